"""Sections of plain values: what differs is told of the entry, from its values and the schema alone."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import pytest

from rosorin_compile.compare import entities, not_compared, plainly
from rosorin_compile.compare.changes import changes
from rosorin_compile.compare.difference import YAML, Side
from rosorin_compile.compare.plainly import compare_plainly
from rosorin_compile.compare.view import View
from rosorin_compile.formats import FORMATS, Fact, Value
from rosorin_compile.language.annotations import ENTRIES, ITEMS, Node
from rosorin_compile.language.lower.records import plain
from rosorin_compile.model import Link, Robot
from rosorin_compile.model.sections import Sections
from rosorin_compile.source.units import Quantity


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
        ({"fuses": [{"amps": 5}]}, {"fuses": [{"amps": 6}, {"amps": 5}]}, ["new: fuse 1"]),
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


def said(**batteries: Mapping[str, float | str]) -> View:
    """Return what an artifact says that has a word for batteries."""
    plain = {
        Fact("battery", name, word): Value(value, "" if isinstance(value, str) else "V")
        for name, words in batteries.items()
        for word, value in words.items()
    }
    return View(plain, {}, {}, {}, frozenset())


@pytest.mark.parametrize(
    ("old", "new", "lines"),
    [
        ({"voltage": 12.0}, {"voltage": 24.0}, ["battery main voltage 12 -> 24 V (+100.0 %)"]),
        ({"link": "a"}, {"link": "b"}, ["battery main link a -> b"]),
        ({}, {"voltage": 12.0, "link": "a"}, ["new: battery main"]),
        ({"voltage": 12.0, "link": "a"}, {}, ["removed: battery main"]),
        ({"voltage": 12.0}, {"voltage": 12.0}, []),
    ],
)
def test_check_tells_it_of_the_entry_too(
    old: dict[str, float | str],
    new: dict[str, float | str],
    lines: list[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(entities, "sections", lambda: SECTIONS)
    pair = entities.Pair("cells", "cells", said(main=old), said(main=new))
    assert [one.words() for one in changes(Robot("r", (Link("a"),), ()), [pair], None)] == lines


def test_what_no_format_has_a_word_for_is_said(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(not_compared, "sections", lambda: SECTIONS)
    bare = Robot("r", (Link("a"),), ())
    here = {"battery": {"main": {}, "spare": {}}, "charger": {"voltage": 5}, "fuses": ({}, {}, {})}
    urdf = Side("a.urdf", FORMATS["urdf"], bare)
    said = Side("b.yaml", YAML, replace(bare, sections=Sections({}, here)))
    line = "2 batteries, 1 charger, 3 fuses: a.urdf is a URDF, a format without a word for it"
    assert line in not_compared.uncompared(urdf, said).lines
    assert line in not_compared.uncompared(said, urdf).lines
    assert not_compared.uncompared(said, Side("c.yaml", YAML, bare)).lines == []


def test_a_value_is_plain_and_does_not_say_where_it_comes_from() -> None:
    length = Quantity(0.2, (1, 0, 0), "200 mm")
    made = plain({"at": [length, "x"], "source": {"note": "weighed"}, "on": True, "inner": {"source": "a", "b": None}})
    assert made == {"at": (0.2, "x"), "on": True, "inner": {"b": None}}
    assert type(made["at"][0]) is float
