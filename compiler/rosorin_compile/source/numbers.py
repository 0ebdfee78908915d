"""Number formats: how a float becomes the text of an artifact. Never a locale, never a negative zero.

``short``, the default, prints what is meant: 0.005 where arithmetic made 0.0050000000000000044 of it.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import lru_cache
from typing import NamedTuple

NumberFormat = Callable[[float], str]

# How a step of a unit is said: the unit that people measure it in, and how many of it there are.
SMALL = {"m": ("mm", 1e3), "rad": ("deg", math.degrees(1)), "kg": ("g", 1e3)}

# Half of the last printed digit of static_transform_publisher arguments, in metres and in radians.
METRE_DIGITS = 7
RADIAN_DIGITS = 8

# How far ``short`` may be off: relative to a number, or to the largest entry of its vector.
SHORT = 1e-12
# So many digits are always enough for that; a number that has more was printed exactly.
_DIGITS_OF_SHORT = 13
# Letters of a number that has twelve digits at most: no shorter one is within 1e-12 of it.
_SHORT_ALREADY = 12
_LARGEST = 1e300
# Of a body that is thinner than that (smallest by largest principal moment) each digit counts for how it turns.
_THIN = 3e-3
# Of a body this flat (see ``inertia``) each digit counts for whether it can be.
_FLAT = 1e-10


# The same numbers stand in a robot again and again, and in each of its artifacts: what was printed is remembered.
@lru_cache(maxsize=20_000)
def exact(value: float) -> str:
    """Return the shortest decimal that reads back as the same double; whole numbers without a point.

    >>> exact(0.1 + 0.2), exact(-0.0), exact(7.5437e-05), exact(3.0)
    ('0.30000000000000004', '0', '7.5437e-05', '3')
    """
    text = repr(float(value) + 0.0)
    return text[:-2] if text.endswith(".0") else text


def six_digits(value: float) -> str:
    """Return a number for a person to read, with six digits at most."""
    return exact(float(f"{value:.6g}"))


def amount(value: float, unit: str) -> str:
    """Return a length, angle or mass that is not negative in the unit that suits its size.

    >>> amount(0.001, "m"), amount(2.5, "m"), amount(0.0042, "rad"), amount(0.0013678, "kg")
    ('1.0 mm', '2.5 m', '0.24 deg', '1.4 g')
    """
    small, count = SMALL[unit]
    return f"{few_digits(value)} {unit}" if value >= 1 and unit != "rad" else f"{few_digits(value * count)} {small}"


def few_digits(value: float) -> str:
    """Return a number with one decimal, a small one with two digits."""
    return f"{value:.1f}" if value >= 0.95 else exact(float(f"{value:.2g}"))


def rounded(value: float, largest: float = 0.0) -> float:
    """Return the shortest decimal within 1e-12 of a value, as a double; of those as short as it the nearest.

    ``largest`` is the largest entry (absolute) of the vector that the value is an entry of: 1e-12 of that will do.

    >>> rounded(0.0050000000000000044), rounded(6.1e-17), rounded(6.1e-17, 1.0), rounded(-1e-30)
    (0.005, 6.1e-17, 0.0, -1e-30)
    """
    bound = SHORT * max(abs(value), largest)
    if not 0.0 < bound < _LARGEST * SHORT:  # zero, what is next to it, what could not be rounded up, and no number
        return value + 0.0
    if abs(value) <= bound:
        return 0.0
    # With this many decimals at most one number is within the bound; with two more there always is one.
    decimals = -math.floor(math.log10(bound)) - 2
    for more in range(3):
        near = round(value, decimals + more)
        if abs(near - value) <= bound:
            return near + 0.0
    return value


@lru_cache(maxsize=20_000)
def short(value: float) -> str:
    """Return the shortest decimal within 1e-12 of the value, relative to it; whole numbers without a point.

    >>> short(0.0050000000000000044), short(1 / 3), short(-0.0), short(-1e-30)
    ('0.005', '0.333333333333', '0', '-1e-30')
    """
    text = exact(value)
    return text if len(text) <= _SHORT_ALREADY else exact(rounded(value))


@lru_cache(maxsize=20_000)
def six(value: float) -> str:
    """Return whichever of ``%.6g`` and ``%.6f`` keeps more of the value, trailing zeros dropped.

    >>> six(-1.5707963267948966), six(7.5437e-05), six(0.0)
    ('-1.570796', '7.5437e-05', '0')
    """
    short, fixed = f"{value:.6g}", f"{value:.6f}"
    better = fixed if abs(float(fixed) - value) < abs(float(short) - value) else short
    return _without_zeros(better)


def fixed(value: float, digits: int) -> str:
    """Return the value with at most ``digits`` decimals, never an exponent, trailing zeros dropped.

    >>> fixed(7.5552e-05, 7), fixed(3.141592653589793, 8), fixed(-1e-9, 7)
    ('0.0000756', '3.14159265', '0')
    """
    return _without_zeros(f"{value:.{digits}f}")


def decimal(value: float) -> str:
    """Return the shortest decimal that reads back as the same double, never with an exponent.

    >>> decimal(7.5437e-05), decimal(1e21), decimal(-0.0), decimal(3.0)
    ('0.000075437', '1000000000000000000000', '0', '3')
    """
    text = exact(value)
    if "e" not in text:
        return text
    from decimal import Decimal

    return _without_zeros(format(Decimal(text), "f"))


def _without_zeros(text: str) -> str:
    if "." in text and "e" not in text:
        text = text.rstrip("0").rstrip(".")
    return "0" if text == "-0" else text


class Style(NamedTuple):
    """How numbers are printed: with so many digits, counted from the first one that is not zero, or after the point.

    ``significant`` and ``decimals``: what all numbers keep to; neither: some keep to this, some to that.
    """

    digits: int
    significant: bool = False
    decimals: bool = False

    def tolerance(self, value: float) -> float:
        """Return how far the number that was meant may be away from the one that is printed."""
        point = 0.5 * 10.0**-self.digits
        if not value:
            return point if self.decimals else 0.0
        first = 0.5 * 10.0 ** (math.floor(math.log10(abs(value))) + 1 - self.digits)
        known = point if self.decimals else min(first, point)
        if self.significant:
            known = max(first, point) if self.decimals else first
        # A number that is this long may be one that ``short`` has printed.
        return max(known, off_by_short(value)) if self.digits >= _DIGITS_OF_SHORT - 1 else known


# What ``six`` prints.
SIX = Style(6)

NUMBER_FORMATS: dict[str, NumberFormat] = {"short": short, "exact": exact, "six": six}


def number_format(options: Mapping[str, object]) -> NumberFormat:
    """Return how an output prints numbers, by its options."""
    return NUMBER_FORMATS[str(options.get("number_format", "short"))]


def off_by_short(value: float, largest: float = 0.0) -> float:
    """Return how far a number may be off that is no longer than ``short`` prints it; a longer one is exact."""
    if float(f"{value:.{_DIGITS_OF_SHORT}g}") != value:
        return 0.0
    return _ABOVE * SHORT * max(abs(value), largest)


# The bound was that of the number before it was rounded.
_ABOVE = 1 + 1e-9
_tolerance_of_six = lru_cache(maxsize=20_000)(SIX.tolerance)


def off_by_six(value: float, largest: float = 0.0) -> float:
    """Return how far a number may be off where none has more digits than ``six`` prints.

    ``short`` may have printed them as well: what is small beside the largest entry of its vector is 0 then.
    """
    return max(_tolerance_of_six(value), off_by_short(value, largest))


def numbers(values: Iterable[float], number: NumberFormat) -> str:
    """Return numbers that have nothing to do with each other, separated by single spaces."""
    return " ".join(map(number, values))


def vector(values: Iterable[float], number: NumberFormat) -> str:
    """Return the entries of a vector separated by single spaces, the only separator that urdfdom takes inside one."""
    if number is short:
        return " ".join(map(exact, rounded_vector(values)))
    return " ".join(map(number, values))


def rounded_vector(values: Iterable[float]) -> list[float]:
    """Return the entries of a vector, each as short as it may be."""
    entries = list(values)
    largest = max(map(abs, entries), default=0.0)
    return [rounded(value, largest) for value in entries]


def inertia(six: Sequence[float], principal: Sequence[float], number: NumberFormat) -> list[str]:
    """Return the moments and products of an inertia (xx yy zz xy xz yz) in print; ``principal``: smallest first.

    Moments are numbers, products entries of the tensor. All digits are kept where the rest would be another body: of a
    thin one whose axes are turned, and of one that is flat, so that A + B = C, and engines refuse A + B < C.
    """
    if number is not short:
        return list(map(number, six))
    moments, products = six[:3], six[3:]
    least, middle, most = principal
    if any(products) and (least < _THIN * most or least + middle - most < _FLAT * most):
        return list(map(exact, six))
    near = [rounded(moment) for moment in moments]
    if _can_be(moments) and not _can_be(near):
        return list(map(exact, six))
    largest = max(map(abs, moments))
    return [*map(exact, near), *(exact(rounded(product, largest)) for product in products)]


def _can_be(moments: Sequence[float]) -> bool:
    """Say whether there can be a body with these moments about its axes: none is more than the other two."""
    low, middle, high = sorted(moments)
    return low + middle >= high
