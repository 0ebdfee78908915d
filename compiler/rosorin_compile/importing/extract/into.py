"""Putting a height map in the place of one that a description has: only its values change, and who says them.

The text is edited where the values stand; comments and everything outside of that collision stay to the letter.
Afterwards the old and the new text are read again and compared: they differ in that collision and nowhere else.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import yaml

from rosorin_compile.model import HeightMap
from rosorin_compile.model.mesh_triangles import ExtractProblem
from rosorin_compile.source.diagnostics import Source
from rosorin_compile.source.load import LoadError, parse_yaml, read_utf8
from rosorin_compile.source.rule_registry import Heading, Rule
from rosorin_compile.source.tree import Map, Seq
from rosorin_compile.source.yaml_text import Scalar

from . import writing

RULES = (
    Rule(
        "extract-into",
        "There is no height map in that file to be replaced, or it cannot be edited safely.",
        "Name its link with `--frame`, or write a file with `-o`.",
        Heading.MESHES,
    ),
)


@dataclass(frozen=True)
class Block:
    """A collision with a height map in a file: the link, its index there, and the values as they are read."""

    link: str
    index: int
    entry: Map
    line: int

    @property
    def height_map(self) -> Map:
        """The value of ``height_map``."""
        entry: Map = self.entry["height_map"]
        return entry


@dataclass(frozen=True, order=True)
class Edit:
    """A piece of a text, from ``start`` to before ``end``, and what stands there instead."""

    start: int
    end: int
    text: str


def read(path: Path) -> Source:
    """Return the text of a description. Raises ExtractProblem."""
    try:
        return read_utf8(path, str(path))
    except LoadError as problem:
        raise _cannot(problem) from None


def find_block(source: Source, link: str | None) -> Block:
    """Return the height map of a link, or the only one in a file. Raises ExtractProblem."""
    try:
        tree = parse_yaml(source)
    except LoadError as problem:
        raise _cannot(problem) from None
    blocks = list(_blocks(tree))
    wanted = [block for block in blocks if link in (None, block.link)]
    if len(wanted) == 1:
        return wanted[0]
    there = ", ".join(block.link for block in blocks) or "none"
    what = f'of the link "{link}"' if link is not None else "that could be meant"
    count = "no height map" if not wanted else f"{len(wanted)} height maps"
    message = f"{source.path} has {count} {what} under links: (there: {there})"
    raise ExtractProblem.of("extract-into", message, "name its link: --frame LINK; or write a file: -o FILE")


def _blocks(tree: Any) -> Iterator[Block]:
    links = tree.get("links") if isinstance(tree, Map) else None
    for name, link in links.items() if isinstance(links, Map) else ():
        entries = link.get("collision") if isinstance(link, Map) else None
        for index, entry in enumerate(entries if isinstance(entries, Seq) else ()):
            if isinstance(entry, Map) and isinstance(entry.get("height_map"), Map):
                yield Block(name, index, entry, entry.key_spans["height_map"].line)


def grid_of(block: Block) -> tuple[float, tuple[float, float], tuple[int, int]]:
    """Return cell, origin and number of cells of a block. Raises ExtractProblem for what only expressions say."""
    there = block.height_map
    origin, rows = there.get("origin"), there.get("heights")
    numbers = [there.get("cell"), *(origin if isinstance(origin, Seq) else ())]
    known = len(numbers) == 3 and all(isinstance(value, int | float) for value in numbers)
    if not known or not isinstance(rows, Seq) or not all(isinstance(row, Seq) and row for row in rows) or not rows:
        message = f"the grid of the height map of {block.link} is not written in numbers"
        raise ExtractProblem.of("extract-into", message, "give --cell, --origin and --cells")
    cell, x, y = map(float, numbers)
    return cell, (x, y), (len(rows), len(rows[0]))


def replaced(source: Source, block: Block, made: HeightMap, status: str, note: str) -> str:
    """Return the text with a height map in the place of a block. Raises ExtractProblem if that is not safe."""
    loader = yaml.SafeLoader(source.text)
    try:
        top = loader.get_single_node()
    finally:
        loader.dispose()
    entry = _value(_value(_value(_value(top, "links"), block.link), "collision"), block.index)
    there = _value(entry, "height_map")
    edits = _values(source.text, there, block, made)
    edits.append(_source(source.text, entry, there, writing.source(status, note)))
    text = source.text
    for edit in sorted(edits, reverse=True):
        inside = _begin(entry) <= edit.start <= edit.end <= _end(entry, source.text)
        if not inside:
            raise _unsafe(source, block)
        text = text[: edit.start] + edit.text + text[edit.end :]
    _check(source, text, block, made, status)
    return text


def _values(text: str, there: yaml.CollectionNode, block: Block, made: HeightMap) -> list[Edit]:
    """Return the edits of the values of a height map; what is right already stays as it is written."""
    wanted: dict[str, tuple[Any, str]] = {
        "origin": (list(made.origin), writing.row(made.origin)),
        "cell": (made.cell, writing.length(made.cell)),
        "method": (made.method, Scalar(made.method).quoted()),
    }
    if made.step != block.height_map.get("step", made.cell):
        wanted["step"] = (made.step, writing.length(made.step))
    edits, missing = [], []
    for key, (value, written) in wanted.items():
        if key not in block.height_map:
            missing.append(f"{key}: {written}")
        elif block.height_map[key] != value:
            node = _value(there, key)
            edits.append(Edit(_begin(node), _end(node, text), written))
    rows = _value(there, "heights")
    edits.append(Edit(_begin(rows), _end(rows, text), _rows(rows, made)))
    if missing:
        edits.append(_insertion(there, missing))
    return edits


def _rows(node: yaml.CollectionNode, made: HeightMap) -> str:
    """Return all heights in the style of those that were there."""
    rows = writing.height_rows(made.heights)
    indent = "\n" + " " * node.start_mark.column
    if node.flow_style:
        return "[" + f",{indent} ".join(rows) + "]"
    return indent.join(f"- {row}" for row in rows)


def _insertion(there: yaml.CollectionNode, missing: list[str]) -> Edit:
    """Return the edit that puts keys at the beginning of a mapping."""
    first = _begin(there)
    if there.flow_style:
        return Edit(first + 1, first + 1, "".join(f"{line}, " for line in missing))
    indent = "\n" + " " * there.start_mark.column
    return Edit(first, first, "".join(f"{line}{indent}" for line in missing))


def _source(text: str, entry: yaml.CollectionNode, there: yaml.CollectionNode, written: str) -> Edit:
    """Return the edit that says who says so: in the place of ``source``, or behind the height map."""
    for key, value in entry.value:
        if key.value == "source":
            begin, end = _begin(value), _end(value, text)
            if value.flow_style or "\n" not in text[key.end_mark.index : begin]:
                return Edit(begin, end, written)
            indent = "\n" + " " * value.start_mark.column
            status, note = written[1:-1].split(", note: ", 1)
            return Edit(begin, end, f"{status}{indent}note: {note}")
    if entry.flow_style:
        return Edit(_end(there, text), _end(there, text), f", source: {written}")
    return Edit(_end(there, text), _end(there, text), f"\n{' ' * entry.start_mark.column}source: {written}")


def _value(node: Any, step: str | int) -> yaml.CollectionNode:
    """Return the node of a key or an index; one that is a scalar only has its place asked for."""
    child: yaml.CollectionNode
    child = node.value[step] if isinstance(step, int) else next(v for key, v in node.value if key.value == step)
    return child


def _begin(node: yaml.Node) -> int:
    return int(node.start_mark.index)


def _end(node: yaml.Node, text: str) -> int:
    """Return where the text of a node ends; that of a block ends with its last value, not with what follows it."""
    while isinstance(node, yaml.CollectionNode) and not node.flow_style and node.value:
        last = node.value[-1]
        node = last[1] if isinstance(last, tuple) else last
    begin, end = _begin(node), int(node.end_mark.index)
    return begin + len(text[begin:end].rstrip())  # a folded text takes the line end behind it


def _check(source: Source, text: str, block: Block, made: HeightMap, status: str) -> None:
    """Raise ExtractProblem unless a new text says what is wanted, and otherwise what the old one said."""
    try:
        old, new = parse_yaml(source), parse_yaml(Source(source.path, text))
        now = new["links"][block.link]["collision"][block.index]
        there = now["height_map"]
        right = (
            [list(row) for row in there["heights"]] == [list(row) for row in made.heights]
            and [*there["origin"], there["cell"]] == [*made.origin, made.cell]
            and now["source"]["status"] == status
        )
        for tree in (old, new):
            entry = tree["links"][block.link]["collision"][block.index]
            entry.pop("source", None)
            for key in ("heights", "origin", "cell", "method", "step"):
                entry["height_map"].pop(key, None)
    except (LoadError, KeyError, IndexError, TypeError):
        raise _unsafe(source, block) from None
    if not right or old != new:
        raise _unsafe(source, block)


def _unsafe(source: Source, block: Block) -> ExtractProblem:
    message = f"the height map of {block.link} in {source.path} is written in a way that cannot be edited safely"
    help = "write it without anchors and aliases; or write a file with -o FILE, and paste it"
    return ExtractProblem.of("extract-into", message, help, block.entry.key_spans["height_map"])


def _cannot(problem: LoadError) -> ExtractProblem:
    diagnostic = problem.diagnostic
    return ExtractProblem.of(diagnostic.rule, diagnostic.message, diagnostic.help, diagnostic.span)


def changes(block: Block, made: HeightMap, status: str) -> list[str]:
    """Return what a new height map changes, for people."""
    before = _as_map(block)
    lines = []
    if before is None or _grid(before) != _grid(made):
        lines.append(f"grid {_grid(before) if before else 'written in expressions'} -> {_grid(made)}")
    else:
        pairs = [
            (a, b) for old, new in zip(before.heights, made.heights, strict=True) for a, b in zip(old, new, strict=True)
        ]
        differ = [(a, b) for a, b in pairs if a != b]
        largest = max((abs(a - b) for a, b in differ), default=0.0)
        lines.append(f"cells changed: {len(differ)} of {len(pairs)}, by up to {largest * 1000:.1f} mm")
    if before is not None:
        lines.append(
            f"highest {_top(before):g} -> {_top(made):g} m, boxes {len(before.boxes())} -> {len(made.boxes())}"
        )
    there = block.entry.get("source")
    was = there.get("status", "not said") if isinstance(there, Map) else "not said"
    lines.append(f"source: {was} -> {status}" if was != status else f"source: {status}")
    return lines


def _as_map(block: Block) -> HeightMap | None:
    """Return the height map that a block says in numbers; None if it does not."""
    try:
        cell, origin, _ = grid_of(block)
        rows = tuple(tuple(map(float, row)) for row in block.height_map["heights"])
        step = float(block.height_map.get("step", cell))
    except (ExtractProblem, TypeError, ValueError):
        return None
    return HeightMap(origin, cell, rows, step) if len({len(row) for row in rows}) == 1 and step > 0 else None


def _grid(made: HeightMap) -> str:
    at = f"from {made.origin[0]:g}, {made.origin[1]:g}"
    return f"{len(made.heights)} x {len(made.heights[0])} cells of {made.cell * 1000:g} mm {at}"


def _top(made: HeightMap) -> float:
    return max(max(row) for row in made.heights)
