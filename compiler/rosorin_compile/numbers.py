"""Number formats: how a float becomes the text of an artifact. Never a locale, never a negative zero."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable

from .startup.records import NamedTuple
from .startup.remembering import remembered

NumberFormat = Callable[[float], str]

# Half of the last printed digit of static_transform_publisher arguments, in metres and in radians.
METRE_DIGITS = 7
RADIAN_DIGITS = 8


# The same numbers stand in a robot again and again, and in each of its artifacts: what was printed is remembered.
@remembered
def exact(value: float) -> str:
    """Return the shortest decimal that reads back as the same double; whole numbers without a point.

    >>> exact(0.1 + 0.2), exact(-0.0), exact(7.5437e-05), exact(3.0)
    ('0.30000000000000004', '0', '7.5437e-05', '3')
    """
    text = repr(float(value) + 0.0)
    return text[:-2] if text.endswith(".0") else text


@remembered
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
        if self.significant and self.decimals:
            return max(first, point)
        return first if self.significant else point if self.decimals else min(first, point)


# What ``six`` prints.
SIX = Style(6)

NUMBER_FORMATS: dict[str, NumberFormat] = {"exact": exact, "six": six}


def vector(values: Iterable[float], number: NumberFormat) -> str:
    """Return numbers separated by single spaces, the only separator that urdfdom takes inside a vector."""
    return " ".join(map(number, values))
