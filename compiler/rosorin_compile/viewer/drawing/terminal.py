"""Terminal: the tree of frames as lines of text, with who publishes each edge in columns beside it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import NamedTuple

from rosorin_compile.model.frame_tree import Line, Row

from .letters import cells

HEADS = ("frame", "published by", "topic", "joint", "")
FLAT_HEADS = ("from", "to", "published by", "topic", "joint", "")

_BOLD, _DIM, _PLAIN = "\033[1m", "\033[2m", "\033[0m"
# Colours of a terminal: blue, yellow, green, magenta, cyan, red, then the bright ones.
_COLOURS = ("34", "33", "32", "35", "36", "31", "94", "93", "92", "95", "96", "91")
_GAP = "  "
# What is left out where a terminal is too narrow, in this order: the rest tells it, or the description does.
_LEAST = ("joint", "topic")


class Look(NamedTuple):
    """How to draw: with lines or in ASCII, the colour of each publisher (none: no colours), how wide (0: any width)."""

    ascii: bool
    colour: Mapping[str, str]
    width: int = 0

    def paint(self, text: str, code: str) -> str:
        """Return a text in a colour, if there are colours."""
        return f"{code}{text}{_PLAIN}" if self.colour and text and code else text

    def of(self, row: Row | None) -> str:
        """Return the colour of an edge."""
        if row is None:
            return _BOLD
        return self.colour.get(row.publisher, "") if row.published else _DIM


class _Drawn(NamedTuple):
    """A line of text: its cells, and the edge that gives it its colour."""

    cells: tuple[str, ...]
    row: Row | None
    indent: int = 0


def look(ascii: bool, coloured: bool, publishers: Sequence[str], width: int = 0) -> Look:  # noqa: A002
    """Return how to draw; ``publishers`` get their colours in this order; ``width`` 0 means any."""
    codes = {name: f"\033[{_COLOURS[at % len(_COLOURS)]}m" for at, name in enumerate(publishers)}
    return Look(ascii, {**codes, "": _DIM} if coloured else {}, width)


def tree(lines: Sequence[Line], look: Look) -> list[str]:
    """Return lines of a tree as text."""
    reasons = _reasons([line.row for line in lines if line.row is not None])
    drawn = []
    for line, indent in zip(lines, _indents(lines, look.ascii), strict=True):
        name = f"{indent}{line.frame}{' (above)' if line.up else ''}"
        drawn.append(_Drawn((name, *_beside(line.row, reasons)), line.row, len(indent)))
    return [*_columns(HEADS, drawn, look), *_notes(reasons, look)]


def table(rows: Sequence[Row], look: Look) -> list[str]:
    """Return edges as text, without the tree."""
    reasons = _reasons(rows)
    drawn = [_Drawn((row.parent, row.child, *_beside(row, reasons)), row) for row in rows]
    return [*_columns(FLAT_HEADS, drawn, look), *_notes(reasons, look)]


def heading(text: str, look: Look) -> str:
    """Return a heading."""
    return look.paint(text, _BOLD)


def _reasons(rows: Sequence[Row]) -> dict[str, int]:
    """Return the reasons why nobody publishes an edge, numbered."""
    return {why: at for at, why in enumerate(dict.fromkeys(row.why for row in rows if row.why), 1)}


def _notes(reasons: Mapping[str, int], look: Look) -> list[str]:
    return [look.paint(f"({at}) {why}", _DIM) for why, at in reasons.items()]


def _beside(row: Row | None, reasons: Mapping[str, int]) -> tuple[str, ...]:
    """Return publisher, topic, joint, and when an edge is published."""
    if row is None:
        return ("", "", "", "")
    who = f"{row.publisher} ({reasons[row.why]})" if row.why else row.publisher
    joint = f"{row.joint} ({row.kind})" if row.joint else ""
    return who, row.topic if row.published else "-", joint, f"when {row.when}" if row.when else ""


def _indents(lines: Sequence[Line], ascii: bool) -> list[str]:  # noqa: A002
    """Return what stands before each frame."""
    drawn: list[str] = []
    before: list[str] = []  # what lines that hang on a line begin with
    for line in lines:
        if line.on < 0:
            drawn.append("")
            before.append("")
            continue
        dashed = line.row is not None and not line.row.published
        branch = (".. " if dashed else "-- ") if ascii else ("╌╌ " if dashed else "── ")
        corner = ("`" if line.last else "|") if ascii else ("└" if line.last else "├")
        drawn.append(before[line.on] + corner + branch)
        before.append(before[line.on] + ("    " if line.last else "|   " if ascii else "│   "))
    return drawn


def _columns(heads: Sequence[str], drawn: Sequence[_Drawn], look: Look) -> list[str]:
    """Return cells below each other under their heads."""
    every = [heads, *(line.cells for line in drawn)]
    widths = {head: max(map(cells, column)) for head, *column in zip(heads, *every, strict=True)}
    left_out: list[str] = []
    for head in _LEAST:
        if 0 < look.width < _room(widths):
            left_out.append(head)
            del widths[head]
    lines = [look.paint(_join(heads, heads, widths), _DIM)]
    for line in drawn:
        text, first = _join(heads, line.cells, widths), line.indent
        lines.append(text[:first] + look.paint(text[first:], look.of(line.row)))
    return lines + [look.paint(f"(no room for: {', '.join(left_out)})", _DIM)] * bool(left_out)


def _room(widths: Mapping[str, int]) -> int:
    """Return how wide the widest line is; a column in which nothing stands takes no room."""
    used = [width for width in widths.values() if width]
    return sum(used) + len(_GAP) * (len(used) - 1)


def _join(heads: Sequence[str], texts: Sequence[str], widths: Mapping[str, int]) -> str:
    """Return the texts of a line below each other's heads, those that have a width."""
    shown = [(text, widths[head]) for head, text in zip(heads, texts, strict=True) if head in widths]
    padded = [text + " " * (width - cells(text)) for text, width in shown]
    return _GAP.join(padded).rstrip()
