"""The numbers of a fleet as a table with histograms: in a terminal, in Markdown, and for the page."""

from __future__ import annotations

import math
import shutil
import sys
from collections.abc import Sequence
from typing import Any

from rosorin_compile.diagnostics import Console, counted, first_of, printable

from .answers import FleetNumber
from .columns import ARGUMENT, Columns
from .judging import Row

MOST_ROWS = 30
_BLOCKS = " ▁▂▃▄▅▆▇█"
_LETTERS = " .:-=+*#@"  # where a terminal has no blocks
_BINS = 16
_WIDTH = 100  # of what is no terminal
_LEAST = 8  # columns of a histogram
_HEADS = ("number", "robots", "smallest", "median", "largest")
_NAMED = 3
_GAP = 2


def histogram(row: Row, count: int = _BINS) -> tuple[list[int], int, int]:
    """Return how many robots lie in each of ``count`` equal steps from the smallest to the largest of the usual ones.

    Beside them, how many are far below and far above.
    """
    low, high = row.spread.usual
    far = {far.place for far in row.spread.far}
    bins = [0] * count
    below = above = 0
    for at, value in enumerate(row.lined_up()):
        if not math.isfinite(value):
            continue
        if at in far:
            below, above = below + (value < low), above + (value > high)
            continue
        place = int((value - low) / (high - low) * count) if high > low else count // 2
        bins[min(max(place, 0), count - 1)] += 1
    return bins, below, above


def bar(row: Row, width: int, letters: str = _BLOCKS) -> str:
    """Return a histogram as a line of text; robots that are far stand as a number before or behind it."""
    wide = max(1, width // min(width, _bins(row)))  # of few robots each step is some letters wide
    bins, below, above = histogram(row, width // wide)
    most = max(bins)
    steps = len(letters) - 1
    line = "".join((letters[math.ceil(count / most * steps)] if count else letters[0]) * wide for count in bins)
    return f"{f'{below}<' if below else '  '}{line}{f'>{above}' if above else '  '}"


def _bins(row: Row) -> int:
    """Return how many steps a histogram of so many robots has at most."""
    return max(5, math.ceil(2 * math.sqrt(row.spread.robots)))


def table(rows: Sequence[Row], full: bool) -> list[str]:
    """Return the numbers that differ as lines for a terminal, as wide as it is."""
    shown = rows if full else rows[:MOST_ROWS]
    width = shutil.get_terminal_size((_WIDTH, 24)).columns if sys.stdout.isatty() else _WIDTH
    letters = _BLOCKS if _can_print(_BLOCKS) else _LETTERS
    cells = [_HEADS, *(_cells(row) for row in shown)]
    widths = [max(len(line[at]) for line in cells) for at in range(len(_HEADS))]
    rest = width - sum(widths) - _GAP * len(widths)
    if rest < _LEAST + 4:  # the names give way
        widths[0] = max(12, widths[0] - (_LEAST + 4 - rest))
        rest = width - sum(widths) - _GAP * len(widths)
    room = min(rest - 4, 32)
    lines = []
    for at, line in enumerate(cells):
        texts = [_cut(line[0], widths[0]).ljust(widths[0])]
        texts += [text.rjust(size) for text, size in zip(line[1:], widths[1:], strict=True)]
        drawn = bar(shown[at - 1], room, letters) if at and room >= _LEAST else ""
        lines.append((" " * _GAP).join([*texts, drawn]).rstrip())
        if at and shown[at - 1].follow:
            lines.append(_cut(f"  {_follow(shown[at - 1])}", width))
    if len(rows) > len(shown):
        lines.append(f"and {counted(len(rows) - len(shown), 'more number')}; --full lists all")
    return lines


def _cells(row: Row) -> tuple[str, ...]:
    spread = row.spread
    unit = f", {row.said_in}" if row.said_in else ""
    numbers = (row.bare(value) for value in (spread.smallest, spread.median, spread.largest))
    return (f"{printable(row.label)}{unit}", f"{spread.robots:,}", *numbers)


def _follow(row: Row) -> str:
    names = [str(column.fact.about) for column in row.follow]
    word = "gives" if row.is_argument else "and with it"
    return f"{word} {first_of(names, _NAMED)}"


def _cut(text: str, width: int) -> str:
    return text if len(text) <= width else f"{text[: max(width - 3, 1)]}..."


def _can_print(letters: str) -> bool:
    try:
        letters.encode(sys.stdout.encoding or "utf-8")
    except (UnicodeEncodeError, LookupError):
        return False
    return True


def texts_of(columns: Columns, full: bool) -> list[str]:
    """Return what else differs: texts, each with how many robots have it, and artifacts that no format reads."""
    lines: list[str] = []
    lacking: dict[str, int] = {}
    total = len(columns.robots)
    for fact, found in columns.texts.items():
        counts = {text: said.count for text, said in found.items()}
        if set(counts) == {""}:
            lacking[fact.name] = max(total - counts[""], lacking.get(fact.name, 0))
            continue
        usual = columns.usual_texts.get(fact)
        if usual is not None:
            counts[usual] = counts.get(usual, 0) + total - sum(counts.values())
        if len(counts) < 2 or (fact.kind == ARGUMENT and len(counts) > max(2, min(_BINS, total // 2))):
            continue  # a name, a serial number
        often = sorted(counts, key=lambda text: (-counts[text], text))
        said = first_of([f"{printable(text) or 'none'} ({counts[text]:,})" for text in often], _NAMED)
        name = fact.name if fact.kind == ARGUMENT else str(fact.about)
        lines.append(f"{printable(name)}: {said}")
    if lacking:
        names = [f"{printable(name)} ({count:,})" for name, count in sorted(lacking.items())]
        lines.append(f"not in all robots: {first_of(names, 12)}")
    more = len(lines) - MOST_ROWS
    if more > 0 and not full:
        lines = [*lines[:MOST_ROWS], f"and {counted(more, 'more text')}; --full lists all"]
    for name, sums in sorted(columns.plain.items()):
        if len(sums) > 1:
            lines.append(f"{printable(name)}: {counted(len(sums), 'text')}, compared as a whole")
    return lines


def add_table(rows: Sequence[Row], console: Console) -> None:
    """Add the numbers that differ to what is said in Markdown, as a table."""
    lines = [(*_cells(row), bar(row, _BINS).strip()) for row in rows]
    console.add_table("number", (*_HEADS, "histogram"), lines, code=(0, len(_HEADS)))


def told_of(row: Row) -> FleetNumber:
    """Return a number that differs between robots in the form for programs (JSON)."""
    spread = row.spread
    return FleetNumber(
        row.label,
        row.is_argument,
        row.unit,
        spread.robots,
        spread.smallest,
        spread.median,
        spread.largest,
        spread.width,
        [str(column.fact.about) for column in row.follow],
    )


def page_rows(rows: Sequence[Row]) -> list[dict[str, Any]]:
    """Return the numbers that differ as the page draws them, their texts ready."""
    return [_page_row(row) for row in rows]


def _page_row(row: Row) -> dict[str, Any]:
    bins, below, above = histogram(row, min(2 * _BINS, _bins(row)))
    low, high = row.spread.usual
    made: dict[str, Any] = {
        "name": row.label,
        "robots": row.spread.robots,
        "smallest": row.shown(row.spread.smallest),
        "median": row.shown(row.spread.median),
        "largest": row.shown(row.spread.largest),
        "low": row.shown(low),
        "high": row.shown(high),
        "bins": bins,
        "below": below,
        "above": above,
    }
    if row.frame:
        made["frame"] = row.frame
    if row.follow:
        made["gives"] = first_of([str(column.fact.about) for column in row.follow], 12)
    return made
