"""Mirroring: how a reflection at the plane across x, y or z of the mount changes what a part contains.

For a reflection S, a pose becomes R' = S R S and p' = S p. Each function takes a mapping and the index of the axis, and
returns the values that change.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping
from typing import Any

from rosorin_compile.source.tree import Map, Seq
from rosorin_compile.source.units import Dimension, Quantity

AXES = {"x": 0, "y": 1, "z": 2}
# What the sides of a base become that is mirrored across x, y or z.
_SIDES: tuple[dict[str, str], ...] = ({"front": "rear", "rear": "front"}, {"left": "right", "right": "left"}, {})


def _vectors(polar: tuple[str, ...], axial: tuple[str, ...] = ()) -> Callable[[Map, int], dict[str, Any]]:
    """Return a function that reflects the points and directions, and the rotations, under some keys."""

    def changes(entry: Map, axis: int) -> dict[str, Any]:
        found = {key: entry[key] for key in (*polar, *axial) if entry.get(key) is not None and is_vector(entry[key])}
        return {key: listed(_reflected(values, axis, key in axial), values) for key, values in found.items()}

    return changes


def _axis(joint: Map, axis: int) -> dict[str, Any]:
    # What has no type is no joint; its axis is one to turn about.
    values = joint.get("axis")
    kind = joint.get("type", "revolute" if values is not None else "")
    if kind not in ("revolute", "continuous", "prismatic", "planar") or not is_vector(values):
        return {}
    values = listed((1, 0, 0), joint) if values is None else values
    return {"axis": listed(_reflected(values, axis, kind != "prismatic"), values)}


def _grid(grid: Map, axis: int) -> dict[str, Any]:
    """Reverse the order of the cells of a height map along x or y.

    Along z the heights change sign, which a rule reports: a map counts them up from z = 0.
    """
    heights, origin, cell = grid.get("heights"), grid.get("origin"), grid.get("cell")
    if not isinstance(heights, Seq) or not heights or not all(isinstance(row, Seq) for row in heights):
        return {}
    if not isinstance(origin, Seq) or len(origin) != 2 or not all(map(is_number, (*origin, cell))):
        return {}
    if axis == AXES["z"]:
        negative = [listed([_negative(v) if is_number(v) else v for v in row], row) for row in heights]
        return {"heights": listed(negative, heights)}
    count = len(heights) if axis == AXES["x"] else len(heights[0])
    high = float(origin[axis]) + count * float(cell or 0)
    changes: dict[str, Any] = {"origin": listed([-high if i == axis else v for i, v in enumerate(origin)], origin)}
    for key in ("heights", "bottom"):
        rows = grid.get(key)
        if isinstance(rows, Seq) and all(isinstance(row, Seq) for row in rows):
            lines = rows[::-1] if axis == AXES["x"] else [listed(row[::-1], row) for row in rows]
            changes[key] = listed(lines, rows)
    return changes


def _inertia(moments: Map, axis: int) -> dict[str, Any]:
    keys = [key for key in ("ixy", "ixz", "iyz") if "xyz"[axis] in key[1:]]
    return {key: _negative(moments[key]) for key in keys if is_number(moments.get(key))}


def _bounds(box: Map, axis: int) -> dict[str, Any]:
    if not all(box.get(key) and is_vector(box[key]) for key in ("min", "max")):
        return {}
    low, high = list(box["min"]), list(box["max"])
    low[axis], high[axis] = _negative(high[axis]), _negative(low[axis])
    return {"min": listed(low, box["min"]), "max": listed(high, box["max"])}


def _scale(mesh: Map, axis: int) -> dict[str, Any]:
    values = mesh.get("scale") or listed((1, 1, 1), mesh)
    return {"scale": listed(_reflected(values, axis, False), values)} if is_vector(values) else {}


def _gear(actuator: Map, axis: int) -> dict[str, Any]:
    """Reflect the gear of an actuator: of a ball a torque, of a site a force and a torque."""
    gear = actuator.get("gear")
    if not isinstance(gear, list) or len(gear) not in (3, 6) or not all(map(is_number, gear)):
        return {}
    return {"gear": listed([*_reflected(gear[:-3], axis, False), *_reflected(gear[-3:], axis, True)], gear)}


# By the annotation ``x-mirror``, whose keys are ``annotations.MIRRORED_KEYS``.
MIRRORED: Mapping[str, Callable[[Map, int], dict[str, Any]]] = {
    "pose": _vectors(("xyz",), ("rpy",)),
    "axis": _axis,
    "direction": _vectors(("direction",)),
    "dir": _vectors(("dir",)),
    "at": _vectors(("at",)),
    "grid": _grid,
    "inertia": _inertia,
    "bounds": _bounds,
    "scale": _scale,
    "gear": _gear,
}


def side(role: str, axis: int | None) -> str:
    """Return the role of mirrored wheels: ``front_left`` across y is ``front_right``."""
    swapped = _SIDES[axis] if axis is not None else {}
    return "_".join(swapped.get(word, word) for word in role.split("_"))


def is_number(value: Any, dimension: Dimension | None = None) -> bool:
    """Return True for a number, of a dimension if one is requested; a bare number is of any."""
    if isinstance(value, bool) or not isinstance(value, (int, float)):
        return False
    return dimension is None or not isinstance(value, Quantity) or value.dimension == dimension


def is_vector(value: Any, dimension: Dimension | None = None) -> bool:
    """Return True for three finite numbers, of a dimension if one is requested, or None."""
    if value is None:
        return True
    if not isinstance(value, list) or len(value) != 3:
        return False
    return all(is_number(v, dimension) and math.isfinite(v) for v in value)


def listed(values: Iterable[Any], like: Any) -> Seq:
    """Return a sequence of values with the places of another one, or the place of a mapping."""
    made = Seq(like.span, like.via)
    spans = getattr(like, "value_spans", None)
    for index, value in enumerate(values):
        made.put(value, spans[index] if isinstance(spans, list) and index < len(spans) else like.span)
    return made


def _reflected(values: Iterable[Any], axis: int, axial: bool) -> list[Any]:
    """Return a reflected vector; that of a rotation (``axial``) changes its other components."""
    return [_negative(v) if (i == axis) != axial else v for i, v in enumerate(values)]


def _negative(value: float) -> float:
    # A quantity stays one, and zero stays as it is.
    if not value:
        return value
    return Quantity(-value, value.dimension, value.text) if isinstance(value, Quantity) else -value
