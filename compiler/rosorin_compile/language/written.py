"""The files of a description as they are written, before expressions are evaluated, by position.

A later stage has the position of a value; this finds its text there, and the entry that it is in.
"""

from __future__ import annotations

from itertools import islice
from typing import Any, NamedTuple

from rosorin_compile.source.diagnostics import Source, Span
from rosorin_compile.source.load import LoadError, parse_yaml
from rosorin_compile.source.tree import Map, Path, Seq

MAX_TEXT = 80

_Places = dict[tuple[int, int], "Piece"]


class Piece(NamedTuple):
    """A value of a file: its path from the top, the value as read, and the positions of the value and of its key."""

    path: Path
    value: Any
    span: Span
    key: Span | None


class Written:
    """The files that positions are in; each is read once."""

    def __init__(self) -> None:
        self._files: dict[str, tuple[_Places, _Places]] = {}

    def value(self, span: Span) -> Piece | None:
        """Return the innermost value that begins at a position."""
        return self._read(span.source)[0].get((span.line, span.column))

    def entry(self, span: Span) -> Piece | None:
        """Return the value whose key is at a position."""
        return self._read(span.source)[1].get((span.line, span.column))

    def text(self, span: Span) -> str:
        """Return the value written at a position, or behind the key there, on one line and shortened."""
        if _is_markup(span.source):
            text = span.source.line(span.line)[span.column - 1 :][: span.length]
        else:
            piece = self.entry(span) or self.value(span)
            text = "" if piece is None else _text(piece.value, piece.span)
        return text if len(text) <= MAX_TEXT else f"{text[: MAX_TEXT - 3]}..."

    def _read(self, source: Source) -> tuple[_Places, _Places]:
        if source.path not in self._files:
            values, keys = self._files.setdefault(source.path, ({}, {}))
            try:
                waiting: list[tuple[Path, Any]] = [((), None if _is_markup(source) else parse_yaml(source))]
            except LoadError:  # artifacts of another tool; descriptions with errors are not explained
                waiting = []
            while waiting:
                path, value = waiting.pop()
                items = value.items() if isinstance(value, Map) else enumerate(value) if isinstance(value, Seq) else ()
                for key, item in items:
                    span, named = value.value_spans[key], value.key_spans[key] if isinstance(value, Map) else None
                    piece = values[span.line, span.column] = Piece((*path, key), item, span, named)
                    if named is not None:
                        keys[named.line, named.column] = piece
                    waiting.append((piece.path, item))
        return self._files[source.path]


def _is_markup(source: Source) -> bool:
    return source.text[:200].lstrip("\ufeff \t\r\n").startswith("<")


def _text(value: Any, span: Span) -> str:
    line = span.source.line(span.line)[span.column - 1 :]
    if isinstance(value, Map):
        keys = list(islice(value, MAX_TEXT))
        if line.startswith("{"):
            keys = [f"{key}: {_text(value[key], value.value_spans[key])}" for key in keys]
        return f"{{{', '.join(keys)}}}"
    if isinstance(value, Seq):
        if not line.startswith("["):
            return f"[{len(value)} items]"
        return f"[{', '.join(_text(*item) for item in islice(zip(value, value.value_spans, strict=True), MAX_TEXT))}]"
    if value is None:
        return ""
    one_line = not isinstance(value, str) or span.length >= len(value)
    return line[: span.length] if one_line else " ".join(value.split())
