"""Shapes: sizes out of proportion, scales of meshes, shapes far apart or two in one place, and materials."""

from __future__ import annotations

import math
from collections.abc import Iterator
from itertools import product
from typing import Any

from rosorin_compile.model import Box, Capsule, Cylinder, Ellipsoid, HeightMap, Joint, Link, Mesh, Robot, Shape, Sphere
from rosorin_compile.model.bounds import Bounds, ball_of, bounds_of
from rosorin_compile.model.cached import of_robot
from rosorin_compile.model.geometry import Transform, Vector
from rosorin_compile.model.shape import Material, Rgba
from rosorin_compile.source.diagnostics import NOTE, WARNING, Diagnostic, nearest
from rosorin_compile.source.rule_registry import NUMBERS, rule
from rosorin_compile.source.tree import Path, Seq, at
from rosorin_compile.source.units import has_unit
from rosorin_compile.source.wording import quoted

from .case import Case, number, per_link

# Meshes are in metres, millimetres (0.001) or inches (0.0254), seldom in units of their own; no unit of length that
# drawings have is 100 m or a hundredth of a millimetre.
LARGEST_SCALE, SMALLEST_SCALE = 100.0, 1e-5
UNEVEN = 100.0  # an axis in another unit than the others; a unit cube that is scaled to a table top differs by 30
# A length is this often the diagonal of the rest of the robot; millimetres for metres make 1000.
OUT_OF_PROPORTION, SEVERAL_OUT_OF_PROPORTION = 10.0, 15.0
LARGE = 2.0  # m; no robot is larger that has such shapes, and a plate on a small joint is no mistake
TINY = 0.005  # m; the smallest robots that people build on joints are centimetres
ELSEWHERE = 0.25  # of the larger diagonal: collision that is a rough guess at the visual overlaps it at least nearly


@rule("mesh-scale", "A warning: no unit explains the scale of a mesh.", "Check units.", NUMBERS, "link", "always")
@per_link
def mesh_scales(case: Case, link: Link) -> Iterator[Diagnostic]:
    """Scales of meshes that no unit explains."""
    for path, shape in _shapes_of(case, link):
        if not isinstance(shape.geometry, Mesh):
            continue
        factors = [abs(factor) for factor in shape.geometry.scale]  # a mirror is legal
        low, high = min(factors), max(factors)
        if low == 0:
            wrong = "nothing is left of it"
        elif high > LARGEST_SCALE or high < SMALLEST_SCALE:
            wrong = f"no unit of a drawing is so {'large' if high > LARGEST_SCALE else 'small'}"
        elif high / low > UNEVEN:
            wrong = f"along another axis the factor is {number(high)}, {number(high / low)} times as much"
        else:
            continue
        index = factors.index(high if high > LARGEST_SCALE else low)
        message = f'a mesh of link "{link.name}" is scaled by {number(shape.geometry.scale[index])}: {wrong}'
        help = "0.001 makes metres of millimetres; without scale a mesh is in metres"
        yield case.problem("mesh-scale", message, (*path, "mesh", "scale", index), help)


def _shapes_of(case: Case, link: Link) -> Iterator[tuple[Path, Shape]]:
    for purpose, shapes in (("visual", link.visual), ("collision", link.collision)):
        for index, shape in enumerate(shapes):
            yield case.link(link.name, purpose, index), shape


@rule("collision-elsewhere", "A warning: collision and visual are far apart.", "Fix `xyz`.", NUMBERS, "link", "always")
@per_link
def collision_elsewhere(case: Case, link: Link) -> Iterator[Diagnostic]:
    """Collision shapes away from the visual shapes of their link."""
    visual, collision = bounds_of(link.visual), bounds_of(link.collision)
    if visual is None or collision is None:
        return
    gap = visual.gap(collision)
    if gap > ELSEWHERE * max(visual.diagonal, collision.diagonal):
        path, other = case.link(link.name, "collision", 0), case.link(link.name, "visual", 0)
        message = f'the collision of link "{link.name}"{case.stands_in(path)} is {number(gap)} m away from its visual:'
        message += f" it is around {_middle(collision)}, the visual{case.stands_in(other)} around {_middle(visual)}"
        help = "correct xyz and rpy of one of them: both are relative to the frame of the link"
        yield case.problem(
            "collision-elsewhere", message, case.value(path, "xyz"), help, related=[("the visual", other)]
        )


def _middle(bounds: Bounds) -> str:
    return f"[{', '.join(number((a + b) / 2) for a, b in zip(*bounds, strict=True))}]"


@rule("size-implausible", "A warning: a bare length dwarfs the robot.", "Write `120 mm`.", NUMBERS, "link", "always")
def proportions(case: Case) -> Iterator[Diagnostic]:
    """Distances and sizes without a unit that are out of proportion to the rest of the robot."""
    robot = case.robot
    if not robot.is_tree:
        return
    distant = [joint for joint in robot.joints if max(map(abs, joint.origin.xyz)) > LARGE]
    # Several mistakes hide each other: then the rest is the robot without any of these distances.
    without_all = diagonal(robot, tuple(joint.name for joint in distant)) if len(distant) > 1 else 0.0
    for joint in distant:
        if not _is_world(robot, joint.parent):
            rest = diagonal(robot, (joint.name,))
            is_far = max(map(abs, joint.origin.xyz)) > SEVERAL_OUT_OF_PROPORTION * without_all
            what = f'joint "{joint.name}" puts "{joint.child}" far away from "{joint.parent}"'
            rest = without_all if without_all and is_far else rest
            yield from _lengths(case, what, case.joint(joint, "xyz"), joint.origin.xyz, rest)
    moved = [joint for joint in robot.joints if any(joint.origin.xyz)]
    if len(moved) < 2:  # the robot is an object, or says nothing about its size
        return
    yield from per_link(_shapes)(case)
    if all(math.hypot(*joint.origin.xyz) < TINY for joint in moved) and 0 < (size := diagonal(robot)) < TINY:
        joint = max(moved, key=lambda joint: math.hypot(*joint.origin.xyz))
        place = case.joint(joint, "xyz", max(range(3), key=lambda index: abs(joint.origin.xyz[index])))
        message = f'the whole robot measures {number(size * 1000)} mm; its longest joint is "{joint.name}"'
        yield case.problem("size-implausible", message, place, "xyz and sizes are in metres")


def _shapes(case: Case, link: Link) -> Iterator[Diagnostic]:
    for path, shape in _shapes_of(case, link):
        key, size, written = longest(shape)
        place = (*path, *key)
        if max(map(abs, shape.pose.xyz)) > LARGE and not isinstance(shape.geometry, Mesh):
            what = f'a shape of link "{link.name}" is far away from its link'
            yield from _lengths(case, what, (*path, "xyz"), shape.pose.xyz, diagonal(case.robot) + size)
        rest = diagonal(case.robot) if size > LARGE else 0.0
        if rest and size > OUT_OF_PROPORTION * rest and not has_unit(at(case.tree, place)):
            message = f'a shape of link "{link.name}" is {number(size)} m long{case.stands_in(place)}, and the rest of'
            message += f" the robot measures {number(rest)} m"
            help = f'write "{number(written)} mm" if millimetres are meant, "{number(written)} m" if not'
            yield case.problem("size-implausible", message, place, help)


def _lengths(case: Case, what: str, path: Path, values: Vector, rest: float) -> Iterator[Diagnostic]:
    """Yield a warning about the numbers of a vector, without units, that are far outside the rest of the robot."""
    written = at(case.tree, path)
    texts = list(written) if isinstance(written, Seq) else list(values)
    limit = max(LARGE, OUT_OF_PROPORTION * rest)
    far = [i for i, value in enumerate(values) if rest > 0 and abs(value) > limit and not has_unit(texts[i])]
    if far:
        place = (*path, max(far, key=lambda index: abs(values[index])))
        numbers = " and ".join(f"{number(abs(values[index]))} m" for index in far)
        message = f"{what}, by {numbers}{case.stands_in(place)}, and the rest of the robot measures {number(rest)} m"
        both = [
            [f"{number(v)} {unit}" if i in far else getattr(v, "text", "") or number(v) for i, v in enumerate(texts)]
            for unit in ("mm", "m")
        ]
        millimetres, metres = (f"[{', '.join(vector)}]" for vector in both)
        help = f"write xyz: {millimetres} if millimetres are meant, {metres} if not"
        yield case.problem("size-implausible", message, place, help)


@of_robot
def diagonal(robot: Robot, without: tuple[str, ...] = ()) -> float:
    """Return the diagonal (m) of the frames and shapes of a robot at zero.

    ``without`` names joints whose translations are ignored. Large shapes and those far from their link do not count:
    they may be the mistake. Neither does the distance from a bare root, the world, to a distant robot.
    """
    if not robot.is_tree:
        return 0.0
    places = {robot.root: Transform()}
    first = robot.joints_from.get(robot.root, ())
    if _is_world(robot, robot.root) and len(first) == 1 and math.hypot(*first[0].origin.xyz) > LARGE:
        places = {first[0].child: Transform()}
    for joint in robot.joints_down():
        if joint.parent in places and joint.child not in places:
            step = joint.origin.transform()
            step = Transform(step.rows) if joint.name in without else step
            places[joint.child] = places[joint.parent].then(step)
    points = [place.xyz for place in places.values()]
    for name, place in places.items():
        link = robot.link.get(name)
        for shape in (*link.visual, *link.collision) if link else ():
            ball = ball_of(shape)
            bounds = bounds_of([shape]) if ball and max(2 * ball.radius, math.hypot(*ball.middle)) <= LARGE else None
            corners = product(*zip(*bounds, strict=True)) if bounds else ()
            points += [place.apply((x, y, z)) for x, y, z in corners]
    size = math.hypot(*(max(values) - min(values) for values in zip(*points, strict=True)))
    return size if math.isfinite(size) else 0.0


def _is_world(robot: Robot, name: str) -> bool:
    """Return True for a bare frame at the root: where a robot is in the world may be far from it."""
    link = robot.link.get(name)
    is_bare = link is not None and not (link.visual or link.collision or link.inertial)
    return is_bare and name not in robot.joint_to and not name.startswith("base")


def longest(shape: Shape) -> tuple[Path, float, float]:
    """Return the keys of the number of a shape's longest side, that side (m), and the number; nothing of a mesh."""
    geometry: Any = shape.geometry
    sides: dict[Path, tuple[float, float]] = {(): (0.0, 0.0)}
    if isinstance(geometry, Box):
        sides = {("box", "size", index): (size, size) for index, size in enumerate(geometry.size)}
    elif isinstance(geometry, Sphere):
        sides = {("sphere", "radius"): (2 * geometry.radius, geometry.radius)}
    elif isinstance(geometry, Ellipsoid):
        sides = {("ellipsoid", "radii", index): (2 * radius, radius) for index, radius in enumerate(geometry.radii)}
    elif isinstance(geometry, (Cylinder, Capsule)):
        kind = "cylinder" if isinstance(geometry, Cylinder) else "capsule"
        sides = {(kind, "length"): (geometry.length,) * 2, (kind, "radius"): (2 * geometry.radius, geometry.radius)}
    elif isinstance(geometry, HeightMap):
        count = max(len(geometry.heights), len(geometry.heights[0]))
        sides = {("height_map", "cell"): (geometry.cell * count, geometry.cell)}
    key = max(sides, key=lambda name: sides[name][0])
    return key, *sides[key]


@rule("two-in-one-place", help="Correct `xyz` of one, or remove it.", topic=NUMBERS, accept="joint", imported="always")
def duplicates(case: Case) -> Iterator[Diagnostic]:
    """A warning: two joints put links of the same shape into the same place, as a wheel that was copied."""
    first: dict[Any, Joint] = {}
    for joint in case.robot.joints:
        link = case.robot.link.get(joint.child)
        shapes = (*link.visual, *link.collision) if link else ()
        # A speck is a placeholder for a part that nobody drew.
        if all((ball := ball_of(shape)) is not None and ball.radius <= TINY for shape in shapes):
            continue
        looks = (len(link.visual) if link else 0, *((shape.geometry, shape.pose) for shape in shapes))
        axis = () if joint.is_fixed else joint.axis
        other = first.setdefault((joint.parent, joint.type, joint.origin, axis, looks), joint)
        if other is not joint:
            message = f'joints "{other.name}" and "{joint.name}" put "{other.child}" and "{joint.child}", which have'
            message += f' the same shape, into the same place of "{joint.parent}"'
            related = [("the other joint", case.joint(other))]
            yield case.problem("two-in-one-place", message, case.value(case.joint(joint), "xyz"), related=related)


# --- materials ---

BRIGHTEST = 1.01  # a hundredth above one is rounding of a colour that was made by hand
MAX_RELATED = 3


def _visuals(case: Case) -> Iterator[tuple[str, Path, Shape]]:
    for link in case.robot.links:
        for index, visual in enumerate(link.visual):
            yield f'a visual of link "{link.name}"', case.link(link.name, "visual", index), visual


@rule("material-twice", help="Give one of them another name; it has one meaning in the whole URDF.", topic=NUMBERS)
def definitions(case: Case) -> Iterator[Diagnostic]:
    """A material has two looks: in `materials` and in a visual, or in two visuals."""
    named = [one for one in case.robot.materials if one.rgba is not None or one.texture]
    defined: list[tuple[Path, Material]] = [(("materials", one.name), one) for one in named]
    defined += [
        ((*path, "material"), Material(visual.material, visual.rgba, visual.texture))
        for _, path, visual in _visuals(case)
        if visual.material and (visual.rgba is not None or visual.texture)
    ]
    first: dict[str, tuple[Path, Material]] = {}
    for path, material in defined:
        place, other = first.setdefault(material.name, (path, material))
        if other != material:
            message = f'the material "{material.name}" is {_look(material)} here and {_look(other)} elsewhere'
            yield case.problem("material-twice", message, path, related=[("the other one", place)])


def _look(material: Material) -> str:
    colour = f"rgba [{', '.join(map(number, material.rgba))}]" if material.rgba is not None else ""
    return " with ".join(filter(None, [colour, material.texture and f'texture "{material.texture}"']))


@rule("colour-range", help="Divide values of 0 to 255 by 255.", topic=NUMBERS, accept="link", imported="always")
def colour_range(case: Case) -> Iterator[Diagnostic]:
    """A warning: a part of a colour is below 0 or above 1."""
    colours: list[tuple[str, Path, Rgba | None]] = [(what, path, one.rgba) for what, path, one in _visuals(case)]
    colours += [(f'the material "{one.name}"', ("materials", one.name), one.rgba) for one in case.robot.materials]
    for what, path, rgba in colours:
        parts = rgba or (0.5,) * 4
        index = max(range(4), key=lambda part: abs(parts[part] - 0.5))
        if not 0 <= parts[index] <= BRIGHTEST:
            message = f"{what} has {number(parts[index])} in its rgba: each is from 0 to 1"
            yield case.problem("colour-range", message, (*path, "rgba", index))


@rule("unknown-material", help="Correct the name, or add it to `materials`.", topic=NUMBERS)
def unknown_materials(case: Case) -> Iterator[Diagnostic]:
    """A note: no material is defined under the name in a visual; a warning if the name is nearly a defined one."""
    unknown: dict[str, list[Path]] = {}
    for _, path, visual in _visuals(case):
        if visual.material and visual.material not in case.robot.material:
            unknown.setdefault(visual.material, []).append((*path, "material"))
    for name in list(unknown):
        close = nearest(name, case.robot.material)
        if close:
            path, *others = unknown.pop(name)
            related = [("also used here", other) for other in others[:MAX_RELATED]]
            message, help = f'there is no material "{name}"', f'did you mean "{close}"?'
            yield case.problem("unknown-material", message, path, help, related=related, severity=WARNING)
    if unknown:
        names = list(unknown)
        message = (
            f"{'a material of visuals is' if len(names) == 1 else f'{len(names)} materials of visuals are'} defined"
        )
        help = "add materials: {NAME: {rgba: [...]}} where readers do not know them"
        message += f" nowhere: {quoted(names, 8)}"
        yield case.problem("unknown-material", message, unknown[names[0]][0], help, severity=NOTE)
