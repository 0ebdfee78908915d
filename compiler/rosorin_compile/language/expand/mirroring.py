"""Mirroring: how a reflection at the plane across x, y or z of the mount turns what a part holds.

Each function takes a mapping and the index of the axis, and returns the values that change: for a reflection S a pose
becomes R' = S R S and p' = S p.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import Any

from rosorin_compile.source.tree import Map, Seq
from rosorin_compile.source.units import Dimension, Quantity

AXES = {"x": 0, "y": 1, "z": 2}
# What the sides of a base become that is mirrored across x, y or z.
_SIDES: tuple[dict[str, str], ...] = ({"front": "rear", "rear": "front"}, {"left": "right", "right": "left"}, {})
_PLANE = 2
_TURNING_OR_SLIDING = ("revolute", "continuous", "prismatic", "planar")


def _pose(entry: Map, axis: int) -> dict[str, Any]:
    changes: dict[str, Any] = {}
    for key in ("xyz", "rpy"):
        values = entry.get(key)
        if values is not None and is_vector(values):
            flipped = [(index == axis) == (key == "xyz") for index in range(3)]
            changes[key] = listed(
                [_negative(v) if flip else v for v, flip in zip(values, flipped, strict=True)], values
            )
    return changes


def _axis(joint: Map, axis: int) -> dict[str, Any]:
    """Return the axis of a mirrored joint; a turning axis changes sign, for a reflection turns turns around.

    What is no joint, and has no type, has an axis to turn about, if it has one.
    """
    values = joint.get("axis")
    if joint.get("type", "revolute" if values is not None else "") not in _TURNING_OR_SLIDING:
        return {}
    if values is None:
        values = listed((1, 0, 0), joint)
    if not is_vector(values):
        return {"axis": values}
    slides = joint.get("type") == "prismatic"
    return {"axis": listed([_negative(v) if (i == axis) == slides else v for i, v in enumerate(values)], values)}


def _vector_at(key: str) -> Callable[[Map, int], dict[str, Any]]:
    """Return what reflects the vector of a key: a point, or a direction."""

    def reflected(entry: Map, axis: int) -> dict[str, Any]:
        values = entry.get(key)
        if values is None or not is_vector(values):
            return {}
        return {key: listed([_negative(v) if i == axis else v for i, v in enumerate(values)], values)}

    return reflected


def _grid(grid: Map, axis: int) -> dict[str, Any]:
    """Return the cells of a height map in reverse order along x or y.

    Along z the heights change sign, which a rule reports: a map counts them up from z = 0.
    """
    heights, origin, cell = grid.get("heights"), grid.get("origin"), grid.get("cell")
    if not isinstance(heights, Seq) or not heights or not all(isinstance(row, Seq) for row in heights):
        return {}
    if not isinstance(origin, Seq) or not isinstance(cell, (int, float)):
        return {}
    if axis == AXES["z"]:
        negative = [listed([_negative(v) if is_number(v) else v for v in row], row) for row in heights]
        return {"heights": listed(negative, heights)}
    count = len(heights) if axis == AXES["x"] else len(heights[0])
    if len(origin) != _PLANE or not is_number(origin[axis]):
        return {}
    high = float(origin[axis]) + count * float(cell)
    changes: dict[str, Any] = {"origin": listed([-high if i == axis else v for i, v in enumerate(origin)], origin)}
    for key in ("heights", "bottom"):
        rows = grid.get(key)
        if isinstance(rows, Seq) and all(isinstance(row, Seq) for row in rows):
            lines = rows[::-1] if axis == AXES["x"] else [listed(row[::-1], row) for row in rows]
            changes[key] = listed(lines, rows)
    return changes


def _inertia(moments: Map, axis: int) -> dict[str, Any]:
    keys = [key for key in ("ixy", "ixz", "iyz") if "xyz"[axis] in key[1:]]
    return {key: _negative(moments[key]) for key in keys if isinstance(moments.get(key), (int, float))}


def _bounds(box: Map, axis: int) -> dict[str, Any]:
    if not all(box.get(key) and is_vector(box[key]) for key in ("min", "max")):
        return {}
    low, high = list(box["min"]), list(box["max"])
    low[axis], high[axis] = _negative(high[axis]), _negative(low[axis])
    return {"min": listed(low, box["min"]), "max": listed(high, box["max"])}


def _scale(mesh: Map, axis: int) -> dict[str, Any]:
    if not is_vector(mesh.get("scale")):
        return {}
    scale = list(mesh.get("scale") or (1, 1, 1))
    scale[axis] = _negative(scale[axis])
    return {"scale": listed(scale, mesh.get("scale", mesh))}


def _gear(actuator: Map, axis: int) -> dict[str, Any]:
    """Return the gear of a mirrored actuator: of a ball a torque, of a site a force and a torque."""
    gear = actuator.get("gear")
    if not isinstance(gear, list) or len(gear) not in (3, 6) or not all(map(is_number, gear)):
        return {}
    force = [_negative(v) if i == axis else v for i, v in enumerate(gear[:-3])]
    torque = [v if i == axis else _negative(v) for i, v in enumerate(gear[-3:])]
    return {"gear": listed([*force, *torque], gear)}


# By the annotation ``x-mirror``, whose keys are ``annotations.MIRRORED_KEYS``.
MIRRORED: Mapping[str, Callable[[Map, int], dict[str, Any]]] = {
    "pose": _pose,
    "axis": _axis,
    "direction": _vector_at("direction"),
    "dir": _vector_at("dir"),
    "at": _vector_at("at"),
    "grid": _grid,
    "inertia": _inertia,
    "bounds": _bounds,
    "scale": _scale,
    "gear": _gear,
}


def side(role: str, axis: int | None) -> str:
    """Return what wheels are that stood at a side before they were mirrored: ``front_left`` across y is front_right."""
    swapped = _SIDES[axis] if axis is not None else {}
    return "_".join(swapped.get(word, word) for word in role.split("_"))


def is_number(value: Any, dimension: Dimension | None = None) -> bool:
    """Return True for a number, of a dimension if one is requested; a bare number is of any."""
    if isinstance(value, bool) or not isinstance(value, (int, float)):
        return False
    return dimension is None or not isinstance(value, Quantity) or value.dimension == dimension


def is_vector(value: Any, dimension: Dimension | None = None) -> bool:
    """Say whether a value is three finite numbers, of a dimension if one is given, or nothing."""
    if value is None:
        return True
    if not isinstance(value, list) or len(value) != 3:
        return False
    return all(is_number(v, dimension) and math.isfinite(v) for v in value)


def listed(values: Any, like: Any) -> Seq:
    """Return numbers as a sequence that stands where ``like`` stands."""
    made = Seq(like.span, like.via)
    spans = getattr(like, "value_spans", None)
    for index, value in enumerate(values):
        made.put(value, spans[index] if isinstance(spans, list) and index < len(spans) else like.span)
    return made


def _negative(value: float) -> float:
    """Return a number with the other sign; a quantity stays one, zero stays as it is."""
    if not value:
        return value
    return Quantity(-value, value.dimension, value.text) if isinstance(value, Quantity) else -value
