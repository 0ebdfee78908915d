"""Format the results of extract as YAML, JSON and tables, and write them to files."""

from __future__ import annotations

import dataclasses
import math
import os
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from rosorin_compile.model import Box, Capsule, Cylinder, HeightMap, Shape
from rosorin_compile.model.mesh_triangles import ExtractProblem
from rosorin_compile.output import OutputError, write_file
from rosorin_compile.source import files
from rosorin_compile.source.numbers import exact
from rosorin_compile.source.yaml_text import Scalar

from ..layout import Verbatim, escape, layout

if TYPE_CHECKING:
    from .shapes import Fit, FitQuality
    from .sources import Part

MARK = "# rosorin-compile extract"  # begins every file that extract writes


class FittedPart(NamedTuple):
    """A part with a shape of each kind around it, and how well each fits."""

    part: Part
    fits: Mapping[str, Fit]
    quality: Mapping[str, FitQuality]

    @property
    def smallest(self) -> str:
        """The kind of shape with the least volume."""
        return min(self.fits, key=lambda kind: self.fits[kind].volume)


def numbers(values: Iterable[float]) -> list[Verbatim]:
    """Return numbers as ``layout`` writes them: the shortest decimals that read back as the same double."""
    return [Verbatim(exact(value)) for value in values]


def row(values: Iterable[float]) -> str:
    """Return numbers as a YAML list on one line."""
    return f"[{', '.join(map(exact, values))}]"


def length(value: float) -> str:
    """Return a length in millimetres where that is exact, else in metres: 10 mm."""
    millimetres = float(f"{value * 1000:.12g}")
    return f"{exact(millimetres)} mm" if millimetres / 1000 == value else exact(value)


def source_line(status: str, note: str) -> str:
    """Return the key ``source`` with its value on one line."""
    return f"source: {{status: {status}, note: {Scalar(note).in_quotes()}}}"


def _sizes(shape: Shape) -> dict[str, dict[str, Any]]:
    """Return the kind of a shape with its numbers."""
    geometry = shape.geometry
    if isinstance(geometry, Box):
        return {"box": {"min": list(geometry.lower), "max": list(geometry.upper)}}
    assert isinstance(geometry, Cylinder | Capsule)  # noqa: S101 - fits have no other shape
    kind = "cylinder" if isinstance(geometry, Cylinder) else "capsule"
    return {kind: {"radius": geometry.radius, "length": geometry.length}}


def shape_entry(shape: Shape) -> dict[str, Any]:
    """Return a shape as an entry of ``collision``, as ``layout`` takes it."""
    (kind, sizes), geometry = next(iter(_sizes(shape).items())), shape.geometry
    if isinstance(geometry, Box) and geometry.centre == (0.0, 0.0, 0.0):
        sizes = {"size": geometry.size}
    entry: dict[str, Any] = {
        kind: {key: numbers(value) if kind == "box" else Verbatim(exact(value)) for key, value in sizes.items()}
    }
    if shape.pose.xyz != (0, 0, 0):
        entry["xyz"] = numbers(shape.pose.xyz)
    if shape.pose.rpy != (0, 0, 0):
        whole = [round(math.degrees(angle)) for angle in shape.pose.rpy]
        entry["rpy"] = [
            Verbatim(f"{degrees} deg" if degrees and math.radians(degrees) == angle else exact(angle))
            for degrees, angle in zip(whole, shape.pose.rpy, strict=True)
        ]
    return entry


def boxes_yaml(parts: Sequence[FittedPart], kind: str) -> str:
    """Return a section ``links`` with a shape of one kind, or the smallest, for each part."""
    links = {}
    for fitted in parts:
        fit = fitted.fits[fitted.smallest if kind == "smallest" else kind]
        shape = {"box": "axis-aligned box", "stack": f"stack of {len(fit.pieces)} boxes"}.get(fit.kind)
        note = f"{shape or fit.kind.replace('_', ' ')} around {', '.join(fitted.part.meshes)}"
        links[fitted.part.name] = {
            "collision": [shape_entry(piece) for piece in fit.pieces],
            "source": {"status": "calculated", "note": note},
        }
    return layout({"links": links})


def boxes_json(parts: Sequence[FittedPart]) -> dict[str, Any]:
    """Return all shapes and their fit: metres, cubic metres, radians."""

    def entry(shape: Shape) -> dict[str, Any]:
        return {**_sizes(shape), "xyz": list(map(float, shape.pose.xyz)), "rpy": list(map(float, shape.pose.rpy))}

    return {
        fitted.part.name: {
            "meshes": list(fitted.part.meshes),
            "triangles": len(fitted.part.triangles),
            "closed": all(one.overhang is not None for one in fitted.quality.values()),
            "smallest": fitted.smallest,
            "shapes": {
                kind: {
                    "shapes": list(map(entry, fitted.fits[kind].pieces)),
                    "volume": one.volume,
                    "overhang_volume": one.overhang,
                    "overlap": one.overlap,
                }
                for kind, one in fitted.quality.items()
            },
        }
        for fitted in parts
    }


def boxes_table(parts: Sequence[FittedPart]) -> list[str]:
    """Return the lines of a table of all shapes."""
    rows = [("part", "shape", "volume", "overhang", "overlap")]
    for fitted in parts:
        for kind, one in fitted.quality.items():
            shape = f"stack of {len(fitted.fits[kind].pieces)}" if kind == "stack" else kind.replace("_", " ")
            overhang = "open mesh"
            if one.overhang is not None:
                overhang = f"{_volume(one.overhang)} ({100 * one.overhang / one.volume:.0f}%)"
            overlap = math.floor(one.overlap * 1000) / 10  # 100% means all of it, not nearly all
            rows.append((fitted.part.name, shape, _volume(one.volume), overhang, f"{overlap:g}%"))
    width = max(len(name) for name, *_ in rows)
    return [f"{row[0]:<{width}}  {row[1]:<12}  {row[2]:>10}  {row[3]:>16}  {row[4]:>7}" for row in rows]


def _volume(value: float) -> str:
    return f"{value * 1e6:.1f} cm3" if value < 0.01 else f"{value * 1e3:.1f} l"


def height_map_yaml(link: str, height_map: HeightMap, status: str, note: str) -> str:
    """Return a section ``links`` with a height map as the collision of a link."""
    cell = length(height_map.cell)
    lines = [
        "links:",
        f"  {Scalar(escape(link)).as_text(True)}:",
        "    collision:",
        "      - height_map:",
        f"          origin: {row(height_map.origin)}",
        f"          cell: {cell}",
        *([f"          step: {length(height_map.step)}"] if height_map.step != height_map.cell else []),
        f"          method: {Scalar(height_map.method).in_quotes()}",
        f"          heights:           # one row per {cell} of x, one number per {cell} of y; 0 means no body",
    ]
    lines += [f"            - {row(heights)}" for heights in height_map.heights]
    if isinstance(height_map.bottom, float) and height_map.bottom:
        lines.append(f"          bottom: {length(height_map.bottom)}")
    return "\n".join([*lines, f"        {source_line(status, note)}"]) + "\n"


def save(path: Path, text: str, force: bool = False) -> None:
    """Write a file; one that extract did not make is replaced only with ``force``. Raises ExtractProblem."""
    if not force and os.path.lexists(path):
        try:
            is_ours = is_made(files.read_bytes(path, len(MARK)))
        except OSError:
            is_ours = False
        if not is_ours:
            message = f"{path} exists, and extract did not make it"
            raise ExtractProblem.new("extract-file", message, "name another file, or add --force")
    replace(path, text)


def replace(path: Path, text: str) -> None:
    """Replace the text of a file atomically; a link stays a link. Raises ExtractProblem."""
    try:
        write_file(path, text.encode(), may_replace=None)
    except OutputError as problem:
        raise ExtractProblem(dataclasses.replace(problem.diagnostic, rule="extract-file")) from None


def is_made(old: bytes) -> bool:
    """Return True if extract made a file."""
    return old.startswith(MARK.encode())
