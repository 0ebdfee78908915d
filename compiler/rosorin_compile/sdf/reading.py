"""Reading: the numbers and poses of an SDF, which stand in the text of its elements, each with its place."""

from __future__ import annotations

import math
import re
from collections.abc import Collection, Sequence
from typing import NamedTuple

from rosorin_compile.formats.format import Placed
from rosorin_compile.formats.urdf.reading import Reading, correction, named
from rosorin_compile.model import Pose, Transform
from rosorin_compile.rules.magnitudes import FAR, FULL_TURN
from rosorin_compile.source.diagnostics import NOTE, Diagnostic, Span, counted
from rosorin_compile.source.units import ANGLE, LENGTH, Quantity
from rosorin_compile.source.xml.markup import TEXT, Element, Remark, Word

_NUMBER = re.compile(r"[-+]?(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][-+]?[0-9]+)?\Z")
_ENDLESS = re.compile(r"[-+]?(?:inf|infinity)\Z", re.I)
_OF_POSE = ("relative_to", "frame", "rotation_format", "degrees")
UNLIMITED = 1e16  # from here on, a limit is none
_UNITS = {"rad": (ANGLE, FULL_TURN), "m": (LENGTH, FAR)}
# As ``Pose`` has it: below this, the numbers of a pose are what rounding has left of a way there and back.
_ROUNDING = 1e-15


class Said(NamedTuple):
    """A pose as it was written: its transform, its numbers with their places where they can stay, its element."""

    transform: Transform
    xyz: Sequence[Placed] = ()
    rpy: Sequence[Placed] = ()
    element: Element | None = None


def words(element: Element) -> list[Word]:
    """Return the words of the text of an element, each with its place."""
    text = element.document.source.text
    found: list[Word] = []
    for item in element.content:
        if not isinstance(item, Remark) or item.kind != TEXT:
            continue
        raw = text[item.start : item.end]
        if "&" in raw or "<" in raw:  # references, CDATA
            found += [Word(word, element.span) for word in item.text.split()]
            continue
        for match in re.finditer(r"\S+", raw):
            found.append(Word(match[0], element.document.span(item.start + match.start(), len(match[0]))))
    return found


def place(element: Element) -> Span:
    """Return the place of what an element says: its first word, or the element itself."""
    found = words(element)
    return found[0].span if len(found) == 1 else element.span


class Numbers:
    """Takes numbers out of elements; what is wrong with them goes to ``reading``."""

    def __init__(self, reading: Reading) -> None:
        self.reading = reading

    def text(self, element: Element, tag: str) -> Placed | None:
        """Return the text of a child, with its place; None if it is not there or empty."""
        child = self.reading.single(element, tag)
        if child is None or not child.text:
            return None
        return Placed(child.text, place(child))

    def flag(self, element: Element, tag: str) -> bool:
        """Say whether a child says true."""
        child = self.reading.single(element, tag)
        return child is not None and child.text.lower() in ("1", "true")

    def all_of(self, element: Element, count: int, unit: str = "") -> list[Placed] | None:
        """Return the numbers that an element says; None after an error."""
        found = words(element)
        if len(found) != count:
            have = "is empty" if not found else f"has {counted(len(found), 'number')}"
            message = f"{named(element)} {have}; it takes {count}"
            self.reading.error("wrong-count", message, element.span, f"give {count}")
            return None
        values = [self.number(element, word, unit) for word in found]
        return None if None in values else [Placed(v, w.span) for v, w in zip(values, found, strict=True)]

    def one(self, element: Element, tag: str, unit: str = "") -> Placed | None:
        """Return the number of a child; None if it is not there, or after an error."""
        child = self.reading.single(element, tag)
        if child is None:
            return None
        found = self.all_of(child, 1, unit)
        return found[0] if found else None

    def limit(self, element: Element | None, tag: str, unit: str) -> Placed | None:
        """Return a limit; None if it is not there, or none, or after an error."""
        child = self.reading.single(element, tag) if element is not None else None
        if child is None or _ENDLESS.match(child.text):
            return None
        found = self.all_of(child, 1, unit)
        return found[0] if found and abs(found[0].value) < UNLIMITED else None

    def number(self, element: Element, word: Word, unit: str) -> float | None:
        """Return a number; one beyond any robot with its unit, so that nobody takes it for another unit."""
        if not _NUMBER.match(word.text) or not math.isfinite(float(word.text)):
            message = f'{named(element)}: "{word.text[:40]}" is not a number'
            help = (
                "write a finite number"
                if _ENDLESS.match(word.text) or word.text.lower() == "nan"
                else "write a number such as 0.5 or 1e-3"
            )
            self.reading.error("not-a-number", message, word.span, help)
            return None
        value = float(word.text)
        if unit in _UNITS and abs(value) > _UNITS[unit][1]:
            return Quantity(value, _UNITS[unit][0], f"{word.text} {unit}")
        return int(value) if value.is_integer() and word.text.lstrip("+-").isdigit() and abs(value) < 1e15 else value

    def pose(self, element: Element | None) -> Said:
        """Return what a <pose> says; without one, or an empty one, nothing is moved."""
        if element is None or not words(element):
            return Said(Transform(), element=element)
        form = element.get("rotation_format", "euler_rpy")
        if form == "quat_xyzw":
            return self._by_quaternion(element)
        if form != "euler_rpy":
            message, span = (
                f'the rotation of {named(element)} is in "{form}"',
                element.attributes["rotation_format"].span,
            )
            self.reading.error("wrong-value", message, span, "one of euler_rpy, quat_xyzw")
        self.reading.known_attributes(element, _OF_POSE)
        found = self.all_of(element, 6)
        if found is None:
            return Said(Transform(), element=element)
        degrees = element.get("degrees").lower() in ("1", "true")
        xyz = [self._with_unit(one, "m") for one in found[:3]]
        turns = [math.radians(one.value) if degrees else one.value for one in found[3:]]
        rpy = [self._with_unit(Placed(turn, one.span), "rad") for turn, one in zip(turns, found[3:], strict=True)]
        x, y, z, a, b, c = (float(one.value) for one in (*xyz, *rpy))
        return Said(Pose((x, y, z), (a, b, c)).transform(), xyz, rpy, element)

    def _with_unit(self, one: Placed, unit: str) -> Placed:
        dimension, far = _UNITS[unit]
        return Placed(Quantity(one.value, dimension, f"{one.value} {unit}"), one.span) if abs(one.value) > far else one

    def _by_quaternion(self, element: Element) -> Said:
        found = self.all_of(element, 7)
        if found is None:
            return Said(Transform(), element=element)
        x, y, z, a, b, c, w = (float(one.value) for one in found)
        if not any((a, b, c, w)):
            message = f"the quaternion of {named(element)} is zero: no rotation"
            self.reading.error("zero-quaternion", message, element.span, "correct it")
            return Said(Transform(), element=element)
        return Said(Transform.of_quaternion((x, y, z), (w, a, b, c)), found[:3], (), element)


def others(reading: Reading, element: Element, known: Collection[str], attributes: Collection[str]) -> list[Element]:
    """Return the elements within one that are none of the known words, nor misspelt ones, which are told."""
    strange = [child for child in element.children if child.tag not in known and not child.tag.startswith("xacro:")]
    found = [child for child in strange if correction(child.tag, known) is None]
    reading.check(element, [*known, *(child.tag for child in found)], attributes, None)
    return found


def entry_of(said: Said, span: Span) -> dict[str, Placed]:
    """Return ``xyz`` and ``rpy`` of an entry: the numbers as they were written, or those of the transform."""
    xyz = said.xyz if said.xyz else [Placed(cleaned(value), span) for value in said.transform.xyz]
    rpy = said.rpy if said.rpy else [Placed(cleaned(value), span) for value in said.transform.rpy()]
    made = {"xyz": xyz, "rpy": rpy}
    return {key: Placed(list(values), values[0].span) for key, values in made.items() if any(v.value for v in values)}


def cleaned(value: float) -> float:
    """Return a number that was calculated without what rounding has left in it."""
    return 0.0 if abs(value) < _ROUNDING else float(f"{value:.15g}")


def changed(reading: Reading, what: str, span: Span) -> None:
    """Say that something is carried over, but not as the file says it."""
    reading.diagnostics.append(Diagnostic("import-changed", NOTE, what, span))


def converted(reading: Reading, what: str, span: Span) -> None:
    """Say that the same is said in another form."""
    reading.diagnostics.append(Diagnostic("import-converted", NOTE, what, span))
