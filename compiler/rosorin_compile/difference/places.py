"""Places compared: how far two of them are apart, and whether that is more than their sources leave open."""

from __future__ import annotations

import math

from ..model import Transform, Vector
from ..model.geometry import dot, norm
from .bodies import Gap, Placed
from .printing import joined


def gap(one: Placed, other: Placed, tolerance: float) -> Gap:
    """Return how far two places are apart; ``tolerance`` (m, rad) is no distance."""
    step = tuple(b - a for a, b in zip(one.transform.xyz, other.transform.xyz, strict=True))
    return Gap(
        math.hypot(*step),
        turn_between(one.transform, other.transform),
        tolerance + joined(one.length, other.length),
        tolerance + joined(one.angle, other.angle),
    )


def turn_between(one: Transform, other: Transform) -> float:
    """Return the angle (rad) by which one place is turned against another one."""
    w, x, y, z = Transform(one.rows).inverse().then(Transform(other.rows)).quaternion()
    return 2 * math.atan2(math.hypot(x, y, z), w)


def angle_between(one: Vector, other: Vector) -> float:
    """Return the angle (rad) between two directions that are not zero."""
    (a, b, c), (d, e, f) = one, other
    across = (b * f - c * e, c * d - a * f, a * e - b * d)
    return math.atan2(norm(across), dot(one, other))


def minus(one: Vector, other: Vector) -> Vector:
    """Return the way from the other point to the first one."""
    return (one[0] - other[0], one[1] - other[1], one[2] - other[2])


def unit(vector: Vector) -> Vector:
    """Return a vector at length 1; a zero vector as it is."""
    length = norm(vector) or 1.0
    return (vector[0] / length, vector[1] / length, vector[2] / length)
