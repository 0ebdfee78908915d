"""Where a description certainly fits, nothing is wrong with it: all cases, and the whole robot with anything in it."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any
from unicodedata import category

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rosorin_compile.diagnostics import Source, Span
from rosorin_compile.formats import FORMATS
from rosorin_compile.frontend import validate
from rosorin_compile.frontend.certain import Certain
from rosorin_compile.frontend.expand import expand
from rosorin_compile.frontend.schema import judge_of, schema, validator, validator_of
from rosorin_compile.frontend.tree import Map, Seq, Text
from rosorin_compile.pipeline import Readers
from rosorin_compile.units import ANGLE, LENGTH, MASS, NUMBER, Quantity

ROOT = Path(__file__).resolve().parents[2]
WHOLE = ROOT / "tests" / "data" / "whole" / "robot.yaml"
GOOD = [WHOLE, *sorted(ROOT.glob("descriptions/*/robot.yaml")), *sorted(ROOT.glob("examples/*/robot.yaml"))]
BAD = sorted((ROOT / "tests" / "bad").rglob("*.yaml"))


def tree_of(path: Path) -> Map | None:
    """Return a description as it is validated; None of one that is no tree."""
    return expand(path, {}, Readers()).tree


def judged(tree: Map) -> tuple[bool, bool]:
    """Return whether a tree certainly fits, and whether nothing is wrong with it."""
    judge = judge_of(tree.get("outputs"), FORMATS)
    return judge.certain.fits(tree), not validate._problems(tree, judge, FORMATS)


@pytest.mark.parametrize("path", GOOD, ids=lambda path: path.parent.name)
def test_what_is_right_certainly_fits(path: Path) -> None:
    tree = tree_of(path)
    assert tree is not None
    assert judged(tree) == (True, True)


def test_what_is_wrong_never_fits() -> None:
    wrong = 0
    for path in BAD:
        tree = tree_of(path)
        certain, right = judged(tree) if tree is not None else (False, False)
        assert right or not certain, path
        wrong += tree is not None and not right
    assert wrong > 90


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
def whole() -> Map:
    tree = tree_of(WHOLE)
    assert tree is not None
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


@settings(max_examples=400, deadline=None)
@given(data=st.data())
def test_anything_put_anywhere(whole: Map, data: st.DataObject) -> None:
    tree = as_tree(whole)
    change(tree, data)
    certain, right = judged(tree)
    assert right or not certain


@pytest.mark.parametrize("name", ["robot_model", "static_tf"])
@settings(max_examples=100, deadline=None)
@given(data=st.data())
def test_json_artifacts(name: str, data: st.DataObject) -> None:
    tree = as_tree(json.loads((ROOT / "outputs" / "rosorin" / f"{name}.json").read_text("utf-8")))
    certain = Certain(schema(name))
    assert validator(name).is_valid(tree)
    assert certain.fits(tree)
    change(tree, data)
    assert not certain.fits(tree) or validator(name).is_valid(validate._Walk().plain(tree))


NUMBERS = st.one_of(st.floats(), st.integers(-3, 3), st.floats(-3, 3), st.booleans(), st.just("1"), st.none())


@given(
    st.lists(NUMBERS, max_size=5) | st.lists(st.floats(-3, 3), max_size=5),
    st.one_of(
        st.booleans(),
        st.fixed_dictionaries(
            {},
            optional={
                "type": st.sampled_from(["number", "integer", "string", ["number", "null"]]),
                "minimum": st.sampled_from([-1, 0.5]),
                "maximum": st.sampled_from([0, 2.5]),
                "exclusiveMinimum": st.just(0),
                "enum": st.just(["1"]),
                "description": st.just("a word"),
            },
        ),
    ),
)
def test_lists_of_numbers(values: list[Any], items: Any) -> None:
    schema_of_list = {"type": "array", "items": items, "$defs": {}}
    fits = Certain(schema_of_list).fits(values)
    finite = all(math.isfinite(one) for one in values if isinstance(one, float))
    assert not fits or (finite and validator_of(schema_of_list).is_valid(values))
    if fits is False and isinstance(items, dict) and items.get("type") == "number" and finite:
        assert not validator_of(schema_of_list).is_valid(values)


def patterns_in(part: Any) -> set[str]:
    """Return the patterns of a schema."""
    if isinstance(part, list):
        return set().union(*map(patterns_in, part))
    if not isinstance(part, dict):
        return set()
    own = {part["pattern"]} if isinstance(part.get("pattern"), str) else set()
    return own.union(*map(patterns_in, part.values()))


# Spaces, digits and what nobody sees: expressions of Python and of schemas differ in which of them are \s, \d and \w.
ODD = [chr(code) for code in range(0x110000) if category(chr(code)) in ("Zs", "Zl", "Zp", "Cc", "Cf", "Nd")]


@pytest.mark.parametrize("pattern", sorted(patterns_in(schema())))
def test_the_size_of_a_description_decides_on_no_letter(pattern: str) -> None:
    part = {"type": "string", "pattern": pattern}
    certain, judge = Certain(part), validator_of(part)
    texts = [text for letter in ODD for text in (letter, f"a{letter}b", f"a {letter}", f"2026-01-{letter}1")]
    assert [text for text in texts if certain.fits(text) and not judge.is_valid(text)] == []
