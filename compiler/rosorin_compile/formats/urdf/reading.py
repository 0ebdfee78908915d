"""Reading: an element of a URDF taken apart, with everything said that is wrong with it, misspelt in it, or left out.

``meant`` says which known word an unknown one was meant to be; ``kept`` is what stays verbatim, because the language
has no word for it.
"""

from __future__ import annotations

import re
from collections.abc import Collection, Iterable, Sequence
from dataclasses import replace
from typing import Any

from rosorin_compile.rules.check import acceptable
from rosorin_compile.source.diagnostics import ERROR, NOTE, Diagnostic, Related, Span, error
from rosorin_compile.source.rule_registry import READING, Rule
from rosorin_compile.source.tree import Map, Path, Seq, Text
from rosorin_compile.source.wording import plural, quoted
from rosorin_compile.source.xml.elements import indented
from rosorin_compile.source.xml.markup import INSTRUCTION, TEXT, Element

from ..format import cannot_carry
from ..imported import LeftOut, ReadOptions
from .grammar import CHILDREN, NUMBERS, TEXTS, attributes
from .magnitudes import Magnitudes

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
)


# What a description can call something, as its schema has it.
NAME = re.compile(r"""[^\s<>&"']+( +[^\s<>&"']+)*\Z""")

# Every attribute that URDF has somewhere.
_ATTRIBUTES = {"iyx", "izx", "izy", *(name for tag in (*TEXTS, *NUMBERS) for name in attributes(tag))}

_DECIDING = ("origin", "pose", "parent", "child", "axis", "xyz", "limit", "mimic", "geometry", "mass", "inertia")


class Reading:
    """One reading of a file: collects what is wrong, what is left out, and which entry an element became.

    Without ``spelling``, elements of other names are kept, even where their names look misspelt.
    """

    def __init__(self, options: ReadOptions, spelling: bool = True) -> None:
        self.options = options
        self.spelling = spelling
        self.diagnostics: list[Diagnostic] = []
        self._left_out: dict[tuple[str, str], list[LeftOut]] = {}
        self._first: dict[tuple[str, str], Diagnostic] = {}
        self.paths: dict[int, Path] = {}
        self.joints: frozenset[str] = frozenset()  # the names of all joints of the file
        self._ignored: dict[str, list[Span]] = {}
        self.magnitudes = Magnitudes()

    def error(self, rule: str, message: str, span: Span, help: str = "", related: Iterable[Related] = ()) -> None:
        """Take down that the file is broken."""
        self.diagnostics.append(error(rule, message, span, help, related))

    def lenient(self, rule: str, message: str, span: Span, help: str, instead: str) -> bool:
        """Take down something broken that --lenient takes; return whether it is taken. ``instead`` is what is done."""
        if not self.options.lenient:
            self.error(rule, message, span, f"{help}; --lenient {instead}")
            return False
        if rule not in acceptable():  # what is accepted is told there
            self.diagnostics.append(Diagnostic(rule, NOTE, f"{message}; --lenient {instead}", span))
        return True

    def spoilt(self, element: Element, what: str, before: int) -> bool:
        """Say whether anything within an element is wrong, so that there is nothing to be taken of it.

        ``before`` is how much had been said before it. Leniently, it is left out, and that is all there is to say.
        """
        said = self.diagnostics[before:]
        wrong = [one for one in said if one.severity == ERROR]
        if wrong and self.options.lenient:
            self.diagnostics[before:] = [one for one in said if one not in wrong]
            self.cannot_carry(named(element), element.span, wrong[0].message)
        elif wrong:
            way_out = f"--lenient leaves {what} out"
            self.diagnostics[before:] = [
                replace(one, help=f"{one.help}; {way_out}") if one in wrong and "--lenient" not in one.help else one
                for one in said
            ]
        return bool(wrong)

    def cannot_carry(self, what: str, span: Span, help: str = "") -> None:
        """Take down something that the language has no word for; told once for each kind, names aside."""
        kind = (_NAMED.sub(r"\1>", what), help)
        if kind not in self._left_out:
            self._first[kind] = cannot_carry(what, span, help)
            self.diagnostics.append(self._first[kind])
        self._left_out.setdefault(kind, []).append(LeftOut(what, span))

    def ignored(self, what: str, span: Span) -> None:
        """Take down something that has no effect; told once for each ``what``, with the count and the first place."""
        self._ignored.setdefault(what, []).append(span)

    def left_out(self) -> tuple[LeftOut, ...]:
        """Return what the tree does not carry, each kind once."""
        return tuple(_together(kind, found) for (kind, _), found in self._left_out.items())

    def all_diagnostics(self) -> list[Diagnostic]:
        """Return all that there is to say, the grouped notes included."""
        grouped = []
        whole = {}
        for (kind, help), found in self._left_out.items():
            what, span = _together(kind, found)
            others = [one.span for one in found[1:]]
            whole[id(self._first[kind, help])] = cannot_carry(what, span, help, others=others)
        for what, spans in self._ignored.items():
            times = f" ({len(spans)} times, first here)" if len(spans) > 1 else ""
            grouped.append(Diagnostic("import-ignored", NOTE, f"{what}{times}", spans[0]))
        said = [whole.get(id(one), one) for one in self.diagnostics]
        return [*said, *grouped, *self.magnitudes.diagnostics()]

    def single(self, element: Element, tag: str) -> Element | None:
        """Return the one child of this tag, None if there is none; a second one is an error."""
        children = [child for child in element.children if child.tag == tag]
        for again in children[1:]:
            self._second(element, children[0], again)
        return children[0] if children else None

    def _second(self, element: Element, first: Element, again: Element) -> None:
        """Report an element that stands once more: where it decides on the motion it has to be the same."""
        if _same(first, again):
            self.ignored(f"a second <{again.tag}>, the same as the first, has no effect", again.span)
        elif again.tag in _DECIDING and not self.options.lenient:
            message = f"{named(element)} has a second <{again.tag}>; readers differ in which of them they take"
            related = [Related("the first", first.span)]
            self.error("duplicate-element", message, again.span, "remove one; --lenient takes the first", related)
        else:
            self.cannot_carry(f"a second <{again.tag}> of {named(element)}", again.span, "the first is taken")

    def attribute(self, element: Element, name: str) -> str | None:
        """Return an attribute that has to be there; without it there is an error, and None."""
        self.need(element, name)
        own = element.attributes.get(name)
        return None if own is None else own.value

    def need(self, element: Element, *names: str) -> None:
        """Report the attributes of some names that are not there; one that is misspelt has its own message."""
        missing = self.missing(element, *names)
        if missing:
            message = f"{named(element)} lacks the {plural('attribute', len(missing))} {quoted(missing)}"
            self.error(
                "missing-attribute", message, element.span, "add " + " ".join(f'{name}="..."' for name in missing)
            )

    def missing(self, element: Element, *names: str) -> list[str]:
        """Return the attributes of some names that are not there, those aside that are misspelt and told as that."""
        missing = [name for name in names if name not in element.attributes]
        if self.options.lenient:
            return missing
        others = [other for other in element.attributes if other not in _ATTRIBUTES]
        return [name for name in missing if not any(correction(other, [name]) for other in others)]

    def check(self, element: Element, tags: Collection[str], attributes: Collection[str], keep: Map | None) -> None:
        """Look for what a reader of this element does not know.

        What is near to a known name is misspelt. Other elements are kept in ``keep``, where the language has a place.
        """
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
        self._remarks(element)

    def known_attributes(self, element: Element, attributes: Collection[str]) -> None:
        """Look for attributes that a reader of this element does not know."""
        for attribute in element.attributes.values():
            if attribute.name not in attributes and not attribute.name.startswith("xmlns"):
                self._unknown(
                    f'the attribute "{attribute.name}"', attribute.name, attributes, element, attribute.name_span
                )

    def _unknown(self, what: str, name: str, legal: Collection[str], element: Element, span: Span) -> None:
        near = correction(name, [other for other in legal if other not in element.attributes])
        if near is None:
            self.cannot_carry(f"{what} of {named(element)}", span)
        else:
            self._misspelt(what, f'"{near}"', element, span)

    def _misspelt(self, what: str, near: str, element: Element, span: Span) -> None:
        if self.options.lenient:
            self.cannot_carry(f"{what} of {named(element)}", span, f"did you mean {near}?")
        else:
            message = f"{named(element)} has {what}, which no reader knows"
            self.error("misspelt", message, span, f"did you mean {near}? --lenient leaves it out")

    def keep(self, element: Element, entry: Map) -> None:
        """Keep an element as it is, in ``urdf_elements`` of an entry."""
        if "urdf_elements" not in entry:
            entry.put("urdf_elements", Seq(element.span), element.span, element.span)
        above = self.paths.get(id(element.parent), ())
        inside = () if above == ("robot",) else above
        self.paths[id(element)] = (*inside, "urdf_elements", len(entry["urdf_elements"]))
        entry["urdf_elements"].put(kept(element), element.span)

    def _remarks(self, element: Element) -> None:
        for item in element.content:
            if isinstance(item, Element) or item.kind not in (TEXT, INSTRUCTION):
                continue
            span = element.document.span(item.start, min(item.end - item.start, 40))
            what = "text between elements" if item.kind == TEXT else "an instruction <?...?>"
            self.ignored(f"{what} has no meaning to any reader", span)


def check_element(element: Element, reading: Reading, keep: Map | None = None) -> None:
    """Look for what no reader of URDF knows in an element; ``keep`` as for ``Reading.check``."""
    reading.check(element, CHILDREN.get(element.tag, ()), attributes(element.tag), keep)


# An element in words, with its name (see ``named``).
_NAMED = re.compile(r'(<[^\s>]+) name="[^"]*">')


def _together(kind: str, found: Sequence[LeftOut]) -> LeftOut:
    """Return all that is left out of one kind as one: of several, without names and with their number."""
    first = found[0]
    return first if len(found) == 1 else LeftOut(f"{kind} ({len(found)} places)", first.span)


def _same(one: Element, other: Element) -> bool:
    """Say whether two elements say the same, text, comments and the order of attributes aside."""
    if one.tag != other.tag or len(one.children) != len(other.children):
        return False
    if {a.name: a.value for a in one.attributes.values()} != {a.name: a.value for a in other.attributes.values()}:
        return False
    return all(map(_same, one.children, other.children))


def named(element: Element) -> str:
    """Return an element in words: its tag, with its name or whose it is."""
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


_LINE_END = re.compile("\r\n|\r")


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
