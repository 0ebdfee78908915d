"""Put differences into sentences, in ``check``, ``diff`` and wherever else two robots are compared.

Each kind of difference has one sentence: what it is about, what happened, and the numbers before and after, short but
sufficient. Small steps are in mm, deg and g.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Sequence
from typing import Any, NamedTuple

from rosorin_compile.model import Pose, Vector
from rosorin_compile.model.geometry import angle_between, norm
from rosorin_compile.source.numbers import SMALL, amount, exact, few_digits, six_digits
from rosorin_compile.source.wording import counted, first_of, printable

from .precision import NOISE

AXES = ("x", "y", "z")
ANGLES = ("roll", "pitch", "yaw")
INERTIA = ("xx", "yy", "zz", "xy", "xz", "yz")
NEW, REMOVED = "new", "removed"
_MAX_TEXT = 60
_MAX_PAIRS = 3
_MOST = 3
# No length (m) and no angle (rad): a step that rounding made.
_LEAST = 1e-12
# The step of one coordinate beside a much larger one of another is told, down to what calculating leaves of it.
_SHARE = 1e-9


class Row(NamedTuple):
    """What became of something, in the columns of a table; a column that has nothing to say is empty.

    ``where`` is the frame that it is seen in, ``by`` how much it is, or what happened where there are no two values.
    """

    what: str
    quantity: str = ""
    before: str = ""
    after: str = ""
    by: str = ""
    where: str = ""


class Sentence(NamedTuple):
    """A difference in words, how much it is where that is no part of the words, and the same as a row of a table."""

    text: str
    remark: str
    row: Row

    def __str__(self) -> str:
        """Return both."""
        return f"{self.text} ({self.remark})" if self.remark else self.text


class About(NamedTuple):
    """What a sentence is about: a thing and a quantity of it, and what is between them."""

    name: str
    quantity: str
    between: str = " "

    def __str__(self) -> str:
        """Return both as they are in a sentence."""
        return f"{self.name}{self.between}{self.quantity}"


def number(value: float, other: float | None = None) -> str:
    """Return a number in print, with the digits that tell it from another one."""
    return six_digits(value) if other is None or other == value else number_pair(value, other)[0]


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


def row_pair(old: Sequence[float], new: Sequence[float]) -> tuple[str, str]:
    """Return two rows of as many numbers, each number with the digits that tell it from the other one.

    >>> row_pair((0.5, 1), (0.5, 1.0000111))
    ('0.5 1', '0.5 1.000011')
    """
    before, after = zip(*((number(a, b), number(b, a)) for a, b in zip(old, new, strict=True)), strict=True)
    return " ".join(before), " ".join(after)


def several(names: Sequence[str]) -> str:
    """Return the first names of a list and the number of the others."""
    return first_of(names, _MOST)


def step(difference: float, old: float, unit: str) -> str:
    """Return a signed step in mm, deg or g; in other units as a part of the old value; nothing without a unit."""
    sign = "-" if difference < 0 else "+"
    if unit in SMALL:
        return f"{sign}{amount(abs(difference), unit)}"
    return f"{sign}{few_digits(abs(difference / old) * 100)} %" if unit and old else ""


def far(distance: float, angle: float, verbs: bool = False) -> str:
    """Return a length (m) and an angle (rad), each only if it is not zero.

    >>> far(0.002, 0.0), far(0.0, 0.01), far(0.002, 0.01, verbs=True)
    ('2.0 mm', '0.57 deg', 'moved 2.0 mm and turned 0.57 deg')
    """
    values = (("moved ", distance, "m"), ("turned ", angle, "rad"))
    parts = [f"{verb if verbs else ''}{amount(value, unit)}" for verb, value, unit in values if value > _LEAST]
    return " and ".join(parts) or "0 mm"


_NUMBERS = r"(?: [-+]?[0-9.]+(?:e[-+]?[0-9]+)?)*"
# Where a sentence begins to say how much: values, a remark, or the steps of a pose.
_VALUES = re.compile(rf"{_NUMBERS} \S+ -> | \(|: (?=origin |roll |pitch |yaw )|: (?:new|removed), ")


def brief(texts: Iterable[str]) -> str:
    """Return what several sentences are about, each once and without its numbers; of many the first ones.

    >>> brief(["arm mass 1 -> 2 kg (+1.0 kg)", "lid moved 20.0 mm in arm: origin x 0 -> 0.02 m"])
    'arm mass, lid moved 20.0 mm in arm'
    """
    heads = (_VALUES.split(text, maxsplit=1)[0].rstrip(":") for text in texts)
    return several(list(dict.fromkeys(heads)))


def value_change(about: About, old: Any, new: Any, unit: str = "") -> Sentence:
    """Return what became of a value: a number in a unit, or anything else; None where it is not given."""
    row = Row(about.name, about.quantity)
    if old is None or new is None:
        what, value = (NEW, text_of(new)) if old is None else (REMOVED, text_of(old))
        value = f"{value} {unit}".rstrip()
        given = Row(about.name, about.quantity, *(("", value) if what == NEW else (value, "")), what)
        return Sentence(f"{about}: {what}, {'' if what == NEW else 'was '}{value}", "", given)
    if not _is_number(old) or not _is_number(new):
        before, after = _text_pair(old, new)
        return Sentence(f"{about} {before} -> {after}", "", row._replace(before=before, after=after))
    before, after = number_pair(old, new)
    end = f" {unit}" if unit else ""
    by = step(new - old, old, unit)
    return Sentence(
        f"{about} {before} -> {after}{end}", by, row._replace(before=before + end, after=after + end, by=by)
    )


def _is_number(value: Any) -> bool:
    return isinstance(value, (int, float)) and not isinstance(value, bool)


def text_of(value: Any, other: Any = None) -> str:
    """Return a value in print, with the digits that tell it from another one; "nothing" for None."""
    if value is None:
        return "nothing"
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, str):
        return _quoted(value, 0)
    if isinstance(value, Pose):
        twin = other if isinstance(other, Pose) else value
        return f"xyz {text_of(value.xyz, twin.xyz)} rpy {text_of(value.rpy, twin.rpy)}"
    if isinstance(value, frozenset):
        return first_of(sorted(map(str, value)), _MOST)
    if isinstance(value, (tuple, list)):
        twins = other if isinstance(other, (tuple, list)) and len(other) == len(value) else value
        return " ".join(text_of(one, twin) for one, twin in zip(value, twins, strict=True)) or "nothing"
    if _is_number(value):
        return number(float(value), float(other) if _is_number(other) else None)
    return str(value)


def _text_pair(old: Any, new: Any) -> tuple[str, str]:
    """Return two different values in print, long texts from shortly before the place where they begin to differ."""
    if not isinstance(old, str) or not isinstance(new, str):
        before, after = text_of(old, new), text_of(new, old)
        if max(len(before), len(after)) <= _MAX_TEXT:
            return before, after
        old, new = before, after
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
    least: tuple[float, float] = (_LEAST, _LEAST),
) -> Sentence:
    """Return what became of where a frame is, before and after.

    ``apart`` is how far it moved (m) and turned (rad), ``others`` are frames that went with it. In another parent the
    numbers alone are given: what happened is told of the parent. Steps of ``least`` (m, rad) and below are none.
    """
    with_it = f", and with it {several(others)}" if others else ""
    steps = coordinates(*poses, *apart, least)
    row = steps_row(f"{frame}{with_it}", steps)
    if parents[0] != parents[1]:
        return Sentence(f"{frame} {origin_text(steps)}{with_it}", "", row)
    text = f"{frame} {far(*apart, verbs=True)} in {parents[1]}{with_it}: {origin_text(steps)}"
    return Sentence(text, "", row._replace(by=far(*apart), where=parents[1]))


class Step(NamedTuple):
    """A coordinate that changed: its name, before, after, and the unit."""

    name: str
    before: str
    after: str
    unit: str

    def __str__(self) -> str:
        return f"{self.name} {self.before} -> {self.after} {self.unit}"


def coordinates(
    old: Pose, new: Pose, distance: float, angle: float, least: tuple[float, float] = (_LEAST, _LEAST)
) -> list[Step]:
    """Return which coordinates changed, of which something did; steps of ``least`` (m, rad) and below are none."""
    length, turn = max(least[0], _SHARE * distance), max(least[1], _SHARE * angle)
    named = [*zip(AXES, old.xyz, new.xyz, strict=True)] if distance else []
    turned = [*zip(ANGLES, old.rpy, new.rpy, strict=True)] if angle else []
    found = [Step(axis, *number_pair(a, b), "m") for axis, a, b in named if abs(b - a) > length]
    return found + [Step(name, *number_pair(a, b), "rad") for name, a, b in turned if abs(b - a) > turn]


def origin_text(steps: Sequence[Step]) -> str:
    """Return steps of a pose in words."""
    moved = ", ".join(str(one) for one in steps if one.unit == "m")
    return ", ".join([f"origin {moved}"] * bool(moved) + [str(one) for one in steps if one.unit != "m"])


def steps_row(what: str, steps: Sequence[Step], quantity: str = "origin") -> Row:
    """Return steps of a pose as a row; a single one is named before its numbers."""
    if len(steps) == 1:
        (only,) = steps
        name = f"{quantity} {only.name}" if only.unit == "m" else only.name
        return Row(what, name, f"{only.before} {only.unit}", f"{only.after} {only.unit}")
    before, after = (", ".join(f"{s.name} {getattr(s, side)} {s.unit}" for s in steps) for side in ("before", "after"))
    return Row(what, quantity, before, after)


def near_angles(old: Vector, new: Vector) -> Vector:
    """Return angles (rad) that mean the same rotation as the old ones, as near to the new ones as they can be."""
    roll, pitch, yaw = old
    forms = [(roll, pitch, yaw), (roll + math.pi, math.pi - pitch, yaw + math.pi)]
    near = [[b + _wrapped(a - b) for a, b in zip(form, new, strict=True)] for form in forms]
    best = min(near, key=lambda form: sum(abs(a - b) for a, b in zip(form, new, strict=True)))
    roll, pitch, yaw = (0.0 if abs(angle) < _LEAST else angle for angle in best)
    return (roll, pitch, yaw)


def _wrapped(angle: float) -> float:
    """Return an angle (rad) within plus and minus half a turn; half a turn itself is plus, in print as well."""
    half = math.pi + 2e-6
    return half - (half - angle) % math.tau


def axis_change(joint: str, old: Vector, new: Vector, angle: float | None = None) -> Sentence:
    """Return what became of the axis of a joint; ``angle`` (rad) is by how much it turned, if the axes do not say."""
    if angle is None:
        angle = angle_between(old, new) if norm(old) and norm(new) else 0.0
    if angle > math.pi - _LEAST:
        text = f"{joint} counts the other way round: axis {row(old)} -> {row(new)}"
        return Sentence(text, "", Row(joint, "axis", row(old), row(new), "the other way round"))
    # Of the same direction, what changed is the length.
    turned = amount(angle, "rad") if angle > NOISE else ""
    before, after = row_pair(old, new)
    remark = f"turned {turned}" if turned else ""
    return Sentence(f"{joint} axis {before} -> {after}", remark, Row(joint, "axis", before, after, turned))


def mimic_text(leader: str, multiplier: float = 1.0, offset: float = 0.0) -> str:
    """Return what a joint follows; nothing without a leader."""
    return f"{leader} * {number(multiplier)} + {number(offset)}" if leader else "nothing"


def centre_change(link: str, old: Vector, new: Vector, least: float = 0.0) -> Sentence:
    """Return what became of a centre of mass (m) in the frame of its link; ``least`` as in ``coordinates``."""
    distance = math.dist(old, new)
    steps = coordinates(Pose(old), Pose(new), distance, 0.0, (least, 0.0))
    moved = amount(distance, "m")
    text = f"{link} centre of mass moved {moved}: {', '.join(map(str, steps))}"
    return Sentence(text, "", steps_row(link, steps, "centre of mass")._replace(by=moved))


def inertia_change(link: str, old: Sequence[float], new: Sequence[float], least: float = 0.0) -> Sentence:
    """Return what became of an inertia (kg*m^2; xx yy zz xy xz yz); entries that changed by ``least`` did not."""
    entries = [(name, a, b) for name, a, b in zip(INERTIA, old, new, strict=True) if abs(b - a) > least]
    steps = [Step(f"i{name}", *number_pair(a, b), "kg*m^2") for name, a, b in entries]
    parts = [f"{one.name} {one.before} -> {one.after}" for one in steps]
    share = max(abs(b - a) for a, b in zip(old, new, strict=True)) / max(map(abs, (*old, *new)))
    percent = f"{share * 100:.2g}" if share < 0.995 else f"{share * 100:.0f}"
    by = f"{percent} % of the largest moment"
    row = steps_row(link, steps, "inertia")
    if len(steps) == 1:
        row = row._replace(quantity=f"inertia {steps[0].name}")
    return Sentence(f"{link} inertia {', '.join(parts)} kg*m^2", f"by {by}", row._replace(by=by))


def existence(word: str, what: str, name: str, how: Iterable[str] = (), others: Sequence[str] = ()) -> Sentence:
    """Return that something is new or removed, ``how`` it is attached, and ``others`` that are attached to it."""
    remark = ", ".join(filter(None, how))
    row = Row(name, what, "" if word == NEW else remark, remark if word == NEW else "", word)
    sentence = Sentence(f"{word}: {what} {name}".rstrip(), remark, row)
    if not others:
        return sentence
    with_it = f", and with it {several(others)}"
    return Sentence(f"{sentence}{with_it}", "", row._replace(what=f"{name}{with_it}"))


def renamed(what: str, old: str, new: str) -> Sentence:
    """Return that a link or a joint has another name."""
    return Sentence(f"{what} {old} renamed to {new}", "", Row(new, f"name of the {what}", old, new, "renamed"))


def set_change(title: str, old: Iterable[str], new: Iterable[str]) -> Sentence:
    """Return which members of a set are new, or removed."""
    before, after = frozenset(old), frozenset(new)
    shown = {}
    for members, what in ((after - before, NEW), (before - after, REMOVED)):
        rest = f", {len(members) - _MAX_PAIRS} more" if len(members) > _MAX_PAIRS else ""
        shown[what] = f"{', '.join(sorted(members)[:_MAX_PAIRS])}{rest}"
    counts = {NEW: len(after - before), REMOVED: len(before - after)}
    text = ", ".join(f"{count} {what} ({shown[what]})" for what, count in counts.items() if count)
    by = ", ".join(f"{count} {what}" for what, count in counts.items() if count)
    return Sentence(f"{title}: {text}", "", Row(title, "", shown[REMOVED], shown[NEW], by))


def colour_change(about: About, old: Sequence[float] | None, new: Sequence[float] | None) -> Sentence:
    """Return what became of a colour."""
    colours = row_pair(old, new) if old and new else tuple(row(one) if one else "none" for one in (old, new))
    text = f"{about} colour {' -> '.join(colours)}"
    return Sentence(text, "", Row(about.name, f"{about.quantity} colour".strip(), *colours))


def cells_change(link: str, old: Sequence[Sequence[float]], new: Sequence[Sequence[float]]) -> Sentence:
    """Return what became of the heights (m) of a height map."""
    sizes = [f"{len(grid)} x {len(grid[0]) if grid else 0}" for grid in (old, new)]
    made = Row(link, "height map")
    pairs = (pair for lines in zip(old, new, strict=False) for pair in zip(*lines, strict=False))
    steps = [abs(b - a) for a, b in pairs if abs(b - a) > NOISE]
    parts = []
    if sizes[0] != sizes[1]:
        made = made._replace(before=f"{sizes[0]} cells", after=f"{sizes[1]} cells")
        parts.append(f"{sizes[0]} -> {sizes[1]} cells")
    if steps:
        by = f"{'by up to' if len(steps) > 1 else 'by'} {amount(max(steps), 'm')}"
        made = made._replace(by=f"{counted(len(steps), 'cell')}, {by}")
        parts.append(f"{counted(len(steps), 'cell')} changed, {by}")
    return Sentence(f"{link} height map: {', '.join(parts)}", "", made)
