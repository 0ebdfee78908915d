"""Cache results of functions in memory.

The same numbers and names occur many times in a robot and its artifacts. A process that compiles thousands of robots
calls ``forget`` between them, so that memory does not grow.
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
    """Cache the latest 20,000 results of a function until ``forget`` is called."""
    remembering = lru_cache(maxsize=_MOST)(work)
    _functions.append(remembering.cache_clear)
    return remembering  # type: ignore[return-value]  # its signature is lost on the way


def forget() -> None:
    """Clear all caches."""
    for clear in _functions:
        clear()
