"""Markup: XML read safely, every element, attribute and comment with its place.

Built on expat without namespaces, so a prefix that nobody declares is part of a name, as for the readers of URDF. A
document type is refused where it begins, so no entity is ever declared, expanded or fetched. ``complaint`` tells what
expat has to say of a text that is no XML, in words that say what to do.
"""

from __future__ import annotations

import re
from bisect import bisect_right
from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING, NamedTuple
from xml.parsers import expat

from ..diagnostics import Diagnostic, Related, Source, Span, error
from ..rule_registry import READING, Rule
from .elements import canonical, indented, new_parser, tree_of

if TYPE_CHECKING:
    from xml.etree import ElementTree

RULES = (
    Rule(
        "xml-syntax",
        "This is not XML.",
        "Correct it as the message says; `--lenient` takes what readers of URDF pass over.",
        READING,
    ),
    Rule(
        "xml-doctype",
        "The file has a document type, in which a stranger can declare entities that grow without end or name other "
        "files.",
        "Remove the `<!DOCTYPE ...>`.",
        READING,
    ),
    Rule("xml-too-deep", "Elements are nested deeper than in any robot.", "Name the right file.", READING),
    Rule("xml-too-large", "There are more elements than in any robot.", "Name the right file.", READING),
)


MAX_DEPTH = 200
MAX_ELEMENTS = 2_000_000

_RIGHT = "is this the right file?"

# As ``Source.line`` counts lines.
_LINE_END = re.compile("\r\n|[\n\r\x85\u2028\u2029]")
_ATTRIBUTE = re.compile(r"""\s+([^\s=]+)\s*=\s*(?:"([^"]*)"|'([^']*)')""")
_WORD = re.compile(r"[^ \t\r\n]+")


class MarkupError(Exception):
    """A text that is no XML, or XML that is not safe to read; carries the diagnostic."""

    def __init__(self, diagnostic: Diagnostic) -> None:
        super().__init__(diagnostic.message)
        self.diagnostic = diagnostic


class Word(NamedTuple):
    """A piece of an attribute between white space, and its place."""

    text: str
    span: Span


class Attribute(NamedTuple):
    """An attribute: its value, and the offsets of its name and of ``raw``, the value as it stands in the text."""

    document: Document
    name: str
    value: str
    name_start: int
    start: int
    raw: str

    @property
    def span(self) -> Span:
        """Return the place of the value, without its quotes; of an empty one the closing quote."""
        return self.document.span(self.start, len(self.raw))

    @property
    def name_span(self) -> Span:
        """Return the place of the name."""
        return self.document.span(self.name_start, len(self.name))

    def words(self) -> list[Word]:
        """Return the pieces between white space. Those of a value with references (``&#48;``) have its whole place."""
        if "&" in self.raw:
            return [Word(text, self.span) for text in self.value.split()]
        matches = _WORD.finditer(self.raw)
        if self.document.origin is not None or "\n" in self.raw or "\r" in self.raw or not self.raw.isascii():
            span = self.document.span
            return [Word(match[0], span(self.start + match.start(), match.end() - match.start())) for match in matches]
        source, line, column, _ = self.span
        return [Word(m[0], Span(source, line, column + m.start(), m.end() - m.start())) for m in matches]


class Remark(NamedTuple):
    """A comment, or text between elements, or a processing instruction: what it says, from ``start`` to ``end``."""

    kind: str
    text: str
    start: int
    end: int

    @property
    def is_comment(self) -> bool:
        """Whether this is a comment."""
        return self.kind == COMMENT


COMMENT, TEXT, INSTRUCTION = "comment", "text", "instruction"


class Element:
    """An element: name, attributes, and what it holds in order; ``start`` to ``end`` are its offsets in the text."""

    __slots__ = ("attributes", "content", "document", "end", "opened", "parent", "start", "tag")

    def __init__(self, document: Document, tag: str, parent: Element | None, start: int) -> None:
        self.document = document
        self.tag = tag
        self.parent = parent
        self.start = start
        self.opened = self.end = start
        self.attributes: dict[str, Attribute] = {}
        self.content: list[Element | Remark] = []

    @property
    def children(self) -> list[Element]:
        """Return the elements that it holds."""
        return [item for item in self.content if isinstance(item, Element)]

    @property
    def comments(self) -> list[Remark]:
        """Return the comments directly in it."""
        return [item for item in self.content if isinstance(item, Remark) and item.is_comment]

    @property
    def text(self) -> str:
        """Return the text directly in it, without white space around."""
        return "".join(i.text for i in self.content if isinstance(i, Remark) and i.kind == TEXT).strip()

    @property
    def span(self) -> Span:
        """Return the place of the name in the start tag."""
        return self.document.span(self.start + 1, len(self.tag))

    @property
    def verbatim(self) -> str:
        """Return the element as it stands in the text."""
        return self.document.source.text[self.start : self.end]

    def get(self, name: str, default: str = "") -> str:
        """Return the value of an attribute."""
        attribute = self.attributes.get(name)
        return default if attribute is None else attribute.value

    def iter(self) -> Iterator[Element]:
        """Yield the element and all within, in the order of the text."""
        waiting = [self]
        while waiting:
            element = waiting.pop()
            yield element
            waiting += reversed(element.children)


class Document:
    """A text read as XML: its root, and the remarks ``before`` and ``after`` it.

    A text that a program has made of files that people have (``origin``) knows its places in those.
    """

    def __init__(self, source: Source) -> None:
        self.source = source
        self._starts = [0, *(match.end() for match in _LINE_END.finditer(source.text))]
        self.before: list[Remark] = []
        self.after: list[Remark] = []
        self.root = Element(self, "", None, 0)
        self.origin: Callable[[int, int], Span] | None = None

    @classmethod
    def parse(cls, source: Source) -> Document:
        """Return a text as XML. Raises MarkupError, which names the place."""
        return parse(source)

    @staticmethod
    def tree(text: str) -> ElementTree.Element:
        """Return a text as elements of the standard library, without places and without namespaces.

        Raises ValueError if it is not well formed, or might declare entities.
        """
        return tree_of(text)

    @staticmethod
    def canonical(tree: ElementTree.Element) -> str:
        """Return elements in one spelling: what has the same differs in white space, comments and spelling alone."""
        return canonical(tree)

    @staticmethod
    def indented(text: str, indent: str) -> str:
        """Return elements with the first line after ``indent``, and the others as far right as they were from it."""
        return indented(text, indent)

    def span(self, start: int, length: int = 1) -> Span:
        """Return the place of the characters from an offset on; it ends with the line at the latest."""
        if self.origin is not None:
            return self.origin(start, length)
        line = bisect_right(self._starts, start)
        column = start - self._starts[line - 1]
        if line < len(self._starts) and start + length > self._starts[line]:
            length = len(self.source.line(line)) - column
        return Span(self.source, line, column + 1, max(1, length))


def parse(source: Source) -> Document:
    """Return a text as XML. Raises MarkupError, which names the place."""
    return _Reader(source).read()


class _Reader:
    """Follows expat's events with a stack of its own, so that no nesting can exhaust the interpreter."""

    def __init__(self, source: Source) -> None:
        self.document = Document(source)
        self.data = source.text.encode("utf-8", "replace")
        self.ascii = len(self.data) == len(source.text)
        self.known = (0, 0)
        self.open: Element | None = None
        self.depth = self.count = 0
        self.root_seen = False
        self.parser = new_parser()
        self.parser.ordered_attributes = True
        self.parser.StartElementHandler = self.start
        self.parser.EndElementHandler = lambda _: self.finish()
        self.parser.CommentHandler = self.comment
        self.parser.ProcessingInstructionHandler = self.instruction
        self.parser.CharacterDataHandler = self.text
        self.parser.StartDoctypeDeclHandler = lambda *_: self.doctype()

    def read(self) -> Document:
        try:
            self.parser.Parse(self.data, True)
        except expat.ExpatError as problem:
            at = self.offset(max(0, self.parser.ErrorByteIndex))
            raise MarkupError(complaint(self.document, problem.code, at, self.open)) from None
        return self.document

    def offset(self, byte: int) -> int:
        """Return the offset in characters of one in bytes; those asked for grow."""
        if self.ascii:
            return byte
        bytes_known, known = self.known
        if byte < bytes_known:
            bytes_known = known = 0
        known += len(self.data[bytes_known:byte].decode("utf-8", "replace"))
        self.known = (byte, known)
        return known

    def fail(self, rule: str, message: str, start: int, help: str = "", length: int = 1) -> MarkupError:
        return MarkupError(error(rule, message, self.document.span(start, length), help))

    def start(self, tag: str, pairs: list[str]) -> None:
        start = self.offset(self.parser.CurrentByteIndex)
        self.count += 1
        self.depth += 1
        if self.depth > MAX_DEPTH:
            raise self.fail("xml-too-deep", f"elements are nested deeper than {MAX_DEPTH} levels", start + 1, _RIGHT)
        if self.count > MAX_ELEMENTS:
            raise self.fail("xml-too-large", f"there are more than {MAX_ELEMENTS:,} elements", start + 1, _RIGHT)
        made = Element(self.document, tag, self.open, start)
        position = start + 1 + len(tag)
        text = self.document.source.text
        for index in range(0, len(pairs), 2):
            match = _ATTRIBUTE.match(text, position)
            if match is None:  # expat has read the tag: it has this form
                raise self.fail("xml-syntax", "an attribute cannot be read", position)
            group = 2 if match[2] is not None else 3
            name = pairs[index]
            at = (match.start(1), match.start(group))
            made.attributes[name] = Attribute(self.document, name, pairs[index + 1], *at, match[group])
            position = match.end()
        made.opened = text.index(">", position) + 1
        if self.open is None:
            self.document.root = made
            self.root_seen = True
        else:
            self.open.content.append(made)
        self.open = made

    def finish(self) -> None:
        made = self.open
        if made is None:
            return
        text = self.document.source.text
        if text.startswith("/", made.opened - 2):
            made.end = made.opened
        else:
            made.end = text.index(">", self.offset(self.parser.CurrentByteIndex)) + 1
        self.open = made.parent
        self.depth -= 1

    def remark(self, kind: str, text: str, end: str) -> None:
        start = self.offset(self.parser.CurrentByteIndex)
        made = Remark(kind, text, start, self.document.source.text.index(end, start) + len(end))
        if self.open is not None:
            self.open.content.append(made)
        else:
            (self.document.after if self.root_seen else self.document.before).append(made)

    def comment(self, text: str) -> None:
        self.remark(COMMENT, text, "-->")

    def instruction(self, target: str, text: str) -> None:
        self.remark(INSTRUCTION, f"{target} {text}".strip(), "?>")

    def text(self, text: str) -> None:
        if self.open is not None and not text.isspace():
            # With buffer_text this is the place where the text ends.
            end = self.offset(self.parser.CurrentByteIndex)
            self.open.content.append(Remark(TEXT, text, self.beginning(), end))

    def beginning(self) -> int:
        """Return where the text began that ends here: behind what came before it."""
        here = self.open
        if here is None:
            return 0
        start = here.content[-1].end if here.content else here.opened
        text = self.document.source.text
        while start < len(text) - 1 and text[start].isspace():
            start += 1
        return start

    def doctype(self) -> None:
        start = self.offset(self.parser.CurrentByteIndex)
        message = "a document type (<!DOCTYPE>) may declare entities, which are not read: they can grow without end"
        help = "remove the <!DOCTYPE ...>; no reader of robots needs one"
        raise self.fail("xml-doctype", f"{message} and name other files", start, help, len("<!DOCTYPE"))


RULE = "xml-syntax"

_ERRORS = expat.errors
_CLOSING = re.compile(r"</\s*([^\s>]+)")
_NAME = re.compile(r"[^\s=/>]+")
_REFERS = re.compile(r"&(?!(?:lt|gt|amp|quot|apos);|#)[^;\s<\"']*;?")
_IN_TAG = re.compile(r"<([^\s<>/!?]+)[^<>]*\Z")
_ENDS = {"<!--": ("comment", "-->"), "<![CDATA[": ("CDATA section", "]]>"), "<?": ("instruction", "?>")}
_TAKEN = "--lenient takes it as it is"
_ESCAPES = 'write &lt; for <, &amp; for &, &quot; for "'


def complaint(document: Document, code: int, at: int, open_element: Element | None) -> Diagnostic:
    """Return the error about a text that expat stopped in, at the offset ``at`` with the error ``code``."""
    text = document.source.text
    at = min(at, max(0, len(text) - 1))
    where, length, related, help = at, 1, [Related("opened here", open_element.span)] if open_element else [], ""
    kind = expat.errors.messages[code]
    if kind == _ERRORS.XML_ERROR_TAG_MISMATCH and open_element is not None:
        match = _CLOSING.match(text, text.rfind("<", 0, at + 1))
        where, length = (match.start(), len(match[0])) if match else (at, 1)
        message = f"</{match[1] if match else '?'}> closes what is not open: <{open_element.tag}> is"
        help = f"close <{open_element.tag}> first, or correct the name"
        return error(RULE, message, document.span(where, length), help, related)
    unclosed = kind in (_ERRORS.XML_ERROR_UNCLOSED_TOKEN, _ERRORS.XML_ERROR_PARTIAL_CHAR)
    if unclosed and text.startswith("<", at):
        beginning = next((one for one in _ENDS if text.startswith(one, at)), "<")
        name, ending = _ENDS.get(beginning, ("tag", ">, or a missing quote"))
        span = document.span(at, len(beginning))
        return error(RULE, f"this {name} is not closed", span, f"add {ending}")
    if unclosed or kind == _ERRORS.XML_ERROR_NO_ELEMENTS:
        if open_element is None:
            return error(RULE, "there is no XML element in this file", document.span(0), "is this the right file?")
        message, end = f"the file ends, but <{open_element.tag}> is not closed", max(0, len(text.rstrip()) - 1)
        return error(RULE, message, document.span(end), f"add </{open_element.tag}>", related)
    if kind == _ERRORS.XML_ERROR_INVALID_TOKEN:
        return _token(document, at)
    related = []
    if kind == _ERRORS.XML_ERROR_JUNK_AFTER_DOC_ELEMENT:
        message = "there is text behind the end of the root element; XML has one root"
        help = "put everything into one root element"
        related = [Related("the root element", document.root.span)] if document.root.tag else []
    elif kind == _ERRORS.XML_ERROR_DUPLICATE_ATTRIBUTE:
        match = _NAME.match(text, at)
        message, help = f'an element has the attribute "{match[0] if match else ""}" twice', "remove one"
    elif kind == _ERRORS.XML_ERROR_UNDEFINED_ENTITY:
        match = _REFERS.search(text, at)
        where, length = (match.start(), len(match[0])) if match else (at, 1)
        message = f"there is no entity {match[0] if match else ''}".rstrip()
        help = f"no entities are declared; {_ESCAPES}"
    elif kind == _ERRORS.XML_ERROR_MISPLACED_XML_PI:
        message = "the declaration <?xml ...?> is not at the very beginning of the file"
        help = "remove what is before it"
    elif kind == _ERRORS.XML_ERROR_BAD_CHAR_REF:
        message, help = "this reference names no character that XML has", "write the character itself"
    else:
        message = f"this is not well-formed XML: {expat.ErrorString(code)}"
        help = "add ]]>" if kind == _ERRORS.XML_ERROR_UNCLOSED_CDATA_SECTION else ""
    return error(RULE, message, document.span(where, length), help, related)


def _token(document: Document, at: int) -> Diagnostic:
    text = document.source.text
    letter = text[at] if text else ""
    if letter and not letter.isprintable() and letter not in "\r\n\t":
        last = letter == "\0" and not text[at:].strip("\0 \r\n\t")
        help = f"remove it; {_TAKEN}" if last else "remove it"
        return error(RULE, f"the character U+{ord(letter):04X} is not allowed in XML", document.span(at), help)
    comment = text.rfind("<!--", 0, at + 1)
    if comment >= 0 and text.find("-->", comment + 4, at) < 0:
        help = f"XML ends a comment with -->; write one dash, or another sign; {_TAKEN}"
        return error(RULE, '"--" is not allowed inside a comment', document.span(at), help)
    if text[max(0, at - 1) : at] == "&":
        at, letter = at - 1, "&"
    tag = _IN_TAG.search(text[max(0, at - 1000) : at])
    message, help = "this is not well-formed XML", 'an attribute is written name="value", with quotes'
    if letter.isspace() and tag:
        message, help = f"the tag of <{tag[1]}> is not closed", "add >"
    elif letter in ("<", "&"):
        message = f'"{letter}" is not allowed here'
        help = _ESCAPES + ("; or a quote or a > is missing before" if letter == "<" else "")
    elif letter.isprintable() and letter:
        message = f'"{letter}" is not allowed here'
    return error(RULE, message, document.span(at), help)
