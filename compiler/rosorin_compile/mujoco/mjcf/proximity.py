"""Whether two solids touch: boxes, cylinders, capsules, spheres and ellipsoids at any pose, without an engine.

The distance of two convex bodies is the distance of their Minkowski difference from the origin, which simplices of
support points approach (E. G. Gilbert, D. W. Johnson, S. S. Keerthi, "A fast procedure for computing the distance
between complex objects in three-dimensional space", 1988). A sphere is a point and a capsule a line with a radius
around it. The search ends as soon as a support plane shows that the bodies are farther apart than the limit.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import cached_property
from itertools import combinations

from rosorin_compile.model.bounds import ball_of
from rosorin_compile.model.geometry import Transform, Vector, cross, dot, minus
from rosorin_compile.model.shape import MERGED, Box, Capsule, Cylinder, Ellipsoid, HeightMap, Shape, Sphere

# Faces that lie on each other touch, whatever the rounding of their poses (m).
NEAR = 1e-6
_STEPS = 100  # a longer search is one along round faces that are hardly apart
_DONE = 1e-10  # relative improvement of the distance at which the search ends
_ORIGIN: Vector = (0.0, 0.0, 0.0)

Simplex = Sequence[Vector]


class Solid:
    """A shape of known size, with a ball around it: its middle in the frame of the link, and its radius (m).

    ``margin`` (m) is the radius of a sphere or capsule, which ``support`` leaves out.
    """

    def __init__(self, shape: Shape, middle: Vector, radius: float) -> None:
        self.shape = shape
        self.middle = middle
        self.radius = radius
        self.origin = shape.origin().transform()
        self.margin = abs(shape.geometry.radius) if isinstance(shape.geometry, (Sphere, Capsule)) else 0.0

    @cached_property
    def pieces(self) -> Sequence[Solid]:
        """The boxes of a height map, or the solid itself."""
        if not isinstance(self.shape.geometry, HeightMap):
            return (self,)
        return [solid for solid in map(solid_of, self.shape.solids(MERGED)) if solid is not None]

    @cached_property
    def half_extents(self) -> Vector:
        """Half the size along the axes of the shape, without the margin (m)."""
        geometry = self.shape.geometry
        if isinstance(geometry, Box):
            x, y, z = geometry.size
            return (abs(x) / 2, abs(y) / 2, abs(z) / 2)
        if isinstance(geometry, Ellipsoid):
            x, y, z = map(abs, geometry.radii)
            return (x, y, z)
        if isinstance(geometry, (Cylinder, Capsule)):
            radius = abs(geometry.radius) if isinstance(geometry, Cylinder) else 0.0
            return (radius, radius, abs(geometry.length) / 2)
        return _ORIGIN

    def support(self, place: Transform, direction: Vector) -> Vector:
        """Return the farthest point in a direction, without the margin; ``place`` is the pose of the shape."""
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
    """Return a shape with a small ball around it, or None for a mesh."""
    ball, geometry = ball_of(shape), shape.geometry
    if ball is None:
        return None
    radius = ball.radius
    if isinstance(geometry, Sphere):
        radius = abs(geometry.radius)
    elif isinstance(geometry, Capsule):
        radius = abs(geometry.radius) + abs(geometry.length) / 2
    elif isinstance(geometry, Cylinder):
        radius = math.hypot(geometry.radius, geometry.length / 2)
    return Solid(shape, ball.middle, radius)


class Touching:
    """Tests two groups of solids for contact: whether any two are closer than ``near`` (m)."""

    def __init__(self, fixed: Sequence[Solid], moved: Sequence[Solid], near: float = NEAR) -> None:
        self.near = near
        self._fixed = [piece for solid in fixed for piece in solid.pieces]
        self._moved = [piece for solid in moved for piece in solid.pieces]
        self._last: tuple[Solid, Solid] | None = None  # a pair in contact will be a little further on, too

    def at(self, way: Transform) -> bool:
        """Return True if they touch where ``way`` is the pose of the moved group in the frame of the fixed one."""
        if self._last is not None and self._are_close(*self._last, way):
            return True
        for solid in self._moved:
            middle, limit = way.apply(solid.middle), solid.radius + self.near
            gaps = [(math.dist(middle, other.middle) - other.radius, other) for other in self._fixed]
            for _, other in sorted((one for one in gaps if one[0] <= limit), key=lambda one: one[0]):
                if self._are_close(other, solid, way):
                    self._last = other, solid
                    return True
        return False

    def _are_close(self, fixed: Solid, moved: Solid, way: Transform) -> bool:
        there, limit = way.then(moved.origin), self.near + fixed.margin + moved.margin
        nearest = minus(fixed.origin.xyz, there.xyz)
        simplex: list[Vector] = []
        for _ in range(_STEPS):
            length = math.hypot(*nearest)
            if length <= limit:
                return True
            x, y, z = nearest
            point = minus(fixed.support(fixed.origin, (-x, -y, -z)), moved.support(there, nearest))
            ahead = dot(nearest, point)
            # The support plane is beyond the limit, or no point is nearer than this one.
            if ahead > limit * length or (simplex and length * length - ahead <= _DONE * length * length):
                return False
            nearest, simplex = _closest([*simplex, point])
            if len(simplex) == 4:  # the origin is inside
                return True
        return True


def _closest(simplex: Simplex) -> tuple[Vector, list[Vector]]:
    """Return the point of a simplex that is closest to the origin, and the corners that it lies between."""
    if len(simplex) == 4 and _encloses(simplex):
        return _ORIGIN, list(simplex)
    faces = (face for size in (1, 2, 3) for face in combinations(simplex, size))
    feet = ((_foot(face), list(face)) for face in faces)
    return min(((foot, face) for foot, face in feet if foot is not None), key=lambda pair: dot(pair[0], pair[0]))


def _encloses(simplex: Simplex) -> bool:
    """Return True if the origin is inside a tetrahedron that is not flat."""
    for index, apex in enumerate(simplex):
        a, b, c = (corner for at, corner in enumerate(simplex) if at != index)
        normal = cross(minus(b, a), minus(c, a))
        height = dot(normal, minus(apex, a))
        if abs(height) <= 1e-12 * math.hypot(*normal) * math.dist(apex, a) or dot(normal, a) * height >= 0:
            return False
    return True


def _foot(face: Simplex) -> Vector | None:
    """Return the foot of the origin on a point, line or triangle, or None if it is not between the corners."""
    if len(face) == 1:
        return face[0]
    if len(face) == 2:
        a, b = face
        along = minus(b, a)
        square = dot(along, along)
        share = -dot(a, along) / square if square > 0 else 0.0
        shares = [1 - share, share]
    else:
        # The share of a corner is the area of the triangle of the foot and the other two corners.
        a, b, c = face
        normal = cross(minus(b, a), minus(c, a))
        square = dot(normal, normal)
        if square == 0:
            return None
        shares = [dot(cross(p, q), normal) / square for p, q in ((b, c), (c, a), (a, b))]
    if min(shares) <= 0:
        return None
    x, y, z = (sum(share * corner[k] for share, corner in zip(shares, face, strict=True)) for k in range(3))
    return (x, y, z)
