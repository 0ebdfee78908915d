"""References: what the transform of an edge should be at a time, for many times at once."""

from __future__ import annotations

import numpy as np

from ...model import Joint, Transform
from ..arrays import Flags, Floats, Samples, about, angles_between, arrays_of, inverse, normalised, product, turned
from ..expected import Description, Expected
from .joints import JointLog


class Deviation:
    """How far samples are from what they should be: metres (n,), radians (n,), and which of them are too far."""

    def __init__(self, metres: Floats, radians: Floats, edge: Expected) -> None:
        self.metres, self.radians = metres, radians
        self.wrong: Flags = (metres > edge.tolerance.metres) | (radians > edge.tolerance.radians)


class Still:
    """The value of an edge that does not move."""

    def __init__(self, edge: Expected, value: Transform) -> None:
        self.edge = edge
        self.xyz, self.quaternion = arrays_of(value)

    def deviation(self, samples: Samples) -> Deviation:
        """Return how far samples are from the described value."""
        metres = np.linalg.norm(samples.xyz - self.xyz, axis=1)
        return Deviation(metres, angles_between(normalised(samples.quaternion), self.quaternion), self.edge)


class Moving:
    """The values of an edge that a joint moves: origin, then the turn or the slide of the position."""

    def __init__(self, edge: Expected, origin: Transform, joint: Joint, description: Description) -> None:
        self.edge = edge
        self.xyz, self.quaternion = arrays_of(origin)
        axis = np.array(joint.axis, np.float64)
        self.axis: Floats = axis / np.linalg.norm(axis)
        self.slides = joint.type == "prismatic"
        self.leader, self.factor, self.offset = description.leader(joint)

    def at(self, positions: Floats) -> tuple[Floats, Floats]:
        """Return the transforms, xyz (n, 3) and quaternions (n, 4), at positions (n,) of this joint in rad or m."""
        if self.slides:
            along = turned(self.quaternion, self.axis)
            return self.xyz + positions[:, None] * along, np.tile(self.quaternion, (len(positions), 1))
        return np.tile(self.xyz, (len(positions), 1)), product(self.quaternion, about(self.axis, positions))

    def positions_of(self, samples: Samples) -> Floats:
        """Return the positions (n,) at which this joint comes nearest to the samples."""
        if self.slides:
            return np.asarray((samples.xyz - self.xyz) @ turned(self.quaternion, self.axis), np.float64)
        turn = product(inverse(self.quaternion), normalised(samples.quaternion))
        return np.asarray(2.0 * np.arctan2(turn[:, :3] @ self.axis, turn[:, 3]), np.float64)

    def deviation(self, samples: Samples, log: JointLog) -> tuple[Deviation, Flags]:
        """Return how far samples are from the described value at the joint states of the same stamps.

        The second result says which samples have such a joint state. The others are compared with the position at which
        the joint comes nearest: a transform that no position gives is wrong whatever the joint states were.
        """
        leader, known = log.at(self.leader, samples.stamp, samples.received)
        positions = np.where(known, self.factor * leader + self.offset, 0.0)
        if not known.all():
            positions = np.where(known, positions, self.positions_of(samples))
        xyz, quaternion = self.at(positions)
        metres = np.linalg.norm(samples.xyz - xyz, axis=1)
        return Deviation(metres, angles_between(normalised(samples.quaternion), quaternion), self.edge), known


def reference(edge: Expected | None, description: Description) -> Still | Moving | None:
    """Return what an edge is compared with; None where only its publisher knows."""
    if edge is None or edge.transform is None:
        return None
    if edge.moving:
        return (
            Moving(edge, edge.transform, edge.joint, description)
            if edge.joint is not None and edge.joint.moves
            else None
        )
    return Still(edge, edge.transform)
