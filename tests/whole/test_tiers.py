"""A landing tries the cases that a test names for it; the others, and what is marked, belong to a tier."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import pytest

from support.tiers import hold_landings, tiers_of


def case(id: str, **marks: tuple[str, ...]) -> Any:
    """Return a case of a test with marks, as pytest collects it."""
    return SimpleNamespace(
        nodeid=f"test_it.py::test_it[{id}]",
        callspec=SimpleNamespace(id=id),
        iter_markers=lambda name: [SimpleNamespace(args=args) for mark, args in marks.items() if mark == name],
    )


@pytest.mark.parametrize(
    ("id", "marks", "tiers"),
    [
        ("a", {}, [None]),
        ("a", {"tier": ("kills",)}, ["kills"]),
        ("a", {"landing": ("fuzz", "a", "b")}, [None]),
        ("c", {"landing": ("fuzz", "a", "b")}, ["fuzz"]),
        ("py-given0", {"landing": ("outside", "py")}, [None]),
        ("xml-given0", {"landing": ("outside", "py")}, ["outside"]),
        ("a", {"landing": ("fuzz", "a"), "tier": ("kills",)}, ["kills"]),
    ],
)
def test_where_a_case_belongs(id: str, marks: dict[str, tuple[str, ...]], tiers: list[str | None]) -> None:
    assert tiers_of(case(id, **marks)) == tiers


def test_a_case_that_is_not_there_is_told() -> None:
    landing = ("fuzz", "a", "d")
    hold_landings([case("a", landing=landing)])  # asked for by its name
    with pytest.raises(pytest.UsageError, match="has no case d, which a landing is to try"):
        hold_landings([case(id, landing=landing) for id in ("a", "b", "c")])
