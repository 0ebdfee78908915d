"""Parts that are inside each other, at zero and in the named poses: what is a defect, and what the robot is built like.

Neighbours overlap at their joint in most robots: a cover, a shared housing, a shaft in its bearing. What overlaps in
every position that was tried, and not in full, is taken for a design and said once, and so are neighbours of which a
corner is in the other one. Of the rest each pair is told, with the shapes, the depth and the poses.
"""

from __future__ import annotations

from collections.abc import Generator, Iterator, Mapping, Sequence, Set
from dataclasses import replace
from typing import Any, NamedTuple

from rosorin_compile.model import Joint, Mesh
from rosorin_compile.rules.case import Case
from rosorin_compile.rules.check import accepts
from rosorin_compile.source.diagnostics import (
    NOTE,
    WARNING,
    Diagnostic,
    Related,
    and_more,
    counted,
    first_of,
    listed,
    quoted,
)
from rosorin_compile.source.rule_registry import Heading, Rule
from rosorin_compile.source.tree import Path

from .accepted import apart
from .scene import Overlap, Pair, Scene, Solid

RULES = (
    Rule(
        "parts-overlap",
        "A warning: two parts are inside each other, at zero or in a named pose, and not in every position (a note, "
        "where zero is beyond the limits of a joint). A "
        "simulation pushes them apart in its first step. How deep is said of the convex hulls of meshes, as simulators "
        "take them.",
        "Move one of them, correct the shape or the pose; a pair that is meant to touch goes under "
        "`disabled_contacts`.",
        Heading.PHYSICS,
    ),
    Rule(
        "part-inside-part",
        "A warning: a part is inside another one with most of its volume.",
        "Check `xyz` of the joint and of the shape; a pair that is meant goes under `disabled_contacts`.",
        Heading.PHYSICS,
    ),
    Rule(
        "hulls-overlap",
        "A note: the convex hulls of meshes overlap, at zero or in a named pose, though the meshes do not touch. A "
        "simulation that takes hulls pushes the parts apart.",
        "Several convex shapes in place of the mesh; or the pair under `disabled_contacts`.",
        Heading.PHYSICS,
    ),
    Rule(
        "parts-always-overlap",
        "A note: parts overlap in every position that was tried, or neighbours a little at their joint. They are taken "
        "for a design, such as a housing that two links share.",
        "Nothing, if it is one; else move them.",
        Heading.PHYSICS,
    ),
)

ZERO = ""  # the name of the state in which every joint is at zero
MOST_INSIDE = 0.9  # of its volume: no bearing and no cover holds a part like that
CORNER = 0.2  # of its volume: less is a corner at a joint
MOST_TOLD = 12
_SHOWN = 5


class State(NamedTuple):
    """A position of the robot at which it rests: a named pose, or zero; rad or m by joint, and what overlaps there.

    ``near`` says that it is not zero but as near as the limits let it be.
    """

    name: str
    positions: Mapping[str, float]
    overlaps: Mapping[Pair, Overlap]
    near: bool = False


def diagnose_overlaps(case: Case, scene: Scene, states: Sequence[State], always: Set[Pair]) -> list[Diagnostic]:
    """Return what is to say about parts that overlap at rest; ``always`` are the pairs that overlap everywhere."""
    found: dict[Pair, list[State]] = {}
    for state in states:
        for pair in state.overlaps:
            found.setdefault(pair, []).append(state)
    warnings, designs, hulls, illegal = [], {}, {}, {}
    for pair, where in found.items():
        deepest = max(where, key=lambda state: state.overlaps[pair].depth)
        overlap = deepest.overlaps[pair]
        small, large = scene.smaller(pair)
        share = scene.share(small, large, deepest.positions)
        if [state.name for state in where] == [ZERO] and _beyond(scene, pair):
            illegal[pair] = overlap
        elif share >= MOST_INSIDE and scene.share(small, large, deepest.positions, exact=True) >= MOST_INSIDE:
            # By its hull a case has in it what it is around.
            warnings.append((overlap.depth, _inside(case, scene, small, pair, where, overlap, share)))
        elif pair in always or (scene.joint_of(pair) is not None and share < CORNER):
            designs[pair] = overlap
        elif not scene.touches(overlap, deepest.positions):
            hulls[pair] = overlap
        else:
            warnings.append((overlap.depth, _overlap(case, scene, pair, where, overlap)))
    warnings.sort(key=lambda one: -one[0])
    notes = (*_designs(case, designs), *_hulls(case, hulls), *_illegal(case, scene, illegal))
    return [*at_most(case, [one for _, one in warnings]), *notes]


def _beyond(scene: Scene, pair: Pair) -> list[Joint]:
    """Return the joints between two links that are beyond their limits at zero."""
    robot = scene.robot
    one, other = (robot.chain(link) for link in pair)
    return [joint for joint in dict.fromkeys((*one, *other)) if (joint in one) != (joint in other) and nearest(joint)]


def nearest(joint: Joint) -> float:
    """Return the position (rad or m) nearest to zero that the limits of a joint let it have."""
    limit = joint.limit
    if not joint.moves or joint.mimic or joint.type == "continuous" or limit is None:
        return 0.0
    if limit.lower is None or limit.upper is None or limit.lower > limit.upper:
        return 0.0
    return min(max(0.0, limit.lower), limit.upper)


def _illegal(case: Case, scene: Scene, pairs: Mapping[Pair, Overlap]) -> Iterator[Diagnostic]:
    """Yield a note on the pairs that overlap at zero alone, where joints between them are beyond their limits."""
    pairs = yield from _unaccepted(case, "parts-overlap", pairs)
    if not pairs:
        return
    joints = list(dict.fromkeys(joint for pair in pairs for joint in _beyond(scene, pair)))
    names = [f"{pair[1]} in {pair[0]} by {mm(overlap.depth)}" for pair, overlap in _deepest(pairs)]
    message = (
        f"at zero, which is beyond the limits of {quoted([joint.name for joint in joints], _SHOWN)},"
        f" {counted(len(pairs), 'pair')} of parts overlap{'s' if len(pairs) == 1 else ''}: {first_of(names, _SHOWN)};"
        " simulators start there"
    )
    side = "lower" if nearest(joints[0]) > 0 else "upper"
    help = "count the joint from a position that it can have, or start simulations in a named pose"
    found = case.problem("parts-overlap", message, case.joint(joints[0], "limit", side), help, severity=NOTE)
    yield replace(found, of=(), numbers=())


def _deepest(pairs: Mapping[Pair, Overlap]) -> list[tuple[Pair, Overlap]]:
    return sorted(pairs.items(), key=lambda item: -item[1].depth)


def _inside(
    case: Case, scene: Scene, small: str, pair: Pair, where: Sequence[State], overlap: Overlap, share: float
) -> Diagnostic:
    inner, outer = (overlap.one, overlap.other) if overlap.one.link == small else (overlap.other, overlap.one)
    message = (
        f'link "{small}" is inside link "{outer.link}" with {share:.0%} of its volume {_where(where)}:'
        f" {shape_word(case, inner)} in {shape_word(case, outer)}"
    )
    help = "check where the joint and the shapes put it; disabled_contacts names a pair that is meant"
    return _at(case, scene, "part-inside-part", message, pair, where, inner, outer, help, overlap.depth)


def _overlap(case: Case, scene: Scene, pair: Pair, where: Sequence[State], overlap: Overlap) -> Diagnostic:
    message = (
        f'link "{pair[1]}" is {mm(overlap.depth)} inside link "{pair[0]}" {_where(where)}:'
        f" {shape_word(case, overlap.other)} in {shape_word(case, overlap.one)}"
    )
    help = "correct a shape, a joint or the pose; disabled_contacts names a pair that is meant"
    return _at(case, scene, "parts-overlap", message, pair, where, overlap.other, overlap.one, help, overlap.depth)


def _at(
    case: Case,
    scene: Scene,
    rule: str,
    message: str,
    pair: Pair,
    where: Sequence[State],
    first: Solid,
    second: Solid,
    help: str,
    depth: float,
) -> Diagnostic:
    """Return a warning at the number that puts the parts there: a pose, the joint of neighbours, or the shape."""
    joint = scene.joint_of(pair)
    shapes = [case.related(f'the shape of "{solid.link}"', shape_path(case, solid)) for solid in (first, second)]
    if where[0].name != ZERO:
        path: Path = ("poses", where[0].name)
        key = True
    elif joint is not None:
        path, key = case.joint(joint, "xyz"), False
    else:
        path, key, shapes = shape_path(case, first), False, shapes[1:]
    made = case.problem(rule, message, path, help, related=shapes, severity=WARNING, key=key)
    return replace(made, of=pair, numbers=(("depth", depth),))


def _where(states: Sequence[State]) -> str:
    """Return in which states something is so, as the end of a sentence."""
    poses = [f'"{state.name}"' for state in states if state.name != ZERO]
    zero = ["at zero"] if len(poses) < len(states) else []
    named = [f"in {'pose' if len(poses) == 1 else 'poses'} {listed(poses, _SHOWN)}"] if poses else []
    return " and ".join(zero + named)


def _designs(case: Case, designs: Mapping[Pair, Overlap]) -> Iterator[Diagnostic]:
    """Yield a note on the pairs that overlap in every position."""
    designs = yield from _unaccepted(case, "parts-always-overlap", designs)
    if not designs:
        return
    deepest = _deepest(designs)
    names = [f"{pair[1]} in {pair[0]} by {mm(overlap.depth)}" for pair, overlap in deepest[:_SHOWN]]
    message = (
        f"{counted(len(designs), 'pair')} of parts overlap{'s' if len(designs) == 1 else ''} in every position that was"
        f" tried, or at a joint, as parts do that are built into each other: {', '.join(names)}"
        f"{and_more(len(designs) - _SHOWN)}{_rubbing(case, [pair for pair, _ in deepest])}"
    )
    path = shape_path(case, deepest[0][1].other)
    help = "nothing to do, if they are; else move them"
    found = case.problem("parts-always-overlap", message, path, help, severity=NOTE, key=True)
    yield replace(found, related=(), of=(), numbers=())


def _rubbing(case: Case, pairs: Sequence[Pair]) -> str:
    """Return the end of a sentence about a wheel that turns on in a part that does not carry it; empty without one."""
    for pair in pairs:
        for wheel, other in (pair, pair[::-1]):
            axle, beside = (case.robot.joint_to.get(name) for name in (wheel, other))
            if axle is None or axle.type != "continuous" or other == axle.parent:
                continue
            if beside is None or beside.type != "continuous":
                return f'; "{wheel}" turns on in "{other}", and rubs on it in a simulation'
    return ""


def _hulls(case: Case, hulls: Mapping[Pair, Overlap]) -> Iterator[Diagnostic]:
    """Yield a note on the pairs whose meshes do not touch, though their hulls overlap."""
    hulls = yield from _unaccepted(case, "hulls-overlap", hulls)
    if not hulls:
        return
    deepest = _deepest(hulls)
    names = [f"{pair[1]} in {pair[0]} by {mm(overlap.depth)}" for pair, overlap in deepest[:_SHOWN]]
    message = (
        f"the hulls of {counted(len(hulls), 'pair')} of parts overlap, though their meshes do not touch:"
        f" {', '.join(names)}{and_more(len(hulls) - _SHOWN)}; a simulation with hulls pushes them apart"
    )
    path = shape_path(case, deepest[0][1].other)
    help = "several convex shapes in place of one mesh; disabled_contacts names a pair that is not to collide"
    found = case.problem("hulls-overlap", message, path, help, severity=NOTE, key=True)
    yield replace(found, related=(), of=(), numbers=())


def _unaccepted(
    case: Case, rule: str, pairs: Mapping[Pair, Overlap]
) -> Generator[Diagnostic, None, Mapping[Pair, Overlap]]:
    """Yield a diagnostic for each pair that the description accepts by name; return the others."""
    taken, left = apart(case, rule, pairs, lambda pair: pair)
    yield from taken
    return {pair: pairs[pair] for pair in left}


def at_most(case: Case, found: Sequence[Diagnostic], others: str = "of this kind, less deep") -> list[Diagnostic]:
    """Return diagnostics that are sorted by their weight; of many the first, the last of them with how many others.

    Those that the description accepts do not count.
    """
    taken = [one for one in found if accepts(case, one)]
    found = [one for one in found if one not in taken]
    if len(found) <= MOST_TOLD:
        return [*found, *taken]
    *first, last = found[:MOST_TOLD]
    more = and_more(len(found) - MOST_TOLD, others).strip()
    return [*first, replace(last, related=(Related(more, None), *last.related)), *taken]


def mm(length: float) -> str:
    """Return a length (m) in millimetres."""
    return f"{1000 * length:.1f} mm"


def shape_path(case: Case, solid: Solid) -> Path:
    """Return the path of a collision shape."""
    return case.link(solid.link, "collision", solid.number)


def shape_word(case: Case, solid: Solid) -> str:
    """Return what a shape is called in a sentence: its kind, its number of several, and whether it is a stand-in."""
    shapes = case.robot.link[solid.link].collision
    geometry = shapes[solid.number].geometry
    word = {"HeightMap": "height map"}.get(type(geometry).__name__, type(geometry).__name__.lower())
    if isinstance(geometry, Mesh):
        word = f"the hull of {geometry.file.rpartition('/')[2]}"
    elif len(shapes) > 1:
        word += f" {solid.number + 1} of {len(shapes)}"
    else:
        word = f"its {word}"
    return f"{word} (a stand-in)" if stands_in(case, shape_path(case, solid)) else word


def stands_in(case: Case, path: Path) -> bool:
    """Say whether what is written at a path, or what holds it, is a stand-in; the nearest source says it."""
    for depth in range(len(path), 1, -1):
        source: Any = case.tree.at((*path[:depth], "source"))
        if source:
            return bool(source.get("status") == "stand_in")
    return False
