"""The operators of expressions: what values and functions give together, with their dimension, and within bounds."""

from __future__ import annotations

import ast
import operator
from collections.abc import Callable, Mapping
from functools import lru_cache
from typing import Any

from ..quantity import NUMBER, Dimension, Quantity, add
from .bounds import EFFORT, bounded
from .functions import MAX_ITEMS, ExpressionError, common_dimension, kind_of

BINARY: dict[type[ast.operator], Callable[[Any, Any], Any]] = {
    ast.Add: operator.add,
    ast.Sub: operator.sub,
    ast.Mult: operator.mul,
    ast.Div: operator.truediv,
    ast.FloorDiv: operator.floordiv,
    ast.Mod: operator.mod,
    ast.Pow: operator.pow,
}

COMPARE: dict[type[ast.cmpop], Callable[[Any, Any], bool]] = {
    ast.Eq: operator.eq,
    ast.NotEq: operator.ne,
    ast.Lt: operator.lt,
    ast.LtE: operator.le,
    ast.Gt: operator.gt,
    ast.GtE: operator.ge,
    ast.In: lambda a, b: a in b,
    ast.NotIn: lambda a, b: a not in b,
}


def combine(kind: type[ast.operator], left: Any, right: Any) -> Any:
    """Return the result of an operator on two values, at least one of which is no bare number.

    Quantities add and compare with their like, and multiply to the product of their dimensions; a bare number goes
    with any. Raises ExpressionError.
    """
    if type(left) in NUMERIC and type(right) in NUMERIC:
        first: Dimension | None = left.dimension if type(left) is Quantity else None
        second: Dimension | None = right.dimension if type(right) is Quantity else None
        if kind is ast.Mult or kind is ast.Div:
            dimension = _product(first, second, kind is ast.Mult)
            result = BINARY[kind](left, right)
            return Quantity(result, dimension) if dimension is not None else result
        if kind is ast.Pow:
            return _power(left, right)
        common = first if first == second else common_dimension([left, right])
        result = bounded(BINARY[kind](left, right))
        return result if kind is ast.FloorDiv or common is None else Quantity(result, common)
    return _join(kind, left, right)


NUMERIC = frozenset((int, float, Quantity))


@lru_cache(maxsize=1_000)
def _product(first: Dimension | None, second: Dimension | None, times: bool) -> Dimension | None:
    """Return the dimension of a product or a quotient; None for a plain number."""
    dimension = add(first or NUMBER, second or NUMBER, 1 if times else -1)
    return dimension if dimension != NUMBER else None


def _join(kind: type[ast.operator], left: Any, right: Any) -> Any:
    """Return two texts or two lists joined by ``+``, the only operator that they have."""
    texts = isinstance(left, str) and isinstance(right, str)
    if kind is ast.Add and (texts or (isinstance(left, list) and isinstance(right, list))):
        if len(left) + len(right) > MAX_ITEMS:
            raise ExpressionError(f"the result has more than {MAX_ITEMS:,} items")
        EFFORT.spend(left, right)
        return left + right if texts else [*left, *right]
    raise ExpressionError(f"cannot combine {kind_of(left)} and {kind_of(right)} with this operator")


def _power(base: Any, exponent: Any) -> Any:
    if abs(exponent) > 64 or (isinstance(base, int) and abs(base) > 10**9):
        raise ExpressionError("the power is too large")
    dimension = getattr(base, "dimension", None)
    if isinstance(exponent, Quantity) and exponent.dimension != NUMBER:
        raise ExpressionError(f"an exponent is a plain number, not {kind_of(exponent)}")
    if dimension is None:
        return bounded(base**exponent)
    if int(exponent) != exponent:
        raise ExpressionError("a quantity may only be raised to a whole power")
    return Quantity(float(base) ** exponent, _raised(dimension, int(exponent)))


@lru_cache(maxsize=1_000)
def _raised(dimension: Dimension, exponent: int) -> Dimension:
    return add(NUMBER, dimension, exponent)


def entry(container: Any, key: Any) -> Any:
    """Return an entry of a table, a list or a text. Raises ExpressionError if it has none of that name."""
    if not isinstance(key, (str, int, float)):
        raise ExpressionError(f"an entry is named by text or a number, not {kind_of(key)}")
    if isinstance(container, Mapping):
        if key not in container:
            known = ", ".join(map(str, container)) or "it is empty"
            raise ExpressionError(f'the table has no entry "{key}"', help=f"entries: {known}")
        return container[key]
    if not isinstance(container, (list, str)):
        raise ExpressionError(f"{kind_of(container)} has no entries")
    if not isinstance(key, int):
        raise ExpressionError(f"an item is named by its number, not {kind_of(key)}")
    return container[key]


def holds(function: Callable[[Any, Any], bool] | None, left: Any, right: Any) -> bool:
    """Say whether a comparison holds. Raises ExpressionError where the two cannot be compared."""
    if isinstance(left, (str, list, dict)) or isinstance(right, (str, list, dict)):
        EFFORT.spend(left, right)
    try:
        return function is not None and bool(function(left, right))
    except TypeError:
        raise ExpressionError(f"{kind_of(left)} and {kind_of(right)} cannot be compared") from None


def sliced(container: Any, ends: list[Any]) -> Any:
    """Return the part of a list or a text from one end to another, by steps. Raises ExpressionError."""
    if not isinstance(container, (list, str)):
        raise ExpressionError(f"{kind_of(container)} has no items in order")
    EFFORT.spend(container)
    return container[slice(*ends)]


def called(name: str, function: Callable[..., Any], values: list[Any]) -> Any:
    """Return what a function gives, within bounds. Raises ExpressionError in the words of the description."""
    EFFORT.spend(*values)
    try:
        result = bounded(function(*values))
    except (TypeError, AttributeError):
        given = ", ".join(map(kind_of, values)) or "nothing"
        raise ExpressionError(f"{name}() does not take {given}") from None
    except (ValueError, ArithmeticError, LookupError):
        raise ExpressionError(f"{name}() has no value for this") from None
    if isinstance(result, (list, str)):
        EFFORT.spend(result)
    return result
