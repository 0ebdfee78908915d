"""The functions and constants of expressions, and how quantities go through them.

A bare number has no dimension and goes with any; two quantities must be of one dimension where they are added,
compared or chosen from.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import Any

from ..quantity import ANGLE, NUMBER, Dimension, Quantity, describe, dimension_of

MAX_ITEMS = 100_000


class ExpressionError(Exception):
    """An expression that has no value; ``column`` counts from 0 within the expression, -1 where it is not known."""

    def __init__(self, message: str, column: int = -1, help: str = "", unknown: str = "") -> None:
        super().__init__(message)
        self.message = message
        self.column = column
        self.help = help
        self.unknown = unknown


def kind_of(value: Any) -> str:
    """Return what a value is, in words."""
    if value is None:
        return "nothing"
    if isinstance(value, bool):
        return "true or false"
    if isinstance(value, Quantity):
        return describe(value.dimension)
    if isinstance(value, (int, float)):
        return "a number"
    if isinstance(value, str):
        return "text"
    return "a table" if isinstance(value, Mapping) else "a list"


def common_dimension(values: list[Any]) -> Dimension | None:
    """Return the dimension that all values share; bare numbers go with any. Raises ExpressionError otherwise."""
    found: Dimension | None = None
    for value in values:
        if not isinstance(value, (int, float)):
            raise ExpressionError(f"expected a number, got {kind_of(value)}")
        dimension = dimension_of(value)
        if found is not None and dimension not in (None, found):
            raise ExpressionError(f"{describe(found)} and {describe(dimension or NUMBER)} do not go together")
        found = found or dimension
    return found


def _of_angle(function: Callable[[float], float]) -> Callable[[Any], float]:
    """Make a function of an angle: a bare number is in radians."""

    def apply(angle: Any) -> float:
        dimension = dimension_of(angle)
        if dimension not in (None, ANGLE, NUMBER):
            raise ExpressionError(f"expected {describe(ANGLE)}, got {kind_of(angle)}")
        return function(float(angle))

    return apply


def _to_angle(function: Callable[..., float]) -> Callable[..., Quantity]:
    return lambda *values: Quantity(function(*map(float, values)), ANGLE)


def _atan2(y: Any, x: Any) -> Quantity:
    common_dimension([y, x])
    return Quantity(math.atan2(y, x), ANGLE)


def _keeping(function: Callable[..., Any]) -> Callable[..., Any]:
    """Make a function of numbers, or of one list of them, keep their common dimension."""

    def apply(*values: Any) -> Any:
        numbers = list(values[0]) if len(values) == 1 and isinstance(values[0], list) else list(values)
        dimension = common_dimension(numbers)
        result = function(*numbers)
        return Quantity(result, dimension) if dimension else result

    return apply


def _plain(function: Callable[..., Any]) -> Callable[..., Any]:
    """Make a function of bare numbers refuse quantities, whose unit it would lose."""

    def apply(*values: Any) -> Any:
        for value in values:
            if isinstance(value, Quantity) and value.dimension != NUMBER:
                raise ExpressionError(f"expected a plain number, got {kind_of(value)}")
        return function(*values)

    return apply


def _sqrt(value: Any) -> Any:
    dimension = dimension_of(value)
    if dimension is None:
        return math.sqrt(value)
    if any(n % 2 for n in dimension):
        raise ExpressionError(f"there is no square root of {describe(dimension)}")
    a, b, c, d = (n // 2 for n in dimension)
    return Quantity(math.sqrt(value), (a, b, c, d))


def _sum(values: Any) -> Any:
    dimension = common_dimension(list(values))
    total = math.fsum(values) if any(isinstance(v, float) for v in values) else sum(values)
    return Quantity(total, dimension) if dimension else total


def _range(*bounds: Any) -> list[int]:
    if any(isinstance(bound, float) and not bound.is_integer() for bound in bounds):
        raise ExpressionError("a range counts in whole numbers")
    numbers = range(*(int(bound) for bound in bounds))
    if len(numbers) > MAX_ITEMS:
        raise ExpressionError(f"a range of more than {MAX_ITEMS:,} numbers")
    return list(numbers)


def _pad(value: Any, width: Any) -> str:
    """Return a whole number as text of at least ``width`` digits: pad(7, 2) is 07."""
    if isinstance(value, bool) or not isinstance(value, (int, float)) or int(value) != value:
        raise ExpressionError(f"pad takes a whole number, not {kind_of(value)}")
    return str(int(value)).zfill(min(int(width), 20))


def _error(text: Any) -> Any:
    """Refuse a description with a message of its author."""
    raise ExpressionError(_text(text))


def _text(value: Any) -> str:
    """Return a value as text, whole numbers without a point."""
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, float):
        return repr(float(value)) if not float(value).is_integer() else str(int(value))
    if isinstance(value, (str, int)):
        return str(value)
    raise ExpressionError(f"{kind_of(value)} cannot stand inside text", help="use it as the whole value")


def _replace(text: str, old: str, new: str) -> str:
    if not old:
        raise ExpressionError("replace needs a text to look for")
    if text.count(old) * len(new) > MAX_ITEMS:
        raise ExpressionError(f"the result has more than {MAX_ITEMS:,} letters")
    return text.replace(old, new)


def _join(separator: str, texts: list[Any]) -> str:
    words = [_text(text) for text in texts]
    if len(words) * len(separator) + sum(map(len, words)) > MAX_ITEMS:
        raise ExpressionError(f"the result has more than {MAX_ITEMS:,} letters")
    return separator.join(words)


def _round(value: Any, digits: int = 0) -> Any:
    dimension = dimension_of(value)
    rounded = round(float(value), digits) if digits else round(value)
    return Quantity(rounded, dimension) if dimension else rounded


FUNCTIONS: dict[str, Callable[..., Any]] = {
    # angles
    **{name: _of_angle(getattr(math, name)) for name in ("sin", "cos", "tan")},
    **{name: _to_angle(getattr(math, name)) for name in ("asin", "acos", "atan")},
    "atan2": _atan2,
    "degrees": lambda angle: _of_angle(math.degrees)(angle),
    "radians": lambda number: Quantity(math.radians(number), ANGLE),
    # numbers
    "sqrt": _sqrt,
    **{
        name: _keeping(function) for name, function in (("abs", abs), ("min", min), ("max", max), ("hypot", math.hypot))
    },
    "round": _round,
    "floor": _plain(math.floor),
    "ceil": _plain(math.ceil),
    "trunc": _plain(math.trunc),
    **{name: _plain(getattr(math, name)) for name in ("exp", "log", "log2", "log10", "sinh", "cosh", "tanh")},
    **{name: _plain(getattr(math, name)) for name in ("fmod", "copysign", "gcd", "isclose")},
    "pow": _plain(lambda base, exponent: float(base) ** float(exponent)),
    "sign": lambda value: (value > 0) - (value < 0),
    "int": _plain(int),
    "float": float,
    "bool": bool,
    # lists and tables
    "len": len,
    "sum": _sum,
    "range": _range,
    "sorted": lambda values: sorted(values),
    "reversed": lambda values: list(values)[::-1],
    "list": lambda values: list(values),
    "zip": lambda *lists: [list(row) for row in zip(*lists, strict=True)],
    "enumerate": lambda values, start=0: [[index, value] for index, value in enumerate(values, start)],
    "keys": lambda table: list(table.keys()),
    "values": lambda table: list(table.values()),
    "items": lambda table: [[key, value] for key, value in table.items()],
    "get": lambda table, key, default=None: table.get(key, default),
    "all": lambda values: all(values),
    "any": lambda values: any(values),
    # text
    "str": _text,
    "pad": _pad,
    "error": _error,
    "upper": lambda text: text.upper(),
    "lower": lambda text: text.lower(),
    "strip": lambda text: text.strip(),
    "split": lambda text, separator=None: text.split(separator),
    "join": _join,
    "replace": _replace,
    "startswith": lambda text, start: text.startswith(start),
    "endswith": lambda text, end: text.endswith(end),
}

CONSTANTS: dict[str, Any] = {"pi": math.pi, "tau": math.tau, "e": math.e}
CONSTANTS |= {"true": True, "false": False, "none": None}
