"""When the messages of a stream arrived and how they were stamped: rates, gaps, ages, clocks, and second sources."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from .expected import SIX_ANGLE
from .findings import YEAR

Floats = NDArray[np.float64]
Times = NDArray[np.int64]
Flags = NDArray[np.bool_]

SECOND = 1_000_000_000
SLICES = 240  # time slices in which a recording is divided
JUMP = SECOND // 10  # a stamp further behind the previous one jumped back; messages may overtake each other by less
SIMULATED = 10**8 * SECOND  # wall clocks show more (1973); simulations begin at zero
APART = 60.0  # stamps and arrivals that are always further apart than this (s) are from two clocks

# A step of the clock is searched in slices of at least 0.8 s, with three slices on each side of it.
_SLICE, _SIDE = 8 * SECOND // 10, 3
# The smallest step (s). If both sides are in the past, a smaller change than DELAY may be a transmission delay.
_STEP, _DELAY = 0.25, 5.0
AHEAD = 0.1  # stamps ahead of their arrival by less (s) are within the accuracy of reading two clocks


class Gap(NamedTuple):
    """A duration in s, and the time in ns when it began or was observed."""

    seconds: float = 0.0
    at: int = 0


class Step(NamedTuple):
    """A step of the clock that stamps: when (ns), and how far ahead of arrival (s) it stamped before and after."""

    time: int
    before: float
    after: float
    size: float


class Pace:
    """Rates, gaps and ages of one stream of messages in order of arrival. Times are ns, ages and gaps s.

    ``start`` is the start of the recording; ``timed`` tells whether arrival times are known.
    """

    def __init__(self, received: Times, stamps: Times, start: int, timed: bool) -> None:
        self.received, self.stamps, self.start, self.timed = received, stamps, start, timed
        self.count = len(received)
        stamped = stamps != 0  # zero means that there is no stamp
        self.zeros = self.count - int(np.count_nonzero(stamped))
        self.first, self.last = (int(received[0]), int(received[-1])) if self.count else (0, 0)
        self.first_stamp = int(stamps[0]) if self.count else 0
        self.newest = int(stamps.max(initial=0))
        span = self.last - self.first
        self.rate = (self.count - 1) * SECOND / span if self.count > 1 and span > 0 else math.nan  # messages a second
        ahead = (stamps - received)[stamped] / SECOND
        self.most_ahead, self.least_ahead = float(ahead.max(initial=-math.inf)), float(ahead.min(initial=math.inf))
        self.mean_age = -float(ahead.mean()) if timed and len(ahead) else math.nan
        self.gap = _longest(np.diff(received), received)
        self.largest_gap = self.gap.seconds if timed else None
        falls = np.where(stamps[1:] != 0, -np.diff(stamps), 0)
        self.jumps = int(np.count_nonzero(falls > JUMP))
        self.farthest_jump = _longest(falls, received[1:])
        self.repeated = int(np.count_nonzero((np.diff(stamps) == 0) & (stamps[1:] != 0)))
        # The age of the newest stamp just before each arrival.
        newest, came = np.maximum.accumulate(stamps[stamped]), received[stamped]
        self.oldest = _longest(came - np.concatenate((newest[:1], newest[:-1])), came)
        # The first messages of a simulation may have its time zero.
        begins = self.first_stamp == 0 and self.newest < SIMULATED and self.zeros <= max(1, self.count // 20)
        self.unstamped = self.zeros > 0 and not begins
        # Of another clock, all stamps are far from their arrival and advance as time does.
        limit = APART if self.newest - self.first_stamp > span / 2 > 0 else YEAR
        self.other_clock = timed and len(ahead) > 0 and (self.least_ahead > APART or self.most_ahead < -limit)

    @property
    def alternates(self) -> bool:
        """Return True if short and long steps alternate while every second message is regular: two sources.

        The jitter of one source spreads over two steps as over one; of two sources, two steps are one period.
        """
        one, two = np.diff(self.stamps) / SECOND, (self.stamps[2:] - self.stamps[:-2]) / SECOND
        if len(one) < 20 or one.sum() <= 0:
            return False
        return bool(one.var() > (0.15 * one.mean()) ** 2 and two.var() < 0.1 * one.var())

    def oldest_until(self, end: int) -> Gap:
        """Return the largest age of the newest stamp up to the end (ns) of the recording."""
        rest = (end - self.newest) / SECOND
        return Gap(rest, end) if rest > self.oldest.seconds else self.oldest

    def slices(self, width: int) -> Times:
        """Return the time slice (n,) in which each message arrived; slices are ``width`` ns wide."""
        return np.asarray(np.clip((self.received - self.start) // width, 0, SLICES - 1), np.int64)

    @cached_property
    def step(self) -> Step | None:
        """The largest step of the clock that stamps, or from where to where it drifted; None for neither.

        The lead of a slice is the most that a stamp was ahead of its arrival; no message arrives before it is sent.
        Growing delays are not a step: the leads on both sides of it have to be steady.
        """
        width = slice_width(int(self.received.max(initial=self.start)) - self.start, _SLICE)
        leads = np.full(SLICES, -np.inf)
        stamped = self.stamps != 0
        np.maximum.at(leads, self.slices(width)[stamped], (self.stamps - self.received)[stamped] / SECOND)
        places = np.flatnonzero(np.isfinite(leads))
        best = _drift(leads[places], self.start)
        values = leads[places].tolist()
        for at in range(_SIDE, len(values) - _SIDE + 1):
            before, after = sorted(values[at - _SIDE : at]), sorted(values[at : at + _SIDE])
            low, high = before[_SIDE // 2], after[_SIDE // 2]
            step = Step(self.start + int(places[at]) * width, low, high, abs(high - low))
            steady = max(before[-1] - before[0], after[-1] - after[0]) < step.size / 4
            large = step.size > (_STEP if max(before[-1], after[-1]) > AHEAD else _DELAY)
            if steady and large and (best is None or step.size > best.size):
                best = step
        return best


def slice_width(span: int, width: int = SECOND // 10) -> int:
    """Return the width (ns) of the slices of a recording that is ``span`` ns long: at least ``width``."""
    while span // width >= SLICES:
        width *= 2
    return width


def _longest(spans: Times, times: Times) -> Gap:
    """Return the longest of some time spans (ns) if it is positive, and the time at the same index."""
    at = int(spans.argmax()) if len(spans) else 0
    return Gap(float(spans[at] / SECOND), int(times[at])) if len(spans) and spans[at] > 0 else Gap()


def _drift(leads: Floats, start: int) -> Step | None:
    """Return the first and last lead of a clock that runs too fast or too slow; growing delays are not a drift."""
    if len(leads) < 2 * _SIDE:
        return None
    at = np.arange(len(leads))
    line = np.polyval(np.polyfit(at, leads, 1), at)
    step = Step(start, float(line[0]), float(line[-1]), float(abs(line[-1] - line[0])))
    even = np.abs(leads - line).max() < step.size / 8
    return step if even and step.size > _STEP and min(step.before, step.after) > -AHEAD else None


_LOOK_BACK = 6
LEAP = 5e-3  # a value that leaps by this (m or rad) and returns to an earlier one came from another source
# A stream has two sources if at least this share of steps, and of leaps, and this number lead back.
_SHARE, _RETURNING, _FEWEST = 0.2, 0.45, 4
_FEWEST_REPEATED = 3

Distance = Callable[[Floats, Floats], Floats]


def largest_difference(one: Floats, other: Floats) -> Floats:
    """Return the largest difference (n,) between the numbers of rows (n, k)."""
    return np.asarray(np.abs(one - other).max(axis=1), np.float64)


class Leaps:
    """Leaps of a stream back to where it was shortly before, and different values with the same stamp.

    ``values`` (n, k) are in order of arrival; ``distance`` compares two rows, ``leap`` is the smallest leap.
    """

    def __init__(
        self, stamps: Times, values: Floats, distance: Distance = largest_difference, leap: float = LEAP
    ) -> None:
        self.steps = max(1, len(stamps) - 1)
        self.pair: tuple[Floats, Floats] | None = None
        self.leaps = self.returns = self.contradictions = 0
        self.contradict, self.two, self.largest = False, False, 0.0
        if len(stamps) < 2:
            return
        far = distance(values[1:], values[:-1])
        again = np.flatnonzero((np.diff(stamps) == 0) & (stamps[1:] != 0) & (far > 2 * SIX_ANGLE)) + 1
        leaping = np.flatnonzero(far > leap) + 1
        back = np.full(len(leaping), np.inf)
        for lag in range(2, _LOOK_BACK + 1):
            lands = distance(values[leaping], values[np.maximum(leaping - lag, 0)])
            back = np.minimum(back, np.where(leaping >= lag, lands, np.inf))
        returned = leaping[back < 0.1 * far[leaping - 1]]
        self.contradictions, self.leaps, self.returns = len(again), len(leaping), len(returned)
        self.largest = float(far[returned - 1].max(initial=0.0))
        if len(again) or len(returned):
            first = int(min([*again[:1], *returned[:1]]))
            self.pair = (values[first - 1], values[first])
        self.contradict = self.contradictions >= _FEWEST_REPEATED  # stamps often occur with two values
        returns = self.returns >= _FEWEST and self.returns > max(_SHARE * self.steps, _RETURNING * self.leaps)
        self.two = self.contradict or returns  # the stream seems to have two sources with different values
