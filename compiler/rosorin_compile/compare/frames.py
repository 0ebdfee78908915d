"""Compare where the frames of two robots are and how they move; what moved together is one difference.

Frames of one body that have the same places in each other are a cluster. A cluster is in its place if it is so seen
from some cluster of a body above, wherever the joints between are.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from typing import NamedTuple

from rosorin_compile.model import Joint, Pose
from rosorin_compile.model.geometry import pose_of
from rosorin_compile.source.numbers import amount
from rosorin_compile.source.progress import Progress

from .bodies import (
    Bodies,
    Gap,
    Line,
    gap,
    has_axis,
    motion_of,
    positions_of,
    same_motion,
    shifted,
    span_of,
    turned,
)
from .difference import FRAME, JOINT, Item
from .pairing import Pairing
from .precision import Placed
from .sentences import axis_change, far, near_angles, number, placed, row, several, text_of, value_change

_LEAST = 1e-6  # rad, m: no shift of zero


class Coordinate(NamedTuple):
    """How a joint of B counts: its position is ``sign`` times that of A, plus ``shift`` (rad or m)."""

    joint: Joint
    twin: Joint
    sign: int
    shift: float
    same_limits: bool

    def of(self, position: float) -> float:
        """Return the position in B of a position in A."""
        return self.sign * position + self.shift

    def item(self) -> Item:
        """Return the difference in words."""
        name, axes = self.joint.name, (self.joint.axis, self.twin.axis)
        limits = "its limits follow" if self.same_limits else "its limits do not follow"
        if self.sign < 0:
            shift = f", zero is shifted by {number(self.shift)}" if self.shift else ""
            text = f"{axis_change(name, *axes, math.pi)}{shift}; {limits}"
        else:
            shift = f"position in B = position in A {'-' if self.shift < 0 else '+'} {number(abs(self.shift))}"
            text = f"{name} counts from another zero: {shift}; {limits}"
        return Item(JOINT, name, "coordinate", text, row(axes[0]), row(axes[1]), when="always")


class Frames(NamedTuple):
    """What differs in frames, and what the comparison of other things builds on.

    ``origins`` are the frames of bodies of A in which their shapes and masses are compared; ``coordinates`` are joints
    whose positions count otherwise.
    """

    items: list[Item]
    origins: Mapping[str, str]
    coordinates: Mapping[str, Coordinate]


def compare_frames(pairing: Pairing) -> Frames:
    """Return which frames moved, by how much, and at which positions of the joints."""
    work = _Frames(pairing)
    for index, top in enumerate(pairing.bodies):
        Progress.step("comparing frames", index, len(pairing.bodies))
        work.body(top)
    items = [*work.items, *_elsewhere(pairing)]
    return Frames(items, {top: clusters[0][0] for top, clusters in work.clusters.items()}, work.coordinates)


class _Frames:
    """Goes through the bodies of A from the root down; collects what differs."""

    def __init__(self, pairing: Pairing) -> None:
        self.pairing = pairing
        self.a, self.b = pairing.a, pairing.b
        self.items: list[Item] = []
        self.clusters: dict[str, list[list[str]]] = {}
        self.moved: set[str] = set()
        self.coordinates: dict[str, Coordinate] = {}

    def body(self, top: str) -> None:
        """Compare one body with the bodies above it, then its own clusters."""
        shared = [name for name in self.a.members[top] if self.b.top.get(name) == self.pairing.bodies[top]]
        clusters = self._clusters(shared)
        joint, twin = self.pairing.pair_of_joints(top)
        first, in_place = clusters[0], []
        if joint is not None and twin is not None:
            same_kind = motion_of(joint) == motion_of(twin)
            if same_kind:
                self._count(joint, twin, clusters, top)
                in_place = self._in_place(clusters, top, self.coordinates)
                near = next((cluster for cluster in clusters if joint.child in cluster), first)
                first = in_place[0] if in_place else near
            if not in_place:
                self.moved |= {top} if same_kind else set()
                self._moved_joint(joint, twin, joint.child if joint.child in first else first[0], same_kind)
        self.clusters[top] = [first, *(cluster for cluster in clusters if cluster is not first)]
        for cluster in clusters:
            if cluster is not first and cluster not in in_place:
                self._moved_cluster(cluster, first[0])

    def _clusters(self, names: Sequence[str]) -> list[list[str]]:
        """Return the clusters of a body; that of the root, or the largest one, comes first."""
        found: list[list[str]] = []
        for name in names:
            joint = self.a.robot.joint_to.get(name)
            # Seen from its parent a frame is known best: rounding further off does not make up for a difference.
            near = next((cluster for cluster in found if joint is not None and joint.parent in cluster), [])
            if near and joint is not None and self._gap(joint.parent, name).closed:
                near.append(name)
                continue
            others = (cluster for cluster in found if cluster is not near)
            home = next((cluster for cluster in others if self._gap(cluster[0], name).closed), None)
            if home is None:
                found.append([name])
            else:
                home.append(name)
        return sorted(found, key=lambda cluster: (self.a.robot.root not in cluster, -len(cluster)))

    def _zeros(self) -> dict[str, float]:
        return {name: coordinate.of(0.0) for name, coordinate in self.coordinates.items()}

    def _gap(self, source: str, target: str) -> Gap:
        """Return how far a frame is apart in the two robots, seen from another one, with the joints at zero."""
        places = self.a.relative(source, target), self.b.relative(source, target, self._zeros())
        return gap(*places, self.pairing.tolerance)

    def _in_place(self, clusters: list[list[str]], top: str, coordinates: Mapping[str, Coordinate]) -> list[list[str]]:
        """Return the clusters of a body that are in their place seen from the body above, or one further up.

        Further up counts only where the body above moved itself: over a long way rounding adds up.
        """
        zeros = {name: one.of(0.0) for name, one in coordinates.items()}
        flipped = frozenset(name for name, one in coordinates.items() if one.sign < 0)
        joint, upper = self.a.robot.joint_to[top], self.a.above(top)
        goals = [joint.child if joint.child in cluster else cluster[0] for cluster in clusters]
        while upper is not None:
            if upper in self.clusters:
                ends = [joint.parent if joint.parent in some else some[0] for some in self.clusters[upper]]
                found = [
                    cluster
                    for cluster, goal in zip(clusters, goals, strict=True)
                    if any(self._same(end, goal, zeros, flipped) for end in ends)
                ]
                if found or upper not in self.moved:
                    return found
            upper = self.a.above(upper)
        return []

    def _same(self, source: str, target: str, zeros: Mapping[str, float], flipped: frozenset[str]) -> bool:
        ends = (source, source), (target, target)
        return same_motion((self.a, self.b), *ends, self.pairing.tolerance, zeros, flipped)

    def _count(self, joint: Joint, twin: Joint, clusters: list[list[str]], top: str) -> None:
        """Note how a joint of B counts, if it counts otherwise and moves the same way.

        A shift of zero is taken for one only if the limits are shifted, too: otherwise the joint was turned.
        """
        if not joint.moves or self._in_place(clusters, top, self.coordinates):
            return
        for sign in (-1, 1):
            for shift in [0.0] * (sign < 0) + _shifts(joint, twin, sign):
                trial = Coordinate(joint, twin, sign, shift, _follows(joint, twin, sign, shift))
                known = {**self.coordinates, joint.name: trial}
                if (trial.same_limits or not shift) and self._in_place(clusters, top, known):
                    self.coordinates = known
                    self.items.append(trial.item())
                    return

    def _moved_joint(self, joint: Joint, twin: Joint, target: str, same_kind: bool) -> None:
        """Add what became of a joint whose body is nowhere in its place: its parent, its place and its axis."""
        is_elsewhere = self.pairing.bodies.get(self.a.top[joint.parent]) != self.b.top[twin.parent]
        source = "" if is_elsewhere and same_kind else self._above_in_both(joint, target)
        if is_elsewhere and same_kind:
            text = value_change(f"{joint.child} parent", joint.parent, twin.parent)
            self.items.append(Item(JOINT, joint.name, "parent", text, joint.parent, twin.parent))
            places = self.a.edge(joint), self.b.edge(twin, self._zeros().get(joint.name, 0.0))
            self._moved(JOINT, joint.name, joint.child, (joint.parent, twin.parent), places)
        elif source:
            places = self.a.relative(source, target), self.b.relative(source, target, self._zeros())
            self._moved(JOINT, joint.name, target, (source, source), places)
        if not has_axis(joint) or not has_axis(twin):
            return
        lines = self.a.line(joint, target), self.b.line(twin, target)
        item = _axis_item(joint, twin, target, lines, self.pairing.tolerance)
        if item is not None:
            self.items.append(self._with_effect(item, joint, twin, source) if source and same_kind else item)

    def _above_in_both(self, joint: Joint, target: str) -> str:
        """Return the nearest link above a joint that B has above the same frame, too; empty if there is none."""
        body: str | None = self.a.top[joint.parent]
        while body is not None:
            for name in (joint.parent, *self.a.members[body]):
                top = self.b.top.get(name)
                if top is not None and self.b.joints_between(top, self.b.top[target]):
                    return name
            body = self.a.above(body)
        return ""

    def _with_effect(self, item: Item, joint: Joint, twin: Joint, source: str) -> Item:
        """Return a change of an axis with how far it moves what is below the joint, and where that is largest."""
        below = [name for name in self.pairing.shared if self._below(joint, name, source)]
        worst, at, frame, angle = 0.0, 0.0, "", 0.0
        robots = self.a.without_followers, self.b.without_followers
        for position in positions_of(joint, twin):
            states = {joint.name: position}, {**self._zeros(), joint.name: position}
            poses = [robot.poses_in_root(state) for robot, state in zip(robots, states, strict=True)]
            back = [places[source].inverse() for places in poses]
            for name in below:
                one, other = (way.then(places[name]) for way, places in zip(back, poses, strict=True))
                distance, angle = math.dist(one.xyz, other.xyz), max(angle, one.angle_to(other))
                if not frame or distance > worst + 1e-12:
                    worst, at, frame = distance, position, name
        text = f"{item.text}: {frame} off by up to {far(worst, angle)} at {joint.name} = {number(at)}"
        text += f", only when {joint.name} is away from 0"
        name, quantity = item.name, item.quantity
        values = item.before, item.after, item.unit
        return Item(JOINT, name, quantity, text, *values, worst, angle, "away from 0", {joint.name: at})

    def _below(self, joint: Joint, name: str, source: str) -> bool:
        """Return True if a link is moved by a joint in both robots."""
        ways = [side.joints_between(side.top[source], side.top[name]) or [] for side in (self.a, self.b)]
        return all(joint.name in {one.name for one in way} for way in ways)

    def _moved_cluster(self, cluster: list[str], origin: str) -> None:
        """Add what became of a cluster, seen from its parent, or from the frame that its body is compared in."""
        head = cluster[0]
        joint = self.a.robot.joint_to.get(head)
        parent = joint.parent if joint is not None else ""
        is_fixed = all(parent in side.top and side.top[parent] == side.top[head] for side in (self.a, self.b))
        source = parent if is_fixed else origin
        places = self.a.relative(source, head), self.b.relative(source, head)
        self._moved(FRAME, head, head, (source, source), places, cluster[1:])

    def _moved(
        self,
        kind: str,
        name: str,
        frame: str,
        sources: tuple[str, str],
        places: tuple[Placed, Placed],
        others: Sequence[str] = (),
    ) -> None:
        """Add that a frame has another place, if it has; ``others`` are frames that went with it."""
        apart = gap(*places, self.pairing.tolerance)
        if apart.closed:
            return
        old, new = pose_of(places[0].transform), pose_of(places[1].transform)
        distance = apart.distance if apart.distance > apart.length_tolerance else 0.0
        angle = apart.angle if apart.angle > apart.angle_tolerance else 0.0
        near = Pose(old.xyz, near_angles(old.rpy, new.rpy)), new
        least = apart.length_tolerance, apart.angle_tolerance
        text = placed(frame, sources, near, (distance, angle), others, least)
        values = text_of(old), text_of(new)
        self.items.append(Item(kind, name, "origin", text, *values, "", distance, angle, "always"))


def _axis_item(joint: Joint, twin: Joint, frame: str, lines: tuple[Line, Line], tolerance: float) -> Item | None:
    """Return how the axis of a joint changed, seen from a frame that it moves; None if it did not."""
    angle, distance = turned(*lines, tolerance), shifted(*lines, tolerance)
    if angle:
        text = axis_change(joint.name, joint.axis, twin.axis, angle)
        return Item(JOINT, joint.name, "axis", text, row(lines[0].direction), row(lines[1].direction))
    if joint.type != "prismatic" and distance:
        text = f"{joint.name} axis moved {amount(distance, 'm')} in {frame}"
        return Item(JOINT, joint.name, "axis", text, row(lines[0].point), row(lines[1].point))
    return None


def _bounds(joint: Joint) -> tuple[float, float] | None:
    limit = joint.limit if joint.type != "continuous" else None
    return None if limit is None or limit.lower is None or limit.upper is None else (limit.lower, limit.upper)


def _shifts(joint: Joint, twin: Joint, sign: int) -> list[float]:
    """Return the shift of zero by which the limits differ; none without limits."""
    mine, theirs = _bounds(joint), _bounds(twin)
    shift = theirs[0] - (mine[0] if sign > 0 else -mine[1]) if mine and theirs else 0.0
    return [shift] if abs(shift) > _LEAST else []


def _follows(joint: Joint, twin: Joint, sign: int, shift: float) -> bool:
    """Return True if the limits of a joint of B are those of A as B counts."""
    mine, theirs = _bounds(joint), _bounds(twin)
    if mine is None or theirs is None:
        return mine is theirs
    ends = sorted(sign * end + shift for end in mine)
    allowed = _LEAST * max(1.0, *map(abs, span_of(joint)))
    return all(math.isclose(a, b, abs_tol=allowed) for a, b in zip(ends, theirs, strict=True))


def _elsewhere(pairing: Pairing) -> Iterator[Item]:
    """Yield the links that move with another body in B, each with those that go with it."""
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
