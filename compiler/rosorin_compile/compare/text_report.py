"""Report how files differ: as unified diffs, by the values in them that no leaf is about, as lines and as tables."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
from difflib import unified_diff
from typing import Any, NamedTuple

from rosorin_compile.source.bounded import json_of
from rosorin_compile.source.numbers import exact
from rosorin_compile.source.wording import and_more, counted, printable

from .change import Change
from .elements import values_of

CHANGED, MISSING, EXTRA, NOT_TEXT = "changed", "missing", "extra", "not-text"
MAX_LINES = 40
MAX_WIDTH = 160
_MAX_CHANGES = 100
# Above this number of lines, comparing line by line takes too long.
_MAX_COMPARED = 20_000
_NO_END = "\\ No newline at end of file"
_IF_MEANT = "if this is what you meant, run rosorin-compile all and commit what it writes"
_HEAD = ("what", "quantity", "before", "after", "by", "artifacts")
_MOST_NAMES = 12  # in one cell
_MOST_VALUES = 3
_LARGEST = 200_000  # letters of a text whose values are looked at
_CUT = 60
_WORD = re.compile(r"[A-Za-z_]\w+")


class Code(str):
    """A name or a number, to be set as code."""

    __slots__ = ()


Cell = tuple[str, ...]  # texts, those that are Code as code


class Table(NamedTuple):
    """Rows under a head; ``noun`` is what one row is."""

    noun: str
    head: tuple[str, ...]
    rows: tuple[tuple[Cell, ...], ...]


class Diff(NamedTuple):
    """A unified diff of a file, folded: its name, a remark, its lines, and how many lines are already left out."""

    name: str
    remark: str
    lines: tuple[str, ...]
    left: int = 0


Block = Table | Diff


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

    def shortened(self) -> list[str]:
        """Return the first lines of the diff, as ``narrowed``, and how many there are more."""
        return shorten(self.lines)


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


def narrowed(lines: Sequence[str], most: int) -> list[str]:
    """Return the first lines of a diff, long ones cut around the place where they begin to differ."""
    shown = list(lines[:most])
    for index, line in enumerate(shown):
        if len(line) > MAX_WIDTH:
            first = max(1, _beginning(lines, index) - MAX_WIDTH // 3)
            left, right = "" if first == 1 else "...", "..." if first + MAX_WIDTH < len(line) else ""
            shown[index] = f"{line[:1]}{left}{line[first : first + MAX_WIDTH]}{right}"
    return shown


def shorten(lines: Sequence[str]) -> list[str]:
    """Return the first lines of a diff, as ``narrowed``, and how many there are more."""
    shown = narrowed(lines, MAX_LINES)
    if len(lines) > MAX_LINES:
        shown.append(f"... {len(lines) - MAX_LINES} more lines (--full shows them)")
    return shown


def _beginning(lines: Sequence[str], index: int) -> int:
    """Return where a line of a diff begins to differ from the line that takes its place; 0 if none does."""
    signs = "".join(line[:1] or " " for line in lines)
    before = max(signs.rfind(sign, 0, index) for sign in " @")
    block = re.compile(r"(-+)(\++)").search(signs, before + 1)
    if lines[index][:1] not in ("-", "+") or block is None or not block.start() <= index < block.end():
        return 0
    removed, added = block.start(1), block.start(2)
    twin = added + index - removed if index < added else removed + index - added
    if not block.start() <= twin < block.end() or (twin < added) == (index < added):
        return 0
    pairs = zip(lines[index][1:], lines[twin][1:], strict=False)
    return next((at for at, (a, b) in enumerate(pairs, 1) if a != b), 0)


def differing_values(old: str, new: str) -> str:
    """Return the first values of two texts that differ, in words; empty if none does, or they cannot be compared."""
    if max(len(old), len(new)) > _LARGEST:
        return ""
    try:
        before, after = dict(_values(old)), dict(_values(new))
    except ValueError:
        return ""
    if old[:1] not in ("<", "{", "[") and len(before) != len(after):
        return ""
    places = [place for place in {**before, **after} if before.get(place) != after.get(place)]
    within = " ".join(places)
    places = [place for place in places if (before.get(place) or after.get(place)) or f"{place} " not in within]
    found = [_value_change(place, before.get(place), after.get(place)) for place in places[:_MOST_VALUES]]
    if len(places) > _MOST_VALUES:
        found.append(f"and {len(places) - _MOST_VALUES} more")
    return ", ".join(found)


def _value_change(place: str, old: Any, new: Any) -> str:
    if old is None or new is None:
        return f"{printable(place)}: {'new' if old is None else 'removed'}"
    old, new = (exact(value) if isinstance(value, float) else str(value) for value in (old, new))
    if place.startswith("line "):
        place += f" {next(iter(_WORD.findall(new)), '')}".rstrip()
        before, after = old.split(), new.split()
        for at in (0, -1):  # what both begin and end with
            while before and after and before[at] == after[at]:
                del before[at], after[at]
        old, new = " ".join(before), " ".join(after)
    return f"{printable(place)} {printable(old)[:_CUT]} -> {printable(new)[:_CUT]}"


def _values(text: str) -> Iterator[tuple[str, Any]]:
    """Yield the values of a text with their places. Raises ValueError if it is damaged."""
    if text.startswith("<"):
        yield from values_of(text)
    elif text.startswith(("{", "[")):
        times: Counter[str] = Counter()
        for place, value in _of_json(json_of(text), ()):
            times[place] += 1
            yield place if times[place] == 1 else f"{place} ({times[place]})", value
    else:
        yield from ((f"line {number}", line) for number, line in enumerate(text.splitlines(), 1))


def _of_json(value: Any, above: Sequence[str]) -> Iterator[tuple[str, str]]:
    if isinstance(value, dict):
        for key, inner in value.items():
            yield from _of_json(inner, (*above, key)[-3:])
    elif isinstance(value, list):
        for number, inner in enumerate(value, 1):
            yield from _of_json(inner, (*above[-2:], str(number)))
    else:
        yield " ".join(above), str(value)


def report_lines(changes: Sequence[Change], texts: Sequence[TextDifference], full: bool = False) -> list[str]:
    """Return differences as lines of plain text: changes of meaning, remarks and what to do, then the text diffs.

    Diffs are shortened unless ``full``.
    """
    lines = [change.line() for change in changes]
    if not full and len(lines) > _MAX_CHANGES:
        lines[_MAX_CHANGES:] = [f"... {counted(len(lines) - _MAX_CHANGES, 'more difference')} (--full shows them)"]
    lines += [f"{printable(text.file)}: {text.remark}" for text in texts if text.remark]
    for text in texts:
        if text.lines and (full or text.shown):
            lines += ["", *(text.lines if full else shorten(text.lines))]
    return [*lines, "", _IF_MEANT] if any(text.kind == CHANGED for text in texts) else lines


def blocks(
    changes: Sequence[Change], texts: Sequence[TextDifference], others: Sequence[tuple[str, str]] = ()
) -> list[Block]:
    """Return changes and differences of text as tables; ``others`` are further files, each with a remark."""
    found: list[Block] = []
    if changes:
        found.append(Table("change", _HEAD, tuple(map(_row, changes))))
    diffs = [text for text in texts if text.kind == CHANGED and text.shown and text.lines]
    explained = any(change.artifacts for change in changes)
    # Where the changes say it, a file whose text is not shown needs no remark.
    files = [(text.file, text.remark or ("" if explained else "different text")) for text in texts if text not in diffs]
    rows = [((Code(name),), (remark,)) for name, remark in [*files, *others] if remark]
    if rows:
        found.append(Table("file", ("file", "what is wrong"), tuple(rows)))
    for text in diffs:
        shown = tuple(narrowed(text.lines, MAX_LINES))
        found.append(Diff(text.file, text.remark, shown, len(text.lines) - len(shown)))
    return found


def _row(change: Change) -> tuple[Cell, ...]:
    row = change.row
    what = [Code(row.what), *((" in ", Code(row.where)) if row.where else ())]
    if change.therefore:
        what += ["\nand therefore the shapes of ", *_names(change.therefore)]
    return (tuple(what), (row.quantity,), (row.before,), (row.after,), (row.by,), tuple(_names(change.artifacts)))


def _names(names: Sequence[str]) -> Iterable[str]:
    """Yield names as code, commas between them; of many the first ones and the number of the others."""
    for at, name in enumerate(names[:_MOST_NAMES]):
        yield from ([", "] if at else [])
        yield Code(name)
    yield and_more(len(names) - _MOST_NAMES)
