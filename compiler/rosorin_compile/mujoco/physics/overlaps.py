"""Check which parts are inside each other at zero and in the named poses, and which of them the joints drive together.

Neighbours overlap at their joint in most robots: a cover, a shared housing, a shaft in its bearing. What overlaps in
every position that was tried, and not in full, is taken for a design and reported in one note, and so are neighbours of
which a corner is in the other one. Every other pair is reported with the shapes, the depth and the poses.

Each joint is moved alone over its range, from zero and from each named pose. A part that it drives into its neighbour
is a warning if a good part of one gets into the other over a good part of the range, for then an axis or an origin is
wrong, and a note if it is less: limits are often a little wider than the parts allow. What a joint drives into parts
that are not neighbours is one note: planners know how to avoid it.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence, Set
from dataclasses import replace
from typing import NamedTuple

from rosorin_compile.model import Joint, Mesh, Robot
from rosorin_compile.rules.case import Case
from rosorin_compile.rules.check import accepts
from rosorin_compile.source.diagnostics import NOTE, WARNING, Diagnostic, first_of, quoted
from rosorin_compile.source.rule_registry import DECLARED, PHYSICS, Rule
from rosorin_compile.source.tree import Path

from ..rest_pose import nearest_to_zero, range_of
from .scene import Overlap, Pair, Positions, Scene
from .solids import Solid

RULES = (
    Rule(
        "parts-overlap",
        "A warning: two parts are inside each other, at zero or in a named pose, and not in every position (a note, "
        "where zero is beyond the limits of a joint). A simulation pushes them apart in its first step.",
        "Correct a shape, a joint or the pose; a pair that is meant to touch goes under `disabled_contacts`.",
        PHYSICS,
    ),
    Rule(
        "part-inside-part",
        "A warning: a part is inside another one with most of its volume.",
        "Correct a shape, a joint or the pose; a pair that is meant to touch goes under `disabled_contacts`.",
        PHYSICS,
    ),
    Rule(
        "hulls-overlap",
        "A note: the convex hulls of meshes overlap, at zero or in a named pose, though the meshes do not touch. A "
        "simulation that takes hulls pushes the parts apart.",
        "Several convex shapes in place of the mesh; or the pair under `disabled_contacts`.",
        PHYSICS,
    ),
    Rule(
        "parts-always-overlap",
        "A note: parts overlap in every position that was tried, or neighbours a little at their joint, as parts do "
        "that are built into each other.",
        "Nothing, if they are; else move them.",
        PHYSICS,
    ),
    Rule(
        "joint-through-neighbour",
        "A joint drives its part into the part that it hangs on. A warning where a third of its volume gets into the "
        "other over a quarter of the range; a note where it is a fifth of its volume, or at the end of the range.",
        "Check the axis, its sign and the limits; a pair that is meant to touch goes under `disabled_contacts`.",
        PHYSICS,
    ),
    Rule(
        "joints-meet-parts",
        "A note: joints, each alone, drive a part into one that is not its neighbour.",
        "Plan around it, or narrow the limits; a pair that is meant to touch goes under `disabled_contacts`.",
        PHYSICS,
    ),
)
DECLARED.update({rule.id: rule for rule in RULES})

ZERO = ""  # the name of the state in which every joint is at zero
MOST_INSIDE = 0.9  # of its volume: no bearing and no cover holds a part like that
CORNER = 0.2  # of its volume: less is a corner at a joint
SHOWN = 5  # names in a note
STEP, MOST_STEPS = math.radians(5), 72  # of a hinge
SLIDE_STEPS = 24
MOST_STATES = 20_000  # of all sweeps together: then steps grow
GROWTH = 0.3  # of the volume of the part that moves: it is driven into the other one
BLOCKED = 0.25  # of the range: less is a limit that is too wide
_HALVINGS = 8


class State(NamedTuple):
    """Joint positions (rad or m) at which the robot rests, "zero" or a named pose, and the overlaps there."""

    name: str
    positions: Positions
    overlaps: Mapping[Pair, Overlap]

    def __str__(self) -> str:
        return f'in pose "{self.name}"' if self.name != ZERO else "at zero"


class Member(NamedTuple):
    """One of several findings that a note sums up: the names that ``accept`` may list, a text, and a path."""

    names: tuple[str, ...]
    text: str
    path: Path


def note(
    case: Case, rule: str, members: Iterable[Member], message: str, *, key: bool = False, first: bool = False
) -> Iterator[Diagnostic]:
    """Yield a note that sums up members, and a diagnostic for each that the description accepts by name.

    ``{count}`` and ``{names}`` in the message are replaced. ``first``: of members with the same first name, only one
    is counted.
    """
    accepted = {one: Diagnostic(rule, NOTE, "", of=one.names) for one in members}
    yield from (found for found in accepted.values() if accepts(case, found))
    rest = [one for one, found in accepted.items() if not accepts(case, found)]
    if first:
        rest = [one for index, one in enumerate(rest) if one.names[0] not in {two.names[0] for two in rest[:index]}]
    if rest:
        text = message.format(count=len(rest), names=first_of([one.text for one in rest], SHOWN))
        found = case.problem(rule, text, rest[0].path, severity=NOTE, key=key)
        yield replace(found, related=(), of=())


def check_overlaps(case: Case, scene: Scene, states: Sequence[State], always: Set[Pair]) -> Iterator[Diagnostic]:
    """Yield diagnostics for parts that overlap at rest; ``always`` are the pairs that overlap in every position."""
    warnings, limiting, beyond_zero = list[tuple[float, Diagnostic]](), dict[Joint, None](), nearest_to_zero(case.robot)
    summed_up: dict[str, list[tuple[float, Member]]] = {"design": [], "hulls": [], "beyond": []}
    for pair in dict.fromkeys(pair for state in states for pair in state.overlaps):
        where = [state for state in states if pair in state.overlaps]
        deepest = max(where, key=lambda state: state.overlaps[pair].depth)
        overlap, at = deepest.overlaps[pair], deepest.positions
        small, large = scene.by_volume(pair)
        share = scene.share(small, large, at)
        between = set.symmetric_difference(*(set(case.robot.chain(link)) for link in pair))
        limits = [joint for joint in case.robot.joints if joint in between and joint.name in beyond_zero]
        kind = ""
        if [state.name for state in where] == [ZERO] and limits:
            kind = "beyond"
            limiting |= dict.fromkeys(limits)
        elif share >= MOST_INSIDE and scene.share(small, large, at, exact=True) >= MOST_INSIDE:
            outer, inner = overlap.solids if overlap.solids[1].link == small else overlap.solids[::-1]
            what = f'link "{small}" is inside link "{large}" with {share:.0%} of its volume'
            warnings.append((overlap.depth, _overlap(case, scene, "part-inside-part", what, where, inner, outer)))
        elif pair in always or (scene.joint_of(pair) is not None and share < CORNER):
            kind = "design"
        elif not scene.touches(overlap.solids, at):
            kind = "hulls"
        else:
            what = f'link "{pair[1]}" is {1000 * overlap.depth:.1f} mm inside link "{pair[0]}"'
            found = _overlap(case, scene, "parts-overlap", what, where, overlap.solids[1], overlap.solids[0])
            warnings.append((overlap.depth, found))
        if kind:
            text = f"{pair[1]} in {pair[0]} by {1000 * overlap.depth:.1f} mm"
            summed_up[kind].append((overlap.depth, Member(pair, text, shape_path(case, overlap.solids[1]))))
    yield from (found for _, found in sorted(warnings, key=lambda one: -one[0]))
    members = {
        kind: [member for _, member in sorted(several, key=lambda one: -one[0])] for kind, several in summed_up.items()
    }
    message = "links that overlap in every position, or at their joint, as parts of one design do ({count}): {names}"
    yield from note(case, "parts-always-overlap", members["design"], message, key=True)
    message = "hulls that overlap though their meshes do not touch ({count}): {names}; simulators push them apart"
    yield from note(case, "hulls-overlap", members["hulls"], message, key=True)
    if limiting:
        first, names = next(iter(limiting)), quoted([joint.name for joint in limiting], SHOWN)
        path = case.joint(first, "limit", "lower" if beyond_zero[first.name] > 0 else "upper")
        message = f"links that overlap at zero, which is beyond the limits of {names} ({{count}}): {{names}}"
        beyond = [one._replace(path=path) for one in members["beyond"]]
        yield from note(case, "parts-overlap", beyond, message)


def _overlap(
    case: Case, scene: Scene, rule: str, what: str, where: Sequence[State], inner: Solid, outer: Solid
) -> Diagnostic:
    """Return a warning at what puts the parts there: a pose, the joint between neighbours, or the shape."""
    joint = scene.joint_of((inner.link, outer.link))
    related = [case.related(f'the shape of "{one.link}"', shape_path(case, one)) for one in (inner, outer)]
    path, is_pose = shape_path(case, inner), where[0].name != ZERO
    if is_pose:
        path = ("poses", where[0].name)
    elif joint is not None:
        path = case.joint(joint, "xyz")
    else:
        related = related[1:]
    poses = quoted([state.name for state in where if state.name != ZERO], SHOWN)
    at = ["at zero"] * (where[0].name == ZERO) + [f"in pose {poses}"] * (where[-1].name != ZERO)
    message = f"{what} {' and '.join(at)}: {shape_name(case, inner)} in {shape_name(case, outer)}"
    found = case.problem(rule, message, path, related=related, key=is_pose)
    return replace(found, of=(inner.link, outer.link))


def shape_path(case: Case, solid: Solid) -> Path:
    """Return the path of a collision shape."""
    return case.link(solid.link, "collision", solid.number)


def shape_name(case: Case, solid: Solid) -> str:
    """Return the name of a shape in a sentence: its kind, its number of several, and whether it is a stand-in."""
    shapes = case.robot.link[solid.link].collision
    geometry = shapes[solid.number].geometry
    name = {"HeightMap": "height map"}.get(type(geometry).__name__, type(geometry).__name__.lower())
    if isinstance(geometry, Mesh):
        name = f"the hull of {geometry.file.rpartition('/')[2]}"
    else:
        name = f"{name} {solid.number + 1} of {len(shapes)}" if len(shapes) > 1 else f"its {name}"
    return name + case.stands_in(shape_path(case, solid))


class Meeting(NamedTuple):
    """A joint that drives the second link of a pair into the first one.

    ``position`` (rad or m) is where that begins, ``end`` the end of the range behind it, ``side`` its limit ("lower" or
    "upper"), ``blocked`` the share of the range in which they overlap, ``inside`` the share of the moved link that gets
    into the other.
    """

    joint: Joint
    pair: Pair
    state: State
    position: float
    end: float
    side: str
    solids: tuple[Solid, Solid]
    blocked: float
    inside: float

    @property
    def where(self) -> str:
        """Where it begins: the position, and the pose unless it is zero."""
        if self.joint.type == "prismatic":
            text = f"{float(f'{self.position:.3g}'):.6g} m"
        else:
            text = f"{round(self.position, 2):.6g} rad ({math.degrees(self.position):.0f} deg)"
        return f"{text} {self.state}" if self.state.name != ZERO else text


def swept_joints(robot: Robot) -> list[tuple[Joint, float, float]]:
    """Return the joints that move by themselves over a range, with its ends (rad or m)."""
    ranges = [(joint, ends) for joint in robot.joints if (ends := range_of(joint))]
    return [(joint, lower, upper) for joint, (lower, upper) in ranges if lower < upper]


def sweep(scene: Scene, states: Sequence[State], tick: Callable[[], None]) -> tuple[list[Meeting], set[Pair]]:
    """Move each joint alone from each state; return the first meetings, and the pairs that overlap in every position.

    Calls ``tick`` after each joint of each state.
    """
    joints = swept_joints(scene.robot)
    counts = {
        joint: SLIDE_STEPS if joint.type == "prismatic" else min(MOST_STEPS, math.ceil((upper - lower) / STEP))
        for joint, lower, upper in joints
    }
    factor = min(1.0, MOST_STATES / max(1, len(states) * sum(counts.values())))
    always = set.intersection(*(set(state.overlaps) for state in states))
    meetings: dict[tuple[str, Pair], Meeting] = {}
    for state in states:
        for joint, lower, upper in joints:
            steps = max(2, round(factor * counts[joint]))
            every = [lower + (upper - lower) * index / steps for index in range(steps + 1)]
            start = state.positions.get(joint.name, 0.0)  # a start outside the range is left at once
            positions = [p for p in reversed(every) if p < start] + [p for p in every if p > start]
            rows = scene.rows([{**state.positions, joint.name: position} for position in positions])
            overlaps = dict(zip(positions, map(scene.overlaps_at, rows), strict=True))
            always = always.intersection(*overlaps.values())
            for meeting in _meetings(scene, state, joint, overlaps):
                meetings.setdefault((joint.name, meeting.pair), meeting)
            tick()
    return list(meetings.values()), always


def _meetings(
    scene: Scene, state: State, joint: Joint, overlaps: Mapping[float, Mapping[Pair, Overlap]]
) -> Iterator[Meeting]:
    """Yield the pairs of links that a joint moves into each other; adjacent links only if they overlap more."""
    start, below = state.positions.get(joint.name, 0.0), set(scene.robot.below(joint.child))
    ways = [[p for p in overlaps if p < start], [p for p in overlaps if p > start]]
    for pair in dict.fromkeys(pair for several in overlaps.values() for pair in several):
        moved, still = pair if pair[0] in below else pair[::-1]
        is_neighbour = scene.joint_of(pair) == joint

        def share(position: float, moved: str = moved, still: str = still) -> float:
            return scene.share(moved, still, {**state.positions, joint.name: position})

        least = 0.0
        if pair in state.overlaps:
            least = share(start) + GROWTH if is_neighbour else 1.0
            if least >= 1:
                continue
        hits = {
            position
            for position, several in overlaps.items()
            if pair in several and (not least or share(position) >= least)
        }
        firsts = [next((i for i, p in enumerate(way) if p in hits), len(overlaps)) for way in ways]
        if not hits:
            continue
        side = firsts.index(min(firsts))
        way, index = ways[side], firsts[side]
        far, near = way[index], way[index - 1] if index else start
        solids = overlaps[far][pair].solids
        for _ in range(_HALVINGS):
            middle = (near + far) / 2
            meet = pair in scene.overlaps({**state.positions, joint.name: middle})
            near, far = (near, middle) if meet and (not least or share(middle) >= least) else (middle, far)
        yield Meeting(
            joint,
            (still, moved),
            state,
            far,
            way[-1],
            ("lower", "upper")[side],
            solids if pair[1] == moved else solids[::-1],
            len(hits) / len(overlaps),
            max(map(share, hits)) - max(0.0, least - GROWTH) if is_neighbour else 0.0,
        )


def check_sweeps(case: Case, scene: Scene, meetings: Sequence[Meeting]) -> Iterator[Diagnostic]:
    """Yield diagnostics for what the joints drive into each other: neighbours one by one, warnings first."""
    near = [one for one in meetings if scene.joint_of(one.pair) == one.joint]
    found = [_through_neighbour(case, scene, one) for one in near if one.inside >= CORNER]
    yield from sorted(found, key=lambda one: one.severity != WARNING)
    far = [
        Member(
            (met.joint.name, *met.pair),
            f"{met.joint.name} {met.pair[1]} into {met.pair[0]} from {met.where}",
            case.joint(met.joint, "limit", met.side),
        )
        for met in meetings
        if met not in near
    ]
    message = "joints that can each move a link into collision with one that is not adjacent ({count}): {names}"
    yield from note(case, "joints-meet-parts", far, message, first=True)


def _through_neighbour(case: Case, scene: Scene, met: Meeting) -> Diagnostic:
    """Return a warning about a real collision in a good part of the range, else a note."""
    is_real = False
    for part in range(4):  # more than the hulls of meshes overlap somewhere beyond the position where it begins
        position = met.position + (met.end - met.position) * part / 3
        state = {**met.state.positions, met.joint.name: position}
        overlaps = scene.overlaps(state)
        overlap = overlaps.get(met.pair) or overlaps.get(met.pair[::-1])
        is_real = is_real or (overlap is not None and scene.touches(overlap.solids, state))
    severity = WARNING if is_real and met.inside >= GROWTH and met.blocked >= BLOCKED else NOTE
    outer, inner = met.solids
    message = (
        f'joint "{met.joint.name}" drives link "{met.pair[1]}" into link "{met.pair[0]}" from {met.where}'
        f" towards its {met.side} limit, {met.blocked:.0%} of its range: {shape_name(case, inner)} into"
        f" {shape_name(case, outer)}"
    )
    related = [case.related(f'the shape of "{solid.link}"', shape_path(case, solid)) for solid in (inner, outer)]
    path = case.joint(met.joint, "limit", met.side)
    return case.problem("joint-through-neighbour", message, path, related=related, severity=severity)
