"""Bodies: the links of a robot that are fixed to each other, where each link is in its body, and how bodies move.

A body is named after its topmost link. Which link of a body is attached to which is a matter of how a file is written.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping
from dataclasses import replace
from functools import cached_property
from typing import NamedTuple

from rosorin_compile.model import Joint, Robot, Vector
from rosorin_compile.model.geometry import angle_between, dot, minus, norm, unit

from .precision import HERE, ROOT_THREE, TURNS, Placed, Precision, join_errors


class Line(NamedTuple):
    """The axis of a joint: its direction and a point of it (m), and how well both are known."""

    direction: Vector
    point: Vector
    angle: float
    length: float


class Bodies:
    """The bodies of a robot; ``split`` are fixed joints that separate bodies, because they move in another robot."""

    def __init__(self, robot: Robot, precision: Precision, split: frozenset[str] = frozenset()) -> None:
        self.robot = robot
        self.precision = precision
        self.top: dict[str, str] = {}
        self.members: dict[str, list[str]] = {}
        self._places: dict[tuple[str, str], Placed] = {}
        for link in robot.walk():
            joint = robot.joint_to.get(link.name)
            is_top = joint is None or not joint.is_fixed or joint.name in split
            self.top[link.name] = link.name if joint is None or is_top else self.top[joint.parent]
            self.members.setdefault(self.top[link.name], []).append(link.name)

    @cached_property
    def order(self) -> Mapping[str, int]:
        """The place of each link in the tree, parents first."""
        return {link.name: index for index, link in enumerate(self.robot.walk())}

    @cached_property
    def without_followers(self) -> Robot:
        """The robot with every joint free to move on its own."""
        return replace(self.robot, joints=tuple(replace(joint, mimic=None) for joint in self.robot.joints))

    def edge(self, joint: Joint) -> Placed:
        """Return the child of a joint in its parent, the joint at zero."""
        length = ROOT_THREE * self.precision("xyz", *joint.origin.xyz)
        return Placed(joint.origin.transform(), length, TURNS * self.precision("rpy", *joint.origin.rpy))

    def parent_of(self, top: str) -> str | None:
        """Return the body that a body moves against."""
        joint = self.robot.joint_to.get(top)
        return self.top[joint.parent] if joint else None

    def joints_between(self, upper: str, lower: str) -> list[Joint] | None:
        """Return the joints from a body down to another one; None if that is not below it."""
        found: list[Joint] = []
        while lower != upper:
            joint = self.robot.joint_to.get(lower)
            if joint is None:
                return None
            found.append(joint)
            lower = self.top[joint.parent]
        return found[::-1]

    def relative(self, source: str, target: str) -> Placed:
        """Return the pose of a link in another one of the same body, or of one above; all joints at zero."""
        here, found = source, HERE
        for joint in self.joints_between(self.top[source], self.top[target]) or []:
            found = found.then(self._within(here, joint.parent))
            found = found.then(self.edge(joint))
            here = joint.child
        return found.then(self._within(here, target))

    def _within(self, source: str, target: str) -> Placed:
        """Return the pose of a link in one of the same body, by way of the last link that both are attached to."""
        found = self._places.get((source, target))
        if found is None:
            up, down = self._way(source), self._way(target)
            while up and down and up[-1] is down[-1]:
                up.pop()
                down.pop()
            found = HERE
            for joint in up:
                found = found.then(self.edge(joint).inverse())
            for joint in reversed(down):
                found = found.then(self.edge(joint))
            self._places[source, target] = found
        return found

    def _way(self, link: str) -> list[Joint]:
        found = []
        while link != self.top[link]:
            found.append(self.robot.joint_to[link])
            link = found[-1].parent
        return found

    def line(self, joint: Joint, target: str) -> Line:
        """Return the axis of a joint in the frame of a link that it moves."""
        place = self.relative(joint.child, target).inverse()
        axis = place.transform.rotate(unit(joint.axis))
        tilt = 2 * ROOT_THREE * self.precision("axis", *joint.axis) / norm(joint.axis)
        return Line(axis, place.transform.xyz, place.angle + tilt, place.length)


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
        tolerance + join_errors(one.length, other.length),
        tolerance + join_errors(one.angle, other.angle),
    )


def has_axis(joint: Joint) -> bool:
    """Return True if a joint turns or slides along an axis."""
    return joint.moves and bool(norm(joint.axis))


def axis_turn(old: Line, new: Line, tolerance: float) -> float:
    """Return by how much an axis turned (rad); 0 if by no more than the axes are known."""
    angle = angle_between(old.direction, new.direction)
    return angle if angle > tolerance + join_errors(old.angle, new.angle) else 0.0


def axis_shift(old: Line, new: Line, tolerance: float) -> float:
    """Return how far an axis moved sideways (m); 0 if by no more than the axes are known."""
    way = minus(new.point, old.point)
    along = dot(way, old.direction)
    x, y, z = old.direction
    distance = norm(minus(way, (x * along, y * along, z * along)))
    return distance if distance > tolerance + join_errors(old.length, new.length) else 0.0


def motion_of(joint: Joint) -> str:
    """Return how a joint moves; a joint that turns does so with limits and without."""
    return "turns" if joint.type in ("revolute", "continuous") else joint.type


def same_motion(
    a: Bodies, b: Bodies, source: str, target: str, tolerance: float, flipped: Collection[str] = ()
) -> bool:
    """Return True if a link has the same place in another one above it in two robots, wherever the joints are.

    A product of exponentials (R. Brockett): the place with all joints at zero and the axes of the joints between, seen
    from the link, say all. ``flipped`` are joints that count the other way round.
    """
    ways = [side.joints_between(side.top[source], side.top[target]) for side in (a, b)]
    if ways[0] is None or ways[1] is None or list(map(motion_of, ways[0])) != list(map(motion_of, ways[1])):
        return False
    if not gap(a.relative(source, target), b.relative(source, target), tolerance).closed:
        return False
    for joint, twin in zip(*ways, strict=True):
        if has_axis(joint) and has_axis(twin):
            old, new = a.line(joint, target), b.line(twin, target)
            if twin.name in flipped:
                x, y, z = new.direction
                new = new._replace(direction=(-x, -y, -z))
            if axis_turn(old, new, tolerance) or (joint.type != "prismatic" and axis_shift(old, new, tolerance)):
                return False
    return True


_STEPS = 16
_TURN, _SLIDE = math.pi, 0.5  # how far joints without limits are moved (rad, m)


def positions_of(*joints: Joint) -> list[float]:
    """Return positions (rad or m) of a joint, zero first, then from one limit to the other; of the first with some."""
    reach = _SLIDE if joints[0].type == "prismatic" else _TURN
    lower, upper = -reach, reach
    for joint in reversed(joints):
        limit = joint.limit if joint.type != "continuous" else None
        if limit is not None and limit.lower is not None and limit.upper is not None and limit.lower < limit.upper:
            lower, upper = max(limit.lower, -2 * reach), min(limit.upper, 2 * reach)
    steps = [lower + (upper - lower) * index / _STEPS for index in range(_STEPS + 1)]
    return [0.0, *(position for position in steps if abs(position) > 1e-6)]
