"""One number over the robots of a fleet: what is far from the others, and what it looks like."""

from __future__ import annotations

import math
import random

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rosorin_compile_fleet.check.spread import FEWEST, spread_of, straight, typo


def far(values: list[float], unit: str = "") -> list[int]:
    return [one.place for one in spread_of(values, unit).far]


def measured(count: int, middle: float, width: float, seed: int = 3) -> list[float]:
    random_of = random.Random(seed)  # noqa: S311 - nothing is kept secret
    return [random_of.gauss(middle, width) for _ in range(count)]


@pytest.mark.parametrize("count", [6, 7, 8, 9, 20, 1000])
@pytest.mark.parametrize("wrong", [48.0, -0.048, 0.0, 0.06])
def test_one_among_few_is_found_though_it_widens_the_spread(count: int, wrong: float) -> None:
    values = measured(count - 1, 0.048, 0.0005)
    assert far([*values, wrong], "m") == [count - 1]
    assert far([wrong, *values], "m") == [0]


def test_of_eight_robots_with_a_typo_the_plain_deviation_finds_none() -> None:
    """(n - 1) / sqrt(n) standard deviations is the most that one of n numbers can be from their mean."""
    values = [*measured(7, 0.048, 0.0005), 48.0]
    mean = sum(values) / 8
    deviation = math.sqrt(sum((value - mean) ** 2 for value in values) / 7)
    assert max(abs(value - mean) for value in values) / deviation < 2.5
    assert far(values, "m") == [7]


@pytest.mark.parametrize(("count", "most"), [(6, 0.03), (8, 0.02), (30, 0.004), (200, 0.002)])
def test_sound_fleets_are_rarely_called_wrong(count: int, most: float) -> None:
    random_of = random.Random(11)  # noqa: S311
    fleets = 1500
    found = sum(bool(far([random_of.gauss(5, 1) for _ in range(count)])) for _ in range(fleets))
    assert found / fleets <= most
    assert not any(far([random_of.uniform(0, 1) for _ in range(max(count, 20))]) for _ in range(200))


def test_a_sweep_over_factors_has_no_outliers() -> None:
    random_of = random.Random(5)  # noqa: S311
    assert far([10 ** (step / 10) for step in range(-30, 31)]) == []
    assert not any(far([math.exp(random_of.gauss(0, 0.7)) for _ in range(100)]) for _ in range(100))


@pytest.mark.parametrize(
    ("values", "unit", "found"),
    [
        ([0.048] * 7 + [0.9], "m", [7]),
        ([0.048] * 7 + [0.0485], "m", []),  # the first robot that was measured
        ([0.0] * 7 + [0.5], "rad", [7]),
        ([0.0] * 7 + [0.01], "rad", []),
        ([2.0] * 7 + [20.0], "kg", [7]),
        ([2.0] * 7 + [2.1], "kg", []),
        ([0.0] * 7 + [1e-9], "", []),
        ([0.048] * 20 + [0.0481, 0.0479, 0.0482, 0.0478, 0.048], "m", []),
        # Of ten that are measured and twelve that are not, one is wrong.
        ([0.048] * 14 + [0.0481, 0.0479, 0.0482, 0.0478, 0.04805, 0.04795, 0.0483, 0.0481, 0.0479, 0.5], "m", [23]),
    ],
)
def test_most_have_one_and_the_same_number(values: list[float], unit: str, found: list[int]) -> None:
    assert far(values, unit) == found


def test_too_few_are_not_judged() -> None:
    values = [*measured(FEWEST - 2, 1.0, 0.01), 1000.0]
    assert far(values) == []
    assert far([*values, 1.0]) == [FEWEST - 2]


def test_a_second_kind_of_robot_is_no_typo() -> None:
    values = [*measured(30, 0.1, 0.001), *measured(6, 0.3, 0.001)]
    assert far(values, "m") == []
    assert far([*measured(30, 0.1, 0.001), 0.3], "m") == [30]
    assert far([*measured(30, 0.1, 0.001), 0.3, 0.9], "m") == [30, 31]


def test_robots_without_the_number_do_not_count() -> None:
    values = [math.nan, *measured(7, 0.048, 0.0005), math.nan, 48.0]
    spread = spread_of(values, "m")
    assert spread.robots == 8
    assert [one.place for one in spread.far] == [9]
    with pytest.raises(ValueError, match="no robot"):
        spread_of([math.nan])


def test_angles_go_round() -> None:
    around = [math.pi - 0.01, -math.pi + 0.01, math.pi, -math.pi, math.pi - 0.02, math.pi - 0.005, math.pi + 0.003]
    assert far(straight(around), "rad") == []
    assert max(straight(around)) - min(straight(around)) < 0.04
    assert far(straight([*around, 0.0]), "rad") == [7]
    assert straight([0.1, -0.1, 6.28]) == pytest.approx([0.1, -0.1, 6.28 - math.tau])


@given(st.lists(st.floats(-7, 7), min_size=1, max_size=20))
def test_straight_angles_are_the_same_angles(angles: list[float]) -> None:
    for one, other in zip(angles, straight(angles), strict=True):
        assert abs(math.remainder(one - other, math.tau)) < 1e-6
    made = straight(angles)
    assert max(made) - min(made) <= math.tau + 1e-6


@pytest.mark.parametrize(
    ("value", "unit", "wraps", "asked"),
    [
        (48.1, "m", False, "mm where m is meant?"),
        (0.0000481, "m", False, "m where mm is meant?"),
        (4.81, "m", False, "cm where m is meant?"),
        (-0.0481, "m", False, "a sign that is lost, or one too many?"),
        (0.481, "m", False, "a slip of the decimal point, or cm where mm is meant?"),
        (0.0048, "kg", False, "a slip of the decimal point?"),
        (0.0481 / 0.0254, "m", False, "inches where m is meant?"),
        (0.0481 * 180 / math.pi, "rad", True, "degrees where radians are meant?"),
        (0.0481 * math.pi / 180, "rad", True, "radians where degrees are meant?"),
        (0.0481 + math.pi, "rad", True, "looks it the other way?"),
        (0.0481 - math.pi / 2, "rad", True, "another convention of axes?"),
    ],
)
def test_what_a_typo_looks_like(value: float, unit: str, wraps: bool, asked: str) -> None:
    found = typo(value, 0.048, 0.0005, unit, wraps)
    assert found is not None
    assert found.asked == asked


def test_what_looks_like_nothing() -> None:
    assert typo(0.3, 0.048, 0.0005, "m") is None
    assert typo(0.3, 0.0, 0.0, "m") is None
    assert typo(3.0, 2.0, 0.01, "") is None


def test_a_typo_of_a_number_about_zero() -> None:
    found = typo(1.2, 0.0001, 0.001, "m")
    assert found is not None
    assert found.asked == "mm where m is meant?"
    found = typo(0.6, 0.0, 0.01, "rad", wraps=True)
    assert found is not None
    assert found.asked == "degrees where radians are meant?"


def test_degrees_as_radians_go_round_in_an_artifact() -> None:
    found = typo(math.remainder(90.0, math.tau), math.pi / 2, 0.002, "rad", wraps=True)
    assert found is not None
    assert found.asked == "degrees where radians are meant?"
