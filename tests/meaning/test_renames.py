"""Renames: a link of an artifact is known under its new name by its joint, by what hangs on it, or by its place."""

from __future__ import annotations

import pytest

from rosorin_compile.compare.entities import Pair
from rosorin_compile.compare.renames import under_new_names
from rosorin_compile.compare.view import View, transform_of, view_of
from rosorin_compile.formats import Fact, Value


def view(*rows: str) -> View:
    """Return what an artifact says of joints, each as "name parent child x"."""
    facts: dict[Fact, Value] = {}
    for row in rows:
        joint, parent, child, x = row.split()
        facts[Fact("joint", joint, "child")] = Value(child)
        facts[Fact("frame", child, "parent")] = Value(parent)
        facts |= {Fact("frame", child, f"origin {axis}"): Value(float(x) * (axis == "x"), "m") for axis in "xyz"}
    return view_of(facts, {})


@pytest.mark.parametrize(
    ("old", "new", "links"),
    [
        (("j base mast 1", "k mast lamp 1"), ("j base mast 1", "k mast lamp 1"), {}),
        (("j base mast 1",), ("j base pole 2",), {"mast": "pole"}),  # the joint
        (("j base mast 1", "k mast lamp 1"), ("i base pole 2", "k pole lamp 1"), {"mast": "pole"}),  # what hangs on it
        (("j base mast 1",), ("i base pole 1",), {"mast": "pole"}),  # the place
        (("j base mast 1",), ("i base pole 2",), {}),
        (("j base mast 1",), ("j base mast 1", "i base pole 1"), {}),
    ],
)
def test_a_link_has_a_new_name(old: tuple[str, ...], new: tuple[str, ...], links: dict[str, str]) -> None:
    (pair,) = under_new_names([Pair("urdf", "urdf", view(*old), view(*new))])
    assert pair.renamed.get("link", {}) == links


def test_a_frame_of_several_rows_has_each_as_part_of_its_name() -> None:
    facts = {
        Fact("frame", "base", "parent below odom"): Value("odom"),
        Fact("frame", "base", "parent when slam"): Value("map"),
    }
    assert view_of(facts, {}).names >= {"base below odom", "base when slam"}


def test_a_coordinate_that_an_artifact_does_not_say_is_zero() -> None:
    facts = {Fact("frame", "arm", "parent"): Value("base"), Fact("frame", "arm", "origin y"): Value(2.0, "m")}
    assert transform_of(view_of(facts, {}), "arm").xyz == (0.0, 2.0, 0.0)
