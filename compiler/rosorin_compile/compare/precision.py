"""The precision of numbers: in descriptions (exact), in files (by printed digits), and after calculations."""

import math
import re
from collections.abc import Callable
from typing import NamedTuple

from rosorin_compile.model import Transform
from rosorin_compile.model.geometry import norm
from rosorin_compile.source.numbers import off_by_short, off_by_six, six

# A function from a key ("xyz", "rpy", "ixx") and its numbers to the largest error of these numbers.
Precision = Callable[..., float]
Precisions = tuple[Precision, Precision]  # of two compared sides

# Rounding error of floating-point arithmetic, relative to the larger of two numbers (and to 1 m or 1 rad).
NOISE = 1e-12
# Accumulated rounding error of a chain of transforms (m, or an entry of a rotation matrix).
POSE_NOISE = 1e-9
# Factors for the combined error of three coordinates, and of three angles (if all rotate about one line).
ROOT_THREE, TURNS = 3**0.5, 3.0
# A number with fewer characters than this counts as exact, not as rounded: 0.1 is 0.1.
_FEWEST = 6
# The error of a number that is calculated from printed numbers is larger by this factor.
_CALCULATED = 4.0
# No angle (rad) or entry of a quaternion is larger.
_LARGEST_ANGLE = 4.0

_IN_TEXT = re.compile(r"(?<![\w.])[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?(?![\w.])")


def exact(key: str, *values: float) -> float:  # noqa: ARG001
    """Return zero, the precision of exact numbers."""
    return 0.0


def rounding_precision(length: float, angle: float) -> Precision:
    """Return the precision of numbers with a maximum error of ``length`` (m), and ``angle`` (rad) for angles."""
    return lambda key, *values: angle if key == "rpy" else length  # noqa: ARG005


def printed_precision(text: str) -> Precision:
    """Return the precision of the numbers in an artifact, estimated from its printed digits."""
    # The text has six digits if formatting with ``six`` changes none of its numbers.
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
    """Return the largest difference of two printed numbers for the same value, from their largest errors.

    Numbers with equal errors are rounded in the same way. Adjacent printed numbers are two errors apart and must count
    as different, so the result is less than the sum of the errors.
    """
    larger, smaller = max(first, second), min(first, second)
    return larger + min(smaller, larger / 2)


def same_number(first: float, second: float, tolerance: float = NOISE) -> bool:
    """Return True if two numbers differ by at most ``tolerance``, relative to the larger one or to 1."""
    return abs(first - second) <= tolerance * max(1.0, abs(first), abs(second))


class RoundedTransform(NamedTuple):
    """A transform and its uncertainty: a length (m) and an angle (rad)."""

    transform: Transform
    length: float = 0.0
    angle: float = 0.0

    def then(self, child: "RoundedTransform") -> "RoundedTransform":
        """Return this transform followed by ``child``."""
        length = self.length + child.length + self.angle * norm(child.transform.xyz)
        return RoundedTransform(self.transform.then(child.transform), length, self.angle + child.angle)

    def inverse(self) -> "RoundedTransform":
        """Return the inverse transform with its uncertainty."""
        length = self.length + self.angle * norm(self.transform.xyz)
        return RoundedTransform(self.transform.inverse(), length, self.angle)


HERE = RoundedTransform(Transform())
