"""Report how files differ: as unified diffs, by the values in them that no leaf is about, as lines and as tables."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterator, Sequence
from difflib import unified_diff
from typing import Any, NamedTuple

from rosorin_compile.source.bounded import json_of
from rosorin_compile.source.markdown import Block, Cell, Code, Diff, Table
from rosorin_compile.source.numbers import exact
from rosorin_compile.source.wording import and_more, counted, printable
from rosorin_compile.source.xml.elements import values_of

from .changes import Change

CHANGED, MISSING, EXTRA, NOT_TEXT = "changed", "missing", "extra", "not-text"
MAX_LINES = 40
MAX_WIDTH = 160
_MAX_CHANGES = 100
# Above this number of lines, comparing line by line takes too long.
_MAX_COMPARED = 20_000
_NO_END = "\\ No newline at end of file"
_IF_MEANT = "if this is what you meant, run rosorin-compile all and commit what it writes"
_MOST_NAMES = 12  # in one cell
_MOST_VALUES = 3
_LARGEST = 200_000  # letters of a text whose values are looked at
_CUT = 60
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


def blocks(
    changes: Sequence[Change], texts: Sequence[TextDifference], others: Sequence[tuple[str, str]] = ()
) -> list[Block]:
    """Return changes and differences of text as tables; ``others`` are further files, each with a remark."""
    found: list[Block] = []
    if changes:
        rows = tuple(((change.words(),), _names(change.artifacts)) for change in changes)
        found.append(Table("change", ("change", "artifacts"), rows))
    diffs = [text for text in texts if text.kind == CHANGED and text.shown and text.lines]
    explained = any(change.artifacts for change in changes)
    # Where the changes say it, a file whose text is not shown needs no remark.
    files = [(text.file, text.remark or ("" if explained else "different text")) for text in texts if text not in diffs]
    remarks = [((Code(name),), (remark,)) for name, remark in [*files, *others] if remark]
    if remarks:
        found.append(Table("file", ("file", "what is wrong"), tuple(remarks)))
    for text in diffs:
        shown = shorten(text.lines)[:MAX_LINES]
        found.append(Diff(text.file, text.remark, tuple(shown), len(text.lines) - len(shown)))
    return found


def _names(names: Sequence[str]) -> Cell:
    """Return names as code, commas between them; of many the first ones and the number of the others."""
    shown = [part for name in names[:_MOST_NAMES] for part in (", ", Code(name))][1:]
    return (*shown, and_more(len(names) - _MOST_NAMES))
