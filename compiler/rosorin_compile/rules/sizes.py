"""Sizes: shapes and distances out of proportion, scales of meshes, shapes far apart or twice in one place."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from functools import partial
from itertools import product
from typing import Any

from rosorin_compile.model import Box, Capsule, Cylinder, Ellipsoid, HeightMap, Joint, Link, Mesh, Robot, Shape, Sphere
from rosorin_compile.model.bounds import Bounds, ball_of, bounds_of
from rosorin_compile.model.cached import of_robot
from rosorin_compile.model.geometry import Transform, Vector
from rosorin_compile.source.diagnostics import WARNING, Diagnostic
from rosorin_compile.source.rule_registry import NUMBERS, rule
from rosorin_compile.source.tree import Path, Seq, at, exists
from rosorin_compile.source.units import has_unit

from .case import Case, links_by_value, number

# Meshes are in metres, millimetres (0.001) or inches (0.0254), seldom in units of their own; no unit of length that
# drawings have is 100 m or a hundredth of a millimetre.
LARGEST_SCALE, SMALLEST_SCALE = 100.0, 1e-5
# One axis in another unit than the others; a unit cube that is scaled to a table top differs by 30.
UNEVEN = 100.0
# A length is this often the diagonal of the rest of the robot; millimetres for metres make 1000.
OUT_OF_PROPORTION = 10.0
SEVERAL_OUT_OF_PROPORTION = 15.0
# No robot is larger that has such shapes, and a plate on a small joint is no mistake.
LARGE = 2.0  # m
# All of a robot within this: the smallest that people build on joints are centimetres.
TINY = 0.005  # m
# Of the larger diagonal: collision that is a rough guess at the visual overlaps it at least nearly.
ELSEWHERE = 0.25


@rule(
    "mesh-scale",
    "A warning: a mesh is scaled to nothing, by a factor that no unit has, or very differently along its axes.",
    "0.001 makes metres of millimetres; a mesh in metres needs no scale.",
    NUMBERS,
    accept="link",
    imported="always",
)
def mesh_scales(case: Case) -> Iterator[Diagnostic]:
    """Scales of meshes that no unit explains."""
    return links_by_value(case.robot).problems(partial(_scales, case))


def _scales(case: Case, link: Link) -> Iterator[Diagnostic]:
    for purpose, shapes in (("visual", link.visual), ("collision", link.collision)):
        for number_, shape in enumerate(shapes):
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
            path = case.link(link.name, purpose, number_, "mesh", "scale", index)
            yield case.problem("mesh-scale", message, path, help, severity=WARNING)


@rule(
    "collision-elsewhere",
    "A warning: the collision shapes of a link are not where its visual shapes are.",
    "Correct `xyz` and `rpy` of one of them.",
    NUMBERS,
    accept="link",
    imported="always",
)
def collision_elsewhere(case: Case) -> Iterator[Diagnostic]:
    """Collision shapes away from the visual shapes of their link."""
    return links_by_value(case.robot).problems(partial(_elsewhere, case))


def _elsewhere(case: Case, link: Link) -> Iterator[Diagnostic]:
    if not (link.visual and link.collision):
        return
    one, other = ball_of(link.visual[0]), ball_of(link.collision[0])
    if one and other and math.dist(one.middle, other.middle) <= ELSEWHERE * 2 * max(one.radius, other.radius):
        return
    visual, collision = bounds_of(link.visual), bounds_of(link.collision)
    if visual is None or collision is None:
        return
    gap = visual.gap(collision)
    if gap > ELSEWHERE * max(visual.diagonal, collision.diagonal):
        path, other_path = case.link(link.name, "collision", 0), case.link(link.name, "visual", 0)
        message = (
            f'the collision of link "{link.name}"{case.stands_in(path)} is {number(gap)} m away from its visual: it is'
            f" around {_middle(collision)}, the visual{case.stands_in(other_path)} around {_middle(visual)}"
        )
        related = [case.related("the visual", other_path)]
        help = "correct xyz and rpy of one of them: both are relative to the frame of the link"
        place = (*path, "xyz") if exists(case.tree, (*path, "xyz")) else path
        yield case.problem("collision-elsewhere", message, place, help, related=related, severity=WARNING)


def _middle(bounds: Bounds) -> str:
    return f"[{', '.join(number((a + b) / 2) for a, b in zip(*bounds, strict=True))}]"


@rule(
    "size-implausible",
    "A warning: a length without a unit is many times the diagonal of the rest of the robot, or the whole robot "
    "measures a few millimetres.",
    "Sizes and `xyz` are in metres: write `120 mm`, or 0.12.",
    NUMBERS,
    accept="link",
    imported="always",
)
def proportions(case: Case) -> Iterator[Diagnostic]:
    """Distances and sizes without a unit that are out of proportion to the rest of the robot."""
    robot = case.robot
    if not robot.is_tree:
        return
    distant = [joint for joint in robot.joints if max(map(abs, joint.origin.xyz)) > LARGE]
    # Several mistakes hide each other: then the rest is the robot without any of these ways.
    without_all = diagonal(robot, tuple(joint.name for joint in distant)) if len(distant) > 1 else 0.0
    for joint in distant:
        if not _is_world(robot, joint.parent):
            way = max(map(abs, joint.origin.xyz))
            rest = diagonal(robot, (joint.name,))
            rest = without_all if without_all and way > SEVERAL_OUT_OF_PROPORTION * without_all else rest
            what = f'joint "{joint.name}" puts "{joint.child}" far away from "{joint.parent}"'
            yield from _lengths(case, what, case.joint(joint, "xyz"), joint.origin.xyz, rest)
    ways = [joint for joint in robot.joints if any(joint.origin.xyz)]
    if len(ways) > 1:  # else the robot is an object, or says nothing about its size
        yield from links_by_value(robot).problems(partial(_shapes, case))
    is_tiny = len(ways) > 1 and all(math.hypot(*joint.origin.xyz) < TINY for joint in ways)
    if is_tiny and 0 < (size := diagonal(robot)) < TINY:
        longest_way = max(ways, key=lambda joint: math.hypot(*joint.origin.xyz))
        xyz = longest_way.origin.xyz
        place = case.joint(longest_way, "xyz", max(range(3), key=lambda index: abs(xyz[index])))
        message = (
            f"the whole robot measures {number(size * 1000)} mm; its longest way between joints is that of"
            f' "{longest_way.name}"'
        )
        yield case.problem("size-implausible", message, place, "xyz and sizes are in metres", severity=WARNING)


def _shapes(case: Case, link: Link) -> Iterator[Diagnostic]:
    for purpose, shapes in (("visual", link.visual), ("collision", link.collision)):
        for index, shape in enumerate(shapes):
            xyz, path = shape.pose.xyz, case.link(link.name, purpose, index)
            key, size, written = longest(shape)
            if max(map(abs, xyz)) > LARGE and not isinstance(shape.geometry, Mesh):
                what = f'a shape of link "{link.name}" is far away from its link'
                yield from _lengths(case, what, (*path, "xyz"), xyz, diagonal(case.robot) + size)
            rest = diagonal(case.robot) if size > LARGE else 0.0
            if rest and size > OUT_OF_PROPORTION * rest and not has_unit(at(case.tree, (*path, *key))):
                place = (*path, *key)
                message = (
                    f'a shape of link "{link.name}" is {number(size)} m long{case.stands_in(place)}, and the rest of'
                    f" the robot measures {number(rest)} m"
                )
                help = f'write "{number(written)} mm" if millimetres are meant, "{number(written)} m" if not'
                yield case.problem("size-implausible", message, place, help, severity=WARNING)


def _lengths(case: Case, what: str, path: Path, values: Vector, rest: float) -> Iterator[Diagnostic]:
    """Yield a warning about the numbers of a vector, without units, that are far outside the rest of the robot."""
    written = at(case.tree, path)
    written = list(written) if isinstance(written, Seq) else list(values)
    far = [
        index
        for index, value in enumerate(values)
        if rest > 0 and abs(value) > max(LARGE, OUT_OF_PROPORTION * rest) and not has_unit(written[index])
    ]
    if far:
        place = (*path, max(far, key=lambda index: abs(values[index])))
        numbers = " and ".join(f"{number(abs(values[index]))} m" for index in far)
        message = f"{what}, by {numbers}{case.stands_in(place)}, and the rest of the robot measures {number(rest)} m"
        millimetres, metres = (_vector(written, far, unit) for unit in ("mm", "m"))
        help = f"write xyz: {millimetres} if millimetres are meant, {metres} if not"
        yield case.problem("size-implausible", message, place, help, severity=WARNING)


def _vector(values: Sequence[Any], indices: Sequence[int], unit: str) -> str:
    texts = [
        f"{number(v)} {unit}" if i in indices else getattr(v, "text", "") or number(v) for i, v in enumerate(values)
    ]
    return f"[{', '.join(texts)}]"


@of_robot
def diagonal(robot: Robot, without: tuple[str, ...] = ()) -> float:
    """Return the diagonal (m) of the frames and shapes of a robot at zero.

    ``without`` names joints whose translations are ignored. Large shapes and those far from their link do not count:
    they may be the mistake. Neither does the way from a bare root, the world, to a distant robot.
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
    sides = [max(values) - min(values) for values in zip(*points, strict=True)]
    size = math.hypot(*sides)
    return size if math.isfinite(size) else 0.0


def _is_world(robot: Robot, name: str) -> bool:
    """Return True for a bare frame at the root: where a robot is in the world may be far from it."""
    link = robot.link.get(name)
    is_bare = link is not None and not (link.visual or link.collision or link.inertial)
    return is_bare and name not in robot.joint_to and not name.startswith("base")


def longest(shape: Shape) -> tuple[Path, float, float]:
    """Return the keys of the number of a shape's longest side, that side (m), and the number; nothing of a mesh."""
    geometry: Any = shape.geometry
    if isinstance(geometry, Box):
        size = geometry.size
        return ("box", "size", max(range(3), key=lambda index: size[index])), max(size), max(size)
    if isinstance(geometry, Sphere):
        return ("sphere", "radius"), 2 * geometry.radius, geometry.radius
    if isinstance(geometry, Ellipsoid):
        radii = geometry.radii
        return ("ellipsoid", "radii", max(range(3), key=lambda index: radii[index])), 2 * max(radii), max(radii)
    if isinstance(geometry, (Cylinder, Capsule)):
        kind = "cylinder" if isinstance(geometry, Cylinder) else "capsule"
        sides = {"length": geometry.length, "radius": 2 * geometry.radius}
        key = max(sides, key=lambda name: sides[name])
        return (kind, key), sides[key], getattr(geometry, key)
    if isinstance(geometry, HeightMap):
        rows, columns = len(geometry.heights), len(geometry.heights[0])
        return ("height_map", "cell"), geometry.cell * max(rows, columns), geometry.cell
    return (), 0.0, 0.0


@rule(
    "two-in-one-place",
    "A warning: two joints put links of the same shape into the same place.",
    "Correct `xyz` of one of them, or remove it.",
    NUMBERS,
    accept="joint",
    imported="always",
)
def duplicates(case: Case) -> Iterator[Diagnostic]:
    """Joints that are equal except for their names, with equal links: a wheel that was copied and not moved."""
    first: dict[Any, Joint] = {}
    for joint in case.robot.joints:
        link = case.robot.link.get(joint.child)
        if len(case.robot.joints_from[joint.parent]) < 2 or link is None:
            continue
        shapes = (*link.visual, *link.collision)
        # A speck holds the place of a part that nobody drew.
        if all((ball := ball_of(shape)) is not None and ball.radius <= TINY for shape in shapes):
            continue
        looks = tuple((shape.geometry, shape.pose) for shape in shapes)
        axis = () if joint.is_fixed else joint.axis
        other = first.setdefault((joint.parent, joint.type, joint.origin, axis, len(link.visual), looks), joint)
        if other is not joint:
            message = (
                f'joints "{other.name}" and "{joint.name}" put "{other.child}" and "{joint.child}", which have the'
                f' same shape, into the same place of "{joint.parent}"'
            )
            path = case.joint(joint)
            place = (*path, "xyz") if exists(case.tree, (*path, "xyz")) else path
            related = [case.related("the other joint", case.joint(other), key=True)]
            help = "correct xyz of one of them, or remove it"
            yield case.problem("two-in-one-place", message, place, help, related=related, severity=WARNING)
