"""What expat has to say of a text that is no XML, in words that tell what to do."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING
from xml.parsers import expat

from ..diagnostic import Diagnostic, Related, error

if TYPE_CHECKING:
    from .markup import Document, Element

RULE = "xml-syntax"

_CODES = expat.errors.codes
_NOTHING = _CODES[expat.errors.XML_ERROR_NO_ELEMENTS]
_MISMATCH = _CODES[expat.errors.XML_ERROR_TAG_MISMATCH]
_UNCLOSED = (_CODES[expat.errors.XML_ERROR_UNCLOSED_TOKEN], _CODES[expat.errors.XML_ERROR_PARTIAL_CHAR])
_SECOND = _CODES[expat.errors.XML_ERROR_JUNK_AFTER_DOC_ELEMENT]
_TWICE = _CODES[expat.errors.XML_ERROR_DUPLICATE_ATTRIBUTE]
_ENTITY = _CODES[expat.errors.XML_ERROR_UNDEFINED_ENTITY]
_DECLARATION = _CODES[expat.errors.XML_ERROR_MISPLACED_XML_PI]
_REFERENCE = _CODES[expat.errors.XML_ERROR_BAD_CHAR_REF]
_CDATA = _CODES[expat.errors.XML_ERROR_UNCLOSED_CDATA_SECTION]
_TOKEN = _CODES[expat.errors.XML_ERROR_INVALID_TOKEN]

_CLOSING = re.compile(r"</\s*([^\s>]+)")
_NAME = re.compile(r"[^\s=/>]+")
_REFERS = re.compile(r"&(?!(?:lt|gt|amp|quot|apos);|#)[^;\s<\"']*;?")
_IN_TAG = re.compile(r"<([^\s<>/!?]+)[^<>]*\Z")

_TAKEN = "--lenient takes it as it is"
_ESCAPES = 'write &lt; for <, &amp; for &, &quot; for "'


def complaint(document: Document, code: int, at: int, open_element: Element | None) -> Diagnostic:
    """Return what is wrong with a text that expat stopped in, at the offset ``at`` with the error ``code``."""
    text = document.source.text
    at = min(at, max(0, len(text) - 1))
    if code == _NOTHING:
        return _unfinished(document, open_element)
    if code in _UNCLOSED:
        return _unclosed(document, at, open_element)
    if code == _MISMATCH and open_element is not None:
        return _mismatch(document, at, open_element)
    span = document.span(at)
    if code == _SECOND:
        message = "something stands behind the end of the root element; XML has one root"
        return error(RULE, message, span, "put everything into one root element", _root(document))
    if code == _TWICE:
        name = _NAME.match(text, at)
        word = name[0] if name else ""
        return error(RULE, f'the attribute "{word}" stands twice in one element', span, "remove one")
    if code == _ENTITY:
        found = _REFERS.search(text, at)
        if found is not None:
            span = document.span(found.start(), len(found[0]))
        message = f"there is no entity {found[0] if found else ''}".rstrip()
        return error(RULE, message, span, f"no entities are declared; {_ESCAPES}")
    if code == _DECLARATION:
        message = "the declaration <?xml ...?> is not at the very beginning of the file"
        return error(RULE, message, span, "remove what stands before it")
    if code == _REFERENCE:
        return error(RULE, "this reference names no character that XML has", span, "write the character itself")
    if code == _TOKEN:
        return _token(document, at)
    help = "add ]]>" if code == _CDATA else ""
    return error(RULE, f"this is not well-formed XML: {expat.ErrorString(code)}", span, help)


def _root(document: Document) -> list[Related]:
    return [Related("the root element", document.root.span)] if document.root.tag else []


def _unfinished(document: Document, open_element: Element | None) -> Diagnostic:
    """Return the message about a text that ends before its root element is closed, or has none."""
    end = max(0, len(document.source.text.rstrip()) - 1)
    if open_element is None:
        message = "there is no XML element in this file"
        return error(RULE, message, document.span(0), "is this the right file?")
    message = f"the file ends, but <{open_element.tag}> is not closed"
    related = [Related("opened here", open_element.span)]
    return error(RULE, message, document.span(end), f"add </{open_element.tag}>", related)


def _unclosed(document: Document, at: int, open_element: Element | None) -> Diagnostic:
    text = document.source.text
    kinds = {"<!--": ("comment", "-->"), "<![CDATA[": ("CDATA section", "]]>"), "<?": ("instruction", "?>")}
    for beginning, (kind, end) in kinds.items():
        if text.startswith(beginning, at):
            return error(RULE, f"this {kind} is not closed", document.span(at, len(beginning)), f"add {end}")
    if text.startswith("<", at):
        return error(RULE, "this tag is not closed", document.span(at), "add >, or a missing quote")
    return _unfinished(document, open_element)


def _mismatch(document: Document, at: int, open_element: Element) -> Diagnostic:
    found = _CLOSING.match(document.source.text, document.source.text.rfind("<", 0, at + 1))
    closed = found[1] if found else "?"
    span = document.span(found.start(), len(found[0])) if found else document.span(at)
    message = f"</{closed}> closes what is not open: <{open_element.tag}> is"
    help = f"close <{open_element.tag}> first, or correct the name"
    return error(RULE, message, span, help, [Related("opened here", open_element.span)])


def _token(document: Document, at: int) -> Diagnostic:
    """Return the message about a character that may not stand where it does."""
    text = document.source.text
    span, letter = document.span(at), text[at] if text else ""
    if letter and not letter.isprintable() and letter not in "\r\n\t":
        last = letter == "\0" and not text[at:].strip("\0 \r\n\t")
        help = f"remove it; {_TAKEN}" if last else "remove it"
        return error(RULE, f"the character U+{ord(letter):04X} may not stand in XML", span, help)
    comment = text.rfind("<!--", 0, at + 1)
    if comment >= 0 and text.find("-->", comment + 4, at) < 0:
        message = '"--" may not stand inside a comment'
        return error(RULE, message, span, f"XML ends a comment with -->; write one dash, or another sign; {_TAKEN}")
    if text[max(0, at - 1) : at] == "&":
        at -= 1
        span, letter = document.span(at), "&"
    tag = _IN_TAG.search(text[max(0, at - 1000) : at])
    if letter.isspace() and tag:
        return error(RULE, f"the tag of <{tag[1]}> is not closed", span, "add >")
    if letter == "<":
        return error(RULE, '"<" may not stand here', span, f"{_ESCAPES}; or a quote or a > is missing before")
    if letter == "&":
        return error(RULE, '"&" may not stand alone', span, _ESCAPES)
    message = f'"{letter}" may not stand here' if letter.isprintable() and letter else "this is not well-formed XML"
    return error(RULE, message, span, 'an attribute is written name="value", with quotes')
