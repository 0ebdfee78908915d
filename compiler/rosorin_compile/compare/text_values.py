"""Values of a text that no fact is about, such as an option of MuJoCo: which of them differ between two texts.

Each value of an XML or a JSON has a place in words: the element or key with the names around it. Of other texts, such
as tables for people, lines are compared.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING

from rosorin_compile.source.bounded import json_of
from rosorin_compile.source.wording import printable
from rosorin_compile.source.xml.elements import tree_of

if TYPE_CHECKING:
    from typing import Any
    from xml.etree.ElementTree import Element

_MOST = 3
_LARGEST = 200_000  # letters of a text whose values are looked at
_NAMES = ("name", "class", "link", "joint", "body", "site")
_CUT = 60
_WORD = re.compile(r"[A-Za-z_]\w+")
_READ = ("<", "{", "[")  # how an XML and a JSON begin


def differing(old: str, new: str) -> str:
    """Return the first values that differ, in words; empty if none does, or the texts cannot be compared so."""
    if max(len(old), len(new)) > _LARGEST:
        return ""
    try:
        before, after = _values(old), _values(new)
    except ValueError:
        return ""
    if old[:1] not in _READ and len(before) != len(after):
        return ""
    places = [place for place in {**before, **after} if before.get(place) != after.get(place)]
    said = [_change(place, before.get(place), after.get(place)) for place in places[:_MOST]]
    if len(places) > _MOST:
        said.append(f"and {len(places) - _MOST} more")
    return ", ".join(said)


def _change(place: str, old: str | None, new: str | None) -> str:
    if old is None or new is None:
        return f"{printable(place)}: {'new' if old is None else 'removed'}"
    if place.startswith("line "):
        place += f" {next(iter(_WORD.findall(new)), '')}".rstrip()
        old, new = _apart(old, new)
    return f"{printable(place)} {printable(old)[:_CUT]} -> {printable(new)[:_CUT]}"


def _apart(old: str, new: str) -> tuple[str, str]:
    """Return the words of two lines without those with which both begin and end."""
    before, after = old.split(), new.split()
    for at in (0, -1):
        while before and after and before[at] == after[at]:
            del before[at], after[at]
    return " ".join(before), " ".join(after)


def _values(text: str) -> Mapping[str, str]:
    """Return the values of a text by their places. Raises ValueError if it is damaged."""
    if text[:1] not in _READ:
        return {f"line {number}": line for number, line in enumerate(text.splitlines(), 1)}
    pairs = _of_root(tree_of(text)) if text.startswith("<") else _of_json(json_of(text), ())
    found: dict[str, str] = {}
    times: Counter[str] = Counter()
    for place, value in pairs:
        times[place] += 1
        found[place if times[place] == 1 else f"{place} ({times[place]})"] = value  # of elements that have no name
    return found


def _of_root(root: Element) -> Iterator[tuple[str, str]]:
    """Yield the attributes and texts of a document with their places: the last three elements that have names.

    The name of the robot stands around none of them. No depth of elements can exhaust the interpreter.
    """
    for key, value in root.items():
        yield f"{root.tag} {key}", value
    left: list[tuple[Element, tuple[str, ...]]] = [(inner, ()) for inner in reversed(root)]
    while left:
        element, around = left.pop()
        name = next((element.attrib[key] for key in _NAMES if key in element.attrib), "")
        here = (*around, f"{element.tag} {name}".rstrip())[-3:]
        for key, value in element.items():
            yield f"{' '.join(here)} {key}", value
        if element.text and element.text.strip():
            yield " ".join(here), element.text.strip()
        left += [(inner, here if name else around) for inner in reversed(element)]


def _of_json(value: Any, around: Sequence[str]) -> Iterator[tuple[str, str]]:
    if isinstance(value, dict):
        for key, inner in value.items():
            yield from _of_json(inner, (*around, key)[-3:])
    elif isinstance(value, list):
        for number, inner in enumerate(value, 1):
            yield from _of_json(inner, (*around[-2:], str(number)))
    else:
        yield " ".join(around), str(value)
