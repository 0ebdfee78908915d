"""Bounds: how large a value may grow, and how much work one expression may do.

Every list and text that is made, walked or compared is counted, not only the rounds of a loop: a short expression can
ask for a great deal.
"""

from __future__ import annotations

from typing import Any

from ..quantity import Quantity
from .functions import MAX_ITEMS, ExpressionError

MAX_MAGNITUDE = 1e300
MAX_INTEGER = 10**18
MAX_WORK = 3_000_000

_SIZED = (str, list, dict)


class Effort:
    """The work that the expression under evaluation has done so far, those nested in it included."""

    def __init__(self) -> None:
        self.done = 0

    def spend(self, *values: Any) -> None:
        """Count the items of the values, and one step. Raises ExpressionError when it is too much."""
        self.done += 1
        for value in values:
            if isinstance(value, _SIZED):
                self.done += weight(value)
        if self.done > MAX_WORK:
            raise ExpressionError(f"more than {MAX_WORK:,} steps")


EFFORT = Effort()


def weight(value: Any) -> int:
    """Return the number of values within a value, itself included; lists in lists count as often as they stand there.

    Stops counting a little above the bound of a list.
    """
    if not isinstance(value, (list, dict)):
        return len(value) // 8 + 1 if isinstance(value, str) else 1
    total, waiting = 0, [value]
    while waiting and total <= MAX_ITEMS:
        items: Any = waiting.pop()
        items = items.values() if isinstance(items, dict) else items
        total += len(items) + 1
        waiting += [item for item in items if isinstance(item, (list, dict))]
    return total


def bounded(value: Any) -> Any:
    """Return the value. Raises ExpressionError if it grows beyond what a description can need, or is no number."""
    kind = type(value)
    if kind is bool or value is None:
        return value
    if isinstance(value, (float, Quantity)):
        if not abs(value) < MAX_MAGNITUDE:
            raise ExpressionError("the result is not a finite number")
    elif isinstance(value, int):
        if abs(value) > MAX_INTEGER:
            raise ExpressionError("the number is too large")
    elif isinstance(value, complex):
        raise ExpressionError("the result is not a real number")
    elif isinstance(value, str):
        if len(value) > MAX_ITEMS:
            raise ExpressionError(f"the result has more than {MAX_ITEMS:,} letters")
    elif weight(value) > MAX_ITEMS:
        raise ExpressionError(f"the result has more than {MAX_ITEMS:,} items")
    return value
