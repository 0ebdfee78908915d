"""Read XML elements of URDF, SDF and SRDF, and report invalid numbers and misspelled, missing or duplicate names."""

import math
import re
from collections.abc import Collection, Iterable, Iterator, Sequence
from dataclasses import replace
from typing import Any, NamedTuple

from rosorin_compile.rules.check import acceptable
from rosorin_compile.rules.magnitudes import FAR, FULL_TURN
from rosorin_compile.source.diagnostics import ERROR, NOTE, WARNING, Diagnostic, Help, Related, Span, error
from rosorin_compile.source.messages import gather
from rosorin_compile.source.tree import Map, Path, Seq
from rosorin_compile.source.units import ANGLE, LENGTH, Quantity
from rosorin_compile.source.wording import and_more, count_of, plural, quote
from rosorin_compile.source.xml.elements import canonical, kept_text, numbers_of, tree_of
from rosorin_compile.source.xml.markup import Element, Word, correction, name_of

from .format import cannot_carry
from .imported_robot import ReadOptions

ANGLES, LENGTHS, PLAIN = "rad", "m", ""
UNITS = {ANGLES: (ANGLE, FULL_TURN), LENGTHS: (LENGTH, FAR)}  # (dimension, largest plausible number without a unit)

NAME = re.compile(r"""[^\s<>&"']+( +[^\s<>&"']+)*\Z""")  # the pattern of names in descriptions
NUMBER = re.compile(r"[-+]?(?:[0-9]+(?:\.[0-9]*)?|\.[0-9]+)(?:[eE][-+]?[0-9]+)?\Z")
_INTEGER = r"[-+]?[0-9]{1,18}\Z"
_NAME_IN_TAG = r'(<[^\s>]+) name="[^"]*">'  # see ``name_of``
# Elements that must not occur twice with different contents, because parsers differ in which one they use.
_DECIDING = ("origin", "pose", "parent", "child", "axis", "xyz", "limit", "mimic", "geometry", "mass", "inertia")
_GATHERED = ("import-cannot-carry", "import-ignored")


class _Size(NamedTuple):
    value: float  # rad or m
    tag: str  # tag of its element
    what: str  # description for messages
    span: Span


class XmlReader:
    """Reads the elements of an XML file, and collects diagnostics and the YAML paths of the elements."""

    attributes: Collection[str] = ()  # all attributes of the format

    def __init__(self, options: ReadOptions, spelling: bool = True) -> None:
        self.options, self.spelling = options, spelling
        self.diagnostics: list[Diagnostic] = []
        self.paths: dict[int, Path] = {}  # {id of an element: YAML path of its entry}
        self.joint_types: set[str] = set()
        self._sizes: dict[str, list[_Size]] = {ANGLES: [], LENGTHS: []}

    def error(self, rule: str, message: str, span: Span, help: Help = "", related: Iterable[Related] = ()) -> None:
        self.diagnostics.append(error(rule, message, span, help, related))

    def note(self, rule: str, message: str, span: Span) -> None:
        self.diagnostics.append(Diagnostic(rule, NOTE, message, span))

    def cannot_carry(self, what: str, span: Span, help: str = "") -> None:
        self.diagnostics.append(cannot_carry(what, span, help))

    def ignore(self, what: str, span: Span) -> None:
        self.note("import-ignored", what, span)

    def lenient(self, rule: str, message: str, span: Span, help: Help, instead: str) -> bool:
        """Report a mistake as an error, or with --lenient as a note that states ``instead``. Return True for a note."""
        if not self.options.lenient:
            self.error(rule, message, span, f"{help if isinstance(help, str) else help()}; --lenient {instead}")
        elif rule not in acceptable():  # other mistakes are reported by the rule
            self.note(rule, f"{message}; --lenient {instead}", span)
        return self.options.lenient

    def spoilt(self, element: Element, what: str, before: int) -> bool:
        """Return True if ``diagnostics`` has errors from index ``before`` on; --lenient makes them a single warning."""
        reported = [one.with_help() for one in self.diagnostics[before:]]
        wrong = [one for one in reported if one.severity == ERROR]
        if wrong and self.options.lenient:
            self.diagnostics[before:] = [one for one in reported if one.severity != ERROR]
            self.cannot_carry(name_of(element), element.span, wrong[0].message)
        elif wrong:
            for index, one in enumerate(reported, before):
                if one.severity == ERROR and "--lenient" not in one.help:
                    one = replace(one, help=f"{one.help}; --lenient leaves {what} out")
                self.diagnostics[index] = one
        return bool(wrong)

    def all_diagnostics(self) -> list[Diagnostic]:
        """Return all diagnostics; those about similar elements that are omitted or ignored are merged."""
        groups: dict[object, list[Diagnostic]] = {}
        for index, one in enumerate(self.diagnostics):
            kind = (re.sub(_NAME_IN_TAG, r"\1>", one.message), one.help) if one.rule in _GATHERED else index
            groups.setdefault(kind, []).append(one)
        return [*(gather(some, (WARNING, NOTE))[0] for some in groups.values()), *self._other_units()]

    def single(self, element: Element, tag: str) -> Element | None:
        """Return the first child with a tag, or None, and report all other children with the same tag."""
        first = None
        for again in element.children:
            if again.tag != tag:
                continue
            if first is None:
                first = again
            elif canonical(tree_of(first.verbatim)) == canonical(tree_of(again.verbatim)):
                self.ignore(f"a second <{tag}>, the same as the first, has no effect", again.span)
            elif tag in _DECIDING and not self.options.lenient:
                message = f"{name_of(element)} has a second <{tag}>; parsers differ in which one they use"
                related = [Related("the first", first.span)]
                self.error("duplicate-element", message, again.span, "remove one; --lenient uses the first", related)
            else:
                self.cannot_carry(f"a second <{tag}> of {name_of(element)}", again.span, "only the first is used")
        return first

    def attribute(self, element: Element, name: str) -> str | None:
        self.need(element, name)
        return element.values.get(name)

    def need(self, element: Element, *names: str) -> None:
        """Report missing attributes, unless the element has a misspelled attribute in place of them."""
        missing = [name for name in names if name not in element.values]
        if missing and not self.options.lenient:
            strange = [other for other in element.values if other not in self.attributes]
            missing = [name for name in missing if not any(correction(other, [name]) for other in strange)]
        if missing:
            help = "add " + " ".join(f'{name}="..."' for name in missing)
            self.error("missing-attribute", lacks(element, missing), element.span, help)

    def check(self, element: Element, tags: Collection[str], attributes: Collection[str], keep: Map | None) -> None:
        """Report unknown attributes and children of an element; with ``keep``, add unknown children to it as XML."""
        self.check_attributes(element, attributes)
        for child in element.children:
            if child.tag in tags:
                continue
            near, is_xacro = correction(child.tag, tags) if self.spelling else None, child.tag.startswith("xacro:")
            if near is not None and not is_xacro:
                self.misspelt(f"<{child.tag}>", f"<{near}>", element, child.span)
            elif keep is None or is_xacro:
                help = "URDF parsers ignore it; name the file NAME.xacro to have it expanded" if is_xacro else ""
                self.cannot_carry(f"<{child.tag}> in {name_of(element)}", child.span, help)
            else:
                self.keep(child, keep)

    def check_attributes(self, element: Element, attributes: Collection[str]) -> None:
        for name in element.values:
            if name in attributes or name.startswith("xmlns"):
                continue
            what = f'the attribute "{name}"'
            near = correction(name, [one for one in attributes if one not in element.values])
            if near is None:
                self.cannot_carry(f"{what} of {name_of(element)}", element.attributes[name].name_span)
            else:
                self.misspelt(what, f'"{near}"', element, element.attributes[name].name_span)

    def misspelt(self, what: str, near: str, element: Element, span: Span) -> None:
        if self.options.lenient:
            self.cannot_carry(f"{what} of {name_of(element)}", span, f"did you mean {near}?")
        else:
            message = f"{name_of(element)} has {what}, which no parser knows"
            self.error("misspelt", message, span, f"did you mean {near}? --lenient leaves it out")

    def keep(self, element: Element, entry: Map) -> None:
        entry.setdefault_at("urdf_elements", Seq(element.span), element.span)
        above = self.paths.get(id(element.parent), ())
        inside = () if above == ("robot",) else above
        self.paths[id(element)] = (*inside, "urdf_elements", len(entry["urdf_elements"]))
        entry["urdf_elements"].put(kept_text(element), element.span)

    def numbers(
        self, words: Sequence[Word], element: Element, name: str, span: Span, count: int, unit: str = "", tag: str = ""
    ) -> Seq | None:
        """Parse the numbers of an attribute, or of the text if ``name`` is empty; return None after an error."""
        # An invalid number, such as one with a comma, is reported instead of the wrong count that it causes.
        if len(words) != count and (count == 1 or all(NUMBER.match(word.text) for word in words)):
            have = "is empty" if not words else f"has {count_of(len(words), 'number')}"
            message = f"{_described(element, name)} {have}; it takes {'one' if count == 1 else count}"
            self.error("wrong-count", message, span, f"write {'one number' if count == 1 else f'{count} numbers'}")
            return None
        made = Seq(span)
        for word in words:
            value = self.number(word, element, name, unit, tag)
            if value is None:
                return None
            made.put(value, word.span)
        return made

    def number(self, word: Word, element: Element, name: str, unit: str = "", tag: str = "") -> float | None:
        """Parse a number, or report an error and return None."""
        # A very large number becomes a quantity with an explicit unit, so that no rule reports a missing unit. Numbers
        # with a ``tag`` are collected in order to detect files in degrees or millimetres.
        text = word.text
        if not NUMBER.match(text) or not math.isfinite(float(text)):
            wrong = "too large for a number" if NUMBER.match(text) else "not a number"
            message = f'{_described(element, name)}: "{text[:40]}" is {wrong}'
            self.error("not-a-number", message, word.span, _advice(text))
            return None
        value: float = int(text) if re.match(_INTEGER, text) else float(text)
        if unit not in UNITS:
            return value
        dimension, far = UNITS[unit]
        is_far = abs(value) > far
        if tag and value:
            what = f"{_described(element, name)} is {text} {unit}" if is_far else ""
            self._sizes[unit].append(_Size(abs(value), tag, what, word.span))
        return Quantity(value, dimension, f"{text} {unit}") if is_far else value

    def _other_units(self) -> Iterator[Diagnostic]:
        """Yield warnings for numbers that are probably in degrees or millimetres."""
        # A single large number proves nothing: a wrist can turn by 400 degrees, and 999999 means "no limit". In a file
        # in millimetres, most lengths are large. A large model without moving joints can be a building.
        angles, lengths = self._sizes.values()
        degrees = [one for one in angles if FULL_TURN < one.value < 721 and _is_degrees(one)]
        sizes = sorted(one.value for one in lengths if one.tag != "limit")
        in_millimetres = self.joint_types - {"fixed"} and sizes and sizes[len(sizes) // 2] > 1
        far = [one for one in lengths if one.value > FAR]
        far = far if in_millimetres else [one for one in far if one.tag == "origin" and self.joint_types]
        for rule, found, limit, other, unit in (
            ("angle-looks-like-degrees", degrees, "more than a full turn", "degrees", ANGLES),
            ("length-looks-like-millimetres", far, "larger than any robot", "millimetres", LENGTHS),
        ):
            if found:
                more = f",{and_more(len(found) - 1)}" if len(found) > 1 else ""
                message = f"{found[0].what}, {limit}: this looks like {other}{more}"
                help = f"it is kept as it is, in {unit}; if it is wrong, correct it in the source"
                yield Diagnostic(rule, WARNING, message, found[0].span, (), help)


def _is_degrees(size: _Size) -> bool:

    def is_multiple(step: float) -> bool:
        return abs(size.value - round(size.value / step) * step) < 0.06  # 1.57 rad is 89.95 degrees

    if size.tag == "origin":
        return size.value > 14.94 and is_multiple(5)
    digits = size.value / 10 ** math.floor(math.log10(size.value))
    many_turns = any(math.isclose(digits, one) for one in (1, 2, 5)) or is_multiple(math.tau)
    # In 600 public robots, all limits above 20 rad mean "many turns".
    return size.value < 360.06 and ((size.value > 31 and not many_turns) or is_multiple(45))


def _advice(text: str) -> str:
    if text.lower().lstrip("+-") in ("nan", "inf", "infinity") or NUMBER.match(text):
        return "write a finite number"
    if "$" in text:
        return "this is xacro: name the file NAME.xacro, or declare xmlns:xacro"
    if "," in text:
        return "write decimals with a point, and separate numbers with spaces"
    if text[:1].isdigit() or text[:1] in "+-.":
        return "write a plain number: values are in metres, radians and kilograms, without a unit"
    return "write a number such as 0.5 or 1e-3"


def _described(element: Element, attribute: str) -> str:
    return f"{attribute} of {name_of(element)}" if attribute else name_of(element)


def lacks(element: Element, names: Sequence[str]) -> str:
    """Return a message which states that an element lacks attributes."""
    return f"{name_of(element)} lacks the {plural('attribute', len(names))} {quote(names)}"


def sequence(values: Iterable[float], spans: list[Span]) -> Seq:
    """Return a YAML sequence of numbers with their source positions; its own position is that of the first number."""
    made = Seq(spans[0])
    made += values
    made.value_spans = spans
    return made


def artifact_numbers(element: Element, text: str, count: int) -> Seq | None:
    """Parse ``count`` numbers of a generated file; return None if they are invalid, or if the file has positions."""
    whole = element.document.whole
    try:
        return None if whole is None else sequence(numbers_of(text, count), [whole] * count)
    except ValueError:
        return None


def numbers(element: Element, name: str, count: int, unit: str, reading: XmlReader) -> Seq | None:
    """Parse the numbers of an attribute; return None if it is missing or invalid."""
    if name not in element.values:
        return None
    if (plain := artifact_numbers(element, element.values[name], count)) is not None:
        return plain
    tag = "origin" if element.tag == "origin" else "size" if name in ("size", "radius", "length") else "limit"
    attribute = element.attributes[name]
    words = attribute.words()
    if name == "scale" and (len(words) == 1 or len(words) > count) and reading.options.lenient:
        taken = "one number, which is taken for all three" if len(words) == 1 else "more than three numbers"
        reading.note("wrong-count", f"scale of {name_of(element)} has {taken}", attribute.span)
        words = (words * count)[:count]
    return reading.numbers(words, element, name, attribute.span, count, unit, tag)


def put_value(entry: Map, key: str, value: Any, element: Element) -> None:
    """Set a key of an entry to a value, at the source position of an element."""
    entry.put(key, value, element.span, element.span)
