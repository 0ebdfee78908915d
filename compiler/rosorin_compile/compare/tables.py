"""Tables: a comparison with what is committed or deployed, as the blocks of a document.

A change of meaning is a row: what, before, after, by how much, and which artifacts show it. Then come files
that are missing or too many, and differences of text.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from rosorin_compile.source.markdown import Block, Cell, Code, Diff, Table
from rosorin_compile.source.wording import and_more

from .committed import CHANGED, MAX_LINES, TextDifference, narrowed
from .entities import Change

_HEAD = ("what", "quantity", "before", "after", "by", "artifacts")
_MOST = 12  # names in one cell


def blocks(
    changes: Sequence[Change], texts: Sequence[TextDifference], others: Sequence[tuple[str, str]] = ()
) -> list[Block]:
    """Return changes and differences of text as blocks; ``others`` are further files, each with what is to say."""
    found: list[Block] = []
    if changes:
        found.append(Table("change", _HEAD, tuple(map(_row, changes))))
    diffs = [text for text in texts if text.kind == CHANGED and text.shown and text.lines]
    told = {name for change in changes for name in change.artifacts}
    files = [(text.file, _remark(text, bool(told))) for text in texts if text not in diffs]
    files = [(name, remark) for name, remark in [*files, *others] if remark]
    if files:
        rows = tuple(((Code(name),), (remark,)) for name, remark in files)
        found.append(Table("file", ("file", "what is wrong"), rows))
    return found + [_diff(text) for text in diffs]


def _diff(text: TextDifference) -> Diff:
    shown = tuple(narrowed(text.lines, MAX_LINES))
    return Diff(text.file, text.remark, shown, len(text.lines) - len(shown))


def _remark(text: TextDifference, told: bool) -> str:
    """Return what there is to say of a file whose text is not shown; nothing where the changes say it."""
    return text.remark or ("" if told else "different text")


def _row(change: Change) -> tuple[Cell, ...]:
    row = change.row
    what = [Code(row.what), *((" in ", Code(row.where)) if row.where else ())]
    if change.therefore:
        what += ["\nand therefore the shapes of ", *_names(change.therefore)]
    return (tuple(what), (row.quantity,), (row.before,), (row.after,), (row.by,), tuple(_names(change.artifacts)))


def _names(names: Sequence[str]) -> Iterable[str]:
    """Yield names as code, commas between them; of many the first ones and the number of the others."""
    for at, name in enumerate(names[:_MOST]):
        yield from ([", "] if at else [])
        yield Code(name)
    yield and_more(len(names) - _MOST)
