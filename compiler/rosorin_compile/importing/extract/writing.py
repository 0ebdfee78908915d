"""Results of extract as YAML that can be pasted or included, and as values for JSON.

``save`` and ``replace`` write files one by one: whole or not at all, and never over somebody else's.
"""

from __future__ import annotations

import dataclasses
import math
import os
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

from rosorin_compile.model import Box, Capsule, Cylinder, HeightMap, Shape
from rosorin_compile.model.mesh_triangles import ExtractProblem
from rosorin_compile.output import OutputError, write_file
from rosorin_compile.source import files
from rosorin_compile.source.numbers import exact
from rosorin_compile.source.rule_registry import Heading, Rule
from rosorin_compile.source.yaml_text import Scalar

from ..layout import escaped

RULES = (
    Rule(
        "extract-file",
        "A result cannot be written, or would overwrite a file that `extract` did not make.",
        "Another name, or `--force`.",
        Heading.MESHES,
    ),
)


def name(text: str) -> str:
    """Return a name as YAML that means just this name, inside brackets too."""
    return Scalar(escaped(text)).written(True)


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
    return f"{{status: {status}, note: {Scalar(note).quoted()}}}"


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
        f"          method: {Scalar(made.method).quoted()}",
        f"          heights:           # a row is {length(made.cell)} of x, a number in it of y; 0 is no body",
    ]
    lines += [f"            - {text}" for text in height_rows(made.heights)]
    if isinstance(made.bottom, (int, float)):
        lines += [f"          bottom: {length(made.bottom)}"] if made.bottom else []
    else:
        lines.append("          bottom:            # where the body begins in each cell")
        lines += [f"            - {text}" for text in height_rows(made.bottom)]
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


# The first words of every file that extract writes.
MARK = "# rosorin-compile extract"


def save(path: Path, text: str, force: bool = False) -> None:
    """Write a file; one that extract did not make is overwritten only with ``force``. Raises ExtractProblem."""
    if not force and os.path.lexists(path) and not _is_ours(path):
        message = f"{path} is there, and extract did not make it"
        raise ExtractProblem.of("extract-file", message, "name another file, or add --force")
    replace(path, text)


def replace(path: Path, text: str) -> None:
    """Put a new text into a file: after a kill at any moment it holds the old or the new one. Raises ExtractProblem.

    A link stays a link, and permissions stay as they are.
    """
    try:
        write_file(path, text.encode(), may_replace=None)
    except OutputError as problem:
        raise ExtractProblem(dataclasses.replace(problem.diagnostic, rule="extract-file")) from None


def is_made(old: bytes) -> bool:
    """Return True if extract made a file: no other is replaced."""
    return old.startswith(MARK.encode())


def _is_ours(path: Path) -> bool:
    try:
        return files.read_bytes(path, len(MARK)) == MARK.encode()
    except OSError:
        return False
