"""Values: the numbers of attributes, each with its place, as the readers of URDF take them.

``put_origin`` makes position and orientation of an origin the ``xyz`` and ``rpy`` of an entry.
"""

from __future__ import annotations

import math
import re
from typing import Any

from rosorin_compile.model.geometry import Transform
from rosorin_compile.rules.magnitudes import FAR, FULL_TURN
from rosorin_compile.source.diagnostics import NOTE, Diagnostic, Span
from rosorin_compile.source.rule_registry import READING, Rule
from rosorin_compile.source.tree import Map, Path, Seq
from rosorin_compile.source.units import ANGLE, LENGTH, Quantity
from rosorin_compile.source.wording import counted
from rosorin_compile.source.xml.markup import Attribute, Element, Word

from .grammar import NUMBERS, SHAPES
from .magnitudes import LIMIT, ORIGIN, SIZE
from .reading import Reading, check_element, named

RULES = (
    Rule(
        "not-a-number",
        "Something that is to be a number is none, or is not finite.",
        "Write digits, a point, and no unit.",
        READING,
    ),
    Rule(
        "wrong-count",
        "An attribute has too many or too few numbers.",
        "The message says how many it takes.",
        READING,
    ),
    Rule("zero-quaternion", "A quaternion is zero, which is no rotation.", "Correct it.", READING),
    Rule("import-converted", "A note: the same is said in another form.", topic=READING),
)


_NUMBER = re.compile(r"[-+]?(?:[0-9]+(?:\.[0-9]*)?|\.[0-9]+)(?:[eE][-+]?[0-9]+)?\Z")
_INTEGER = re.compile(r"[-+]?[0-9]{1,18}\Z")

# What a number may stand for: its unit decides from which size on it is written with it.
ANGLES, LENGTHS, PLAIN = "rad", "m", ""
_LIMITS = {ANGLES: (ANGLE, FULL_TURN), LENGTHS: (LENGTH, FAR)}


def number_of(word: Word, unit: str, element: Element, name: str, reading: Reading) -> float | None:
    """Return the number that a word of an attribute is; None after an error.

    An angle beyond a full turn and a length beyond any robot are quantities with their unit: the rules about numbers
    that look like degrees or millimetres are for what people write, and here nobody is left to ask.
    """
    text = word.text
    if not _NUMBER.match(text):
        message = f"{_what(element, name)}: {shortened(text)} is not a number"
        reading.error("not-a-number", message, word.span, _advice(text))
        return None
    value: float = int(text) if _INTEGER.match(text) else float(text)
    if not math.isfinite(value):
        message = f"{_what(element, name)}: {shortened(text)} is too large for a number"
        reading.error("not-a-number", message, word.span, "correct it")
        return None
    if unit not in _LIMITS:
        return value
    dimension, far = _LIMITS[unit]
    what = f"{_what(element, name)} is {text} {unit}" if abs(value) > far else ""
    where = ORIGIN if element.tag == "origin" else SIZE if element.tag in SHAPES else LIMIT
    reading.magnitudes.take(unit, value, where, what, word.span)
    return Quantity(value, dimension, f"{text} {unit}") if what else value


def _what(element: Element, name: str) -> str:
    return f"{name} of {named(element)}"


def _advice(text: str) -> str:
    lower = text.lower().lstrip("+-")
    if lower in ("nan", "inf", "infinity"):
        return "write a finite number"
    if "$" in text:
        return "this is xacro: name the file NAME.xacro, or declare xmlns:xacro"
    if "," in text:
        return "write a point in numbers and a space between them"
    if lower.startswith("0x"):
        return "write it in decimal"
    if text[:1].isdigit() or text[:1] in "+-.":
        return "write digits alone: values are in metres, radians and kilograms and carry no unit"
    return "write a number such as 0.5 or 1e-3"


def shortened(text: str, most: int = 40) -> str:
    """Return a text in quotes, shortened and on one line."""
    text = text if len(text) <= most else f"{text[: most - 3]}..."
    return f'"{text}"'


def numbers(element: Element, name: str, count: int, unit: str, reading: Reading) -> Seq | None:
    """Return the numbers of an attribute as a list; None if it is not there, or after an error."""
    attribute = element.attributes.get(name)
    if attribute is None:
        return None
    words = attribute.words()
    if len(words) != count and not (words and _joined(words)):
        have = "is empty" if not words else f"has {counted(len(words), 'number')}"
        message = f"{_what(element, name)} {have}; it takes {count}"
        reading.error("wrong-count", message, attribute.span, f"give {count}")
        return None
    made = Seq(attribute.span)
    for word in words:
        value = number_of(word, unit, element, name, reading)
        if value is None:
            return None
        made.put(value, word.span)
    if _split_by_other_than_space(attribute):
        message = "numbers are parted by a tab or a line end; urdfdom, the reader of ROS, splits at spaces alone"
        reading.ignored(message, attribute.span)
    return made


def _joined(words: list[Word]) -> bool:
    """Say whether the count is wrong because of a comma or the like, which is the better message."""
    return any(not _NUMBER.match(word.text) for word in words)


def _split_by_other_than_space(attribute: Attribute) -> bool:
    return any(letter in attribute.raw.strip() for letter in "\t\n\r")


def _number(element: Element, name: str, unit: str, reading: Reading) -> tuple[float, Span] | None:
    """Return the number of an attribute that is there, and its place; None after an error."""
    attribute = element.attributes[name]
    words = attribute.words()
    if len(words) != 1:
        have = "is empty" if not words else f"has {len(words)} numbers"
        message = f"{_what(element, name)} {have}; it takes one"
        reading.error("wrong-count", message, attribute.span, "give one number")
        return None
    value = number_of(words[0], unit, element, name, reading)
    return None if value is None else (value, words[0].span)


def put_numbers(
    entry: Map, element: Element, name: str, reading: Reading, key: str = "", position: str = PLAIN
) -> None:
    """Set a key, by default that of the name, to what an attribute of numbers says, if it is there.

    ``position`` is the unit of the position of the joint that the element is of.
    """
    attribute, said = element.attributes.get(name), NUMBERS[element.tag][name]
    if attribute is None:
        return
    unit = said.unit_at(position)
    if said.many == 1:
        found: tuple[Any, Span] | None = _number(element, name, unit, reading)
    else:
        values = numbers(element, name, said.many, unit, reading)
        found = None if values is None else (values, attribute.span)
    if found is not None:
        entry.put(key or name, found[0], attribute.name_span, found[1])


def put_all(entry: Map, element: Element, reading: Reading, position: str = PLAIN) -> None:
    """Set the keys of all numbers of an element that are there."""
    for name in NUMBERS[element.tag]:
        put_numbers(entry, element, name, reading, position=position)


def put_origin(entry: Map, element: Element, path: Path, reading: Reading) -> None:
    """Set ``xyz`` and ``rpy`` of an entry from the <origin> in an element."""
    origin = reading.single(element, "origin")
    if origin is None:
        return
    check_element(origin, reading)
    reading.paths[id(origin)] = (*path, "xyz" if "xyz" in origin.attributes else "rpy")
    put_numbers(entry, origin, "xyz", reading)
    if "quat_xyzw" not in origin.attributes:
        put_numbers(entry, origin, "rpy", reading)
        return
    attribute = origin.attributes["quat_xyzw"]
    if "rpy" in origin.attributes:
        message = f"{named(origin)} has rpy and quat_xyzw; readers differ in which of them they take"
        reading.error("duplicate-element", message, attribute.name_span, "remove one")
        return
    quaternion = numbers(origin, "quat_xyzw", NUMBERS["origin"]["quat_xyzw"].many, PLAIN, reading)
    if quaternion is None:
        return
    if not any(quaternion):
        reading.error(
            "zero-quaternion", f"quat_xyzw of {named(origin)} is zero: no rotation", attribute.span, "correct it"
        )
        return
    x, y, z, w = quaternion
    rpy = Transform.of_quaternion((0.0, 0.0, 0.0), (w, x, y, z)).rpy()
    made = Seq(attribute.span)
    for angle in rpy:
        made.put(angle + 0.0, attribute.span)
    entry.put("rpy", made, attribute.name_span, attribute.span)
    message = f"quat_xyzw of {named(origin)} became rpy: the same rotation"
    reading.diagnostics.append(Diagnostic("import-converted", NOTE, message, attribute.span))
