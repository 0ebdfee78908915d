"""Estimate the largest errors of numbers: rounding of printed digits and calculations; numbers in YAML are exact."""

import math
import re
from collections.abc import Callable
from typing import NamedTuple

from rosorin_compile.model import Transform
from rosorin_compile.model.geometry import norm
from rosorin_compile.source.numbers import off_by_short, off_by_six, six

# A function that returns the largest error of the numbers of a key: precision("xyz", 0.1, 0.2, 0.3).
Precision = Callable[..., float]
Precisions = tuple[Precision, Precision]  # for the old and for the new numbers

# Rounding error of floating-point arithmetic, relative to the larger of two numbers, or to 1 if that is larger.
NOISE = 1e-12
# Accumulated rounding error of a chain of transforms (m, or an entry of a rotation matrix).
POSE_NOISE = 1e-9
# Factors from the error of a single number to that of a position (three coordinates) or rotation (three angles).
ROOT_THREE, TURNS = 3**0.5, 3.0
# Numbers with at most this many characters do not show how many digits are printed: 0.1 can be exact.
_FEWEST = 6
# The error of a number that is calculated from printed numbers is larger by this factor.
_CALCULATED = 4.0
# Upper bound of angles (rad) and of entries of quaternions.
_LARGEST_ANGLE = 4.0

_IN_TEXT = re.compile(r"(?<![\w.])[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?(?![\w.])")


def exact(key: str, *values: float) -> float:  # noqa: ARG001
    """Return zero, the error of exact numbers, as a ``Precision`` function."""
    return 0.0


def rounding_precision(length: float, angle: float) -> Precision:
    """Return a ``Precision`` with the error ``angle`` (rad) for Euler angles ("rpy"), else ``length`` (m)."""
    return lambda key, *values: angle if key == "rpy" else length  # noqa: ARG005


def printed_precision(text: str) -> Precision:
    """Return a ``Precision`` for the numbers in an artifact, estimated from its printed digits."""
    # If rounding to six digits changes no number of the text, all were printed with six digits.
    long = (float(found[0]) for found in _IN_TEXT.finditer(text) if len(found[0]) > _FEWEST)
    off_by = off_by_six if all(float(six(one)) == one for one in long if math.isfinite(one)) else off_by_short
    turn = NOISE + _CALCULATED * off_by(_LARGEST_ANGLE)

    def precision(key: str, *values: float) -> float:
        if key == "rpy":
            return turn
        largest = max(map(abs, values), default=0.0)
        return max((off_by(value, largest) for value in values), default=0.0)

    return precision


def join_errors(first: float, second: float) -> float:
    """Return the largest difference between two printed numbers for the same value, given the error of each.

    Equal errors mean that both numbers are rounded in the same way. Then adjacent printed numbers, which are two errors
    apart, must count as different, so the result is less than the sum of the errors.
    """
    larger, smaller = max(first, second), min(first, second)
    return larger + min(smaller, larger / 2)


class RoundedTransform(NamedTuple):
    """A transform with its largest errors: ``length`` (m) for the position, ``angle`` (rad) for the rotation."""

    transform: Transform
    length: float = 0.0
    angle: float = 0.0

    def then(self, child: "RoundedTransform") -> "RoundedTransform":
        """Return this transform followed by ``child``, with the sum of their errors."""
        length = self.length + child.length + self.angle * norm(child.transform.xyz)
        return RoundedTransform(self.transform.then(child.transform), length, self.angle + child.angle)

    def inverse(self) -> "RoundedTransform":
        """Return the inverse transform with its errors."""
        length = self.length + self.angle * norm(self.transform.xyz)
        return RoundedTransform(self.transform.inverse(), length, self.angle)


HERE = RoundedTransform(Transform())
