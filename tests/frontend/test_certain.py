"""What certainly fits the schema, the validator takes: of all cases, and of the whole robot with anything in it."""

from __future__ import annotations

import copy
import json
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rosorin_compile.formats import FORMATS
from rosorin_compile.frontend import validate
from rosorin_compile.frontend.certain import Certain
from rosorin_compile.frontend.expand import expand
from rosorin_compile.frontend.schema import schema, validator, validator_of, with_outputs
from rosorin_compile.pipeline import Readers

ROOT = Path(__file__).resolve().parents[2]
WHOLE = ROOT / "tests" / "data" / "whole" / "robot.yaml"
GOOD = [WHOLE, *sorted(ROOT.glob("descriptions/*/robot.yaml")), *sorted(ROOT.glob("examples/*/robot.yaml"))]
BAD = sorted((ROOT / "tests" / "bad").rglob("*.yaml"))


def plain_of(path: Path) -> Any:
    """Return a description as the validator gets it; None of one that is no tree."""
    tree = expand(path, {}, Readers()).tree
    return None if tree is None else copy.deepcopy(validate._Walk().plain(tree))


def judged(plain: Any) -> tuple[bool, bool]:
    """Return whether a value certainly fits, and whether the validator takes it."""
    schema = with_outputs(plain.get("outputs"), FORMATS)
    return Certain(schema).fits(plain), validator_of(schema).is_valid(plain)


@pytest.mark.parametrize("path", GOOD, ids=lambda path: path.parent.name)
def test_what_is_right_certainly_fits(path: Path) -> None:
    assert judged(plain_of(path)) == (True, True)


def test_what_the_validator_refuses_never_fits() -> None:
    refused = 0
    for path in BAD:
        plain = plain_of(path)
        certain, valid = judged(plain) if plain is not None else (False, False)
        assert valid or not certain, path
        refused += plain is not None and not valid
    assert refused > 80


ANYTHING = st.recursive(
    st.none() | st.booleans() | st.integers(-3, 3) | st.floats(-2, 2) | st.sampled_from(["", "a b", "link\n", "fixed"]),
    lambda inner: st.lists(inner, max_size=4) | st.dictionaries(st.sampled_from(["of", "mass", "xyz", "min"]), inner),
    max_leaves=5,
)


@pytest.fixture(scope="module")
def whole() -> Any:
    return plain_of(WHOLE)


def change(plain: Any, data: st.DataObject) -> None:
    """Put anything anywhere, or take something away."""
    place = plain
    while True:
        keys = list(place) if isinstance(place, dict) else list(range(len(place)))
        key = data.draw(st.sampled_from(keys))
        if not isinstance(place[key], (dict, list)) or not place[key] or data.draw(st.integers(0, 3)) == 0:
            break
        place = place[key]
    match data.draw(st.sampled_from(["put", "remove", "add"])):
        case "put":
            place[key] = data.draw(ANYTHING)
        case "remove":
            del place[key]
        case "add" if isinstance(place, dict):
            place[data.draw(st.sampled_from(["mass", "x", "min", "of", "a b", "joints"]))] = data.draw(ANYTHING)
        case "add":
            place.append(data.draw(ANYTHING))


@settings(max_examples=400, deadline=None)
@given(data=st.data())
def test_anything_put_anywhere(whole: Any, data: st.DataObject) -> None:
    plain = copy.deepcopy(whole)
    change(plain, data)
    certain, valid = judged(plain)
    assert valid or not certain


@pytest.mark.parametrize("name", ["robot_model", "static_tf"])
@settings(max_examples=100, deadline=None)
@given(data=st.data())
def test_json_artifacts(name: str, data: st.DataObject) -> None:
    plain = json.loads((ROOT / "outputs" / "rosorin" / f"{name}.json").read_text("utf-8"))
    certain = Certain(schema(name))
    assert validator(name).is_valid(plain)
    assert certain.fits(plain)
    change(plain, data)
    assert validator(name).is_valid(plain) or not certain.fits(plain)
