"""Pace: when the messages of one stream came, in statistics whose size does not grow with the recording.

``Leaps`` notices a stream of two sources: it leaps back to where it was shortly before, or has two values at one
stamp.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from .arrays import SECOND, Floats, Times
from .expected import SIX_ANGLE
from .findings import YEAR

BINS = 240
# A stamp that lies further behind the one before it has jumped; less is two messages that overtook each other.
JUMP = SECOND // 10
# No wall clock says less (1973): what does is the clock of a simulation, which begins at zero.
SIMULATED = 10**8 * SECOND


# Stamps and times of arrival that are all farther apart than this (s) are of two clocks.
APART = 60.0


@dataclass
class Gap:
    """How long something was (s), and when it began or was noticed (ns)."""

    seconds: float = 0.0
    began: int = 0


class Bins:
    """How many messages came in each slice of time; slices double in width when the recording outgrows them.

    ``leads`` has the most that a stamp in each slice was ahead of its arrival (s; less than zero is behind it, minus
    infinite where there is none): what is between two clocks, for no message arrives before it is sent.
    """

    def __init__(self, width: int = SECOND // 10) -> None:
        self.start: int | None = None
        self.width = width
        self.counts: Floats = np.zeros(BINS)
        self.leads: Floats = np.full(BINS, -np.inf)

    def add(self, times: Times, stamps: Times, start: int) -> None:
        """Take messages by the times (ns) when they came; ``start`` is the begin of the recording."""
        if self.start is None:
            self.start = start
        since = times - self.start
        while int(since.max()) // self.width >= BINS:
            self.counts = np.concatenate((self.counts.reshape(-1, 2).sum(axis=1), np.zeros(BINS // 2)))
            self.leads = np.concatenate((self.leads.reshape(-1, 2).max(axis=1), np.full(BINS // 2, -np.inf)))
            self.width *= 2
        places = np.clip(since // self.width, 0, BINS - 1)
        self.counts += np.bincount(places, minlength=BINS)
        stamped = stamps != 0
        np.maximum.at(self.leads, places[stamped], (stamps - times)[stamped] / SECOND)

    def at_width(self, width: int) -> Floats:
        """Return the counts in slices of a width that is this one doubled some times."""
        counts, own = self.counts, self.width
        while own < width:
            counts = np.concatenate((counts.reshape(-1, 2).sum(axis=1), np.zeros(BINS // 2)))
            own *= 2
        return counts


# A step of the clock that stamps is looked for in slices of this time (ns), as many on each side of it.
SLICE, SLICES = SECOND // 2, 3
# It is one if it is as large (s); where both sides lie in the past it might be a delay if it is not larger.
STEP, DELAY = 0.25, 5.0
# From here on (s) a stamp that is ahead is no matter of reading two clocks one after the other.
AHEAD = 0.1


class Step(NamedTuple):
    """A step of the clock that stamps: when (ns), and how far ahead of their arrival (s) it dated before and after."""

    time: int
    before: float
    after: float

    @property
    def size(self) -> float:
        """How large it is (s)."""
        return abs(self.after - self.before)


def step_of(bins: Bins) -> Step | None:
    """Return the largest step of the clock that stamps a stream, or from where to where it drifted; None if neither.

    Delays that grow and shrink are no step: both sides have to stand still.
    """
    leads, width = bins.leads, bins.width
    while width < SLICE:
        leads, width = leads.reshape(-1, 2).max(axis=1), width * 2
    places = np.flatnonzero(np.isfinite(leads))
    best = _drift(leads[places], bins.start or 0)
    values = leads[places].tolist()
    for at in range(SLICES, len(values) - SLICES + 1):
        if abs(values[at] - values[at - 1]) < STEP / 2:  # most often
            continue
        before, after = sorted(values[at - SLICES : at]), sorted(values[at : at + SLICES])
        found = Step((bins.start or 0) + int(places[at]) * width, before[SLICES // 2], after[SLICES // 2])
        still = max(before[-1] - before[0], after[-1] - after[0]) < found.size / 4
        large = found.size > (STEP if max(before[-1], after[-1]) > AHEAD else DELAY)
        if still and large and (best is None or found.size > best.size):
            best = found
    return best


def _drift(values: Floats, start: int) -> Step | None:
    """Return from where to where a clock drifted that runs faster or slower; a stamp that stays behind is no drift."""
    if len(values) < 2 * SLICES:
        return None
    at = np.arange(len(values))
    line = np.polyval(np.polyfit(at, values, 1), at)
    found = Step(start, float(line[0]), float(line[-1]))
    even = np.abs(values - line).max() < found.size / 8
    return found if even and found.size > STEP and min(found.before, found.after) > -AHEAD else None


@dataclass
class Pace:
    """Rates, gaps and ages of one stream of messages; all times in ns, ages in s."""

    aged: bool = True  # whether it is known when messages were received
    count: int = 0
    first: int = 0
    last: int = 0
    first_stamp: int = 0
    newest: int = 0  # the newest stamp so far
    gap: Gap = field(default_factory=Gap)
    oldest: Gap = field(default_factory=Gap)  # the oldest that the newest stamp ever was, and when it was
    age_sum: float = 0.0
    most_ahead: float = -math.inf  # the most (s) that a stamp was ahead of its arrival, and the least
    least_ahead: float = math.inf
    zeros: int = 0
    jumps: int = 0
    farthest: Gap = field(default_factory=Gap)  # the farthest jump back of a stamp, and the time when it came
    twice: int = 0  # messages with the stamp of the message before
    steps: Floats = field(default_factory=lambda: np.zeros(5))  # count, sum and squares of steps; the same over two
    bins: Bins = field(default_factory=Bins)
    _tail: Times = field(default_factory=lambda: np.empty((2, 0), np.int64))

    def add(self, received: Times, stamp: Times, start: int) -> None:
        """Take messages in the order of their arrival; ``start`` (ns) is the begin of the recording."""
        if not self.count:
            self.first, self.first_stamp = int(received[0]), int(stamp[0])
        self.count += len(received)
        self.zeros += int(np.count_nonzero(stamp == 0))
        self.bins.add(received, stamp, start)
        self._ages(received, stamp)
        times = np.concatenate((self._tail, np.stack((received, stamp))), axis=1)
        self._gaps(times, len(received))
        self.newest = max(self.newest, int(stamp.max()))
        self.last = int(received[-1])
        self._tail = times[:, -2:]

    def _ages(self, received: Times, stamp: Times) -> None:
        """Take the ages: what a message has when it comes, and what the newest before it had then; zero is no stamp."""
        stamped = stamp != 0
        received, stamp = received[stamped], stamp[stamped]
        if not len(stamp):
            return
        ages = (received - stamp) / SECOND
        self.age_sum += float(ages.sum())
        self.most_ahead = max(self.most_ahead, -float(ages.min()))
        self.least_ahead = min(self.least_ahead, -float(ages.max()))
        before = self.newest if self.newest > 0 else int(stamp[0])
        newest = np.maximum(np.maximum.accumulate(stamp), before)
        known = np.concatenate(([before], newest[:-1]))
        for oldest in (received - known, received - newest):
            at = int(oldest.argmax())
            if oldest[at] / SECOND > self.oldest.seconds:
                self.oldest = Gap(float(oldest[at] / SECOND), int(received[at]))

    def _gaps(self, times: Times, new: int) -> None:
        """Take the steps from message to message; ``times`` (2, n) are received and stamp, the last ``new`` are new."""
        if times.shape[1] < 2:
            return
        one = np.diff(times[:, -(new + 1) :], axis=1)
        at = int(one[0].argmax())
        if one[0, at] / SECOND > self.gap.seconds:
            self.gap = Gap(float(one[0, at] / SECOND), int(times[0, -(new + 1) :][at]))
        self.twice += int(np.count_nonzero((one[1] == 0) & (times[1, -one.shape[1] :] != 0)))
        fall = np.where(times[1, -one.shape[1] :] != 0, -one[1], 0)  # zero is no stamp
        back = int(fall.argmax())
        self.jumps += int(np.count_nonzero(fall > JUMP))
        if fall[back] > JUMP and fall[back] / SECOND > self.farthest.seconds:
            self.farthest = Gap(float(fall[back] / SECOND), int(times[0, -(new + 1) :][back + 1]))
        single = one[1] / SECOND
        double = (times[1, 2:] - times[1, :-2])[-new:] / SECOND
        self.steps += (len(single), single.sum(), (single**2).sum(), double.sum(), (double**2).sum())

    @property
    def unstamped(self) -> bool:
        """Whether messages have no stamp; those that come first in a simulation may be of its time zero."""
        begins = self.first_stamp == 0 and self.newest < SIMULATED and self.zeros <= max(1, self.count // 20)
        return self.zeros > 0 and not begins

    @property
    def rate(self) -> float:
        """Messages a second; NaN of fewer than two."""
        span = self.last - self.first
        return (self.count - 1) * SECOND / span if self.count > 1 and span > 0 else math.nan

    @property
    def mean_age(self) -> float:
        """The mean age (s) of a message when it came; NaN where that is not known."""
        stamped = self.count - self.zeros
        return self.age_sum / stamped if self.aged and stamped else math.nan

    @property
    def other_clock(self) -> bool:
        """Whether all stamps are far from the times of arrival: of another clock.

        A stamp that is sent again and again grows old, too, but it does not go on as time does.
        """
        if not self.aged or self.least_ahead > self.most_ahead:
            return False
        goes_on = self.newest - self.first_stamp > (self.last - self.first) / 2 > 0
        return self.least_ahead > APART or self.most_ahead < -(APART if goes_on else YEAR)

    @property
    def alternates(self) -> bool:
        """Whether steps alternate between short and long while every second message is regular: two clocks, not one.

        The jitter of one clock spreads over two steps as over one; of two clocks in turn, two steps are one period.
        """
        n, sum_one, square_one, sum_two, square_two = (float(value) for value in self.steps)
        if n < 20 or sum_one <= 0:
            return False
        mean = sum_one / n
        spread_one = square_one / n - mean**2
        spread_two = square_two / n - (sum_two / n) ** 2
        return spread_one > (0.15 * mean) ** 2 and spread_two < 0.1 * spread_one

    def oldest_until(self, end: int) -> Gap:
        """Return the oldest that the newest stamp ever was, up to the end (ns) of the recording."""
        rest = (end - self.newest) / SECOND
        return Gap(rest, end) if rest > self.oldest.seconds else self.oldest


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
