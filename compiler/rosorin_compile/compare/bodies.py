"""Match links, joints and bodies of two robots, and compare poses within bodies and the motion of bodies.

A body is a set of links that are fixed to each other, named after the topmost link. Files may attach the links of a
body to each other in different ways.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Iterator, Mapping
from dataclasses import replace
from functools import reduce
from typing import NamedTuple

from rosorin_compile.model import Joint, Robot, Vector
from rosorin_compile.model.geometry import angle_between, dot, minus, norm, unit

from .difference import JOINT, NAME, Item, Side
from .names import Names, new_joint_names, new_link_names, prefix_of, renamed_robot, with_names, without_prefix
from .precision import HERE, ROOT_THREE, TURNS, Placed, Precision, join_errors
from .sentences import NEW, REMOVED, existence
from .walk import Leaves, leaves


class Line(NamedTuple):
    """The axis of a joint: its direction and a point on it (m), each with its precision."""

    direction: Vector
    point: Vector
    angle: float
    length: float


class Bodies:
    """The bodies of a robot; ``split`` are fixed joints that separate bodies because they move in the other robot."""

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

    def edge(self, joint: Joint) -> Placed:
        """Return the pose of a joint's child in its parent, at position zero."""
        length = ROOT_THREE * self.precision("xyz", *joint.origin.xyz)
        return Placed(joint.origin.transform(), length, TURNS * self.precision("rpy", *joint.origin.rpy))

    def above(self, top: str) -> Iterator[str]:
        """Yield the ancestors of a body, nearest first."""
        while joint := self.robot.joint_to.get(top):
            yield (top := self.top[joint.parent])

    def joints_between(self, upper: str, lower: str) -> list[Joint] | None:
        """Return the joints from body ``upper`` down to body ``lower``, or None if it is not below."""
        bodies = [lower, *self.above(lower)]
        if upper not in bodies:
            return None
        return [self.robot.joint_to[top] for top in bodies[: bodies.index(upper)]][::-1]

    def relative(self, source: str, target: str) -> Placed:
        """Return the pose of ``target`` in ``source``, a link of the same body or a body above; all joints at zero."""
        here, found = source, HERE
        for joint in self.joints_between(self.top[source], self.top[target]) or []:
            found = found.then(self._within(here, joint.parent)).then(self.edge(joint))
            here = joint.child
        return found.then(self._within(here, target))

    def _within(self, source: str, target: str) -> Placed:
        """Return the pose of ``target`` in ``source``, a link of the same body, through their common ancestor."""
        if (source, target) not in self._places:
            up, down = ways = list[Joint](), list[Joint]()
            for link, way in zip((source, target), ways, strict=True):
                while link != self.top[link]:
                    way.append(self.robot.joint_to[link])
                    link = way[-1].parent
            while up and down and up[-1] is down[-1]:
                up.pop()
                down.pop()
            steps = [*(self.edge(joint).inverse() for joint in up), *map(self.edge, reversed(down))]
            self._places[source, target] = reduce(Placed.then, steps, HERE)
        return self._places[source, target]

    def line(self, joint: Joint, target: str) -> Line:
        """Return the axis of a joint in the frame of a link that it moves."""
        place = self.relative(joint.child, target).inverse()
        axis = place.transform.rotate(unit(joint.axis))
        tilt = 2 * ROOT_THREE * self.precision("axis", *joint.axis) / norm(joint.axis)
        return Line(axis, place.transform.xyz, place.angle + tilt, place.length)


class Gap(NamedTuple):
    """The distance between two poses (m, rad; zero within their precision), and their precision."""

    distance: float
    angle: float
    least: tuple[float, float]

    @property
    def closed(self) -> bool:
        """Whether the two poses are equal."""
        return not self.distance and not self.angle


def gap(one: Placed, other: Placed, tolerance: float) -> Gap:
    """Return the distance between two poses, which are equal up to ``tolerance`` (m, rad)."""
    apart = math.dist(one.transform.xyz, other.transform.xyz), one.transform.angle_to(other.transform)
    least = tolerance + join_errors(one.length, other.length), tolerance + join_errors(one.angle, other.angle)
    distance, angle = (by if by > known else 0.0 for by, known in zip(apart, least, strict=True))
    return Gap(distance, angle, least)


def has_axis(joint: Joint) -> bool:
    """Return True if a joint turns or slides along an axis."""
    return joint.moves and bool(norm(joint.axis))


def axis_turn(old: Line, new: Line, tolerance: float) -> float:
    """Return by how much an axis turned (rad), or 0 if that is within the precision of the axes."""
    angle = angle_between(old.direction, new.direction)
    return angle if angle > tolerance + join_errors(old.angle, new.angle) else 0.0


def axis_shift(old: Line, new: Line, tolerance: float) -> float:
    """Return how far an axis moved sideways (m), or 0 if that is within the precision of the axes."""
    way = minus(new.point, old.point)
    along = dot(way, old.direction)
    x, y, z = old.direction
    distance = norm(minus(way, (x * along, y * along, z * along)))
    return distance if distance > tolerance + join_errors(old.length, new.length) else 0.0


def motion_of(joint: Joint) -> str:
    """Return the kind of motion of a joint; revolute and continuous joints have the same kind."""
    return "turns" if joint.type in ("revolute", "continuous") else joint.type


def same_motion(
    a: Bodies, b: Bodies, source: str, target: str, tolerance: float, flipped: Collection[str] = ()
) -> bool:
    """Return True if ``target`` moves in the same way relative to ``source``, a link above, in both robots.

    Product of exponentials (R. Brockett): the pose with all joints at zero and the axes of the joints in between, in
    the frame of the link, determine the motion. ``flipped`` are joints with the opposite sign.
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
_TURN, _SLIDE = math.pi, 0.5  # the range of joints without limits (rad, m)


def positions_of(*joints: Joint) -> list[float]:
    """Return positions to try (rad or m): zero, then steps between the limits of the first joint with limits."""
    reach = _SLIDE if joints[0].type == "prismatic" else _TURN
    lower, upper = -reach, reach
    for joint in reversed(joints):
        limit = joint.limit if joint.type != "continuous" else None
        if limit is not None and limit.lower is not None and limit.upper is not None and limit.lower < limit.upper:
            lower, upper = max(limit.lower, -2 * reach), min(limit.upper, 2 * reach)
    steps = [lower + (upper - lower) * index / _STEPS for index in range(_STEPS + 1)]
    return [0.0, *(position for position in steps if abs(position) > 1e-6)]


class Pairing(NamedTuple):
    """Two matched robots; B has the names of A."""

    a: Bodies
    b: Bodies
    bodies: Mapping[str, str]  # bodies of B by matching body of A, both named after their topmost link
    links: Names  # names in A of differently named links, by name in B without the prefix
    joints: Names  # as ``links``
    prefix: str  # the prefix of all names in robot ``prefixed``
    prefixed: str  # "A", "B" or ""
    tolerance: float
    steps: tuple[list[tuple[Names, Names]], list[tuple[Names, Names]]]  # renamings of links and joints in A and B

    @property
    def shared(self) -> list[str]:
        """The links that both robots have, in the order of A's tree."""
        return [link.name for link in self.a.robot.walk() if link.name in self.b.robot.link]

    def pair_of_joints(self, top: str) -> tuple[Joint | None, Joint | None]:
        """Return the joints above a body of A and above its counterpart in B."""
        return self.a.robot.joint_to.get(top), self.b.robot.joint_to.get(self.bodies[top])

    def rename_leaves(self, at: int, found: Leaves, other: Leaves) -> Leaves:
        """Rename leaves of A (``at`` 0) or B to the common names; ``other`` are the leaves of the other robot."""
        for links, joints in self.steps[at]:
            found = with_names(with_names(found, links, "link", other), joints, "joint", other)
        return found


def pair(a: Side, b: Side, tolerance: float, prefix: str | None = None) -> Pairing:
    """Match two robots link by link. ``prefix`` is the prefix of all names in B; None detects it."""
    robots, at = [a.robot, b.robot], 1
    steps: tuple[list[tuple[Names, Names]], list[tuple[Names, Names]]] = ([], [])
    if prefix is None:
        found = [prefix_of(robots[1 - side], robots[side]) for side in (0, 1)]
        at = 1 if found[1] or not found[0] else 0
        prefix = found[at]
    if prefix:
        names = without_prefix(robots[at].link, prefix), without_prefix(robots[at].joint, prefix)
        robots[at] = renamed_robot(robots[at], *names)
        steps[at].append(names)
    links = new_link_names(*(leaves(replace(robot, edges=())) for robot in robots[::-1]))
    other = renamed_robot(robots[1], links, {})
    joints = new_joint_names(leaves(other), leaves(robots[0]))
    # The new name of a joint in B must be unused, or be renamed itself.
    for name in sorted({name for name in other.joint if name not in joints} & set(joints.values())):
        joints[name] = f"{name} (of B)"
    one, other = robots[0], renamed_robot(other, {}, joints)
    steps[1].append((links, joints))
    first, second = Bodies(one, a.printing, _split(one, other)), Bodies(other, b.printing, _split(other, one))
    # Match each body of A with the body of B at the same joint, or else the one that shares most links.
    rated: list[tuple[bool, int, int, str, str]] = []
    for index, (top, members) in enumerate(first.members.items()):
        goals = [second.top[name] for name in members if name in second.top]
        for goal in dict.fromkeys(goals):
            mine, theirs = one.joint_to.get(top), other.joint_to.get(goal)
            other_joint = mine is None or theirs is None or mine.name != theirs.name
            rated.append((other_joint, -goals.count(goal), index, top, goal))
    goal_of: dict[str, str] = {}
    for _, _, _, top, goal in sorted(rated):
        if top not in goal_of and goal not in goal_of.values():
            goal_of[top] = goal
    bodies = {top: goal_of[top] for top in first.members if top in goal_of}
    return Pairing(first, second, bodies, links, joints, prefix, "AB"[at] if prefix else "", tolerance, steps)


def _split(one: Robot, other: Robot) -> frozenset[str]:
    pairs = [(joint, other.joint_to[joint.child]) for joint in one.joints if joint.child in other.joint_to]
    pairs = [(joint, twin) for joint, twin in pairs if joint.is_fixed and not twin.is_fixed]
    return frozenset(joint.name for joint, twin in pairs if joint.parent == twin.parent or joint.name == twin.name)


def compare_names(pairing: Pairing, not_carried: frozenset[str], fixed_names: bool) -> Iterator[Item]:
    """Yield new, removed and renamed links and joints; a new or removed link includes the links attached to it."""
    a, b = pairing.a.robot, pairing.b.robot
    for robot, other, word in ((a, b, REMOVED), (b, a, NEW)):
        heads: dict[str, str] = {}
        below: dict[str, list[str]] = {}
        for link in robot.walk():
            name, joint = link.name, robot.joint_to.get(link.name)
            if name not in other.link and name not in not_carried:
                heads[name] = heads.get(joint.parent, name) if joint is not None else name
                below.setdefault(heads[name], []).append(name)
        for head, names in below.items():
            joint, link = robot.joint_to.get(head), robot.link[head]
            what = "link" if link.inertial or link.collision or link.visual else "frame"
            how = [f"{joint.type} on {joint.parent}", joint.name] if joint is not None else ["the root"]
            values = (head, None) if word == REMOVED else (None, head)
            yield Item(NAME, head, "existence", existence(word, what, head, how, names[1:]), *values)
    for mine, theirs in map(pairing.pair_of_joints, pairing.bodies):  # a body may have lost or gained its joint
        joint, word = (mine, REMOVED) if mine is not None else (theirs, NEW)
        if joint is not None and (mine is None or theirs is None):
            text = f"{word}: joint {joint.name} ({joint.type}, {joint.parent} to {joint.child})"
            values = (joint.name, None) if word == REMOVED else (None, joint.name)
            yield Item(JOINT, joint.name, "existence", text, *values)
    # The keys are names in B without the prefix.
    new_names = {old: new for new, old in pairing.links.items()}
    for old in (name for name in pairing.a.top if name in new_names):
        yield Item(NAME, old, "name", f"link {old} renamed to {new_names[old]}", old, new_names[old])
    for new, old in pairing.joints.items():
        joint = a.joint.get(old)
        if joint is not None and (fixed_names or not joint.is_fixed):
            yield Item(NAME, old, "name", f"joint {old} renamed to {new}", old, new)
