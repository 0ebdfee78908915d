"""Bodies: the links of a robot that are fixed to each other, and where each link sits in its body.

A body is named after its topmost link. What moves against what is a matter of bodies; which link of a body hangs on
which other one is a matter of writing.

Then, the states of the joints at which two robots are compared: the same ones in every run.
"""

from __future__ import annotations

import math
import random
from collections.abc import Iterable, Mapping, Sequence
from functools import cached_property
from typing import Any, NamedTuple

from rosorin_compile.model import Joint, Robot
from rosorin_compile.model.geometry import norm
from rosorin_compile.model.joint import motion

from .precision import HERE, ROOT_THREE, TURNS, Placed, Printing, joined

Positions = Mapping[str, float]


class Bodies:
    """The bodies of a robot; ``split`` are fixed joints that separate bodies all the same, because they move in B."""

    def __init__(self, robot: Robot, printing: Printing, split: frozenset[str] = frozenset()) -> None:
        self.robot = robot
        self.printing = printing
        self.top: dict[str, str] = {}
        self._known: dict[tuple[str, str], Placed] = {}
        self.members: dict[str, list[str]] = {}
        for link in robot.walk():
            joint = robot.joint_to.get(link.name)
            moves = joint is None or not joint.is_fixed or joint.name in split
            self.top[link.name] = link.name if joint is None or moves else self.top[joint.parent]
            self.members.setdefault(self.top[link.name], []).append(link.name)

    @cached_property
    def order(self) -> Mapping[str, int]:
        """The place of each link in the tree, parents first."""
        return {link.name: index for index, link in enumerate(self.robot.walk())}

    def edge(self, joint: Joint, position: float) -> Placed:
        """Return the child of a joint in its parent at a position (rad or m)."""
        tolerance = self.printing.tolerance
        origin = Placed(
            joint.origin.transform(),
            ROOT_THREE * tolerance("xyz", *joint.origin.xyz),
            TURNS * tolerance("rpy", *joint.origin.rpy),
        )
        if not position or not joint.moves:
            return origin
        tilt = ROOT_THREE * tolerance("axis", *joint.axis) / (norm(joint.axis) or 1.0)
        slides = joint.type == "prismatic"
        way = motion(joint.type, joint.axis, position)
        return origin.then(Placed(way, tilt * abs(position) if slides else 0.0, 0.0 if slides else 2 * tilt))

    def entering(self, top: str) -> Joint | None:
        """Return the joint that moves a body; None for the root's."""
        return self.robot.joint_to.get(top)

    def above(self, top: str) -> str | None:
        """Return the body that a body moves against."""
        joint = self.entering(top)
        return self.top[joint.parent] if joint else None

    def joints_between(self, upper: str, lower: str) -> list[Joint] | None:
        """Return the joints from a body down to another one; None if that is not below it."""
        found: list[Joint] = []
        top: str | None = lower
        while top != upper:
            joint = self.entering(top) if top is not None else None
            if joint is None:
                return None
            found.append(joint)
            top = self.top[joint.parent]
        return found[::-1]

    def relative(self, source: str, target: str, positions: Positions) -> Placed:
        """Return where a link sits in another one of the same body, or of one above."""
        joints = self.joints_between(self.top[source], self.top[target]) or []
        here, found = source, HERE
        for joint in joints:
            found = found.then(self._within(here, joint.parent))
            found = found.then(self.edge(joint, positions.get(joint.name, 0.0)))
            here = joint.child
        return found.then(self._within(here, target))

    def _within(self, source: str, target: str) -> Placed:
        """Return where a link sits in another one of the same body, by way of the last link that both hang on."""
        known = self._known.get((source, target))
        if known is None:
            up, down = self._way(source), self._way(target)
            while up and down and up[-1] is down[-1]:
                up.pop()
                down.pop()
            known = HERE
            for joint in up:
                known = known.then(self.edge(joint, 0.0).inverse())
            for joint in reversed(down):
                known = known.then(self.edge(joint, 0.0))
            self._known[source, target] = known
        return known

    def _way(self, link: str) -> list[Joint]:
        """Return the joints from a link up to the top of its body."""
        found = []
        while link != self.top[link]:
            found.append(self.robot.joint_to[link])
            link = found[-1].parent
        return found


class Gap(NamedTuple):
    """How far two places are apart (m, rad), and how far they may be as well as they are known."""

    distance: float
    angle: float
    length_tolerance: float
    angle_tolerance: float

    @property
    def closed(self) -> bool:
        """Whether the two places are the same."""
        return self.distance <= self.length_tolerance and self.angle <= self.angle_tolerance


def gap(one: Placed, other: Placed, tolerance: float) -> Gap:
    """Return how far two places are apart; ``tolerance`` (m, rad) is no distance."""
    return Gap(
        math.dist(one.transform.xyz, other.transform.xyz),
        one.transform.angle_to(other.transform),
        tolerance + joined(one.length, other.length),
        tolerance + joined(one.angle, other.angle),
    )


_SEED = 5
_RANDOM = 48
_STEPS = 16
# Of more joints than these each one alone is too much.
_FEW = 40
# How far joints without limits are moved (rad, m).
_TURN, _SLIDE = math.pi, 0.5


def span_of(*joints: Joint | None) -> tuple[float, float]:
    """Return between which positions (rad or m) a joint is moved; the first of the joints with limits says."""
    reach = _SLIDE if any(joint is not None and joint.type == "prismatic" for joint in joints) else _TURN
    for joint in joints:
        limit = joint.limit if joint is not None and joint.type != "continuous" else None
        if limit is not None and limit.lower is not None and limit.upper is not None and limit.lower < limit.upper:
            return max(limit.lower, -2 * reach), min(limit.upper, 2 * reach)
    return -reach, reach


def positions_of(*joints: Joint | None) -> list[float]:
    """Return positions (rad or m) of a joint, zero first, then from one limit to the other."""
    lower, upper = span_of(*joints)
    steps = [lower + (upper - lower) * index / _STEPS for index in range(_STEPS + 1)]
    return [0.0, *(position for position in steps if abs(position) > 1e-6)]


def states_of(joints: Sequence[tuple[Joint, Joint | None]]) -> list[dict[str, float]]:
    """Return states of a few joints: zero, each at its limits alone, and some of all together."""
    found: list[dict[str, float]] = [{}]
    for joint, twin in joints:
        found += [{joint.name: position} for position in span_of(joint, twin) if position]
    return found + random_states(_spans(joints), 6 if len(joints) > 1 else 1, _SEED)


def random_states(joints: Iterable[tuple[Joint, float, float]], count: int, seed: int) -> list[dict[str, Any]]:
    """Return states of joints, the same for a seed: each number (rad or m) between the two beside its joint.

    A joint has as many numbers as it has ``coordinates``; those of an orientation are not normalised.
    """
    chance = random.Random(seed)  # noqa: S311 - the same states in every run
    drawn = list(joints)
    return [
        {joint.name: _random_position(joint, low, high, chance) for joint, low, high in drawn} for _ in range(count)
    ]


def _random_position(joint: Joint, low: float, high: float, chance: random.Random) -> float | Sequence[float]:
    numbers = [chance.uniform(low, high) for _ in joint.coordinates]
    return numbers if len(numbers) > 1 else sum(numbers)


def _spans(joints: Sequence[tuple[Joint, Joint | None]]) -> list[tuple[Joint, float, float]]:
    return [(joint, *span_of(joint, twin)) for joint, twin in joints]


def whole_states(robot: Robot, twin: Robot) -> list[dict[str, float]]:
    """Return states of a whole robot: zero, its poses, random ones, and of few joints each at its limits alone."""
    free = [joint for joint in robot.joints if joint.moves and joint.mimic is None]
    pairs = [(joint, twin.joint.get(joint.name)) for joint in free]
    found = states_of(pairs) if len(pairs) <= _FEW else [{}]
    found += [{name: value for name, value in pose.positions.items() if value} for pose in robot.poses]
    return found + random_states(_spans(pairs), _RANDOM, _SEED)
