"""Entries of a plain tree as YAML, each number with the digits that its source has."""

from __future__ import annotations

from typing import Any

from ..diagnostic import Span
from ..importing.writing.numbers import number
from ..tree import Map, Seq
from . import writing


def block(entry: Map, indent: str) -> list[str]:
    """Return the lines of a mapping, a key a line, what a key holds on that line."""
    return [f"{indent}{writing.name(key)}: {inline(value, entry.value_spans[key])}" for key, value in entry.items()]


def inline(value: Any, span: Span) -> str:
    """Return a value of a tree on one line."""
    if isinstance(value, Map):
        pairs = (f"{writing.name(key)}: {inline(item, value.value_spans[key])}" for key, item in value.items())
        return f"{{{', '.join(pairs)}}}"
    if isinstance(value, Seq):
        return f"[{', '.join(inline(item, place) for item, place in zip(value, value.value_spans, strict=True))}]"
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, int | float):
        return number(value, span)
    return writing.name(str(value))
