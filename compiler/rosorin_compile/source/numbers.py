"""Format floats for artifacts, independent of the locale: as ``short`` (the default), ``exact`` or ``six``."""

import math
from collections.abc import Callable, Iterable, Mapping
from functools import lru_cache

NumberFormat = Callable[[float], str]

SMALL = {"m": ("mm", 1e3), "rad": ("deg", math.degrees(1)), "kg": ("g", 1e3)}  # smaller unit, factor to convert to it
METRE_DIGITS, RADIAN_DIGITS = 7, 8  # decimals of m and rad in arguments of static_transform_publisher
SHORT = 1e-12  # maximum rounding error of ``short``, relative to the number or to the largest entry of its vector


@lru_cache(maxsize=20_000)
def exact(value: float) -> str:
    """Format a float as the shortest text that reads back as the same double; an integer has no decimal point."""
    return repr(float(value) + 0.0).removesuffix(".0")


def amount(value: float, unit: str) -> str:
    """Format a value in ``unit`` (m, rad or kg) with a readable unit, such as 1.0 mm, 2.5 m, 0.24 deg or 1.4 g."""
    small, count = SMALL[unit]
    return f"{few_digits(value)} {unit}" if value >= 1 and unit != "rad" else f"{few_digits(value * count)} {small}"


def few_digits(value: float) -> str:
    """Format a number with one decimal, or with two significant digits if it is below 0.95."""
    return f"{value:.1f}" if value >= 0.95 else exact(float(f"{value:.2g}"))


def round_to_shortest(value: float, largest: float = 0.0) -> float:
    """Round to the fewest decimals with an error below 1e-12, relative to the value or the vector entry ``largest``."""
    bound = SHORT * max(abs(value), largest)
    if not 0.0 < bound < 1e300 * SHORT:  # zero, subnormal, huge or NaN: cannot be rounded
        return value + 0.0
    if abs(value) <= bound:
        return 0.0
    # Start with so few decimals that at most one number is within the bound. Two more decimals are always enough.
    decimals = -math.floor(math.log10(bound)) - 2
    for digits in range(decimals, decimals + 3):
        if abs((near := round(value, digits)) - value) <= bound:
            return near + 0.0
    return value


@lru_cache(maxsize=20_000)
def short(value: float) -> str:
    """Format a float as the shortest text within a relative error of 1e-12; an integer has no decimal point."""
    text = exact(value)
    return text if len(text) <= 12 else exact(round_to_shortest(value))  # 12 characters or fewer need no rounding


@lru_cache(maxsize=20_000)
def six(value: float) -> str:
    """Format a float as ``%.6g`` or ``%.6f``, whichever is closer to the value, without trailing zeros."""
    return _without_zeros(min(f"{value:.6g}", f"{value:.6f}", key=lambda text: abs(float(text) - value)))


def to_fixed(value: float, digits: int) -> str:
    """Format a float with at most ``digits`` decimals, without an exponent or trailing zeros."""
    return _without_zeros(f"{value:.{digits}f}")


def decimal(value: float) -> str:
    """Format a float as the shortest text without an exponent that reads back as the same double."""
    from decimal import Decimal

    text = exact(value)
    return _without_zeros(format(Decimal(text), "f")) if "e" in text else text


def _without_zeros(text: str) -> str:
    if "." in text and "e" not in text:
        text = text.rstrip("0").rstrip(".")
    return "0" if text == "-0" else text


def off_by_short(value: float, largest: float = 0.0) -> float:
    """Return the maximum rounding error of a value from ``short``; ``largest`` is the largest entry of its vector."""
    is_short = float(f"{value:.13g}") == value
    return (1 + 1e-9) * SHORT * max(abs(value), largest) if is_short else 0.0  # the original value may be larger


def off_by_six(value: float, largest: float = 0.0) -> float:
    """Return the maximum rounding error of a value from ``six`` or ``short``; ``largest`` is as in ``off_by_short``."""
    digit = 0.5 * 10.0 ** (math.floor(math.log10(abs(value))) - 5) if value else 0.0
    return max(min(0.5e-6, digit), off_by_short(value, largest))


NUMBER_FORMATS: dict[str, NumberFormat] = {"short": short, "exact": exact, "six": six}


def number_format(options: Mapping[str, object]) -> NumberFormat:
    """Return the formatter that the option ``number_format`` of an output selects; the default is ``short``."""
    return NUMBER_FORMATS[str(options.get("number_format", "short"))]


def numbers(values: Iterable[float], number: NumberFormat) -> str:
    """Format each number with the function ``number``, and join them with single spaces."""
    return " ".join(map(number, values))


def vector(values: Iterable[float], number: NumberFormat = short) -> str:
    """Format a vector with single spaces between its entries, because urdfdom accepts no other separator."""
    return _short_vector(tuple(values)) if number is short else numbers(values, number)


@lru_cache(maxsize=20_000)
def _short_vector(entries: tuple[float, ...]) -> str:
    largest = max(map(abs, entries), default=0.0)
    return numbers((round_to_shortest(value, largest) for value in entries), exact)
