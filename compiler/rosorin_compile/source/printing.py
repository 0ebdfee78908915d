"""How a source prints its numbers: with how many digits, by key.

A program that prints six digits leaves half of the sixth open. The numbers of a file show that it was printed so: none
has more digits.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterator, Mapping
from functools import lru_cache
from typing import NamedTuple

from .diagnostics import Span
from .numbers import SHORT
from .tree import Map, Seq

# Fewer digits than these are taken for a choice, not for rounding: 0.1 is 0.1.
_FEWEST = 6
# What has more digits than these is exact as far as a double can tell.
_MOST = 14
# By how much less a number is known that was calculated from printed ones.
_CALCULATED = 4.0
_NUMBER = re.compile(r"[+-]?(?P<whole>[0-9]*)\.?(?P<part>[0-9]*)(?:[eE](?P<power>[+-]?[0-9]+))?")

_DIGITS_OF_SHORT = 13  # always enough for ``short``; a number that has more was printed exactly


class Style(NamedTuple):
    """The number of digits that numbers are printed with: significant ones, decimals, or (neither) some of each."""

    digits: int
    significant: bool = False
    decimals: bool = False

    def tolerance(self, value: float) -> float:
        """Return the largest error of a number that is printed like that."""
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


class Printing(NamedTuple):
    """How a source prints its numbers, by their key; without a style numbers are exact.

    ``general`` is the style of all numbers: that of what was calculated from others, as angles from a quaternion.
    """

    styles: Mapping[str, Style | None]
    general: Style | None = None

    def tolerance(self, key: str, *values: float) -> float:
        """Return how well the values of a key are known, the worst of them."""
        if key in self.styles:
            style, share = self.styles[key], 1.0
        else:
            style, share = self.general, _CALCULATED
        return share * max(map(style.tolerance, values), default=0.0) if style else 0.0


def printing_of(tree: Map) -> Printing:
    """Return how the numbers of a tree were printed whose spans cover the digits of its numbers."""
    digits: dict[str, list[tuple[int, int]]] = {}
    for key, span in _numbers(tree):
        counted = count_digits(span.source.line(span.line)[span.column - 1 : span.column - 1 + span.length])
        if counted:
            digits.setdefault(key, []).append(counted)
    styles = {key: _style(found) for key, found in sorted(digits.items())}
    return Printing(styles, _style([counted for found in digits.values() for counted in found]))


def _numbers(root: Map) -> Iterator[tuple[str, Span]]:
    """Yield the key and the place of each number; items of a list have the key of the list."""
    waiting: list[tuple[Map | Seq, str]] = [(root, "")]
    while waiting:
        node, key = waiting.pop()
        pairs = list(node.items()) if isinstance(node, Map) else list(enumerate(node))
        for step, value in pairs:
            name = step if isinstance(step, str) else key
            if isinstance(value, (Map, Seq)):
                waiting.append((value, name))
            elif isinstance(value, (int, float)) and not isinstance(value, bool):
                yield name, node.value_spans[step]  # type: ignore[index]


def count_digits(text: str) -> tuple[int, int] | None:
    """Return how many digits a number has, from the first one that is not zero, and how many after the point.

    >>> count_digits("-1.5708"), count_digits("0.0120"), count_digits("7.5437e-05"), count_digits("abc")
    ((5, 4), (2, 3), (5, 9), None)
    """
    found = _NUMBER.fullmatch(text.strip())
    if not found or not (found["whole"] or found["part"]):
        return None
    part = found["part"].rstrip("0")
    power = int((found["power"] or "0")[:6])
    whole = found["whole"] if part else found["whole"].rstrip("0")
    return len((whole + part).lstrip("0")), max(0, len(part) - power)


def _style(found: list[tuple[int, int]]) -> Style | None:
    """Return the style with the fewest digits that explains all numbers; None for exact ones, and for none at all."""
    if not found:
        return None
    for digits in range(_FEWEST, _MOST + 1):
        if all(significant <= digits or decimals <= digits for significant, decimals in found):
            return Style(digits, all(one <= digits for one, _ in found), all(other <= digits for _, other in found))
    return None
