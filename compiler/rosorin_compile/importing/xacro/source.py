"""The elements of a xacro file: their comments, and what xacro makes of one."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

from rosorin_compile.source.tree import Map
from rosorin_compile.source.xml.markup import COMMENT, Element, Remark

from ..description import _Document
from .tree import Place, place_of


class Flat(NamedTuple):
    """An entry as xacro expands it: its section, its name (empty in a list), its value and its conditions."""

    section: str
    name: str
    value: Any


def flat_entries(trees: Sequence[Map], place: Place) -> list[Flat]:
    """Return what an element makes, from the first robot that has anything of it."""
    for tree in trees:
        document = _Document(tree)
        document.folders = {}
        found: list[Flat] = []
        for section in ("materials", "links", "joints"):
            entries: Any = tree.get(section)
            for name in entries or ():
                span = entries.value_spans[name]
                if made_by(span, place):
                    found.append(Flat(section, name, document.value(entries[name], (section, name), span)))
        elements = tree.get("urdf_elements")
        for text, span in zip(elements or (), elements.value_spans if elements else (), strict=True):
            if made_by(span, place):
                found.append(Flat("urdf_elements", "", str(text)))
        if found:
            return found
    return []


def made_by(span: Any, place: Place) -> bool:
    """Return True if an element made something, itself or by a macro that it calls."""
    spans = [span, *(one.span for one in getattr(span, "via", ()))]
    return any(one is not None and place_of(one) == place for one in spans)


def with_comments(element: Element) -> list[tuple[Element, tuple[str, ...]]]:
    """Return the elements in an element, each with the comments above it or behind it on its line."""
    found: list[tuple[Element, tuple[str, ...]]] = []
    waiting: list[str] = []
    text = element.document.source.text
    for index, item in enumerate(element.content):
        before = element.content[index - 1] if index else None
        is_comment = isinstance(item, Remark) and item.kind == COMMENT
        if is_comment and isinstance(before, Element) and "\n" not in text[before.end : item.start]:
            found[-1] = (found[-1][0], (*found[-1][1], item.text))
        elif isinstance(item, Element):
            found.append((item, tuple(waiting)))
            waiting = []
        elif is_comment:
            waiting.append(item.text)
    return found


def comments_within(element: Element) -> list[str]:
    """Return the comments in a link or a joint, except those of visuals and collisions, which have a place."""
    found: list[str] = []
    for one in element.iter():
        placed: set[str] = set()
        for child, comments in with_comments(one):
            placed.update(comments if one is element and child.tag in ("visual", "collision") else ())
        remarks = [item.text for item in one.content if isinstance(item, Remark) and item.kind == COMMENT]
        found += [text for text in remarks if text not in placed]
    return found
