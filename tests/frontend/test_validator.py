"""The one validator: schemas that each version of jsonschema from 3.2 on reads alike, and errors of any order."""

from __future__ import annotations

import json
import math
from collections.abc import Iterator
from typing import Any
from unicodedata import category

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from jsonschema import Draft7Validator

from authoring import with_formats
from rosorin_compile.formats import FORMATS
from rosorin_compile.formats.compilation import RobotReader
from rosorin_compile.language.annotations import validator_of
from rosorin_compile.language.expand.description import expand
from rosorin_compile.language.schema import schema, with_outputs
from rosorin_compile.language.validate import validate
from rosorin_compile.source.diagnostics import Source, Span
from rosorin_compile.source.tree import Map, Seq, Text
from rosorin_compile.source.units import ANGLE, LENGTH, MASS, NUMBER, Quantity
from support.paths import ROOT, SCHEMAS

WHOLE = ROOT / "tests" / "data" / "whole" / "robot.yaml"
SHIPPED = {path.name: json.loads(path.read_text("utf-8")) for path in sorted(SCHEMAS.glob("*.schema.json"))}
# What is put together at run time: for outputs of all formats, and for editors.
MADE = {
    "outputs of all formats": with_outputs({name: {"file": "a"} for name in FORMATS}, FORMATS),
    "options of all formats": with_formats(FORMATS.values()),
}
ALL = pytest.mark.parametrize("whole", [*SHIPPED.values(), *MADE.values()], ids=[*SHIPPED, *MADE])


@ALL
def test_schemas_are_of_draft_7(whole: dict[str, Any]) -> None:
    assert whole["$schema"] == "http://json-schema.org/draft-07/schema#"
    for part in [whole, *whole.get("$defs", {}).values()]:  # which draft 7 calls definitions
        Draft7Validator.check_schema(part)


# Spaces, digits, and what nobody sees.
ODD = [chr(code) for code in range(0x110000) if category(chr(code)) in ("Zs", "Zl", "Zp", "Cc", "Cf", "Nd")]


def test_a_name_has_no_space_but_the_plain_one() -> None:
    judge = validator_of({**schema(), "$ref": "#/$defs/name"})
    refused = {letter for letter in ODD if not judge.is_valid(f"a{letter}b")}
    assert {letter for letter in ODD if category(letter) in ("Zs", "Zl", "Zp") and letter != " "} <= refused
    assert refused == {letter for letter in ODD if letter != " " and (letter.isspace() or letter == "\ufeff")}
    assert [name for name in ("a\n", "a ", " a", "\ufeffa", "") if judge.is_valid(name)] == []
    assert all(map(judge.is_valid, ("a", "a b", "a/b", "größe", "a٣")))


SPAN = Span(Source("anything.yaml", "anything"), 1, 1, 1)


def put(place: Map | Seq, key: str | int | None, value: Any) -> None:
    """Put a value into a tree, at the end of a list without a key."""
    if isinstance(place, Map):
        place.put(str(key), value, SPAN, SPAN)
    elif isinstance(key, int):
        place[key] = value
    else:
        place.put(value, SPAN)


def as_tree(value: Any) -> Any:
    """Return a tree of plain mappings and lists, or a copy of a tree."""
    if not isinstance(value, (dict, list)):
        return value
    made: Map | Seq = Map(SPAN) if isinstance(value, dict) else Seq(SPAN)
    for key, item in value.items() if isinstance(value, dict) else ((None, item) for item in value):
        put(made, key, as_tree(item))
    return made


NUMBERS = st.floats(-2, 2) | st.integers(-3, 3) | st.sampled_from([math.nan, math.inf, -math.inf, 1e300, 2**53, 2**60])
QUANTITIES = st.builds(Quantity, NUMBERS, st.sampled_from([LENGTH, MASS, ANGLE, NUMBER]))
TEXTS = st.sampled_from(["", "a b", "link\n", "fixed", "1"])
ANYTHING = st.recursive(
    st.none() | st.booleans() | NUMBERS | QUANTITIES | TEXTS | TEXTS.map(Text),
    lambda inner: st.lists(inner, max_size=4) | st.dictionaries(st.sampled_from(["of", "mass", "xyz", "min"]), inner),
    max_leaves=5,
).map(as_tree)


@pytest.fixture(scope="module")
def whole_robot() -> Map:
    tree = expand(WHOLE, {}, RobotReader()).tree
    assert tree is not None
    assert validate(tree, FORMATS) == []
    return tree


def change(tree: Map, data: st.DataObject) -> None:
    """Put anything anywhere, or take something away."""
    place: Any = tree
    while True:
        keys = list(place) if isinstance(place, dict) else list(range(len(place)))
        key = data.draw(st.sampled_from(keys))
        if not isinstance(place[key], (dict, list)) or not place[key] or data.draw(st.integers(0, 3)) == 0:
            break
        place = place[key]
    match data.draw(st.sampled_from(["put", "remove", "add"])):
        case "put":
            put(place, key, data.draw(ANYTHING))
        case "remove":
            del place[key]
        case "add":
            name = data.draw(st.sampled_from(["mass", "x", "min", "of", "a b", "joints", "xyz", "with"]))
            put(place, name if isinstance(place, Map) else None, data.draw(ANYTHING))


def numbers_in(tree: Any) -> Iterator[float]:
    """Yield the numbers of a tree."""
    for item in tree.values() if isinstance(tree, dict) else tree:
        if isinstance(item, (dict, list)):
            yield from numbers_in(item)
        elif isinstance(item, float):
            yield float(item)


@settings(max_examples=40, deadline=None)
@given(data=st.data())
def test_anything_put_anywhere_is_told_or_fits(whole_robot: Map, data: st.DataObject) -> None:
    tree = as_tree(whole_robot)
    change(tree, data)
    found = validate(tree, FORMATS)
    outputs = with_outputs(tree.get("outputs"), FORMATS)
    # The schema itself, with its references, of draft 7 as jsonschema has it.
    fits = Draft7Validator(outputs).is_valid(tree)
    assert not found or not fits or {one.rule for one in found} <= {"not-finite", "wrong-unit"}
    assert found or fits
    if any(map(math.isnan, numbers_in(tree))):
        assert "not-finite" in {one.rule for one in found}
