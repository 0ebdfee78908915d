"""Lenient: texts that are no XML although it is plain what is meant, mended without moving a letter."""

from __future__ import annotations

import re

from ..diagnostic import Source

_COMMENT = re.compile("<!--(.*?)-->", re.DOTALL)
_MISC = re.compile(r"\s+|<!--.*?-->", re.DOTALL)
_DECLARATION = re.compile(r"<\?xml\s[^>]*\?>")


def without_late_declaration(source: Source) -> Source:
    """Return a source with a declaration ``<?xml ...?>`` behind space or comments blanked out, as tinyxml2 takes it."""
    at = 0
    # One piece at a time: as one pattern with a repetition, many comments take a time that doubles with each of them.
    while piece := _MISC.match(source.text, at):
        at = piece.end()
    found = _DECLARATION.match(source.text, at) if at else None
    if found is None:
        return source
    blank = re.sub(r"\S", " ", found[0])
    return Source(source.path, source.text[:at] + blank + source.text[found.end() :])


def mended(source: Source) -> Source:
    """Return a source with what other readers pass over blanked out: ``--`` inside comments, zero bytes at the end."""
    text = source.text
    bare = text.rstrip("\0 \r\n\t")
    text = bare + text[len(bare) :].replace("\0", " ")
    return Source(source.path, _COMMENT.sub(_without_dashes, text))


def _without_dashes(comment: re.Match[str]) -> str:
    inner = comment[1].replace("--", "- ")
    if inner.endswith("-"):
        inner = f"{inner[:-1]} "
    return f"<!--{inner.replace('--', '- ')}-->"
