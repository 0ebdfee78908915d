"""Flattened: what a call or an element at the top of a file makes, taken as xacro has expanded it.

For what cannot be said here: it is laid out as the flat import would write it, and the rest keeps its structure.
"""

from __future__ import annotations

import os
from collections.abc import Sequence
from typing import Any, NamedTuple

from rosorin_compile.source.diagnostics import Span
from rosorin_compile.source.tree import Map

from ..description import _Document
from .pieces import Whens

Place = tuple[str, int, int]


class Flat(NamedTuple):
    """An entry of the flat robot: its section, its name (empty in a list), and its value as it is laid out."""

    section: str
    name: str
    value: Any
    when: Whens
    comments: tuple[str, ...]


def place_of(span: Span) -> Place:
    """Return where something stands, to be compared."""
    return os.path.abspath(span.source.path), span.line, span.column


def outermost(span: Span) -> Place:
    """Return the element at the top of a file that made something."""
    via = getattr(span, "via", ())
    return place_of(via[-1].span if via else span)


def flat_entries(trees: Sequence[Map], place: Place, when: Whens, comments: tuple[str, ...]) -> list[Flat]:
    """Return what an element at the top of a file makes, from the first robot that has anything of it."""
    for tree in trees:
        document = _Document(tree)
        document.folders = {}
        found: list[Flat] = []
        for section in ("materials", "links", "joints"):
            entries: Any = tree.get(section)
            for name in entries or ():
                span = entries.value_spans[name]
                if _made_by(span, place):
                    value = document.value(entries[name], (section, name), span)
                    found.append(Flat(section, name, value, when, comments if not found else ()))
        elements = tree.get("urdf_elements")
        for text, span in zip(elements or (), elements.value_spans if elements else (), strict=True):
            if _made_by(span, place):
                found.append(Flat("urdf_elements", "", str(text), when, ()))
        if found:
            return found
    return []


def _made_by(span: Span, place: Place) -> bool:
    spans = [span, *(one.span for one in getattr(span, "via", ()))]
    return any(one is not None and place_of(one) == place for one in spans)
