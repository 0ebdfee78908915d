"""Each joint moved alone over its range, from zero and from each named pose: where it drives a part into another one.

A part that a joint drives into its neighbour is told, with the position at which it begins: a warning where a good part
of one gets into the other over a good part of the range, for then an axis or an origin is wrong; a note where it is
less: limits are often a little wider than the parts allow. A corner that gets into the neighbour is how boxes around
the parts of a finger are. What a joint drives into parts that are no neighbours is in one note: planners know how to
avoid it.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import NamedTuple

from rosorin_compile.model import Joint, Robot
from rosorin_compile.rules.case import Case
from rosorin_compile.source.diagnostics import NOTE, WARNING, Diagnostic, and_more, counted
from rosorin_compile.source.rule_registry import Heading, Rule

from .accepted import apart
from .overlaps import CORNER, ZERO, State, at_most, shape_path, shape_word
from .scene import Overlap, Pair, Scene

RULES = (
    Rule(
        "joint-through-neighbour",
        "A joint drives its part into the part that it hangs on. A warning where a third of its volume gets into the "
        "other over a quarter of the range; a note where it is a fifth of its volume, or at the end of the range.",
        "Check the axis, its sign and the limits.",
        Heading.PHYSICS,
    ),
    Rule(
        "joints-meet-parts",
        "A note: joints, each alone, drive a part into one that is not its neighbour.",
        "Let a planner know; narrower limits, or `disabled_contacts` for a pair that is meant to touch.",
        Heading.PHYSICS,
    ),
)

STEP = math.radians(5)
MOST_STEPS = 72
SLIDE_STEPS = 24
MOST_STATES = 20_000  # of all sweeps together: then steps grow
GROWTH = 0.3  # of the volume of the part that moves: it is driven into the other one
BLOCKED = 0.25  # of the range: less is a limit that is too wide
_HALVINGS = 8
_SHOWN = 5


class Meeting(NamedTuple):
    """A joint that drives two links into each other: from which state, where it begins (rad or m), and how it is there.

    ``pair`` has the one that the joint moves last. ``blocked`` is the share of the range in which they overlap,
    ``inside`` that of the moved one that gets into the other, ``upper`` says on which side of the start it is.
    """

    joint: Joint
    pair: Pair
    start: State
    position: float
    overlap: Overlap
    blocked: float
    inside: float
    upper: bool

    def turned(self) -> Meeting:
        """Return the same with the two links the other way round."""
        overlap = self.overlap._replace(one=self.overlap.other, other=self.overlap.one)
        return self._replace(pair=(self.pair[1], self.pair[0]), overlap=overlap)


class Swept(NamedTuple):
    """What the sweeps met, and the pairs that overlapped in every position of all of them."""

    meetings: list[Meeting]
    always: set[Pair]


def ends_of(joint: Joint) -> tuple[float, float] | None:
    """Return the range of a joint (rad or m): a turn where a hinge has no limit; None for a slide without."""
    limit = joint.limit
    if joint.type != "continuous" and limit is not None and limit.lower is not None and limit.upper is not None:
        return (limit.lower, limit.upper) if limit.lower < limit.upper else None
    return (-math.pi, math.pi) if joint.type in ("revolute", "continuous") else None


def swept_joints(robot: Robot) -> list[Joint]:
    """Return the joints that move by themselves over a range."""
    return [joint for joint in robot.joints if joint.moves and joint.mimic is None and ends_of(joint)]


def steps_of(joint: Joint, factor: float = 1.0) -> int:
    """Return in how many steps the range of a joint is gone through."""
    lower, upper = ends_of(joint) or (0.0, 0.0)
    steps = SLIDE_STEPS if joint.type == "prismatic" else min(MOST_STEPS, math.ceil((upper - lower) / STEP))
    return max(2, round(steps * factor))


def sweep(scene: Scene, states: Sequence[State], tick: Callable[[], None]) -> Swept:
    """Move each joint alone from each state; ``tick`` is told each joint of each state that is done."""
    joints = swept_joints(scene.robot)
    factor = min(1.0, MOST_STATES / max(1, len(states) * sum(map(steps_of, joints))))
    always = set.intersection(*(set(state.overlaps) for state in states))
    found: dict[tuple[str, Pair], Meeting] = {}
    moved = {joint.name: set(scene.robot.below(joint.child)) for joint in joints}
    for state in states:
        for joint in joints:
            one = _Sweep(scene, state, joint, steps_of(joint, factor))
            always &= one.always
            for meeting in one.meetings():
                turned = meeting.pair[0] in moved[joint.name]
                found.setdefault((joint.name, meeting.pair), meeting.turned() if turned else meeting)
            tick()
    return Swept(list(found.values()), always)


class _Sweep:
    """One joint, moved alone from one state to both ends of its range."""

    def __init__(self, scene: Scene, state: State, joint: Joint, steps: int) -> None:
        self.scene, self.state, self.joint = scene, state, joint
        lower, upper = ends_of(joint) or (0.0, 0.0)
        self.begin = state.positions.get(joint.name, 0.0)
        inner = [lower + (upper - lower) * index / steps for index in range(steps + 1)]
        # From the start to each end; a start outside the range is left at once.
        self.ways = [[p for p in reversed(inner) if p < self.begin], [p for p in inner if p > self.begin]]
        self.found = [[self.overlaps(position) for position in way] for way in self.ways]
        self.always = set(state.overlaps).intersection(*(set(one) for way in self.found for one in way))

    def overlaps(self, position: float) -> Mapping[Pair, Overlap]:
        return self.scene.overlaps(self.at(position))

    def at(self, position: float) -> dict[str, float]:
        return {**self.state.positions, self.joint.name: position}

    def meetings(self) -> list[Meeting]:
        """Return the pairs that the joint drives into each other, or further into each other."""
        met = []
        pairs = dict.fromkeys(pair for way in self.found for one in way for pair in one)
        for pair in pairs:
            is_neighbour = self.scene.joint_of(pair) == self.joint
            if pair not in self.state.overlaps:
                met.append(self._new(pair, is_neighbour))
            elif is_neighbour:
                deeper = self._deeper(pair)
                met += [deeper] if deeper else []
        return met

    def _new(self, pair: Pair, is_neighbour: bool) -> Meeting:
        """Return how two links meet that are apart at the start."""
        side = min((0, 1), key=lambda side: self._first(side, pair))
        index = self._first(side, pair)
        position = self._begins(side, index, lambda where: pair in self.overlaps(where))
        inside = max(self._shares(pair)) if is_neighbour else 0.0  # of the part that moves
        overlap = self.found[side][index][pair]
        return Meeting(self.joint, pair, self.state, position, overlap, self._blocked(pair), inside, bool(side))

    def _deeper(self, pair: Pair) -> Meeting | None:
        """Return how a joint drives a part into its neighbour that overlaps with it from the start."""
        before = self._share(pair, self.begin)
        if before > 1 - GROWTH:
            return None
        for side, way in enumerate(self.ways):
            shares = [self._share(pair, p) if pair in self.found[side][i] else 0.0 for i, p in enumerate(way)]
            if not shares or max(shares) < before + GROWTH:
                continue
            index = next(i for i, share in enumerate(shares) if share >= before + GROWTH)
            position = self._begins(side, index, lambda where: self._share(pair, where) >= before + GROWTH)
            overlap = self.found[side][index][pair]
            blocked = sum(share >= before + GROWTH for share in shares) / sum(map(len, self.ways))
            return Meeting(self.joint, pair, self.state, position, overlap, blocked, max(shares) - before, bool(side))
        return None

    def _first(self, side: int, pair: Pair) -> int:
        return next((index for index, one in enumerate(self.found[side]) if pair in one), MOST_STEPS + 1)

    def _begins(self, side: int, index: int, is_so: Callable[[float], bool]) -> float:
        """Return where something begins between two steps (rad or m)."""
        far, near = self.ways[side][index], self.ways[side][index - 1] if index else self.begin
        for _ in range(_HALVINGS):
            middle = (near + far) / 2
            near, far = (near, middle) if is_so(middle) else (middle, far)
        return far

    def _blocked(self, pair: Pair) -> float:
        every = [pair in one for way in self.found for one in way]
        return sum(every) / len(every)

    def _shares(self, pair: Pair) -> list[float]:
        """Return how much of the moved one is inside the other, at each step at which they overlap."""
        steps = zip((p for way in self.ways for p in way), (one for way in self.found for one in way), strict=True)
        return [self._share(pair, position) for position, one in steps if pair in one]

    def _share(self, pair: Pair, position: float) -> float:
        one, other = pair if self.scene.body_of[pair[0]] == self.scene.body_of[self.joint.child] else (pair[1], pair[0])
        return self.scene.share(one, other, self.at(position))


def diagnose_sweeps(case: Case, scene: Scene, meetings: Sequence[Meeting]) -> list[Diagnostic]:
    """Return what is to say about what the joints meet."""
    near = [one for one in meetings if scene.joint_of(one.pair) == one.joint]
    found = [_neighbour(case, one, _is_real(scene, one)) for one in near if one.inside >= CORNER]
    found.sort(key=lambda one: one.severity != WARNING)
    return [*at_most(case, found), *_others(case, [one for one in meetings if one not in near])]


def _is_real(scene: Scene, met: Meeting) -> bool:
    """Say whether more than the hulls of meshes meet, somewhere in the range beyond the position where it begins."""
    ends = ends_of(met.joint) or (0.0, 0.0)
    far = ends[1] if met.upper else ends[0]
    for part in range(4):
        state = {**met.start.positions, met.joint.name: met.position + (far - met.position) * part / 3}
        overlap = scene.overlaps(state).get(met.pair) or scene.overlaps(state).get((met.pair[1], met.pair[0]))
        if overlap is not None and scene.touches(overlap, state):
            return True
    return False


def _neighbour(case: Case, met: Meeting, is_real: bool) -> Diagnostic:
    grave = is_real and met.inside >= GROWTH and met.blocked >= BLOCKED
    joint, (parent, child) = met.joint, met.pair
    apart = f", {met.blocked:.0%} of its range" if met.blocked else ""
    message = (
        f'joint "{joint.name}" drives link "{child}" into link "{parent}" from {_position(joint, met.position)}'
        f" {'up' if met.upper else 'down'}{_start(met.start)}{apart}:"
        f" {shape_word(case, met.overlap.other)} into {shape_word(case, met.overlap.one)}"
    )
    help = "check the axis, its sign and the limits; disabled_contacts names a pair that is meant to touch"
    path = case.joint(joint, "limit", "upper" if met.upper else "lower")
    shapes = (met.overlap.other, met.overlap.one)
    related = [case.related(f'the shape of "{solid.link}"', shape_path(case, solid)) for solid in shapes]
    severity = WARNING if grave else NOTE
    made = case.problem("joint-through-neighbour", message, path, help, related=related, severity=severity)
    return replace(made, numbers=(("position", met.position), ("blocked", met.blocked), ("inside", met.inside)))


def _others(case: Case, meetings: Sequence[Meeting]) -> list[Diagnostic]:
    taken, left = apart(case, "joints-meet-parts", meetings, lambda one: (one.joint.name, *one.pair))
    if not left:
        return taken
    first: dict[str, Meeting] = {}
    for one in left:
        first.setdefault(one.joint.name, one)
    named = [
        f"{name} {one.pair[1]} into {one.pair[0]} from {_position(one.joint, one.position)}{_start(one.start)}"
        for name, one in first.items()
    ]
    verb = "drives a part" if len(first) == 1 else "drive parts, each alone,"
    message = (
        f"{counted(len(first), 'joint')} {verb} into others that are no neighbours: {'; '.join(named[:_SHOWN])}"
        f"{and_more(len(named) - _SHOWN)}"
    )
    one = next(iter(first.values()))
    path = case.joint(one.joint, "limit", "upper" if one.upper else "lower")
    help = "a planner has to know; narrower limits, or disabled_contacts for a pair that is meant to touch"
    found = case.problem("joints-meet-parts", message, path, help, severity=NOTE)
    return [replace(found, related=(), of=tuple(first)), *taken]


def _position(joint: Joint, position: float) -> str:
    if joint.type == "prismatic":
        return f"{float(f'{position:.3g}'):.6g} m"
    return f"{round(position, 2):.6g} rad ({math.degrees(position):.0f} deg)"


def _start(state: State) -> str:
    return f' in pose "{state.name}"' if state.name != ZERO else ""
