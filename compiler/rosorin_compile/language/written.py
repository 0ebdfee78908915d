"""Written: what stands in the files of a description, found by its place, before anything is evaluated.

A later stage knows of a value where it was written; this tells what was written there, and in which entry.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, NamedTuple

from rosorin_compile.source.diagnostics import Source, Span
from rosorin_compile.source.load import LoadError, parse_yaml
from rosorin_compile.source.tree import Map, Path, Seq

MAX_TEXT = 80

_CLOSING = {"{": "}", "[": "]"}


class Piece(NamedTuple):
    """A value of a file: the keys that lead to it from the top, the value as read, where it and its key stand."""

    path: Path
    value: Any
    span: Span
    key: Span | None


class Written:
    """Knows the files that it was asked about; each is read once."""

    def __init__(self) -> None:
        self._files: dict[str, tuple[dict[tuple[int, int], Piece], dict[tuple[int, int], Piece]]] = {}

    def value(self, span: Span) -> Piece | None:
        """Return the innermost value that begins at a place; None if none does."""
        return self._read(span.source)[0].get((span.line, span.column))

    def entry(self, span: Span) -> Piece | None:
        """Return the value whose key stands at a place; None if no key does."""
        return self._read(span.source)[1].get((span.line, span.column))

    def text(self, span: Span) -> str:
        """Return what is written at a place, on one line and shortened; the text of a key is that of its value."""
        if _is_markup(span.source):
            return _shortened(span.source.line(span.line)[span.column - 1 :][: span.length])
        piece = self.entry(span) or self.value(span)
        return "" if piece is None else _shortened(_text(piece))

    def _read(self, source: Source) -> tuple[dict[tuple[int, int], Piece], dict[tuple[int, int], Piece]]:
        known = self._files.get(source.path)
        if known is None:
            values: dict[tuple[int, int], Piece] = {}
            keys: dict[tuple[int, int], Piece] = {}
            try:
                tree = None if _is_markup(source) else parse_yaml(source)
            except LoadError:  # a description that compiles has none; the artifacts of another tool may
                tree = None
            for piece in _pieces(tree):
                values[piece.span.line, piece.span.column] = piece
                if piece.key is not None:
                    keys[piece.key.line, piece.key.column] = piece
            known = self._files[source.path] = (values, keys)
        return known


def _is_markup(source: Source) -> bool:
    return source.text[:200].lstrip("\ufeff \t\r\n").startswith("<")


def _pieces(tree: Any) -> Iterator[Piece]:
    waiting: list[tuple[Path, Any]] = [((), tree)]
    while waiting:
        path, value = waiting.pop()
        if isinstance(value, Map):
            for key, item in value.items():
                yield Piece((*path, key), item, value.value_spans[key], value.key_spans[key])
                waiting.append(((*path, key), item))
        elif isinstance(value, Seq):
            for index, (item, span) in enumerate(zip(value, value.value_spans, strict=True)):
                yield Piece((*path, index), item, span, None)
                waiting.append(((*path, index), item))


def _text(piece: Piece) -> str:
    value, span = piece.value, piece.span
    line = span.source.line(span.line)[span.column - 1 :]
    if isinstance(value, (Map, Seq)):
        if line[:1] in _CLOSING:
            return _bracketed(span)
        return f"{{{', '.join(value)}}}" if isinstance(value, Map) else f"[{len(value)} items]"
    if value is None:
        return ""
    one_line = not isinstance(value, str) or span.length >= len(value)
    return line[: span.length] if one_line else " ".join(value.split())


def _bracketed(span: Span) -> str:
    """Return a list or mapping in brackets on one line, without its comments."""
    lines = span.source.text.splitlines()[span.line - 1 :]
    letters: list[str] = []
    depth, quote = 0, ""
    for number, line in enumerate(lines):
        begin = span.column - 1 if number == 0 else 0
        for index in range(begin, len(line)):
            letter = line[index]
            if quote:
                quote = "" if letter == quote else quote
            elif letter in "'\"":
                quote = letter
            elif letter == "#" and line[index - 1 : index].isspace():
                break
            depth += (not quote) * ((letter in "{[") - (letter in "}]"))
            letters.append(letter)
            if depth == 0:
                return " ".join("".join(letters).split())
            if len(letters) > 4 * MAX_TEXT:
                return " ".join("".join(letters).split())
        letters.append(" ")
    return " ".join("".join(letters).split())


def _shortened(text: str) -> str:
    return text if len(text) <= MAX_TEXT else f"{text[: MAX_TEXT - 3]}..."
