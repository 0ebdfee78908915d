"""Replace the height map in a description file: only its values and their source change.

The lines of the map are edited in place; comments and everything else stay as they are. Afterwards the old and the new
text are parsed and compared: they differ in this height map and nowhere else.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from rosorin_compile.model import HeightMap
from rosorin_compile.model.mesh_triangles import ExtractProblem
from rosorin_compile.source.diagnostics import Source, Span
from rosorin_compile.source.load import LoadError, parse_yaml, read_utf8
from rosorin_compile.source.tree import Map, Seq
from rosorin_compile.source.yaml_text import Scalar

from .results import length, row, source_line

_HELP = "write it in block style without anchors and aliases; or write a file with -o FILE, and paste it"


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
