"""Parts that are inside each other, at zero and in the named poses: what is a defect, and what the robot is built like.

Neighbours overlap at their joint in most robots: a cover, a shared housing, a shaft in its bearing. What overlaps in
every position that was tried, and not in full, is taken for a design and said once. Of the rest each pair is told, with
the shapes, the depth and the poses.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence, Set
from typing import Any, NamedTuple

from ...diagnostics import NOTE, WARNING, Diagnostic, Related
from ...diagnostics.registry import PHYSICS, Rule
from ...diagnostics.wording import and_more, counted, listed
from ...frontend.tree import Path
from ...model import Mesh
from ...rules.case import Case, at
from .scene import Overlap, Pair, Scene, Solid

RULES = (
    Rule(
        "parts-overlap",
        "A warning: two parts are inside each other, at zero or in a named pose, and not in every position. A "
        "simulation pushes them apart in its first step. Meshes are taken as their convex hulls, as simulators do.",
        "Move one of them, correct the shape or the pose; a pair that is meant to touch goes under "
        "`disabled_contacts`.",
        PHYSICS,
    ),
    Rule(
        "part-inside-part",
        "A warning: a part is inside another one with most of its volume.",
        "Check `xyz` of the joint and of the shape; a pair that is meant goes under `disabled_contacts`.",
        PHYSICS,
    ),
    Rule(
        "parts-always-overlap",
        "A note: parts overlap in every position that was tried. They are taken for a design, such as a housing that "
        "two links share.",
        "Nothing, if it is one; else move them.",
        PHYSICS,
    ),
)

ZERO = ""  # the name of the state in which every joint is at zero
MOST_INSIDE = 0.9  # of its volume: no bearing and no cover holds a part like that
MOST_TOLD = 12
_SHOWN = 5


class State(NamedTuple):
    """A position of the robot at which it rests: a named pose, or zero; rad or m by joint, and what overlaps there."""

    name: str
    positions: Mapping[str, float]
    overlaps: Mapping[Pair, Overlap]


def told(case: Case, scene: Scene, states: Sequence[State], always: Set[Pair]) -> list[Diagnostic]:
    """Return what is to say about parts that overlap at rest; ``always`` are the pairs that overlap everywhere."""
    found: dict[Pair, list[State]] = {}
    for state in states:
        for pair in state.overlaps:
            found.setdefault(pair, []).append(state)
    warnings, designs = [], {}
    for pair, where in found.items():
        deepest = max(where, key=lambda state: state.overlaps[pair].depth)
        overlap = deepest.overlaps[pair]
        small, share = scene.share(pair, deepest.positions)
        if share >= MOST_INSIDE and not _is_hollow(scene, pair, small):
            warnings.append((overlap.depth, _inside(case, scene, small, pair, where, overlap, share)))
        elif pair in always:
            designs[pair] = overlap
        else:
            warnings.append((overlap.depth, _overlap(case, scene, pair, where, overlap)))
    warnings.sort(key=lambda one: -one[0])
    return [*at_most([one for _, one in warnings]), *_designs(case, designs)]


def _is_hollow(scene: Scene, pair: Pair, small: str) -> bool:
    """Say whether what a part is inside of are hulls of meshes: a case and what is in it look like that."""
    large = pair[1] if small == pair[0] else pair[0]
    return all(solid.hull is not None for solid in scene.of_link[large])


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
    return made._replace(of=pair, numbers=(("depth", depth),))


def _where(states: Sequence[State]) -> str:
    """Return in which states something is so, as the end of a sentence."""
    poses = [f'"{state.name}"' for state in states if state.name != ZERO]
    zero = ["at zero"] if len(poses) < len(states) else []
    named = [f"in {'pose' if len(poses) == 1 else 'poses'} {listed(poses, _SHOWN)}"] if poses else []
    return " and ".join(zero + named)


def _designs(case: Case, designs: Mapping[Pair, Overlap]) -> Iterator[Diagnostic]:
    """Yield a note on the pairs that overlap in every position."""
    if not designs:
        return
    deepest = sorted(designs.items(), key=lambda item: -item[1].depth)
    names = [f"{pair[1]} in {pair[0]} by {mm(overlap.depth)}" for pair, overlap in deepest[:_SHOWN]]
    message = (
        f"{counted(len(designs), 'pair')} of parts overlap{'s' if len(designs) == 1 else ''} in every position that was"
        f" tried, as parts do that are built into each other: {', '.join(names)}{and_more(len(designs) - _SHOWN)}"
    )
    path = shape_path(case, deepest[0][1].other)
    help = "nothing to do, if they are; else move them"
    found = case.problem("parts-always-overlap", message, path, help, severity=NOTE, key=True)
    yield found._replace(related=(), of=(), numbers=())


def at_most(found: Sequence[Diagnostic]) -> list[Diagnostic]:
    """Return diagnostics that are sorted by their weight; of many the first, the last of them with how many others."""
    if len(found) <= MOST_TOLD:
        return list(found)
    *first, last = found[:MOST_TOLD]
    more = and_more(len(found) - MOST_TOLD, "of this kind, less deep").strip()
    return [*first, last._replace(related=(Related(more, None), *last.related))]


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
        source: Any = at(case.tree, (*path[:depth], "source"))
        if source:
            return bool(source.get("status") == "stand_in")
    return False


def pairs_of(states: Iterable[State]) -> set[Pair]:
    """Return the pairs that overlap in all of the states."""
    sets = [set(state.overlaps) for state in states]
    return set.intersection(*sets) if sets else set()
