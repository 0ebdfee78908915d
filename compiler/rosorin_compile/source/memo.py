"""Remembering: what functions have worked out once, and are asked for again and again.

The same numbers and names stand in a robot many times, and in each of its artifacts. Over thousands of robots in one
process they are others and others: ``forget`` lets go of all of them, so that memory does not grow.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache
from typing import TYPE_CHECKING, ParamSpec, TypeVar

if TYPE_CHECKING:
    Given = ParamSpec("Given")
    Found = TypeVar("Found")

_MOST = 20_000  # results of a function
_functions: list[Callable[[], None]] = []


def remembered(work: Callable[Given, Found]) -> Callable[Given, Found]:
    """Return a function that works out each of its results once, as long as there are not too many."""
    remembering = lru_cache(maxsize=_MOST)(work)
    _functions.append(remembering.cache_clear)
    return remembering  # type: ignore[return-value]  # its signature is lost on the way


def forget() -> None:
    """Forget all results."""
    for clear in _functions:
        clear()
