"""How the child of a joint moves: its place in the frame of the joint, at given coordinates.

planar: two slides along the plane, then a turn about its normal. The axes x and y of the plane are those of the frame
of the joint, turned the shortest way that brings z to the normal, as MuJoCo's reader of URDF has them; of a normal
along z they are x and y. floating: a position, then an orientation as a quaternion, its numbers in the order of ROS.
ball: the orientation alone.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

from .geometry import Transform, Vector, norm, rotation_about

# In radians and metres; the quaternion of a floating or ball joint may have any length but zero.
COORDINATES: Mapping[str, tuple[str, ...]] = {
    "fixed": (),
    "revolute": ("position",),
    "continuous": ("position",),
    "prismatic": ("position",),
    "planar": ("x", "y", "angle"),
    "floating": ("x", "y", "z", "qx", "qy", "qz", "qw"),
    "ball": ("qx", "qy", "qz", "qw"),
}

_AT_ORIGIN = {"planar": (0.0, 0.0, 0.0), "floating": (0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0), "ball": (0.0, 0.0, 0.0, 1.0)}


def motion(kind: str, axis: Vector, position: float | Sequence[float]) -> Transform:
    """Return the child in the frame of a joint of a kind; ``position`` is one number, or one for each coordinate.

    Raises ValueError for another number of them, for a zero axis, and for a quaternion of length zero.
    """
    if kind in _AT_ORIGIN:
        numbers = _AT_ORIGIN[kind] if position == 0.0 else position
        return _several(kind, axis, numbers if isinstance(numbers, Sequence) else (numbers,))
    if not isinstance(position, (int, float)):
        raise ValueError(f"the position of a {kind} joint is one number")
    if kind in ("revolute", "continuous"):
        return Transform(rotation_about(axis, position))
    return Transform(xyz=_along(axis, position)) if kind == "prismatic" else Transform()


def _several(kind: str, axis: Vector, numbers: Sequence[float]) -> Transform:
    if len(numbers) != len(COORDINATES[kind]):
        raise ValueError(
            f"the position of a {kind} joint is {', '.join(COORDINATES[kind])}, not {len(numbers)} numbers"
        )
    if kind == "floating":
        x, y, z, qx, qy, qz, qw = numbers
        return Transform.of_quaternion((x, y, z), (qw, qx, qy, qz))
    if kind == "ball":
        qx, qy, qz, qw = numbers
        return Transform.of_quaternion((0.0, 0.0, 0.0), (qw, qx, qy, qz))
    first, second = plane_axes(axis)
    (a, b, c), (d, e, f) = _along(first, numbers[0]), _along(second, numbers[1])
    return Transform(rotation_about(axis, numbers[2]), (a + d, b + e, c + f))


def plane_axes(normal: Vector) -> tuple[Vector, Vector]:
    """Return the axes x and y of the plane of a planar joint, of unit length, in the frame of the joint.

    Raises ValueError for a zero normal.
    """
    x, y, z = _along(normal, 1.0)
    across = math.hypot(x, y)
    if across == 0.0:
        return (1.0, 0.0, 0.0), (0.0, math.copysign(1.0, z), 0.0)
    rotation = rotation_about((-y / across, x / across, 0.0), math.atan2(across, z))
    (a, d, _), (b, e, _), (c, f, _) = rotation
    return (a + 0.0, b + 0.0, c + 0.0), (d + 0.0, e + 0.0, f + 0.0)


def _along(axis: Vector, distance: float) -> Vector:
    length = norm(axis)
    if length == 0:
        raise ValueError("a motion needs an axis that is not zero")
    x, y, z = (component / length * distance for component in axis)
    return (x, y, z)
