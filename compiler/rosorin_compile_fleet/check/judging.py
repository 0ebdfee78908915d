"""What the numbers of a fleet say: which come from which argument, and which robot is far from the others.

A number that follows an argument (it is the argument times a factor plus something, in all robots) is told with the
argument, and so is what is wrong with it: one typo is one warning, however many artifacts show it.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import combinations, pairwise
from typing import NamedTuple

from rosorin_compile import Fact, Value
from rosorin_compile.diagnostics import WARNING, Diagnostic, Heading, Progress, Related, Rule, Span, counted, listed

from .columns import ARGUMENT, Column, Columns
from .spread import Spread, Typo, is_same, spread_of, straight, typo

RULES = (
    Rule(
        "fleet-outlier",
        "A warning: a number of a robot is five standard deviations or more from that of the others, measured by their "
        "median and the median distance from it; or most robots have one and the same, and this one another.",
        "Look it up where it was measured. If it is right, the robot is another kind of robot.",
        Heading.FLEETS,
    ),
)

MOST_FAR = 2_000  # robots with a number that is far
_TRIED = 6  # robots at which it is seen first whether a number follows another
_NAMED = 3
_COUNTED = 10_000  # standard deviations: more is said by the numbers themselves
_AXES = re.compile(r"(?<![A-Za-z0-9])([xyz]|roll|pitch|yaw)(?![A-Za-z0-9])|\[([0-5])\]$")
_SHAPE = re.compile(r"(collision|visual) \d|box ")
_THINGS = ("frame", "joint", "link")
# How a unit is shown, and from which size on it is left.
_SHOWN = {"m": ("mm", 1e3, 1.0), "rad": ("deg", math.degrees(1), math.inf), "kg": ("g", 1e3, 1.0)}


@dataclass
class Row:
    """A number that differs between robots: an argument, or a fact of artifacts that follows none.

    ``values`` are those of the robots that are kept, ``spread`` says how they lie. ``follow`` are the facts that come
    with it.
    """

    fact: Fact
    unit: str
    values: list[float]
    extremes: list[tuple[int, float]]
    files: tuple[str, ...]
    wraps: bool = False
    tolerance: float = 0.0
    follow: list[Column] = field(default_factory=list)
    spread: Spread = field(init=False)
    far: list[Far] = field(default_factory=list)

    def __post_init__(self) -> None:
        self.judge()

    def judge(self) -> None:
        """Say how the values lie."""
        self.spread = spread_of(self.lined_up(), self.unit)

    def lined_up(self) -> list[float]:
        """Return the values, then those of the extremes, angles without the step at half a turn."""
        every = [*self.values, *(value for _, value in self.extremes)]
        return straight(every) if self.wraps else every

    @property
    def label(self) -> str:
        """What the number is called."""
        return self.fact.name if self.fact.kind == ARGUMENT else str(self.fact.about)

    @property
    def is_argument(self) -> bool:
        """Whether it is one that the sweep was given."""
        return self.fact.kind == ARGUMENT

    @property
    def frame(self) -> str:
        """The frame or joint at which it is to be seen; empty if there is none."""
        facts = [self.fact, *(column.fact for column in self.follow)]
        return next((fact.name for fact in facts if fact.kind in _THINGS), "")

    def shown(self, value: float) -> str:
        """Return a value in the unit in which people say it, with as many digits as tell robots from each other."""
        return f"{self.bare(value)} {self.said_in}".rstrip()

    @property
    def said_in(self) -> str:
        """The unit in which people say it: mm, deg and g where the number is small."""
        return self._unit[0]

    def bare(self, value: float) -> str:
        """Return a value without its unit."""
        value *= self._unit[1]
        low, high = self.spread.usual
        fine = (self.spread.width or (high - low)) * self._unit[1]
        if not fine:
            return Value(value).shown()
        digits = min(max(1 - math.floor(math.log10(fine)), 0), 9)
        return f"{value:,.{digits}f}" if abs(value) < 1e9 and digits < 7 else Value(value).shown()

    @property
    def _unit(self) -> tuple[str, float]:
        unit, factor, end = _SHOWN.get(self.unit, (self.unit, 1.0, math.inf))
        return (unit, factor) if max(map(abs, self.spread.usual)) < end else (self.unit, 1.0)


class Far(NamedTuple):
    """A number of one robot that is far from that of the others."""

    row: Row
    value: float
    sigmas: float
    looks: Typo | None


def rows_of(columns: Columns) -> list[Row]:
    """Return the numbers that differ: arguments first, then what follows none of them."""
    every = list(columns.columns())
    arguments = [_row(column) for column in every if column.fact.kind == ARGUMENT]
    others = []
    for at, column in enumerate(every):
        Progress.step("comparing numbers", at, len(every))
        if column.fact.kind == ARGUMENT:
            continue
        cause = _cause(column, arguments)
        if cause is None:
            others.append(column)
        else:
            cause.follow.append(column)
    for row in arguments:
        _take_unit(row)
    return arguments + _together(others)


def far_of(rows: Sequence[Row], drawn: Sequence[int]) -> dict[int, list[Far]]:
    """Return the numbers that are far from those of the others, by robot; each row has its own, too."""
    found: dict[int, list[Far]] = {}
    uncertain = {row.fact.name for row in rows if row.fact.quantity.endswith(" shapes")}
    for row in rows:
        if row.fact.kind == "link" and row.fact.name in uncertain and _SHAPE.match(row.fact.quantity):
            continue
        lined = row.lined_up()
        raw = [*row.values, *(value for _, value in row.extremes)]
        for index, sigmas in row.spread.far:
            robot = drawn[index] if index < len(drawn) else row.extremes[index - len(drawn)][0]
            looks = typo(raw[index], row.spread.median, row.spread.width, row.unit, row.wraps)
            looks = looks or typo(lined[index], row.spread.median, row.spread.width, row.unit, row.wraps)
            far = Far(row, raw[index], sigmas, looks)
            row.far.append(far)
            if robot in found or len(found) < MOST_FAR:
                found.setdefault(robot, []).append(far)
    return found


def _row(column: Column) -> Row:
    wraps = column.unit == "rad" and _is_turn(column.fact)
    return Row(column.fact, column.unit, column.values, column.extremes, column.files, wraps, column.tolerance)


def _is_turn(fact: Fact) -> bool:
    return fact._replace(quantity=fact.quantity.split(" ")[-1]).is_angle or fact.quantity.startswith("turn ")


def _take_unit(row: Row) -> None:
    """Give an argument without a unit that of what it is the value of; an angle of a frame wraps."""
    same = [column for column in row.follow if abs(abs(_slope(row.values, column.values)) - 1) < 1e-6]
    if not row.unit:
        row.unit = next((column.unit for column in same if column.unit), "")
    row.wraps = row.unit == "rad" and any(_is_turn(column.fact) for column in same)
    row.judge()


def _slope(of: Sequence[float], values: Sequence[float]) -> float:
    """Return how much a number changes with another one, between two robots that are near each other in neither end."""
    known = sorted((a, b) for a, b in zip(of, values, strict=True) if math.isfinite(a) and math.isfinite(b))
    steps = [(b[1] - a[1]) / (b[0] - a[0]) for a, b in pairwise(known) if not is_same(a[0], b[0])]
    return sorted(steps, key=abs)[len(steps) // 2] if steps else 0.0


def _cause(column: Column, arguments: Sequence[Row]) -> Row | None:
    """Return the argument that a number follows; of several the one that it is equal to."""
    best: tuple[int, Row] | None = None
    for row in arguments:
        line = _line(row.values, column)
        if line is None:
            continue
        slope, start = line
        rank = (abs(abs(slope) - 1) > 1e-6) + (abs(start) > 1e-9)
        if best is None or rank < best[0]:
            best = (rank, row)
    return best[1] if best else None


def _line(of: Sequence[float], column: Column) -> tuple[float, float] | None:
    """Return factor and summand by which a number follows another one in all robots; None if it does not."""
    values = column.values
    known = [at for at, a in enumerate(of) if math.isfinite(a)]
    if len(known) < 2 or any(math.isfinite(values[at]) != math.isfinite(of[at]) for at in range(len(of))):
        return None
    first = known[0]
    last = max(known, key=lambda at: abs(of[at] - of[first]))
    if is_same(of[last], of[first]):
        return None
    wraps = column.unit == "rad" and _is_turn(column.fact)
    slopes = [(values[last] - values[first]) / (of[last] - of[first])]
    slopes += [1.0, -1.0] if wraps else []  # where the number has gone round, two robots do not tell
    for slope in slopes:
        start = values[first] - slope * of[first]
        if _fits(of, column, known[:_TRIED], slope, start, wraps) and _fits(of, column, known, slope, start, wraps):
            return slope, start
    return None


def _fits(of: Sequence[float], column: Column, robots: Iterable[int], slope: float, start: float, wraps: bool) -> bool:
    for at in robots:
        value = column.values[at]
        apart = value - (slope * of[at] + start)
        if wraps:
            apart = math.remainder(apart, math.tau)
        room = 1e-9 * max(abs(value), abs(slope * of[at]), 1e-3)
        if column.tolerance:
            room += 2 * column.tolerance + 2e-6 * abs(value)
        if abs(apart) > room:
            return False
    return True


def _together(columns: Sequence[Column]) -> list[Row]:
    """Return numbers that follow no argument as rows; what follows another one of them stands with it."""
    found: dict[object, list[Row]] = {}
    rows: list[Row] = []
    for column in sorted(columns, key=lambda column: _order(column.fact)):
        key = _signature(column.values)
        for row in found.get(key, ()):
            if _line(row.values, column) is not None:
                row.follow.append(column)
                break
        else:
            rows.append(_row(column))
            found.setdefault(key, []).append(rows[-1])
    return rows


def _order(fact: Fact) -> int:
    place = _THINGS.index(fact.kind) if fact.kind in _THINGS else len(_THINGS)
    return place + 4 * bool(_SHAPE.match(fact.quantity))


def _signature(values: Sequence[float]) -> object:
    """Return what is the same of two numbers of which one follows the other, to find those quickly."""
    known = [at for at, value in enumerate(values) if math.isfinite(value)]
    first = known[0]
    last = max(known, key=lambda at: abs(values[at] - values[first]))
    step = values[last] - values[first]
    steps = (round((values[at] - values[first]) / step, 3) for at in known[1:_TRIED]) if step else ()
    return (first, len(known), *steps)


def outliers(robot: str, far: Sequence[Far], places: Mapping[str, Span]) -> list[Diagnostic]:
    """Return what there is to say of the numbers of one robot that are far: each cause once.

    ``places`` are those of the arguments, by the name of the argument; "" is that of the robot.
    """
    swapped = _swapped(far)
    told = [_swap(robot, *pair, places) for pair in swapped]
    left = [one for one in far if not any(one is other for pair in swapped for other in pair)]
    others = [one for one in left if not one.row.is_argument]
    # What gives no number, such as a serial number, may be as it likes.
    arguments = [one for one in left if one.row.is_argument and (one.row.follow or others)]
    if arguments:
        told += [_outlier(robot, one, [] if at else others, places) for at, one in enumerate(arguments)]
    elif others and not told:
        things: dict[str, list[Far]] = {}
        for one in others:
            leads = one.row.fact.kind in ("frame", "joint")
            things.setdefault(one.row.fact.name if leads else "", []).append(one)
        rest = things.pop("", []) if len(things) > 1 else []
        for group in things.values():
            told.append(_outlier(robot, group[0], [*group[1:], *rest], places))
            rest = []
    return told


def _outlier(robot: str, far: Far, others: Sequence[Far], places: Mapping[str, Span]) -> Diagnostic:
    row, spread = far.row, far.row.spread
    value = row.shown(far.value)
    low, high = spread.usual
    middle = row.shown(spread.median)
    range_of = (
        f"the others {row.bare(low)} to {row.shown(high)}, median {middle}" if low < high else f"all others {middle}"
    )
    if far.looks is not None:
        message = f"{robot}: {row.label} is {value}, {far.looks.seen} ({range_of})"
        help = far.looks.asked
    else:
        apart = f", {far.sigmas:,.0f} sigma from the others" if far.sigmas < _COUNTED else ""
        message = f"{robot}: {row.label} is {value}{apart} ({range_of})"
        help = "a typo? look it up where it was measured"
    related = [Related(line, None) for line in (_follows(row), _with_it(others)) if line]
    span = places.get(row.fact.name if row.is_argument else "", places.get(""))
    numbers = (("value", far.value), ("median", spread.median), ("width", spread.width), ("unit", row.unit))
    return Diagnostic("fleet-outlier", WARNING, message, span, tuple(related), help, (robot, row.label), numbers)


def _follows(row: Row) -> str:
    """Return what a number places, and which artifacts show it."""
    facts = [str(column.fact.about) for column in row.follow]
    files = list(dict.fromkeys([*row.files, *(file for column in row.follow for file in column.files)]))
    shown = f"in {listed(files, _NAMED)}" if files else ""
    return f"it gives {listed(facts, _NAMED)}, {shown}" if facts and shown else f"it is {shown}" if shown else ""


def _with_it(others: Sequence[Far]) -> str:
    names = listed((one.row.label for one in others), _NAMED)
    return f"and with it {counted(len(others), 'number')} of this robot: {names}" if others else ""


def _swapped(far: Sequence[Far]) -> list[tuple[Far, Far]]:
    """Return pairs of numbers of one robot that are each what the other one should be: x and y."""
    found: list[tuple[Far, Far]] = []
    for one, other in combinations(far, 2):
        alike = _family(one.row) == _family(other.row) != "" and one.row.unit == other.row.unit
        taken = any(one is told or other is told for pair in found for told in pair)
        if alike and not taken and _is_usual(one.value, other.row) and _is_usual(other.value, one.row):
            found.append((one, other))
    return found


def _family(row: Row) -> str:
    """Return what numbers have in common that differ in their axis alone; empty for one that has none."""
    text = f"{row.fact.kind} {row.fact.name} {row.fact.quantity}".strip()
    parts = re.sub(_AXES, "*", text.replace("_", " "))
    return parts if parts != text.replace("_", " ") else ""


def _is_usual(value: float, row: Row) -> bool:
    low, high = row.spread.usual
    room = max(5 * row.spread.width, (high - low) / 2, 0.02 * abs(row.spread.median))
    return low - room <= value <= high + room


def _swap(robot: str, one: Far, other: Far, places: Mapping[str, Span]) -> Diagnostic:
    values = f"{one.row.label} is {one.row.shown(one.value)} and {other.row.label} {other.row.shown(other.value)}"
    medians = f"{one.row.shown(one.row.spread.median)} and {other.row.shown(other.row.spread.median)}"
    message = f"{robot}: {values}, each that of the other one in the other robots (medians {medians})"
    related = [Related(line, None) for line in (_follows(one.row),) if line]
    span = places.get(one.row.fact.name if one.row.is_argument else "", places.get(""))
    of = (robot, one.row.label, other.row.label)
    return Diagnostic("fleet-outlier", WARNING, message, span, tuple(related), "swapped?", of)
