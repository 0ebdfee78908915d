"""Find parts that are inside each other at zero and in the named poses, and parts that joints drive together.

Neighbours overlap at their joint in most robots: a cover, a shared housing, a shaft in its bearing. An overlap in every
tested position, and not in full, is a design and part of one note, and so are neighbours with a corner in each other.

Each joint is moved alone over its range, from zero and from each named pose. A part that it drives deep into its
neighbour over a good part of the range is a warning, for then an axis or an origin is wrong, else a note: limits are
often a little wider than the parts allow. Parts that are not neighbours are one note: planners know how to avoid them.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import replace
from itertools import product
from typing import NamedTuple

from rosorin_compile.language.suppressions import is_accepted
from rosorin_compile.model import Joint, Mesh
from rosorin_compile.rules.case import Case
from rosorin_compile.rules.check import acceptable
from rosorin_compile.source.diagnostics import NOTE, WARNING, Diagnostic, first_of, quote
from rosorin_compile.source.progress import Progress
from rosorin_compile.source.tree import Path

from ..rest_pose import nearest_to_zero, range_of
from .scene import Overlap, Pair, Positions, Scene, Solid

_MOST_INSIDE = 0.9  # of its volume: no bearing and no cover holds a part like that
_CORNER = 0.2  # of its volume: less is a corner at a joint
_SHOWN = 5  # names in a note
_STEP, _MOST_STEPS, _SLIDE_STEPS = math.radians(5), 72, 24  # of a hinge, and of a slide
_MOST_STATES = 20_000  # of all sweeps together: then steps grow
_GROWTH = 0.3  # of the volume of the part that moves: it is driven into the other one
_BLOCKED = 0.25  # of the range: less is a limit that is too wide
_HALVINGS = 8


class State(NamedTuple):
    """A position of rest, zero (without a name) or a pose, with joint positions (rad or m) and the overlaps there."""

    name: str
    positions: Positions
    overlaps: Mapping[Pair, Overlap]


class Member(NamedTuple):
    """A finding that a note sums up: the names that ``accept`` may list, a text, a path, and the depth (m)."""

    names: tuple[str, ...]
    text: str
    path: Path
    depth: float = 0.0


def note(case: Case, rule: str, members: Iterable[Member], message: str, key: bool = False) -> Iterator[Diagnostic]:
    """Yield a note that sums up members, and a diagnostic for each that the description accepts by name.

    ``{count}`` and ``{names}`` in the message are replaced.
    """
    rest: dict[tuple[str, ...], Member] = {}
    for member in members:
        found = Diagnostic(rule, NOTE, "", of=member.names)
        if is_accepted(case.tree, found, acceptable()):
            yield found
        else:  # of a joint only the first finding
            rest.setdefault(member.names[:1] if rule == "joints-meet-parts" else (*member.names, member.text), member)
    if rest:
        text = message.format(count=len(rest), names=first_of([one.text for one in rest.values()], _SHOWN))
        first = next(iter(rest.values()))
        yield replace(case.problem(rule, text, first.path, severity=NOTE, key=key), related=(), of=())


def check_overlaps(case: Case, scene: Scene) -> Iterator[Diagnostic]:
    """Yield diagnostics for parts that overlap at rest, and for those that joints drive into each other."""
    poses = [("", nearest_to_zero(case.robot)), *((pose.name, pose.positions) for pose in case.robot.poses)]
    states = [State(name, positions, next(scene.overlaps([positions]))) for name, positions in poses]
    always = set.intersection(*(set(state.overlaps) for state in states))
    ranges = {joint: ends for joint in case.robot.joints if (ends := range_of(joint)) and ends[0] < ends[1]}
    counts = {
        joint: _SLIDE_STEPS if joint.type == "prismatic" else min(_MOST_STEPS, math.ceil((upper - lower) / _STEP))
        for joint, (lower, upper) in ranges.items()
    }
    factor = min(1.0, _MOST_STATES / max(1, len(states) * sum(counts.values())))
    driven: dict[tuple[str, Pair], Member | Diagnostic | None] = {}
    for (number, state), joint in product(enumerate(states), ranges):
        Progress.step("moving joints", number, len(states))
        steps, start = max(2, round(factor * counts[joint])), state.positions.get(joint.name, 0.0)
        lower, upper = ranges[joint]
        every = [lower + (upper - lower) * index / steps for index in range(steps + 1)]
        # From the start to each end; a start outside the range is left at once.
        positions = [p for p in reversed(every) if p < start] + [p for p in every if p > start]
        moved = list(scene.overlaps([{**state.positions, joint.name: position} for position in positions]))
        always = always.intersection(*moved)
        for pair in dict.fromkeys(pair for several in moved for pair in several):
            if driven.get((joint.name, pair)) is None:
                overlaps = dict(zip(positions, moved, strict=True))
                driven[joint.name, pair] = _driven(case, scene, state, joint, overlaps, pair)
    warnings, designs, hulls = list[tuple[float, Diagnostic]](), list[Member](), list[Member]()
    for pair in dict.fromkeys(pair for state in states for pair in state.overlaps):
        where = [state for state in states if pair in state.overlaps]
        deepest = max(where, key=lambda state: state.overlaps[pair].depth)
        overlap, at = deepest.overlaps[pair], deepest.positions
        outer, inner = overlap.solids
        small, large = sorted(pair, key=lambda link: scene.volume[link])
        share, depth = scene.share(small, large, at), f"{1000 * overlap.depth:.1f} mm"
        member = Member(pair, f"{pair[1]} in {pair[0]} by {depth}", _path(case, inner), overlap.depth)
        if share >= _MOST_INSIDE and scene.share(small, large, at, exact=True) >= _MOST_INSIDE:
            outer, inner = overlap.solids if inner.link == small else (inner, outer)
            rule, what = "part-inside-part", f'link "{small}" is inside link "{large}" with {share:.0%} of its volume'
        elif pair in always or (scene.joint_of(pair) is not None and share < _CORNER):
            designs.append(member)
            continue
        elif not scene.touches(overlap.solids, at):
            hulls.append(member)
            continue
        else:
            rule, what = "parts-overlap", f'link "{pair[1]}" is {depth} inside link "{pair[0]}"'
        # It is reported at its cause: a pose, the joint between neighbours, or the shape.
        between, pose = scene.joint_of(pair), where[0].name
        related = _shapes_of(case, inner, outer)
        path = ("poses", pose) if pose else case.joint(between, "xyz") if between else _path(case, inner)
        names = quote([state.name for state in where if state.name], _SHOWN)
        places = ["at zero"] * (not pose) + [f"in pose {names}"] * bool(where[-1].name)
        message = f"{what} {' and '.join(places)}: {_name(case, inner)} in {_name(case, outer)}"
        related = related if pose or between else related[1:]
        found = case.problem(rule, message, path, related=related, key=bool(pose))
        warnings.append((overlap.depth, replace(found, of=(inner.link, outer.link))))
    yield from (found for _, found in sorted(warnings, key=lambda warning: -warning[0]))
    message = "links that overlap in every position, or at their joint, as parts of one design do ({count}): {names}"
    yield from note(case, "parts-always-overlap", sorted(designs, key=lambda one: -one.depth), message, key=True)
    message = "hulls that overlap though their meshes do not touch ({count}): {names}; simulators push them apart"
    yield from note(case, "hulls-overlap", sorted(hulls, key=lambda one: -one.depth), message, key=True)
    near = [one for one in driven.values() if isinstance(one, Diagnostic)]
    yield from sorted(near, key=lambda one: one.severity != WARNING)
    message = "joints that can each move a link into collision with one that is not adjacent ({count}): {names}"
    yield from note(case, "joints-meet-parts", [one for one in driven.values() if isinstance(one, Member)], message)


def _path(case: Case, solid: Solid) -> Path:
    return case.link(solid.link, "collision", solid.number)


def _shapes_of(case: Case, *solids: Solid) -> list[tuple[str, Path]]:
    return [(f'the shape of "{solid.link}"', _path(case, solid)) for solid in solids]


def _name(case: Case, solid: Solid) -> str:
    """Return the name of a shape: its kind, its number among several, and whether it is a stand-in."""
    shapes = case.robot.link[solid.link].collision
    geometry = shapes[solid.number].geometry
    name = {"HeightMap": "height map"}.get(type(geometry).__name__, type(geometry).__name__.lower())
    if isinstance(geometry, Mesh):
        name = f"the hull of {geometry.file.rpartition('/')[2]}"
    elif len(shapes) > 1:
        name = f"{name} {solid.number + 1} of {len(shapes)}"
    return name + case.stands_in(_path(case, solid))


def _driven(
    case: Case, scene: Scene, state: State, joint: Joint, overlaps: Mapping[float, Mapping[Pair, Overlap]], pair: Pair
) -> Member | Diagnostic | None:
    """Return the collision of two links that a joint causes, or None; adjacent links only if they overlap more."""
    moved, still = pair if pair[0] in scene.robot.subtree(joint.child) else pair[::-1]
    start, is_neighbour, least = state.positions.get(joint.name, 0.0), scene.joint_of(pair) == joint, 0.0

    def at(position: float) -> Positions:
        return {**state.positions, joint.name: position}

    def meet(position: float) -> bool:
        several = overlaps[position] if position in overlaps else next(scene.overlaps([at(position)]))
        return pair in several and (not least or scene.share(moved, still, at(position)) >= least)

    if pair in state.overlaps:
        if not is_neighbour:
            return None
        least = scene.share(moved, still, at(start)) + _GROWTH
    hits = [position for position in overlaps if least < 1 and meet(position)]
    if not hits:
        return None
    far = min(hits, key=lambda position: abs(position - start))
    before = [p for p in (start, *overlaps) if min(start, far) <= p <= max(start, far) and p != far]
    near, beyond = min(before, key=lambda position: abs(position - far)), far
    for _ in range(_HALVINGS):
        middle = (near + beyond) / 2
        near, beyond = (near, middle) if meet(middle) else (middle, beyond)
    where = f"{float(f'{beyond:.3g}'):.6g} m"
    if joint.type != "prismatic":
        where = f"{round(beyond, 2):.6g} rad ({math.degrees(beyond):.0f} deg)"
    where += f' in pose "{state.name}"' if state.name else ""
    side = "upper" if far > start else "lower"
    path = case.joint(joint, "limit", side)
    if not is_neighbour:
        return Member((joint.name, still, moved), f"{joint.name} {moved} into {still} from {where}", path)
    inside = max(scene.share(moved, still, at(position)) for position in hits) - max(0.0, least - _GROWTH)
    if inside < _CORNER:
        return None
    tested = hits[:: 1 + len(hits) // 4]  # for more than the hulls of meshes
    is_real = any(scene.touches(overlaps[position][pair].solids, at(position)) for position in tested)
    is_grave = is_real and inside >= _GROWTH and len(hits) >= _BLOCKED * len(overlaps)
    outer, inner = sorted(overlaps[far][pair].solids, key=lambda solid: solid.link == moved)
    message = (
        f'joint "{joint.name}" drives link "{moved}" into link "{still}" from {where} towards its {side} limit,'
        f" {len(hits) / len(overlaps):.0%} of its range: {_name(case, inner)} into {_name(case, outer)}"
    )
    related, severity = _shapes_of(case, inner, outer), WARNING if is_grave else NOTE
    return case.problem("joint-through-neighbour", message, path, related=related, severity=severity)
