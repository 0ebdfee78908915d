"""Parse, compare and indent XML elements that are stored as strings, and escape values that are inserted into XML."""

import math
import re
import textwrap
from collections import Counter
from collections.abc import Iterable
from contextlib import suppress
from typing import TYPE_CHECKING, NamedTuple
from xml.parsers import expat

from ..diagnostics import Source
from ..tree import Text
from .markup import Element, MarkupError, new_parser, parse

if TYPE_CHECKING:
    from xml.etree import ElementTree


def tree_of(text: str) -> "ElementTree.Element":
    """Parse generated XML to an ElementTree element. Raises ValueError if it is invalid or has a DOCTYPE."""
    from xml.etree import ElementTree  # slow import

    if "<!DOCTYPE" in text or "<!ENTITY" in text:
        raise ValueError("a generated artifact declares no entities")
    builder = ElementTree.TreeBuilder()
    parser = new_parser()
    parser.StartElementHandler, parser.EndElementHandler = builder.start, builder.end
    parser.CharacterDataHandler = builder.data
    try:
        parser.Parse(text, True)
    except (expat.ExpatError, UnicodeEncodeError) as problem:
        raise ValueError(str(problem)) from None
    return builder.close()


def canonical(element: "ElementTree.Element") -> str:
    """Serialize an element; differences in white space, attribute order, number format and comments have no effect."""
    attributes = "".join(f' {name}="{_words(value)}"' for name, value in sorted(element.items()))
    content = _words(element.text or "") + "".join(canonical(child) + _words(child.tail or "") for child in element)
    return f"<{element.tag}{attributes}{f'>{content}</{element.tag}' if content else '/'}>"


def _words(text: str) -> str:
    words = " ".join(map(str, map(_value, text.split())))
    return words.replace("&", "&amp;").replace("<", "&lt;").replace('"', "&quot;")


def _value(text: str) -> str | float:
    try:
        return number_of(text) + 0.0
    except ValueError:
        return " ".join(text.split())


_NAMES = ("name", "class", "link", "joint", "body", "site")


def values_of(text: str) -> list[tuple[str, str | float]]:
    """Return (label, value) of each attribute and text in XML: ("link arm mass value", 1.5). Raises MarkupError."""
    times: Counter[str] = Counter()
    values: list[tuple[str, str | float]] = []
    for element in [*parse(Source("", text)).root.iter()][1:]:
        outer = [*element.ancestors()][-2::-1]
        *above, here = [(e.tag, next(filter(None, map(e.get, _NAMES)), "")) for e in (*outer, element)]
        place = " ".join([*(f"{tag} {name}" for tag, name in above if name), " ".join(here).rstrip()][-3:])
        own = [(f"{place} {key}", value) for key, value in element.values.items()]
        own += [(place, element.text)] if element.text or not (own or element.children) else []
        for where, value in own:
            times[where] += 1
            values.append((where if times[where] == 1 else f"{where} ({times[where]})", _value(value)))
    return values


class FlatElement(NamedTuple):
    """An XML element without children; ``tags`` are the tags from the root to the element, ``line`` counts from 1."""

    tags: tuple[str, ...]
    attributes: dict[str, str]
    text: str
    line: int


def _fragment(text: str) -> Element:
    return parse(Source("", f"<robot>{text}</robot>")).root


def damage(text: str) -> str:
    """Return why a string is not a sequence of XML elements, or an empty string if it is valid."""
    try:
        root = _fragment(text)
    except MarkupError as problem:
        return str(problem)
    if root.text:
        return f'"{root.text[:20]}" is outside of an element'
    return "" if root.children else "there is no element"


def found_in(text: str) -> list[FlatElement]:
    """Return all elements in a string of XML, children before their parents, or [] if the string is invalid."""
    found = []
    with suppress(MarkupError):
        for element in sorted([*_fragment(text).iter()][1:], key=lambda element: element.end):
            tags = (*(outer.tag for outer in [*element.ancestors()][-2::-1]), element.tag)
            found.append(FlatElement(tags, element.values, element.text, element.span.line))
    return found


def kept_text(element: Element, text: str = "") -> Text:
    """Return the source text of an element (or ``text`` in its place) plus the namespace declarations that it needs."""
    text = re.sub("\r\n|\r", "\n", text or element.verbatim)
    names = [name for inner in element.iter() for name in (inner.tag, *inner.values) if ":" in name]
    declarations = ""
    for key in dict.fromkeys(f"xmlns:{name.partition(':')[0]}" for name in names):
        above = next((outer for outer in element.ancestors() if key in outer.values), None)
        if above is not None and key not in names:
            address = above.attributes[key].raw.replace('"', "&quot;")
            declarations += f' {key}="{address}"'
    return Text(indent_lines(f"<{element.tag}{declarations}{text[1 + len(element.tag) :]}", ""))


def indent_lines(text: str, indent: str) -> str:
    """Indent the lines of XML elements by the string ``indent``; if a value contains line ends, only the first line."""
    text = text.replace("\r\n", "\n").strip()
    first, *rest = text.split("\n")  # splitlines() would also split at other characters
    has_lines = "<![CDATA[" in text or any("\n" in value for value in re.findall(r"=\s*(\"[^\"]*\"|'[^']*')", text))
    pieces = (piece for element in _fragment(text).iter() for piece in element.texts) if rest else ()
    if not rest or has_lines or any("\n" in piece.text for piece in pieces):
        return indent + text
    lines = textwrap.dedent("\n".join(rest)).split("\n")
    return "\n".join([indent + first, *(indent + line if line else "" for line in lines)])


def indented(texts: Iterable[str], indent: str) -> list[str]:
    """Indent each of several strings of XML elements, see ``indent_lines``."""
    return [indent_lines(text, indent) for text in texts]


_MARKUP = (
    r"(?s)<!--(?P<comment>.*?)(?:-->|\Z)|<!\[CDATA\[(?P<cdata>.*?)(?:\]\]>|\Z)|<\?.*?(?:\?>|\Z)|"
    r"<(?P<tag>(?:[^<>\"']|\"[^\"]*\"|'[^']*')*)(?P<end>>|\"|'|\Z)?"
)
_ESCAPES = str.maketrans({"&": "&amp;", "<": "&lt;", ">": "&gt;"})
_IN_QUOTES = _ESCAPES | str.maketrans({'"': "&quot;", "'": "&apos;", "\n": "&#10;", "\r": "&#13;", "\t": "&#9;"})


# xml.sax.saxutils.quoteattr is not used, because that module imports urllib and http, which is slow.
def attribute_value(text: str) -> str:
    """Escape a string for an XML attribute, and put it in double quotes."""
    return f'"{text.translate(_IN_QUOTES)}"'


def escape_for(before: str, value: str) -> str:
    """Escape a value for insertion into XML after the text ``before``; complete elements are not escaped."""
    last = next(iter([*re.finditer(_MARKUP, before)][-1:]), None)
    if last is not None and last.end() == len(before):
        if last["comment"] is not None and not before.endswith("-->"):
            return re.sub("-(?=-|$)", "- ", value)
        if last["cdata"] is not None and not before.endswith("]]>"):
            return value.replace("]]>", "]] >")
        if last["tag"] is not None and not last["end"]:
            return value
    if last is not None and last["end"] in ("'", '"'):
        return value.translate(_IN_QUOTES)
    return value if "<" in value and not damage(value) else value.translate(_ESCAPES)


def number_of(text: str) -> float:
    """Parse a finite number. Raises ValueError for any other text."""
    value = float(text)
    if "_" in text or not math.isfinite(value):
        raise ValueError(f"not a number: {text}")
    return value


def numbers_of(text: str, count: int | None = None) -> tuple[float, ...]:
    """Parse white-space separated numbers. Raises ValueError for other text, or if there are not ``count`` numbers."""
    found = tuple(map(float, text.split()))
    if "_" in text or not all(map(math.isfinite, found)):
        found = tuple(map(number_of, text.split()))  # raises ValueError
    if count is not None and count != len(found):
        raise ValueError(f'"{text}": {count} numbers are needed')
    return found
