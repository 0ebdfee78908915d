"""Frames: where each link of both robots sits, told once for all that moved together.

Frames of one body that sit to each other as they did are a cluster. A cluster is in its place if it is so against
some cluster of its body or of a body above, at all positions of the joints between.

``furthest`` is the frame that is off the most, all differences together, and in which state.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from typing import NamedTuple

from rosorin_compile.model import Joint, Pose
from rosorin_compile.model.geometry import pose_of
from rosorin_compile.source.progress import Progress
from rosorin_compile.source.wording import first_of

from .bodies import Bodies, Gap, gap, positions_of, states_of, whole_states
from .difference import FRAME, JOINT, Item
from .joints import Coordinate, Coordinates, axis_item, coordinate_of
from .pairing import Pairing
from .precision import Placed
from .sentences import About, far, near_angles, number, placed, several, text_of, value_change


class Frames(NamedTuple):
    """What differs in frames, and what the comparison of other things builds on.

    ``clusters`` are those of each shared body of A, the one that its shapes and masses are compared in first;
    ``coordinates`` are joints whose positions count otherwise.
    """

    items: list[Item]
    notes: list[str]
    clusters: Mapping[str, list[list[str]]]
    coordinates: Mapping[str, Coordinate]


def compare_frames(pairing: Pairing) -> Frames:
    """Return which frames moved, by how much, and at which positions of the joints."""
    work = _Frames(pairing)
    for index, top in enumerate(pairing.bodies):
        Progress.step("comparing frames", index, len(pairing.bodies))
        work.body(top)
    work.items += _elsewhere(pairing)
    return Frames(work.items, work.notes, work.clusters, work.coordinates)


class _Frames:
    """Goes through the bodies of A from the root down; collects what differs."""

    def __init__(self, pairing: Pairing) -> None:
        self.pairing = pairing
        self.a, self.b = pairing.a, pairing.b
        self.items: list[Item] = []
        self.notes: list[str] = []
        self.clusters: dict[str, list[list[str]]] = {}
        self.moved: set[str] = set()
        self.coordinates: dict[str, Coordinate] = {}

    def body(self, top: str) -> None:
        """Compare one body with the bodies above it, then its own clusters."""
        goal = self.pairing.bodies[top]
        shared = [name for name in self.a.members[top] if self.b.top.get(name) == goal]
        clusters = self._clusters(shared)
        self.clusters[top] = clusters
        joint, twin = self.pairing.pair_of_joints(top)
        first = clusters[0]
        if joint is not None and twin is not None and self._kind(joint) == self._kind(twin):
            known = coordinate_of(joint, twin, lambda trial: self._anchored(clusters, top, trial))
            if known is not None:
                self._counts(known)
            in_place = self._in_place(clusters, top, self.coordinates)
            if in_place:
                first = in_place[0]
            else:
                first = next((cluster for cluster in clusters if joint.child in cluster), clusters[0])
                self.moved.add(top)
                self._moved_joint(joint, twin, first)
            left = [cluster for cluster in clusters if cluster is not first and cluster not in in_place]
        else:
            if joint is not None and twin is not None:
                self._retyped(joint, twin, first)
            left = clusters[1:]
        # Shapes and masses are compared in the cluster that comes first.
        self.clusters[top] = [first, *(cluster for cluster in clusters if cluster is not first)]
        self.items += [self._moved_cluster(cluster, first) for cluster in left]

    def _kind(self, joint: Joint) -> str:
        """Return how a joint moves; a joint that turns does so with limits and without."""
        return "turns" if joint.type in ("revolute", "continuous") else joint.type

    def _clusters(self, names: Sequence[str]) -> list[list[str]]:
        """Return the clusters of a body; that of the root, or the largest one, comes first."""
        found: list[list[str]] = []
        for name in names:
            parent = self.a.robot.joint_to[name].parent if name in self.a.robot.joint_to else ""
            # Seen from its parent a frame is known best: what differs there is not made up for by rounding further off.
            near = next((cluster for cluster in found if parent in cluster), None)
            if near is not None and self._gap(parent, name, {}).closed:
                near.append(name)
                continue
            others = (cluster for cluster in found if cluster is not near)
            home = next((cluster for cluster in others if self._gap(cluster[0], name, {}).closed), None)
            if home is None:
                found.append([name])
            else:
                home.append(name)
        root = self.a.robot.root
        return sorted(found, key=lambda cluster: (root not in cluster, -len(cluster)))

    def _gap(self, source: str, target: str, state: Mapping[str, float], trial: Coordinates | None = None) -> Gap:
        """Return how far a frame is apart in the two robots, seen from another one, at positions of A's joints."""
        known = self.coordinates if trial is None else trial
        twin = {name: known[name].of(value) if name in known else value for name, value in state.items()}
        for name in known:
            twin.setdefault(name, known[name].of(0.0))
        one, other = self.a.relative(source, target, state), self.b.relative(source, target, twin)
        return gap(one, other, self.pairing.tolerance)

    def _anchored(self, clusters: list[list[str]], top: str, trial: Coordinate | None) -> bool:
        known = self.coordinates if trial is None else {**self.coordinates, trial.joint: trial}
        return bool(self._in_place(clusters, top, known))

    def _in_place(self, clusters: list[list[str]], top: str, known: Coordinates) -> list[list[str]]:
        """Return the clusters of a body that are in their place against the body above, or one further up.

        Further up counts only where the body above moved itself: over a long way rounding adds up.
        """
        upper = self.a.above(top)
        while upper is not None:
            if upper in self.clusters:
                joint = self.a.robot.joint_to[top]
                ends = [(joint.parent if joint.parent in o else o[0]) for o in self.clusters[upper]]
                goals = {id(c): joint.child if joint.child in c else c[0] for c in clusters}
                found = [c for c in clusters if any(self._agree(end, goals[id(c)], known) for end in ends)]
                if found or upper not in self.moved:
                    return found
            upper = self.a.above(upper)
        return []

    def _agree(self, source: str, target: str, known: Coordinates) -> bool:
        joints = self.a.joints_between(self.a.top[source], self.a.top[target])
        same = self.b.joints_between(self.b.top[source], self.b.top[target])
        if joints is None or same is None:
            return False
        pairs = [(joint, self.b.robot.joint.get(joint.name)) for joint in joints if joint.moves]
        return all(self._gap(source, target, state, known).closed for state in states_of(pairs))

    def _counts(self, known: Coordinate) -> None:
        self.coordinates[known.joint] = known
        self.items.append(known.item())

    def _moved_joint(self, joint: Joint, twin: Joint, cluster: list[str]) -> None:
        """Say what became of a joint whose body is nowhere in its place: where it sits, and its axis."""
        upper = self.a.top[joint.parent]
        if self.pairing.bodies.get(upper) != self.b.top[twin.parent]:
            text = value_change(About(joint.child, "parent"), joint.parent, twin.parent).text
            self.items.append(Item(JOINT, joint.name, "parent", text, joint.parent, twin.parent))
            self._hung(joint, twin, cluster)
            return
        near = next((c for c in self.clusters[upper] if joint.parent in c), self.clusters[upper][0])
        source = joint.parent if joint.parent in near else near[0]
        target = joint.child if joint.child in cluster else cluster[0]
        zero = self._gap(source, target, {})
        if not zero.closed:
            places = self.a.relative(source, target, {}), self.b.relative(source, target, self._zeros())
            self.items.append(_moved((JOINT, joint.name), target, (source, source), places, zero, []))
        axis = axis_item(self.pairing, joint, twin, target)
        if axis is not None:
            self.items.append(self._effect(axis, joint, twin, (source, target)))
        elif zero.closed:
            text = f"{joint.name}: {target} moves otherwise in {source}"
            self.items.append(self._effect(Item(JOINT, joint.name, "motion", text), joint, twin, (source, target)))

    def _retyped(self, joint: Joint, twin: Joint, cluster: list[str]) -> None:
        """Say what else became of a joint that moves otherwise, or hangs on another body: where it sits, its axis."""
        target = joint.child if joint.child in cluster else cluster[0]
        source = self._above_in_both(joint, target)
        zero = self._gap(source, target, {}) if source else None
        if zero is not None and not zero.closed:
            places = self.a.relative(source, target, {}), self.b.relative(source, target, self._zeros())
            self.items.append(_moved((JOINT, joint.name), target, (source, source), places, zero, []))
        axis = axis_item(self.pairing, joint, twin, target)
        self.items += [] if axis is None else [axis]

    def _hung(self, joint: Joint, twin: Joint, cluster: list[str]) -> None:
        """Say what else became of a joint that hangs on another body: where it sits on what it hangs on, its axis."""
        target = joint.child if joint.child in cluster else cluster[0]
        places = self.a.edge(joint, 0.0), self.b.edge(twin, self._zeros().get(joint.name, 0.0))
        apart = gap(*places, self.pairing.tolerance)
        if not apart.closed:
            self.items.append(_moved((JOINT, joint.name), joint.child, (joint.parent, twin.parent), places, apart, []))
        axis = axis_item(self.pairing, joint, twin, target)
        self.items += [] if axis is None else [axis]

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

    def _zeros(self) -> dict[str, float]:
        return {name: coordinate.of(0.0) for name, coordinate in self.coordinates.items()}

    def _effect(self, item: Item, joint: Joint, twin: Joint, ends: tuple[str, str]) -> Item:
        """Return a change of an axis with how far it moves what hangs on the joint, and where that is largest.

        ``ends`` are a frame above the joint and one that it moves.
        """
        source, target = ends
        below = [name for name in self.pairing.shared if self._below(joint, name, source)]
        held = {
            name: (self.a.relative(target, name, {}), self.b.relative(target, name, self._zeros())) for name in below
        }
        worst, at, frame, turn = 0.0, 0.0, "", 0.0
        for position in positions_of(joint, twin):
            first = self.a.relative(source, target, {joint.name: position})
            second = self.b.relative(source, target, {**self._zeros(), joint.name: position})
            for name, (one, other) in held.items():
                found = gap(first.then(one), second.then(other), self.pairing.tolerance)
                turn = max(turn, found.angle)
                if not frame or found.distance > worst + 1e-12:
                    worst, at, frame = found.distance, position, name
        text = f"{item.text}: {frame} off by up to {far(worst, turn)} at {joint.name} = {number(at)}"
        return Item(
            item.kind,
            item.name,
            item.quantity,
            f"{text}, only when {joint.name} is away from 0",
            item.before,
            item.after,
            item.unit,
            worst,
            turn,
            "away from 0",
            {joint.name: at},
        )

    def _below(self, joint: Joint, name: str, source: str) -> bool:
        """Say whether a link hangs on a joint in both robots."""
        one = self.a.joints_between(self.a.top[source], self.a.top[name])
        other = self.b.joints_between(self.b.top[source], self.b.top[name])
        return bool(one and other and joint.name in {j.name for j in one} & {j.name for j in other})

    def _moved_cluster(self, cluster: list[str], first: list[str]) -> Item:
        """Return what became of a cluster against the one that its body is compared in."""
        head = cluster[0]
        parent = self.a.robot.joint_to[head].parent if head in self.a.robot.joint_to else ""
        fixed = all(parent in side.top and side.top[parent] == side.top[head] for side in (self.a, self.b))
        source = parent if fixed else first[0]
        places = self.a.relative(source, head, {}), self.b.relative(source, head, {})
        return _moved((FRAME, head), head, (source, source), places, self._gap(source, head, {}), cluster[1:])


def _moved(
    about: tuple[str, str],
    frame: str,
    source: tuple[str, str],
    places: tuple[Placed, Placed],
    apart: Gap,
    others: list[str],
) -> Item:
    """Return the item about something (its kind and name) that sits elsewhere at every position of the joints."""
    poses = pose_of(places[0].transform), pose_of(places[1].transform)
    distance = apart.distance if apart.distance > apart.length_tolerance else 0.0
    angle = apart.angle if apart.angle > apart.angle_tolerance else 0.0
    least = apart.length_tolerance, apart.angle_tolerance
    near = Pose(poses[0].xyz, near_angles(poses[0].rpy, poses[1].rpy)), poses[1]
    text = placed(frame, source, near, (distance, angle), others, least).text
    return Item(*about, "origin", text, text_of(poses[0]), text_of(poses[1]), "", distance, angle, "always")


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
        text = f"{names[0]}: {before} -> {after}{with_it}"
        yield Item(FRAME, names[0], "body", text, before, after)


def _moved_by(bodies: Bodies, top: str) -> str:
    joint = bodies.entering(top)
    return f"moves with {joint.name}" if joint is not None else f"fixed to {bodies.robot.root}"


_MOST = 4
# What is no gain (m, rad): the same frame is not to be named for rounding.
_LEAST = 1e-6


def furthest(pairing: Pairing, coordinates: Coordinates, items: Sequence[Item]) -> list[str]:
    """Return a sentence on the frame that is off the most over many states.

    Nothing if none is, or if one of the differences alone says as much.
    """
    a, b = pairing.a.robot, pairing.b.robot
    root = a.root if a.root in b.link else next(iter(pairing.shared), "")
    best: tuple[float, float, str, dict[str, float]] = (0.0, 0.0, "", {})
    zeros = {name: coordinate.of(0.0) for name, coordinate in coordinates.items()}
    states = whole_states(a, b)
    for index, state in enumerate(states):
        Progress.step("comparing states", index, len(states))
        counted = {name: coordinates[name].of(value) if name in coordinates else value for name, value in state.items()}
        first = a.poses_in_root(state)
        # A follower of B follows its own leader.
        second = b.poses_in_root({**zeros, **counted})
        back = first[root].inverse(), second[root].inverse()
        for name in pairing.shared:
            one, other = (way.then(poses[name]) for way, poses in zip(back, (first, second), strict=True))
            distance, angle = math.dist(one.xyz, other.xyz), one.angle_to(other)
            if distance > best[0] + _LEAST or (not best[0] and angle > best[1] + _LEAST):
                best = (distance, angle, name, state)
    distance, angle, name, state = best
    if not name or any((i.distance or 0) >= 0.999 * distance and (i.angle or 0) >= 0.999 * angle for i in items):
        return []
    moved = [f"{joint} = {number(round(value, 3))}" for joint, value in state.items() if abs(value) > 1e-3]
    at = f" at {first_of(moved, _MOST)}" if moved else " with all joints at 0"
    return [f"all together: {name} is off by up to {far(distance, angle)} in {root}{at}"]
