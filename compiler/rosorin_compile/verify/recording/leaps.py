"""Leaps: a stream that leaps back to where it was shortly before, or has two values at one stamp, has two sources."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from ..arrays import Floats, Times
from ..expected import SIX_ANGLE

LOOK_BACK = 6
# A value that leaps by this (m, or rad) and lands where an earlier one was came from another source.
LEAP = 5e-3
# From this share of leaps on, and so many, a stream is told to have two sources.
SHARE, FEWEST, FEWEST_TWICE = 0.2, 4, 3
# From this share of the leaps on that lead back; of a source that is noisy few happen to.
BACK = 0.45

Apart = Callable[[Floats, Floats], Floats]


def apart(one: Floats, other: Floats) -> Floats:
    """Return how far rows (n, k) are apart: the largest difference of a number."""
    return np.asarray(np.abs(one - other).max(axis=1), np.float64)


class Leaps:
    """Counts what tells of two sources. ``apart`` says how far two rows are apart, ``leap`` what is no trembling."""

    def __init__(self, apart: Apart = apart, leap: float = LEAP) -> None:
        self.apart, self.leap = apart, leap
        self.leaps = 0
        self.count = 0
        self.returns = 0  # leaps back to where the stream was shortly before
        self.largest = 0.0
        self.twice_different = 0  # two values at one stamp
        self.pair: tuple[Floats, Floats] | None = None
        self._stamps: Times = np.empty(0, np.int64)
        self._values: Floats | None = None

    @property
    def steps(self) -> int:
        """How many steps from one value to the next there were."""
        return max(1, self.count - 1)

    @property
    def two(self) -> bool:
        """Whether the stream seems to have two sources with different values."""
        returns = self.returns >= FEWEST and self.returns > max(SHARE * self.steps, BACK * self.leaps)
        return self.twice_different >= FEWEST_TWICE or returns

    def add(self, stamps: Times, values: Floats) -> None:
        """Take values (n, k) in the order of their arrival."""
        before = len(self._stamps)
        if self._values is not None:
            stamps, values = np.concatenate((self._stamps, stamps)), np.concatenate((self._values, values))
        self.count += len(stamps) - before
        self._stamps, self._values = stamps[-LOOK_BACK:], values[-LOOK_BACK:]
        at = np.arange(max(1, before), len(stamps))
        if len(at):
            self._steps(stamps, values, at)

    def _steps(self, stamps: Times, values: Floats, at: Times) -> None:
        far = self.apart(values[at], values[at - 1])
        again = (stamps[at] == stamps[at - 1]) & (stamps[at] != 0) & (far > 2 * SIX_ANGLE)
        self.twice_different += int(np.count_nonzero(again))
        leaping, far = at[far > self.leap], far[far > self.leap]
        self.leaps += len(leaping)
        back = np.full(len(leaping), np.inf)
        for lag in range(2, LOOK_BACK + 1):
            lands = self.apart(values[leaping], values[np.maximum(leaping - lag, 0)])
            back = np.minimum(back, np.where(leaping >= lag, lands, np.inf))
        returned = back < 0.1 * far
        self.returns += int(np.count_nonzero(returned))
        self.largest = max(self.largest, float(far[returned].max(initial=0.0)))
        both = np.concatenate((at[again], leaping[returned]))
        if len(both) and self.pair is None:
            one = int(both.min())
            self.pair = (values[one - 1], values[one])
