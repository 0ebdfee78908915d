"""Compare the poses and the motion of frames of two robots; frames that moved together are one difference.

A cluster is a set of frames of one body whose relative poses are equal in both robots. A cluster is in place if it
moves equally in both robots relative to some cluster of a body above, even if the joints in between are elsewhere.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import replace

from rosorin_compile.model import Joint, Limit, Pose
from rosorin_compile.model.geometry import pose_of
from rosorin_compile.source.numbers import amount
from rosorin_compile.source.progress import Progress

from .bodies import Bodies, Gap, Pairing, axis_shift, axis_turn, gap, has_axis, motion_of, positions_of, same_motion
from .difference import FRAME, JOINT, Item, Report
from .precision import Placed
from .sentences import axis_change, describe_move, far, near_angles, number, row, several, text_of, value_change

_LEAST = 1e-6  # rad, m: smaller differences of limits are ignored


def compare_frames(pairing: Pairing, report: Report) -> tuple[Mapping[str, str], Mapping[str, bool]]:
    """Report which frames moved, by how much, and at which positions of the joints.

    Return the frame in which to compare shapes and masses for each body of A; and the joints with the opposite sign in
    B, mapped to True if the sign of their limits is also opposite.
    """
    work = _Frames(pairing, report.items)
    for index, top in enumerate(pairing.bodies):
        Progress.step("comparing frames", index, len(pairing.bodies))
        work.body(top)
    report.items.extend(_elsewhere(pairing))
    return {top: clusters[0][0] for top, clusters in work.clusters.items()}, work.flipped


class _Frames:
    def __init__(self, pairing: Pairing, items: list[Item]) -> None:
        self.pairing = pairing
        self.a, self.b = pairing.a, pairing.b
        self.items = items
        self.clusters: dict[str, list[list[str]]] = {}
        self.moved: set[str] = set()
        self.flipped: dict[str, bool] = {}

    def body(self, top: str) -> None:
        """Compare the pose of a body relative to bodies above it, then its clusters with each other."""
        shared = [name for name in self.a.members[top] if self.b.top.get(name) == self.pairing.bodies[top]]
        clusters = self._clusters(shared)
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
        for cluster in clusters:
            if cluster is not first and cluster not in in_place:
                # Report the pose in its parent, or in the frame in which its body is compared.
                above, head = self.a.robot.joint_to.get(cluster[0]), cluster[0]
                parent = above.parent if above is not None else ""
                is_fixed = all(parent in side.top and side.top[parent] == side.top[head] for side in (self.a, self.b))
                source = parent if is_fixed else first[0]
                places = self.a.relative(source, head), self.b.relative(source, head)
                self._moved(FRAME, head, head, (source, source), places, cluster[1:])

    def _clusters(self, names: Sequence[str]) -> list[list[str]]:
        """Return the clusters of a body: first the cluster of the root, or else the largest one."""
        found: list[list[str]] = []
        for name in names:
            joint = self.a.robot.joint_to.get(name)
            # The pose in the parent is the most precise: rounding of a longer chain must not hide a difference.
            parent = joint.parent if joint is not None else ""
            heads = [(cluster, parent if parent in cluster else cluster[0]) for cluster in found]
            heads.sort(key=lambda head: head[1] != parent)
            home = next((cluster for cluster, head in heads if self._gap(head, name).closed), None)
            if home is None:
                found.append(home := [])
            home.append(name)
        return sorted(found, key=lambda cluster: (self.a.robot.root not in cluster, -len(cluster)))

    def _gap(self, source: str, target: str) -> Gap:
        return gap(self.a.relative(source, target), self.b.relative(source, target), self.pairing.tolerance)

    def _in_place(self, clusters: list[list[str]], top: str, flipped: Collection[str]) -> list[list[str]]:
        """Return the clusters that are in place relative to the body above, or to one further up if it moved."""
        joint = self.a.robot.joint_to[top]
        for upper in (body for body in self.a.above(top) if body in self.clusters):
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
        """Record that a joint of B has the opposite sign, if its motion is otherwise equal."""
        known = {*self.flipped, joint.name}
        if not joint.moves or self._in_place(clusters, top, self.flipped) or not self._in_place(clusters, top, known):
            return
        one, other = (j.limit if j.limit is not None and j.type != "continuous" else Limit() for j in (joint, twin))
        ends = [(one.lower, other.upper), (one.upper, other.lower)]
        follows = all(a is b if a is None or b is None else abs(a + b) < _LEAST for a, b in ends)
        self.flipped[joint.name] = follows
        limits = "its limits follow" if follows else "its limits do not follow"
        text = f"{axis_change(joint.name, joint.axis, twin.axis, math.pi)}; {limits}"
        self.items.append(Item(JOINT, joint.name, "coordinate", text, row(joint.axis), row(twin.axis), when="always"))

    def _moved_joint(self, joint: Joint, twin: Joint, target: str, same_kind: bool) -> None:
        """Report how the joint above a displaced body changed: its parent, its pose and its axis."""
        is_elsewhere = self.pairing.bodies.get(self.a.top[joint.parent]) != self.b.top[twin.parent]
        source = "" if is_elsewhere and same_kind else self._above_in_both(joint, target)
        if is_elsewhere and same_kind:
            text = value_change(f"{joint.child} parent", joint.parent, twin.parent)
            self.items.append(Item(JOINT, joint.name, "parent", text, joint.parent, twin.parent))
            places = self.a.edge(joint), self.b.edge(twin)
            self._moved(JOINT, joint.name, joint.child, (joint.parent, twin.parent), places)
        elif source:
            places = self.a.relative(source, target), self.b.relative(source, target)
            self._moved(JOINT, joint.name, target, (source, source), places)
        if not has_axis(joint) or not has_axis(twin):
            return
        old, new = self.a.line(joint, target), self.b.line(twin, target)
        angle, distance = (measure(old, new, self.pairing.tolerance) for measure in (axis_turn, axis_shift))
        if angle:
            text = axis_change(joint.name, joint.axis, twin.axis, angle)
            item = Item(JOINT, joint.name, "axis", text, row(old.direction), row(new.direction))
        elif joint.type != "prismatic" and distance:
            text = f"{joint.name} axis moved {amount(distance, 'm')} in {target}"
            item = Item(JOINT, joint.name, "axis", text, row(old.point), row(new.point))
        else:
            return
        self.items.append(self._with_effect(item, joint, twin, source) if source and same_kind else item)

    def _above_in_both(self, joint: Joint, target: str) -> str:
        """Return the nearest link above a joint that is above ``target`` in B, too, or an empty text."""
        for body in self.a.above(joint.child):
            for name in (joint.parent, *self.a.members[body]):
                if name in self.b.top and self.b.joints_between(self.b.top[name], self.b.top[target]):
                    return name
        return ""

    def _with_effect(self, item: Item, joint: Joint, twin: Joint, source: str) -> Item:
        """Add to a change of an axis the largest displacement of links below, and the joint positions there."""
        # Every joint is moved separately.
        joints = [tuple(replace(each, mimic=None) for each in side.robot.joints) for side in (self.a, self.b)]
        robots = [replace(side.robot, joints=some) for side, some in zip((self.a, self.b), joints, strict=True)]
        trees = [robot.subtree(robot.joint[joint.name].child) for robot in robots]
        below = [name for name in self.pairing.shared if all(name in tree for tree in trees)]
        worst, at, frame, angle = 0.0, 0.0, "", 0.0
        for position in positions_of(joint, twin):
            poses = [robot.poses_in_root({joint.name: position}) for robot in robots]
            back = [places[source].inverse() for places in poses]
            for name in below:
                one, other = (way.then(places[name]) for way, places in zip(back, poses, strict=True))
                distance, angle = math.dist(one.xyz, other.xyz), max(angle, one.angle_to(other))
                if not frame or distance > worst + 1e-12:
                    worst, at, frame = distance, position, name
        text = f"{item.text}: {frame} off by up to {far(worst, angle)} at {joint.name} = {number(at)}"
        text += f", only when {joint.name} is away from 0"
        return replace(item, text=text, distance=worst, angle=angle, when="away from 0", at={joint.name: at})

    def _moved(
        self,
        kind: str,
        name: str,
        frame: str,
        sources: tuple[str, str],
        places: tuple[Placed, Placed],
        others: Sequence[str] = (),
    ) -> None:
        """Report a frame whose pose differs; ``others`` are frames that moved with it."""
        distance, angle, least = apart = gap(*places, self.pairing.tolerance)
        if not apart.closed:
            old, new = pose_of(places[0].transform), pose_of(places[1].transform)
            near = Pose(old.xyz, near_angles(old.rpy, new.rpy)), new
            text = describe_move(frame, sources, near, (distance, angle), others, least)
            values = text_of(old), text_of(new)
            self.items.append(Item(kind, name, "origin", text, *values, "", distance, angle, "always"))


def _elsewhere(pairing: Pairing) -> Iterator[Item]:
    """Yield the links that belong to a different body in B, grouped with the links that go with them."""
    groups: dict[tuple[str, str], list[str]] = {}
    for name in pairing.shared:
        top, goal = pairing.a.top[name], pairing.b.top[name]
        if pairing.bodies.get(top) != goal:
            groups.setdefault((top, goal), []).append(name)
    for (top, goal), names in groups.items():
        before, after = _moved_by(pairing.a, top), _moved_by(pairing.b, goal)
        if before == after:
            before, after = f"{before}, as part of {top}", f"{after}, as part of {goal}"
        with_it = f", and with it {several(names[1:])}" if names[1:] else ""
        yield Item(FRAME, names[0], "body", f"{names[0]}: {before} -> {after}{with_it}", before, after)


def _moved_by(bodies: Bodies, top: str) -> str:
    joint = bodies.robot.joint_to.get(top)
    return f"moves with {joint.name}" if joint is not None else f"fixed to {bodies.robot.root}"
