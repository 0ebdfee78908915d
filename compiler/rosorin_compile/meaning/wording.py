"""How a difference is said, in ``check``, ``diff`` and wherever else two robots are held against each other.

Each kind of difference has one sentence: what it is about, what happened, and the numbers before and after, short but
sufficient. Small steps are said in mm, deg and g.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from typing import NamedTuple

from ..diagnostics.wording import counted, first_of, printable
from ..formats import Fact, Value
from ..formats.facts import ANGLES, AXES, INERTIA, SIZES
from ..model import Pose, Transform, Vector
from ..model.geometry import angle_between, norm, pose_of
from ..numbers import exact
from .solids import Delta, Solid, largest_step
from .tolerance import NOISE, joined

_MAX_TEXT = 60
_MAX_PAIRS = 3
_MOST = 3
# How a step of a unit is said: the unit that people measure it in, and how many of it there are.
_SMALL = {"m": ("mm", 1e3), "rad": ("deg", math.degrees(1)), "kg": ("g", 1e3)}
_BARE = ("frame", "joint", "link")
_LIMITS = ("lower", "upper", "effort", "velocity")
_LOOK = ("red", "green", "blue", "alpha")
# What is no length (m) and no angle (rad): a number apart that rounding made.
_LEAST = 1e-12


class Sentence(NamedTuple):
    """A difference in words, and how much it is where that is no part of the words."""

    text: str
    remark: str = ""

    def __str__(self) -> str:
        """Return both."""
        return f"{self.text} ({self.remark})" if self.remark else self.text


def number(value: float, other: float | None = None) -> str:
    """Return a number in print, with the digits that tell it from another one."""
    if other is not None and other != value:
        return number_pair(value, other)[0]
    return exact(float(f"{value:.6g}"))


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


def row(values: Iterable[float]) -> str:
    """Return numbers in a row."""
    return " ".join(number(value) for value in values)


def several(names: Sequence[str]) -> str:
    """Return the first names of a list and the number of the others."""
    return first_of(names, _MOST)


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


def step(difference: float, old: float, unit: str) -> str:
    """Return a signed step in mm, deg or g; in other units as a part of the old value; nothing without a unit."""
    sign = "-" if difference < 0 else "+"
    if unit in _SMALL:
        return f"{sign}{amount(abs(difference), unit)}"
    return f"{sign}{_short(abs(difference / old) * 100)} %" if unit and old else ""


def far(distance: float, angle: float, verbs: bool = False) -> str:
    """Return a length (m) and an angle (rad), each only if it is not zero.

    >>> far(0.002, 0.0), far(0.0, 0.01), far(0.002, 0.01, verbs=True)
    ('2.0 mm', '0.57 deg', 'moved 2.0 mm and turned 0.57 deg')
    """
    values = (("moved ", distance, "m"), ("turned ", angle, "rad"))
    parts = [f"{verb if verbs else ''}{amount(value, unit)}" for verb, value, unit in values if value > _LEAST]
    return " and ".join(parts) or "0 mm"


def subject(fact: Fact) -> str:
    """Return what a fact is about."""
    kind, name, quantity = fact
    if kind == "frame" and quantity in ("publisher", "topic"):
        return f"{name}: {'published by' if quantity == 'publisher' else quantity}"
    if kind == "joint" and quantity in _LIMITS:
        return f"{name} limit {quantity}"
    if kind == "pose":
        return f"pose {name}: {quantity}"
    if kind == "height map":
        return f"{name} height map {quantity}"
    if kind == "link" and quantity.startswith("inertia "):
        quantity = quantity.replace(" ", " i")
    if kind in _BARE or (kind, name) == ("servo", "pulse_to_rad") or kind == name:
        return f"{name} {quantity}"
    return f"{kind} {name} {quantity}"


def value_change(about: str, old: Value | None, new: Value | None) -> Sentence:
    """Return what became of a value; None where it is not given."""
    if old is None or new is None:
        given = value_text(new or old)
        return Sentence(f"{about}: new, {given}" if new else f"{about}: removed, was {given}")
    if isinstance(old.value, str) and isinstance(new.value, str):
        return Sentence(f"{about} {' -> '.join(_text_pair(old.value, new.value))}")
    if isinstance(old.value, str) or isinstance(new.value, str):
        return Sentence(f"{about} {value_text(old)} -> {value_text(new)}")
    before, after = number_pair(old.value, new.value)
    unit = f" {new.unit}" if new.unit else ""
    return Sentence(f"{about} {before} -> {after}{unit}", step(new.value - old.value, old.value, new.unit))


def number_change(about: str, old: float | None, new: float | None, unit: str) -> Sentence:
    """Return what became of a number; None where it is not given."""
    values = [None if value is None else Value(float(value), unit) for value in (old, new)]
    return value_change(about, values[0], values[1])


def value_text(value: Value | None) -> str:
    """Return a value in print; a text of several words in quotes, and shortened."""
    if value is None:
        return "nothing"
    if not isinstance(value.value, str):
        return f"{number(value.value)} {value.unit}".rstrip()
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


def placed(
    frame: str,
    parents: tuple[str, str],
    poses: tuple[Pose, Pose],
    apart: tuple[float, float],
    others: Sequence[str] = (),
) -> Sentence:
    """Return what became of where a frame sits, before and after.

    ``apart`` is how far it moved (m) and turned (rad), ``others`` are frames that went with it. In another parent the
    numbers alone are said: what happened is said of the parent.
    """
    with_it = f", and with it {several(others)}" if others else ""
    numbers = _coordinates(*poses, *apart)
    if parents[0] != parents[1]:
        return Sentence(f"{frame} {numbers}{with_it}")
    return Sentence(f"{frame} {far(*apart, verbs=True)} in {parents[1]}{with_it}: {numbers}")


def _coordinates(old: Pose, new: Pose, distance: float, angle: float) -> str:
    """Return which coordinates changed, of which something did."""
    steps = [
        f"{axis} {' -> '.join(number_pair(one, other))} m"
        for axis, one, other in zip(AXES, old.xyz, new.xyz, strict=True)
        if abs(other - one) > distance / 1e3 and distance
    ]
    turns = [
        f"{name} {' -> '.join(number_pair(one, other))} rad"
        for name, one, other in zip(ANGLES, old.rpy, new.rpy, strict=True)
        if abs(other - one) > angle / 1e3 and angle
    ]
    return ", ".join([f"origin {', '.join(steps)}"] * bool(steps) + turns)


def pose_text(pose: Pose) -> str:
    """Return a pose as a text of six numbers."""
    return f"xyz {row(pose.xyz)} rpy {row(pose.rpy)}"


def axis_change(joint: str, old: Vector, new: Vector, angle: float | None = None) -> Sentence:
    """Return what became of the axis of a joint; ``angle`` (rad) is by how much it turned, if the axes do not say."""
    if angle is None:
        angle = angle_between(old, new) if norm(old) and norm(new) else 0.0
    if angle > math.pi - _LEAST:
        return Sentence(f"{joint} counts the other way round: axis {row(old)} -> {row(new)}")
    # Of the same direction, what changed is the length.
    remark = f"turned {amount(angle, 'rad')}" if angle > NOISE else ""
    pairs = [(number(a, b), number(b, a)) for a, b in zip(old, new, strict=True)]
    return Sentence(f"{joint} axis {' -> '.join(' '.join(numbers) for numbers in zip(*pairs, strict=True))}", remark)


def mimic_change(joint: str, old: str, new: str) -> Sentence:
    """Return what became of what a joint follows (see ``mimic_text``)."""
    return Sentence(f"{joint} mimics {old} -> {new}")


def mimic_text(leader: str, multiplier: float = 1.0, offset: float = 0.0) -> str:
    """Return what a joint follows; nothing without a leader."""
    return f"{leader} * {number(multiplier)} + {number(offset)}" if leader else "nothing"


def centre_change(link: str, old: Vector, new: Vector) -> Sentence:
    """Return what became of a centre of mass (m) in the frame of its link."""
    distance = math.dist(old, new)
    numbers = _coordinates(Pose(old), Pose(new), distance, 0.0).removeprefix("origin ")
    return Sentence(f"{link} centre of mass moved {amount(distance, 'm')}: {numbers}")


def inertia_change(link: str, old: Sequence[float], new: Sequence[float], changed: Sequence[bool]) -> Sentence:
    """Return what became of an inertia (kg*m^2; xx yy zz xy xz yz), of which some entries changed."""
    entries = zip(INERTIA, old, new, changed, strict=True)
    parts = [f"i{name} {' -> '.join(number_pair(one, other))}" for name, one, other, is_new in entries if is_new]
    share = max(abs(b - a) for a, b in zip(old, new, strict=True)) / max(map(abs, (*old, *new)))
    percent = f"{share * 100:.2g}" if share < 0.995 else f"{share * 100:.0f}"
    return Sentence(f"{link} inertia {', '.join(parts)} kg*m^2", f"by {percent} % of the largest moment")


class Hung(NamedTuple):
    """What is known of how a frame hangs on another: the joint is named where it says more than the frame does."""

    parent: str = ""
    kind: str = ""
    joint: str = ""
    publisher: str = ""


def existence(word: str, what: str, name: str, hung: Hung, others: Sequence[str] = ()) -> Sentence:
    """Return that a link or a frame is new or removed, how it hangs, and ``others`` that hang on it."""
    how = [f"{hung.kind} on {hung.parent}".strip() if hung.parent else "the root", hung.joint]
    how += [f"published by {hung.publisher}" if hung.publisher else ""]
    sentence = Sentence(f"{word}: {what} {name}", ", ".join(filter(None, how)))
    return Sentence(f"{sentence}, and with it {several(others)}") if others else sentence


def renamed(what: str, old: str, new: str) -> Sentence:
    """Return that a link or a joint is called otherwise."""
    return Sentence(f"{what} {old} renamed to {new}")


def contacts_change(new: Sequence[str], removed: Sequence[str]) -> Sentence:
    """Return which pairs of links are excluded from contact now, or no more."""
    parts = []
    for pairs, what in ((new, "new"), (removed, "removed")):
        if pairs:
            rest = f", {len(pairs) - _MAX_PAIRS} more" if len(pairs) > _MAX_PAIRS else ""
            parts.append(f"{len(pairs)} {what} ({', '.join(pairs[:_MAX_PAIRS])}{rest})")
    return Sentence(f"excluded contacts: {', '.join(parts)}")


def shapes_change(link: str, purpose: str, counts: tuple[int, int], difference: Delta) -> Sentence:
    """Return what became of the solids of a link, of which there were and are so many."""
    before, after = counts
    changed = min(len(difference.removed), len(difference.added))
    if before == after == changed == 1:
        return _solid_change(f"{link} {purpose}", difference.removed[0], difference.added[0])
    largest = largest_step(difference) if changed else None
    far_text = f", up to {amount(largest, 'm')}" if largest else ""
    if before == after:
        return Sentence(f"{link} {purpose}: {changed} of {counted(before, 'shape')} changed{far_text}")
    also = f", {changed} of them changed{far_text}" if changed else ""
    return Sentence(f"{link} {purpose}: {before} -> {after} shapes{also}")


def _solid_change(about: str, one: Solid, other: Solid) -> Sentence:
    """Return what became of the only solid of a link: another kind, look or file, other sizes, or another place."""
    if one.kind != other.kind:
        return Sentence(f"{about}: {one.kind} -> {other.kind}")
    looks = [_look(solid) for solid in (one, other)]
    if looks[0] != looks[1] and _without_look(one) == _without_look(other):
        return colour_change(about, *looks)
    if one.words != other.words:
        return Sentence(f"{about}: {one.kind} {_words_change(one.words, other.words)}")
    if one.kind == "mesh" and one.sizes != other.sizes:
        return Sentence(f"{about}: mesh scale {row(one.sizes)} -> {row(other.sizes)}")
    numbers = _numbers_change(one, other)
    if numbers:
        parts = [f"{name} {' -> '.join(number_pair(old, new))}" for name, old, new in numbers]
        _, old, new = numbers[0]
        remark = step(new - old, old, "m") if len(numbers) == 1 else ""
        return Sentence(f"{about}: {one.kind} {', '.join(parts)} m", remark)
    places = Transform(one.rows, one.centre), Transform(other.rows, other.centre)
    apart = math.dist(one.centre, other.centre), places[0].angle_to(places[1])
    poses = pose_of(places[0]), pose_of(places[1])
    return Sentence(f"{about}: {one.kind} {far(*apart, verbs=True)}", _coordinates(*poses, *apart))


def _numbers_change(one: Solid, other: Solid) -> list[tuple[str, float, float]]:
    """Return the sizes that changed, of boxes along the axes their corners, each with its name."""
    allowed = joined(one.tolerance, other.tolerance)
    boxes = one.box, other.box
    if boxes[0] is not None and boxes[1] is not None:
        names = [f"{end} {axis}" for end in ("min", "max") for axis in AXES]
        sizes = [(*box.lower, *box.upper) for box in boxes if box is not None]
        rows = zip(names, *sizes, strict=True)
    else:
        rows = zip(SIZES.get(one.kind, ()), one.sizes, other.sizes, strict=False)
    steps = [(name, a, b) for name, a, b in rows if abs(b - a) > NOISE]
    return [(name, a, b) for name, a, b in steps if abs(b - a) > allowed] or (steps if all(boxes) else [])


def _words_change(old: Sequence[str], new: Sequence[str]) -> str:
    """Return which words about a shape are others now; what both begin with is said once."""
    before, after = ([word for word in some if word not in rest] for some, rest in ((old, new), (new, old)))
    if len(before) == len(after) == 1 and before[0].split(" ")[0] == after[0].split(" ")[0]:
        return f"{before[0]} -> {after[0].partition(' ')[2]}"
    return f"{', '.join(before) or 'nothing'} -> {', '.join(after) or 'nothing'}"


def _look(solid: Solid) -> str:
    """Return the colour of a solid, as its words have it."""
    values = dict(word.split(" ", 1) for word in solid.words if word.split(" ", 1)[0] in _LOOK)
    return row(float(values[part]) for part in _LOOK if part in values)


def _without_look(solid: Solid) -> Solid:
    return solid._replace(words=tuple(word for word in solid.words if word.split(" ")[0] not in _LOOK))


def colour_change(about: str, old: str, new: str) -> Sentence:
    """Return what became of a colour, in numbers."""
    return Sentence(f"{about} colour {old or 'none'} -> {new or 'none'}")


def cells_change(link: str, steps: Sequence[float], cells: tuple[str, str]) -> Sentence:
    """Return what became of a height map: ``steps`` (m) of its heights, and its cells in words before and after."""
    parts = [f"{cells[0]} -> {cells[1]} cells"] if cells[0] != cells[1] else []
    if steps:
        up_to = "by up to" if len(steps) > 1 else "by"
        parts.append(f"{counted(len(steps), 'cell')} changed, {up_to} {amount(max(steps), 'm')}")
    return Sentence(f"{link} height map: {', '.join(parts)}")
