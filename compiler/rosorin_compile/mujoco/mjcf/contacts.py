"""Compute the ``<exclude>`` elements for links that must not collide, and the ``<pair>`` elements for shapes that can.

By default, MuJoCo filters all contacts between two groups of welded bodies that a joint connects, if both can move.
This filters too much: a camera fixed to the wrist can collide with the gripper. ``<pair>`` elements bypass the filter.
Therefore, for each joint,

- the two links that it connects are excluded, because a simulation would push overlapping links apart; so are links
  that touch at zero, in each named pose and over the range of the joint, and links with meshes (not read here);
- for all other links, each pair of shapes that the joint can bring into contact is written, without friction.

Links that cannot collide because of ``ContactBits`` need neither element. The result is the same for a fixed
and a free base, because a robot can be attached to another robot. Distances of convex shapes are computed with GJK
(E. Gilbert, D. Johnson, S. Keerthi, "A fast procedure for computing the distance between complex objects in
three-dimensional space", 1988).

MJX, MuJoCo on accelerators, does not load a model in which cylinders or ellipsoids can collide with boxes, meshes or
height fields, or height fields with each other.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from functools import cache, cached_property
from itertools import combinations, product
from typing import NamedTuple

from rosorin_compile.model import Joint, Mesh, Output, Robot
from rosorin_compile.model.bounds import Ball, ball_of
from rosorin_compile.model.geometry import Transform, Vector, cross, dot, minus, norm, plane_axes, unit
from rosorin_compile.model.joint import motion
from rosorin_compile.model.shape import MERGED, Capsule, Cylinder, Ellipsoid, HeightMap, Shape, Sphere
from rosorin_compile.rules.case import Case
from rosorin_compile.source.cache import of_robot
from rosorin_compile.source.diagnostics import NOTE, Diagnostic

from . import bodies, servos
from .bodies import COLLISION, HFIELD, ContactBits, body_name, half_sizes, has_volume, numbered_solids, weld_groups
from .unsupported import is_written, position_range

NEAR = 1e-6  # m: tolerance, because rounding can separate faces that coincide
_STEPS = 100  # maximum number of GJK iterations; only curved surfaces that almost touch need more
_DONE = 1e-10  # relative improvement of the distance below which GJK stops
# Maximum number of contact pairs for two links, because MuJoCo tests every pair in each time step.
MOST = 300
STEPS = 24  # number of steps over a joint range to test whether two links always touch
_ORIGIN: Vector = (0.0, 0.0, 0.0)


class Solid:
    """A convex shape with its bounding sphere (m). Spheres and capsules are points or lines of radius ``margin``."""

    def __init__(self, shape: Shape, ball: Ball) -> None:
        self.shape, self.middle, self.radius, self.origin = shape, ball.middle, ball.radius, shape.origin().transform()
        geometry, (x, y, z) = shape.geometry, (*map(abs, half_sizes(shape.geometry)), 0.0, 0.0, 0.0)[:3]
        self.margin = x if isinstance(geometry, (Sphere, Capsule)) else 0.0
        # Half sizes (m) along the axes of the shape, without the margin.
        self.half_extents: Vector = (x, y, z)
        if isinstance(geometry, (Sphere, Capsule, Cylinder)):
            self.half_extents = (x - self.margin, x - self.margin, y)
            self.radius = math.hypot(x, y) if isinstance(geometry, Cylinder) else x + y

    @cached_property
    def pieces(self) -> Sequence[Solid]:
        """The boxes of a height map, or the shape itself if it is convex."""
        if not isinstance(self.shape.geometry, HeightMap):
            return (self,)
        return [solid for solid in map(solid_of, self.shape.solids(MERGED)) if solid is not None]

    def support(self, place: Transform, direction: Vector) -> Vector:
        """Return the point of the shape at pose ``place`` that is farthest in ``direction``, without the margin."""
        (a, b, c), (d, e, f), (g, h, i) = place.rows
        x, y, z = direction
        u, v, w = a * x + d * y + g * z, b * x + e * y + h * z, c * x + f * y + i * z
        r, s, t = self.half_extents
        if isinstance(self.shape.geometry, Ellipsoid):
            length = math.hypot(r * u, s * v, t * w)
            return place.apply((r * r * u / length, s * s * v / length, t * t * w / length))
        if isinstance(self.shape.geometry, Cylinder):
            length = math.hypot(u, v)
            u, v = (r * u / length, r * v / length) if length > 0 else (0.0, 0.0)
        else:
            u, v = math.copysign(r, u), math.copysign(s, v)
        return place.apply((u, v, math.copysign(t, w)))


def solid_of(shape: Shape) -> Solid | None:
    """Convert a shape to a solid, or return None for a mesh."""
    ball = ball_of(shape)
    return None if ball is None else Solid(shape, ball)


def touch(fixed: Sequence[Solid], moved: Sequence[Solid], way: Transform) -> bool:
    """Return True if a solid in ``fixed`` touches one in ``moved``, whose pose relative to ``fixed`` is ``way``."""
    others = [piece for solid in fixed for piece in solid.pieces]
    for solid in (piece for one in moved for piece in one.pieces):
        middle, limit = way.apply(solid.middle), solid.radius + NEAR
        gaps = [(math.dist(middle, other.middle) - other.radius, other) for other in others]
        near = sorted((one for one in gaps if one[0] <= limit), key=lambda one: one[0])
        if any(_are_close(other, solid, way) for _, other in near):
            return True
    return False


def _are_close(fixed: Solid, moved: Solid, way: Transform) -> bool:
    there, limit = way.then(moved.origin), NEAR + fixed.margin + moved.margin
    nearest = minus(fixed.origin.xyz, there.xyz)
    simplex: list[Vector] = []
    for _ in range(_STEPS):
        if (length := math.hypot(*nearest)) <= limit:
            return True
        x, y, z = nearest
        point = minus(fixed.support(fixed.origin, (-x, -y, -z)), moved.support(there, nearest))
        ahead = dot(nearest, point)
        # Stop if the distance is above the limit or no longer decreases.
        if ahead > limit * length or (simplex and length * length - ahead <= _DONE * length * length):
            return False
        nearest, simplex = _closest([*simplex, point])
        if len(simplex) == 4:  # the tetrahedron contains the origin
            return True
    return True


def _closest(simplex: Sequence[Vector]) -> tuple[Vector, list[Vector]]:
    """Return (point of a simplex closest to the origin, vertices of the smallest face with that point)."""
    is_around = len(simplex) == 4
    for index, apex in enumerate(simplex if is_around else ()):  # a flat tetrahedron cannot contain the origin
        a, b, c = (corner for at, corner in enumerate(simplex) if at != index)
        normal = cross(minus(b, a), minus(c, a))
        height = dot(normal, minus(apex, a))
        is_flat = abs(height) <= 1e-12 * math.hypot(*normal) * math.dist(apex, a)
        is_around = is_around and not is_flat and dot(normal, a) * height < 0
    if is_around:
        return _ORIGIN, list(simplex)
    feet = ((_foot(face), list(face)) for size in (1, 2, 3) for face in combinations(simplex, size))
    return min(((foot, face) for foot, face in feet if foot is not None), key=lambda pair: dot(pair[0], pair[0]))


def _foot(face: Sequence[Vector]) -> Vector | None:
    """Return the projection of the origin onto a point, segment or triangle, or None if the projection is outside."""
    if len(face) == 1:
        return face[0]
    a, b, *_ = face
    along = minus(b, a)
    normal = cross(along, minus(face[2], a)) if len(face) == 3 else along
    square = dot(normal, normal)
    if square == 0:
        return None
    shares = [1 + dot(a, along) / square, -dot(a, along) / square]
    if len(face) == 3:  # a triangle: test the barycentric coordinates
        shares = [dot(cross(p, q), normal) / square for p, q in ((b, face[2]), (face[2], a), (a, b))]
    if min(shares) <= 0:
        return None
    x, y, z = (sum(share * corner[k] for share, corner in zip(shares, face, strict=True)) for k in range(3))
    return (x, y, z)


class Geom(NamedTuple):
    """A collision shape of a link. ``number`` counts the geoms of the link from 1."""

    link: str
    number: int
    solid: Solid


Meeting = tuple[Geom, Geom]


class Contacts(NamedTuple):
    """Contacts to remove from or to add to an MJCF.

    ``excluded``: names of bodies that must not collide.
    ``pairs``: shapes that can collide although MuJoCo filters contacts between their bodies.
    """

    excluded: list[tuple[str, str]]
    pairs: list[Meeting]
    left: list[tuple[str, str]]  # links without pairs, because they would need more than ``MOST``


@of_robot
def contacts(robot: Robot, form: str = MERGED, implied: bool = True) -> Contacts:
    """Return the excludes and the contact pairs for the MJCF of a robot, with the names of bodies in the MJCF.

    ``form`` is the option ``height_maps`` (see ``form_of``). If ``implied`` is false, only the ``disabled_contacts`` of
    the description are excluded, and there are no pairs.
    """
    groups, masks = weld_groups(robot), ContactBits(robot, implied)
    top_of = {name: top for top, names in groups.items() for name in names}
    solid = {top: [name for name in names if robot.link[name].collision] for top, names in groups.items()}
    meshes = {link.name for link in robot.links for one in link.collision if isinstance(one.geometry, Mesh)}
    named = {frozenset(pair) for pair in robot.disabled_contacts}
    places: dict[str, Transform] = {}  # pose of each link relative to the topmost link of its welded group
    excluded: dict[frozenset[str], tuple[str, str]] = {}
    pairs, left = list[Meeting](), list[tuple[str, str]]()

    @cache
    def geoms(name: str) -> list[Geom]:
        shapes = numbered_solids(robot.link[name], COLLISION, form)
        every = ((number, solid_of(shape)) for number, shape in shapes if has_volume(shape.geometry))
        return [Geom(name, number, solid) for number, solid in every if solid is not None]

    def mask(geom: Geom) -> bodies.Mask:
        return masks.mask_of(geom.link, geom.solid.shape)

    for link in robot.walk():
        above = robot.joint_to.get(link.name)
        places[link.name] = places[above.parent].then(above.transform()) if above and above.is_fixed else Transform()
    for top, below in solid.items() if implied else ():
        joint = robot.joint_to.get(top)
        over = solid[top_of[joint.parent]] if joint is not None else []
        if joint is None or not below or not over:
            continue
        ends = (joint.parent, joint.child)
        if over == [joint.parent] and below == [joint.child]:  # only the adjacent links have shapes
            if masks.meet(*ends):
                excluded.setdefault(frozenset(ends), ends)
            continue
        # Shapes can only meet if their bounding spheres overlap in the two coordinates that the joint cannot change.
        back = places[joint.parent].then(joint.origin.transform()).inverse()
        fixed = [(geom, _constant(joint, back.then(places[name]), geom)) for name in over for geom in geoms(name)]
        moved = [(geom, _constant(joint, places[name], geom)) for name in below for geom in geoms(name)]
        found: dict[tuple[str, str], list[Meeting]] = {}
        for (one, here), (other, there) in product(fixed, moved):
            if math.dist(here, there) <= one.solid.radius + other.solid.radius + NEAR:
                found.setdefault((one.link, other.link), []).append((one, other))
        for links in product(over, below):
            meeting, is_hidden = found.get(links, []), links == ends or not meshes.isdisjoint(links)
            if not (meeting or is_hidden) or not masks.meet(*links):
                continue
            if is_hidden or _always_touch(robot, joint, places, links, meeting):
                excluded.setdefault(frozenset(links), links)
            elif len(meeting) > MOST:
                left.append(links)
            elif frozenset(links) not in named:
                pairs += [(one, other) for one, other in meeting if mask(one).meets(mask(other))]
    for pair in robot.disabled_contacts:
        if masks.rolling.isdisjoint(pair):  # contact bits already disable the contacts of wheels
            excluded.setdefault(frozenset(pair), pair)
    return Contacts([(body_name(robot, one), body_name(robot, other)) for one, other in excluded.values()], pairs, left)


def _constant(joint: Joint, place: Transform, geom: Geom) -> tuple[float, float]:
    """Return the two coordinates (m) of a shape's centre that the motion of a joint does not change."""
    point = place.apply(geom.solid.middle)
    along = dot(unit(joint.axis), point)
    if joint.type == "prismatic":
        one, other = plane_axes(joint.axis)
        return dot(one, point), dot(other, point)
    lengths = {"floating": (0.0, 0.0), "ball": (norm(point), 0.0), "planar": (along, 0.0)}
    return lengths.get(joint.type) or (along, math.sqrt(max(dot(point, point) - along * along, 0.0)))


def _always_touch(
    robot: Robot, joint: Joint, places: Mapping[str, Transform], links: tuple[str, str], meeting: Sequence[Meeting]
) -> bool:
    """Return True if two links touch at zero, in each named pose, and over the range of the joint."""
    one, other = (places[name] for name in links)
    mine, theirs = ({geom.number: geom.solid for geom in side}.values() for side in zip(*meeting, strict=True))
    states = [{}, *(pose.positions for pose in robot.poses)] if joint.moves else []
    positions = [0.0, *(robot.position(joint, state) for state in states)]
    if joint.type in ("revolute", "continuous", "prismatic"):
        ends = position_range(joint) or ((-math.pi, math.pi) if joint.type == "continuous" else None)
        positions += [ends[0] + (ends[1] - ends[0]) * step / STEPS for step in range(STEPS + 1)] if ends else []
    base = one.inverse().then(places[joint.parent]).then(joint.origin.transform())
    ways = (motion(joint.type, joint.axis, at) for at in dict.fromkeys(positions))
    return all(touch(list(mine), list(theirs), base.then(way).then(other)) for way in ways)


_ROUND = ("cylinder", "ellipsoid")
CANNOT = {*(frozenset((one, other)) for one in _ROUND for other in ("box", "mesh", HFIELD)), frozenset((HFIELD,))}


def refused_by_mjx(robot: Robot, output: Output) -> Iterator[tuple[tuple[str, str], tuple[str, int], tuple[str, int]]]:
    """Find shapes that can touch in MuJoCo, but whose kinds MJX does not support, such as a cylinder and a box.

    Yield ((kind, kind), (link, shape index), (link, shape index)) once for each combination of kinds.
    """
    implied, form = output.options.get("contacts", "implied") == "implied", bodies.form_of(output)
    masks, touching = ContactBits(robot, implied), contacts(robot, form, implied)
    # Index of the first shape in a link by (link, kind of shape, contact bits).
    looks: dict[tuple[str, str, bodies.Mask], int] = {}
    for name, (number, shape) in ((link.name, one) for link in robot.links for one in enumerate(link.collision)):
        if kind := _kind(robot, shape, form):
            looks.setdefault((name, kind, masks.mask_of(name, shape)), number)
    paired = {frozenset((geom.link, _kind(robot, geom.solid.shape, form)) for geom in pair) for pair in touching.pairs}
    excluded = set(map(frozenset, touching.excluded))
    top_of = {name: top for top, names in weld_groups(robot).items() for name in names}
    above = {top: top_of[robot.joint_to[top].parent] for top in set(top_of.values()) if top in robot.joint_to}
    world = "" if robot.has_free_base(output) else robot.root  # topmost link of the group fixed to the world
    kinds_here = {kind for _, kind, _ in looks}
    wanted, found = {kinds for kinds in CANNOT if kinds <= kinds_here}, set[frozenset[str]]()
    for first, second in combinations(looks, 2):
        if found == wanted:
            return
        (one, kind, mask), (other, other_kind, other_mask) = first, second
        kinds = frozenset((kind, other_kind))
        if one == other or kinds not in CANNOT or kinds in found or not mask.meets(other_mask):
            continue
        tops = top_of[one], top_of[other]
        is_filtered = tops[0] == tops[1] or (world not in tops and bool({above.get(top) for top in tops} & set(tops)))
        is_excluded = frozenset((body_name(robot, one), body_name(robot, other))) in excluded
        if frozenset(((one, kind), (other, other_kind))) in paired or not (is_filtered or is_excluded):
            found.add(kinds)
            if other_kind in _ROUND:
                first, second = second, first
            yield (first[1], second[1]), (first[0], looks[first]), (second[0], looks[second])


def _kind(robot: Robot, shape: Shape, form: str) -> str:
    geometry = shape.geometry
    if not has_volume(geometry) or (isinstance(geometry, Mesh) and not is_written(robot, geometry)):
        return ""
    if isinstance(geometry, HeightMap):
        return HFIELD if form == HFIELD else "box" if shape.solids(form) else ""
    return type(geometry).__name__.lower()


def check(case: Case, output: Output) -> Iterator[Diagnostic]:
    """Yield diagnostics for actuators, and notes about contacts between shapes that MJX does not support."""
    yield from servos.check(case, output)
    if not case.robot.is_tree:  # reported by other rules
        return
    for kinds, (link, number), (other, _) in refused_by_mjx(case.robot, output):
        message = f"MJX cannot load the MJCF: MJX has no collisions between a {kinds[0]} and a {kinds[1]}, but"
        message += f' links "{link}" and "{other}" may touch'
        help = 'make one of them a capsule, or exclude their contact with "contact" (for wheels, with "drive")'
        yield case.problem("not-in-mjx", message, case.link(link, "collision", number), help, severity=NOTE)
