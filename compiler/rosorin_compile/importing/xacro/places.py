"""Find where the elements of an expanded xacro are in the files that it was made of."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Mapping, Sequence

from rosorin_compile.source.diagnostics import MadeSpan, Related, Span
from rosorin_compile.source.xml.markup import Document, Element

Place = Sequence[int]  # the number of a file, the offset of an element, the number of the call of a macro or -1
_MOST_CALLS = 12


class Sources:
    """The files that xacro has read, by their number, and the calls of macros."""

    def __init__(self, files: Mapping[int, Document], calls: Sequence[Place]) -> None:
        self.files = files
        self.calls = calls
        self._elements: dict[int, dict[int, Element]] = {}

    def element(self, place: Place | None) -> Element | None:
        """Return the element at a place, or None if its file cannot be read any more."""
        if place is None or place[0] not in self.files:
            return None
        file, start, _ = place
        if file not in self._elements:
            self._elements[file] = {element.start: element for element in self.files[file].root.iter()}
        return self._elements[file].get(start)

    def via(self, place: Place) -> tuple[Related, ...]:
        """Return the calls of macros that made an element, innermost first."""
        found: list[Related] = []
        call = place[2]
        while call >= 0 and len(found) < _MOST_CALLS:
            element = self.element(self.calls[call])
            if element is not None:
                name = element.tag.removeprefix("xacro:")
                found.append(Related(f'when expanding the macro "{name}"', element.span))
            call = self.calls[call][2]
        return tuple(found)


class Origins:
    """Finds where a piece of an expanded document is from; called with an offset and a length."""

    def __init__(self, made: Document, places: Sequence[Place | None], sources: Sources, otherwise: Span) -> None:
        self._made = list(made.root.iter())
        self._starts = [element.start for element in self._made]
        self._places = places
        self._sources = sources
        self._otherwise = otherwise

    def __call__(self, start: int, length: int) -> Span:
        """Return the place, or ``otherwise`` if it is not known."""
        index = max(0, bisect_right(self._starts, start) - 1)
        element = self._made[index]
        inside = start >= element.opened
        while start >= element.end and element.parent is not None:
            element = element.parent
            inside = True
        if inside:
            index = bisect_right(self._starts, element.start) - 1
        place = self._places[index] if index < len(self._places) else None
        origin = self._sources.element(place)
        if place is None or origin is None:
            return self._otherwise
        made = MadeSpan(*(origin.span if inside else _span_in_tag(element, origin, start, length)))
        made.text = element.document.source.text[start : start + length]
        made.via = self._sources.via(place)
        return made


def _span_in_tag(element: Element, origin: Element, start: int, length: int) -> Span:
    """Return the place in the start tag of the element that another was made of."""
    for name, attribute in element.attributes.items():
        source = origin.attributes.get(name)
        if source is None or not attribute.name_start <= start <= attribute.start + len(attribute.raw):
            continue
        if start < attribute.start:
            return source.name_span
        if source.raw == attribute.raw:
            return origin.document.span(source.start + start - attribute.start, length)
        return source.span
    return origin.span
