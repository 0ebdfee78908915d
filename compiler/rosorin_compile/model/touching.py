"""Whether two solids touch, without an engine: boxes, cylinders, capsules, spheres and ellipsoids at any pose.

The distance of two convex bodies is that of their Minkowski difference from the origin, which is approached by
simplices of support points (E. G. Gilbert, D. W. Johnson, S. S. Keerthi, "A fast procedure for computing the distance
between complex objects in three-dimensional space", 1988). A sphere is a point and a capsule a line with a radius
around it. The search is short, for only whether a distance is reached is asked: a support plane that is farther away
ends it. The closest point of a simplex: C. Ericson, "Real-Time Collision Detection", 2005, chapter 5.
"""

from __future__ import annotations

import math
from bisect import bisect_left, bisect_right
from collections.abc import Sequence
from functools import cached_property
from typing import NamedTuple

from .bounds import ball_of
from .geometry import Transform, Vector, dot, minus, plus
from .shape import MERGED, Box, Capsule, Cylinder, Ellipsoid, HeightMap, Shape, Sphere

# Faces that lie on each other touch, whatever the rounding of the poses made of it (m).
NEAR = 1e-6
_STEPS = 100  # a search that goes on for longer is one along round faces that hardly are apart
_DONE = 1e-10  # relative: the distance gets no better

Simplex = list[Vector]


class _Core(NamedTuple):
    """A convex body seen from some frame: what is at ``place``, and how much is around it on all sides (m).

    ``half`` are the half extents of a box; of what is ``round`` about z the radius, the same, and the half length; of
    what is ``oval`` the radii.
    """

    place: Transform
    half: Vector
    round: bool = False
    oval: bool = False
    around: float = 0.0

    def support(self, direction: Vector) -> Vector:
        """Return the point that is farthest in a direction, without what is around it."""
        (a, b, c), (d, e, f), (g, h, i) = self.place.rows
        x, y, z = direction
        u, v, w = a * x + d * y + g * z, b * x + e * y + h * z, c * x + f * y + i * z
        r, s, half = self.half
        if self.oval:
            length = math.hypot(r * u, s * v, half * w)
            return self.place.apply((r * r * u / length, s * s * v / length, half * half * w / length))
        if self.round:
            length = math.hypot(u, v)
            u, v = (r * u / length, r * v / length) if length > 0 else (0.0, 0.0)
        else:
            u, v = math.copysign(r, u), math.copysign(s, v)
        return self.place.apply((u, v, math.copysign(half, w)))


class Solid:
    """A shape of known size in the frame of its link, with a ball around it: its middle and its radius (m)."""

    def __init__(self, shape: Shape, middle: Vector, radius: float) -> None:
        self.shape = shape
        self.middle = middle
        self.radius = radius

    @cached_property
    def pieces(self) -> Sequence[Solid]:
        """What is convex: the boxes of a height map, or itself."""
        if not isinstance(self.shape.geometry, HeightMap):
            return (self,)
        return [solid for solid in map(around, self.shape.solids(MERGED)) if solid is not None]

    @cached_property
    def core(self) -> _Core:
        """What the search asks, seen from the frame of the link."""
        return _core(self.shape)

    @cached_property
    def _origin(self) -> Transform:
        return self.shape.origin().transform()

    def seen(self, way: Transform) -> _Core:
        """Return what the search asks; ``way`` is where the frame of the link is."""
        return _Core(way.then(self._origin), *self.core[1:])


class Touching:
    """Says of two groups of solids whether they touch: whether any of each are closer than ``near`` (m)."""

    def __init__(self, ones: Sequence[Solid], others: Sequence[Solid], near: float = NEAR) -> None:
        self.near = near
        self._ones = sorted((piece for one in ones for piece in one.pieces), key=lambda one: one.middle[0])
        self._others = [piece for one in others for piece in one.pieces]
        self._middles = [one.middle[0] for one in self._ones]
        self._largest = max((one.radius for one in self._ones), default=0.0)
        self._last: tuple[Solid, Solid] | None = None  # that touched: they will do so a little further on

    def at(self, way: Transform) -> bool:
        """Say whether they touch where the frame of the others sits in that of the first ones by ``way``."""
        if self._last is not None and self._are_close(*self._last, way):
            return True
        for solid in self._others:
            middle, radius = way.apply(solid.middle), solid.radius
            reach = radius + self._largest + self.near
            start, end = bisect_left(self._middles, middle[0] - reach), bisect_right(self._middles, middle[0] + reach)
            apart = ((math.dist(middle, other.middle), other) for other in self._ones[start:end])
            close = [(far - other.radius, other) for far, other in apart if far <= radius + other.radius + self.near]
            for _, other in sorted(close, key=lambda pair: pair[0]):  # those that are likely to touch first
                if self._are_close(other, solid, way):
                    self._last = other, solid
                    return True
        return False

    def _are_close(self, one: Solid, other: Solid, way: Transform) -> bool:
        return not _apart(one.core, other.seen(way), self.near + one.core.around + other.core.around)


def around(shape: Shape) -> Solid | None:
    """Return a shape with the smallest ball around it; None of a mesh."""
    ball, geometry = ball_of(shape), shape.geometry
    if ball is None:
        return None
    if isinstance(geometry, Sphere):
        return Solid(shape, ball.middle, abs(geometry.radius))
    if isinstance(geometry, Capsule):
        return Solid(shape, ball.middle, abs(geometry.radius) + abs(geometry.length) / 2)
    if isinstance(geometry, Cylinder):
        return Solid(shape, ball.middle, math.hypot(geometry.radius, geometry.length / 2))
    return Solid(shape, ball.middle, ball.radius)


def _core(shape: Shape) -> _Core:
    geometry, place = shape.geometry, Transform().then(shape.origin().transform())
    if isinstance(geometry, Box):
        x, y, z = (abs(side) / 2 for side in geometry.size)
        return _Core(place, (x, y, z))
    if isinstance(geometry, Ellipsoid):
        x, y, z = map(abs, geometry.radii)
        return _Core(place, (x, y, z), oval=True)
    if isinstance(geometry, Cylinder):
        radius = abs(geometry.radius)
        return _Core(place, (radius, radius, abs(geometry.length) / 2), round=True)
    if isinstance(geometry, Capsule):
        return _Core(place, (0.0, 0.0, abs(geometry.length) / 2), around=abs(geometry.radius))
    if isinstance(geometry, Sphere):
        return _Core(place, (0.0, 0.0, 0.0), around=abs(geometry.radius))
    raise TypeError(f"a {type(geometry).__name__} is no convex body that is known")


def _apart(one: _Core, other: _Core, reach: float) -> bool:
    """Say whether two cores are farther from each other than ``reach`` (m)."""
    nearest = minus(one.place.xyz, other.place.xyz)
    simplex: Simplex = []
    for _ in range(_STEPS):
        length = math.hypot(*nearest)
        if length <= reach:
            return False
        x, y, z = nearest
        found = minus(one.support((-x, -y, -z)), other.support(nearest))
        ahead = dot(nearest, found)
        if ahead > reach * length:  # the plane through the support point is as far away as that
            return True
        if simplex and length * length - ahead <= _DONE * length * length:
            return True  # no point is nearer than this one, and it is beyond the reach
        nearest, simplex = _closest([*simplex, found])
        if len(simplex) == 4:  # the origin is within
            return False
    return False


def _closest(simplex: Simplex) -> tuple[Vector, Simplex]:
    """Return the point of a simplex that is closest to the origin, and the corners that it lies between."""
    if len(simplex) == 1:
        return simplex[0], simplex
    if len(simplex) == 2:
        return _on_line(simplex[0], simplex[1])
    if len(simplex) == 3:
        return _on_triangle(simplex)
    best: tuple[float, Vector, Simplex] | None = None
    for index, apex in enumerate(simplex):
        face = [*simplex[:index], *simplex[index + 1 :]]
        if not _is_outside(face, apex):
            continue
        point, corners = _on_triangle(face)
        far = dot(point, point)
        if best is None or far < best[0]:
            best = (far, point, corners)
    return ((0.0, 0.0, 0.0), simplex) if best is None else best[1:]


def _is_outside(face: Simplex, apex: Vector) -> bool:
    """Say whether the origin is on the other side of a face than the apex, or the four points are nearly flat."""
    a, b, c = face
    normal = _cross(minus(b, a), minus(c, a))
    height = dot(normal, minus(apex, a))
    flat = 1e-12 * math.hypot(*normal) * math.dist(apex, a)
    return abs(height) <= flat or dot(normal, a) * height >= 0


def _on_line(a: Vector, b: Vector) -> tuple[Vector, Simplex]:
    along = minus(b, a)
    square = dot(along, along)
    share = -dot(a, along) / square if square > 0 else 0.0
    if share <= 0:
        return a, [a]
    if share >= 1:
        return b, [b]
    return _between((a, b), (1 - share, share)), [a, b]


def _on_triangle(triangle: Simplex) -> tuple[Vector, Simplex]:
    a, b, c = triangle
    normal = _cross(minus(b, a), minus(c, a))
    square = dot(normal, normal)
    edges = ((a, b), (b, c), (c, a))
    if square > 0:
        # The share of each corner is the area of the triangle that the foot of the origin makes with the others.
        shares = [dot(_cross(p, q), normal) / square for p, q in (edges[1], edges[2], edges[0])]
        if min(shares) > 0:
            return _between((a, b, c), shares), [a, b, c]
    return min((_on_line(p, q) for p, q in edges), key=lambda found: dot(found[0], found[0]))


def _between(points: Sequence[Vector], shares: Sequence[float]) -> Vector:
    made = (0.0, 0.0, 0.0)
    for (x, y, z), share in zip(points, shares, strict=True):
        made = plus(made, (share * x, share * y, share * z))
    return made


def _cross(one: Vector, other: Vector) -> Vector:
    (a, b, c), (d, e, f) = one, other
    return (b * f - c * e, c * d - a * f, a * e - b * d)
