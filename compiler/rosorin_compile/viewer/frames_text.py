"""The tree of frames as text, with the publisher of each edge in columns next to it."""

from __future__ import annotations

import unicodedata
from collections.abc import Mapping, Sequence
from typing import NamedTuple

from rosorin_compile.model.frame_tree import Line, Row

_HEADS = ("frame", "published by", "topic", "joint", "")
_FLAT_HEADS = ("from", "to", "published by", "topic", "joint", "")
_OPTIONAL = ("joint", "topic")  # columns that are left out in this order if a terminal is too narrow
_BOLD, _DIM, _PLAIN = "\033[1m", "\033[2m", "\033[0m"
# Colours of a terminal: blue, yellow, green, magenta, cyan, red, then the bright ones.
_COLOURS = ("34", "33", "32", "35", "36", "31", "94", "93", "92", "95", "96", "91")
_GAP = "  "


class Look(NamedTuple):
    """How to draw: in ASCII or with lines, the publishers in colours (none: no colours), the width (0: any)."""

    ascii: bool = False
    publishers: Sequence[str] = ()
    width: int = 0

    def paint(self, text: str, code: str) -> str:
        """Return a text in a colour, if there are colours."""
        return f"{code}{text}{_PLAIN}" if self.publishers and text else text

    def colour(self, row: Row | None) -> str:
        """Return the colour of an edge; a root is bold."""
        if row is None or not row.published:
            return _BOLD if row is None else _DIM
        at = self.publishers.index(row.publisher) if row.publisher in self.publishers else 0
        return f"\033[{_COLOURS[at % len(_COLOURS)]}m"


def tree(lines: Sequence[Line], look: Look) -> list[str]:
    """Return a tree as lines of text."""
    before: list[str] = []  # the start of lines below each line
    cells = []
    for line in lines:
        start, below = "", ""
        if line.on >= 0:
            dashed = line.row is not None and not line.row.published
            branch = (".. " if dashed else "-- ") if look.ascii else ("╌╌ " if dashed else "── ")
            corner = ("`" if line.last else "|") if look.ascii else ("└" if line.last else "├")
            start = before[line.on] + corner + branch
            below = before[line.on] + ("    " if line.last else "|   " if look.ascii else "│   ")
        before.append(below)
        cells.append(((f"{start}{line.frame}{' (above)' if line.up else ''}",), line.row, len(start)))
    return _columns(_HEADS, cells, look)


def table(rows: Sequence[Row], look: Look) -> list[str]:
    """Return edges as lines of text, without the tree."""
    return _columns(_FLAT_HEADS, [((row.parent, row.child), row, 0) for row in rows], look)


def heading(text: str, look: Look) -> str:
    """Return a heading."""
    return look.paint(text, _BOLD)


def _columns(heads: Sequence[str], entries: Sequence[tuple[tuple[str, ...], Row | None, int]], look: Look) -> list[str]:
    """Return columns under their heads; an entry has its first cells, its edge, and the width of its indentation."""
    whys = dict.fromkeys(row.why for _, row, _ in entries if row is not None and row.why)
    numbers = {why: at for at, why in enumerate(whys, 1)}
    cells = [(*first, *_cells(row, numbers)) for first, row, _ in entries]
    widths = {head: max(map(text_width, texts)) for head, *texts in zip(heads, heads, *cells, strict=True)}
    left_out = []
    for head in _OPTIONAL:
        used = [width for width in widths.values() if width]
        if 0 < look.width < sum(used) + len(_GAP) * (len(used) - 1):
            left_out.append(head)
            del widths[head]
    lines = []
    for texts, row, indent in ((heads, None, 0), *((c, row, i) for c, (_, row, i) in zip(cells, entries, strict=True))):
        shown = [(text, widths[head]) for head, text in zip(heads, texts, strict=True) if head in widths]
        text = _GAP.join(text + " " * (width - text_width(text)) for text, width in shown).rstrip()
        lines.append(text[:indent] + look.paint(text[indent:], look.colour(row) if lines else _DIM))
    lines += [look.paint(f"(no room for: {', '.join(left_out)})", _DIM)] if left_out else []
    return lines + [look.paint(f"({at}) {why}", _DIM) for why, at in numbers.items()]


def _cells(row: Row | None, numbers: Mapping[str, int]) -> tuple[str, ...]:
    """Return publisher, topic, joint and condition of an edge."""
    if row is None:
        return ("", "", "", "")
    who = f"{row.publisher} ({numbers[row.why]})" if row.why else row.publisher
    joint = f"{row.joint} ({row.kind})" if row.joint else ""
    return who, row.topic if row.published else "-", joint, f"when {row.when}" if row.when else ""


def text_width(text: str) -> int:
    """Return the columns that a text takes in a terminal."""
    if text.isascii():
        return len(text)
    shown = [letter for letter in text if unicodedata.category(letter) not in ("Mn", "Me", "Cf")]
    return sum(2 if unicodedata.east_asian_width(letter) in ("W", "F") else 1 for letter in shown)
