"""Parse XML with the position of every element, attribute and comment. Ignore namespaces; reject a DOCTYPE."""

from __future__ import annotations

import codecs
import difflib
import json
import re
from bisect import bisect_right
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import suppress
from pathlib import Path
from typing import NamedTuple
from xml.parsers import expat

from ..diagnostics import Diagnostic, Related, Source, SourceError, Span, error
from ..files import label
from ..load import decode, read_input

RULE = "xml-syntax"
MAX_BYTES = 100_000_000
MAX_DEPTH = 200
MAX_ELEMENTS = 2_000_000
COMMENT, TEXT, INSTRUCTION = "comment", "text", "instruction"

MarkupError = SourceError  # raised for XML that is invalid or unsafe to read

# Matches the text up to an XML declaration. A lazy ".*?" would take exponential time in the number of comments.
_DECLARATION = r"(?s)(?:\s|<!--(?:(?!-->).)*-->)*(<\?xml\s[^>]*\?>)"
_DECLARED = re.compile(r"""encoding\s*=\s*["']([A-Za-z][A-Za-z0-9._-]{0,40})["']""")
# Python's codecs for text. Other codecs decode binary data, or interpret escape sequences.
_ENCODING = r"utf-8|ascii|iso8859|iso2022|cp\d|gb|hz|big5|euc|shift_jis|johab|koi8|mac|tis|ptcp|kz"
_COMMENT = "(?s)<!--(.*?)-->"
_TAG = r"""(?s)<!--.*?-->|<!\[CDATA\[.*?\]\]>|(<[A-Za-z_](?:[^<>"']|"[^"]*"|'[^']*')*>)"""
_NO_SPACE = r"""(=\s*(?:"[^"]*"|'[^']*'))(?=[A-Za-z_])"""


def read_source(path: Path, asked: Span | None = None) -> Source:
    """Read an XML file in its declared encoding; ``asked`` is where another file refers to it. Raises MarkupError."""
    name = label(path)
    data = read_input(path, name, asked, MAX_BYTES, "check the name and the permissions")
    if not data.strip():
        raise MarkupError(error("file-empty", f"{name} is empty", asked, "is this the right file?"))
    encoding: str = json.detect_encoding(data) if b"<" in data[:8] else "utf-8"  # detects UTF-16 and UTF-32
    beginning = Source(name, data[:10_000].decode("ascii", "replace"))
    declaration = re.match(_DECLARATION, beginning.text) if encoding == "utf-8" else None
    if declaration and (declared := _DECLARED.search(beginning.text, declaration.start(1), declaration.end())):
        encoding = ""
        with suppress(LookupError):
            encoding = codecs.lookup(declared[1]).name
        if not re.match(_ENCODING, encoding):
            message = f'{name} declares the encoding "{declared[1]}", which is unknown or not its own'
            span = beginning.span(declared.start(1), len(declared[1]))
            raise MarkupError(error("not-utf8", message, span, "save the file as UTF-8"))
    if b"\0" in data.rstrip(b"\0 \r\n\t")[:1000] and not encoding.startswith(("utf-16", "utf-32")):
        message = f"{name} is not a text file: it contains zero bytes"
        raise MarkupError(error("not-text", message, asked, "name a URDF, xacro, SDF or MJCF file"))
    help = 'save the file as UTF-8, or declare its encoding: <?xml version="1.0" encoding="ISO-8859-1"?>'
    return decode(data, name, encoding.removesuffix("-sig"), help)


def without_late_declaration(source: Source) -> Source:
    """Blank out an XML declaration that follows spaces or comments, where only tinyxml2 accepts it."""
    match, text = re.match(_DECLARATION, source.text), source.text
    if match is None or match.start(1) == 0:
        return source
    return Source(source.path, text[: match.start(1)] + re.sub(r"\S", " ", match[1]) + text[match.end() :])


def repair(source: Source) -> Source:
    """Fix errors that other parsers accept: ``--`` in comments, trailing zero bytes, no space between attributes."""
    bare = source.text.rstrip("\0 \r\n\t")
    text = bare + source.text[len(bare) :].replace("\0", " ")
    text = re.sub(_COMMENT, lambda comment: f"<!--{re.sub('-(?=-|$)', ' ', comment[1])}-->", text)
    return Source(source.path, re.sub(_TAG, lambda tag: re.sub(_NO_SPACE, r"\1 ", tag[1]) if tag[1] else tag[0], text))


_LINE_END = "\r\n|[\n\r\x85\u2028\u2029]"  # the same line ends as in ``Source.line``
_ATTRIBUTE = re.compile(r"""(?s)\s+([^\s=]+)\s*=\s*(["'])(.*?)\2""")
_WORD = r"[^ \t\r\n]+"


class Word(NamedTuple):
    """A word of an attribute value or of text in an element, with its position."""

    text: str
    span: Span


class Attribute(NamedTuple):
    """An attribute of an element. Its positions are found by searching the source when they are accessed."""

    element: Element
    name: str
    value: str

    def _match(self) -> re.Match[str]:
        element = self.element
        found = _ATTRIBUTE.finditer(element.document.source.text, element.start + 1 + len(element.tag))
        return next(match for match in found if match[1] == self.name)

    @property
    def raw(self) -> str:
        """The value in the source text, where ``&lt;`` and other entity references are not replaced."""
        return self._match()[3]

    @property
    def start(self) -> int:
        return self._match().start(3)

    @property
    def name_start(self) -> int:
        return self._match().start(1)

    @property
    def span(self) -> Span:
        return self.element.document.whole or self.element.document.span(self.start, len(self.raw))

    @property
    def name_span(self) -> Span:
        return self.element.document.whole or self.element.document.span(self.name_start, len(self.name))

    def words(self) -> list[Word]:
        return self.element.document.words(self.raw, self.value, self.start, self.span)


class Remark(NamedTuple):
    """A comment, processing instruction or text (``kind``); ``start`` and ``end`` are offsets in the source."""

    kind: str
    text: str
    start: int
    end: int


class Element:
    """An XML element. ``start`` is its offset in the source; ``values`` are the values of its attributes by name."""

    __slots__ = ("children", "closed", "document", "parent", "remarks", "start", "tag", "values")

    def __init__(self, of: Document, tag: str, parent: Element | None, start: int, values: dict[str, str]) -> None:
        self.document, self.tag, self.parent, self.start, self.values = of, tag, parent, start, values
        self.closed = start  # the offset of its end tag, or of its end if it has no end tag
        self.children: list[Element] = []
        self.remarks: list[Remark] = []

    @property
    def attributes(self) -> dict[str, Attribute]:
        return {name: Attribute(self, name, value) for name, value in self.values.items()}

    @property
    def content(self) -> list[Element | Remark]:
        return sorted([*self.children, *self.remarks], key=lambda item: item.start)

    @property
    def end(self) -> int:
        """The offset of the end of the element in the source."""
        text = self.document.source.text
        is_empty = not (self.children or self.remarks) and text.startswith("/>", self.closed - 2)
        return self.closed if is_empty else text.index(">", self.closed) + 1

    @property
    def opened(self) -> int:
        """The offset of the end of the start tag: the first ">" after the values that contain a ">"."""
        ends = [one.start + len(one.raw) for one in self.attributes.values() if ">" in one.value]
        return self.document.source.text.index(">", max(ends, default=self.start)) + 1

    @property
    def texts(self) -> list[Remark]:
        return [item for item in self.remarks if item.kind == TEXT]

    @property
    def text(self) -> str:
        """The text of the element without the text of its children, stripped."""
        return "".join([one.text for one in self.remarks if one.kind == TEXT]).strip() if self.remarks else ""

    @property
    def span(self) -> Span:
        return self.document.whole or self.document.span(self.start + 1, len(self.tag))

    @property
    def verbatim(self) -> str:
        return self.document.source.text[self.start : self.end]

    def attribute(self, name: str) -> Attribute | None:
        return Attribute(self, name, self.values[name]) if name in self.values else None

    def get(self, name: str, default: str = "") -> str:
        return self.values.get(name, default)

    def iter(self) -> Iterator[Element]:
        waiting = [self]
        while waiting:
            element = waiting.pop()
            yield element
            waiting += reversed(element.children)

    def ancestors(self) -> Iterator[Element]:
        element = self
        while element.parent is not None:
            element = element.parent
            yield element


class Document:
    """A parsed XML document: ``root``, and the comments and processing instructions ``before`` and ``after`` it."""

    def __init__(self, source: Source) -> None:
        self.source = source
        self._starts: list[int] = []  # offsets of lines, found when the first span is needed
        self.before: list[Remark] = []
        self.after: list[Remark] = []
        self.root = Element(self, "", None, 0, {})
        self.origin: Callable[[int, int], Span] | None = None  # for generated XML: finds the source of (offset, length)
        self.whole: Span | None = None  # if set, the span of every element, for artifacts without positions

    def span(self, start: int, length: int = 1) -> Span:
        """Convert an offset and length in the source to a ``Span``, cut off at the end of the line."""
        if self.whole is not None:
            return self.whole
        if self.origin is not None:
            return self.origin(start, length)
        self._starts = self._starts or [0, *(match.end() for match in re.finditer(_LINE_END, self.source.text))]
        line = bisect_right(self._starts, start)
        column = start - self._starts[line - 1]
        if line < len(self._starts) and start + length > self._starts[line]:
            length = len(self.source.line(line)) - column
        return Span(self.source, line, column + 1, max(1, length))

    def words(self, raw: str, text: str, start: int, whole: Span) -> list[Word]:
        """Split text into words with positions; ``raw`` is the source of the text, at the offset ``start``.

        If ``raw`` has entity references, the positions are unknown, and the span of each word is ``whole``.
        """
        if self.whole is not None or "&" in raw or "<" in raw:  # entity references and CDATA change offsets
            return [Word(word, whole) for word in text.split()]
        return [Word(found[0], self.span(start + found.start(), len(found[0]))) for found in re.finditer(_WORD, raw)]


def name_of(element: Element) -> str:
    """Format an element for a message: <link name="arm">, or <mass> of <link name="arm"> if it has no name."""
    if name := element.get("name"):
        return f'<{element.tag} name="{name}">'
    above = next((outer for outer in element.ancestors() if outer.get("name")), None)
    return f"<{element.tag}>{f' of {name_of(above)}' if above is not None and above.parent is not None else ''}"


def words(element: Element) -> list[Word]:
    """Split the text of an element into words with their positions."""
    document = element.document
    pieces = ((document.source.text[item.start : item.end], item) for item in element.texts)
    return [word for raw, item in pieces for word in document.words(raw, item.text, item.start, element.span)]


def place(element: Element) -> Span:
    """Return the span of the text of an element if the text is a single word, else of the tag."""
    found = words(element) if element.document.whole is None else []
    return found[0].span if len(found) == 1 else element.span


def correction(word: str, known: Iterable[str]) -> str | None:
    """Return the name in ``known`` that ``word`` misspells, or None (also if ``word`` has a prefix: ``drake:mass``)."""
    if ":" in word or len(word) < 2:
        return None
    lower = {name.lower(): name for name in known if len(name) > 2}
    near = difflib.get_close_matches(word.lower(), lower, n=1, cutoff=0.8 if len(word) > 4 else 0.66)
    return lower[near[0]] if near else None


def new_parser() -> expat.XMLParserType:
    """Create an expat parser that ignores namespaces, and passes each text to its handler in one piece."""
    parser = expat.ParserCreate("utf-8")
    parser.buffer_text = True
    return parser


def parse(source: Source) -> Document:
    """Parse XML. Raises MarkupError with the position of the error."""
    reader = _Reader(source)
    try:
        reader.parser.Parse(reader.data, True)
    except expat.ExpatError as problem:
        at = len(reader.data[: max(0, reader.parser.ErrorByteIndex)].decode("utf-8", "replace"))
        raise MarkupError(_explained(reader.document, problem.code, at, reader.open)) from None
    return reader.document


def parse_artifact(text: str, tag: str) -> Document:
    """Parse generated XML without positions. Raises ValueError if it is invalid, or its root element is not ``tag``."""
    try:
        document = parse(Source("", text))
    except MarkupError as problem:
        raise ValueError(problem.diagnostic.message) from None
    if document.root.tag != tag:
        raise ValueError(f"the root element is {document.root.tag}, not {tag}")
    document.whole = document.source.span()
    return document


class _Reader:
    def __init__(self, source: Source) -> None:
        self.document, self.text = Document(source), source.text
        self.data = source.text.encode("utf-8", "surrogatepass")  # expat, not encode(), reports surrogates
        self.is_ascii = source.text.isascii()
        self.last = (0, 0)  # offset of the last event, in bytes and in characters
        self.open: list[Element] = []  # the open elements, outermost first
        self.count = 0
        self.parser = parser = new_parser()
        parser.StartElementHandler, parser.EndElementHandler = self.start, self.finish
        parser.CommentHandler = lambda text: self.remark(COMMENT, text, "-->")
        parser.ProcessingInstructionHandler = lambda *text: self.remark(INSTRUCTION, " ".join(text).strip(), "?>")
        parser.CharacterDataHandler, parser.StartDoctypeDeclHandler = self.characters, self.doctype

    def here(self) -> int:
        """Return the offset of the current event in characters; expat counts bytes."""
        byte, (last_byte, last) = self.parser.CurrentByteIndex, self.last
        if self.is_ascii:
            return byte
        self.last = (byte, last + len(self.data[last_byte:byte].decode("utf-8", "replace")))
        return self.last[1]

    def start(self, tag: str, values: dict[str, str]) -> None:
        start, parents = self.parser.CurrentByteIndex if self.is_ascii else self.here(), self.open
        made = Element(self.document, tag, parents[-1] if parents else None, start, values)
        if parents:
            parents[-1].children.append(made)
        else:
            self.document.root = made
        parents.append(made)
        self.count += 1
        if len(parents) > MAX_DEPTH or self.count > MAX_ELEMENTS:
            rule, message = "xml-too-deep", f"elements are nested deeper than {MAX_DEPTH} levels"
            if self.count > MAX_ELEMENTS:
                rule, message = "xml-too-large", f"there are more than {MAX_ELEMENTS:,} elements"
            raise MarkupError(error(rule, message, self.document.span(start + 1), "is this the right file?"))

    def finish(self, _tag: str) -> None:
        # Here, expat is behind an empty element, or at the end tag of another element.
        self.open.pop().closed = self.parser.CurrentByteIndex if self.is_ascii else self.here()

    def remark(self, kind: str, text: str, end: str) -> None:
        start, outside = self.here(), self.document.after if self.count else self.document.before
        made = Remark(kind, text, start, self.text.index(end, start) + len(end))
        (self.open[-1].remarks if self.open else outside).append(made)

    def characters(self, text: str) -> None:
        if text.isspace() or not self.open:
            return
        # With buffer_text, expat reports text after its end. With references or CDATA, it is longer in the source.
        element, end = self.open[-1], self.here()
        start = end - len(text.lstrip())
        if ";" in text or ">" in text or not self.text.startswith(text.lstrip(), start):
            start = element.content[-1].end if element.content else element.opened
            while start < len(self.text) - 1 and self.text[start].isspace():
                start += 1
        element.remarks.append(Remark(TEXT, text, start, end))

    def doctype(self, *_: object) -> None:
        message = "a document type (<!DOCTYPE>) may declare entities, which are not read"
        help = "remove the <!DOCTYPE ...>, which no robot description needs"
        raise MarkupError(error("xml-doctype", message, self.document.span(self.here(), len("<!DOCTYPE")), help))


_ENDS = {"<!--": "comment", "<![CDATA[": "CDATA section", "<?": "instruction", "<": "tag"}
_ESCAPES = 'write &lt; for <, &amp; for &, &quot; for "'
_ERRORS = expat.errors
_UNCLOSED = (_ERRORS.XML_ERROR_UNCLOSED_TOKEN, _ERRORS.XML_ERROR_PARTIAL_CHAR)
# By expat error: (pattern that matches the invalid text, help).
_PATTERNS = {
    _ERRORS.XML_ERROR_DUPLICATE_ATTRIBUTE: (r"[^\s=/>]+", "remove one of the two"),
    _ERRORS.XML_ERROR_UNDEFINED_ENTITY: (r"&(?!(?:lt|gt|amp|quot|apos);|#)[^;\s<\"']*;?", _ESCAPES),
}


def _explained(document: Document, code: int, at: int, open_elements: Sequence[Element]) -> Diagnostic:
    text, kind, length = document.source.text, expat.errors.messages[code], 1
    at = min(at, max(0, len(text) - 1))
    tag = open_elements[-1].tag if open_elements else ""
    related = [Related("opened here", element.span) for element in open_elements[-1:]]
    ends_early = kind in _UNCLOSED or kind == _ERRORS.XML_ERROR_NO_ELEMENTS
    if kind == _ERRORS.XML_ERROR_TAG_MISMATCH:
        at = text.rfind("<", 0, at + 1)
        end = text[at:].partition(">")[0]
        length, message, help = len(end), f"{end}> does not close <{tag}>", f"close <{tag}> first"
    elif kind in _UNCLOSED and text.startswith("<", at):
        sign = next(sign for sign in _ENDS if text.startswith(sign, at))
        message, help, length, related = f"this {_ENDS[sign]} is not closed", "close it", len(sign), []
    elif ends_early and tag:
        at, message, help = max(0, len(text.rstrip()) - 1), f"the file ends, but <{tag}> is not closed", f"add </{tag}>"
    elif ends_early:
        at, message, help = 0, "there is no XML element in this file", "is this the right file?"
    elif kind == _ERRORS.XML_ERROR_INVALID_TOKEN:
        (at, message, help), related = _invalid_token(text, at), []
    else:
        pattern, help = _PATTERNS.get(kind, ("", "correct it, or remove it"))
        found = re.compile(pattern).search(text, at) if pattern else None
        at, length = (found.start(), len(found[0])) if found else (at, 1)
        message = f"{expat.ErrorString(code)}{f' {found[0]}' if found else ''}"
        is_second = kind == _ERRORS.XML_ERROR_JUNK_AFTER_DOC_ELEMENT and document.root.tag
        related = [Related("the root element", document.root.span)] if is_second else []
        help = "remove it: an XML file has one root element" if is_second else help
    return error(RULE, message, document.span(at, length), help, related)


def _invalid_token(text: str, at: int) -> tuple[int, str, str]:
    letter, comment = text[at : at + 1], text.rfind("<!--", 0, at + 1)
    if letter and not letter.isprintable() and letter not in "\r\n\t":
        help = "remove it" if letter != "\0" or text[at:].strip("\0 \r\n\t") else "remove it; --lenient ignores it"
        return at, f"the character U+{ord(letter):04X} is not allowed in XML", help
    if comment >= 0 and text.find("-->", comment + 4, at) < 0:
        return at, '"--" is not allowed inside a comment', "write one dash; --lenient accepts it as it is"
    if text[max(0, at - 1) : at] == "&":
        return at - 1, '"&" is not allowed here', _ESCAPES
    help = _ESCAPES if letter in ("<", "&") else 'a ">" or the quotes of a value are missing before it'
    shown = "a space" if letter.isspace() else f'"{letter}"'
    return at, f"{shown} is not allowed here", help
