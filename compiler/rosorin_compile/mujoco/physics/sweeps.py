"""Move each joint alone over its range, from zero and from each named pose, and check which parts it drives together.

A part that a joint drives into its neighbour is a warning if a good part of one gets into the other over a good part of
the range, for then an axis or an origin is wrong, and a note if it is less: limits are often a little wider than the
parts allow. What a joint drives into parts that are not neighbours is one note: planners know how to avoid it.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from typing import NamedTuple

from rosorin_compile.model import Joint, Robot
from rosorin_compile.rules.case import Case
from rosorin_compile.source.diagnostics import NOTE, WARNING, Diagnostic, counted, first_of
from rosorin_compile.source.rule_registry import Heading, Rule

from .overlaps import CORNER, SHOWN, ZERO, State, shape_name, shape_path, split_accepted
from .scene import Overlap, Pair, Positions, Scene

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

STEP, MOST_STEPS = math.radians(5), 72  # of a hinge
SLIDE_STEPS = 24
MOST_STATES = 20_000  # of all sweeps together: then steps grow
GROWTH = 0.3  # of the volume of the part that moves: it is driven into the other one
BLOCKED = 0.25  # of the range: less is a limit that is too wide
_HALVINGS = 8


class Meeting(NamedTuple):
    """A joint that drives the second link of a pair into the first one.

    ``position`` (rad or m) is where that begins, ``end`` the end of the range behind it, ``side`` its limit ("lower" or
    "upper"), ``blocked`` the share of the range in which they overlap, ``inside`` the share of the moved link that gets
    into the other.
    """

    joint: Joint
    pair: Pair
    start: State
    position: float
    end: float
    overlap: Overlap
    blocked: float
    inside: float
    side: str


def range_of(joint: Joint) -> tuple[float, float] | None:
    """Return the range of a joint (rad or m): a turn for a hinge without limits, None for a slide without."""
    limit = joint.limit
    if joint.type != "continuous" and limit is not None and limit.lower is not None and limit.upper is not None:
        return (limit.lower, limit.upper) if limit.lower < limit.upper else None
    return (-math.pi, math.pi) if joint.type in ("revolute", "continuous") else None


def swept_joints(robot: Robot) -> list[tuple[Joint, tuple[float, float]]]:
    """Return the joints that move by themselves over a range, with the range."""
    moving = [joint for joint in robot.joints if joint.moves and joint.mimic is None]
    return [(joint, ends) for joint in moving if (ends := range_of(joint)) is not None]


def _step_count(joint: Joint, ends: tuple[float, float]) -> int:
    return SLIDE_STEPS if joint.type == "prismatic" else min(MOST_STEPS, math.ceil((ends[1] - ends[0]) / STEP))


def sweep(scene: Scene, states: Sequence[State], tick: Callable[[], None]) -> tuple[list[Meeting], set[Pair]]:
    """Move each joint alone from each state; return the first meetings, and the pairs that overlap in every position.

    Calls ``tick`` after each joint of each state.
    """
    joints = swept_joints(scene.robot)
    factor = min(1.0, MOST_STATES / max(1, len(states) * sum(_step_count(*one) for one in joints)))
    always = set.intersection(*(set(state.overlaps) for state in states))
    meetings: dict[tuple[str, Pair], Meeting] = {}
    for state in states:
        for joint, ends in joints:
            swept = _Sweep(scene, state, joint, ends, max(2, round(factor * _step_count(joint, ends))))
            always &= swept.always
            for meeting in swept.meetings():
                meetings.setdefault((joint.name, meeting.pair), meeting)
            tick()
    return list(meetings.values()), always


class _Sweep:
    """The overlaps along the way of one joint from a state to both ends of its range."""

    def __init__(self, scene: Scene, state: State, joint: Joint, ends: tuple[float, float], steps: int) -> None:
        self.scene, self.state, self.joint, self.ends = scene, state, joint, ends
        self.start = state.positions.get(joint.name, 0.0)
        every = [ends[0] + (ends[1] - ends[0]) * index / steps for index in range(steps + 1)]
        # From the start to each end; a start outside the range is left at once.
        self.ways = ([p for p in reversed(every) if p < self.start], [p for p in every if p > self.start])
        self.positions = [*self.ways[0], *self.ways[1]]
        rows = scene.rows([self._at(position) for position in self.positions])
        self.overlaps = dict(zip(self.positions, map(scene.overlaps_at, rows), strict=True))
        self.always = set(state.overlaps).intersection(*map(set, self.overlaps.values()))

    def _at(self, position: float) -> Positions:
        return {**self.state.positions, self.joint.name: position}

    def meetings(self) -> Iterator[Meeting]:
        """Yield the pairs of links that the joint moves into each other; adjacent links only if they overlap more."""
        below = set(self.scene.robot.below(self.joint.child))
        for pair in dict.fromkeys(pair for overlaps in self.overlaps.values() for pair in overlaps):
            is_neighbour, least = self.scene.joint_of(pair) == self.joint, 0.0
            if pair in self.state.overlaps:
                least = self._share(pair, self.start) + GROWTH if is_neighbour else 1.0
                if least >= 1:
                    continue
            hits = [position for position in self.positions if self._is_driven(pair, position, least)]
            if not hits:
                continue
            firsts = [next((i for i, p in enumerate(way) if p in hits), len(self.positions)) for way in self.ways]
            side = firsts.index(min(firsts))
            way, index = self.ways[side], firsts[side]
            overlap = self.overlaps[way[index]][pair]
            inside = max(self._share(pair, position) for position in hits) if is_neighbour else 0.0
            yield Meeting(
                self.joint,
                pair if pair[1] in below else (pair[1], pair[0]),
                self.state,
                self._begin(pair, least, way[index - 1] if index else self.start, way[index]),
                self.ends[side],
                overlap if pair[1] in below else Overlap(overlap.depth, overlap.other, overlap.one),
                len(hits) / len(self.positions),
                inside - max(0.0, least - GROWTH),
                ("lower", "upper")[side],
            )

    def _is_driven(self, pair: Pair, position: float, least: float) -> bool:
        """Return True if a pair overlaps at a position with a share of ``least``; 0 is any overlap."""
        if position not in self.overlaps:
            self.overlaps[position] = self.scene.overlaps(self._at(position))
        return pair in self.overlaps[position] and (not least or self._share(pair, position) >= least)

    def _share(self, pair: Pair, position: float) -> float:
        """Return how much of the moved link of two neighbours is inside the other one."""
        is_first = self.scene.top[pair[0]] == self.scene.top[self.joint.child]
        moved, other = pair if is_first else (pair[1], pair[0])
        return self.scene.share(moved, other, self._at(position))

    def _begin(self, pair: Pair, least: float, near: float, far: float) -> float:
        """Return where between two positions a pair begins to overlap (rad or m)."""
        for _ in range(_HALVINGS):
            middle = (near + far) / 2
            near, far = (near, middle) if self._is_driven(pair, middle, least) else (middle, far)
        return far


def check_sweeps(case: Case, scene: Scene, meetings: Sequence[Meeting]) -> Iterator[Diagnostic]:
    """Yield diagnostics for what the joints drive into each other: neighbours one by one, warnings first."""
    near = [one for one in meetings if scene.joint_of(one.pair) == one.joint]
    found = [_through_neighbour(case, scene, one) for one in near if one.inside >= CORNER]
    yield from sorted(found, key=lambda one: one.severity != WARNING)
    far = [one for one in meetings if one not in near]
    accepted, rest = split_accepted(case, "joints-meet-parts", far, lambda one: (one.joint.name, *one.pair))
    yield from accepted
    if rest:
        firsts: dict[str, Meeting] = {}
        for one in rest:
            firsts.setdefault(one.joint.name, one)
        texts = [f"{name} {one.pair[1]} into {one.pair[0]} from {_position(one)}" for name, one in firsts.items()]
        verb = "drives a part" if len(texts) == 1 else "drive parts, each alone,"
        message = f"{counted(len(texts), 'joint')} {verb} into others that are not neighbours: {first_of(texts, SHOWN)}"
        help = "a planner has to know; narrower limits, or disabled_contacts for a pair that is meant to touch"
        path = case.joint(rest[0].joint, "limit", rest[0].side)
        note = case.problem("joints-meet-parts", message, path, help, severity=NOTE)
        yield replace(note, related=(), of=tuple(firsts))


def _through_neighbour(case: Case, scene: Scene, met: Meeting) -> Diagnostic:
    """Return a warning about a real collision in a good part of the range, else a note."""
    is_grave = met.inside >= GROWTH and met.blocked >= BLOCKED and _is_real(scene, met)
    (parent, child), outer, inner = met.pair, met.overlap.one, met.overlap.other
    message = (
        f'joint "{met.joint.name}" drives link "{child}" into link "{parent}" from {_position(met, full=True)},'
        f" {met.blocked:.0%} of its range: {shape_name(case, inner)} into {shape_name(case, outer)}"
    )
    help = "check the axis, its sign and the limits; disabled_contacts names a pair that is meant to touch"
    related = [case.related(f'the shape of "{solid.link}"', shape_path(case, solid)) for solid in (inner, outer)]
    path, severity = case.joint(met.joint, "limit", met.side), WARNING if is_grave else NOTE
    return case.problem("joint-through-neighbour", message, path, help, related=related, severity=severity)


def _is_real(scene: Scene, met: Meeting) -> bool:
    """Return True if more than the hulls of meshes overlap somewhere beyond the position where it begins."""
    for part in range(4):
        position = met.position + (met.end - met.position) * part / 3
        state = {**met.start.positions, met.joint.name: position}
        overlaps = scene.overlaps(state)
        overlap = overlaps.get(met.pair) or overlaps.get((met.pair[1], met.pair[0]))
        if overlap is not None and scene.touches(overlap, state):
            return True
    return False


def _position(met: Meeting, full: bool = False) -> str:
    """Return where a meeting begins; ``full``: also in which direction it goes on."""
    if met.joint.type == "prismatic":
        text = f"{float(f'{met.position:.3g}'):.6g} m"
    else:
        text = f"{round(met.position, 2):.6g} rad ({math.degrees(met.position):.0f} deg)"
    direction = {"upper": " up", "lower": " down"}[met.side] if full else ""
    return f"{text}{direction}{f' {met.start}' if met.start.name != ZERO else ''}"
