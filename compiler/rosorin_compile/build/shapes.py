"""Building shapes: the entry of a collision or a visual becomes a geometry at a pose."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from ..model import Box, Capsule, Cylinder, Geometry, HeightMap, Mesh, Pose, Shape, Sphere


class ShapeProblem(Exception):
    """A shape that cannot be built; ``path`` leads to the culprit within the entry."""

    def __init__(self, rule: str, message: str, path: tuple[str | int, ...] = (), help: str = "") -> None:
        super().__init__(message)
        self.rule = rule
        self.message = message
        self.path = path
        self.help = help


def build_shape(entry: Mapping[str, Any], pose: Pose, stand_in: str) -> Shape:
    """Return the shape of an entry; ``stand_in`` is what is not measured about it. Raises ShapeProblem."""
    kinds = [kind for kind in GEOMETRIES if kind in entry]
    if len(kinds) != 1:
        found = " and ".join(kinds) or "none of them"
        message = f"a shape has one of {', '.join(GEOMETRIES)}; this one has {found}"
        raise ShapeProblem("shape-kind", message, (), "write one entry a shape")
    kind = kinds[0]
    geometry = GEOMETRIES[kind](entry[kind])
    rgba = entry.get("rgba")
    colour = None if rgba is None else (float(rgba[0]), float(rgba[1]), float(rgba[2]), float(rgba[3]))
    return Shape(geometry, pose, entry.get("name", ""), colour, entry.get("material", ""), stand_in)


def _box(entry: Mapping[str, Any]) -> Box:
    if ("size" in entry) == ("min" in entry):
        raise ShapeProblem("shape-kind", "a box has either a size or the corners min and max", ("box",), "give one")
    if "size" in entry:
        x, y, z = (_positive(value, "box", "size", index) for index, value in enumerate(entry["size"]))
        return Box((-x / 2, -y / 2, -z / 2), (x / 2, y / 2, z / 2))
    lower, upper = entry["min"], entry["max"]
    for index in range(3):
        if not lower[index] < upper[index]:
            message = f"{'xyz'[index]} of max ({upper[index]:g} m) is not above that of min ({lower[index]:g} m)"
            raise ShapeProblem("shape-size", message, ("box", "max", index), "swap or correct the corners")
    a, b, c = map(float, lower)
    d, e, f = map(float, upper)
    return Box((a, b, c), (d, e, f))


def _height_map(entry: Mapping[str, Any]) -> HeightMap:
    rows = entry["heights"]
    for index, row in enumerate(rows):
        if len(row) != len(rows[0]):
            message = f"row {index + 1} has {len(row)} heights, the first row {len(rows[0])}"
            raise ShapeProblem("height-map-rows", message, ("height_map", "heights", index), "give all rows one length")
    for i, row in enumerate(rows):
        for j, height in enumerate(row):
            if height < 0:
                path = ("height_map", "heights", i, j)
                raise ShapeProblem("height-map-rows", "a height is below zero", path, "heights count up from z = 0")
    cell = _positive(entry["cell"], "height_map", "cell")
    step = _positive(entry["step"], "height_map", "step") if "step" in entry else cell
    heights = tuple(tuple(map(float, row)) for row in rows)
    x, y = map(float, entry["origin"])
    return HeightMap((x, y), cell, heights, step, entry.get("method", ""))


def _mesh(entry: Mapping[str, Any]) -> Mesh:
    x, y, z = map(float, entry.get("scale", (1, 1, 1)))
    return Mesh(entry["file"], (x, y, z))


def _positive(value: float, *path: str | int) -> float:
    if not value > 0:
        words = " ".join(str(step) for step in path)
        raise ShapeProblem("shape-size", f"{words} is {value:g} m; a size is above zero", path, "correct it")
    return float(value)


def _cylinder(entry: Mapping[str, Any]) -> Cylinder:
    return Cylinder(_positive(entry["radius"], "cylinder", "radius"), _positive(entry["length"], "cylinder", "length"))


def _capsule(entry: Mapping[str, Any]) -> Capsule:
    return Capsule(_positive(entry["radius"], "capsule", "radius"), _positive(entry["length"], "capsule", "length"))


GEOMETRIES: Mapping[str, Callable[[Mapping[str, Any]], Geometry]] = {
    "box": _box,
    "cylinder": _cylinder,
    "capsule": _capsule,
    "sphere": lambda entry: Sphere(_positive(entry["radius"], "sphere", "radius")),
    "mesh": _mesh,
    "height_map": _height_map,
}
