"""Sections of plain values: what differs is told of the entry, from its values and the schema alone."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import pytest

from rosorin_compile.frontend.annotations import ENTRIES, ITEMS, Node
from rosorin_compile.meaning import plainly
from rosorin_compile.meaning.plainly import compare_plainly


@dataclass(frozen=True)
class Cell:
    """An entry that has its key as its name."""

    name: str
    voltage: float
    link: str = ""
    source: str = ""


SECTIONS = {
    "battery": Node(merge=ENTRIES, compared="battery"),
    "charger": Node(compared="charger"),
    "fuses": Node(merge=ITEMS, compared="fuse"),
    "links": Node(merge=ENTRIES),
}


@pytest.fixture(autouse=True)
def _sections(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(plainly, "sections", lambda: SECTIONS)


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ({}, {}, []),
        (
            {"battery": {"main": {"voltage": 12, "at": {"link": "a"}}}},
            {"battery": {"main": {"voltage": 24, "at": {"link": "b"}}}},
            ["battery main: voltage 12 -> 24", "battery main: at link a -> b"],
        ),
        (
            {"battery": (Cell("main", 12.0, source="a"), Cell("spare", 12))},
            {"battery": (Cell("other", 12), Cell("main", 12.000001, source="b"))},
            ["removed: battery spare", "new: battery other", "battery main: voltage 12 -> 12.000001"],
        ),
        ({"battery": {"main": {"voltage": 1}}}, {"battery": {"main": {"voltage": 1 + 1e-15}}}, []),
        ({"battery": {"main": {}}}, {"battery": {"main": {"fused": True}}}, ["battery main: fused none -> true"]),
        ({"charger": {"voltage": 12}}, {"charger": {"voltage": 5}}, ["charger: voltage 12 -> 5"]),
        ({"charger": {"voltage": 12}}, {"charger": None}, ["removed: charger"]),
        ({}, {"charger": {"voltage": 12}}, ["new: charger"]),
        ({"fuses": [{"amps": 5}]}, {"fuses": [{"amps": 6}, {"amps": 5}]}, ["new: fuse 2", "fuse 1: amps 5 -> 6"]),
        ({"links": {"a": 1}}, {"links": {"a": 2}}, []),
    ],
)
def test_what_differs_is_told_of_the_entry(old: dict[str, Any], new: dict[str, Any], said: list[str]) -> None:
    assert [item.text for item in compare_plainly(old, new)] == said


def test_what_is_new_or_gone_has_a_name() -> None:
    found = [*compare_plainly({"battery": {"main": {}}}, {}), *compare_plainly({}, {"charger": {}})]
    assert [(one.name, one.quantity, one.before, one.after) for one in found] == [
        ("main", "battery", "main", None),
        ("charger", "charger", None, "charger"),
    ]
