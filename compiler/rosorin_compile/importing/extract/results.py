"""Format the results of extract as YAML, JSON and tables, and replace the height map in a description file.

The lines of a height map are edited in place; comments and everything else stay as they are. Afterwards the old and the
new text are parsed and compared: they differ in this height map and nowhere else.
"""

from __future__ import annotations

import dataclasses
import math
import os
import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

from rosorin_compile.model import Box, Capsule, Cylinder, HeightMap, Shape
from rosorin_compile.model.mesh_triangles import ExtractProblem
from rosorin_compile.output import OutputError, write_file
from rosorin_compile.source import files
from rosorin_compile.source.diagnostics import Source, Span
from rosorin_compile.source.load import LoadError, parse_yaml, read_utf8
from rosorin_compile.source.numbers import exact
from rosorin_compile.source.tree import Map, Seq
from rosorin_compile.source.yaml_text import Scalar

from ..layout import Verbatim, escaped, layout
from .shapes import KINDS, Fit, FitQuality
from .sources import Part

_HELP = "write it in block style without anchors and aliases; or write a file with -o FILE, and paste it"
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


@dataclass(frozen=True)
class MapEntry:
    """A collision with a height map in a file: its link, its index there, and the parsed values."""

    source: Source
    link: str
    index: int
    entry: Map

    @property
    def height_map(self) -> Map:
        """The value of ``height_map``."""
        value: Map = self.entry["height_map"]
        return value

    @property
    def line(self) -> int:
        """The line of the key ``height_map``."""
        return self.entry.key_spans["height_map"].line

    def grid(self) -> tuple[float, tuple[float, float], tuple[int, int]]:
        """Return cell, origin and number of cells. Raises ExtractProblem if they are written as expressions."""
        origin: Any = self.height_map.get("origin")
        rows: Any = self.height_map.get("heights")
        values = [self.height_map.get("cell"), *(origin if isinstance(origin, Seq) else ())]
        has_rows = isinstance(rows, Seq) and rows and all(isinstance(one, Seq) and one for one in rows)
        if len(values) != 3 or not all(isinstance(value, int | float) for value in values) or not has_rows:
            message = f"the grid of the height map of {self.link} is not written in numbers"
            raise ExtractProblem.of("extract-into", message, "give --cell, --origin and --cells")
        cell, x, y = map(float, values)
        return cell, (x, y), (len(rows), len(rows[0]))


def find_map(path: Path, link: str | None) -> MapEntry:
    """Return the height map of a link in a file, or the only one. Raises ExtractProblem."""
    try:
        source = read_utf8(path, str(path))
        tree = parse_yaml(source)
    except LoadError as problem:
        raise ExtractProblem(problem.diagnostic) from None
    links = tree.get("links") if isinstance(tree, Map) else None
    maps = [
        MapEntry(source, name, index, collision)
        for name, entry in (links.items() if isinstance(links, Map) else ())
        for index, collision in enumerate((isinstance(entry, Map) and entry.get("collision")) or ())
        if isinstance(collision, Map) and isinstance(collision.get("height_map"), Map)
    ]
    matching = [one for one in maps if link in (None, one.link)]
    if len(matching) == 1:
        return matching[0]
    count = f"{len(matching)} height maps" if matching else "no height map"
    of_link = f' of the link "{link}"' if link is not None else ""
    message = f"{source.path} has {count}{of_link} under links: (existing: {', '.join(m.link for m in maps) or 'none'})"
    raise ExtractProblem.of("extract-into", message, "name its link: --frame LINK; or write a file: -o FILE")


def replaced(entry: MapEntry, new: HeightMap, status: str, note: str) -> str:
    """Return the text of the file with another height map. Raises ExtractProblem if it cannot be edited."""
    values = {
        "origin": (list(new.origin), row(new.origin)),
        "cell": (new.cell, length(new.cell)),
        "step": (new.step, length(new.step)),
        "method": (new.method, Scalar(new.method).quoted()),
    }
    old, collision = entry.height_map, entry.entry
    if new.step == old.get("step", new.cell):
        del values["step"]
    lines = [line.rstrip("\r") for line in entry.source.text.split("\n")]
    indent = " " * (min(span.column for span in old.key_spans.values()) - 1)
    heights = [f"{indent}  - {row(heights)}" for heights in new.heights]
    edits = [_edit(lines, old.key_spans["heights"], "heights:", heights)]
    for key, (value, text) in values.items():
        if key in old and old[key] != value:
            edits.append(_edit(lines, old.key_spans[key], f"{key}: {text}"))
    missing = [f"{indent}{key}: {text}" for key, (_, text) in values.items() if key not in old]
    edits.append((entry.line, entry.line, missing))
    source, span = f"source: {source_line(status, note)}", collision.key_spans["height_map"]
    if "source" in collision:
        edits.append(_edit(lines, collision.key_spans["source"], source))
    else:
        end = _block_end(lines, span)
        edits.append((end, end, [" " * (span.column - 1) + source]))
    for start, stop, text_lines in sorted(edits, key=lambda edit: edit[:2], reverse=True):
        lines[start:stop] = text_lines
    text = ("\r\n" if "\r\n" in entry.source.text else "\n").join(lines)
    _check(entry, text, new, status)
    return text


def _edit(lines: list[str], key: Span, text: str, below: Sequence[str] = ()) -> tuple[int, int, list[str]]:
    """Return the lines of a key and its value with their replacement; a comment after the key stays."""
    first = lines[key.line - 1]
    comment = re.search(r"\s+#.*$", first)
    head = first[: key.column - 1] + text + (comment[0] if comment else "")
    return key.line - 1, _block_end(lines, key), [head, *below]


def _block_end(lines: list[str], key: Span) -> int:
    """Return the line after the last one of the value of a key in block style."""
    end = key.line
    for number in range(key.line, len(lines)):
        content = lines[number].lstrip()
        depth = len(lines[number]) - len(content)
        if content and not content.startswith("#"):
            if depth < key.column - 1 or (depth == key.column - 1 and not content.startswith("- ")):
                break
            end = number + 1
    return end


def _check(entry: MapEntry, text: str, new: HeightMap, status: str) -> None:
    """Raise ExtractProblem unless the new text has the new height map and is otherwise equal to the old one."""
    try:
        before, after = parse_yaml(entry.source), parse_yaml(Source(entry.source.path, text))
        collision = after["links"][entry.link]["collision"][entry.index]
        written = collision["height_map"]
        is_right = (
            [list(one) for one in written["heights"]] == [list(one) for one in new.heights]
            and [*written["origin"], written["cell"]] == [*new.origin, new.cell]
            and collision["source"]["status"] == status
        )
        for tree in (before, after):
            collision = tree["links"][entry.link]["collision"][entry.index]
            collision.pop("source", None)
            for key in ("heights", "origin", "cell", "method", "step"):
                collision["height_map"].pop(key, None)
    except (LoadError, KeyError, IndexError, TypeError):
        raise _cannot_edit(entry) from None
    if not is_right or before != after:
        raise _cannot_edit(entry)


def _cannot_edit(entry: MapEntry) -> ExtractProblem:
    message = f"the height map of {entry.link} in {entry.source.path} is written in a way that cannot be edited"
    return ExtractProblem.of("extract-into", message, _HELP, entry.entry.key_spans["height_map"])


def changes(entry: MapEntry, new: HeightMap, status: str) -> list[str]:
    """Describe what a new height map changes."""
    old: HeightMap | None = None
    try:
        cell, origin, _ = entry.grid()
        heights = tuple(tuple(map(float, one)) for one in entry.height_map["heights"])
        old = HeightMap(origin, cell, heights, float(entry.height_map.get("step", cell)))
        boxes = f"boxes {len(old.boxes())} -> {len(new.boxes())}"
    except (ExtractProblem, TypeError, ValueError):
        old = None
    lines = []
    if old is None or _grid_text(old) != _grid_text(new):
        lines.append(f"grid {_grid_text(old) if old else 'written in expressions'} -> {_grid_text(new)}")
    else:
        pairs = [pair for rows in zip(old.heights, new.heights, strict=True) for pair in zip(*rows, strict=True)]
        differences = [abs(a - b) for a, b in pairs if a != b]
        largest = max(differences, default=0.0) * 1000
        lines.append(f"cells changed: {len(differences)} of {len(pairs)}, by up to {largest:.1f} mm")
    if old is not None:
        highest = [max(map(max, one.heights)) for one in (old, new)]
        lines.append(f"highest {highest[0]:g} -> {highest[1]:g} m, {boxes}")
    source: Any = entry.entry.get("source")
    before = source.get("status", "not given") if isinstance(source, Map) else "not given"
    return [*lines, f"source: {before} -> {status}" if before != status else f"source: {status}"]


def _grid_text(one: HeightMap) -> str:
    size = f"{len(one.heights)} x {len(one.heights[0])} cells of {one.cell * 1000:g} mm"
    return f"{size} from {one.origin[0]:g}, {one.origin[1]:g}"
