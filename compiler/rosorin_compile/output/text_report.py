"""Report how files differ: as unified diffs, by their first lines, as a list of lines."""

from __future__ import annotations

import re
from collections.abc import Sequence
from difflib import unified_diff
from typing import NamedTuple

from rosorin_compile.source.wording import counted, printable

CHANGED, MISSING, EXTRA, NOT_TEXT = "changed", "missing", "extra", "not-text"
MAX_LINES = 40
MAX_WIDTH = 160
_MAX_CHANGES = 100
# Above this number of lines, comparing line by line takes too long.
_MAX_COMPARED = 20_000
_NO_END = "\\ No newline at end of file"
_IF_MEANT = "if this is what you meant, run rosorin-compile all and commit what it writes"
_MOST_VALUES = 3
_CUT = 60
_TAG = re.compile(r"<([A-Za-z_]\w*)")
_WORD = re.compile(r"[A-Za-z_]\w+")


class TextDifference(NamedTuple):
    """How the text of a file differs: its kind, a remark, and for a changed file the lines of a unified diff.

    ``shown``: whether these say anything to a person; of a picture they do not.
    """

    file: str
    kind: str
    remark: str = ""
    lines: tuple[str, ...] = ()
    shown: bool = True

    @property
    def is_text(self) -> bool:
        """Whether the committed file is text at all."""
        return self.kind != NOT_TEXT


def unified(file: str, old: str, new: str) -> tuple[str, ...]:
    """Return the unified diff from a committed to a compiled text, without line ends, control characters visible."""
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
    """Return the first lines of a diff, long ones cut, and how many there are more."""
    shown = [line if len(line) <= MAX_WIDTH else f"{line[:MAX_WIDTH]}..." for line in lines[:MAX_LINES]]
    if len(lines) > MAX_LINES:
        shown.append(f"... {len(lines) - MAX_LINES} more lines (--full shows them)")
    return shown


def differing_values(old: str, new: str) -> str:
    """Return the first lines of two texts that differ, in words; empty if the texts are of different lengths."""
    before, after = old.splitlines(), new.splitlines()
    if len(before) != len(after):
        return ""
    pairs = enumerate(zip(before, after, strict=True), 1)
    found = [_line_change(number, *both) for number, both in pairs if both[0].split() != both[1].split()]
    more = [f"and {len(found) - _MOST_VALUES} more"] if len(found) > _MOST_VALUES else []
    return ", ".join([*found[:_MOST_VALUES], *more])


def _line_change(number: int, old: str, new: str) -> str:
    """Return what changed in a line: the words that differ, behind the element, the key or the first word."""
    before, after = old.split(), new.split()
    same: list[str] = []
    for at in (0, -1):  # what both begin and end with
        while before and after and before[at] == after[at]:
            same += after[:1] if at == 0 else []
            del before[at], after[at]
    tags = _TAG.findall(" ".join([*same, *after[:1]]))
    words = tags[-1:] or _WORD.findall(same[-1] if same and len(new) > MAX_WIDTH else new)
    texts = [printable(" ".join(some))[:_CUT] or "nothing" for some in (before, after)]
    return " ".join([f"line {number}", *words[:1]]) + f": {' -> '.join(texts)}"


def report_lines(changes: Sequence[str], texts: Sequence[TextDifference], full: bool = False) -> list[str]:
    """Return differences as lines of plain text: changes of meaning, remarks and what to do, then the text diffs.

    Diffs are shortened unless ``full``.
    """
    lines = [*changes]
    if not full and len(lines) > _MAX_CHANGES:
        lines[_MAX_CHANGES:] = [f"... {counted(len(lines) - _MAX_CHANGES, 'more difference')} (--full shows them)"]
    lines += [f"{printable(text.file)}: {text.remark}" for text in texts if text.remark]
    for text in texts:
        if text.lines and (full or text.shown):
            lines += ["", *(text.lines if full else shorten(text.lines))]
    return [*lines, "", _IF_MEANT] if any(text.kind == CHANGED for text in texts) else lines
