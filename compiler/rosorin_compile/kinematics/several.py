"""Joints whose place is several numbers: what people write for a planar or a floating joint."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TypeAlias

from ..model import Joint, Robot
from ..quantity import ANGLE, LENGTH, NUMBER

Position: TypeAlias = float | tuple[float, ...]
Positions: TypeAlias = Mapping[str, Position]

# The numbers of a joint as people write them, and what each of them is: a length, an angle, or a plain number.
FORMS: Mapping[str, tuple[tuple[str, ...], ...]] = {
    "planar": (("x", "y", "angle"),),
    "floating": (("x", "y", "z", "roll", "pitch", "yaw"), ("x", "y", "z", "qx", "qy", "qz", "qw")),
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
    """Return x, y, z, roll, pitch, yaw as x, y, z and a quaternion x, y, z, w."""
    from .quaternions import of_rows, rows_of_rpy

    x, y, z, roll, pitch, yaw = numbers
    return (x, y, z, *of_rows(rows_of_rpy((roll, pitch, yaw))))
