"""Magnitudes: which numbers of somebody else's robot were meant in degrees or in millimetres.

A number beyond a full turn, or beyond any robot, is no ground by itself: wrists turn by 400 degrees (6.98 rad), legs
are given 10 rad, "no limit" is written as 999999 or 1e16, and a plane is 200 m long. Degrees are round numbers, and
those of the joints around them are too; millimetres are everywhere in a drawing that is in millimetres.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from rosorin_compile.rules.magnitudes import FAR, FULL_TURN
from rosorin_compile.source.diagnostics import WARNING, Diagnostic, Span
from rosorin_compile.source.wording import and_more

# Where a number stands: in an <origin>, in a limit of a joint, or as the size of a shape.
ORIGIN, LIMIT, SIZE = "origin", "limit", "size"

_LEAST, _MOST = 15.0, 721.0  # degrees: what somebody writes who thinks in them
_LOW = 5.0  # degrees: no joint is given less, but for zero
# 20 rad is the most of 600 public robots, but for what means "no limit"; 31 degrees are no limit that many joints have.
_MANY_TURNS = 31.0  # rad
_NEAR = 0.06  # degrees: 89.95 is 1.57 rad
_SMALL = 1.0  # m: most lengths of a robot are below


class _Found(NamedTuple):
    """A number (rad or m), where it stands, what it is in words, and its place."""

    value: float
    where: str
    what: str
    span: Span


class Magnitudes:
    """The angles and lengths of one file, zero left aside; says which of them are in another unit."""

    def __init__(self) -> None:
        self.types: set[str] = set()  # of the joints
        self._angles: list[_Found] = []
        self._lengths: list[_Found] = []

    def take(self, unit: str, value: float, where: str, what: str, span: Span) -> None:
        """Take down an angle (``unit`` rad) or a length (m)."""
        if value:
            (self._angles if unit == "rad" else self._lengths).append(_Found(value, where, what, span))

    def diagnostics(self) -> list[Diagnostic]:
        """Return what there is to say, one warning a unit."""
        limits = self._limits_in_degrees()
        degrees = [one for one in self._angles if FULL_TURN < abs(one.value) < _MOST and _is_degrees(one, limits)]
        far = [one for one in self._lengths if abs(one.value) > FAR]
        # What does not move is a room or a plane; what has no joint at all can be any thing.
        if not (self.types - {"fixed"} and self._all_large()):
            far = [one for one in far if one.where == ORIGIN and self.types]
        said = [_warning("angle-looks-like-degrees", degrees, "more than a full turn", "degrees", "rad")]
        said.append(_warning("length-looks-like-millimetres", far, "larger than any robot", "millimetres", "m"))
        return [one for one in said if one is not None]

    def _limits_in_degrees(self) -> bool:
        """Say whether all limits are round and not all the same, as in a robot that is in degrees."""
        sizes = {abs(one.value) for one in self._angles if one.where == LIMIT}
        even = all(size >= _LOW and _near(size, 0.5) for size in sizes)
        return len(sizes) > 1 and even and any(_is_round(size) and not _means_none(size) for size in sizes)

    def _all_large(self) -> bool:
        """Say whether most lengths are large, as in a drawing in millimetres."""
        sizes = sorted(abs(one.value) for one in self._lengths if one.where != LIMIT)
        return bool(sizes) and sizes[len(sizes) // 2] > _SMALL


def _is_degrees(found: _Found, limits: bool) -> bool:
    """Say whether an angle beyond a full turn is in degrees; ``limits`` says that all limits seem to be."""
    size = abs(found.value)
    if found.where == ORIGIN:
        return _is_round(size)
    return limits or (size < 360 + _NEAR and (_near(size, 45) or (size > _MANY_TURNS and not _stands_for_many(size))))


def _is_round(size: float) -> bool:
    """Say whether somebody who thinks in degrees would write this angle."""
    return _LEAST - _NEAR < size < _MOST and _near(size, 5)


def _stands_for_many(size: float) -> bool:
    """Say whether somebody writes this limit who means many turns: 1, 2 or 5 of a power of ten, or full turns."""
    digits = size / 10 ** math.floor(math.log10(size))
    turns = size / math.tau
    return any(math.isclose(digits, one) for one in (1, 2, 5)) or abs(turns - round(turns)) < 1e-2


def _means_none(size: float) -> bool:
    """Say whether a limit is a power of ten, which is how "no limit" is written."""
    return math.isclose(math.log10(size) % 1, 0, abs_tol=1e-9)


def _near(value: float, step: float) -> bool:
    return abs(value - round(value / step) * step) < _NEAR


def _warning(rule: str, found: list[_Found], limit: str, other: str, unit: str) -> Diagnostic | None:
    if not found:
        return None
    more = f",{and_more(len(found) - 1)}" if len(found) > 1 else ""
    message = f"{found[0].what}, {limit}: this looks like {other}{more}"
    help = f"it is kept as it is, in {unit}; if it is wrong, correct it in the source"
    return Diagnostic(rule, WARNING, message, found[0].span, (), help)
