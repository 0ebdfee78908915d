"""Numbers as a person would have written them: what MuJoCo calculated, freed of the noise of its calculation.

Nothing here moves a value by more than 1e-12.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence

from ...model import Transform, geometry
from ...model.geometry import Rows, Vector, transform_of_quaternion

DEGREE = math.pi / 180
ROUNDING = 1e-15  # of sums and products of numbers near 1
ANGLE_ROUNDING = 1e-12  # rad
NO_POSE = Transform()


def tidy(value: float, zero: float = ROUNDING) -> float:
    """Return the short decimal that a number misses by rounding alone, else the number; below ``zero`` it is 0.

    >>> tidy(0.30000000000000004), tidy(0.1234567890123456), tidy(1e-17), tidy(-0.0)
    (0.3, 0.1234567890123456, 0.0, 0.0)
    """
    if abs(value) < zero or not math.isfinite(value):
        return value if not math.isfinite(value) else 0.0
    for digits in range(1, 14):
        short = float(f"{value:.{digits}g}")
        if abs(short - value) <= ROUNDING * abs(value):
            return short
    return value


def tidy_angle(value: float) -> float:
    """Return an angle (rad), a whole number of degrees exactly where it misses one by rounding; -180 deg is 180 deg.

    >>> tidy_angle(1.5707963267948963) == 90 * DEGREE, tidy_angle(-math.pi) == math.pi
    (True, True)
    """
    degrees = round(value / DEGREE) if math.isfinite(value) else 0
    if degrees and abs(value - degrees * DEGREE) <= ANGLE_ROUNDING:
        return 180 * DEGREE if degrees == -180 else degrees * DEGREE
    return tidy(value, ANGLE_ROUNDING)


def tidy_position(value: float) -> float:
    """Return a position of a joint that turns (rad): as ``tidy_angle``, but -180 deg stays what it is."""
    degrees = round(value / DEGREE) if math.isfinite(value) else 0
    if degrees and abs(value - degrees * DEGREE) <= ANGLE_ROUNDING * max(1.0, abs(degrees) / 180):
        return degrees * DEGREE
    return tidy(value)


def rotation(quaternion: Sequence[float]) -> Rows:
    """Return the rotation matrix, as rows, of a quaternion (w, x, y, z) of any length above zero."""
    return transform(NO_POSE.xyz, quaternion).rows


def transform(pos: Sequence[float], quat: Sequence[float]) -> Transform:
    """Return the transform of a position (m) and a quaternion (w, x, y, z)."""
    x, y, z = pos
    return transform_of_quaternion((x, y, z), quat)


def shift(offset: Sequence[float]) -> Transform:
    """Return the transform that only moves (m)."""
    x, y, z = offset
    return Transform(xyz=(x, y, z))


def rpy_of(rows: Rows) -> Vector:
    """Return a rotation as fixed-axis roll, pitch, yaw in radians, whole degrees where it misses them by rounding.

    Where pitch is near 90 degrees, roll alone and yaw alone mean little. Yaw is therefore measured after roll was taken
    out, so that all three together are the rotation to the last digit, and roll is 0 where nothing of it can be seen.
    """
    (a, b, c), (d, e, f), (g, h, i) = rows
    horizontal = math.hypot(h, i)
    roll = math.atan2(h, i) if horizontal > ANGLE_ROUNDING else 0.0
    sine, cosine = math.sin(roll), math.cos(roll)
    yaw = math.atan2(c * sine - b * cosine, e * cosine - f * sine)
    pitch = math.atan2(-g, a * math.cos(yaw) + d * math.sin(yaw))
    return (tidy_angle(roll), tidy_angle(pitch), tidy_angle(yaw))


def tidy_vector(values: Iterable[float], zero: float = ROUNDING) -> Vector:
    """Return three numbers freed of rounding."""
    x, y, z = (tidy(value, zero) for value in values)
    return (x, y, z)


def unit(axis: Sequence[float]) -> Vector:
    """Return an axis with length 1; MuJoCo has made it so already, but for rounding."""
    x, y, z = axis
    return tidy_vector(geometry.unit((x, y, z)))


def angles_about_xyz(quaternion: Sequence[float]) -> Vector:
    """Return the turns about x, then the new y, then the new z that make a rotation (rad)."""
    (_, _, c), (d, e, f), (g, h, i) = rotation(quaternion)
    first = math.atan2(-f, i) if math.hypot(f, i) > ANGLE_ROUNDING else 0.0
    sine, cosine = math.sin(first), math.cos(first)
    third = math.atan2(d * cosine + g * sine, e * cosine + h * sine)
    second = math.atan2(c, i * cosine - f * sine)
    return (tidy_angle(first), tidy_angle(second), tidy_angle(third))


def full_inertia(diagonal: Sequence[float], rows: Rows) -> dict[str, float]:
    """Return the moments along the axes of the link of an inertia that is diagonal in the axes of ``rows``."""
    largest = max(map(abs, diagonal))

    def moment(j: int, k: int) -> float:
        return sum(rows[j][n] * diagonal[n] * rows[k][n] for n in range(3))

    cells = {"ixx": (0, 0), "iyy": (1, 1), "izz": (2, 2), "ixy": (0, 1), "ixz": (0, 2), "iyz": (1, 2)}
    return {name: tidy(moment(*cell), ROUNDING * largest) for name, cell in cells.items()}
