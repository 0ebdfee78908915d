"""Origins: the place in somebody's file of what stands in an expanded text, which nobody has.

``Origins`` is how the expanded document (``Document.origin``) finds a place; it knows elements and their attributes. A
value that xacro has calculated stands where its expression does.
"""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Mapping, Sequence

from rosorin_compile.source.diagnostics import MadeSpan, Related, Span
from rosorin_compile.source.xml.markup import Document, Element

Place = Sequence[int]


class Sources:
    """The files that xacro has read, by their number, and the calls of macros."""

    def __init__(self, files: Mapping[int, Document], calls: Sequence[Place]) -> None:
        self.files = files
        self.calls = calls
        self._elements: dict[int, dict[int, Element]] = {}

    def element(self, place: Place) -> Element | None:
        """Return the element that a place names; None if its file cannot be read any more."""
        file, start, _ = place
        if file not in self.files:
            return None
        if file not in self._elements:
            self._elements[file] = {element.start: element for element in self.files[file].root.iter()}
        return self._elements[file].get(start)

    def via(self, place: Place) -> tuple[Related, ...]:
        """Return the calls of macros that made an element, innermost first."""
        found: list[Related] = []
        call = place[2]
        while call >= 0 and len(found) < _MOST:
            element = self.element(self.calls[call])
            if element is not None:
                name = element.tag.removeprefix("xacro:")
                found.append(Related(f'when expanding the macro "{name}"', element.span))
            call = self.calls[call][2]
        return tuple(found)


_MOST = 12


class Origins:
    """Finds where a piece of an expanded document stood; called with an offset and a length."""

    def __init__(self, made: Document, places: Sequence[Place | None], sources: Sources, otherwise: Span) -> None:
        self._made = list(made.root.iter())
        self._starts = [element.start for element in self._made]
        self._places = places
        self._sources = sources
        self._otherwise = otherwise

    def __call__(self, start: int, length: int) -> Span:
        """Return the place; ``otherwise`` if it is not known."""
        index = max(0, bisect_right(self._starts, start) - 1)
        element = self._made[index]
        inside = start >= element.opened
        while start >= element.end and element.parent is not None:
            element = element.parent
            inside = True
        if inside:
            index = bisect_right(self._starts, element.start) - 1
        place = self._places[index] if index < len(self._places) else None
        origin = None if place is None else self._sources.element(place)
        if place is None or origin is None:
            return self._otherwise
        span = origin.span if inside else _within(element, origin, start, length)
        made = MadeSpan(*span)
        made.text = element.document.source.text[start : start + length]
        made.via = self._sources.via(place)
        return made


def _within(element: Element, origin: Element, start: int, length: int) -> Span:
    for name, attribute in element.attributes.items():
        written = origin.attributes.get(name)
        if written is None or not attribute.name_start <= start <= attribute.start + len(attribute.raw):
            continue
        if start < attribute.start:
            return written.name_span
        if written.raw == attribute.raw:
            return origin.document.span(written.start + start - attribute.start, length)
        return written.span
    return origin.span
