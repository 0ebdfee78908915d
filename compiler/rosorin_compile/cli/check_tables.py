"""Changes of artifacts as tables of Markdown: what changed by meaning, and how texts differ."""

from __future__ import annotations

from collections.abc import Sequence

from rosorin_compile.cli.markdown import Block, Cell, Code, Diff, Table
from rosorin_compile.compare.changes import Change
from rosorin_compile.output.committed import CHANGED, MAX_LINES, TextDifference, shorten
from rosorin_compile.source.wording import and_more

_MOST_NAMES = 12  # in one cell


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
