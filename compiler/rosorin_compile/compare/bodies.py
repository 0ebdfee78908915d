"""Match links, joints and bodies of two robots, and compare the poses and the motion of their frames.

A body is a set of links that fixed joints connect rigidly, named after its topmost link. Two files can connect the same
links by different fixed joints, so poses are not compared joint by joint. Within a body, links whose relative poses are
equal in both robots form a cluster, and are reported together if they moved. A cluster is in place if its motion
relative to a body above is equal in both robots, even if the joints in between have other origins.
"""

import math
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import replace
from functools import reduce
from typing import NamedTuple

from rosorin_compile.model import Joint, Limit, Robot, Vector
from rosorin_compile.model.geometry import angle_between, dot, minus, norm, pose_of, unit
from rosorin_compile.source.numbers import amount
from rosorin_compile.source.progress import Progress

from . import sentences, walk
from .difference import FRAME, JOINT, NAME, Item, Report, Side
from .precision import HERE, ROOT_THREE, TURNS, Precision, RoundedTransform, join_errors
from .sentences import NEW, REMOVED, Apart, existence, far, number, row, several, text_of, value_change
from .walk import Leaves, Names, leaves, prefix_of, renamed_robot, with_names, without_prefix

_LEAST = 1e-6  # rad or m; smaller differences between joint limits are ignored
_STEPS = 16
_TURN, _SLIDE = math.pi, 0.5  # a joint without limits moves from -pi to pi rad, or from -0.5 to 0.5 m


class Line(NamedTuple):
    """The axis of a joint, as a unit vector and a point on the axis (m), each with its largest error."""

    direction: Vector
    point: Vector
    angle: float  # largest error of the direction (rad)
    length: float  # largest error of the point (m)


class Bodies:
    """Groups the links of a robot into rigid bodies. The fixed joints ``split`` are treated as moving joints."""

    def __init__(self, robot: Robot, precision: Precision, split: frozenset[str] = frozenset()) -> None:
        self.robot = robot
        self.precision = precision
        self.top: dict[str, str] = {}
        self.members: dict[str, list[str]] = {}
        self._places: dict[tuple[str, str], RoundedTransform] = {}
        for link in robot.walk():
            joint = robot.joint_to.get(link.name)
            is_top = joint is None or not joint.is_fixed or joint.name in split
            self.top[link.name] = link.name if joint is None or is_top else self.top[joint.parent]
            self.members.setdefault(self.top[link.name], []).append(link.name)

    def edge(self, joint: Joint) -> RoundedTransform:
        """Return the pose of the child link of a joint in its parent link, at joint position zero."""
        length = ROOT_THREE * self.precision("xyz", *joint.origin.xyz)
        return RoundedTransform(joint.origin.transform(), length, TURNS * self.precision("rpy", *joint.origin.rpy))

    def ancestors(self, top: str) -> Iterator[str]:
        """Yield the topmost links of all bodies above a body, nearest first."""
        while joint := self.robot.joint_to.get(top):
            yield (top := self.top[joint.parent])

    def joints_between(self, upper: str, lower: str) -> list[Joint] | None:
        """Return the joints from body ``upper`` down to body ``lower``, or None if ``lower`` is not below ``upper``."""
        bodies = [lower, *self.ancestors(lower)]
        if upper not in bodies:
            return None
        return [self.robot.joint_to[top] for top in bodies[: bodies.index(upper)]][::-1]

    def relative(self, source: str, target: str) -> RoundedTransform:
        """Return the pose of ``target`` in ``source``, a link in the same or a higher body; all joints are at zero."""
        here, found = source, HERE
        for joint in self.joints_between(self.top[source], self.top[target]) or []:
            found = found.then(self._within(here, joint.parent)).then(self.edge(joint))
            here = joint.child
        return found.then(self._within(here, target))

    def _within(self, source: str, target: str) -> RoundedTransform:
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
            self._places[source, target] = reduce(RoundedTransform.then, steps, HERE)
        return self._places[source, target]

    def moved_by(self, top: str) -> str:
        joint = self.robot.joint_to.get(top)
        return f"moves with {joint.name}" if joint is not None else f"fixed to {self.robot.root}"

    def line(self, joint: Joint, target: str) -> Line:
        """Return the axis of a joint in the frame of ``target``, a link that the joint moves."""
        place = self.relative(joint.child, target).inverse()
        tilt = 2 * ROOT_THREE * self.precision("axis", *joint.axis) / norm(joint.axis)
        return Line(place.transform.rotate(unit(joint.axis)), place.transform.xyz, place.angle + tilt, place.length)


def gap(one: RoundedTransform, other: RoundedTransform, tolerance: float) -> tuple[Apart, Apart]:
    """Return ((distance, angle), (precision of the distance, of the angle)) of two poses, in m and rad.

    The precision is ``tolerance`` plus the errors of the poses. A distance or angle within the precision is zero.
    """
    apart = math.dist(one.transform.xyz, other.transform.xyz), one.transform.angle_to(other.transform)
    least = tolerance + join_errors(one.length, other.length), tolerance + join_errors(one.angle, other.angle)
    distance, angle = (by if by > known else 0.0 for by, known in zip(apart, least, strict=True))
    return (distance, angle), least


def has_axis(joint: Joint) -> bool:
    """Return True if a joint turns about or slides along an axis."""
    return joint.moves and bool(norm(joint.axis))


def axis_gap(old: Line, new: Line, tolerance: float) -> Apart:
    """Return the distance (m) and the angle (rad) that an axis moved. Up to ``tolerance`` plus rounding, they are 0."""
    angle = angle_between(old.direction, new.direction)
    way, (x, y, z) = minus(new.point, old.point), old.direction
    along = dot(way, old.direction)
    distance = norm(minus(way, (x * along, y * along, z * along)))
    known = tolerance + join_errors(old.length, new.length), tolerance + join_errors(old.angle, new.angle)
    return distance if distance > known[0] else 0.0, angle if angle > known[1] else 0.0


def motion_of(joint: Joint) -> str:
    """Return "turns" for revolute and continuous joints, or the type of any other joint."""
    return "turns" if joint.type in ("revolute", "continuous") else joint.type


def same_motion(
    a: Bodies, b: Bodies, source: str, target: str, tolerance: float, flipped: Collection[str] = ()
) -> bool:
    """Return True if the motion of link ``target`` relative to link ``source`` is the same in both robots.

    ``source`` is above ``target``. The motion follows from the pose at joint position zero and the axes of the joints
    in between (product of exponentials, R. Brockett). The joints ``flipped`` have opposite axes in ``b``.
    """
    ways = [side.joints_between(side.top[source], side.top[target]) for side in (a, b)]
    if ways[0] is None or ways[1] is None or list(map(motion_of, ways[0])) != list(map(motion_of, ways[1])):
        return False
    if any(gap(a.relative(source, target), b.relative(source, target), tolerance)[0]):
        return False
    for joint, twin in zip(*ways, strict=True):
        if has_axis(joint) and has_axis(twin):
            old, new = a.line(joint, target), b.line(twin, target)
            if twin.name in flipped:
                x, y, z = new.direction
                new = new._replace(direction=(-x, -y, -z))
            distance, angle = axis_gap(old, new, tolerance)
            if angle or (distance and joint.type != "prismatic"):
                return False
    return True


class BodyPairs(NamedTuple):
    """Two matched robots, A and B. Links and joints of B have the names of their counterparts in A."""

    a: Bodies
    b: Bodies
    bodies: Mapping[str, str]  # {body of A: matching body of B}, both named after their topmost link
    links: Names  # {name in B without the prefix: name in A} of links with different names
    joints: Names  # the same for joints
    prefix: str  # a prefix that only the names of one robot have, or ""
    prefixed: str  # the robot with the prefix: "A", "B" or ""
    tolerance: float
    steps: tuple[list[tuple[Names, Names]], list[tuple[Names, Names]]]  # new names in A and in B: (links, joints)

    @property
    def shared_links(self) -> list[str]:
        """The names of the links that both robots have, from the root of A down."""
        return [link.name for link in self.a.robot.walk() if link.name in self.b.robot.link]

    def pair_of_joints(self, top: str) -> tuple[Joint | None, Joint | None]:
        """Return the joint above a body of A and the joint above the matching body of B, or None for a root."""
        return self.a.robot.joint_to.get(top), self.b.robot.joint_to.get(self.bodies[top])

    def rename_leaves(self, at: int, found: Leaves, other: Leaves) -> Leaves:
        """Rename links and joints in the values of a robot to the common names of both robots.

        ``at`` is 0 for robot A and 1 for B; ``other`` are the values of the other robot (see ``with_names``).
        """
        for links, joints in self.steps[at]:
            found = with_names(with_names(found, links, "link", other), joints, "joint", other)
        return found


def pair(a: Side, b: Side, tolerance: float, prefix: str | None = None) -> BodyPairs:
    """Match two robots link by link. ``prefix`` is the prefix of all names in ``b``; None detects the prefix."""
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
    links = walk.new_link_names(*(leaves(replace(robot, edges=())) for robot in robots[::-1]))
    other = renamed_robot(robots[1], links, {})
    joints = walk.new_joint_names(leaves(other), leaves(robots[0]))
    # Avoid duplicate names: rename joints of B that have the name of a different joint of A.
    for name in sorted({name for name in other.joint if name not in joints} & set(joints.values())):
        joints[name] = f"{name} (of B)"
    one, other = robots[0], renamed_robot(other, {}, joints)
    steps[1].append((links, joints))
    first, second = Bodies(one, a.printing, _split(one, other)), Bodies(other, b.printing, _split(other, one))
    # Match each body of A with the body of B whose joint has the same name, or that shares the most links.
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
    return BodyPairs(first, second, bodies, links, joints, prefix, "AB"[at] if prefix else "", tolerance, steps)


def _split(one: Robot, other: Robot) -> frozenset[str]:
    pairs = [(joint, other.joint_to[joint.child]) for joint in one.joints if joint.child in other.joint_to]
    pairs = [(joint, twin) for joint, twin in pairs if joint.is_fixed and not twin.is_fixed]
    return frozenset(joint.name for joint, twin in pairs if joint.parent == twin.parent or joint.name == twin.name)


def compare_names(pairing: BodyPairs, not_carried: frozenset[str], fixed_names: bool) -> Iterator[Item]:
    """Yield an ``Item`` for each new, removed or renamed link or joint.

    The item of a new or removed link lists the links below, which have no items of their own. Links in ``not_carried``
    are ignored. Renamed fixed joints are ignored unless ``fixed_names`` is True.
    """
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
    for mine, theirs in map(pairing.pair_of_joints, pairing.bodies):  # a body can be the root of only one robot
        joint, word = (mine, REMOVED) if mine is not None else (theirs, NEW)
        if joint is not None and (mine is None or theirs is None):
            text = f"{word}: joint {joint.name} ({joint.type}, {joint.parent} to {joint.child})"
            values = (joint.name, None) if word == REMOVED else (None, joint.name)
            yield Item(JOINT, joint.name, "existence", text, *values)
    # ``pairing.links`` maps names in B (without the prefix) to names in A.
    new_names = {old: new for new, old in pairing.links.items()}
    for old in (name for name in pairing.a.top if name in new_names):
        yield Item(NAME, old, "name", f"link {old} renamed to {new_names[old]}", old, new_names[old])
    for new, old in pairing.joints.items():
        joint = a.joint.get(old)
        if joint is not None and (fixed_names or not joint.is_fixed):
            yield Item(NAME, old, "name", f"joint {old} renamed to {new}", old, new)


def compare_frames(pairing: BodyPairs, report: Report) -> tuple[Mapping[str, str], Mapping[str, bool]]:
    """Report which frames moved, by how much, and at which joint positions.

    Return two dicts: for each body of A, the link whose frame is used to compare its shapes and masses; and for each
    joint with an opposite axis in B, True if the sign of its limits is also opposite.
    """
    work = _Frames(pairing, report.items)
    for index, top in enumerate(pairing.bodies):
        Progress.step("comparing frames", index, len(pairing.bodies))
        work.body(top)
    # {(body in A, body in B): links} of links that belong to different bodies in A and B; each group is one item.
    groups: dict[tuple[str, str], list[str]] = {}
    for name in pairing.shared_links:
        top, goal = pairing.a.top[name], pairing.b.top[name]
        if pairing.bodies.get(top) != goal:
            groups.setdefault((top, goal), []).append(name)
    for (top, goal), names in groups.items():
        before, after = pairing.a.moved_by(top), pairing.b.moved_by(goal)
        if before == after:
            before, after = f"{before}, as part of {top}", f"{after}, as part of {goal}"
        with_it = f", and with it {several(names[1:])}" if names[1:] else ""
        report.items.append(Item(FRAME, names[0], "body", f"{names[0]}: {before} -> {after}{with_it}", before, after))
    return {top: clusters[0][0] for top, clusters in work.clusters.items()}, work.flipped


class _Frames:
    def __init__(self, pairing: BodyPairs, items: list[Item]) -> None:
        self.pairing, self.items = pairing, items
        self.a, self.b = pairing.a, pairing.b
        self.clusters: dict[str, list[list[str]]] = {}
        self.moved: set[str] = set()
        self.flipped: dict[str, bool] = {}

    def body(self, top: str) -> None:
        clusters = self._clusters([n for n in self.a.members[top] if self.b.top.get(n) == self.pairing.bodies[top]])
        joint, twin = self.pairing.pair_of_joints(top)
        first, in_place = clusters[0], []
        if joint is not None and twin is not None:
            same_kind = motion_of(joint) == motion_of(twin)
            if same_kind:
                self._flip(joint, twin, clusters, top)
                in_place = self._in_place(clusters, top, self.flipped)
                near = next((cluster for cluster in clusters if joint.child in cluster), first)
                first = in_place[0] if in_place else near
            if not in_place:
                self.moved |= {top} if same_kind else set()
                self._moved_joint(joint, twin, joint.child if joint.child in first else first[0], same_kind)
        self.clusters[top] = [first, *(cluster for cluster in clusters if cluster is not first)]
        for head, *others in (one for one in clusters if one is not first and one not in in_place):
            # Report the pose in the parent link if that is in the same body, or else in the first cluster.
            above = self.a.robot.joint_to.get(head)
            parent = above.parent if above is not None else ""
            is_fixed = all(parent in side.top and side.top[parent] == side.top[head] for side in (self.a, self.b))
            way = (parent if is_fixed else first[0], head)
            self._moved(FRAME, head, way, way, others)

    def _clusters(self, names: Sequence[str]) -> list[list[str]]:
        """Group links by equal relative poses; the group of the root, or else the largest group, is first."""
        found: list[list[str]] = []
        for name in names:
            joint = self.a.robot.joint_to.get(name)
            # Prefer the pose in the parent link: the rounding errors of a longer chain could hide a difference.
            parent = joint.parent if joint is not None else ""
            heads = [(cluster, parent if parent in cluster else cluster[0]) for cluster in found]
            heads.sort(key=lambda head: head[1] != parent)
            home = next((cluster for cluster, head in heads if not any(self._gap((head, name))[0])), None)
            if home is None:
                found.append(home := [])
            home.append(name)
        return sorted(found, key=lambda cluster: (self.a.robot.root not in cluster, -len(cluster)))

    def _gap(self, way: tuple[str, str], other: tuple[str, str] | None = None) -> tuple[Apart, Apart]:
        return gap(self.a.relative(*way), self.b.relative(*(other or way)), self.pairing.tolerance)

    def _in_place(self, clusters: list[list[str]], top: str, flipped: Collection[str]) -> list[list[str]]:
        """Return the clusters that move equally in both robots, relative to the nearest body that did not move."""
        joint = self.a.robot.joint_to[top]
        for upper in (body for body in self.a.ancestors(top) if body in self.clusters):
            ends = [joint.parent if joint.parent in some else some[0] for some in self.clusters[upper]]
            found = []
            for cluster in clusters:
                goal = joint.child if joint.child in cluster else cluster[0]
                if any(same_motion(self.a, self.b, end, goal, self.pairing.tolerance, flipped) for end in ends):
                    found.append(cluster)
            if found or upper not in self.moved:
                return found
        return []

    def _flip(self, joint: Joint, twin: Joint, clusters: list[list[str]], top: str) -> None:
        """Record and report a joint that has the opposite axis in B but otherwise moves its links equally."""
        known = {*self.flipped, joint.name}
        if not joint.moves or self._in_place(clusters, top, self.flipped) or not self._in_place(clusters, top, known):
            return
        one, other = (j.limit if j.limit is not None and j.type != "continuous" else Limit() for j in (joint, twin))
        ends = [(one.lower, other.upper), (one.upper, other.lower)]
        follows = all(a is b if a is None or b is None else abs(a + b) < _LEAST for a, b in ends)
        self.flipped[joint.name] = follows
        limits = "its limits follow" if follows else "its limits do not follow"
        text = f"{sentences.axis_change(joint.name, joint.axis, twin.axis, math.pi)}; {limits}"
        self.items.append(Item(JOINT, joint.name, "coordinate", text, row(joint.axis), row(twin.axis), when="always"))

    def _moved_joint(self, joint: Joint, twin: Joint, target: str, same_kind: bool) -> None:
        source = ""
        if same_kind and self.pairing.bodies.get(self.a.top[joint.parent]) != self.b.top[twin.parent]:
            text = value_change(f"{joint.child} parent", joint.parent, twin.parent)
            self.items.append(Item(JOINT, joint.name, "parent", text, joint.parent, twin.parent))
            self._moved(JOINT, joint.name, (joint.parent, joint.child), (twin.parent, twin.child))
        else:  # find the nearest link above the joint that is also above the target in B
            above = (name for body in self.a.ancestors(joint.child) for name in (joint.parent, *self.a.members[body]))
            b, tops = self.b, self.b.top
            source = next((n for n in above if n in tops and b.joints_between(tops[n], tops[target])), "")
        if source:
            self._moved(JOINT, joint.name, (source, target), (source, target))
        if not has_axis(joint) or not has_axis(twin):
            return
        old, new = self.a.line(joint, target), self.b.line(twin, target)
        distance, angle = axis_gap(old, new, self.pairing.tolerance)
        if angle:
            text = sentences.axis_change(joint.name, joint.axis, twin.axis, angle)
            item = Item(JOINT, joint.name, "axis", text, row(old.direction), row(new.direction))
        elif joint.type != "prismatic" and distance:
            text = f"{joint.name} axis moved {amount(distance, 'm')} in {target}"
            item = Item(JOINT, joint.name, "axis", text, row(old.point), row(new.point))
        else:
            return
        self.items.append(self._with_effect(item, joint, twin, source) if source and same_kind else item)

    def _with_effect(self, item: Item, joint: Joint, twin: Joint, source: str) -> Item:
        """Add to an item about a changed axis how far the change displaces the links below the joint."""
        reach = _SLIDE if joint.type == "prismatic" else _TURN
        lower, upper = -reach, reach
        for limit in (each.limit for each in (twin, joint) if each.type != "continuous"):
            if limit is not None and limit.lower is not None and limit.upper is not None and limit.lower < limit.upper:
                lower, upper = max(limit.lower, -2 * reach), min(limit.upper, 2 * reach)
        steps = [lower + (upper - lower) * index / _STEPS for index in range(_STEPS + 1)]
        # Remove mimics, so that the position of the joint moves no other joint.
        joints = [tuple(replace(each, mimic=None) for each in side.robot.joints) for side in (self.a, self.b)]
        robots = [replace(side.robot, joints=some) for side, some in zip((self.a, self.b), joints, strict=True)]
        trees = [robot.subtree(robot.joint[joint.name].child) for robot in robots]
        below = [name for name in self.pairing.shared_links if all(name in tree for tree in trees)]
        worst, at, frame, angle = 0.0, 0.0, "", 0.0
        for position in [0.0, *(step for step in steps if abs(step) > _LEAST)]:
            poses = [robot.poses_in_root({joint.name: position}) for robot in robots]
            back = [places[source].inverse() for places in poses]
            for name in below:
                one, other = (way.then(places[name]) for way, places in zip(back, poses, strict=True))
                distance, angle = math.dist(one.xyz, other.xyz), max(angle, one.angle_to(other))
                if not frame or distance > worst + 1e-12:
                    worst, at, frame = distance, position, name
        text = f"{item.text}: {frame} off by up to {far(worst, angle)} at {joint.name} = {number(at)}"
        text += f", only when {joint.name} is away from 0"
        return item._replace(text=text, distance=worst, angle=angle, when="away from 0", at={joint.name: at})

    def _moved(
        self, kind: str, name: str, way: tuple[str, str], other: tuple[str, str], others: Sequence[str] = ()
    ) -> None:
        apart, least = self._gap(way, other)
        if any(apart):
            old, new = pose_of(self.a.relative(*way).transform), pose_of(self.b.relative(*other).transform)
            text = sentences.describe_move(way[1], (way[0], other[0]), (old, new), apart, least, others)
            self.items.append(Item(kind, name, "origin", text, text_of(old), text_of(new), "", *apart, "always"))
