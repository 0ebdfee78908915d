"""Joints: what /joint_states said, kept as long as transforms may ask for it."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from rosorin_compile.model import Joint

from .arrays import Flags, Floats, Times
from .expected import Description
from .pace import Leaps, Pace

# Joint states that are remembered: five minutes at 100 Hz, and more than a batch of messages. A transform comes
# milliseconds after its joint state.
REMEMBERED = 32_768
MAX_PUBLISHERS = 16
MAX_NAMES = 1000
BEYOND = 1e-6
# A servo that holds its place trembles by some steps (rad, or m).
TREMBLING = 0.02
# How far a finger that slides may be off (m).
SLIDING = 1e-3


class _Ring:
    """The latest joint states that name the same joints in the same order."""

    def __init__(self, names: tuple[str, ...]) -> None:
        self.names = names
        self.stamps: Times = np.empty(0, np.int64)
        self.received: Times = np.empty(0, np.int64)
        self.positions: Floats = np.empty((0, len(names)))
        self._order: Times | None = None

    def add(self, received: Times, stamps: Times, positions: Floats) -> None:
        self.received = np.concatenate((self.received, received))[-REMEMBERED:]
        self.stamps = np.concatenate((self.stamps, stamps))[-REMEMBERED:]
        self.positions = np.concatenate((self.positions, positions))[-REMEMBERED:]
        self._order = None

    def at(self, joint: str, stamps: Times, received: Times) -> tuple[Floats, Flags]:
        """Return the positions (n,) of a joint at exactly these stamps (n,), and where there are any; zero is no stamp.

        Of several with one stamp, as after a clock was set back, the one that was received at nearly the same time.
        """
        if self._order is None:
            self._order = np.lexsort((self.received, self.stamps))
        known = self.stamps[self._order]
        first = np.minimum(np.searchsorted(known, stamps, side="left"), len(known) - 1)
        last = np.maximum(np.searchsorted(known, stamps, side="right") - 1, 0)
        there = (known[first] == stamps) & (stamps != 0)
        one, other = self._order[first], self._order[last]
        later = np.abs(self.received[other] - received) < np.abs(self.received[one] - received)
        column = self.positions[np.where(later, other, one), self.names.index(joint)]
        return column, there & np.isfinite(column)


class Range:
    """The positions that a joint was seen in (rad or m), and how often they were beyond its limits or no numbers."""

    def __init__(self) -> None:
        self.lowest, self.highest = np.inf, -np.inf
        self.seen = self.beyond = self.not_numbers = 0


class Follower:
    """How often a joint that mimics another one was reported, was elsewhere than the other one says, and how far."""

    def __init__(self) -> None:
        self.seen = self.off = 0
        self.farthest = 0.0


class JointLog:
    """All joint states of a recording."""

    def __init__(self, description: Description) -> None:
        self.description = description
        self.pace = Pace()
        self.ranges: dict[str, Range] = {}
        self.leaps = Leaps(leap=TREMBLING)
        self.too_short = 0  # messages with fewer positions than names; those without any speak of speeds or efforts
        self.followers: dict[str, Follower] = {}
        self.names_first: tuple[str, ...] = ()
        self._rings: dict[tuple[str, ...], _Ring] = {}

    def add(self, names: tuple[str, ...], received: Times, stamps: Times, positions: Floats) -> None:
        """Take joint states that name the same joints; ``positions`` (n, number of names) in rad or m."""
        if not positions.shape[1]:
            return
        if positions.shape[1] < len(names):
            self.too_short += len(stamps)
            names = names[: positions.shape[1]]
        for column, name in enumerate(names):
            self._range(name, positions[:, column])
        self._follow(names, positions)
        if names == (self.names_first or names) and names:
            self.names_first = names
            self.leaps.add(stamps, positions[:, : len(names)])
        if names in self._rings or len(self._rings) < MAX_PUBLISHERS:
            self._rings.setdefault(names, _Ring(names)).add(received, stamps, positions[:, : len(names)])

    def _range(self, name: str, values: Floats) -> None:
        if name not in self.ranges and len(self.ranges) >= MAX_NAMES:
            return
        reach = self.ranges.setdefault(name, Range())
        good = values[np.isfinite(values)]
        reach.seen += len(values)
        reach.not_numbers += len(values) - len(good)
        if not len(good):
            return
        reach.lowest = min(reach.lowest, float(good.min()))
        reach.highest = max(reach.highest, float(good.max()))
        lower, upper = self.limits(name)
        reach.beyond += int(np.count_nonzero((good < lower - BEYOND) | (good > upper + BEYOND)))

    def limits(self, name: str) -> tuple[float, float]:
        """Return the limits of a joint (rad or m), infinite where there are none."""
        joint = self.description.robot.joint.get(name)
        if joint is None or joint.limit is None or joint.type == "continuous":
            return -np.inf, np.inf
        lower, upper = joint.limit.lower, joint.limit.upper
        return (-np.inf if lower is None else lower), (np.inf if upper is None else upper)

    def at(self, joint: str, stamps: Times, received: Times) -> tuple[Floats, Flags]:
        """Return the positions (n,) of a joint at stamps (n,) of transforms received then, and where there are any."""
        positions, known = np.zeros(len(stamps)), np.zeros(len(stamps), bool)
        for names, ring in self._rings.items():
            if joint in names:
                values, there = ring.at(joint, stamps, received)
                positions, known = np.where(there, values, positions), known | there
        return positions, known

    def position(self, joint: Joint, stamps: Times, received: Times) -> tuple[Floats, Flags]:
        """Return the positions (n,) that robot_state_publisher took for a joint, and where there are any.

        What a driver reports of a follower goes before what its leader says
        (``ros/robot_state_publisher@{humble,jazzy}: callbackJointState`` inserts the latter where nothing is yet).
        """
        positions, known = self.at(joint.name, stamps, received)
        if joint.mimic is None or known.all():
            return positions, known
        leader, there = self.position(self.description.robot.joint[joint.mimic.joint], stamps, received)
        followed = joint.mimic.multiplier * leader + joint.mimic.offset
        return np.where(known, positions, followed), known | there

    def _follow(self, names: tuple[str, ...], positions: Floats) -> None:
        """Note how far the followers that a message reports are from what their leaders in it say."""
        columns = {name: positions[:, column] for column, name in enumerate(names)}
        for name in names:
            joint = self.description.robot.joint.get(name)
            if joint is None or joint.mimic is None or joint.mimic.joint not in columns:
                continue
            leader = self.description.robot.joint[joint.mimic.joint]
            apart = columns[name] - joint.mimic.multiplier * columns[leader.name] - joint.mimic.offset
            apart = np.abs(apart[np.isfinite(apart)])
            if leader.type == "continuous" and not float(joint.mimic.multiplier).is_integer():
                continue  # how often the leader has gone round is not said
            if "continuous" in (joint.type, leader.type) and joint.type != "prismatic":
                apart = np.abs(np.remainder(apart + np.pi, 2 * np.pi) - np.pi)
            follower = self.followers.setdefault(name, Follower())
            follower.seen += len(apart)
            follower.off += int(np.count_nonzero(apart > (SLIDING if joint.type == "prismatic" else TREMBLING)))
            follower.farthest = max(follower.farthest, float(apart.max(initial=0.0)))

    @property
    def names(self) -> Sequence[str]:
        """The joints that were named, in the order of their appearance."""
        return list(self.ranges)
