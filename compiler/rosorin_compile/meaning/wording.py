"""How a difference is said: numbers short but sufficient, small steps in mm, deg and g."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import NamedTuple

from ..diagnostics.wording import counted, printable
from ..formats import Fact, Value
from ..model import Robot
from ..numbers import exact
from .solids import Delta, largest_step

_MAX_TEXT = 60
_MAX_PAIRS = 3
# How a step of a unit is said: the unit that people measure it in, and how many of it there are.
_SMALL = {"m": ("mm", 1e3), "rad": ("deg", math.degrees(1)), "kg": ("g", 1e3)}
_BARE = ("frame", "joint", "link")


class Change(NamedTuple):
    """One difference of meaning: what it is about, in words, how much it is, and the outputs that show it.

    ``quantity`` is empty where the thing itself is new or gone. ``therefore`` are links whose shapes differ for no
    other reason.
    """

    kind: str
    name: str
    quantity: str
    text: str
    remark: str
    artifacts: tuple[str, ...]
    therefore: tuple[str, ...] = ()

    def line(self) -> str:
        """Return the change as one line of plain text."""
        remarks = [self.remark] if self.remark else []
        if self.therefore:
            remarks.append(f"and therefore the shapes of {', '.join(self.therefore)}")
        remark = f" ({'; '.join(remarks)})" if remarks else ""
        return f"{self.text}{remark}: {', '.join(self.artifacts)}"


def value_change(robot: Robot, fact: Fact, old: Value | None, new: Value | None) -> tuple[str, str]:
    """Return what became of a value, and how large the step is."""
    subject = _subject(robot, fact)
    if old is None or new is None:
        said = value_text(new or old)
        return (f"{subject}: new, {said}" if new else f"{subject}: removed, was {said}"), ""
    if isinstance(old.value, str) and isinstance(new.value, str):
        return f"{subject} {' -> '.join(_text_pair(old.value, new.value))}", ""
    if isinstance(old.value, str) or isinstance(new.value, str):
        return f"{subject} {value_text(old)} -> {value_text(new)}", ""
    before, after = number_pair(old.value, new.value)
    unit = f" {new.unit}" if new.unit else ""
    return f"{subject} {before} -> {after}{unit}", step(new.value - old.value, old.value, new.unit)


def _subject(robot: Robot, fact: Fact) -> str:
    """Return what a fact is about, a frame under the name of the joint that places it, where there is one."""
    kind, name, quantity = fact
    if kind == "frame" and quantity in ("publisher", "topic"):
        return f"{name}: {quantity}"
    if kind == "frame":
        name = robot.joint_to[name].name if name in robot.joint_to else f"frame {name}"
    if kind == "height map":
        return f"chassis height map {quantity}"
    if kind in _BARE or (kind, name) == ("servo", "pulse_to_rad") or kind == name:
        return f"{name} {quantity}"
    return f"{kind} {name} {quantity}"


def value_text(value: Value | None) -> str:
    """Return a value in print; a text of several words in quotes, and shortened."""
    if value is None:
        return "nothing"
    if not isinstance(value.value, str):
        return f"{exact(float(f'{value.value:.7g}'))} {value.unit}".rstrip()
    return _quoted(value.value, 0)


def _text_pair(old: str, new: str) -> tuple[str, str]:
    """Return two different texts in print, long ones from shortly before the place where they begin to differ."""
    place = next((at for at, (a, b) in enumerate(zip(old, new, strict=False)) if a != b), min(len(old), len(new)))
    first = max(0, place - _MAX_TEXT // 3) if max(len(old), len(new)) > _MAX_TEXT else 0
    return _quoted(old, first), _quoted(new, first)


def _quoted(text: str, first: int) -> str:
    shown = printable(text[first : first + _MAX_TEXT], keep="\t")
    shown = f"{'...' if first else ''}{shown}{'...' if first + _MAX_TEXT < len(text) else ''}"
    return f'"{shown}"' if not shown or " " in shown else shown


def number_pair(old: float, new: float) -> tuple[str, str]:
    """Return two different numbers with as few digits, six at least, as show their difference.

    >>> number_pair(0.0136322197327749, 0.015), number_pair(0.1, 0.1000000001)
    (('0.0136322', '0.015'), ('0.1', '0.1000000001'))
    """
    difference = abs(new - old)
    for digits in range(6, 17):
        before, after = float(f"{old:.{digits}g}"), float(f"{new:.{digits}g}")
        if before != after and abs(abs(after - before) - difference) <= 0.05 * difference:
            return exact(before), exact(after)
    return exact(old), exact(new)


def step(difference: float, old: float, unit: str) -> str:
    """Return a signed step in mm, deg or g; in other units as a part of the old value; nothing without a unit."""
    sign = "-" if difference < 0 else "+"
    if unit in _SMALL:
        return f"{sign}{amount(abs(difference), unit)}"
    return f"{sign}{_short(abs(difference / old) * 100)} %" if unit and old else ""


def amount(value: float, unit: str) -> str:
    """Return a length, angle or mass that is not negative in the unit that suits its size.

    >>> amount(0.001, "m"), amount(2.5, "m"), amount(0.0042, "rad"), amount(0.0013678, "kg")
    ('1.0 mm', '2.5 m', '0.24 deg', '1.4 g')
    """
    small, count = _SMALL[unit]
    return f"{_short(value)} {unit}" if value >= 1 and unit != "rad" else f"{_short(value * count)} {small}"


def _short(value: float) -> str:
    """Return a number with one decimal, a small one with two digits."""
    return f"{value:.1f}" if value >= 0.95 else exact(float(f"{value:.2g}"))


def contacts_change(new: list[str], removed: list[str]) -> str:
    """Return which pairs of links are excluded from contact now, or no more."""
    parts = []
    for pairs, what in ((new, "new"), (removed, "removed")):
        if pairs:
            rest = f", {len(pairs) - _MAX_PAIRS} more" if len(pairs) > _MAX_PAIRS else ""
            parts.append(f"{len(pairs)} {what} ({', '.join(pairs[:_MAX_PAIRS])}{rest})")
    return f"excluded contacts: {', '.join(parts)}"


def shapes_change(link: str, purpose: str, counts: tuple[int, int], difference: Delta) -> str:
    """Return what became of the solids of a link, of which there were and are so many."""
    before, after = counts
    changed = min(len(difference.removed), len(difference.added))
    far = largest_step(difference) if changed else None
    far_text = f", up to {amount(far, 'm')}" if far else ""
    if before == after:
        return f"{link} {purpose}: {changed} of {counted(before, 'shape')} changed{far_text}"
    also = f", {changed} of them changed{far_text}" if changed else ""
    return f"{link} {purpose}: {before} -> {after} shapes{also}"


def cells_change(old: Mapping[tuple[int, int], float], new: Mapping[tuple[int, int], float]) -> str:
    """Return what became of the heights (m) of the cells of a height map; empty if nothing did."""
    steps = [abs(new[cell] - old[cell]) for cell in sorted(old.keys() & new.keys()) if new[cell] != old[cell]]
    before, after = _grid(old), _grid(new)
    parts = [f"{before} -> {after} cells"] if before != after else []
    if steps:
        up_to = "by up to" if len(steps) > 1 else "by"
        parts.append(f"{counted(len(steps), 'cell')} changed, {up_to} {amount(max(steps), 'm')}")
    return f"chassis height map: {', '.join(parts)}" if parts else ""


def _grid(cells: Mapping[tuple[int, int], float]) -> str:
    rows, columns = (1 + max((cell[axis] for cell in cells), default=-1) for axis in (0, 1))
    return f"{rows} x {columns}"
