"""Rules about shapes: sizes, scales of meshes, shapes far apart or inside each other, and materials."""

import math
from bisect import bisect_left, bisect_right
from collections.abc import Iterable, Iterator
from itertools import product
from typing import Any

from rosorin_compile.model import Box, Capsule, Cylinder, Ellipsoid, HeightMap, Joint, Link, Mesh, Robot, Shape, Sphere
from rosorin_compile.model.bounds import ball_of, bounds_of
from rosorin_compile.model.geometry import Transform, Vector, norm
from rosorin_compile.model.shape import Geometry, Material
from rosorin_compile.source.cache import of_robot
from rosorin_compile.source.diagnostics import NOTE, WARNING, Diagnostic, nearest
from rosorin_compile.source.rule_registry import JOINTS, NUMBERS, rule
from rosorin_compile.source.tree import Path, Seq, value_at
from rosorin_compile.source.units import has_unit
from rosorin_compile.source.wording import phrase, quote, suggest

from .case import Case, number
from .joints import pieces

# Meshes are in metres, millimetres (scale 0.001), inches (0.0254) or, seldom, other units of CAD programs. All of these
# units are smaller than 100 m and larger than a hundredth of a millimetre.
LARGEST_SCALE, SMALLEST_SCALE = 100.0, 1e-5
UNEVEN = 100.0  # ratio of scales along two axes; even a unit cube that is scaled to a table top only has 30
# Ratios of a length to the diagonal of the rest of the robot; millimetres instead of metres give 1000.
OUT_OF_PROPORTION, SEVERAL_OUT_OF_PROPORTION = 10.0, 15.0
LARGE = 2.0  # m; shorter lengths may be correct, such as a plate on a small joint
TINY = 0.005  # m; the smallest robots measure centimetres
ELSEWHERE = 0.25  # fraction of the larger diagonal; even rough collision shapes are closer to the visuals
ENVELOPE = 4  # a shape that contains this many links is a keep-out zone, such as a box around a hand
_SIDES = [side for side in product((-1, 0, 1), repeat=3) if any(side)]
_TURNS = [math.pi / 4 * step for step in range(8)]
_CLEARANCE = 1e-9  # m; equal shapes in the same place are not inside each other
BRIGHTEST = 1.01  # colour components are at most 1; larger values up to this are rounding errors
MAX_RELATED = 3


@rule("mesh-scale", "A warning: no unit explains the scale of a mesh.", "Check the units.", NUMBERS, "link", "always")
def mesh_scales(case: Case) -> Iterator[Diagnostic]:
    """Report scales of meshes that no unit of length explains."""
    for link, path, shape in case.shapes():
        if not isinstance(shape.geometry, Mesh):
            continue
        low, _, high = sorted(factors := [abs(factor) for factor in shape.geometry.scale])  # mirroring is allowed
        if low == 0 or not SMALLEST_SCALE <= high <= LARGEST_SCALE or high / low > UNEVEN:
            index = factors.index(high if high > LARGEST_SCALE else low)
            scale = ", ".join(map(number, shape.geometry.scale))
            message = f'a mesh of link "{link.name}" is scaled by [{scale}], which no unit of length explains'
            yield case.problem("mesh-scale", message, (*path, "mesh", "scale", index))


@rule("collision-elsewhere", "A warning: collision is far from visual.", "Correct `xyz`.", NUMBERS, "link", "always")
def collision_elsewhere(case: Case) -> Iterator[Diagnostic]:
    """Report collision shapes that are far from the visual shapes of their link."""
    for link in case.robot.links:
        visual, collision = bounds_of(link.visual), bounds_of(link.collision)
        gap = visual.gap(collision) if visual and collision else 0.0
        if visual and collision and gap > ELSEWHERE * max(visual.diagonal, collision.diagonal):
            path, related = case.link(link.name, "collision", 0), [("the visual", case.link(link.name, "visual", 0))]
            message = f'the collision of link "{link.name}" is {number(gap)} m away from its visual'
            yield case.problem("collision-elsewhere", message, case.value(path, "xyz"), related=related)


@rule("size-implausible", "A warning: a bare length dwarfs the robot.", "Write `120 mm`.", NUMBERS, "link", "always")
def proportions(case: Case) -> Iterator[Diagnostic]:
    """Report distances and sizes without a unit that are out of proportion to the rest of the robot."""
    robot = case.robot
    if not robot.is_tree:
        return
    distant = [joint for joint in robot.joints if max(map(abs, joint.origin.xyz)) > LARGE]
    # Wrong distances can hide each other, so also compare them with the robot without all of these distances.
    without_all = diagonal(robot, tuple(joint.name for joint in distant)) if len(distant) > 1 else 0.0
    for joint in distant:
        if not _is_world(robot, joint.parent):
            is_far = max(map(abs, joint.origin.xyz)) > SEVERAL_OUT_OF_PROPORTION * without_all
            rest = without_all if without_all and is_far else diagonal(robot, (joint.name,))
            what = f'joint "{joint.name}" places "{joint.child}" far away from "{joint.parent}"'
            yield from _lengths(case, what, case.joint(joint, "xyz"), joint.origin.xyz, rest)
    moved = [joint for joint in robot.joints if any(joint.origin.xyz)]
    if len(moved) < 2:  # a single object cannot be compared with the rest of the robot
        return
    size = diagonal(robot)
    for link, path, shape in case.shapes():
        key, side, value = longest(shape)
        place = (*path, *key)
        if max(map(abs, shape.pose.xyz)) > LARGE and not isinstance(shape.geometry, Mesh):
            what = f'a shape of link "{link.name}" is far away from its link'
            yield from _lengths(case, what, (*path, "xyz"), shape.pose.xyz, size + side)
        if size and side > max(LARGE, OUT_OF_PROPORTION * size) and not has_unit(value_at(case.tree, place)):
            message = f'a shape of link "{link.name}" is {number(side)} m long, the rest of the robot {number(size)} m'
            help = f'write "{number(value)} mm" if millimetres are meant, "{number(value)} m" if not'
            yield case.problem("size-implausible", message, place, help)
    if 0 < size < TINY and all(math.hypot(*joint.origin.xyz) < TINY for joint in moved):
        joint = max(moved, key=lambda joint: math.hypot(*joint.origin.xyz))
        place = case.joint(joint, "xyz", max(range(3), key=lambda index: abs(joint.origin.xyz[index])))
        message = f'the entire robot measures only {number(size * 1000)} mm (longest offset: joint "{joint.name}")'
        yield case.problem("size-implausible", message, place, 'write "xyz" and sizes in metres, or with a unit')


def _lengths(case: Case, what: str, path: Path, values: Vector, rest: float) -> Iterator[Diagnostic]:
    written = value_at(case.tree, path)
    texts = list(written) if isinstance(written, Seq) else list(values)
    limit = max(LARGE, OUT_OF_PROPORTION * rest)
    far = [i for i, value in enumerate(values) if rest > 0 and abs(value) > limit and not has_unit(texts[i])]
    if far:
        place = (*path, max(far, key=lambda index: abs(values[index])))
        numbers = phrase(number(values[index]) for index in far)
        message = f"{what} ({numbers} m{case.stand_in(place)}), but the rest of the robot measures {number(rest)} m"
        help = f'write the unit "mm" after {numbers} if millimetres are meant, "m" if not'
        yield case.problem("size-implausible", message, place, help)


@of_robot
def diagonal(robot: Robot, without: tuple[str, ...] = ()) -> float:
    """Return the diagonal (m) of the bounding box of a robot's frames and shapes, with joints at zero.

    ``without`` names joints whose translations are ignored. Large shapes and shapes far from their link are ignored,
    because they may be mistakes, and so is the distance from a root without shapes (the world).
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
            places[joint.child] = places[joint.parent].then(Transform(step.rows) if joint.name in without else step)
    points = [place.xyz for place in places.values()]
    for name, place in places.items():  # link names are unique in a tree
        for shape in (*robot.link[name].visual, *robot.link[name].collision):
            ball = ball_of(shape)
            bounds = bounds_of([shape]) if ball and max(2 * ball.radius, norm(ball.middle)) <= LARGE else None
            points += bounds.at(place) if bounds else ()
    size = math.hypot(*(max(values) - min(values) for values in zip(*points, strict=True)))
    return size if math.isfinite(size) else 0.0


def _is_world(robot: Robot, name: str) -> bool:
    """Return True for a root without shapes, which may be the world and far away from the robot."""
    link = robot.link[name]
    is_bare = not (link.visual or link.collision or link.inertial)
    return is_bare and name not in robot.joint_to and not name.startswith("base")


def longest(shape: Shape) -> tuple[Path, float, float]:
    """Return the longest side of a shape: (path, size in m, number at the path, such as a radius); zeros for a mesh."""
    geometry, kind = shape.geometry, type(shape.geometry).__name__.lower()
    sides: list[tuple[Path, float, float]] = [((), 0.0, 0.0)]
    if isinstance(geometry, Box):
        sides = [((kind, "size", index), size, size) for index, size in enumerate(geometry.size)]
    elif isinstance(geometry, Ellipsoid):
        sides = [((kind, "radii", index), 2 * radius, radius) for index, radius in enumerate(geometry.radii)]
    elif isinstance(geometry, HeightMap):
        count = max(len(geometry.heights), len(geometry.heights[0]))
        sides = [(("height_map", "cell"), geometry.cell * count, geometry.cell)]
    elif not isinstance(geometry, Mesh):
        length = 0.0 if isinstance(geometry, Sphere) else geometry.length
        sides = [((kind, "length"), length, length), ((kind, "radius"), 2 * geometry.radius, geometry.radius)]
    return max(sides, key=lambda side: side[1])


@rule("two-in-one-place", help="Move or remove one of the joints.", topic=NUMBERS, accept="joint", imported="always")
def duplicates(case: Case) -> Iterator[Diagnostic]:
    """A warning: two joints put links with equal shapes into the same place, such as a copied wheel."""
    first: dict[Any, Joint] = {}
    for joint in case.robot.joints:
        link = case.robot.link.get(joint.child)
        shapes = (*link.visual, *link.collision) if link else ()
        # Links with only tiny shapes, which are placeholders, may share a place.
        if all((ball := ball_of(shape)) is not None and ball.radius <= TINY for shape in shapes):
            continue
        looks = (len(link.visual) if link else 0, *((shape.geometry, shape.pose) for shape in shapes))
        axis = () if joint.is_fixed else joint.axis
        other = first.setdefault((joint.parent, joint.type, joint.origin, axis, looks), joint)
        if other is not joint:
            message = f'joints "{other.name}" and "{joint.name}" place links of the same shape at the same pose'
            related = [("the other joint", case.joint(other))]
            yield case.problem("two-in-one-place", message, case.value(case.joint(joint), "xyz"), related=related)


@rule("link-inside-link", help="Correct `xyz`, or disable the contact.", topic=JOINTS, accept="link", imported="always")
def contained_links(case: Case) -> Iterator[Diagnostic]:
    """A warning: a link is entirely inside a shape of another link, with joints at zero. Meshes are not checked."""
    robot = case.robot
    if not robot.has_poses:
        return
    places = robot.poses_in_root({})
    starts = {link.name: start for link in robot.links if (start := next(_points(link, places[link.name]), None))}
    firsts = [*zip(*starts.values(), strict=True)] or [(0.0,)]
    axis = max(range(len(firsts)), key=lambda axis: max(firsts[axis]) - min(firsts[axis]))  # axis of the largest extent
    order = sorted((start[axis], name) for name, start in starts.items())
    fixed = [(joint.parent, joint.child) for joint in robot.joints if joint.is_fixed]
    rigid = pieces([*zip(robot.link, robot.link, strict=True), *fixed])
    group = {name: index for index, names in enumerate(rigid) for name in names}
    near = {frozenset((group[joint.parent], group[joint.child])) for joint in robot.joints}
    apart = {frozenset(pair) for pair in robot.disabled_contacts}
    for outer in robot.links:
        for index, shape in enumerate(outer.collision or outer.visual):
            ball = ball_of(shape)
            if ball is None:
                continue
            middle = places[outer.name].apply(ball.middle)[axis]
            first = bisect_left(order, (middle - ball.radius, ""))
            last = bisect_right(order, (middle + ball.radius, "\uffff"))
            inside = [name for _, name in order[first:last] if group[name] != group[outer.name]]
            inside = [name for name in inside if frozenset((group[name], group[outer.name])) not in near]
            inside = [name for name in inside if frozenset((name, outer.name)) not in apart]
            to_shape = places[outer.name].then(shape.pose.transform()).inverse() if inside else Transform()
            inside = [name for name in inside if holds(shape.geometry, to_shape, [starts[name]])]  # nearly always none
            inside = [n for n in inside if holds(shape.geometry, to_shape, _points(robot.link[n], places[n]))]
            for name in inside if len(inside) < ENVELOPE else ():
                path = case.joint(robot.joint_to[name]) if name in robot.joint_to else case.link(name)
                place = case.value(path, "xyz")
                kind = "collision" if outer.collision else "visual"
                related = [("the surrounding shape", case.link(outer.name, kind, index))]
                message = f'link "{name}" is entirely inside link "{outer.name}"'
                yield case.problem("link-inside-link", message, place, related=related, key=place == path)


def _points(link: Link, place: Transform) -> Iterator[Vector]:
    shapes = link.collision or link.visual
    if not all(isinstance(shape.geometry, (Box, Sphere, Cylinder, Capsule)) for shape in shapes):
        return
    for shape in shapes:
        geometry, to_root = shape.geometry, place.then(shape.pose.transform())
        if isinstance(geometry, Box):
            for x, y, z in product(*zip(geometry.lower, geometry.upper, strict=True)):
                yield to_root.apply((x, y, z))
        elif isinstance(geometry, Sphere):
            for side in _SIDES:
                size = geometry.radius / math.hypot(*side)
                yield to_root.apply((side[0] * size, side[1] * size, side[2] * size))
        elif isinstance(geometry, (Cylinder, Capsule)):
            radius, half = geometry.radius, geometry.length / 2
            half += radius if isinstance(geometry, Capsule) else 0.0
            for turn, end in product(_TURNS, (-half, half)):
                yield to_root.apply((radius * math.cos(turn), radius * math.sin(turn), end))


def holds(geometry: Geometry, to_shape: Transform, points: Iterable[Vector]) -> bool:
    """Return True if ``to_shape`` maps all points into a box, sphere, cylinder or capsule; False for other shapes."""
    for point in points:
        x, y, z = to_shape.apply(point)
        depth = -math.inf  # depth of the point below the surface (m); negative outside
        if isinstance(geometry, Box):
            (a, b, c), (d, e, f) = geometry.lower, geometry.upper
            depth = min(x - a, d - x, y - b, e - y, z - c, f - z)
        elif isinstance(geometry, Sphere):
            depth = geometry.radius - math.hypot(x, y, z)
        elif isinstance(geometry, (Cylinder, Capsule)):
            depth = min(geometry.radius - math.hypot(x, y), geometry.length / 2 - abs(z))
        if depth <= _CLEARANCE:
            return False
    return True


def _materials(case: Case) -> Iterator[tuple[str, Path, Path, Material]]:
    for one in case.robot.materials:
        yield f'the material "{one.name}"', ("materials", one.name), ("materials", one.name), one
    for link, path, shape in case.shapes():
        if path[-2] == "visual":
            material = Material(shape.material, shape.rgba, shape.texture)
            yield f'a visual of link "{link.name}"', path, (*path, "material"), material


@rule("material-twice", help="Rename one of them: a URDF cannot have two materials with the same name.", topic=NUMBERS)
def definitions(case: Case) -> Iterator[Diagnostic]:
    """A material is defined twice with different colours or textures, in `materials` or in visuals."""
    first: dict[str, tuple[Path, Material]] = {}
    for _, _, path, material in _materials(case):
        if material.name and (material.rgba is not None or material.texture):
            place, other = first.setdefault(material.name, (path, material))
            if other != material:
                message = f'the material "{material.name}" is defined twice, with different colours or textures'
                yield case.problem("material-twice", message, path, related=[("the other definition", place)])


@rule("colour-range", help="Divide values from 0 to 255 by 255.", topic=NUMBERS, accept="link", imported="always")
def colour_range(case: Case) -> Iterator[Diagnostic]:
    """A warning: a component of a colour is below 0 or above 1."""
    for what, path, _, material in _materials(case):
        parts = material.rgba or (0.5,) * 4
        index = max(range(4), key=lambda part: abs(parts[part] - 0.5))
        if not 0 <= parts[index] <= BRIGHTEST:
            message = f'{what} has {number(parts[index])} in its "rgba", but values must be from 0 to 1'
            yield case.problem("colour-range", message, (*path, "rgba", index))


@rule("unknown-material", help="Correct the name, or add it to `materials`.", topic=NUMBERS)
def unknown_materials(case: Case) -> Iterator[Diagnostic]:
    """A note: a visual names a material that is not defined; a warning if a defined name is similar."""
    unknown: dict[str, list[Path]] = {}
    for _, _, path, material in _materials(case):
        if material.name and material.name not in case.robot.material:
            unknown.setdefault(material.name, []).append(path)
    for name in list(unknown):
        if close := nearest(name, case.robot.material):
            path, *others = unknown.pop(name)
            related = [("also used here", other) for other in others[:MAX_RELATED]]
            message, help = f'there is no material "{name}"', suggest(close)
            yield case.problem("unknown-material", message, path, help, related=related, severity=WARNING)
    if unknown:
        message = f"visuals use undefined materials: {quote(unknown, 8)}"
        yield case.problem("unknown-material", message, next(iter(unknown.values()))[0], severity=NOTE)
