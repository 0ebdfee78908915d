"""Coordinates: joints of two robots that move the same way and count their positions otherwise."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import NamedTuple

from ..model import Joint
from .states import span_of
from .values import JOINT, Item
from .wording import number, row

_ALIKE = 1e-6
# How finely a shift of zero that follows from limits is looked for (rad, m).
_LEAST = 1e-6


class Coordinate(NamedTuple):
    """How a joint of B counts: its position is ``sign`` times that of A, plus ``shift`` (rad or m)."""

    joint: str
    sign: int
    shift: float
    same_limits: bool
    axes: tuple[str, str]

    def of(self, position: float) -> float:
        """Return the position in B of a position in A."""
        return self.sign * position + self.shift

    def item(self) -> Item:
        """Return the difference in words."""
        limits = "its limits follow" if self.same_limits else "its limits do not follow"
        if self.sign < 0:
            turned = f"axis {self.axes[0]} -> {self.axes[1]}"
            shift = f", zero is shifted by {number(self.shift)}" if self.shift else ""
            text = f"{self.joint} counts the other way round: {turned}{shift}; {limits}"
        else:
            sign = "-" if self.shift < 0 else "+"
            shift = f"position in B = position in A {sign} {number(abs(self.shift))}"
            text = f"{self.joint} counts from another zero: {shift}; {limits}"
        return Item(JOINT, self.joint, "coordinate", text, self.axes[0], self.axes[1], when="always")


Coordinates = Mapping[str, Coordinate]


def coordinate_of(joint: Joint, twin: Joint, fits: Callable[[Coordinate | None], bool]) -> Coordinate | None:
    """Return how a joint of B counts, if it counts otherwise and moves the same way; None if not.

    ``fits`` says whether what hangs on the joint is in its place if B counts so. A shift of zero is taken for one only
    if the limits are shifted, too: otherwise the joint was turned.
    """
    if not joint.moves or fits(None):
        return None
    axes = row(joint.axis), row(twin.axis)
    for sign in (-1, 1):
        for shift in [0.0] * (sign < 0) + _shifts(joint, twin, sign):
            same = _follows(joint, twin, sign, shift)
            trial = Coordinate(joint.name, sign, shift, same, axes)
            if (same or not shift) and fits(trial):
                return trial
    return None


def _bounds(joint: Joint) -> tuple[float, float] | None:
    limit = joint.limit
    if limit is None or limit.lower is None or limit.upper is None:
        return None
    return limit.lower, limit.upper


def _shifts(joint: Joint, twin: Joint, sign: int) -> list[float]:
    """Return the shift of zero that limits would say; none without limits."""
    mine, theirs = _bounds(joint), _bounds(twin)
    if joint.type == "continuous" or mine is None or theirs is None:
        return []
    shift = theirs[0] - (mine[0] if sign > 0 else -mine[1])
    return [shift] if abs(shift) > _LEAST else []


def _follows(joint: Joint, twin: Joint, sign: int, shift: float) -> bool:
    """Say whether the limits of a joint of B are those of A in B's coordinate."""
    mine, theirs = _bounds(joint), _bounds(twin)
    if mine is None or theirs is None or joint.type == "continuous":
        return mine is None and theirs is None
    low, high = sorted((sign * mine[0] + shift, sign * mine[1] + shift))
    room = _ALIKE * max(1.0, *map(abs, span_of(joint)))
    return math.isclose(low, theirs[0], abs_tol=room) and math.isclose(high, theirs[1], abs_tol=room)
