"""How numbers are printed by default: as short as 1e-12 allows, and never so that it is another robot."""

from __future__ import annotations

import math
from decimal import Decimal
from fractions import Fraction

from hypothesis import assume, example, given, settings
from hypothesis import strategies as st

from rosorin_compile.model import Inertial, Pose
from rosorin_compile.source.numbers import exact, short, vector

BOUND = Fraction(1e-12) * (1 + Fraction(1, 10**15))  # the product of two doubles is off by half a bit
DIGITS = 13

floats = st.one_of(
    st.floats(allow_nan=False, allow_infinity=False),
    st.floats(-1e6, 1e6),
    # What arithmetic makes of short numbers.
    st.tuples(st.integers(-9999, 9999), st.integers(-9, 9), st.floats(-4e-12, 4e-12)).map(
        lambda made: made[0] * 10.0 ** made[1] * (1 + made[2])
    ),
)
vectors = st.lists(floats, min_size=1, max_size=6)


def digits(text: str) -> int:
    """Return how many digits a number has, from the first to the last one that is not zero."""
    return len(str(abs(int("".join(map(str, Decimal(text).as_tuple().digits))))).rstrip("0"))


def decimals(text: str) -> int:
    """Return where the last digit that is not zero stands: so many places behind the point."""
    number = Decimal(text)
    return -int(number.normalize().as_tuple().exponent) if number else -400


def shorter(value: float, bound: Fraction, places: int) -> bool:
    """Return True if a decimal with at most so many places, as a double, is within the bound."""
    unit = Fraction(10) ** -places
    doubles = [Fraction(float(whole * unit)) for whole in _around(value, unit)]
    return any(abs(double - Fraction(value)) < bound * (1 - Fraction(1, 10**9)) for double in doubles)


def _around(value: float, unit: Fraction) -> tuple[int, int]:
    whole = math.floor(Fraction(value) / unit)
    return whole, whole + 1


@given(floats)
@example(1.0000000000015)
@example(5e-324)
@example(1.7976931348623157e308)
@example(-9.9999999999995)
@example(0.0999999999999)
def test_a_number_is_within_the_bound_and_none_is_shorter(value: float) -> None:
    text = short(value)
    bound = BOUND * abs(Fraction(value))
    assert abs(Fraction(float(text)) - Fraction(value)) <= bound
    assert (float(text) > 0, float(text) < 0) == (value > 0, value < 0)
    assert digits(text) <= DIGITS or not 1e-290 < abs(value) < 1e300
    if 1e-290 < abs(value) < 1e300:  # below, doubles have fewer digits
        assert not shorter(value, bound, decimals(text) - 1)
    assert short(value) == text == exact(float(text))


@given(vectors)
@example([1.0, 6.123233995736766e-17, 0.0])
@example([7.346839692639297e-40, 1e-3])
@example([-1.0, 1e-12])
def test_an_entry_of_a_vector_is_within_the_bound_of_the_largest(values: list[float]) -> None:
    texts = vector(values, short).split(" ")
    largest = max(abs(Fraction(value)) for value in values)
    assume(largest == 0 or 1e-290 < largest < 1e300)
    for value, text in zip(values, texts, strict=True):
        assert abs(Fraction(float(text)) - Fraction(value)) <= BOUND * largest
        assert float(text) == 0 or (float(text) > 0) == (value > 0)
        assert text != "-0"
        if float(text):
            assert not shorter(value, BOUND * largest, decimals(text) - 1)


moments = st.floats(1e-9, 10)
turns = st.tuples(*[st.floats(-3, 3)] * 3)


@settings(max_examples=300)
@given(moments, moments, st.floats(0, 1), turns)
@example(1 / 3, 1 / 3, 1.0, (0.0, 0.0, 0.0))
@example(1e-9, 1.0, 0.0, (0.3, 0.4, 0.5))
def test_an_inertia_stays_that_of_a_body(a: float, b: float, share: float, rpy: tuple[float, float, float]) -> None:
    """Thin and flat bodies are on the edge of what can be; the small moment of a thin one keeps its digits."""
    c = abs(a - b) + share * (a + b - abs(a - b))
    rows = Pose((0, 0, 0), rpy).transform().rows
    xx, yy, zz, xy, xz, yz = (
        math.fsum(rows[i][k] * rows[j][k] * moment for k, moment in enumerate((a, b, c)))
        for i, j in ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))
    )
    was = Inertial(1.0, Pose(), xx, yy, zz, xy, xz, yz)
    assume(was.principal_moments[0] > 1e-12)
    printed = list(map(float, was.printed_inertia(short)))
    now = Inertial(1.0, Pose(), *printed)
    noise = 1e-15 * was.principal_moments[2]  # of the eigenvalues as they are worked out
    for before, after in zip(was.principal_moments, now.principal_moments, strict=True):
        assert abs(after - before) <= 1e-9 * before + 10 * noise
    assert edge(now) >= min(edge(was), 0.0) - 10 * noise


def edge(inertial: Inertial) -> float:
    """Return by how much the two smaller moments are more than the largest one."""
    low, middle, high = inertial.principal_moments
    return low + middle - high


def test_a_flat_plate_is_printed_with_all_digits() -> None:
    """MuJoCo refuses A + B < C, by whatever it is less."""
    assert Inertial(1, Pose(), 1 / 3, 1 / 3, 2 / 3).printed_inertia(short)[:3] == [
        "0.3333333333333333",
        "0.3333333333333333",
        "0.6666666666666666",
    ]
    assert Inertial(1, Pose(), 1 / 3, 1 / 3, 1 / 3, 1e-30).printed_inertia(short) == [
        *["0.333333333333"] * 3,
        *["0"] * 3,
    ]
