"""Results of extract as YAML that can be pasted or included, and as values for JSON."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from typing import Any

from ..formatting import exact
from ..model import Box, Capsule, Cylinder, HeightMap, Shape
from ..yaml_text import escaped, quoted, scalar


def name(text: str) -> str:
    """Return a name as YAML that means just this name, inside brackets too."""
    return scalar(escaped(text), flow=True)


def number(value: float) -> str:
    """Return metres as the shortest decimal that reads back as the same double."""
    return exact(value)


def angle(value: float) -> str:
    """Return an angle: whole degrees as such, anything else in radians."""
    degrees = round(math.degrees(value))
    return f"{degrees} deg" if degrees and math.radians(degrees) == value else exact(value)


def row(values: Iterable[float]) -> str:
    """Return numbers as a list on one line."""
    return f"[{', '.join(map(number, values))}]"


def length(value: float) -> str:
    """Return a length as people write it: 10 mm."""
    millimetres = float(f"{value * 1000:.12g}")
    return f"{exact(millimetres)} mm" if millimetres / 1000 == value else exact(value)


def source(status: str, note: str) -> str:
    """Return the value of ``source``."""
    return f"{{status: {status}, note: {quoted(note)}}}"


def shape(piece: Shape) -> str:
    """Return a shape as an entry of ``collision`` on one line."""
    geometry = piece.geometry
    if isinstance(geometry, Box) and geometry.centre != (0.0, 0.0, 0.0):
        text = f"box: {{min: {row(geometry.lower)}, max: {row(geometry.upper)}}}"
    elif isinstance(geometry, Box):
        text = f"box: {{size: {row(geometry.size)}}}"
    elif isinstance(geometry, Cylinder | Capsule):
        kind = "cylinder" if isinstance(geometry, Cylinder) else "capsule"
        text = f"{kind}: {{radius: {number(geometry.radius)}, length: {number(geometry.length)}}}"
    else:
        raise TypeError(f"no shape around a mesh: {geometry!r}")
    if piece.pose.xyz != (0, 0, 0):
        text += f", xyz: {row(piece.pose.xyz)}"
    if piece.pose.rpy != (0, 0, 0):
        text += f", rpy: [{', '.join(map(angle, piece.pose.rpy))}]"
    return f"{{{text}}}"


def shape_values(piece: Shape) -> dict[str, Any]:
    """Return a shape as values for JSON: metres and radians."""
    geometry = piece.geometry
    if isinstance(geometry, Box):
        value: dict[str, Any] = {"box": {"min": list(geometry.lower), "max": list(geometry.upper)}}
    elif isinstance(geometry, Cylinder | Capsule):
        kind = "cylinder" if isinstance(geometry, Cylinder) else "capsule"
        value = {kind: {"radius": geometry.radius, "length": geometry.length}}
    else:
        raise TypeError(f"no shape around a mesh: {geometry!r}")
    return value | {"xyz": list(map(float, piece.pose.xyz)), "rpy": list(map(float, piece.pose.rpy))}


def height_rows(heights: Sequence[Sequence[float]]) -> list[str]:
    """Return the rows of a height map, each as a list on one line."""
    return [row(heights_of_row) for heights_of_row in heights]


def height_map(link: str, made: HeightMap, status: str, note: str) -> list[str]:
    """Return the lines of a section ``links`` with a height map as the collision of a link."""
    lines = [
        "links:",
        f"  {name(link)}:",
        "    collision:",
        "      - height_map:",
        f"          origin: {row(made.origin)}",
        f"          cell: {length(made.cell)}",
        *([f"          step: {length(made.step)}"] if made.step != made.cell else []),
        f"          method: {quoted(made.method)}",
        f"          heights:           # a row is {length(made.cell)} of x, a number in it of y; 0 is no body",
    ]
    lines += [f"            - {text}" for text in height_rows(made.heights)]
    return [*lines, f"        source: {source(status, note)}"]


def driver_height_map(link: str, made: HeightMap) -> dict[str, Any]:
    """Return a height map in the form of the driver's model (schemas/robot_model.schema.json)."""
    return {
        "frame": link,
        "origin_xy": list(made.origin),
        "cell": made.cell,
        "method": made.method,
        "z": [list(heights) for heights in made.heights],
    }
