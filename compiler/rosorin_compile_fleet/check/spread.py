"""How one number is spread over the robots of a fleet, and which of them are far from the others.

The middle is the median and the width the median distance from it (MAD): one robot that is wrong moves neither. Of
normally spread numbers 1.4826 times the MAD is the standard deviation; of few numbers it is too small on average, by
the factors of Croux and Rousseeuw ("Time-efficient algorithms for two highly robust estimators of scale", 1992). An
outlier is five such widths from the median, and five standard deviations of the others from their mean: among few
robots either alone calls every thirtieth fleet wrong that is right, both together one of eighty (8 robots) to one of a
thousand (30 and more).
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Sequence
from statistics import fmean, median
from typing import NamedTuple

SIGMAS = 5.0
FEWEST = 6  # robots; of fewer nobody can say which one is wrong
_OF_NORMAL = 1.4826
_FEW = {2: 1.196, 3: 1.495, 4: 1.363, 5: 1.206, 6: 1.2, 7: 1.14, 8: 1.129, 9: 1.107}
# What arithmetic leaves of two equal numbers, relative.
_SAME = 1e-9
# Where most robots have one and the same number: how far another may be from it before that is an outlier, in widths
# of this. Of other units it is this share of the number.
_STEP = {"m": 1e-3, "rad": math.radians(0.5)}
_SHARE = 0.02
_CALIBRATED = 5  # robots whose number is not that of most: so many have a width of their own
_MOST = 4  # more than one of so many is no outlier
_ALIKE = 20  # more than one of so many that have nearly the same number are a second kind of robots
_SKEWED = 30  # robots: so many that have one sign, all of them, may be spread by factors


class Far(NamedTuple):
    """A robot that is far from the others: its place in the list, and by how many standard deviations (inf: many)."""

    place: int
    sigmas: float


class Spread(NamedTuple):
    """One number over the robots, NaN aside. ``usual`` are the smallest and the largest without those that are far.

    ``width`` is the robust standard deviation; 0 where most have one and the same number.
    """

    robots: int
    smallest: float
    median: float
    largest: float
    width: float
    usual: tuple[float, float]
    far: tuple[Far, ...]


def straight(angles: Sequence[float]) -> list[float]:
    """Return angles (rad) without the step between +pi and -pi: the cut is where the widest gap is.

    >>> [round(angle, 2) for angle in straight([3.1, -3.1, 3.0])]
    [3.1, 3.18, 3.0]
    """
    known = sorted(angle % math.tau for angle in angles if math.isfinite(angle))
    if not known:
        return list(angles)
    gaps = [after - before for before, after in zip(known, [*known[1:], known[0] + math.tau], strict=True)]
    first = known[(gaps.index(max(gaps)) + 1) % len(known)]  # the angle behind the gap
    turned = [first + (angle - first + _SAME) % math.tau - _SAME if math.isfinite(angle) else angle for angle in angles]
    pairs = zip(turned, angles, strict=True)
    rounds = Counter(round((one - angle) / math.tau) for one, angle in pairs if math.isfinite(angle))
    shift = math.tau * max(rounds, key=lambda turns: (rounds[turns], -abs(turns)))  # most stay as they are written
    return [angle - shift for angle in turned]


def spread_of(values: Sequence[float], unit: str = "") -> Spread:
    """Return how numbers are spread, angles that wrap made ``straight`` before; a number that is not there is NaN.

    Raises ValueError where there is none.
    """
    known = [(value, index) for index, value in enumerate(values) if math.isfinite(value)]
    if not known:
        raise ValueError("no robot has the number")
    numbers = [value for value, _ in known]
    middle, smallest, largest = median(numbers), min(numbers), max(numbers)
    width = _width(numbers, middle)
    far = _far(numbers, middle, width, unit) if len(numbers) >= FEWEST else []
    told = tuple(Far(known[at][1], sigmas) for at, sigmas in far)
    others = _without(numbers, [at for at, _ in far])
    return Spread(len(numbers), smallest, middle, largest, width, (min(others), max(others)), told)


def is_same(one: float, other: float) -> bool:
    """Say whether two numbers differ by no more than arithmetic."""
    return abs(one - other) <= _SAME * max(abs(one), abs(other), 1e-6)


def _width(numbers: Sequence[float], middle: float) -> float:
    count = len(numbers)
    apart = median(abs(number - middle) for number in numbers)
    if apart <= _SAME * max(abs(middle), 1e-6):
        return 0.0
    return _OF_NORMAL * apart * (_FEW.get(count) or count / (count - 0.8))


def _far(numbers: Sequence[float], middle: float, width: float, unit: str) -> list[tuple[int, float]]:
    """Return which numbers are far from the others, and by how many standard deviations."""
    exact = not width
    width = width or _step(numbers, middle, unit)
    if not width:
        return []
    candidates = [at for at, number in enumerate(numbers) if abs(number - middle) > SIGMAS * width]
    if not candidates or len(candidates) > max(1, len(numbers) // _MOST):
        return []
    others = _without(numbers, candidates)
    mean = fmean(others)
    deviation = math.sqrt(sum((number - mean) ** 2 for number in others) / (len(others) - 1))
    deviation = max(deviation, width if exact else deviation)
    found = [at for at in candidates if abs(numbers[at] - mean) > SIGMAS * deviation]
    found = [at for at in found if not _is_kind(numbers, at, candidates, width) and _is_far_in_factors(numbers, at)]
    return [(at, math.inf if exact else abs(numbers[at] - middle) / width) for at in found]


def _step(numbers: Sequence[float], middle: float, unit: str) -> float:
    """Return the width where most robots have one and the same number: that of those that have another, if any."""
    apart = [abs(number - middle) for number in numbers if not is_same(number, middle)]
    if len(apart) >= _CALIBRATED:
        return _OF_NORMAL * median(apart)
    return _STEP.get(unit, _SHARE * abs(middle))


def _is_kind(numbers: Sequence[float], at: int, candidates: Sequence[int], width: float) -> bool:
    """Say whether a number is one of several that are alike: another kind of robot, and no typo."""
    alike = sum(abs(numbers[one] - numbers[at]) <= width for one in candidates)
    return alike > max(1, len(numbers) // _ALIKE)


def _is_far_in_factors(numbers: Sequence[float], at: int) -> bool:
    """Say whether a number is far in factors, too, where the numbers may be spread by factors: all have one sign."""
    if len(numbers) < _SKEWED or min(numbers) <= 0 <= max(numbers):
        return True
    logs = [math.log(abs(number)) for number in numbers]
    middle = median(logs)
    width = _width(logs, middle)
    return not width or abs(logs[at] - middle) > SIGMAS * width


def _without(numbers: Sequence[float], left: Sequence[int]) -> list[float]:
    out = set(left)
    return [number for at, number in enumerate(numbers) if at not in out]


# A factor between what was written and what was meant: the words for a length, an angle, anything else.
_FACTORS = (
    (1000.0, "1,000 times that of the others", {"m": "mm where m is meant?", "kg": "g where kg is meant?"}),
    (1e-3, "a thousandth of that of the others", {"m": "m where mm is meant?", "kg": "kg where g is meant?"}),
    (100.0, "100 times that of the others", {"m": "cm where m is meant?"}),
    (0.01, "a hundredth of that of the others", {"m": "m where cm is meant?"}),
    (
        10.0,
        "10 times that of the others",
        {"": "a slip of the decimal point?", "m": "a slip of the decimal point, or cm where mm is meant?"},
    ),
    (0.1, "a tenth of that of the others", {"": "a slip of the decimal point?"}),
    (1 / 0.0254, "39.37 times that of the others", {"m": "inches where m is meant?"}),
    (1 / 25.4, "25.4 times less than that of the others", {"m": "mm where inches are meant?"}),
    (25.4, "25.4 times that of the others", {"m": "inches where mm are meant?"}),
)
_TURN = math.degrees(1)
_OF_ANGLES = (
    (_TURN, "57.3 times that of the others", "degrees where radians are meant?"),
    (1 / _TURN, "57.3 times less than that of the others", "radians where degrees are meant?"),
)
_LEAST, _NEAR = 0.1, 3.0  # widths: what is nearer to the middle than that could be anything, divided
_AROUND = 0.02  # share: how near a number has to be to the one that was meant


class Typo(NamedTuple):
    """What is likely wrong: what can be seen of the number, and the question to whoever wrote it."""

    seen: str
    asked: str


def typo(value: float, middle: float, width: float, unit: str, wraps: bool = False) -> Typo | None:
    """Return what a number that is far from the others looks like; None if like nothing that people mistype."""
    room = max(SIGMAS * width, _AROUND * abs(middle))
    if not middle or SIGMAS * width > 0.3 * abs(middle):
        return (_turned(value, middle, width) if wraps else None) or _around_nothing(value, middle, width, unit)
    if abs(value + middle) <= room and abs(middle) > SIGMAS * width:
        return Typo("that of the others with the other sign", "a sign that is lost, or one too many?")
    if unit == "rad":
        for factor, seen, asked in _OF_ANGLES:
            meant = middle * factor
            close = abs(value - meant) <= room * factor
            if close or (wraps and factor > 1 and abs(_wrapped(value - meant)) <= min(room * factor, 0.3)):
                return Typo(seen if close else "what degrees give, read as radians", asked)
    if wraps and (turned := _turned(value, middle, width)):
        return turned
    for factor, seen, words in _FACTORS:
        if abs(value - middle * factor) <= room * factor:
            return Typo(seen, words.get(unit, words.get("", "another unit, or a slip of the decimal point?")))
    return None


def _around_nothing(value: float, middle: float, width: float, unit: str) -> Typo | None:
    """Return which unit would bring a number among the others, where those are on both sides of zero."""
    for factor, of, asked in ((1000.0, "m", "mm where m is meant?"), (_TURN, "rad", _OF_ANGLES[0][2])):
        if unit == of and _LEAST * width <= abs(value / factor - middle) <= _NEAR * width:
            return Typo(f"among the others if it is divided by {factor:,.3g}", asked)
    return None


def _turned(value: float, middle: float, width: float) -> Typo | None:
    """Return that an angle is a half or a quarter of a turn off."""
    apart, room = abs(_wrapped(value - middle)), max(SIGMAS * width, math.radians(2))
    if room > math.radians(20):
        return None
    if abs(apart - math.pi) <= room:
        return Typo("half a turn from that of the others", "looks it the other way?")
    if abs(apart - math.pi / 2) <= room:
        return Typo("a quarter turn from that of the others", "another convention of axes?")
    return None


def _wrapped(angle: float) -> float:
    return math.pi - (math.pi - angle) % math.tau
