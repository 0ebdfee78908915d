"""Read XML files as text in the encoding that they declare, and repair what other readers ignore."""

from __future__ import annotations

import codecs
import re
from pathlib import Path

from ..diagnostics import Source, Span, error
from ..files import shown
from ..load import decoded, read_input
from ..rule_registry import READING, Rule
from .markup import Document, MarkupError

RULES = (
    Rule("file-empty", "There is nothing in the file.", "Name the right file.", READING),
    Rule("not-text", "The file is not text.", "Name a URDF, a xacro, an SDF or an MJCF.", READING),
)

MAX_BYTES = 100_000_000

# https://www.w3.org/TR/xml/#sec-guessing: marks, the longer ones first; then UTF-16 without a mark.
_BEGINNINGS = (
    *((codecs.BOM_UTF8, "utf-8"), (codecs.BOM_UTF32_LE, "utf-32-le"), (codecs.BOM_UTF32_BE, "utf-32-be")),
    *((codecs.BOM_UTF16_LE, "utf-16-le"), (codecs.BOM_UTF16_BE, "utf-16-be")),
    *((b"<\0?\0", "utf-16-le"), (b"\0<\0?", "utf-16-be")),
)
# What may be before a declaration. A comment ends at its first end: with a lazy ".*?" the time would double with each.
_MISC = r"(?:\s|<!--(?:(?!-->).)*-->)*"
_DECLARED = re.compile(_MISC + r"""<\?xml\s[^>]*?encoding\s*=\s*["']([A-Za-z][A-Za-z0-9._-]{0,40})["']""", re.DOTALL)
_DECLARATION = re.compile(_MISC + r"(<\?xml\s[^>]*\?>)", re.DOTALL)
# Of the codecs of Python, some are for other things than files, or interpret an escape language.
_ENCODING = re.compile(r"utf-8|ascii|iso8859|iso2022|cp\d|gb|hz|big5|euc|shift_jis|johab|koi8|mac|tis|ptcp|kz")
_COMMENT = re.compile("<!--(.*?)-->", re.DOTALL)
_TAG = re.compile(r"""<!--.*?-->|<!\[CDATA\[.*?\]\]>|(<[A-Za-z_](?:[^<>"']|"[^"]*"|'[^']*')*>)""", re.DOTALL)
_ATTRIBUTE = re.compile(r"""(=\s*(?:"[^"]*"|'[^']*'))(?=[A-Za-z_])""")


def read_source(path: Path, asked: Span | None = None) -> Source:
    """Return the text of a file; ``asked`` is the place that names it. Raises MarkupError with a clear message."""
    name = shown(path)
    data = read_input(path, name, asked, MAX_BYTES, "check the name and the permissions")
    if not data.strip():
        raise MarkupError(error("file-empty", f"{name} is empty", asked, "is this the right file?"))
    encoding = _encoding(data, name)
    if b"\0" in data.rstrip(b"\0 \r\n\t")[:1000] and not encoding.startswith(("utf-16", "utf-32")):
        message = f"{name} is not a text file: it contains zero bytes"
        raise MarkupError(error("not-text", message, asked, "name a URDF, xacro, SDF or MJCF file"))
    declared = '<?xml version="1.0" encoding="ISO-8859-1"?>'
    return decoded(data, name, encoding, f"save the file as UTF-8, or declare its encoding: {declared}")


def _encoding(data: bytes, name: str) -> str:
    """Return the encoding of a file: by its first bytes, or the one it declares. Raises MarkupError."""
    for beginning, encoding in _BEGINNINGS:
        if data.startswith(beginning):
            return encoding
    source = Source(name, data[:10_000].decode("ascii", "replace"))
    match = _DECLARED.match(source.text)
    try:
        encoding = codecs.lookup(match[1]).name if match else "utf-8"
    except LookupError:
        encoding = ""
    if match and not _ENCODING.match(encoding):
        message = f'{name} declares the encoding "{match[1]}", which is unknown or not its own'
        span = Document(source).span(match.start(1), len(match[1]))
        raise MarkupError(error("not-utf8", message, span, "save the file as UTF-8"))
    return encoding


def without_late_declaration(source: Source) -> Source:
    """Blank out a declaration ``<?xml ...?>`` that is behind space or comments, as tinyxml2 accepts it."""
    match, text = _DECLARATION.match(source.text), source.text
    if match is None or match.start(1) == 0:
        return source
    return Source(source.path, text[: match.start(1)] + re.sub(r"\S", " ", match[1]) + text[match.end() :])


def mended(source: Source) -> Source:
    """Repair what other readers accept: ``--`` inside comments, zero bytes at the end, attributes without a space."""
    text = source.text
    bare = text.rstrip("\0 \r\n\t")
    text = bare + text[len(bare) :].replace("\0", " ")
    text = _COMMENT.sub(lambda comment: f"<!--{re.sub('-(?=-|$)', ' ', comment[1])}-->", text)
    return Source(source.path, _TAG.sub(lambda tag: tag[0] if tag[1] is None else _ATTRIBUTE.sub(r"\1 ", tag[0]), text))
