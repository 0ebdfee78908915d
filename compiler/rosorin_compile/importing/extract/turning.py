"""Poses of shapes around a mesh: angles that are nice where they may be, and numbers of a few decimals."""

from __future__ import annotations

import itertools
import math
from typing import TYPE_CHECKING, Any

from rosorin_compile.model import Pose, Transform
from rosorin_compile.source.diagnostics import Span
from rosorin_compile.source.tree import Map, Seq

from ..layout import number
from . import writing

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    Floats = NDArray[np.float64]


Vector = tuple[float, float, float]

# Noise of the corners of an STL, in metres, that is not rounded up: they have 24 bits.
_NOISE = 1e-7


def nice_angles(frame: Floats) -> Vector:
    """Return roll, pitch, yaw of axes (rows of 3x3), named and directed so that they turn as little as possible."""
    import numpy as np

    rotations: list[tuple[float, Floats]] = []
    for order in itertools.permutations(range(3)):
        for signs in itertools.product((1, -1), repeat=3):
            axes = frame[list(order)] * np.array(signs)[:, None]
            if np.linalg.det(axes) > 0:
                rotations.append((round(float(np.trace(axes)), 9), axes))
    _, axes = max(rotations, key=lambda rotation: rotation[0])
    rows = axes.T.tolist()
    return rounded_angles(Transform((tuple(rows[0]), tuple(rows[1]), tuple(rows[2]))).rpy())


def rounded_angles(rpy: Vector) -> Vector:
    """Return angles that are within 0.01 degrees of a whole degree as that, others with six decimals."""
    made = []
    for angle in rpy:
        degrees = math.degrees(angle)
        nice = abs(degrees - round(degrees)) < 0.01
        made.append(math.radians(round(degrees)) if nice else round(angle, 6) + 0.0)
    return (made[0], made[1], made[2])


def angles_of_axis(frame: Transform, index: int) -> Vector:
    """Return angles of a frame whose z points along an axis of another."""
    x, y, z = (row[index] for row in frame.rows)
    if z < 0:
        x, y, z = -x, -y, -z
    return rounded_angles((0.0, math.atan2(math.hypot(x, y), z), math.atan2(y, x)))


def matrix(rpy: Vector) -> Floats:
    """Return the rotation matrix (3, 3) of roll, pitch, yaw."""
    import numpy as np

    return np.array(Pose((0, 0, 0), rpy).transform().rows)


def seen_from(points: Floats, pose: Pose) -> Floats:
    """Return points (n, 3) of the link in the frame of a shape."""
    import numpy as np

    seen: Floats = (points - np.array(pose.xyz)) @ matrix(pose.rpy)
    return seen


def rounded_pose(xyz: Floats, rpy: Vector, digits: int) -> Pose:
    """Return a pose whose position has a number of decimals."""
    x, y, z = (round(float(value), digits) + 0.0 for value in xyz)
    return Pose((x, y, z), rpy) if (x, y, z) != (0, 0, 0) or rpy != (0, 0, 0) else Pose()


def up(value: float, digits: int) -> float:
    """Return metres rounded up to a number of decimals; noise of 0.1 um, or of a twentieth of the last one, is not."""
    scale = 10.0**digits
    return round(math.ceil(value * scale - min(_NOISE * scale, 0.05)) / scale, digits) + 0.0


def down(value: float, digits: int) -> float:
    """Return a number rounded down to a number of decimals."""
    return -up(-value, digits) + 0.0


def block(entry: Map, indent: str) -> list[str]:
    """Return the lines of a mapping, a key a line, what a key holds on that line."""
    return [f"{indent}{writing.name(key)}: {inline(value, entry.value_spans[key])}" for key, value in entry.items()]


def inline(value: Any, span: Span) -> str:
    """Return a value of a tree on one line."""
    if isinstance(value, Map):
        pairs = (f"{writing.name(key)}: {inline(item, value.value_spans[key])}" for key, item in value.items())
        return f"{{{', '.join(pairs)}}}"
    if isinstance(value, Seq):
        return f"[{', '.join(inline(item, place) for item, place in zip(value, value.value_spans, strict=True))}]"
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, int | float):
        return number(value, span)
    return writing.name(str(value))
