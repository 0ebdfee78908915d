"""Check which parts are inside each other at zero and in the named poses.

Neighbours overlap at their joint in most robots: a cover, a shared housing, a shaft in its bearing. What overlaps in
every position that was tried, and not in full, is taken for a design and reported in one note, and so are neighbours of
which a corner is in the other one. Every other pair is reported with the shapes, the depth and the poses.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence, Set
from dataclasses import replace
from typing import NamedTuple, TypeVar

from rosorin_compile.language.suppressions import accepted
from rosorin_compile.model import Joint, Mesh
from rosorin_compile.rules.case import Case
from rosorin_compile.rules.check import acceptable
from rosorin_compile.source.diagnostics import NOTE, WARNING, Diagnostic, counted, first_of, listed, quoted
from rosorin_compile.source.rule_registry import Heading, Rule
from rosorin_compile.source.tree import Path

from .scene import Overlap, Pair, Positions, Scene
from .solids import Solid

RULES = (
    Rule(
        "parts-overlap",
        "A warning: two parts are inside each other, at zero or in a named pose, and not in every position (a note, "
        "where zero is beyond the limits of a joint). A simulation pushes them apart in its first step. The depth is "
        "that of the convex hulls of meshes, as simulators take them.",
        "Move one of them, correct the shape or the pose; a pair that is meant to touch goes under "
        "`disabled_contacts`.",
        Heading.PHYSICS,
    ),
    Rule(
        "part-inside-part",
        "A warning: a part is inside another one with most of its volume, or a wheel of the drive with half of it.",
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
WHEEL_INSIDE = 0.5  # of the volume of a wheel of the drive: a wheel turns beside the body
SHOWN = 5  # names in a note

Member = TypeVar("Member")


class State(NamedTuple):
    """Joint positions (rad or m) at which the robot rests, "zero" or a named pose, and the overlaps there."""

    name: str
    positions: Positions
    overlaps: Mapping[Pair, Overlap]

    def __str__(self) -> str:
        return f'in pose "{self.name}"' if self.name != ZERO else "at zero"


def split_accepted(
    case: Case, rule: str, members: Iterable[Member], names: Callable[[Member], Sequence[str]]
) -> tuple[list[Diagnostic], list[Member]]:
    """Split what one note sums up: a diagnostic for each member that the description accepts by name, and the rest."""
    apart: list[Diagnostic] = []
    rest: list[Member] = []
    for member in members:
        found = Diagnostic(rule, NOTE, "", of=tuple(names(member)))
        if accepted(case.tree, found, acceptable()):
            apart.append(found)
        else:
            rest.append(member)
    return apart, rest


def check_overlaps(case: Case, scene: Scene, states: Sequence[State], always: Set[Pair]) -> Iterator[Diagnostic]:
    """Yield diagnostics for parts that overlap at rest; ``always`` are the pairs that overlap in every position."""
    states_of: dict[Pair, list[State]] = {}
    for state in states:
        for pair in state.overlaps:
            states_of.setdefault(pair, []).append(state)
    warnings = []
    designs: dict[Pair, Overlap] = {}
    hulls: dict[Pair, Overlap] = {}
    beyond: dict[Pair, Overlap] = {}  # the limits of a joint between
    for pair, where in states_of.items():
        deepest = max(where, key=lambda state: state.overlaps[pair].depth)
        overlap = deepest.overlaps[pair]
        small, large = scene.by_volume(pair)
        share = scene.share(small, large, deepest.positions)
        if [state.name for state in where] == [ZERO] and _beyond_limits(scene, pair):
            beyond[pair] = overlap
        elif share >= MOST_INSIDE and scene.share(small, large, deepest.positions, exact=True) >= MOST_INSIDE:
            inner, outer = (overlap.one, overlap.other) if overlap.one.link == small else (overlap.other, overlap.one)
            what = f'link "{small}" is inside link "{large}" with {share:.0%} of its volume'
            warnings.append((overlap.depth, _overlap(case, scene, "part-inside-part", what, where, inner, outer)))
        elif share >= WHEEL_INSIDE and small in _wheels(case):
            inner, outer = (overlap.one, overlap.other) if overlap.one.link == small else (overlap.other, overlap.one)
            what = f'wheel "{small}" of the drive is inside link "{large}" with {share:.0%} of its volume'
            warnings.append((overlap.depth, _overlap(case, scene, "part-inside-part", what, where, inner, outer)))
        elif pair in always or (scene.joint_of(pair) is not None and share < CORNER):
            designs[pair] = overlap
        elif not scene.touches(overlap, deepest.positions):
            hulls[pair] = overlap
        else:
            what = f'link "{pair[1]}" is {_mm(overlap.depth)} inside link "{pair[0]}"'
            found = _overlap(case, scene, "parts-overlap", what, where, overlap.other, overlap.one)
            warnings.append((overlap.depth, found))
    yield from (found for _, found in sorted(warnings, key=lambda one: -one[0]))
    yield from _note(
        case,
        "parts-always-overlap",
        designs,
        "{pairs} overlap{s} in every position that was tried, or at a joint, as parts do that are built into each"
        " other: {names}",
        "nothing to do, if they are; else move them",
    )
    yield from _note(
        case,
        "hulls-overlap",
        hulls,
        "the hulls of {pairs} overlap, though their meshes do not touch: {names}; a simulation with hulls pushes them"
        " apart",
        "several convex shapes in place of one mesh; disabled_contacts names a pair that is not to collide",
    )
    joints = list(dict.fromkeys(joint for pair in beyond for joint in _beyond_limits(scene, pair)))
    if joints:
        yield from _note(
            case,
            "parts-overlap",
            beyond,
            f"at zero, which is beyond the limits of {quoted([joint.name for joint in joints], SHOWN)}, {{pairs}}"
            " overlap{s}: {names}; simulators start there",
            "count the joint from a position that it can have, or start simulations in a named pose",
            case.joint(joints[0], "limit", "lower" if nearest_to_zero(joints[0]) > 0 else "upper"),
        )


def _wheels(case: Case) -> set[str]:
    drive = case.robot.drive
    return {case.robot.joint[name].child for name in drive.wheels} if drive else set()


def _beyond_limits(scene: Scene, pair: Pair) -> list[Joint]:
    """Return the joints between two links whose limits do not include zero."""
    one, other = (scene.robot.chain(link) for link in pair)
    between = [joint for joint in dict.fromkeys((*one, *other)) if (joint in one) != (joint in other)]
    return [joint for joint in between if nearest_to_zero(joint)]


def nearest_to_zero(joint: Joint) -> float:
    """Return the position (rad or m) within the limits of a joint that is nearest to zero."""
    limit = joint.limit
    if not joint.moves or joint.mimic or joint.type == "continuous" or limit is None:
        return 0.0
    if limit.lower is None or limit.upper is None or limit.lower > limit.upper:
        return 0.0
    return min(max(0.0, limit.lower), limit.upper)


def _overlap(
    case: Case, scene: Scene, rule: str, what: str, where: Sequence[State], inner: Solid, outer: Solid
) -> Diagnostic:
    """Return a warning at what puts the parts there: a pose, the joint between neighbours, or the shape."""
    joint = scene.joint_of((inner.link, outer.link))
    related = [case.related(f'the shape of "{one.link}"', shape_path(case, one)) for one in (inner, outer)]
    path, is_key = shape_path(case, inner), False
    if where[0].name != ZERO:
        path, is_key = ("poses", where[0].name), True
    elif joint is not None:
        path = case.joint(joint, "xyz")
    else:
        related = related[1:]
    poses = [f'"{state.name}"' for state in where if state.name != ZERO]
    at = ["at zero"] if len(poses) < len(where) else []
    at += [f"in {'pose' if len(poses) == 1 else 'poses'} {listed(poses, SHOWN)}"] if poses else []
    message = f"{what} {' and '.join(at)}: {shape_name(case, inner)} in {shape_name(case, outer)}"
    help = "correct a shape, a joint or the pose; disabled_contacts names a pair that is meant to touch"
    found = case.problem(rule, message, path, help, related=related, severity=WARNING, key=is_key)
    return replace(found, of=(inner.link, outer.link))


def _note(
    case: Case, rule: str, pairs: Mapping[Pair, Overlap], message: str, help: str, path: Path | None = None
) -> Iterator[Diagnostic]:
    """Yield one note on pairs that the description does not accept by name, the deepest first."""
    accepted, rest = split_accepted(case, rule, pairs, lambda pair: pair)
    yield from accepted
    if rest:
        rest.sort(key=lambda pair: -pairs[pair].depth)
        names = first_of([f"{pair[1]} in {pair[0]} by {_mm(pairs[pair].depth)}" for pair in rest], SHOWN)
        count, s = f"{counted(len(rest), 'pair')} of parts", "s" if len(rest) == 1 else ""
        text, where = message.format(pairs=count, s=s, names=names), path or shape_path(case, pairs[rest[0]].other)
        found = case.problem(rule, text, where, help, severity=NOTE, key=path is None)
        yield replace(found, related=(), of=())


def _mm(length: float) -> str:
    return f"{1000 * length:.1f} mm"


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
    elif len(shapes) > 1:
        name += f" {solid.number + 1} of {len(shapes)}"
    else:
        name = f"its {name}"
    return name + case.stands_in(shape_path(case, solid))
