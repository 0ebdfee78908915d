"""Joint states, and the transforms of one edge on one topic, compared with the description.

Quaternions are (x, y, z, w) as in ROS.
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np

from rosorin_compile.model import Joint, Robot, Transform

from .expected import EXACT, SIX_ANGLE, Expected
from .timing import Flags, Floats, Leaps, Pace, Times

# tf2 drops transforms whose squared quaternion deviates more from 1 (tf2/src/buffer_core.cpp).
_NORM_TOLERANCE = 10e-3
_MAX_VALUES = 4
TREMBLING = 0.02  # a servo that holds its position moves by up to this (rad or m)
_SLIDING = 1e-3  # tolerance of the position of a sliding follower (m)
_BEYOND = 1e-6


class States(NamedTuple):
    """Joint states that name the same joints: times in ns (n,), positions (n, number of names) in rad or m."""

    received: Times
    stamps: Times
    positions: Floats


class Range(NamedTuple):
    """The positions of a joint: lowest and highest, and how many were reported, beyond limits, and not numbers."""

    lowest: float
    highest: float
    seen: int
    beyond: int
    not_numbers: int


class Follower(NamedTuple):
    """How often a follower was reported, how often not where its leader puts it, and by how much at most."""

    seen: int
    off: int
    farthest: float


class JointStates:
    """All messages of /joint_states; ``groups`` has them by the names of the joints, in order of arrival.

    ``ranges`` and ``followers`` have what was reported of each joint, and of those that follow another one.
    """

    def __init__(self, robot: Robot, groups: Mapping[tuple[str, ...], States], pace: Pace) -> None:
        self.robot, self.pace, self.too_short = robot, pace, 0
        self.leaps = Leaps(np.empty(0, np.int64), np.empty((0, 0)))
        states: dict[str, list[States]] = {}
        off: dict[str, list[Floats]] = {}
        for names, group in groups.items():
            if 0 < group.positions.shape[1] < len(names):
                self.too_short += len(group.stamps)
            named = dict(zip(names, group.positions.T, strict=False))  # empty if only velocities or efforts came
            if named and not states:
                self.leaps = Leaps(group.stamps, group.positions, leap=TREMBLING)
            for name, positions in named.items():
                states.setdefault(name, []).append(States(group.received, group.stamps, positions))
                mimic = robot.joint[name].mimic if name in robot.joint else None
                if mimic is not None and mimic.joint in named:
                    followed = mimic.multiplier * named[mimic.joint] + mimic.offset
                    off.setdefault(name, []).append(positions - followed)
        self._states: dict[str, States] = {}  # by joint, ordered by stamp
        self.ranges: dict[str, Range] = {}
        for name, several in states.items():
            received, stamps, positions = map(np.concatenate, zip(*several, strict=True))
            order = np.lexsort((received, stamps))
            self._states[name] = States(received[order], stamps[order], positions[order])
            good, (lower, upper) = positions[np.isfinite(positions)], self.limits(name)
            beyond = int(np.count_nonzero((good < lower - _BEYOND) | (good > upper + _BEYOND)))
            lowest, highest = float(good.min(initial=np.inf)), float(good.max(initial=-np.inf))
            self.ranges[name] = Range(lowest, highest, len(positions), beyond, len(positions) - len(good))
        followers = ((robot.joint[name], np.concatenate(several)) for name, several in off.items())
        self.followers = {joint.name: found for joint, apart in followers if (found := self._follower(joint, apart))}

    def limits(self, name: str) -> tuple[float, float]:
        """Return the limits of a joint (rad or m), infinite where there are none."""
        joint = self.robot.joint.get(name)
        if joint is None or joint.limit is None or joint.type == "continuous":
            return -np.inf, np.inf
        lower, upper = joint.limit.lower, joint.limit.upper
        return (-np.inf if lower is None else lower), (np.inf if upper is None else upper)

    def position(self, joint: Joint, stamps: Times, received: Times) -> tuple[Floats, Flags]:
        """Return the positions (n,) that robot_state_publisher used for a joint at stamps (n,), and which are known.

        Of several messages with a stamp it is the one received at about that time. A reported position of a follower
        takes precedence over that of its leader (``callbackJointState`` of robot_state_publisher).
        """
        positions, known = np.zeros(len(stamps)), np.zeros(len(stamps), bool)
        if (states := self._states.get(joint.name)) is not None:
            first = np.minimum(np.searchsorted(states.stamps, stamps, side="left"), len(states.stamps) - 1)
            last = np.maximum(np.searchsorted(states.stamps, stamps, side="right") - 1, 0)
            is_later = np.abs(states.received[last] - received) < np.abs(states.received[first] - received)
            positions = states.positions[np.where(is_later, last, first)]
            known = (states.stamps[first] == stamps) & (stamps != 0) & np.isfinite(positions)
        if joint.mimic is None or known.all():
            return positions, known
        leader, there = self.position(self.robot.joint[joint.mimic.joint], stamps, received)
        return np.where(known, positions, joint.mimic.multiplier * leader + joint.mimic.offset), known | there

    def _follower(self, joint: Joint, apart: Floats) -> Follower | None:
        """Return how far (n,) a follower was from its leader, or None if turns of the leader are ambiguous."""
        turns = joint.mimic is not None and self.robot.joint[joint.mimic.joint].type == "continuous"
        if joint.mimic is None or (turns and not float(joint.mimic.multiplier).is_integer()):
            return None
        slides, apart = joint.type == "prismatic", apart[np.isfinite(apart)]
        if (turns or joint.type == "continuous") and not slides:
            apart = np.remainder(apart + np.pi, 2 * np.pi) - np.pi
        apart = np.abs(apart)
        off = np.count_nonzero(apart > (_SLIDING if slides else TREMBLING))
        return Follower(len(apart), int(off), float(apart.max(initial=0.0)))


class Samples(NamedTuple):
    """Transforms in order of arrival: times in ns (n,), ``xyz`` in m (n, 3) and quaternions (n, 4)."""

    received: Times
    stamps: Times
    xyz: Floats
    quaternions: Floats

    def where(self, chosen: Any) -> Samples:
        """Return some of the samples, by mask, index or slice."""
        return Samples(*(values[chosen] for values in self))

    def transform(self, at: int) -> Transform:
        """Return one of the samples."""
        return transform_from(self.xyz[at], self.quaternions[at])


class Wrong(NamedTuple):
    """The first wrong sample of an edge: its value, the described value and the time of arrival (ns)."""

    recorded: Transform
    described: Transform
    received: int


class Series:
    """One edge on one topic: /tf_static if it is ``static``, otherwise /tf. ``edge`` is the described edge."""

    def __init__(self, parent: str, child: str, static: bool, samples: Samples, pace: Pace) -> None:
        self.parent, self.child, self.static, self.pace = parent, child, static, pace
        self.name, self.topic = f"{parent} -> {child}", "/tf_static" if static else "/tf"
        self.edge: Expected | None = None
        self.owner = self.by_owner = ""  # the node that should publish it, if known, and in brackets
        self.constant, self.comparable = static, False  # whether the description determines its value
        square = np.einsum("ij,ij->i", samples.quaternions, samples.quaternions)
        good = np.isfinite(samples.xyz).all(axis=1) & (np.abs(square - 1.0) <= _NORM_TOLERANCE)  # as tf2 accepts them
        self.bad = int(np.count_nonzero(~good))
        self.first_bad = int(samples.received[~good][0]) if self.bad else 0
        self.samples = samples if not self.bad else samples.where(good)
        self.compared = self.by_state = self.wrong = 0
        self.first_wrong: Wrong | None = None
        self.values: list[tuple[Transform, int]] = []  # of a constant edge, with the number of samples
        self.other_values = self.switches = 0

    @cached_property
    def newest(self) -> Times:
        """The newest stamp (n,) at each arrival."""
        return np.asarray(np.maximum.accumulate(self.pace.stamps), np.int64)

    @cached_property
    def leaps(self) -> Leaps:
        """The leaps of a moving edge."""
        poses = np.concatenate((self.samples.xyz, self.samples.quaternions), axis=1)
        return Leaps(self.samples.stamps[: 0 if self.constant else None], poses, _distance)

    @property
    def has_two_sources(self) -> bool:
        """Return True if two nodes seem to publish different values; an edge that follows its joint may leap."""
        return not self.constant and self.leaps.two and not (self.compared and not self.wrong)

    def compare(self, edge: Expected | None, owner: str, joints: JointStates) -> None:
        """Compare all samples with the described edge."""
        self.edge, self.owner, self.by_owner = edge, owner, f" ({owner})" if owner else ""
        self.constant = self.static or (edge is not None and not edge.moving)
        samples = self.samples
        if self.constant:
            self._find_values()
        if edge is None or edge.transform is None or edge.parent != self.parent:
            return
        self.comparable = not edge.moving or (edge.joint is not None and edge.joint.moves)
        if not self.comparable or not len(samples.stamps):
            return
        xyz, quaternions, by_state = _expected_values(edge, edge.transform, samples, joints)
        metres = np.linalg.norm(samples.xyz - xyz, axis=1)
        radians = _angles(_normalised(samples.quaternions), quaternions)
        wrong = (metres > EXACT) | (radians > edge.radians)
        self.compared, self.by_state = len(wrong), by_state
        self.wrong = int(np.count_nonzero(wrong))
        if self.wrong:
            at = int(wrong.argmax())
            described = transform_from(xyz[at], quaternions[at])
            self.first_wrong = Wrong(samples.transform(at), described, int(samples.received[at]))

    def _find_values(self) -> None:
        """Find the different values of an edge that should be constant."""
        samples, turns = self.samples, _normalised(self.samples.quaternions)
        kinds = np.full(len(turns), -1)
        for number in range(_MAX_VALUES):
            rest = np.flatnonzero(kinds < 0)
            if not len(rest):
                break
            like = int(rest[0])
            same = (kinds < 0) & (np.abs(samples.xyz - samples.xyz[like]).max(axis=1) <= EXACT)
            same &= _angles(turns, turns[like]) <= SIX_ANGLE
            kinds[same] = number
            self.values.append((samples.transform(like), int(np.count_nonzero(same))))
        self.other_values = int(np.count_nonzero(kinds < 0))
        self.switches = int(np.count_nonzero(np.diff(kinds)))


def _expected_values(
    edge: Expected, origin: Transform, samples: Samples, joints: JointStates
) -> tuple[Floats, Floats, int]:
    """Return the described values of samples, xyz (n, 3) and quaternions (n, 4), and how many joint states gave them.

    Without the joint state of its stamp, a sample is compared with the position at which the joint is nearest to it:
    a transform that no position produces is wrong whatever the joint states were.
    """
    count = len(samples.stamps)
    w, x, y, z = origin.quaternion()
    xyz, turn = np.array(origin.xyz, np.float64), np.array((x, y, z, w), np.float64)
    if not edge.moving or edge.joint is None:
        return np.tile(xyz, (count, 1)), np.tile(turn, (count, 1)), 0
    joint = edge.joint
    axis = np.array(joint.axis, np.float64) / np.linalg.norm(joint.axis)
    slides = joint.type == "prismatic"
    positions, known = joints.position(joint, samples.stamps, samples.received)
    along = np.array(origin.rotate(tuple(axis.tolist())), np.float64)
    if not known.all():
        if slides:
            nearest = (samples.xyz - xyz) @ along
        else:
            rest = _product(turn * (-1.0, -1.0, -1.0, 1.0), _normalised(samples.quaternions))
            nearest = 2.0 * np.arctan2(rest[:, :3] @ axis, rest[:, 3])
        positions = np.where(known, positions, nearest)
    by_state = int(np.count_nonzero(known))
    if slides:
        return xyz + positions[:, None] * along, np.tile(turn, (count, 1)), by_state
    half = 0.5 * positions[:, None]
    turns = _product(turn, np.concatenate((np.sin(half) * axis, np.cos(half)), axis=1))
    return np.tile(xyz, (count, 1)), turns, by_state


def transform_from(xyz: Floats, quaternion: Floats) -> Transform:
    """Return a position (3,) and a quaternion (4,) as a transform."""
    px, py, pz = map(float, xyz)
    x, y, z, w = map(float, quaternion)
    return Transform.of_quaternion((px, py, pz), (w, x, y, z))


def _distance(one: Floats, other: Floats) -> Floats:
    """Return the distance (n,) of poses (n, 7): m, or rad where that is more. q and -q are the same rotation."""
    metres = np.abs(one[:, :3] - other[:, :3]).max(axis=1)
    same, opposite = (np.abs(one[:, 3:] + sign * other[:, 3:]).max(axis=1) for sign in (-1, 1))
    return np.asarray(np.maximum(metres, 2.0 * np.minimum(same, opposite)), np.float64)


def _normalised(quaternions: Floats) -> Floats:
    return np.asarray(quaternions / np.linalg.norm(quaternions, axis=1)[:, None], np.float64)


def _product(a: Floats, b: Floats) -> Floats:
    """Return the products (n, 4) of quaternions (n, 4) or (4,)."""
    u, v, s, t = a[..., :3], b[..., :3], a[..., 3:], b[..., 3:]
    real = s * t - (u * v).sum(axis=-1, keepdims=True)
    return np.concatenate((s * v + t * u + np.cross(u, v), real), axis=-1)


def _angles(a: Floats, b: Floats) -> Floats:
    """Return the angles (n,) in rad from 0 to pi between rotations (n, 4) and (n, 4) or (4,)."""
    turn = _product(a * (-1.0, -1.0, -1.0, 1.0), b)
    return np.asarray(2.0 * np.arctan2(np.linalg.norm(turn[..., :3], axis=-1), np.abs(turn[..., 3])), np.float64)
