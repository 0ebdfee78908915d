"""The precision of numbers: exact in a description, by the printed digits in a file, and after calculations."""

from __future__ import annotations

import math
import re
from collections.abc import Callable
from typing import NamedTuple

from rosorin_compile.model import Transform
from rosorin_compile.model.geometry import norm
from rosorin_compile.source.numbers import off_by_short, off_by_six, six

# How far the values of a key ("xyz", "rpy", "ixx") may be from the true ones, at most.
Precision = Callable[..., float]

# Rounding between numbers that arithmetic alone has moved: relative to the larger one, and to 1 m or 1 rad.
NOISE = 1e-12
# Rounding of a pose (m, or an entry of a rotation) that a chain of transforms adds up.
POSE_NOISE = 1e-9
# Three coordinates may be off at once; three angles may all turn about one line.
ROOT_THREE, TURNS = 3**0.5, 3.0
# A number with fewer digits than these counts as exact, not as rounded: 0.1 is 0.1.
_FEWEST = 6
# The factor by which a number that was calculated from printed ones is less precise.
_CALCULATED = 4.0
# No angle or entry of a quaternion is larger.
_LARGEST_ANGLE = 4.0

_IN_TEXT = re.compile(r"(?<![\w.])[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?(?![\w.])")


def exact(key: str, *values: float) -> float:  # noqa: ARG001
    """Return the precision of numbers that are known to the last digit."""
    return 0.0


def rounding_precision(length: float, angle: float) -> Precision:
    """Return the precision of numbers that are off by no more than a length (m), angles (rad)."""
    return lambda key, *values: angle if key == "rpy" else length  # noqa: ARG005


def printed_precision(text: str) -> Precision:
    """Return the precision of the numbers of an artifact, by the digits that it was printed with."""
    # Six digits, if ``six`` would shorten none of the numbers.
    long = {float(token) for token in _IN_TEXT.findall(text) if len(token) > _FEWEST}
    is_six = all(float(six(value)) == value for value in long if math.isfinite(value))
    off_by = off_by_six if is_six else off_by_short
    turn = NOISE + _CALCULATED * off_by(_LARGEST_ANGLE)

    def precision(key: str, *values: float) -> float:
        if key == "rpy":
            return turn
        largest = max(map(abs, values), default=0.0)
        return max((off_by(value, largest) for value in values), default=0.0)

    return precision


def join_errors(first: float, second: float) -> float:
    """Return how far two printed numbers may be apart that mean the same.

    Rounded alike they are equal, and neighbours in print are two tolerances apart; rounded differently their tolerances
    add up.
    """
    larger, smaller = max(first, second), min(first, second)
    return larger + min(smaller, larger / 2)


def same_number(first: float, second: float, tolerance: float = NOISE) -> bool:
    """Return True if two numbers differ by no more than a part of the larger one, or of 1."""
    return abs(first - second) <= tolerance * max(1.0, abs(first), abs(second))


class Placed(NamedTuple):
    """A transform and its uncertainty: a length (m) and an angle (rad)."""

    transform: Transform
    length: float = 0.0
    angle: float = 0.0

    def then(self, child: Placed) -> Placed:
        """Return this place followed by another one in it."""
        length = self.length + child.length + self.angle * norm(child.transform.xyz)
        return Placed(self.transform.then(child.transform), length, self.angle + child.angle)

    def inverse(self) -> Placed:
        """Return the way back."""
        length = self.length + self.angle * norm(self.transform.xyz)
        return Placed(self.transform.inverse(), length, self.angle)


HERE = Placed(Transform())
