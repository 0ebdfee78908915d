"""Entries of the plain tree made of what MuJoCo says, each with its place in the text of the MJCF."""

from __future__ import annotations

import re
from collections.abc import Sequence
from typing import Any

from ...diagnostic import Span
from ...model import Transform
from ...model.geometry import IDENTITY
from ...tree import Map, Seq
from ..markup import Element
from .numbers import rpy_of, tidy_vector
from .source import says, spans_of

_ILLEGAL = re.compile(r"[<>&\"'\s\x00-\x1f\x7f]+")


def numbers(values: Sequence[float], element: Element, attribute: str = "") -> Seq:
    """Return a list of numbers; their places are the digits of the attribute where it says these very values."""
    made = Seq(element.span)
    said = element.attributes.get(attribute)
    for value, span in zip(values, spans_of(said, values, element.span), strict=True):
        made.put(plain(value), span)
    return made


def plain(value: float) -> float | int:
    """Return a whole number as an int, as the description would say it."""
    return int(value) if value == int(value) and abs(value) < 1e15 else value


def put(entry: Map, key: str, value: Any, span: Span | None = None) -> None:
    """Set a key of an entry; the place is that of the entry, unless one is given."""
    place = span or getattr(value, "span", None) or entry.span
    entry.put(key, value, place, place)


def put_number(entry: Map, key: str, value: float, element: Element, attribute: str = "", at: int = 0) -> None:
    """Set a number; its place is the word ``at`` of the attribute where that says this very value."""
    said = element.attributes.get(attribute)
    word = said.words()[at : at + 1] if said else []
    span = word[0].span if word and says(word[0].text, value) else element.span
    entry.put(key, plain(value), element.span, span)


def put_pose(entry: Map, place: Transform, element: Element) -> None:
    """Set xyz and rpy of an entry, where they are not zero."""
    xyz = tidy_vector(place.xyz)
    rpy = rpy_of(place.rows)
    if xyz != IDENTITY.xyz:
        put(entry, "xyz", numbers(xyz, element, "pos"))
    if rpy != IDENTITY.rpy:
        put(entry, "rpy", numbers(rpy, element))


def source(entry: Map, status: str, note: str) -> None:
    """Say where the values of an entry come from."""
    said = Map(entry.span)
    put(said, "status", status)
    put(said, "note", note)
    put(entry, "source", said)


def legal(name: str) -> str:
    """Return a name without what names of the description never have: markup, quotes, outer or other white space."""
    return " ".join(_ILLEGAL.sub("_", word) for word in name.split(" ") if word)


class Names:
    """Names that are given once: those of the file, and plain ones for what has none."""

    def __init__(self) -> None:
        self.taken: set[str] = set()

    def give(self, name: str) -> str:
        """Return the name, or with a number behind it if it is taken."""
        word = legal(name) or "unnamed"
        made, count = word, 1
        while made in self.taken:
            count += 1
            made = f"{word}_{count}"
        self.taken.add(made)
        return made
