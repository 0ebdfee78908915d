"""How far apart two numbers may be that mean the same: no farther than printing them may have moved them."""

from __future__ import annotations

import math

import pytest

from rosorin_compile.compare.tolerance import (
    HERE,
    Placed,
    Turn,
    gap,
    joined,
    printing_of,
    same_angles,
    same_value,
    wrapped,
)
from rosorin_compile.formats import Value
from rosorin_compile.model import Transform
from rosorin_compile.source.diagnostics import Source
from rosorin_compile.source.load import parse_yaml
from rosorin_compile.source.numbers import Style


@pytest.mark.parametrize(
    ("one", "other", "apart"),
    [(0.0, 0.0, 0.0), (5e-7, 0.0, 5e-7), (5e-7, 5e-7, 7.5e-7), (5e-7, 1e-7, 6e-7), (1e-7, 5e-7, 6e-7)],
)
def test_two_printed_numbers_are_apart_by_their_roundings(one: float, other: float, apart: float) -> None:
    assert joined(one, other) == pytest.approx(apart, rel=1e-12)


@pytest.mark.parametrize(
    ("moved", "tolerance", "noise", "same"),
    [
        (0.0, 0.0, 0.0, True),
        (1e-15, 0.0, 0.0, False),
        (4.9e-7, 5e-7, 0.0, True),
        (7.6e-7, 5e-7, 0.0, False),
        (1.9e-9, 0.0, 1e-9, True),
        (2.2e-9, 0.0, 1e-9, False),
    ],
)
def test_a_value_is_the_same_within_what_it_was_printed_with(
    moved: float, tolerance: float, noise: float, same: bool
) -> None:
    one, other = Value(1.0, "m", tolerance), Value(1.0 + moved, "m", tolerance)
    assert same_value(one, other, noise) == same_value(other, one, noise) == same


def test_a_value_and_none_differ_and_words_are_compared_letter_by_letter() -> None:
    assert same_value(None, None)
    assert not same_value(Value(0.0), None)
    assert not same_value(None, Value(0.0))
    assert same_value(Value("fixed"), Value("fixed"))
    assert not same_value(Value("fixed"), Value("Fixed"), 1.0)


@pytest.mark.parametrize(
    ("angle", "within"), [(0.5, 0.5), (math.pi, math.pi), (3.5, 3.5 - math.tau), (-3.5, math.tau - 3.5)]
)
def test_an_angle_is_within_half_a_turn(angle: float, within: float) -> None:
    assert wrapped(angle) == pytest.approx(within, abs=1e-12)


@pytest.mark.parametrize(("turned", "same"), [(0.0, True), (7.4e-7, True), (8e-7, False), (math.tau, True)])
def test_angles_are_the_same_one_by_one(turned: float, same: bool) -> None:
    known = (5e-7, 5e-7, 5e-7)
    for axis in range(3):
        rpy = [0.1, 0.2, 0.3]
        rpy[axis] += turned
        assert same_angles(Turn((0.1, 0.2, 0.3), known), Turn((rpy[0], rpy[1], rpy[2]), known)) == same


def test_two_places_are_one_within_their_tolerances() -> None:
    there = Placed(Transform(xyz=(1.0, 0.0, 0.0)), 2e-3, 1e-3)
    assert gap(there, Placed(Transform(xyz=(1.0, 0.0029, 0.0)), 2e-3, 1e-3), 0.0).closed
    assert not gap(there, Placed(Transform(xyz=(1.0, 0.0031, 0.0)), 2e-3, 1e-3), 0.0).closed
    assert there.then(there).length == pytest.approx(2e-3 + 2e-3 + 1e-3)
    assert there.then(there).angle == pytest.approx(2e-3)
    assert there.inverse().length == pytest.approx(3e-3)
    assert not gap(HERE, there, 0.99).closed
    assert gap(HERE, there, 1.0).closed


@pytest.mark.parametrize(
    ("numbers", "style"),
    [
        ("0.123456, 1.5", Style(6, True, True)),
        ("0.123456, 1234567", Style(6, False, True)),  # a whole number counts, too
        ("0.000123456, 1234.567891", Style(6, False, False)),  # six digits of one, six after the point of the other
        ("0.12345678901234567, 1.5", None),
    ],
)
def test_the_digits_of_numbers_say_how_they_were_printed(numbers: str, style: Style | None) -> None:
    printing = printing_of(parse_yaml(Source("a.yaml", f"mass: [{numbers}]\n")))
    assert printing.styles["mass"] == printing.general == style
