"""Bounding boxes, extents and line intersections of shapes (C. Ericson, "Real-Time Collision Detection", 2005, 5.3)."""

import math
from collections.abc import Callable, Iterable
from typing import NamedTuple

from .geometry import IDENTITY, Transform, Vector, dot, minus, plane_axes, plus
from .shape import MERGED, Box, Capsule, Cylinder, Ellipsoid, Geometry, HeightMap, Mesh, Shape, Sphere

_NOWHERE = (math.inf, -math.inf)
_EVERYWHERE = (-math.inf, math.inf)
_CIRCLE = [(math.cos(turn), math.sin(turn)) for turn in (2 * math.pi * step / 360 for step in range(360))]
_PARALLEL = 1e-12  # direction components below this count as 0; also the tolerance (m) for a line on a face


class Bounds(NamedTuple):
    """An axis-aligned box, defined by its lower and upper corner (m)."""

    lower: Vector
    upper: Vector

    @property
    def size(self) -> Vector:
        return minus(self.upper, self.lower)

    @property
    def diagonal(self) -> float:
        """The distance between two opposite corners (m)."""
        return math.dist(self.lower, self.upper)

    def join(self, other: "Bounds") -> "Bounds":
        (a, b, c), (d, e, f) = self
        (g, h, i), (j, k, m) = other
        return Bounds((min(a, g), min(b, h), min(c, i)), (max(d, j), max(e, k), max(f, m)))

    def at(self, place: Transform) -> "Bounds":
        """Return the bounding box, in another frame, of this box at the pose ``place``."""
        x, y, z = ((high - low) / 2 for low, high in zip(*self, strict=True))
        middle = place.apply(plus(self.lower, (x, y, z)))
        a, b, c = (abs(p) * x + abs(q) * y + abs(r) * z for p, q, r in place.rows)
        return Bounds(minus(middle, (a, b, c)), plus(middle, (a, b, c)))

    def gap(self, other: "Bounds") -> float:
        """Return the distance between two boxes (m), or zero if they touch."""
        pairs = zip(self.lower, self.upper, other.lower, other.upper, strict=True)
        return math.hypot(*(max(c - b, a - d, 0.0) for a, b, c, d in pairs))

    def reach(self, point: Vector) -> float:
        """Return the distance from a point to the farthest corner of the box (m)."""
        return math.hypot(*(max(abs(a - p), abs(b - p)) for a, b, p in zip(*self, point, strict=True)))


def bounds_of(shapes: Iterable[Shape]) -> Bounds | None:
    """Return the bounding box of shapes in the link frame (m), or None if there are no shapes or one is a mesh."""
    bounds: Bounds | None = None
    for shape in shapes:
        if isinstance(shape.geometry, Mesh):
            return None
        lower, upper = _corners(shape.geometry)
        box = Bounds(lower, upper) if shape.pose == IDENTITY else Bounds(lower, upper).at(shape.pose.transform())
        bounds = bounds.join(box) if bounds else box
    return bounds


class Ball(NamedTuple):
    """A sphere around the bounding box of a shape."""

    middle: Vector  # in the link frame (m)
    radius: float  # m
    volume: float  # volume of the bounding box (m^3)


def ball_of(shape: Shape) -> Ball | None:
    """Return the sphere around the bounding box of a shape, or None for a mesh."""
    if isinstance(shape.geometry, Mesh):
        return None
    (a, b, c), (d, e, f) = _corners(shape.geometry)
    middle = ((a + d) / 2, (b + e) / 2, (c + f) / 2)
    return Ball(shape.pose.transform().apply(middle), math.hypot(d - a, e - b, f - c) / 2, (d - a) * (e - b) * (f - c))


def _corners(geometry: Geometry) -> tuple[Vector, Vector]:
    if isinstance(geometry, Box):
        (a, b, c), (d, e, f) = geometry.lower, geometry.upper
        return (min(a, d), min(b, e), min(c, f)), (max(a, d), max(b, e), max(c, f))
    if isinstance(geometry, HeightMap):
        x, y = geometry.origin
        rows, columns = len(geometry.heights), max(map(len, geometry.heights), default=0)
        ends = [(geometry.bottom_of(i, j), z) for i, row in enumerate(geometry.heights) for j, z in enumerate(row)]
        top = max((high for low, high in ends if high > low), default=0.0)
        low = min((low for low, high in ends if high > low), default=0.0) if geometry.bottom else 0.0
        return (x, y, low), (x + rows * geometry.cell, y + columns * geometry.cell, top)
    if isinstance(geometry, Ellipsoid):
        a, b, c = map(abs, geometry.radii)
        return (-a, -b, -c), (a, b, c)
    if isinstance(geometry, Mesh):
        raise ValueError("the size of a mesh is not known")
    radius = half = abs(geometry.radius)
    if not isinstance(geometry, Sphere):
        half = abs(geometry.length) / 2 + (radius if isinstance(geometry, Capsule) else 0.0)
    return (-radius, -radius, -half), (radius, radius, half)


def reach_along(shape: Shape, place: Transform) -> Callable[[Vector], float]:
    """Return the support function of a shape, which maps a unit vector to the largest coordinate (m) along it.

    ``place`` is the pose of the shape's link in the frame of the unit vector. Meshes are not supported.
    """
    geometry, there = shape.geometry, place.then(shape.pose.transform())
    (a, b, c), (d, e, f), (g, h, i) = there.rows
    j, k, m = there.xyz
    boxes = [_corners(one.geometry) for one in shape.solids(MERGED)] if isinstance(geometry, Box | HeightMap) else []

    def reach(direction: Vector) -> float:
        u, v, w = direction
        x, y, z = a * u + d * v + g * w, b * u + e * v + h * w, c * u + f * v + i * w
        if isinstance(geometry, Sphere):
            extent = geometry.radius
        elif isinstance(geometry, Capsule):
            extent = abs(z) * geometry.length / 2 + geometry.radius
        elif isinstance(geometry, Cylinder):
            extent = abs(z) * geometry.length / 2 + geometry.radius * math.hypot(x, y)
        elif isinstance(geometry, Ellipsoid):
            extent = math.hypot(x * geometry.radii[0], y * geometry.radii[1], z * geometry.radii[2])
        else:  # a box or a height map, which has no boxes if all heights are 0
            extent = -math.inf
            for (o, p, q), (r, s, t) in boxes:
                extent = max(extent, x * (r if x > 0 else o) + y * (s if y > 0 else p) + z * (t if z > 0 else q))
        return j * u + k * v + m * w + extent

    return reach


def radius_about(placed: Iterable[tuple[Shape, Transform]], axis: Vector) -> float:
    """Return the distance (m) from an axis through the origin to the farthest point of the shapes.

    ``placed`` has each shape with the pose of its link. Meshes are not supported. The relative error is below 0.004 %.
    """
    u, v = plane_axes(axis)
    (i, j, k), (m, n, o) = u, v
    farthest = 0.0
    for shape, place in placed:
        geometry, there = shape.geometry, place.then(shape.pose.transform())
        if isinstance(geometry, (Sphere, Capsule)):  # round ends
            half = geometry.length / 2 if isinstance(geometry, Capsule) else 0.0
            ends = [there.apply((0.0, 0.0, end)) for end in (-half, half)]
            farthest = max(farthest, *(math.hypot(dot(end, u), dot(end, v)) + geometry.radius for end in ends))
            continue
        reach, turn = reach_along(shape, place), math.atan2(dot(there.xyz, v), dot(there.xyz, u))
        ways = [(math.cos(turn), math.sin(turn)), *_CIRCLE]
        farthest = max(farthest, *(reach((c * i + s * m, c * j + s * n, c * k + s * o)) for c, s in ways))
    return farthest


def through(geometry: Geometry, at: Vector, along: Vector) -> tuple[float, float] | None:
    """Return the distances (m) along a line at which it enters and leaves a solid, or None if it misses the solid.

    ``at`` is a point on the line (m) and ``along`` its direction (unit vector), both in a frame at the centre of the
    solid. For a mesh or a height map, the result is always None.
    """
    parts: list[tuple[float, float]] = []
    if isinstance(geometry, Box):
        slabs = [_slab(*line) for line in zip(at, along, geometry.size, strict=True)]
        parts = [(max(start for start, _ in slabs), min(end for _, end in slabs))]
    elif isinstance(geometry, Ellipsoid):
        parts = [_ellipsoid(at, along, geometry.radii)]
    elif isinstance(geometry, Sphere):
        parts = [_ellipsoid(at, along, (geometry.radius,) * 3)]
    elif isinstance(geometry, Cylinder | Capsule):
        round_part = _ellipsoid(at, along, (geometry.radius, geometry.radius, math.inf))
        flat_part = _slab(at[2], along[2], geometry.length)
        parts = [(max(round_part[0], flat_part[0]), min(round_part[1], flat_part[1]))]
        for end in (-geometry.length / 2, geometry.length / 2) if isinstance(geometry, Capsule) else ():
            parts.append(_ellipsoid((at[0], at[1], at[2] + end), along, (geometry.radius,) * 3))
    inside = [part for part in parts if part[0] < part[1]]  # all solids are convex, so the parts are contiguous
    return (min(part[0] for part in inside), max(part[1] for part in inside)) if inside else None


def _slab(start: float, step: float, side: float) -> tuple[float, float]:
    """Return the (first, last) distance along a line at which ``start + distance * step`` is within +-``side / 2``."""
    half = abs(side) / 2
    if abs(step) < _PARALLEL:
        return _EVERYWHERE if abs(start) < half - _PARALLEL else _NOWHERE
    first, second = (-half - start) / step, (half - start) / step
    return (first, second) if first < second else (second, first)


def _ellipsoid(at: Vector, along: Vector, radii: Vector) -> tuple[float, float]:
    """Return where a line enters and leaves an ellipsoid; an infinite radius makes it an infinite cylinder."""
    if not all(radii):
        return _NOWHERE
    x, y, z = (start / radius for start, radius in zip(at, radii, strict=True))
    u, v, w = (step / radius for step, radius in zip(along, radii, strict=True))
    a, b, c = u * u + v * v + w * w, x * u + y * v + z * w, x * x + y * y + z * z - 1.0
    if a == 0.0:
        return _EVERYWHERE if c < 0.0 else _NOWHERE
    under = b * b - a * c
    root = math.sqrt(max(under, 0.0))
    return ((-b - root) / a, (-b + root) / a) if under > 0.0 else _NOWHERE
