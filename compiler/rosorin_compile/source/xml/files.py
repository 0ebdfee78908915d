"""Files of other programs, read as text in the encoding that they declare.

``mended`` and ``without_late_declaration`` are for texts that are no XML although it is plain what is meant.
"""

from __future__ import annotations

import codecs
import re
from pathlib import Path

from .. import files
from ..diagnostics import Diagnostic, Source, Span, error
from ..files import shown
from ..project import stdin_of
from ..rule_registry import READING, Rule
from ..wording import masked
from .markup import Document, MarkupError

RULES = (
    Rule("file-empty", "There is nothing in the file.", "Name the right file.", READING),
    Rule("not-text", "The file is not text.", "Name a URDF, a xacro, an SDF or an MJCF.", READING),
)


MAX_BYTES = 100_000_000
_NO_FILE = "check the name and the permissions"

# https://www.w3.org/TR/xml/#sec-guessing; the longer marks first.
_MARKS = (
    (codecs.BOM_UTF8, "utf-8"),
    (codecs.BOM_UTF32_LE, "utf-32-le"),
    (codecs.BOM_UTF32_BE, "utf-32-be"),
    (codecs.BOM_UTF16_LE, "utf-16-le"),
    (codecs.BOM_UTF16_BE, "utf-16-be"),
)
_BARE = ((b"<\0?\0", "utf-16-le"), (b"\0<\0?", "utf-16-be"))
# A comment ends at its first end: were it left to a lazy ".*?", many comments took a time that doubles with each.
_DECLARED = re.compile(
    rb"""(?:\s|<!--(?:(?!-->).)*-->)*<\?xml\s[^>]*?encoding\s*=\s*["']([A-Za-z][A-Za-z0-9._-]{0,40})["']""", re.DOTALL
)

# Python has codecs that are no encoding of a text file; these would run an escape language over it.
_NO_ENCODING = {"unicode-escape", "raw-unicode-escape", "idna", "punycode", "utf-7", "undefined", "mbcs", "oem"}


def printable_name(path: Path) -> str:
    """Return the name of a file as it can stand in a description: without line ends, and bytes that are no text."""
    return masked(path.name)


def read_source(path: Path, asked: Span | None = None) -> Source:
    """Return the text of a file; ``asked`` is the place that names it. Raises MarkupError with a clear message."""
    return decode(bytes_of(path, asked), shown(path), asked)


def bytes_of(path: Path, asked: Span | None = None) -> bytes:
    """Return the bytes of a file. Raises MarkupError when it cannot be read, is empty or far too large."""
    name = shown(path)
    given = stdin_of(path)
    data = _of_file(path, name, asked) if given is None else given
    if len(data) > MAX_BYTES:
        raise MarkupError(error("file-too-large", f"{name} is larger than {MAX_BYTES:,} bytes", asked, _NO_FILE))
    if not data.strip():
        raise MarkupError(error("file-empty", f"{name} is empty", asked, "is this the right file?"))
    return data


def _of_file(path: Path, name: str, asked: Span | None) -> bytes:
    try:
        if files.is_folder(path):
            message = f"{name} is a folder, not a file"
            raise MarkupError(error("file-unreadable", message, asked, "name the file of the robot in it"))
        if files.is_special(path):
            raise MarkupError(error("file-unreadable", f"{name} is not a regular file", asked, _NO_FILE))
        if path.stat().st_size > MAX_BYTES:
            raise MarkupError(error("file-too-large", f"{name} is larger than {MAX_BYTES:,} bytes", asked, _NO_FILE))
        return files.read_bytes(path)
    except (OSError, ValueError) as problem:
        reason = getattr(problem, "strerror", None) or str(problem)
        raise MarkupError(error("file-unreadable", f"cannot read {name}: {reason}", asked, _NO_FILE)) from None


def decode(data: bytes, name: str, asked: Span | None = None) -> Source:
    """Return bytes as text, in the encoding of their mark or declaration, else UTF-8. Raises MarkupError."""
    encoding, skip = _encoding(data, name)
    if b"\0" in data.rstrip(b"\0 \r\n\t")[:1000] and not encoding.startswith(("utf-16", "utf-32")):
        message = f"{name} is not a text file: it holds zero bytes"
        raise MarkupError(error("not-text", message, asked, "name a URDF, xacro, SDF or MJCF file"))
    try:
        return Source(name, data[skip:].decode(encoding))
    except UnicodeDecodeError as problem:
        text = data[skip:].decode(encoding, "replace")
        start = len(data[skip : skip + problem.start].decode(encoding, "replace"))
        raise MarkupError(_undecodable(Source(name, text), encoding, data[skip + problem.start], start)) from None


def _undecodable(source: Source, encoding: str, byte: int, start: int) -> Diagnostic:
    message = f"{source.path} is not {encoding.upper()} text: byte {byte:#04x} at this place"
    help = 'save the file as UTF-8, or declare its encoding: <?xml version="1.0" encoding="ISO-8859-1"?>'
    return error("not-utf8", message, Document(source).span(start), help)


def _encoding(data: bytes, name: str) -> tuple[str, int]:
    """Return the encoding of a file, and how many bytes its mark takes."""
    for mark, encoding in _MARKS:
        if data.startswith(mark):
            return encoding, len(mark)
    for beginning, encoding in _BARE:
        if data.startswith(beginning):
            return encoding, 0
    match = _DECLARED.match(data)
    if match is None:
        return "utf-8", 0
    declared = match[1].decode("ascii")
    try:
        known = codecs.lookup(declared)
    except LookupError:
        known = None
    span = Span(Source(name, data[:1000].decode("ascii", "replace")), 1, match.start(1) + 1, len(declared))
    if known is None or known.name in _NO_ENCODING or not getattr(known, "_is_text_encoding", True):
        raise MarkupError(error("not-utf8", f'nobody knows the encoding "{declared}"', span, "save the file as UTF-8"))
    if known.name.startswith(("utf-16", "utf-32")):  # its very declaration could be read as ASCII
        message = f"{name} declares {declared}, but is not"
        raise MarkupError(error("not-utf8", message, span, "declare the encoding that it is saved in, such as UTF-8"))
    return known.name, 0


_COMMENT = re.compile("<!--(.*?)-->", re.DOTALL)
_TAG = re.compile(r"""<!--.*?-->|<!\[CDATA\[.*?\]\]>|(<[A-Za-z_](?:[^<>"']|"[^"]*"|'[^']*')*>)""", re.DOTALL)
_ATTRIBUTE = re.compile(r"""(=\s*(?:"[^"]*"|'[^']*'))(?=[A-Za-z_])""")
_MISC = re.compile(r"\s+|<!--.*?-->", re.DOTALL)
_DECLARATION = re.compile(r"<\?xml\s[^>]*\?>")


def without_late_declaration(source: Source) -> Source:
    """Return a source with a declaration ``<?xml ...?>`` behind space or comments blanked out, as tinyxml2 takes it."""
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
    """Return a source without what other readers pass over: ``--`` inside comments, zero bytes at the end.

    Also with a space between attributes that have none; all else keeps its place.
    """
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
