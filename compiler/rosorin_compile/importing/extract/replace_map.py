"""Replace the height map in a description file.

The lines of a height map are edited in place; comments and everything else stay as they are. Afterwards the old and the
new text are parsed and compared: they differ in this height map and nowhere else.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from rosorin_compile.model import HeightMap
from rosorin_compile.model.mesh_triangles import ExtractProblem
from rosorin_compile.source.diagnostics import Source, Span
from rosorin_compile.source.load import LoadError, parse_yaml, read_utf8
from rosorin_compile.source.tree import Map
from rosorin_compile.source.yaml_text import Scalar

from .results import length, row, source_line
from .sources import GridOptions

_HELP = "write it in block style without anchors and aliases; or write a file with -o FILE, and paste it"


@dataclass(frozen=True)
class MapEntry:
    """A collision with a height map in a file: its link, its index there, and the parsed values."""

    source: Source
    link: str
    index: int
    entry: Map

    @property
    def line(self) -> int:
        """The line of the key ``height_map``."""
        return self.entry.key_spans["height_map"].line

    @property
    def numbers(self) -> HeightMap | None:
        """The grid, heights and step of the map, or None if they are not written in numbers."""
        values: Map = self.entry["height_map"]
        try:
            x, y = map(float, values["origin"])
            heights = tuple(tuple(map(float, row)) for row in values["heights"])
            cell = float(values["cell"])
            return HeightMap((x, y), cell, heights, float(values.get("step", cell))) if all(heights) else None
        except (KeyError, TypeError, ValueError):
            return None

    def complete(self, grid: GridOptions) -> GridOptions:
        """Return options with the grid and the step of this map as defaults. Raises ExtractProblem."""
        old = self.numbers
        if old is not None:
            size = grid.size or (len(old.heights) * old.cell, len(old.heights[0]) * old.cell)
            cell, origin, step = grid.cell or old.cell, grid.origin or old.origin, grid.step or old.step
            return replace(grid, cell=cell, origin=origin, size=None if grid.cells else size, step=step)
        if None in (grid.cell, grid.origin) or (grid.cells is None and grid.size is None):
            message = f"the grid of the height map of {self.link} is not written in numbers"
            raise ExtractProblem.new("extract-into", message, "give --cell, --origin and --cells")
        return grid


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
    raise ExtractProblem.new("extract-into", message, "name its link: --frame LINK; or write a file: -o FILE")


def replace_map(entry: MapEntry, new: HeightMap, status: str, note: str) -> str:
    """Return the text of the file with another height map. Raises ExtractProblem if it cannot be edited."""
    old, spans = entry.entry["height_map"], entry.entry.key_spans
    texts = {
        key: text
        for key, value, text in (
            ("origin", list(new.origin), row(new.origin)),
            ("cell", new.cell, length(new.cell)),
            ("step", new.step, length(new.step)),
            ("method", new.method, Scalar(new.method).in_quotes()),
        )
        if old.get(key, new.cell if key == "step" else None) != value
    }
    lines = [line.rstrip("\r") for line in entry.source.text.split("\n")]
    indent = " " * (min(span.column for span in old.key_spans.values()) - 1)
    heights = [f"{indent}  - {row(heights)}" for heights in new.heights]
    edits = [_edit(lines, old.key_spans["heights"], "heights:", heights)]
    edits += [_edit(lines, old.key_spans[key], f"{key}: {text}") for key, text in texts.items() if key in old]
    edits.append((entry.line, entry.line, [f"{indent}{key}: {text}" for key, text in texts.items() if key not in old]))
    if "source" in spans:
        edits.append(_edit(lines, spans["source"], source_line(status, note)))
    else:
        end = _block_end(lines, spans["height_map"])
        edits.append((end, end, [" " * (spans["height_map"].column - 1) + source_line(status, note)]))
    for start, stop, new_lines in sorted(edits, key=lambda edit: edit[:2], reverse=True):
        lines[start:stop] = new_lines
    text = ("\r\n" if "\r\n" in entry.source.text else "\n").join(lines)
    try:
        before, after = parse_yaml(entry.source), parse_yaml(Source(entry.source.path, text))
        entries = [tree["links"][entry.link]["collision"][entry.index] for tree in (before, after)]
        written = MapEntry(entry.source, entry.link, entry.index, entries[1]).numbers
        is_right = written == replace(new, method="", bottom=0.0) and entries[1].pop("source")["status"] == status
        entries[0].pop("source", None)
        for key in ("heights", "origin", "cell", "method", "step"):
            for collision in entries:
                collision["height_map"].pop(key, None)
    except (LoadError, KeyError, IndexError, TypeError):
        is_right = False
    if not is_right or before != after:
        message = f"the height map of {entry.link} in {entry.source.path} is written in a way that cannot be edited"
        raise ExtractProblem.new("extract-into", message, _HELP, spans["height_map"])
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


def changes(entry: MapEntry, new: HeightMap, status: str) -> list[str]:
    """Describe what a new height map changes."""
    old = entry.numbers
    if old is None or _grid_text(old) != _grid_text(new):
        lines = [f"grid {_grid_text(old) if old else 'written in expressions'} -> {_grid_text(new)}"]
    else:
        pairs = [pair for rows in zip(old.heights, new.heights, strict=True) for pair in zip(*rows, strict=True)]
        differences = [abs(a - b) for a, b in pairs if a != b]
        largest = max(differences, default=0.0) * 1000
        lines = [f"cells changed: {len(differences)} of {len(pairs)}, by up to {largest:.1f} mm"]
    source: Any = entry.entry.get("source")
    before = source.get("status", "not given") if isinstance(source, Map) else "not given"
    return [*lines, f"source: {before} -> {status}" if before != status else f"source: {status}"]


def _grid_text(one: HeightMap) -> str:
    size = f"{len(one.heights)} x {len(one.heights[0])} cells of {one.cell * 1000:g} mm"
    return f"{size} from {one.origin[0]:g}, {one.origin[1]:g}"
