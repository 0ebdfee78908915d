"""Elements of XML: how a text is parsed, whether elements are whole, how they look in a file, when two are the same.

Names are names here: a prefix that nothing declares, as in <controller:foo>, is legal text of a URDF.

``canonical`` is what two of them are compared by: without white space, comments and order.
"""

from __future__ import annotations

import math
import re
from collections import Counter
from collections.abc import Sequence
from typing import TYPE_CHECKING, NamedTuple

if TYPE_CHECKING:
    from xml.etree.ElementTree import Element
    from xml.parsers.expat import XMLParserType


_TOP = b"<robot>"
_END = b"</robot>"


def new_parser() -> XMLParserType:
    """Return a parser of XML without namespaces, which gives text in one piece; texts are decoded already."""
    from xml.parsers import expat

    parser = expat.ParserCreate("utf-8")
    parser.buffer_text = True
    return parser


def tree_of(text: str) -> Element:
    """Return the tree of an XML text. Raises ValueError if it is not well formed, or might declare entities."""
    from xml.etree import ElementTree
    from xml.parsers import expat

    if "<!DOCTYPE" in text or "<!ENTITY" in text:
        raise ValueError("a generated artifact declares no entities")
    if "xmlns" not in text:
        try:
            return ElementTree.fromstring(text)  # noqa: S314 - without entities there is nothing to expand
        except ElementTree.ParseError as problem:
            if expat.ErrorString(problem.code) != expat.errors.XML_ERROR_UNBOUND_PREFIX:
                raise ValueError(str(problem)) from None
    builder = ElementTree.TreeBuilder()
    parser = new_parser()
    parser.StartElementHandler = builder.start
    parser.EndElementHandler = builder.end
    parser.CharacterDataHandler = builder.data
    try:
        parser.Parse(text, True)
    except (expat.ExpatError, UnicodeEncodeError) as problem:
        raise ValueError(str(problem)) from None
    return builder.close()


def canonical(element: Element) -> str:
    """Return an element in one spelling: what has the same differs in white space, comments and spelling alone.

    Attributes are sorted, one space stands between words, numbers have no spare zeros. No depth of elements can exhaust
    the interpreter.

    >>> canonical(tree_of("<a c='1.50'  b='x'><!-- 2 --><d> 1e3 </d><e/></a>"))
    '<a b="x" c="1.5"><d>1000.0</d><e/></a>'
    """
    parts: list[str] = []
    waiting: list[Element | str] = [element]
    while waiting:
        item = waiting.pop()
        if isinstance(item, str):
            parts.append(item)
            continue
        start = f"<{item.tag}" + "".join(f' {name}="{_words(item.attrib[name])}"' for name in sorted(item.attrib))
        text = _words(item.text or "")
        if not text and not len(item):
            parts.append(f"{start}/>")
            continue
        parts.append(f"{start}>{text}")
        waiting.append(f"</{item.tag}>")
        for child in reversed(item):
            waiting += [_words(child.tail or ""), child]
    return "".join(parts)


def _words(text: str) -> str:
    words = " ".join(map(_word, text.split()))
    return words.replace("&", "&amp;").replace("<", "&lt;").replace('"', "&quot;")


def _word(word: str) -> str:
    try:
        return word if "_" in word else repr(float(word) + 0.0)
    except ValueError:
        return word


def damage(text: str) -> str:
    """Return what keeps a text from being elements of XML, in words; empty if nothing does."""
    from xml.parsers import expat

    reader = _Reader()
    try:
        reader.read(text)
    except expat.ExpatError as problem:
        line = f" (line {problem.lineno} of the text)" if "\n" in text.strip() else ""
        return f"{expat.errors.messages[problem.code]}{line}"
    except UnicodeEncodeError:
        return "a character that no file can hold"
    return reader.wrong or ("" if reader.elements else "there is no element")


_OPENINGS = (("<!--", "-->"), ("<![CDATA[", "]]>"), ("<?", "?>"))
_TAG = re.compile(r"<[^<>\"']*(?:\"[^\"]*\"[^<>\"']*|'[^']*'[^<>\"']*)*")
_SPELT = {"&": "&amp;", "<": "&lt;", ">": "&gt;"}
_IN_QUOTES = _SPELT | {'"': "&quot;", "'": "&apos;", "\n": "&#10;", "\r": "&#13;", "\t": "&#9;"}


def fitted(before: str, value: str) -> str:
    """Return a value as it has to be spelt behind the text ``before``, so that a reader has the very value.

    In an attribute and between tags, signs of XML are escaped; but a value that is whole elements stays elements
    between tags. In a comment two dashes are kept apart, and nothing ends a CDATA section.

    >>> fitted("<a b='", 'x<"y"'), fitted("<a>", "1 < 2"), fitted("<a>", "<b/>")
    ('x&lt;&quot;y&quot;', '1 &lt; 2', '<b/>')
    """
    position = 0
    while (start := before.find("<", position)) >= 0:
        opening, closing = next((pair for pair in _OPENINGS if before.startswith(pair[0], start)), ("", ">"))
        if not opening:
            tag = _TAG.match(before, start)
            position = tag.end() if tag else start + 1
            if before.startswith(">", position):
                position += 1
            elif position < len(before) and before[position] != "<":
                return "".join(_IN_QUOTES.get(letter, letter) for letter in value)
            elif position == len(before):
                return value
            continue
        end = before.find(closing, start + len(opening))
        if end < 0:
            return re.sub("-(?=-|$)", "- ", value) if opening == "<!--" else value.replace("]]>", "]] >")
        position = end + len(closing)
    if "<" in value and not damage(value):
        return value
    return "".join(_SPELT.get(letter, letter) for letter in value)


class Found(NamedTuple):
    """An element of a text: the tags that lead to it, its own last; its attributes, its own text, its line from 1."""

    tags: tuple[str, ...]
    attributes: dict[str, str]
    text: str
    line: int


def found_in(text: str) -> list[Found]:
    """Return every element of a text of elements, in the order of their ends; none of one that is no XML."""
    from xml.parsers import expat

    found: list[Found] = []
    open_ones: list[tuple[str, dict[str, str], list[str], int]] = []
    parser = new_parser()

    def start(name: str, attributes: dict[str, str]) -> None:
        open_ones.append((name, attributes, [], parser.CurrentLineNumber))

    def end(name: str) -> None:  # noqa: ARG001
        tags = tuple(one[0] for one in open_ones[1:])
        _, attributes, texts, line = open_ones.pop()
        found.append(Found(tags, attributes, "".join(texts).strip(), line))

    def data(piece: str) -> None:
        open_ones[-1][2].append(piece)

    parser.StartElementHandler, parser.EndElementHandler, parser.CharacterDataHandler = start, end, data
    try:
        for part in (_TOP, text.encode(), _END):
            parser.Parse(part, False)
        parser.Parse(b"", True)
    except (expat.ExpatError, UnicodeEncodeError):
        return []
    return found[:-1]


def indented(text: str, indent: str) -> str:
    """Return elements with the first line after ``indent`` and the others as far right as they were from it.

    Where a line end or the space after it is part of what the elements say, the text stays as it is; comments say
    nothing, and move with the lines around them.
    """
    text = text.replace("\r\n", "\n").strip()
    reader = _Reader()
    reader.read(text)
    first, *rest = text.split("\n")  # and at no other character that ends lines elsewhere
    if not rest or not reader.loose:
        return indent + text
    margin = _margin([line for line in rest if line.strip(" \t")])
    return "\n".join([indent + first, *(indent + line[len(margin) :] if line.strip(" \t") else "" for line in rest)])


def _margin(lines: list[str]) -> str:
    margin = min((line[: len(line) - len(line.lstrip(" \t"))] for line in lines), key=len)
    while not all(line.startswith(margin) for line in lines):
        margin = margin[:-1]
    return margin


class _Reader:
    """Reads elements. ``wrong``: what stands beside them; ``loose``: space between them means nothing."""

    def __init__(self) -> None:
        self.depth = 0
        self.elements = 0
        self.wrong = ""
        self.loose = True
        self.parser = new_parser()
        self.parser.StartElementHandler = self._start
        self.parser.EndElementHandler = self._end
        self.parser.CharacterDataHandler = self._data
        self.parser.StartCdataSectionHandler = self._cdata

    def read(self, text: str) -> None:
        """Read a text. Raises expat.ExpatError if it is not well formed."""
        for piece in (_TOP, text.encode(), _END):
            self.parser.Parse(piece, False)
        self.parser.Parse(b"", True)
        # A tag that is written over several lines may have a line end in a value.
        values = re.findall(r"=\s*(\"[^\"]*\"|'[^']*')", text)
        self.loose = self.loose and not any("\n" in value for value in values)

    def _start(self, name: str, attributes: dict[str, str]) -> None:  # noqa: ARG002
        self.depth += 1
        self.elements += self.depth == 2

    def _end(self, name: str) -> None:  # noqa: ARG002
        self.depth -= 1

    def _data(self, text: str) -> None:
        if text.strip():
            if self.depth == 1:
                self.wrong = self.wrong or f'"{text.strip()[:20]}" stands outside of an element'
            self.loose = self.loose and "\n" not in text

    def _cdata(self) -> None:
        self.loose = False


def fragments(texts: Sequence[str]) -> Counter[str]:
    """Return each element of some texts in one spelling, and how often it is there; what is no XML as its words."""
    counts: Counter[str] = Counter()
    for text in texts:
        try:
            root = tree_of(f"<all>{text}</all>")
        except ValueError:
            counts[" ".join(text.split())] += 1
        else:
            counts.update(map(canonical, root))
    return counts


_NAMES = ("name", "class", "link", "joint", "body", "site")


def values_of(text: str) -> list[tuple[str, str | float]]:
    """Return the attributes and texts of an XML text, each by its place: the last three elements that have names.

    Numbers are numbers. Places that occur twice are numbered. The root element is no part of a place, but of those of
    its own attributes. Raises ValueError for a text that is not well formed. No depth of elements can exhaust the
    interpreter.
    """
    root = tree_of(text)
    found: list[tuple[str, str | float]] = []
    times: Counter[str] = Counter()

    def add(place: str, value: str) -> None:
        times[place] += 1
        found.append((place if times[place] == 1 else f"{place} ({times[place]})", _value(value)))

    for key, value in root.items():
        add(f"{root.tag} {key}", value)
    left: list[tuple[Element, tuple[str, ...]]] = [(inner, ()) for inner in reversed(root)]
    while left:
        element, above = left.pop()
        name = next((element.attrib[key] for key in _NAMES if key in element.attrib), "")
        here = (*above, f"{element.tag} {name}".rstrip())[-3:]
        for key, value in element.items():
            add(f"{' '.join(here)} {key}", value)
        words = (element.text or "").strip()
        if words or not (len(element) or element.attrib):
            add(" ".join(here), words)
        left += [(inner, here if name else above) for inner in reversed(element)]
    return found


def _value(text: str) -> str | float:
    try:
        return text if "_" in text else float(text)
    except ValueError:
        return " ".join(text.split())


def number_of(text: str) -> float:
    """Return the number that a text is. Raises ValueError if it is none or not finite."""
    value = float(text)
    if "_" in text or not math.isfinite(value):
        raise ValueError(f"not a number: {text}")
    return value


def numbers_of(text: str, count: int | None = None) -> tuple[float, ...]:
    """Return the numbers of a text. Raises ValueError if a word is none, or unless there are ``count``."""
    found = tuple(map(number_of, text.split()))
    if count is not None and len(found) != count:
        raise ValueError(f'"{text}": {count} numbers are needed')
    return found
