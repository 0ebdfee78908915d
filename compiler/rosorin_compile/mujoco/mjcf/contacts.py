"""Contacts: which links are not to collide, and which may though MuJoCo would not let them.

MuJoCo lets nothing that is welded together on one side of a joint collide with what is welded together on its other
side, where both sides can move. That is right for the two links that the joint connects, and hides too much of the
others: a camera that is fixed to the wrist may well meet the gripper. So of those

- the two links that the joint connects are excluded: they are built into each other;
- links that touch at zero, in each named pose and all over the range of the joint are excluded: a simulation would
  push them apart. What is free in any of these is never hidden;
- links with a mesh are excluded: what a mesh touches is not known here;
- of the others the shapes that the joint can bring together are named as pairs, which MuJoCo then takes into account.
  They slide without friction: shapes around a joint are larger than the parts, and would brake it where they rub.

Where the bits of shapes (``masks``) keep links apart, there is nothing to exclude; and a pair would pass over them.

Pairs and excludes are said for every base, fixed or free: a robot is attached to other things. Pairs are the robot's
own, while the flag that turns MuJoCo's filter off is one of the whole scene, where other robots rely on it.

MJX, MuJoCo on accelerators, loads no model of which two shapes may touch that it cannot collide (``refused``). What it
lacks (mujoco-mjx 3.17, JAX): cylinders and ellipsoids against boxes, meshes and height fields, and fields against each
other. The floor of a scene, a plane, meets all shapes.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence, Set
from functools import cache
from itertools import combinations, product
from typing import NamedTuple

from rosorin_compile.model import HeightMap, Joint, Link, Mesh, Output, Robot, Shape, Transform
from rosorin_compile.model.cached import of_robot
from rosorin_compile.model.geometry import dot, norm, plane_axes, unit
from rosorin_compile.model.joint import motion
from rosorin_compile.model.shape import MERGED
from rosorin_compile.rules.case import Case
from rosorin_compile.source.diagnostics import NOTE, Diagnostic
from rosorin_compile.source.rule_registry import FORMATS, Rule

from .bodies import Mask, Masks, body_name, weld_groups
from .height_fields import HFIELD, form_of, solids
from .omissions import has_volume, is_written, position_range
from .proximity import NEAR, Solid, Touching, solid_of

# Each pair is looked at in each step; of two links that are made of hundreds of shapes it would be all that is done.
MOST = 300
# Into so many steps the range of a joint is cut to see whether two links always touch.
STEPS = 24


class Geom(NamedTuple):
    """A collision shape of a link: the number that its geom has there, from 1."""

    link: str
    number: int
    solid: Solid


Meeting = tuple[Geom, Geom]


class Contacts(NamedTuple):
    """Pairs of bodies that are excluded from contact, and pairs of shapes that may collide where MuJoCo filters.

    ``left`` are links that would need more than ``MOST`` pairs: it is left to MuJoCo whether they collide.
    """

    excluded: list[tuple[str, str]]
    pairs: list[Meeting]
    left: list[tuple[str, str]]


@of_robot
def contacts(robot: Robot, form: str = MERGED, implied: bool = True) -> Contacts:
    """Return who is not to collide, and who may all the same; ``form`` is that of the height maps.

    The links of each joint come first, then ``disabled_contacts`` of the robot; without ``implied`` these alone. Bodies
    are called as in the MJCF.
    """
    groups, masks = weld_groups(robot), Masks(robot, implied)
    top_of = {name: top for top, names in groups.items() for name in names}
    solid = {top: [name for name in names if robot.link[name].collision] for top, names in groups.items()}
    geoms = cache(lambda name: _geoms(robot.link[name], form))
    meshes = {link.name for link in robot.links for one in link.collision if isinstance(one.geometry, Mesh)}
    named = {frozenset(pair) for pair in robot.disabled_contacts}
    places: dict[str, Transform] = {}  # of links in the topmost link that they are welded to
    excluded: dict[frozenset[str], tuple[str, str]] = {}
    pairs: list[Meeting] = []
    left: list[tuple[str, str]] = []
    for link in robot.walk():
        above = robot.joint_to.get(link.name)
        is_welded = above is not None and above.is_fixed
        places[link.name] = places[above.parent].then(above.transform()) if above and is_welded else Transform()
    for top, below in solid.items() if implied else ():
        joint = robot.joint_to.get(top)
        over = solid[top_of[joint.parent]] if joint is not None else []
        if joint is None or not below or not over:
            continue
        ends = (joint.parent, joint.child)
        if over == [joint.parent] and below == [joint.child]:  # neighbours alone, wherever they are
            if masks.meet(*ends):
                excluded.setdefault(frozenset(ends), ends)
            continue
        for links, meeting in _candidates(joint, places, geoms, meshes, over, below):
            if not masks.meet(*links):
                continue
            is_hidden = links == ends or not meshes.isdisjoint(links)
            if is_hidden or _always_touch(robot, joint, places, links, meeting):
                excluded.setdefault(frozenset(links), links)
            elif len(meeting) > MOST:
                left.append(links)
            elif frozenset(links) not in named:
                pairs += [pair for pair in meeting if masks.pair(*pair)]
    for pair in robot.disabled_contacts:
        if masks.rolling.isdisjoint(pair):  # else the bits say it, of a hundred rollers at once
            excluded.setdefault(frozenset(pair), pair)
    bodies = [(body_name(robot, one), body_name(robot, other)) for one, other in excluded.values()]
    return Contacts(bodies, pairs, left)


def _geoms(link: Link, form: str) -> list[Geom]:
    shapes = (solid for shape in link.collision for solid in solids(shape, form))
    every = ((number, solid_of(shape)) for number, shape in enumerate(shapes, start=1) if has_volume(shape.geometry))
    return [Geom(link.name, number, solid) for number, solid in every if solid is not None]


def _candidates(
    joint: Joint,
    places: Mapping[str, Transform],
    geoms: Callable[[str], Sequence[Geom]],
    meshes: Set[str],
    above: Sequence[str],
    below: Sequence[str],
) -> Iterator[tuple[tuple[str, str], list[Meeting]]]:
    """Yield the links of both sides of a joint that matter to each other, with the shapes that it can bring together.

    They are neighbours, those that may meet, and what has a mesh with all of the other side. Shapes may meet where the
    balls around them do, in the two lengths that the motion of the joint does not change.
    """
    back = places[joint.parent].then(joint.origin.transform()).inverse()
    fixed = [(geom, _constant(joint, back.then(places[name]), geom)) for name in above for geom in geoms(name)]
    moved = [(geom, _constant(joint, places[name], geom)) for name in below for geom in geoms(name)]
    found: dict[tuple[str, str], list[Meeting]] = {}
    for one, (first, second) in fixed:
        for other, (x, y) in moved:
            if math.hypot(first - x, second - y) <= one.solid.radius + other.solid.radius + NEAR:
                found.setdefault((one.link, other.link), []).append((one, other))
    for links in ((one, other) for one in above for other in below):
        if links in found or links == (joint.parent, joint.child) or not meshes.isdisjoint(links):
            yield links, found.get(links, [])


def _constant(joint: Joint, place: Transform, geom: Geom) -> tuple[float, float]:
    """Return two lengths (m) of the middle of a shape that the motion of the joint does not change."""
    point, axis = place.apply(geom.solid.middle), unit(joint.axis)
    if joint.type == "floating":
        return 0.0, 0.0
    if joint.type == "ball":
        return norm(point), 0.0
    along = dot(axis, point)
    if joint.type == "planar":
        return along, 0.0
    if joint.type == "prismatic":
        one, other = plane_axes(joint.axis)
        return dot(one, point), dot(other, point)
    return along, math.sqrt(max(dot(point, point) - along * along, 0.0))


def _always_touch(
    robot: Robot,
    joint: Joint,
    places: Mapping[str, Transform],
    links: tuple[str, str],
    meeting: Sequence[Meeting],
) -> bool:
    """Return True if two links touch at zero, in each pose, and all over the range of the joint between them."""
    one, other = (places[name] for name in links)
    mine, theirs = ({geom.number: geom.solid for geom in side}.values() for side in zip(*meeting, strict=True))
    touching = Touching(list(mine), list(theirs))
    states = [{}, *(pose.positions for pose in robot.poses)] if joint.moves else []
    positions = [0.0, *(robot.position(joint, state) for state in states)]
    if joint.type in ("revolute", "continuous", "prismatic"):
        ends = position_range(joint) or ((-math.pi, math.pi) if joint.type == "continuous" else None)
        positions += [ends[0] + (ends[1] - ends[0]) * step / STEPS for step in range(STEPS + 1)] if ends else []
    base = one.inverse().then(places[joint.parent]).then(joint.origin.transform())
    ways = (motion(joint.type, joint.axis, at) for at in dict.fromkeys(positions))
    return all(touching.at(base.then(way).then(other)) for way in ways)


RULES = (Rule("not-in-mjx", "A note: MJX does not collide two shapes that may touch.", "Make one a capsule.", FORMATS),)

_ROUND = ("cylinder", "ellipsoid")
CANNOT = {
    *(frozenset((one, other)) for one in _ROUND for other in ("box", "mesh", HFIELD)),
    frozenset((HFIELD,)),
}


def refused(robot: Robot, output: Output) -> Iterator[tuple[tuple[str, str], tuple[str, int], tuple[str, int]]]:
    """Yield two kinds of shapes that MJX does not collide and MuJoCo does, with link and number of the first of each.

    Each two kinds come once.
    """
    implied = output.options.get("contacts", "implied") == "implied"
    masks, form, touching = Masks(robot, implied), form_of(output), contacts(robot, form_of(output), implied)
    # The first shape of each kind and mask of a link, with its number.
    looks: dict[str, dict[tuple[str, Mask], int]] = {}
    for link in robot.links:
        for number, shape in enumerate(link.collision):
            kind = _kind(robot, shape, form)
            if kind:
                looks.setdefault(link.name, {}).setdefault((kind, masks.of(link.name, shape)), number)
    paired = {frozenset((geom.link, _kind(robot, geom.solid.shape, form)) for geom in pair) for pair in touching.pairs}
    excluded = set(map(frozenset, touching.excluded))
    top_of = {name: top for top, names in weld_groups(robot).items() for name in names}
    above = {top: top_of[robot.joint_to[top].parent] for top in set(top_of.values()) if top in robot.joint_to}
    world = "" if robot.has_free_base(output) else robot.root  # the top of what is welded to the world
    found: set[frozenset[str]] = set()
    for one, other in combinations(looks, 2):
        tops = top_of[one], top_of[other]
        is_filtered = tops[0] == tops[1] or (world not in tops and bool({above.get(top) for top in tops} & set(tops)))
        is_excluded = frozenset((body_name(robot, one), body_name(robot, other))) in excluded
        for ((kind, mask), number), ((other_kind, other_mask), other_number) in product(
            looks[one].items(), looks[other].items()
        ):
            kinds = frozenset((kind, other_kind))
            if kinds not in CANNOT or kinds in found or not mask.meets(other_mask):
                continue
            if frozenset(((one, kind), (other, other_kind))) in paired or not (is_filtered or is_excluded):
                found.add(kinds)
                first, second = (kind, (one, number)), (other_kind, (other, other_number))
                if other_kind in _ROUND:
                    first, second = second, first
                yield (first[0], second[0]), first[1], second[1]


def _kind(robot: Robot, shape: Shape, form: str) -> str:
    geometry = shape.geometry
    if not has_volume(geometry) or (isinstance(geometry, Mesh) and not is_written(robot, geometry)):
        return ""
    if isinstance(geometry, HeightMap):
        return HFIELD if form == HFIELD else "box" if solids(shape, form) else ""
    return type(geometry).__name__.lower()


def check(case: Case, output: Output) -> Iterator[Diagnostic]:
    """Yield a note for each two kinds of shapes that may touch and that MJX does not collide: on the first of them."""
    if not case.robot.is_tree:  # reported by the rules about joints
        return
    for kinds, (link, number), (other, _) in refused(case.robot, output):
        message = f"MJX does not collide a {kinds[0]} with a {kinds[1]}, which may touch:"
        message += f' links "{link}" and "{other}"; it does not load the MJCF'
        help = "make one of them a capsule, or keep them apart: by the bits of their contact, or wheels by a drive"
        path = case.link(link, "collision", number)
        yield case.problem("not-in-mjx", message, path, help, severity=NOTE)
