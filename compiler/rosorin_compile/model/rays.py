"""The part of a straight line inside a solid: exact, without an engine and without triangles.

Boxes by their slabs, round solids by the quadratic equation of their surface (C. Ericson, "Real-Time Collision
Detection", 2005, chapter 5.3).
"""

from __future__ import annotations

import math
from typing import NamedTuple

from .geometry import Transform, Vector
from .shape import Box, Capsule, Cylinder, Ellipsoid, Shape, Sphere

_NOWHERE = (math.inf, -math.inf)
_EVERYWHERE = (-math.inf, math.inf)
_PARALLEL = 1e-12  # rounding of a direction, and of a line in a face, which is outside (m)


class Way(NamedTuple):
    """The part of a line inside a solid: distances along its direction (m)."""

    enters: float
    leaves: float


def through(shape: Shape, place: Transform, origin: Vector, direction: Vector) -> Way | None:
    """Return the part of a line inside a solid whose link is at ``place``, or None where it passes by.

    ``direction`` is a unit vector. Lines pass by meshes, and by height maps that are not split into boxes.
    """
    back = place.then(shape.origin().transform()).inverse()
    at, along, geometry = back.apply(origin), back.rotate(direction), shape.geometry
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
    inside = [part for part in parts if part[0] < part[1]]  # all solids are convex: the parts are one
    return Way(min(part[0] for part in inside), max(part[1] for part in inside)) if inside else None


def _slab(start: float, step: float, side: float) -> tuple[float, float]:
    """Return the part of a line between two planes across an axis, each half a side from zero."""
    half = abs(side) / 2
    if abs(step) < _PARALLEL:
        return _EVERYWHERE if abs(start) < half - _PARALLEL else _NOWHERE
    first, second = (-half - start) / step, (half - start) / step
    return (first, second) if first < second else (second, first)


def _ellipsoid(at: Vector, along: Vector, radii: Vector) -> tuple[float, float]:
    """Return the part of a line in an ellipsoid; an infinite radius makes it an endless cylinder."""
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
