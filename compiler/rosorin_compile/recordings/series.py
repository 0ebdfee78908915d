"""Series: everything that is kept of the transforms of one edge on one topic, in statistics of fixed size.

``Still`` and ``Moving`` are what an edge should be: one transform, or one for each time (``reference``).
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from rosorin_compile.model import Joint, Transform

from .arrays import (
    NO_SAMPLES,
    Flags,
    Floats,
    Samples,
    Times,
    about,
    angles_between,
    are_rotations,
    arrays_of,
    inverse,
    normalised,
    product,
    turned,
)
from .expected import EXACT, SIX_ANGLE, Description, Expected
from .joints import JointLog
from .pace import Leaps, Pace

MAX_VALUES = 4
MAX_WAITING = 20_000


@dataclass
class Seen:
    """One of the values of an edge that stands still: how often it came, first and last (ns)."""

    sample: Samples
    count: int
    first: int
    last: int


class Wrong(NamedTuple):
    """A sample that is not as described, and what it should have been: xyz (3,) in metres, quaternion (4,)."""

    sample: Samples
    xyz: Floats
    quaternion: Floats


@dataclass
class Values:
    """How the values of an edge compare with the description, and with each other."""

    compared: int = 0
    by_state: int = 0  # of them with the joint state of the same stamp
    wrong: int = 0
    farthest: tuple[float, float] = (0.0, 0.0)  # metres and radians
    first_wrong: Wrong | None = None
    seen: list[Seen] = field(default_factory=list)
    others: int = 0  # samples that are none of ``seen``
    switches: int = 0  # changes from one value to another
    bad: int = 0
    first_bad: int = 0


class Series:
    """One edge on one topic. ``still`` says that the topic is /tf_static."""

    def __init__(self, parent: str, child: str, still: bool, edge: Expected | None, description: Description) -> None:
        self.parent, self.child, self.still, self.edge = parent, child, still, edge
        right = edge is not None and edge.parent == parent
        self.reference = reference(edge) if right else None
        self.pace = Pace()
        self.values = Values()
        self.constant = still or (edge is not None and not edge.moving)
        self.leaps = Leaps(_apart)
        self.owner = description.owners(child)
        self._waiting = NO_SAMPLES
        self._last_value = -1
        self._waited = 0
        self.known: Times = np.empty((2, 0), np.int64)  # of this batch: received, and the newest stamp by then
        self.known_before: int | None = None

    @property
    def name(self) -> str:
        """The edge in words."""
        return f"{self.parent} -> {self.child}"

    @property
    def topic(self) -> str:
        """The topic it came on."""
        return "/tf_static" if self.still else "/tf"

    def begin_batch(self) -> None:
        """Forget the times of the batch before, but for the newest stamp."""
        if self.known.shape[1]:
            self.known_before = int(self.known[1, -1])
            self.known = self.known[:, :0]

    def add(self, samples: Samples, start: int) -> None:
        """Take the samples of one batch; ``start`` (ns) is the begin of the recording."""
        self.pace.add(samples.received, samples.stamp, start)
        newest = np.maximum.accumulate(samples.stamp)
        if self.known_before is not None:
            newest = np.maximum(newest, self.known_before)
        self.known = np.stack((samples.received, newest))
        good = are_rotations(samples.quaternion, samples.xyz)
        if not good.all():
            if not self.values.bad:
                self.values.first_bad = int(samples.received[~good][0])
            self.values.bad += int(np.count_nonzero(~good))
            samples = samples.where(good)
        if not len(samples.stamp):
            return
        if self.constant:
            self._classify(samples)
        else:
            self.leaps.add(samples.stamp, np.concatenate((samples.xyz, samples.quaternion), axis=1))
        if isinstance(self.reference, Still):
            self._judge(samples, self.reference.deviation(samples), len(samples.stamp))
        elif isinstance(self.reference, Moving):
            self._waiting = samples.after(self._waiting)

    def compare(self, log: JointLog, last: bool) -> None:
        """Compare waiting samples with the joint states; what finds none waits for one more batch, if there is one."""
        if not len(self._waiting.stamp) or not isinstance(self.reference, Moving):
            return
        deviation, known = self.reference.deviation(self._waiting, log)
        if last or len(self._waiting.stamp) > MAX_WAITING:
            now = np.ones(len(known), bool)
        else:  # what waited once already is at the front
            now = known | (np.arange(len(known)) < self._waited)
        samples = self._waiting.where(now)
        if len(samples.stamp):
            chosen = Deviation(deviation.metres[now], deviation.radians[now], self.reference.edge)
            self._judge(samples, chosen, int(np.count_nonzero(known)), log)
        self._waiting = self._waiting.where(~now)
        self._waited = len(self._waiting.stamp)

    def _judge(self, samples: Samples, deviation: Deviation, by_state: int, log: JointLog | None = None) -> None:
        values = self.values
        values.compared += len(samples.stamp)
        values.by_state += by_state
        wrong = deviation.wrong
        count = int(np.count_nonzero(wrong))
        if not count:
            return
        values.wrong += count
        worst = (float(deviation.metres.max()), float(deviation.radians.max()))
        values.farthest = (max(values.farthest[0], worst[0]), max(values.farthest[1], worst[1]))
        if values.first_wrong is None:
            first = samples.where(wrong).where(slice(0, 1))
            values.first_wrong = Wrong(first, *self._expected(first, log))

    def _expected(self, sample: Samples, log: JointLog | None) -> tuple[Floats, Floats]:
        if isinstance(self.reference, Moving) and log is not None:
            here, known = log.position(self.reference.joint, sample.stamp, sample.received)
            xyz, turn = self.reference.at(np.where(known, here, self.reference.positions_of(sample)))
            return xyz[0], turn[0]
        still = self.reference
        return (still.xyz, still.quaternion) if still is not None else (sample.xyz[0], sample.quaternion[0])

    def _classify(self, samples: Samples) -> None:
        """Sort samples of an edge that stands still into the few values that it has."""
        kinds = np.full(len(samples.stamp), -1)
        turns = normalised(samples.quaternion)
        for at, seen in enumerate(self.values.seen):
            self._assign(kinds, samples, turns, at, seen.sample)
        while (kinds < 0).any() and len(self.values.seen) < MAX_VALUES:
            first = samples.where(slice(int(np.argmax(kinds < 0)), int(np.argmax(kinds < 0)) + 1))
            received = int(first.received[0])
            self.values.seen.append(Seen(first, 0, received, received))
            self._assign(kinds, samples, turns, len(self.values.seen) - 1, first)
        self.values.others += int(np.count_nonzero(kinds < 0))
        row = kinds if self._last_value < 0 else np.concatenate(([self._last_value], kinds))
        self.values.switches += int(np.count_nonzero(np.diff(row)))
        self._last_value = int(kinds[-1])

    def _assign(self, kinds: Times, samples: Samples, turns: Floats, at: int, like: Samples) -> None:
        """Give number ``at`` to the samples without one that are like ``like``."""
        metres = np.abs(samples.xyz - like.xyz).max(axis=1)
        same: Flags = (kinds < 0) & (metres <= EXACT)
        same &= angles_between(turns, normalised(like.quaternion)[0]) <= SIX_ANGLE
        kinds[same] = at
        if same.any():
            seen = self.values.seen[at]
            seen.count += int(np.count_nonzero(same))
            seen.last = int(samples.received[same][-1])


def _apart(one: Floats, other: Floats) -> Floats:
    """Return how far transforms (n, 7), position and quaternion, are apart: m, or rad where that is more."""
    metres = np.abs(one[:, :3] - other[:, :3]).max(axis=1)
    turn = np.abs(one[:, 3:] - other[:, 3:]).max(axis=1)
    turned = np.minimum(turn, np.abs(one[:, 3:] + other[:, 3:]).max(axis=1))  # q and -q are one rotation
    return np.asarray(np.maximum(metres, 2.0 * turned), np.float64)


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

    def __init__(self, edge: Expected, origin: Transform, joint: Joint) -> None:
        self.edge = edge
        self.xyz, self.quaternion = arrays_of(origin)
        axis = np.array(joint.axis, np.float64)
        self.axis: Floats = axis / np.linalg.norm(axis)
        self.slides = joint.type == "prismatic"
        self.joint = joint

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
        positions, known = log.position(self.joint, samples.stamp, samples.received)
        if not known.all():
            positions = np.where(known, positions, self.positions_of(samples))
        xyz, quaternion = self.at(positions)
        metres = np.linalg.norm(samples.xyz - xyz, axis=1)
        return Deviation(metres, angles_between(normalised(samples.quaternion), quaternion), self.edge), known


def reference(edge: Expected | None) -> Still | Moving | None:
    """Return what an edge is compared with; None where only its publisher knows."""
    if edge is None or edge.transform is None:
        return None
    if edge.moving:
        return Moving(edge, edge.transform, edge.joint) if edge.joint is not None and edge.joint.moves else None
    return Still(edge, edge.transform)


def unlike(edge: Expected, samples: Samples) -> float:
    """Return how unlike the first of some samples is to an edge: 0 if it fits, 1 if the edge has no value, or more."""
    made = reference(edge)
    if not isinstance(made, Still) or not len(samples.stamp):
        return 1.0
    deviation = made.deviation(samples.where(slice(0, 1)))
    return 2.0 + float(deviation.metres[0]) + float(deviation.radians[0]) if deviation.wrong[0] else 0.0
