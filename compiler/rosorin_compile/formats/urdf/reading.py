"""Read XML elements that describe a robot: attributes, numbers, unknown words, and everything that is wrong in them.

``Reading`` is shared by the readers of URDF, SDF and SRDF. The tables of this module are the grammar of URDF
(http://wiki.ros.org/urdf/XML, ``ros/urdfdom@jazzy:urdf_parser``).
"""

from __future__ import annotations

import math
import re
from collections.abc import Collection, Iterable, Mapping
from dataclasses import replace
from typing import Any

from rosorin_compile.rules.check import acceptable
from rosorin_compile.rules.magnitudes import FAR, FULL_TURN
from rosorin_compile.source.diagnostics import ERROR, NOTE, Diagnostic, Help, Related, Span, error
from rosorin_compile.source.rule_registry import READING, Rule
from rosorin_compile.source.tree import Map, Path, Seq, Text
from rosorin_compile.source.units import ANGLE, LENGTH, Quantity
from rosorin_compile.source.wording import counted, plural, quoted
from rosorin_compile.source.xml.elements import indented
from rosorin_compile.source.xml.markup import INSTRUCTION, TEXT, Element, Word

from ..format import cannot_carry
from ..imported import LeftOut, ReadOptions
from .magnitudes import LIMIT, ORIGIN, SIZE, Magnitudes

RULES = (
    Rule(
        "missing-attribute",
        "An element lacks an attribute that the specification asks for, or it is empty.",
        "Add it.",
        READING,
    ),
    Rule(
        "duplicate-element",
        "An element that is taken once stands twice, or two say the same thing.",
        "Remove one; `--lenient` takes the first.",
        READING,
    ),
    Rule(
        "misspelt",
        "An element or attribute that no reader knows is near to one that they know.",
        "Correct it; `--lenient` leaves it out.",
        READING,
    ),
    Rule(
        "import-ignored",
        "A note: something has no effect for any reader, such as the limit of a fixed joint.",
        topic=READING,
    ),
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
)

# Units that decide from which size on a number is written with its unit.
ANGLES, LENGTHS, PLAIN = "rad", "m", ""
_POSITION_UNIT = "q"  # that of the position of the joint
_LIMITS = {ANGLES: (ANGLE, FULL_TURN), LENGTHS: (LENGTH, FAR)}

# Types of joints, with the units of their positions.
TYPES = {"revolute": "rad", "continuous": "rad", "prismatic": "m", "fixed": "", "floating": "", "planar": "m"}
SHAPES = ("box", "cylinder", "sphere", "capsule", "mesh")
JOINT_PARTS = ("axis", "limit", "mimic", "dynamics", "calibration", "safety_controller")
CHILDREN = {
    "robot": ("link", "joint", "material"),
    "link": ("inertial", "visual", "collision"),
    "inertial": ("origin", "mass", "inertia"),
    "visual": ("origin", "geometry", "material"),
    "collision": ("origin", "geometry"),
    "geometry": SHAPES,
    "material": ("color", "texture"),
    "joint": ("origin", "parent", "child", *JOINT_PARTS),
}
TEXTS = {
    "robot": ("name", "version"),
    "joint": ("name", "type"),
    **dict.fromkeys(("link", "visual", "collision", "material"), ("name",)),
    **dict.fromkeys(("parent", "child"), ("link",)),
    **dict.fromkeys(("mesh", "texture"), ("filename",)),
    "mimic": ("joint",),
}
_LENGTH, _POSITION, _ONE = (1, LENGTHS), (1, _POSITION_UNIT), (1, PLAIN)
# The attributes with numbers: how many, and their unit if its size matters.
NUMBERS: Mapping[str, Mapping[str, tuple[int, str]]] = {
    "origin": {"xyz": (3, LENGTHS), "rpy": (3, ANGLES), "quat_xyzw": (4, PLAIN)},
    "mass": {"value": _ONE},
    "inertia": dict.fromkeys(("ixx", "iyy", "izz", "ixy", "ixz", "iyz"), _ONE),
    "box": {"size": (3, LENGTHS)},
    "cylinder": {"radius": _LENGTH, "length": _LENGTH},
    "sphere": {"radius": _LENGTH},
    "capsule": {"radius": _LENGTH, "length": _LENGTH},
    "mesh": {"scale": (3, PLAIN)},
    "color": {"rgba": (4, PLAIN)},
    "axis": {"xyz": (3, PLAIN)},
    "limit": {"lower": _POSITION, "upper": _POSITION, "effort": _ONE, "velocity": _ONE},
    "mimic": {"multiplier": _ONE, "offset": _POSITION},
    "dynamics": {"damping": _ONE, "friction": _ONE},
    "calibration": dict.fromkeys(("rising", "falling", "reference_position"), _POSITION),
    "safety_controller": {
        **dict.fromkeys(("soft_lower_limit", "soft_upper_limit"), _POSITION),
        **dict.fromkeys(("k_position", "k_velocity"), _ONE),
    },
}


def attributes(tag: str) -> tuple[str, ...]:
    """Return the attributes that an element of URDF has."""
    return (*TEXTS.get(tag, ()), *NUMBERS.get(tag, ()))


_ATTRIBUTES = {"iyx", "izx", "izy", *(name for tag in (*TEXTS, *NUMBERS) for name in attributes(tag))}
_DECIDING = ("origin", "pose", "parent", "child", "axis", "xyz", "limit", "mimic", "geometry", "mass", "inertia")

# A name in a description, as its schema has it.
NAME = re.compile(r"""[^\s<>&"']+( +[^\s<>&"']+)*\Z""")
_NAMED = re.compile(r'(<[^\s>]+) name="[^"]*">')  # see ``named``
_NUMBER = re.compile(r"[-+]?(?:[0-9]+(?:\.[0-9]*)?|\.[0-9]+)(?:[eE][-+]?[0-9]+)?\Z")
_INTEGER = re.compile(r"[-+]?[0-9]{1,18}\Z")
_LINE_END = re.compile("\r\n|\r")


class Reading:
    """One reading of a file: collects diagnostics, what is left out, and which entry an element became.

    Without ``spelling``, elements with unknown names are kept, even where their names look misspelt.
    """

    def __init__(self, options: ReadOptions, spelling: bool = True) -> None:
        self.options = options
        self.spelling = spelling
        self.diagnostics: list[Diagnostic] = []
        self.paths: dict[int, Path] = {}
        self.joints: frozenset[str] = frozenset()  # the names of all joints of the file
        self.magnitudes = Magnitudes()
        self._ignored: dict[str, list[Span]] = {}
        self._left_out: dict[tuple[str, str], list[LeftOut]] = {}
        self._first: dict[tuple[str, str], Diagnostic] = {}

    def error(self, rule: str, message: str, span: Span, help: Help = "", related: Iterable[Related] = ()) -> None:
        """Report that the file is broken."""
        self.diagnostics.append(error(rule, message, span, help, related))

    def note(self, rule: str, message: str, span: Span) -> None:
        """Report something that is read otherwise than it is written."""
        self.diagnostics.append(Diagnostic(rule, NOTE, message, span))

    def lenient(self, rule: str, message: str, span: Span, help: Help, instead: str) -> bool:
        """Report something broken that --lenient reads as ``instead`` says; return True if it is read."""
        if not self.options.lenient:
            self.error(rule, message, span, f"{help if isinstance(help, str) else help()}; --lenient {instead}")
            return False
        if rule not in acceptable():  # otherwise the accepted rule reports it
            self.note(rule, f"{message}; --lenient {instead}", span)
        return True

    def spoilt(self, element: Element, what: str, before: int) -> bool:
        """Return True if there are errors among the diagnostics from ``before`` on.

        With --lenient a warning that the element is left out replaces them.
        """
        reported = self.diagnostics[before:]
        wrong = [one for one in reported if one.severity == ERROR]
        if wrong and self.options.lenient:
            self.diagnostics[before:] = [one for one in reported if one not in wrong]
            self.cannot_carry(named(element), element.span, wrong[0].message)
        elif wrong:
            hint = f"--lenient leaves {what} out"
            reported = [one.worded() for one in reported]
            wrong = [one for one in reported if one.severity == ERROR]
            self.diagnostics[before:] = [
                replace(one, help=f"{one.help}; {hint}") if one in wrong and "--lenient" not in one.help else one
                for one in reported
            ]
        return bool(wrong)

    def cannot_carry(self, what: str, span: Span, help: str = "") -> None:
        """Report something that the language has no key for, once for each kind, whatever the names."""
        kind = (_NAMED.sub(r"\1>", what), help)
        if kind not in self._left_out:
            self._first[kind] = cannot_carry(what, span, help)
            self.diagnostics.append(self._first[kind])
        self._left_out.setdefault(kind, []).append(LeftOut(what, span))

    def ignored(self, what: str, span: Span) -> None:
        """Report something without effect, once for each ``what``, with the count and the first place."""
        self._ignored.setdefault(what, []).append(span)

    def left_out(self) -> tuple[LeftOut, ...]:
        """Return what the tree does not carry, each kind once."""
        return tuple(
            found[0] if len(found) == 1 else LeftOut(f"{kind} ({len(found)} places)", found[0].span)
            for (kind, _), found in self._left_out.items()
        )

    def all_diagnostics(self) -> list[Diagnostic]:
        """Return all diagnostics, the grouped ones included."""
        whole = {
            id(self._first[kind]): cannot_carry(one.what, one.span, kind[1], others=[again.span for again in found[1:]])
            for one, (kind, found) in zip(self.left_out(), self._left_out.items(), strict=True)
        }
        grouped = []
        for what, spans in self._ignored.items():
            times = f" ({len(spans)} times, first here)" if len(spans) > 1 else ""
            grouped.append(Diagnostic("import-ignored", NOTE, f"{what}{times}", spans[0]))
        return [*(whole.get(id(one), one) for one in self.diagnostics), *grouped, *self.magnitudes.diagnostics()]

    def single(self, element: Element, tag: str) -> Element | None:
        """Return the one child of this tag, or None; a second one is an error if it decides on motion and differs."""
        children = [child for child in element.children if child.tag == tag]
        for again in children[1:]:
            if _same(children[0], again):
                self.ignored(f"a second <{tag}>, the same as the first, has no effect", again.span)
            elif tag in _DECIDING and not self.options.lenient:
                message = f"{named(element)} has a second <{tag}>; readers differ in which of them they take"
                related = [Related("the first", children[0].span)]
                self.error("duplicate-element", message, again.span, "remove one; --lenient takes the first", related)
            else:
                self.cannot_carry(f"a second <{tag}> of {named(element)}", again.span, "the first is taken")
        return children[0] if children else None

    def attribute(self, element: Element, name: str) -> str | None:
        """Return a required attribute, or None after an error."""
        self.need(element, name)
        own = element.attributes.get(name)
        return None if own is None else own.value

    def need(self, element: Element, *names: str) -> None:
        """Report required attributes that are missing; a misspelt one has its own message."""
        missing = self.missing(element, *names)
        if missing:
            message = f"{named(element)} lacks the {plural('attribute', len(missing))} {quoted(missing)}"
            help = "add " + " ".join(f'{name}="..."' for name in missing)
            self.error("missing-attribute", message, element.span, help)

    def missing(self, element: Element, *names: str) -> list[str]:
        """Return the attributes that an element lacks, without those that are reported as misspelt."""
        missing = [name for name in names if name not in element.attributes]
        if self.options.lenient:
            return missing
        others = [other for other in element.attributes if other not in _ATTRIBUTES]
        return [name for name in missing if not any(correction(other, [name]) for other in others)]

    def check(self, element: Element, tags: Collection[str], attributes: Collection[str], keep: Map | None) -> None:
        """Report unknown attributes and children of an element: misspelt, kept in ``keep``, or not carried over."""
        self.known_attributes(element, attributes)
        for child in element.children:
            if child.tag in tags:
                continue
            if child.tag.startswith("xacro:"):
                help = "readers of URDF pass over it; name the file NAME.xacro to have it expanded"
                self.cannot_carry(f"<{child.tag}> in {named(element)}", child.span, help)
                continue
            near = correction(child.tag, tags) if self.spelling else None
            if near is not None:
                self._misspelt(f"<{child.tag}>", f"<{near}>", element, child.span)
            elif keep is None:
                self.cannot_carry(f"<{child.tag}> in {named(element)}", child.span)
            else:
                self.keep(child, keep)
        for item in element.content:
            if not isinstance(item, Element) and item.kind in (TEXT, INSTRUCTION):
                what = "text between elements" if item.kind == TEXT else "an instruction <?...?>"
                span = element.document.span(item.start, min(item.end - item.start, 40))
                self.ignored(f"{what} has no meaning to any reader", span)

    def known_attributes(self, element: Element, attributes: Collection[str]) -> None:
        """Report attributes that a reader of this element does not know."""
        for attribute in element.attributes.values():
            name, what = attribute.name, f'the attribute "{attribute.name}"'
            if name in attributes or name.startswith("xmlns"):
                continue
            near = correction(name, [other for other in attributes if other not in element.attributes])
            if near is None:
                self.cannot_carry(f"{what} of {named(element)}", attribute.name_span)
            else:
                self._misspelt(what, f'"{near}"', element, attribute.name_span)

    def _misspelt(self, what: str, near: str, element: Element, span: Span) -> None:
        if self.options.lenient:
            self.cannot_carry(f"{what} of {named(element)}", span, f"did you mean {near}?")
        else:
            message = f"{named(element)} has {what}, which no reader knows"
            self.error("misspelt", message, span, f"did you mean {near}? --lenient leaves it out")

    def keep(self, element: Element, entry: Map) -> None:
        """Keep an element as it is, in ``urdf_elements`` of an entry."""
        entry.setdefault_at("urdf_elements", Seq(element.span), element.span)
        above = self.paths.get(id(element.parent), ())
        inside = () if above == ("robot",) else above
        self.paths[id(element)] = (*inside, "urdf_elements", len(entry["urdf_elements"]))
        entry["urdf_elements"].put(kept(element), element.span)


def check_element(element: Element, reading: Reading, keep: Map | None = None) -> None:
    """Report what no reader of URDF knows in an element; ``keep`` as for ``Reading.check``."""
    reading.check(element, CHILDREN.get(element.tag, ()), attributes(element.tag), keep)


def _same(first: Element, second: Element) -> bool:
    """Return True if two elements are equal without text, comments and the order of attributes."""
    if first.tag != second.tag or len(first.children) != len(second.children):
        return False
    texts = ({item.name: item.value for item in element.attributes.values()} for element in (first, second))
    return next(texts) == next(texts) and all(map(_same, first.children, second.children))


def named(element: Element) -> str:
    """Return an element in words: its tag, with its name or that of the element that contains it."""
    name = element.get("name")
    if name:
        return f'<{element.tag} name="{name}">'
    above = element.parent
    while above is not None and not above.get("name"):
        above = above.parent
    if above is None or above.parent is None:
        return f"<{element.tag}>"
    return f'<{element.tag}> of <{above.tag} name="{above.get("name")}">'


def put(entry: Map, key: str, value: Any, element: Element) -> None:
    """Set a key whose value is that of a whole element."""
    entry.put(key, value, element.span, element.span)


def correction(word: str, known: Iterable[str]) -> str | None:
    """Return the known word that ``word`` is a misspelling of, None if it is a word of its own.

    One letter too many, too few, wrong or swapped is a misspelling, of long words two; so is another case. A word with
    a prefix (``drake:mass``) belongs to somebody.
    """
    if ":" in word:
        return None
    best: tuple[int, str] | None = None
    for other in known:
        allowed = 0 if min(len(word), len(other)) < 3 else 1 if len(other) < 7 else 2
        if abs(len(word) - len(other)) > allowed:
            continue
        distance = 0 if word.lower() == other.lower() else _distance(word.lower(), other.lower())
        if distance <= allowed and (best is None or (distance, other) < best):
            best = (distance, other)
    return best[1] if best else None


def _distance(one: str, other: str) -> int:
    """Return how many letters are added, left out, changed or swapped (optimal string alignment)."""
    before: list[int] = []
    last = list(range(len(other) + 1))
    for i, a in enumerate(one, 1):
        row = [i]
        for j, b in enumerate(other, 1):
            cost = min(last[j] + 1, row[-1] + 1, last[j - 1] + (a != b))
            if i > 1 and j > 1 and a == other[j - 2] and one[i - 2] == b:
                cost = min(cost, before[j - 2] + 1)
            row.append(cost)
        before, last = last, row
    return last[-1]


def kept(element: Element, text: str = "") -> Text:
    """Return an element as text: as it stands, its further lines moved left, where space means nothing.

    ``text`` is what stands for it where something in it has been renamed.

    A prefix that an element around it declares (``xmlns:sim``) is declared in the text, so that it can stand alone.
    """
    text = _LINE_END.sub("\n", text or element.verbatim)
    declared = _declared(element)
    if declared:
        at = 1 + len(element.tag)
        text = text[:at] + "".join(f' xmlns:{prefix}="{address}"' for prefix, address in declared) + text[at:]
    return Text(indented(text, ""))


def _declared(element: Element) -> list[tuple[str, str]]:
    """Return the prefixes used in an element that are declared around it, with their addresses."""
    used: dict[str, None] = {}
    own: set[str] = set()
    for inner in element.iter():
        for name in (inner.tag, *inner.attributes):
            prefix, colon, rest = name.partition(":")
            if prefix == "xmlns":
                own.add(rest)
            elif colon:
                used[prefix] = None
    declared = []
    for prefix in used:
        above = element.parent
        while above is not None and f"xmlns:{prefix}" not in above.attributes:
            above = above.parent
        if above is not None and prefix not in own:
            declared.append((prefix, above.attributes[f"xmlns:{prefix}"].raw.replace('"', "&quot;")))
    return declared


def number_of(word: Word, unit: str, element: Element, name: str, reading: Reading) -> float | None:
    """Return the number that a word of an attribute is, or None after an error.

    An angle beyond a full turn and a length beyond any robot become quantities with their unit: the rules about numbers
    that look like degrees or millimetres are for what people write.
    """
    text, what = word.text, f"{name} of {named(element)}"
    if not _NUMBER.match(text):
        reading.error("not-a-number", f"{what}: {shortened(text)} is not a number", word.span, _advice(text))
        return None
    value: float = int(text) if _INTEGER.match(text) else float(text)
    if not math.isfinite(value):
        reading.error("not-a-number", f"{what}: {shortened(text)} is too large for a number", word.span, "correct it")
        return None
    if unit not in _LIMITS:
        return value
    dimension, far = _LIMITS[unit]
    is_far = abs(value) > far
    where = ORIGIN if element.tag == "origin" else SIZE if element.tag in SHAPES else LIMIT
    reading.magnitudes.take(unit, value, where, f"{what} is {text} {unit}" if is_far else "", word.span)
    return Quantity(value, dimension, f"{text} {unit}") if is_far else value


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
    """Return the numbers of an attribute as a list, or None if it is missing or after an error."""
    attribute = element.attributes.get(name)
    if attribute is None:
        return None
    words = attribute.words()
    # A comma between numbers makes a word that is no number, which is the better message.
    if len(words) != count and (count == 1 or all(_NUMBER.match(word.text) for word in words)):
        have = "is empty" if not words else f"has {counted(len(words), 'number')}"
        message = f"{name} of {named(element)} {have}; it takes {'one' if count == 1 else count}"
        reading.error("wrong-count", message, attribute.span, f"give {'one number' if count == 1 else count}")
        return None
    made = Seq(attribute.span)
    for word in words:
        value = number_of(word, unit, element, name, reading)
        if value is None:
            return None
        made.put(value, word.span)
    if count > 1 and any(letter in attribute.raw.strip() for letter in "\t\n\r"):
        message = "numbers are parted by a tab or a line end; urdfdom, the reader of ROS, splits at spaces alone"
        reading.ignored(message, attribute.span)
    return made


def put_numbers(
    entry: Map, element: Element, name: str, reading: Reading, key: str = "", position: str = PLAIN
) -> None:
    """Set a key (default: the name) to the numbers of an attribute, if there is one.

    ``position`` is the unit of the position of the joint that the element belongs to.
    """
    count, unit = NUMBERS[element.tag][name]
    made = numbers(element, name, count, position if unit == _POSITION_UNIT else unit, reading)
    if made is not None:
        span = made.span if count > 1 else made.value_spans[0]
        entry.put(key or name, made if count > 1 else made[0], element.attributes[name].name_span, span)


def put_all(entry: Map, element: Element, reading: Reading, position: str = PLAIN, zero: Collection[str] = ()) -> None:
    """Set the keys of all numbers of an element; those of ``zero`` are 0 where the attribute is missing."""
    for name in NUMBERS[element.tag]:
        if name in zero and name not in element.attributes:
            entry.put(name, 0, element.span, element.span)
        put_numbers(entry, element, name, reading, position=position)
