"""Differences as blocks of a page: of a long text the first lines, and how many are left."""

from __future__ import annotations

import pytest

from rosorin_compile.compare.committed import CHANGED, MAX_LINES, TextDifference
from rosorin_compile.compare.tables import blocks
from rosorin_compile.source.markdown import Diff, Table


@pytest.mark.parametrize(("count", "left"), [(1, 0), (MAX_LINES, 0), (MAX_LINES + 1, 1), (MAX_LINES + 30, 30)])
def test_of_a_long_text_it_is_said_how_much_is_left(count: int, left: int) -> None:
    (diff,) = blocks([], [TextDifference("r.urdf", CHANGED, "", tuple(f"+{number}" for number in range(count)))])
    assert isinstance(diff, Diff)
    assert (len(diff.lines), diff.left) == (count - left, left)


def test_a_text_that_is_not_shown_has_its_remark() -> None:
    (table,) = blocks([], [TextDifference("r.png", CHANGED, "", ("+1",), shown=False)], [("more.txt", "is not there")])
    assert isinstance(table, Table)
    assert [row[1] for row in table.rows] == [("different text",), ("is not there",)]
