"""MJX: MuJoCo on accelerators, which loads no model of which two shapes may touch that it cannot collide.

What it lacks (mujoco-mjx 3.17, JAX): cylinders and ellipsoids against boxes, meshes and height fields, and fields
against each other. The floor of a scene, a plane, meets all shapes.
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import combinations, product

from rosorin_compile.model import HeightMap, Mesh, Output, Robot, Shape
from rosorin_compile.rules.case import Case
from rosorin_compile.source.diagnostics import NOTE, Diagnostic
from rosorin_compile.source.rule_registry import Heading, Rule

from .bodies import body_name, weld_groups
from .contacts import contacts
from .height_fields import HFIELD, form_of, solids
from .masks import Mask, Masks
from .omissions import has_volume, is_written

RULES = (
    Rule(
        "not-in-mjx",
        "A note: two shapes of a robot may touch that MJX does not collide, such as a cylinder and a box: it loads no "
        "MJCF with these. MuJoCo itself does.",
        "Make one of them a capsule or a sphere, or keep them apart: by the bits of their `contact`, or wheels by a "
        "`drive`.",
        Heading.FORMATS,
    ),
)

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
    """Return the type of a shape in MuJoCo; empty if it has no geom."""
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
