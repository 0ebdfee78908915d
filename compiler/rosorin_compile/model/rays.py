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
    part = _NOWHERE
    if isinstance(geometry, Box):
        part = _EVERYWHERE
        for start, step, side in zip(at, along, geometry.size, strict=True):
            part = _both(part, _slab(start, step, side))
    elif isinstance(geometry, Cylinder):
        part = _tube(at, along, geometry)
    elif isinstance(geometry, Sphere):
        part = _ellipsoid(at, along, (geometry.radius,) * 3)
    elif isinstance(geometry, Ellipsoid):
        part = _ellipsoid(at, along, geometry.radii)
    elif isinstance(geometry, Capsule):
        (x, y, z), half, radii = at, abs(geometry.length) / 2, (geometry.radius,) * 3
        parts = [_tube(at, along, geometry), *(_ellipsoid((x, y, z + end), along, radii) for end in (-half, half))]
        inside = [part for part in parts if part[0] < part[1]]  # it is convex: they are one part together
        part = (min(part[0] for part in inside), max(part[1] for part in inside)) if inside else _NOWHERE
    return Way(*part) if part[0] < part[1] else None


def _both(first: tuple[float, float], second: tuple[float, float]) -> tuple[float, float]:
    return max(first[0], second[0]), min(first[1], second[1])


def _slab(start: float, step: float, side: float) -> tuple[float, float]:
    """Return the part of a line between two planes across an axis, each half a side from zero."""
    half = abs(side) / 2
    if abs(step) < _PARALLEL:
        return _EVERYWHERE if abs(start) < half - _PARALLEL else _NOWHERE
    first, second = (-half - start) / step, (half - start) / step
    return (first, second) if first < second else (second, first)


def _roots(a: float, b: float, c: float) -> tuple[float, float]:
    """Return where a t^2 + 2 b t + c is below zero; ``a`` is not negative."""
    if a == 0.0:
        return _EVERYWHERE if c < 0.0 else _NOWHERE
    under = b * b - a * c
    if under <= 0.0:
        return _NOWHERE
    root = math.sqrt(under)
    return (-b - root) / a, (-b + root) / a


def _tube(at: Vector, along: Vector, geometry: Cylinder | Capsule) -> tuple[float, float]:
    (x, y, z), (u, v, w) = at, along
    endless = _roots(u * u + v * v, x * u + y * v, x * x + y * y - geometry.radius * geometry.radius)
    return _both(endless, _slab(z, w, geometry.length))


def _ellipsoid(at: Vector, along: Vector, radii: Vector) -> tuple[float, float]:
    if not all(radii):
        return _NOWHERE
    x, y, z = (start / radius for start, radius in zip(at, radii, strict=True))
    u, v, w = (step / radius for step, radius in zip(along, radii, strict=True))
    return _roots(u * u + v * v + w * w, x * u + y * v + z * w, x * x + y * y + z * z - 1.0)
