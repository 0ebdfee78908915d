"""Quaternions and angles as tf2 computes them, operation by operation, so that even signs and zeros are the same.

Order x y z w. The formulas are those of Bullet's linear algebra, which tf2 carries along (geometry2,
``tf2/LinearMath/Quaternion.h``, ``Matrix3x3.h``, the same in Humble and Jazzy).

``at`` and ``from_angles`` are for joints whose place is several numbers: what people write for a planar or floating
one.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import TYPE_CHECKING, TypeAlias

from rosorin_compile.source.units import ANGLE, LENGTH, NUMBER

from ..geometry import Vector
from ..joint import Joint

if TYPE_CHECKING:
    from ..robot import Robot

Quaternion = tuple[float, float, float, float]
Rows = tuple[Vector, Vector, Vector]

UNIT: Quaternion = (0.0, 0.0, 0.0, 1.0)


def product(a: Quaternion, b: Quaternion) -> Quaternion:
    """Return the rotation ``b``, then ``a``."""
    ax, ay, az, aw = a
    bx, by, bz, bw = b
    return (
        aw * bx + ax * bw + ay * bz - az * by,
        aw * by + ay * bw + az * bx - ax * bz,
        aw * bz + az * bw + ax * by - ay * bx,
        aw * bw - ax * bx - ay * by - az * bz,
    )


def inverse(q: Quaternion) -> Quaternion:
    """Return the rotation back, of a quaternion of length 1."""
    return (-q[0], -q[1], -q[2], q[3])


def rotate(q: Quaternion, v: Vector) -> Vector:
    """Return a turned vector."""
    x, y, z, w = q
    a, b, c = v
    turned = (w * a + y * c - z * b, w * b + z * a - x * c, w * c + x * b - y * a, -x * a - y * b - z * c)
    return product(turned, inverse(q))[:3]


def of_rows(rows: Rows) -> Quaternion:
    """Return the quaternion of a rotation matrix as a tf2 buffer keeps it.

    w is positive; where the trace of the matrix is not, it is the largest of x, y and z that is positive.
    """
    trace = rows[0][0] + rows[1][1] + rows[2][2]
    if trace > 0:
        s = math.sqrt(trace + 1.0)
        w, s = s * 0.5, 0.5 / s
        return ((rows[2][1] - rows[1][2]) * s, (rows[0][2] - rows[2][0]) * s, (rows[1][0] - rows[0][1]) * s, w)
    diagonal = [rows[i][i] for i in range(3)]
    i = diagonal.index(max(diagonal))  # the first of equals, as tf2 takes it
    j, k = (i + 1) % 3, (i + 2) % 3
    s = math.sqrt(rows[i][i] - rows[j][j] - rows[k][k] + 1.0)
    made = [0.0, 0.0, 0.0, 0.0]
    made[i], s = s * 0.5, 0.5 / s
    made[3] = (rows[k][j] - rows[j][k]) * s
    made[j] = (rows[j][i] + rows[i][j]) * s
    made[k] = (rows[k][i] + rows[i][k]) * s
    return (made[0], made[1], made[2], made[3])


def rows_of_rpy(angles: Vector) -> Rows:
    """Return the rotation matrix of fixed-axis roll, pitch, yaw in radians, as tf2's Matrix3x3 is set."""
    (si, ci), (sj, cj), (sh, ch) = ((math.sin(angle), math.cos(angle)) for angle in angles)
    cc, cs, sc, ss = ci * ch, ci * sh, si * ch, si * sh
    return (
        (cj * ch, sj * sc - cs, sj * cc + ss),
        (cj * sh, sj * ss + cc, sj * cs - sc),
        (-sj, cj * si, cj * ci),
    )


def to_rows(q: Quaternion) -> Rows:
    """Return the rotation matrix of a quaternion of any length but zero."""
    x, y, z, w = q
    s = 2.0 / (x * x + y * y + z * z + w * w)
    xs, ys, zs = x * s, y * s, z * s
    wx, wy, wz = w * xs, w * ys, w * zs
    xx, xy, xz = x * xs, x * ys, x * zs
    yy, yz, zz = y * ys, y * zs, z * zs
    return (
        (1.0 - (yy + zz), xy - wz, xz + wy),
        (xy + wz, 1.0 - (xx + zz), yz - wx),
        (xz - wy, yz + wx, 1.0 - (xx + yy)),
    )


def rpy(rows: Rows) -> Vector:
    """Return fixed-axis roll, pitch, yaw (radians) as tf2's getRPY: the solution with the pitch in -90 to 90 degrees.

    Only where the matrix says 1 or more is the pitch exactly +-90 degrees, and the yaw zero; nearer than rounding is
    not enough. A pitch of zero is -0.0, for tf2 takes the negative of an arc sine.
    """
    down = rows[2][0]
    if abs(down) >= 1:
        return (math.atan2(rows[2][1], rows[2][2]), math.copysign(math.pi / 2, -down), 0.0)
    pitch = -math.asin(down)
    level = math.cos(pitch)
    roll = math.atan2(rows[2][1] / level, rows[2][2] / level)
    return (roll, pitch, math.atan2(rows[1][0] / level, rows[0][0] / level))


Position: TypeAlias = float | tuple[float, ...]
Positions: TypeAlias = Mapping[str, Position]

# The numbers of a joint as people write them, and what each of them is: a length, an angle, or a plain number.
FORMS: Mapping[str, tuple[tuple[str, ...], ...]] = {
    "planar": (("x", "y", "angle"),),
    "floating": (("x", "y", "z", "roll", "pitch", "yaw"), ("x", "y", "z", "qx", "qy", "qz", "qw")),
    "ball": (("roll", "pitch", "yaw"), ("qx", "qy", "qz", "qw")),
}
KINDS = {
    **dict.fromkeys(("x", "y", "z"), LENGTH),
    **dict.fromkeys(("angle", "roll", "pitch", "yaw"), ANGLE),
    **dict.fromkeys(("qx", "qy", "qz", "qw"), NUMBER),
}


def at(robot: Robot, joint: Joint, positions: Positions) -> Position:
    """Return where a joint is: one number (rad or m), or one for each of its coordinates; 0 if it is not named."""
    own = positions.get(joint.name, 0.0)
    if isinstance(own, tuple) or joint.mimic is None:
        return own
    return robot.position(joint, _numbers(positions))


def _numbers(positions: Positions) -> dict[str, float]:
    return {name: value for name, value in positions.items() if not isinstance(value, tuple)}


def from_angles(numbers: tuple[float, ...]) -> tuple[float, ...]:
    """Return x, y, z, roll, pitch, yaw as x, y, z and a quaternion x, y, z, w; angles alone as that alone."""
    *xyz, roll, pitch, yaw = numbers
    return (*xyz, *of_rows(rows_of_rpy((roll, pitch, yaw))))
