"""Bounds: the space that shapes take, as an axis-aligned box in the frame of their link."""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import NamedTuple

from .geometry import IDENTITY, Vector
from .shape import Box, Capsule, Cylinder, Ellipsoid, Geometry, HeightMap, Mesh, Shape


class Bounds(NamedTuple):
    """A box along the axes of a frame, between two corners (metres)."""

    lower: Vector
    upper: Vector

    @property
    def size(self) -> Vector:
        """The full extents along x, y and z."""
        (a, b, c), (d, e, f) = self
        return (d - a, e - b, f - c)

    @property
    def diagonal(self) -> float:
        """The largest distance within the box."""
        return math.dist(self.lower, self.upper)

    def join(self, other: Bounds) -> Bounds:
        """Return the box around two."""
        (a, b, c), (d, e, f) = self
        (g, h, i), (j, k, m) = other
        return Bounds((min(a, g), min(b, h), min(c, i)), (max(d, j), max(e, k), max(f, m)))

    def gap(self, other: Bounds) -> float:
        """Return the distance between two boxes (m); zero where they touch."""
        pairs = zip(self.lower, self.upper, other.lower, other.upper, strict=True)
        return math.hypot(*(max(c - b, a - d, 0.0) for a, b, c, d in pairs))

    def reach(self, point: Vector) -> float:
        """Return the distance from a point to the farthest corner (m)."""
        return math.hypot(*(max(abs(a - p), abs(b - p)) for a, b, p in zip(*self, point, strict=True)))


def bounds_of(shapes: Iterable[Shape]) -> Bounds | None:
    """Return the box around shapes; None if there is none, or the size of one is not known here: that of a mesh."""
    found: Bounds | None = None
    for shape in shapes:
        if isinstance(shape.geometry, Mesh):
            return None
        one = _bounds(shape)
        found = found.join(one) if found else one
    return found


class Ball(NamedTuple):
    """The middle of a shape in the frame of its link (m), the half of its diagonal (m), its box's volume (m^3)."""

    middle: Vector
    radius: float
    volume: float


def ball_of(shape: Shape) -> Ball | None:
    """Return what is quickly known of a shape, without its turn; None of a mesh."""
    known = shape.notes.get("ball")
    if known is None and not isinstance(shape.geometry, Mesh):
        known = shape.notes["ball"] = _ball_of(shape)
    return known if isinstance(known, Ball) else None


def _ball_of(shape: Shape) -> Ball:
    (a, b, c), (d, e, f) = _own(shape.geometry)
    middle = ((a + d) / 2, (b + e) / 2, (c + f) / 2)
    x, y, z = shape.pose.xyz
    if any(middle) and any(shape.pose.rpy):
        middle = shape.pose.transform().apply(middle)
    else:
        middle = (middle[0] + x, middle[1] + y, middle[2] + z)
    return Ball(middle, math.hypot(d - a, e - b, f - c) / 2, (d - a) * (e - b) * (f - c))


def _bounds(shape: Shape) -> Bounds:
    lower, upper = _own(shape.geometry)
    if shape.pose == IDENTITY:
        return Bounds(lower, upper)
    place = shape.pose.transform()
    half = ((upper[0] - lower[0]) / 2, (upper[1] - lower[1]) / 2, (upper[2] - lower[2]) / 2)
    x, y, z = place.apply((lower[0] + half[0], lower[1] + half[1], lower[2] + half[2]))
    a, b, c = (sum(abs(cell) * side for cell, side in zip(row, half, strict=True)) for row in place.rows)
    return Bounds((x - a, y - b, z - c), (x + a, y + b, z + c))


def _own(geometry: Geometry) -> tuple[Vector, Vector]:
    """Return two corners of a geometry in its own frame."""
    if isinstance(geometry, Box):
        (a, b, c), (d, e, f) = geometry.lower, geometry.upper
        return (min(a, d), min(b, e), min(c, f)), (max(a, d), max(b, e), max(c, f))
    if isinstance(geometry, HeightMap):
        x, y = geometry.origin
        rows, columns = len(geometry.heights), max(map(len, geometry.heights), default=0)
        cells = [(i, j) for i, row in enumerate(geometry.heights) for j in range(len(row)) if geometry.is_body(i, j)]
        top = max((geometry.heights[i][j] for i, j in cells), default=0.0)
        low = min((geometry.bottom_of(i, j) for i, j in cells), default=0.0) if geometry.bottom else 0.0
        return (x, y, low), (x + rows * geometry.cell, y + columns * geometry.cell, top)
    if isinstance(geometry, Mesh):
        raise ValueError("the size of a mesh is not known")
    if isinstance(geometry, Ellipsoid):
        a, b, c = map(abs, geometry.radii)
        return (-a, -b, -c), (a, b, c)
    radius = abs(geometry.radius)  # a size below zero may be accepted
    half = radius
    if isinstance(geometry, (Cylinder, Capsule)):
        half = abs(geometry.length) / 2 + (radius if isinstance(geometry, Capsule) else 0.0)
    return (-radius, -radius, -half), (radius, radius, half)
