"""Differences of text: unified diffs, and whether two texts differ in white space, comments and spelling alone."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, NamedTuple

from ..wording import printable

if TYPE_CHECKING:
    from ..emit import Format

CHANGED, MISSING, EXTRA, NOT_TEXT = "changed", "missing", "extra", "not-text"
MAX_LINES = 40
MAX_WIDTH = 160
# Above this number of lines, comparing line by line takes too long.
_MAX_COMPARED = 20_000
_NO_END = "\\ No newline at end of file"


class TextDifference(NamedTuple):
    """How the text of a file differs: its kind, a remark, and for a changed file the lines of a unified diff."""

    file: str
    kind: str
    remark: str = ""
    lines: tuple[str, ...] = ()


def unified(file: str, old: str, new: str) -> tuple[str, ...]:
    """Return the unified diff from a committed to a compiled text, without line ends, control characters visible."""
    from difflib import unified_diff

    before, after = old.splitlines(keepends=True), new.splitlines(keepends=True)
    if max(len(before), len(after)) > _MAX_COMPARED:
        return (f"{len(before)} lines committed, {len(after)} lines compiled: too many to show how they differ",)
    shown: list[str] = []
    for line in unified_diff(before, after, f"committed/{file}", f"compiled/{file}"):
        shown.append(printable(line.removesuffix("\n"), keep="\t"))
        if not line.endswith("\n"):
            shown.append(_NO_END)
    return tuple(shown)


def shorten(lines: Sequence[str]) -> list[str]:
    """Return the first lines of a diff, long ones cut around the place where they begin to differ."""
    shown = list(lines[:MAX_LINES])
    for index, line in enumerate(shown):
        if len(line) > MAX_WIDTH:
            shown[index] = _cut(line, _beginning(lines, index))
    if len(lines) > MAX_LINES:
        shown.append(f"... {len(lines) - MAX_LINES} more lines (--full shows them)")
    return shown


def _beginning(lines: Sequence[str], index: int) -> int:
    """Return where a line of a diff begins to differ from the line that takes its place; 0 if none does."""
    sign = lines[index][:1]
    if sign not in ("-", "+"):
        return 0
    start = index
    while start and lines[start - 1][:1] == sign:
        start -= 1
    if sign == "-":
        place = index
        while place < len(lines) and lines[place][:1] == "-":
            place += 1
    else:
        place = start
        while place and lines[place - 1][:1] == "-":
            place -= 1
    place += index - start
    twin = lines[place] if place < len(lines) and place != index else ""
    if twin[:1] not in ("-", "+") or twin[:1] == sign:
        return 0
    return next((at for at, (a, b) in enumerate(zip(lines[index][1:], twin[1:], strict=False), 1) if a != b), 0)


def _cut(line: str, place: int) -> str:
    first = max(1, place - MAX_WIDTH // 3)
    left = "" if first == 1 else "..."
    right = "..." if first + MAX_WIDTH < len(line) else ""
    return f"{line[:1]}{left}{line[first : first + MAX_WIDTH]}{right}"


def same_syntax(format: Format, old: str, new: str) -> bool:
    """Say whether two texts of a format differ in white space, comments and the spelling of numbers alone."""
    if format.syntax is None:
        return False
    try:
        return bool(format.syntax(old) == format.syntax(new))
    except (ValueError, SyntaxError):
        return False
