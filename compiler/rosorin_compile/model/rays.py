"""Rays: where a straight line enters and leaves a solid, without an engine and without rounding the solid to triangles.

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
    """The part of a line that is within a solid: from where to where, along its direction (m)."""

    enters: float
    leaves: float


def through(shape: Shape, place: Transform, origin: Vector, direction: Vector) -> Way | None:
    """Return the way of a line through a solid whose link is at ``place``; None where it passes by.

    ``direction`` is a unit vector. A mesh, and a height map that is not taken apart, are passed by.
    """
    back = place.then(shape.origin().transform()).inverse()
    enters, leaves = _within(shape, back.apply(origin), back.rotate(direction))
    return Way(enters, leaves) if enters < leaves else None


def _within(shape: Shape, at: Vector, along: Vector) -> tuple[float, float]:
    geometry = shape.geometry
    if isinstance(geometry, Box):
        return _slabs(at, along, geometry.size)
    if isinstance(geometry, Cylinder):
        return _both(_round(at, along, geometry.radius), _slab(at[2], along[2], geometry.length))
    if isinstance(geometry, Sphere):
        return _ball(at, along, (geometry.radius,) * 3)
    if isinstance(geometry, Ellipsoid):
        return _ball(at, along, geometry.radii)
    if isinstance(geometry, Capsule):
        return _capsule(at, along, geometry)
    return _NOWHERE


def _slabs(at: Vector, along: Vector, size: Vector) -> tuple[float, float]:
    found = _EVERYWHERE
    for start, step, side in zip(at, along, size, strict=True):
        found = _both(found, _slab(start, step, side))
    return found


def _slab(start: float, step: float, side: float) -> tuple[float, float]:
    """Return the part of a line between two planes across an axis, each half a side away."""
    half = abs(side) / 2
    if abs(step) < _PARALLEL:
        return _EVERYWHERE if abs(start) < half - _PARALLEL else _NOWHERE
    one, other = (-half - start) / step, (half - start) / step
    return (one, other) if one < other else (other, one)


def _both(one: tuple[float, float], other: tuple[float, float]) -> tuple[float, float]:
    return max(one[0], other[0]), min(one[1], other[1])


def _roots(a: float, b: float, c: float) -> tuple[float, float]:
    """Return where a t^2 + 2 b t + c is below zero; ``a`` is not negative."""
    if a == 0.0:
        return _EVERYWHERE if c < 0.0 else _NOWHERE
    under = b * b - a * c
    if under <= 0.0:
        return _NOWHERE
    root = math.sqrt(under)
    return (-b - root) / a, (-b + root) / a


def _round(at: Vector, along: Vector, radius: float) -> tuple[float, float]:
    """Return the part of a line within an endless cylinder around z."""
    (x, y, _), (u, v, _) = at, along
    return _roots(u * u + v * v, x * u + y * v, x * x + y * y - radius * radius)


def _ball(at: Vector, along: Vector, radii: Vector) -> tuple[float, float]:
    if not all(radii):
        return _NOWHERE
    x, y, z = (start / radius for start, radius in zip(at, radii, strict=True))
    u, v, w = (step / radius for step, radius in zip(along, radii, strict=True))
    return _roots(u * u + v * v + w * w, x * u + y * v + z * w, x * x + y * y + z * z - 1.0)


def _capsule(at: Vector, along: Vector, capsule: Capsule) -> tuple[float, float]:
    """Return the part of a line within a capsule, which is convex: all of its parts are one way together."""
    half, radii = abs(capsule.length) / 2, (capsule.radius,) * 3
    x, y, z = at
    parts = [
        _both(_round(at, along, capsule.radius), _slab(z, along[2], capsule.length)),
        _ball((x, y, z - half), along, radii),
        _ball((x, y, z + half), along, radii),
    ]
    met = [part for part in parts if part[0] < part[1]]
    return (min(part[0] for part in met), max(part[1] for part in met)) if met else _NOWHERE
