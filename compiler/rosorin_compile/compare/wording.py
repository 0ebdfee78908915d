"""How a difference is said, in ``check``, ``diff`` and wherever else two robots are held against each other.

Each kind of difference has one sentence: what it is about, what happened, and the numbers before and after, short but
sufficient. Small steps are said in mm, deg and g.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Sequence
from typing import NamedTuple

from rosorin_compile.formats import Value
from rosorin_compile.formats.facts import AXES, INERTIA
from rosorin_compile.formats.format import ANGLES, About
from rosorin_compile.model import Pose, Vector
from rosorin_compile.model.geometry import angle_between, norm
from rosorin_compile.source.numbers import SMALL, amount, exact, few_digits, six_digits
from rosorin_compile.source.wording import counted, first_of, printable

from .tolerance import NOISE

_MAX_TEXT = 60
_MAX_PAIRS = 3
_MOST = 3
# What happened to a thing that is on one side only.
NEW, REMOVED = "new", "removed"
# What is no length (m) and no angle (rad): a number apart that rounding made.
_LEAST = 1e-12
# The step of one coordinate beside a much larger one of another is told, down to what calculating leaves of it.
_SHARE = 1e-9


Least = tuple[float, float]  # m, rad
NOTHING: Least = (_LEAST, _LEAST)


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


def number(value: float, other: float | None = None) -> str:
    """Return a number in print, with the digits that tell it from another one."""
    if other is not None and other != value:
        return number_pair(value, other)[0]
    return six_digits(value)


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
    pairs = zip(old, new, strict=True)
    before, after = zip(*((number(a, b), number(b, a)) for a, b in pairs), strict=True)
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


def value_change(about: About, old: Value | None, new: Value | None) -> Sentence:
    """Return what became of a value; None where it is not given."""
    row = Row(about.name, about.quantity)
    if old is None or new is None:
        given = value_text(new or old)
        text = f"{about}: new, {given}" if new else f"{about}: removed, was {given}"
        return Sentence(
            text, "", row._replace(**({"after": given, "by": "new"} if new else {"before": given, "by": "removed"}))
        )
    if isinstance(old.value, str) or isinstance(new.value, str):
        both = isinstance(old.value, str) and isinstance(new.value, str)
        before, after = _text_pair(str(old.value), str(new.value)) if both else (value_text(old), value_text(new))
        return Sentence(f"{about} {before} -> {after}", "", row._replace(before=before, after=after))
    before, after = number_pair(old.value, new.value)
    unit = f" {new.unit}" if new.unit else ""
    by = step(new.value - old.value, old.value, new.unit)
    return Sentence(
        f"{about} {before} -> {after}{unit}", by, row._replace(before=before + unit, after=after + unit, by=by)
    )


def number_change(about: About, old: float | None, new: float | None, unit: str) -> Sentence:
    """Return what became of a number; None where it is not given."""
    values = [None if value is None else Value(float(value), unit) for value in (old, new)]
    return value_change(about, values[0], values[1])


def value_text(value: Value | None) -> str:
    """Return a value in print; a text of several words in quotes, and shortened."""
    if value is None:
        return "nothing"
    if not isinstance(value.value, str):
        return value.shown()
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
    least: Least = NOTHING,
) -> Sentence:
    """Return what became of where a frame sits, before and after.

    ``apart`` is how far it moved (m) and turned (rad), ``others`` are frames that went with it. In another parent the
    numbers alone are said: what happened is said of the parent. ``least`` as in ``coordinates``.
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


def coordinates(old: Pose, new: Pose, distance: float, angle: float, least: Least = NOTHING) -> list[Step]:
    """Return which coordinates changed, of which something did; steps of ``least`` and below are none."""
    length, turn = least
    named = [*zip(AXES, old.xyz, new.xyz, strict=True)] if distance else []
    turned = [*zip(ANGLES, old.rpy, new.rpy, strict=True)] if angle else []
    length, turn = max(length, _SHARE * distance), max(turn, _SHARE * angle)
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


def pose_text(pose: Pose) -> str:
    """Return a pose as a text of six numbers."""
    return f"xyz {row(pose.xyz)} rpy {row(pose.rpy)}"


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


def mimic_change(joint: str, old: str, new: str) -> Sentence:
    """Return what became of what a joint follows (see ``mimic_text``)."""
    return Sentence(f"{joint} mimics {old} -> {new}", "", Row(joint, "mimics", old, new))


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


def inertia_change(link: str, old: Sequence[float], new: Sequence[float], changed: Sequence[bool]) -> Sentence:
    """Return what became of an inertia (kg*m^2; xx yy zz xy xz yz), of which some entries changed."""
    entries = zip(INERTIA, old, new, changed, strict=True)
    steps = [Step(f"i{name}", *number_pair(a, b), "kg*m^2") for name, a, b, is_new in entries if is_new]
    parts = [f"{one.name} {one.before} -> {one.after}" for one in steps]
    share = max(abs(b - a) for a, b in zip(old, new, strict=True)) / max(map(abs, (*old, *new)))
    percent = f"{share * 100:.2g}" if share < 0.995 else f"{share * 100:.0f}"
    by = f"{percent} % of the largest moment"
    row = steps_row(link, steps, "inertia")
    if len(steps) == 1:
        row = row._replace(quantity=f"inertia {steps[0].name}")
    return Sentence(f"{link} inertia {', '.join(parts)} kg*m^2", f"by {by}", row._replace(by=by))


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
    remark = ", ".join(filter(None, how))
    row = Row(name, what, by=word)
    row = row._replace(after=remark) if word == NEW else row._replace(before=remark)
    sentence = Sentence(f"{word}: {what} {name}", remark, row)
    if not others:
        return sentence
    with_it = f", and with it {several(others)}"
    return Sentence(f"{sentence}{with_it}", "", row._replace(what=f"{name}{with_it}"))


def renamed(what: str, old: str, new: str) -> Sentence:
    """Return that a link or a joint is called otherwise."""
    return Sentence(f"{what} {old} renamed to {new}", "", Row(new, f"name of the {what}", old, new, "renamed"))


def contacts_change(new: Sequence[str], removed: Sequence[str], title: str = "excluded contacts") -> Sentence:
    """Return which pairs of links are excluded from contact now, or no more; or are what the title says."""
    shown = {}
    for pairs, what in ((new, NEW), (removed, REMOVED)):
        rest = f", {len(pairs) - _MAX_PAIRS} more" if len(pairs) > _MAX_PAIRS else ""
        shown[what] = f"{', '.join(pairs[:_MAX_PAIRS])}{rest}"
    counts = {what: f"{len(pairs)} {what}" for pairs, what in ((new, NEW), (removed, REMOVED)) if pairs}
    text = ", ".join(f"{count} ({shown[what]})" for what, count in counts.items())
    row = Row(title, "", shown[REMOVED], shown[NEW], ", ".join(counts.values()))
    return Sentence(f"{title}: {text}", "", row)


def colour_change(about: About, old: str, new: str) -> Sentence:
    """Return what became of a colour, in numbers."""
    colours = old or "none", new or "none"
    text = f"{about} colour {' -> '.join(colours)}"
    return Sentence(text, "", Row(about.name, f"{about.quantity} colour", *colours))


def cells_change(link: str, steps: Sequence[float], cells: tuple[str, str]) -> Sentence:
    """Return what became of a height map: ``steps`` (m) of its heights, and its cells in words before and after."""
    made = Row(link, "height map")
    if cells[0] != cells[1]:
        made = made._replace(before=f"{cells[0]} cells", after=f"{cells[1]} cells")
    parts = [f"{cells[0]} -> {cells[1]} cells"] if cells[0] != cells[1] else []
    if steps:
        up_to = "by up to" if len(steps) > 1 else "by"
        made = made._replace(by=f"{counted(len(steps), 'cell')}, {up_to} {amount(max(steps), 'm')}")
        parts.append(f"{counted(len(steps), 'cell')} changed, {up_to} {amount(max(steps), 'm')}")
    return Sentence(f"{link} height map: {', '.join(parts)}", "", made)
