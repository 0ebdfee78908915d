"""Sizes: shapes in millimetres or shrunk, scales of meshes, and what stands elsewhere or twice in one place."""

from __future__ import annotations

import math
from collections.abc import Iterator
from functools import partial
from typing import Any

from rosorin_compile.model import (
    Box,
    Capsule,
    Cylinder,
    Ellipsoid,
    HeightMap,
    Joint,
    Link,
    Mesh,
    Robot,
    Shape,
    Sphere,
    Vector,
)
from rosorin_compile.model.bounds import Bounds, ball_of, bounds_of
from rosorin_compile.model.cached import of_robot
from rosorin_compile.source.diagnostics import WARNING, Diagnostic
from rosorin_compile.source.rule_registry import NUMBERS, rule
from rosorin_compile.source.tree import Path, Seq, at, exists
from rosorin_compile.source.units import has_unit

from . import shared_values
from .case import Case, number

# Meshes are in metres, millimetres (0.001) or inches (0.0254), seldom in units of their own; no unit of length that
# drawings have is 100 m or a hundredth of a millimetre.
LARGEST_SCALE, SMALLEST_SCALE = 100.0, 1e-5
# One axis in another unit than the others; a unit cube that is scaled to a table top differs by 30.
UNEVEN = 100.0
# A shape is this often as long as all ways between joints together: 6 times is the most of 600 public robots, and
# millimetres for metres make 1000.
OVERSIZED = 20.0
# A joint is this often as far as all others together.
FAR_OFF = 10.0
# No robot is larger that has such shapes, and a plate on a small joint is no mistake.
LARGE = 2.0  # m
NO_WAY = (0.0, 0.0, 0.0)
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
@rule(
    "collision-elsewhere",
    "A warning: what a link collides with does not stand where the link is seen.",
    "Correct `xyz` and `rpy` of one of them.",
    NUMBERS,
    accept="link",
    imported="always",
)
def shapes(case: Case) -> Iterator[Diagnostic]:
    """Scales of meshes, and collision away from the visual."""
    return shared_values.links(case.robot).problems(partial(_shapes, case))


def _shapes(case: Case, link: Link) -> Iterator[Diagnostic]:
    for purpose, own in (("visual", link.visual), ("collision", link.collision)):
        for index, shape in enumerate(own):
            if isinstance(shape.geometry, Mesh):
                yield from _scale(case, link, shape.geometry, case.link(link.name, purpose, index, "mesh", "scale"))
    if link.visual and link.collision:
        yield from _elsewhere(case, link)


def _scale(case: Case, link: Link, mesh: Mesh, path: Path) -> Iterator[Diagnostic]:
    factors = [abs(factor) for factor in mesh.scale]  # a mirror is legal
    low, high = min(factors), max(factors)
    index = factors.index(high if high > LARGEST_SCALE else low)
    place = (*path, index)
    said = f'a mesh of link "{link.name}" is scaled by {number(mesh.scale[index])}'
    help = "0.001 makes metres of millimetres; without scale a mesh is in metres"
    if low == 0:
        message = f"{said}: nothing is left of it"
        yield case.problem("mesh-scale", message, place, help, severity=WARNING)
    elif high > LARGEST_SCALE or high < SMALLEST_SCALE:
        message = f"{said}: no unit of a drawing is so {'large' if high > LARGEST_SCALE else 'small'}"
        yield case.problem("mesh-scale", message, place, help, severity=WARNING)
    elif high / low > UNEVEN:
        message = f"{said} along one axis and by {number(high)} along another: {number(high / low)} times as much"
        yield case.problem("mesh-scale", message, place, help, severity=WARNING)


def _elsewhere(case: Case, link: Link) -> Iterator[Diagnostic]:
    one, other = ball_of(link.visual[0]), ball_of(link.collision[0])
    if one and other and math.dist(one.middle, other.middle) <= ELSEWHERE * 2 * max(one.radius, other.radius):
        return
    seen, felt = bounds_of(link.visual), bounds_of(link.collision)
    if seen is None or felt is None:
        return
    gap = seen.gap(felt)
    if gap <= ELSEWHERE * max(seen.diagonal, felt.diagonal):
        return
    path, visual = case.link(link.name, "collision", 0), case.link(link.name, "visual", 0)
    message = (
        f'link "{link.name}" collides {number(gap)} m away from where it is seen: its collision'
        f"{case.stands_in(path)} is around {_middle(felt)}, its visual{case.stands_in(visual)} around {_middle(seen)}"
    )
    place = (*path, "xyz") if exists(case.tree, (*path, "xyz")) else path
    related = [case.related("the visual", visual)]
    help = "correct xyz and rpy of one of them: both are seen from the frame of the link"
    yield case.problem("collision-elsewhere", message, place, help, related=related, severity=WARNING)


def _middle(bounds: Bounds) -> str:
    return f"[{', '.join(number((a + b) / 2) for a, b in zip(*bounds, strict=True))}]"


@rule(
    "size-implausible",
    "A warning: a shape or the way to a joint is very long against all ways between joints, or a whole robot measures "
    "a few millimetres.",
    "Sizes and `xyz` are in metres: write `120 mm`, or 0.12.",
    NUMBERS,
    accept="link",
    imported="always",
)
def robot_size(case: Case) -> Iterator[Diagnostic]:
    """Shapes and joints of one robot that are not in one unit."""
    ways = [joint for joint in case.robot.joints if joint.origin.xyz != NO_WAY]
    reach = all_ways(case.robot)
    if not ways or not reach > 0:  # an object, or a robot that says nothing about its size
        return
    kinds = shared_values.links(case.robot)
    far = [joint for joint in ways if math.hypot(*joint.origin.xyz) > LARGE]
    largest = 0.0
    if far or reach < TINY or len(ways) == 1:
        shapes = (shape for link in kinds.first.values() for shape in (*link.visual, *link.collision))
        largest = max((longest(shape)[1] for shape in shapes), default=0.0)
    for joint in far:
        yield from _far(case, joint, reach, largest)
    if len(ways) > 1:
        yield from kinds.problems(partial(_oversized, case, reach))
        yield from kinds.problems(partial(_far_shapes, case, reach))
        if reach + largest < TINY:
            first = max(ways, key=lambda joint: math.hypot(*joint.origin.xyz))
            yield _tiny(case, first, reach + largest)


@of_robot
def all_ways(robot: Robot) -> float:
    """Return how long all ways between joints of a robot are together (m)."""
    return math.fsum(math.hypot(*joint.origin.xyz) for joint in robot.joints)


def _oversized(case: Case, reach: float, link: Link) -> Iterator[Diagnostic]:
    """Yield a warning about each shape that is very long against all ways between joints, ``reach``."""
    for purpose, own in (("visual", link.visual), ("collision", link.collision)):
        for index, shape in enumerate(own):
            key, size, said = longest(shape)
            if size > LARGE and reach * OVERSIZED < size:
                place = case.link(link.name, purpose, index, *key)
                message = (
                    f'a shape of link "{link.name}" is {number(size)} m long{case.stands_in(place)}, and all ways'
                    f" between joints of the robot are {number(reach)} m"
                )
                help = f'write "{number(said)} mm" if millimetres are meant'
                yield case.problem("size-implausible", message, place, help, severity=WARNING)


def _far(case: Case, joint: Joint, reach: float, largest: float) -> Iterator[Diagnostic]:
    """Yield a warning about a joint that is farther than all others together, by a bare number.

    Of the only joint that has a way, the ``largest`` shape (m) says how large the robot is.
    """
    way = math.hypot(*joint.origin.xyz)
    others = reach - way
    alone = others <= 0
    if way <= FAR_OFF * (largest if alone else others) or (alone and not largest) or _is_world(case, joint.parent):
        return
    rest = "the largest shape" if alone else "all other ways between joints"
    message = f'joint "{joint.name}" puts "{joint.child}" {number(way)} m away from "{joint.parent}"'
    size = f"{rest} of the robot {'is' if alone else 'are'} {number(largest if alone else others)} m"
    yield from _by_bare_numbers(case, message, size, case.joint(joint, "xyz"), joint.origin.xyz)


def _far_shapes(case: Case, reach: float, link: Link) -> Iterator[Diagnostic]:
    """Yield a warning about each shape that stands far away from its link, against all ways between joints."""
    for purpose, own in (("visual", link.visual), ("collision", link.collision)):
        for index, shape in enumerate(own):
            way, size = math.hypot(*shape.pose.xyz), longest(shape)[1]
            if isinstance(shape.geometry, Mesh) or way <= max(LARGE, FAR_OFF * (reach + size)):
                continue
            message = f'a shape of link "{link.name}" stands {number(way)} m away from its link'
            size_of_all = f"all ways between joints of the robot are {number(reach)} m"
            place = case.link(link.name, purpose, index, "xyz")
            yield from _by_bare_numbers(case, message, size_of_all, place, shape.pose.xyz)


def _by_bare_numbers(case: Case, message: str, size: str, path: Path, xyz: Vector) -> Iterator[Diagnostic]:
    """Yield a warning about a position that its numbers, without units, put far away; ``size`` is that of the robot."""
    written = at(case.tree, path)
    values = list(written) if isinstance(written, Seq) else list(xyz)
    if any(has_unit(value) for value in values):
        return
    meant = (f"[{', '.join(f'{number(v)} {unit}' if v else '0' for v in values)}]" for unit in ("mm", "m"))
    millimetres, metres = meant
    place = (*path, max(range(3), key=lambda index: abs(xyz[index])))
    told = f"{message}{case.stands_in(place)}, and {size}"
    help = f"write xyz: {millimetres} if millimetres are meant, {metres} if not"
    yield case.problem("size-implausible", told, place, help, severity=WARNING)


def _is_world(case: Case, name: str) -> bool:
    """Say whether a link is a mere frame at the root: where a robot stands in the world may be far from it."""
    link = case.robot.link.get(name)
    mere = link is not None and not (link.visual or link.collision or link.inertial)
    return mere and name not in case.robot.joint_to


def _tiny(case: Case, joint: Joint, size: float) -> Diagnostic:
    xyz = joint.origin.xyz
    place = case.joint(joint, "xyz", max(range(3), key=lambda index: abs(xyz[index])))
    message = (
        f"all shapes and ways between joints of the robot are {number(size * 1000)} mm long together; the longest"
        f' way is that of joint "{joint.name}"'
    )
    help = "xyz and sizes are in metres"
    return case.problem("size-implausible", message, place, help, severity=WARNING)


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


def _is_speck(link: Link) -> bool:
    """Say whether the shapes of a link are too small for a part: they keep the place of one that nobody drew."""
    balls = [ball_of(shape) for shape in (*link.visual, *link.collision)]
    return all(ball is not None and ball.radius <= TINY for ball in balls)


@rule(
    "two-in-one-place",
    "A warning: two joints put links of the same shape into the same place.",
    "Correct `xyz` of one of them, or remove it.",
    NUMBERS,
    accept="joint",
    imported="always",
)
def twins(case: Case) -> Iterator[Diagnostic]:
    """Joints that are equal in all but their names, with equal links: a wheel that was copied and not moved."""
    first: dict[Any, Joint] = {}
    for joint in case.robot.joints:
        if len(case.robot.joints_from[joint.parent]) < 2:
            continue
        link = case.robot.link.get(joint.child)
        if link is None or not (link.visual or link.collision) or _is_speck(link):
            continue
        looks = tuple((shape.geometry, shape.pose) for shape in (*link.visual, *link.collision))
        axis = () if joint.is_fixed else joint.axis
        other = first.setdefault((joint.parent, joint.type, joint.origin, axis, len(link.visual), looks), joint)
        if other is joint:
            continue
        message = (
            f'joints "{other.name}" and "{joint.name}" put "{other.child}" and "{joint.child}", which have the same'
            f' shape, into the same place of "{joint.parent}"'
        )
        path = case.joint(joint)
        place = (*path, "xyz") if exists(case.tree, (*path, "xyz")) else path
        related = [case.related("the other one", case.joint(other), key=True)]
        help = "correct xyz of one of them, or remove it"
        yield case.problem("two-in-one-place", message, place, help, related=related, severity=WARNING)
