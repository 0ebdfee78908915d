"""Differing elements: in what elements kept as XML differ between a translation and xacro, in one line each."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Sequence
from itertools import zip_longest
from typing import TYPE_CHECKING

from rosorin_compile.model import Robot
from rosorin_compile.source.xml.markup import Document

if TYPE_CHECKING:
    from xml.etree.ElementTree import Element

_LONG, _VALUE = 200, 50


def shortened(found: Sequence[str], source: Robot, again: Robot) -> list[str]:
    """Return what differs, as ``different`` says it, in words that fit a line; of elements what differs in them."""
    elements = list(_elements(source, again))
    if not elements:
        return [_cut(one, _LONG) for one in found]
    of_elements = [one for one in found if "urdf_elements" in one or "URDF elements" in one]
    numbers = {one: min(number, len(elements) - 1) for number, one in enumerate(of_elements)}
    return [_cut(elements[numbers[one]] if one in numbers else one, _LONG) for one in found]


def _elements(source: Robot, again: Robot) -> Iterator[str]:
    """Yield a sentence for each element that only one of two robots has."""
    yield from _several("", source.urdf_elements, again.urdf_elements)
    for section, word in (("links", "link"), ("joints", "joint")):
        others = {one.name: one for one in getattr(again, section)}
        for one in getattr(source, section):
            if one.name in others:
                yield from _several(f'{word} "{one.name}": ', one.urdf_elements, others[one.name].urdf_elements)


def _several(where: str, source: Sequence[str], again: Sequence[str]) -> Iterator[str]:
    mine, others = _only(source, again), _only(again, source)
    for element in mine:
        other = _partner(element, others)
        if other is None:
            yield f"{where}{called(element)}: only xacro has it"
            continue
        others.remove(other)
        yield f"{where}{called(element)}: {difference(element, other)}"
    for element in others:
        yield f"{where}{called(element)}: only the translation has it"


def _only(some: Sequence[str], others: Sequence[str]) -> list[Element]:
    """Return the elements that are not among others."""
    found = []
    for text in (Counter(some) - Counter(others)).elements():
        try:
            found.append(Document.tree(text))
        except ValueError:
            continue
    return found


def _key(element: Element) -> tuple[str, str]:
    return element.tag, element.get("name") or element.get("reference") or ""


def _partner(element: Element, others: Sequence[Element]) -> Element | None:
    """Return the element that is meant to be the same: of the same name, the first that has most in common."""
    same = [other for other in others if _key(other) == _key(element)]
    mine = _pieces(element)
    return max(same, key=lambda other: sum((mine & _pieces(other)).values()), default=None)


def _pieces(element: Element) -> Counter[str]:
    return Counter(f"{one.tag} {one.get('name') or ''} {(one.text or '').strip()}" for one in element.iter())


def difference(one: Element, other: Element) -> str:
    """Return where two elements of the same name differ first, and in what.

    >>> difference(Document.tree("<a><b name='c'>True</b></a>"), Document.tree("<a><b name='c'>true</b></a>"))
    'b "c": xacro has True, the translation true'
    """
    path: list[str] = []
    while True:
        for name in sorted({*one.attrib, *other.attrib}):
            if one.get(name) != other.get(name):
                return _said([*path, f"@{name}"], one.get(name), other.get(name))
        if (one.text or "").split() != (other.text or "").split():
            return _said(path, one.text, other.text)
        pairs = [
            (a, b)
            for a, b in zip_longest(one, other)
            if a is None or b is None or Document.canonical(a) != Document.canonical(b)
        ]
        if not pairs:
            return "it is spelt otherwise"
        first, second = pairs[0]
        if first is None or second is None or _key(first) != _key(second):
            return _said(path, _tag(first), _tag(second))
        path.append(f'{first.tag} "{_key(first)[1]}"' if _key(first)[1] else first.tag)
        one, other = first, second


def called(element: Element) -> str:
    """Return what an element is called in a sentence."""
    tag, name = _key(element)
    return f'<{tag} {"name" if element.get("name") else "reference"}="{name}">' if name else f"<{tag}>"


def _tag(element: Element | None) -> str | None:
    return None if element is None else called(element)


def _said(path: Sequence[str], one: str | None, other: str | None) -> str:
    mine, ours = (_value(value) for value in (one, other))
    return f"{'/'.join(path)}{': ' if path else ''}xacro has {mine}, the translation {ours}"


def _value(text: str | None) -> str:
    words = " ".join((text or "").split())
    return _cut(words, _VALUE) if words else "nothing"


def _cut(text: str, length: int) -> str:
    return text if len(text) <= length else f"{text[: length - 3].rstrip()}..."


__all__ = ["called", "difference", "shortened"]
