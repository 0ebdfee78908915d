"""Write a height map as YAML, or replace the one in a description file.

The lines of a height map are edited in place; comments and everything else stay as they are. Afterwards the old and the
new text are parsed and compared: they differ in this height map and nowhere else.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from rosorin_compile.model import HeightMap
from rosorin_compile.model.mesh_triangles import ExtractProblem
from rosorin_compile.source.diagnostics import Source, Span
from rosorin_compile.source.load import LoadError, parse_yaml, read_utf8
from rosorin_compile.source.numbers import exact
from rosorin_compile.source.tree import Map
from rosorin_compile.source.yaml_text import Scalar

from ..layout import escape
from .sources import GridOptions

_HELP = "write it in block style without anchors and aliases; or write a file with -o FILE, and paste it"


def height_map_yaml(link: str, height_map: HeightMap, status: str, note: str) -> str:
    """Return a section ``links`` with a height map as the collision of a link."""
    cell = _length(height_map.cell)
    lines = [
        "links:",
        f"  {Scalar(escape(link)).as_text(True)}:",
        "    collision:",
        "      - height_map:",
        f"          origin: {_row(height_map.origin)}",
        f"          cell: {cell}",
        *([f"          step: {_length(height_map.step)}"] if height_map.step != height_map.cell else []),
        f"          method: {Scalar(height_map.method).in_quotes()}",
        f"          heights:           # one row per {cell} of x, one number per {cell} of y; 0 means no body",
        *(f"            - {_row(heights)}" for heights in height_map.heights),
    ]
    if isinstance(height_map.bottom, float) and height_map.bottom:
        lines.append(f"          bottom: {_length(height_map.bottom)}")
    return "\n".join([*lines, f"        {_source_line(status, note)}"]) + "\n"


def _row(values: Iterable[float]) -> str:
    return f"[{', '.join(map(exact, values))}]"


def _length(value: float) -> str:
    """Return a length in millimetres where that is exact, else in metres: 10 mm."""
    millimetres = float(f"{value * 1000:.12g}")
    return f"{exact(millimetres)} mm" if millimetres / 1000 == value else exact(value)


def _source_line(status: str, note: str) -> str:
    return f"source: {{status: {status}, note: {Scalar(note).in_quotes()}}}"


@dataclass(frozen=True)
class MapEntry:
    """A collision with a height map in a file: its link, its index there, and the parsed values."""

    source: Source
    link: str
    index: int
    collision: Map

    def complete(self, grid: GridOptions) -> GridOptions:
        """Return options with the grid and the step of this map as defaults. Raises ExtractProblem."""
        values: Map = self.collision["height_map"]
        try:
            x, y = map(float, values["origin"])
            cell = float(values["cell"])
            step = float(values.get("step", cell))
            size = len(values["heights"]) * cell, len(values["heights"][0]) * cell
        except (KeyError, IndexError, TypeError, ValueError):
            message = f"the height map of {self.link} is not written in numbers"
            raise ExtractProblem.new("extract-into", message, _HELP) from None
        cell, origin, step = grid.cell or cell, grid.origin or (x, y), grid.step or step
        return replace(grid, cell=cell, origin=origin, size=None if grid.cells else grid.size or size, step=step)


def find_map(path: Path, link: str | None) -> MapEntry:
    """Return the height map of a link in a file, or the only one. Raises SourceError."""
    source = read_utf8(path, str(path))
    tree = parse_yaml(source)
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
    old, spans = entry.collision["height_map"], entry.collision.key_spans
    values: dict[str, Any] = {"origin": list(new.origin), "cell": new.cell, "method": new.method}
    texts = {"origin": _row(new.origin), "cell": _length(new.cell), "method": Scalar(new.method).in_quotes()}
    if "step" in old or new.step != new.cell:
        values["step"], texts["step"] = new.step, _length(new.step)
    texts = {key: text for key, text in texts.items() if old.get(key) != values[key]}
    lines = [line.rstrip("\r") for line in entry.source.text.split("\n")]
    indent = " " * (min(span.column for span in old.key_spans.values()) - 1)
    heights = [f"{indent}  - {_row(heights)}" for heights in new.heights]
    edits = [_edit(lines, old.key_spans["heights"], "heights:", heights)]
    edits += [_edit(lines, old.key_spans[key], f"{key}: {text}") for key, text in texts.items() if key in old]
    top = spans["height_map"].line
    edits.append((top, top, [f"{indent}{key}: {text}" for key, text in texts.items() if key not in old]))
    if "source" in spans:
        edits.append(_edit(lines, spans["source"], _source_line(status, note)))
    else:
        end, column = _block_end(lines, spans["height_map"]), spans["height_map"].column
        edits.append((end, end, [" " * (column - 1) + _source_line(status, note)]))
    for start, stop, new_lines in sorted(edits, key=lambda edit: edit[:2], reverse=True):
        lines[start:stop] = new_lines
    text = ("\r\n" if "\r\n" in entry.source.text else "\n").join(lines)
    expected = parse_yaml(entry.source)
    collision = expected["links"][entry.link]["collision"][entry.index]
    collision["height_map"].update(values, heights=[list(row) for row in new.heights])
    collision["source"] = {"status": status, "note": note}
    try:
        is_right = parse_yaml(Source(entry.source.path, text)) == expected
    except LoadError:
        is_right = False
    if not is_right:
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
