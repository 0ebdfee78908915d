"""The joint states of a recording: ranges, followers, and the positions at the stamps of transforms."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

from rosorin_compile.model import Joint, Robot

from .timing import Flags, Floats, Leaps, Pace, Times

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
    """All messages of /joint_states; ``groups`` has them by the names of the joints, in order of arrival."""

    def __init__(self, robot: Robot, groups: Mapping[tuple[str, ...], States], pace: Pace) -> None:
        self.robot, self.pace = robot, pace
        self.too_short = sum(len(g.stamps) for names, g in groups.items() if 0 < g.positions.shape[1] < len(names))
        self.groups: dict[tuple[str, ...], States] = {}
        for names, group in groups.items():
            width = min(len(names), group.positions.shape[1])
            if width:  # others report only velocities or efforts
                self.groups[names[:width]] = group._replace(positions=group.positions[:, :width])
        self.leaps = Leaps(np.empty(0, np.int64), np.empty((0, 0)))
        if self.groups:
            first = next(iter(self.groups.values()))
            self.leaps = Leaps(first.stamps, first.positions, leap=TREMBLING)
        self.ranges = {name: self._range(name) for name in dict.fromkeys(n for names in self.groups for n in names)}
        self.followers = {name: self._follower(name) for name in self.ranges if self._is_comparable_follower(name)}
        self._orders: dict[tuple[str, ...], Times] = {}

    def limits(self, name: str) -> tuple[float, float]:
        """Return the limits of a joint (rad or m), infinite where there are none."""
        joint = self.robot.joint.get(name)
        if joint is None or joint.limit is None or joint.type == "continuous":
            return -np.inf, np.inf
        lower, upper = joint.limit.lower, joint.limit.upper
        return (-np.inf if lower is None else lower), (np.inf if upper is None else upper)

    def position(self, joint: Joint, stamps: Times, received: Times) -> tuple[Floats, Flags]:
        """Return the positions (n,) that robot_state_publisher used for a joint at stamps (n,), and which are known.

        A reported position of a follower takes precedence over that of its leader
        (``callbackJointState`` of robot_state_publisher).
        """
        positions, known = np.zeros(len(stamps)), np.zeros(len(stamps), bool)
        for names, group in self.groups.items():
            if joint.name in names:
                values, there = self._at(names, group, joint.name, stamps, received)
                positions, known = np.where(there, values, positions), known | there
        if joint.mimic is None or known.all():
            return positions, known
        leader, there = self.position(self.robot.joint[joint.mimic.joint], stamps, received)
        return np.where(known, positions, joint.mimic.multiplier * leader + joint.mimic.offset), known | there

    def _at(
        self, names: tuple[str, ...], group: States, joint: str, stamps: Times, received: Times
    ) -> tuple[Floats, Flags]:
        """Return the positions with exactly these stamps; of equal stamps, take the one received at about that time."""
        if names not in self._orders:
            self._orders[names] = np.lexsort((group.received, group.stamps))
        order = self._orders[names]
        known = group.stamps[order]
        first = np.minimum(np.searchsorted(known, stamps, side="left"), len(known) - 1)
        last = np.maximum(np.searchsorted(known, stamps, side="right") - 1, 0)
        there = (known[first] == stamps) & (stamps != 0)
        one, other = order[first], order[last]
        later = np.abs(group.received[other] - received) < np.abs(group.received[one] - received)
        values = group.positions[np.where(later, other, one), names.index(joint)]
        return values, there & np.isfinite(values)

    def _range(self, name: str) -> Range:
        values = np.concatenate(
            [g.positions[:, names.index(name)] for names, g in self.groups.items() if name in names]
        )
        good = values[np.isfinite(values)]
        lower, upper = self.limits(name)
        beyond = np.count_nonzero((good < lower - _BEYOND) | (good > upper + _BEYOND))
        lowest, highest = float(good.min(initial=np.inf)), float(good.max(initial=-np.inf))
        return Range(lowest, highest, len(values), int(beyond), len(values) - len(good))

    def _is_comparable_follower(self, name: str) -> bool:
        """Return True for a follower that is reported with its leader, unless turns of the leader are ambiguous."""
        joint = self.robot.joint.get(name)
        if joint is None or joint.mimic is None:
            return False
        turns = self.robot.joint[joint.mimic.joint].type == "continuous"
        if turns and not float(joint.mimic.multiplier).is_integer():
            return False
        return any({name, joint.mimic.joint} <= set(names) for names in self.groups)

    def _follower(self, name: str) -> Follower:
        joint = self.robot.joint[name]
        assert joint.mimic is not None  # noqa: S101
        leader, off = joint.mimic.joint, []
        for names, group in self.groups.items():
            if {name, leader} <= set(names):
                followed = joint.mimic.multiplier * group.positions[:, names.index(leader)] + joint.mimic.offset
                off.append(group.positions[:, names.index(name)] - followed)
        apart = np.concatenate(off)
        apart = apart[np.isfinite(apart)]
        if "continuous" in (joint.type, self.robot.joint[leader].type) and joint.type != "prismatic":
            apart = np.remainder(apart + np.pi, 2 * np.pi) - np.pi
        apart = np.abs(apart)
        tolerance = _SLIDING if joint.type == "prismatic" else TREMBLING
        return Follower(len(apart), int(np.count_nonzero(apart > tolerance)), float(apart.max(initial=0.0)))
