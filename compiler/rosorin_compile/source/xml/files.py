"""Read XML files as text in the encoding that they declare, and repair what other readers ignore."""

from __future__ import annotations

import codecs
import re
from pathlib import Path

from ..diagnostics import Source, Span, error
from ..files import shown
from ..load import read_input
from ..rule_registry import READING, Rule
from ..wording import masked
from .markup import Document, MarkupError

RULES = (
    Rule("file-empty", "There is nothing in the file.", "Name the right file.", READING),
    Rule("not-text", "The file is not text.", "Name a URDF, a xacro, an SDF or an MJCF.", READING),
)


MAX_BYTES = 100_000_000

# https://www.w3.org/TR/xml/#sec-guessing; the longer marks first, then UTF-16 without a mark.
_MARKS = (
    *((codecs.BOM_UTF8, "utf-8"), (codecs.BOM_UTF32_LE, "utf-32-le"), (codecs.BOM_UTF32_BE, "utf-32-be")),
    *((codecs.BOM_UTF16_LE, "utf-16-le"), (codecs.BOM_UTF16_BE, "utf-16-be")),
)
_BARE = ((b"<\0?\0", "utf-16-le"), (b"\0<\0?", "utf-16-be"))
# A comment ends at its first end: with a lazy ".*?" the time would double with each comment.
_DECLARED = re.compile(
    rb"""(?:\s|<!--(?:(?!-->).)*-->)*<\?xml\s[^>]*?encoding\s*=\s*["']([A-Za-z][A-Za-z0-9._-]{0,40})["']""", re.DOTALL
)
# Codecs of Python that are not encodings of a text file; some interpret an escape language.
_NO_ENCODING = {"unicode-escape", "raw-unicode-escape", "idna", "punycode", "utf-7", "undefined", "mbcs", "oem"}


def printable_name(path: Path) -> str:
    """Return the name of a file without line ends and undecodable bytes."""
    return masked(path.name)


def read_source(path: Path, asked: Span | None = None) -> Source:
    """Return the text of a file; ``asked`` is the place that names it. Raises MarkupError with a clear message."""
    name = shown(path)

    def refuse(rule: str, message: str, help: str) -> MarkupError:
        return MarkupError(error(rule, message, asked, help))

    data = read_input(path, name, asked, MAX_BYTES, "check the name and the permissions")
    if not data.strip():
        raise refuse("file-empty", f"{name} is empty", "is this the right file?")
    encoding, skip = _encoding(data, name)
    if b"\0" in data.rstrip(b"\0 \r\n\t")[:1000] and not encoding.startswith(("utf-16", "utf-32")):
        message = f"{name} is not a text file: it contains zero bytes"
        raise refuse("not-text", message, "name a URDF, xacro, SDF or MJCF file")
    try:
        return Source(name, data[skip:].decode(encoding))
    except UnicodeDecodeError as problem:
        source = Source(name, data[skip:].decode(encoding, "replace"))
        start = len(data[skip : skip + problem.start].decode(encoding, "replace"))
        message = f"{name} is not {encoding.upper()} text: byte {data[skip + problem.start]:#04x} at this place"
        help = 'save the file as UTF-8, or declare its encoding: <?xml version="1.0" encoding="ISO-8859-1"?>'
        raise MarkupError(error("not-utf8", message, Document(source).span(start), help)) from None


def _encoding(data: bytes, name: str) -> tuple[str, int]:
    """Return the encoding of a file, and the length of its mark in bytes."""
    for beginnings, has_mark in ((_MARKS, True), (_BARE, False)):
        for beginning, encoding in beginnings:
            if data.startswith(beginning):
                return encoding, len(beginning) if has_mark else 0
    match = _DECLARED.match(data)
    if match is None:
        return "utf-8", 0
    declared = match[1].decode("ascii")
    span = Span(Source(name, data[:1000].decode("ascii", "replace")), 1, match.start(1) + 1, len(declared))
    try:
        codec = codecs.lookup(declared)
    except LookupError:
        codec = None
    if codec is None or codec.name in _NO_ENCODING or not getattr(codec, "_is_text_encoding", True):
        raise MarkupError(error("not-utf8", f'unknown encoding "{declared}"', span, "save the file as UTF-8"))
    if codec.name.startswith(("utf-16", "utf-32")):  # the declaration itself is ASCII
        message = f"{name} declares {declared}, but is not"
        raise MarkupError(error("not-utf8", message, span, "declare the encoding that it is saved in, such as UTF-8"))
    return codec.name, 0


_COMMENT = re.compile("<!--(.*?)-->", re.DOTALL)
_TAG = re.compile(r"""<!--.*?-->|<!\[CDATA\[.*?\]\]>|(<[A-Za-z_](?:[^<>"']|"[^"]*"|'[^']*')*>)""", re.DOTALL)
_ATTRIBUTE = re.compile(r"""(=\s*(?:"[^"]*"|'[^']*'))(?=[A-Za-z_])""")
_MISC = re.compile(r"\s+|<!--.*?-->", re.DOTALL)
_DECLARATION = re.compile(r"<\?xml\s[^>]*\?>")


def without_late_declaration(source: Source) -> Source:
    """Blank out a declaration ``<?xml ...?>`` that is behind space or comments, as tinyxml2 accepts it."""
    at = 0
    # One piece at a time: as one pattern with a repetition, many comments take a time that doubles with each of them.
    while piece := _MISC.match(source.text, at):
        at = piece.end()
    match = _DECLARATION.match(source.text, at) if at else None
    if match is None:
        return source
    blank = re.sub(r"\S", " ", match[0])
    return Source(source.path, source.text[:at] + blank + source.text[match.end() :])


def mended(source: Source) -> Source:
    """Repair what other readers accept: ``--`` inside comments, zero bytes at the end, attributes without a space."""
    text = source.text
    bare = text.rstrip("\0 \r\n\t")
    text = bare + text[len(bare) :].replace("\0", " ")
    text = _COMMENT.sub(_without_dashes, text)
    return Source(source.path, _TAG.sub(lambda tag: tag[0] if tag[1] is None else _ATTRIBUTE.sub(r"\1 ", tag[0]), text))


def _without_dashes(comment: re.Match[str]) -> str:
    inner = comment[1].replace("--", "- ")
    if inner.endswith("-"):
        inner = f"{inner[:-1]} "
    return f"<!--{inner.replace('--', '- ')}-->"
