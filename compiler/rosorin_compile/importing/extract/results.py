"""Format the results of extract: sections of a description as YAML, values for JSON, tables for the terminal."""

from __future__ import annotations

import dataclasses
import math
import os
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

from rosorin_compile.model import Box, Capsule, Cylinder, HeightMap, Shape
from rosorin_compile.model.mesh_triangles import ExtractProblem
from rosorin_compile.output import OutputError, write_file
from rosorin_compile.source import files
from rosorin_compile.source.numbers import exact
from rosorin_compile.source.yaml_text import Scalar

from ..layout import Verbatim, escaped, layout
from .fit_quality import FitQuality
from .shapes import KINDS, Fit
from .sources import Part

MARK = "# rosorin-compile extract"  # begins every file that extract writes
_HEAD = ("part", "shape", "volume", "overhang", "sticks out", "overlap")


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
    """Return the value of ``source`` on one line."""
    return f"{{status: {status}, note: {Scalar(note).quoted()}}}"


def shape_entry(shape: Shape) -> dict[str, Any]:
    """Return a shape as an entry of ``collision``, as ``layout`` takes it."""
    geometry = shape.geometry
    entry: dict[str, Any]
    if isinstance(geometry, Box):
        is_centred = geometry.centre == (0.0, 0.0, 0.0)
        sides = {"size": geometry.size} if is_centred else {"min": geometry.lower, "max": geometry.upper}
        entry = {"box": {key: numbers(value) for key, value in sides.items()}}
    else:
        assert isinstance(geometry, Cylinder | Capsule)  # noqa: S101 - fits have no other shape
        kind = "cylinder" if isinstance(geometry, Cylinder) else "capsule"
        radius, height = numbers((geometry.radius, geometry.length))
        entry = {kind: {"radius": radius, "length": height}}
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
    values: dict[str, Any] = {}
    for part, fits, quality in parts:
        is_closed = all(one.overhang is not None for one in quality.values())
        values[part.name] = {
            "meshes": list(part.meshes),
            "triangles": len(part.triangles),
            "closed": is_closed,
            "smallest": min(fits, key=lambda kind: fits[kind].volume),
            "shapes": {
                kind: {
                    "shapes": [_shape_json(piece) for piece in fits[kind].pieces],
                    "volume": one.volume,
                    "overhang_volume": one.overhang,
                    "sticks_out": one.sticks_out,
                    "overlap": one.overlap,
                    "overlap_of": "volume" if is_closed else "surface",
                }
                for kind, one in quality.items()
            },
        }
    return values


def _shape_json(shape: Shape) -> dict[str, Any]:
    geometry = shape.geometry
    if isinstance(geometry, Box):
        value: dict[str, Any] = {"box": {"min": list(geometry.lower), "max": list(geometry.upper)}}
    else:
        assert isinstance(geometry, Cylinder | Capsule)  # noqa: S101 - fits have no other shape
        kind = "cylinder" if isinstance(geometry, Cylinder) else "capsule"
        value = {kind: {"radius": geometry.radius, "length": geometry.length}}
    return value | {"xyz": list(map(float, shape.pose.xyz)), "rpy": list(map(float, shape.pose.rpy))}


def boxes_table(parts: Sequence[FittedPart]) -> list[str]:
    """Return the lines of a table of all shapes."""
    rows = [_HEAD]
    for fitted in parts:
        for kind in KINDS:
            fit, quality = fitted.fits[kind], fitted.quality[kind]
            is_open = quality.overhang is None
            overhang = "open mesh"
            if quality.overhang is not None:
                overhang = f"{_volume(quality.overhang)} ({100 * quality.overhang / quality.volume:.0f}%)"
            # 100% means all of it, not nearly all.
            overlap = "100%" if quality.overlap > 1 - 1e-6 else f"{math.floor(quality.overlap * 1000) / 10:g}%"
            rows.append(
                (
                    fitted.part.name if kind == KINDS[0] else "",
                    f"stack of {len(fit.pieces)}" if kind == "stack" else kind.replace("_", " "),
                    _volume(quality.volume),
                    overhang,
                    f"{quality.sticks_out * 1000:.1f} mm",
                    f"{overlap} of surface" if is_open else overlap,
                )
            )
    widths = [max(len(cells[column]) for cells in rows) for column in range(len(_HEAD))]
    return [
        "  ".join(
            text.ljust(width) if column < 2 else text.rjust(width)
            for column, (text, width) in enumerate(zip(cells, widths, strict=True))
        ).rstrip()
        for cells in rows
    ]


def _volume(value: float) -> str:
    return f"{value * 1e6:.1f} cm3" if value < 0.01 else f"{value * 1e3:.1f} l"


def height_map_yaml(link: str, height_map: HeightMap, status: str, note: str) -> str:
    """Return a section ``links`` with a height map as the collision of a link."""
    cell = length(height_map.cell)
    lines = [
        "links:",
        f"  {Scalar(escaped(link)).written(True)}:",
        "    collision:",
        "      - height_map:",
        f"          origin: {row(height_map.origin)}",
        f"          cell: {cell}",
        *([f"          step: {length(height_map.step)}"] if height_map.step != height_map.cell else []),
        f"          method: {Scalar(height_map.method).quoted()}",
        f"          heights:           # one row per {cell} of x, one number per {cell} of y; 0 means no body",
    ]
    lines += [f"            - {row(heights)}" for heights in height_map.heights]
    if isinstance(height_map.bottom, (int, float)):
        lines += [f"          bottom: {length(height_map.bottom)}"] if height_map.bottom else []
    else:
        lines.append("          bottom:            # the lowest point of the body in each cell")
        lines += [f"            - {row(heights)}" for heights in height_map.bottom]
    return "\n".join([*lines, f"        source: {source_line(status, note)}"]) + "\n"


def save(path: Path, text: str, force: bool = False) -> None:
    """Write a file; one that extract did not make is replaced only with ``force``. Raises ExtractProblem."""
    if not force and os.path.lexists(path):
        try:
            is_ours = is_made(files.read_bytes(path, len(MARK)))
        except OSError:
            is_ours = False
        if not is_ours:
            message = f"{path} exists, and extract did not make it"
            raise ExtractProblem.of("extract-file", message, "name another file, or add --force")
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
