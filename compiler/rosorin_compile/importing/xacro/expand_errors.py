"""Where the elements of an expanded xacro are from, and diagnostics about a xacro that cannot be expanded."""

from __future__ import annotations

import os
import re
from bisect import bisect_right
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from rosorin_compile.source.diagnostics import Diagnostic, MadeSpan, Related, Span, Suggestion, error
from rosorin_compile.source.system import pip_install
from rosorin_compile.source.xml.markup import Document, Element, MarkupError, parse, read_source

Place = Sequence[int]  # the number of a file, the offset of an element, the number of the call of a macro or -1
COMMENT = re.compile("<!--.*?-->", re.DOTALL)
_ARGUMENT = re.compile(r"""<xacro:arg\s[^>]*?\bname\s*=\s*["']([^"']+)["']""")
_EXPRESSION = re.compile(r"when evaluating expression '(.*?)'(?: when|$)")
_MOST_RELATED = 12


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
        while call >= 0 and len(found) < _MOST_RELATED:
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


def expand_errors(
    answer: Mapping[str, Any],
    document: Document,
    path: Path,
    sources: Sources,
    arguments: Sequence[str],
    files: Sequence[Path],
) -> list[Diagnostic]:
    """Return what kept a file from being expanded, or an argument that it does not have."""
    if "absent" in answer:
        message = "xacro, which expands .xacro files, is not installed"
        return [error("extra-missing", message, document.root.span, pip_install("import"))]
    kind, name = answer.get("missing", ("", ""))
    known = _declared(answer, files)
    unknown = [one for one in arguments if one not in known]
    # What a missing package declares is not known; if nothing is missing, xacro ignores an unknown argument.
    if unknown and "markup" not in answer and kind != "package":
        message = f'{path.name} has no argument "{unknown[0]}"'
        suggestion = Suggestion(unknown[0], known, none="it has none")
        return [error("unknown-argument", message, document.root.span, suggestion)]
    if "markup" in answer:
        return [_not_markup(answer, document, path, sources)]
    if kind:
        return [_missing(kind, name, answer, document, path, sources)]
    return [_failure(answer, document, path, sources)] if "error" in answer else []


def _declared(answer: Mapping[str, Any], files: Sequence[Path]) -> list[str]:
    known = dict.fromkeys(answer.get("arguments", ()))
    for file in files:
        try:
            known |= dict.fromkeys(_ARGUMENT.findall(read_source(file).text))
        except MarkupError:
            continue
    return sorted(known)


def _missing(
    kind: str, name: str, answer: Mapping[str, Any], document: Document, path: Path, sources: Sources
) -> Diagnostic:
    """Return the error about a package, an argument or a variable of the environment that is missing."""
    words = {
        "package": [f"(find {name})", f"package://{name}/", name],
        "argument": [f"$(arg {name})", f"'{name}'", name],
        "variable": [f"$(env {name})", f"'{name}'", name],
    }[kind]
    span, related = _place(words, answer, document, path, sources)
    if kind == "package":
        help = f"say where it is: --package {name}=PATH"
        return error("package-missing", f'the package "{name}" is not found', span, help, related)
    message, help = f'the argument "{name}" has no value', f"give it one: {name}:=VALUE"
    if kind == "variable":
        message = f'the environment variable "{name}" is not set'
        help = f"set it: export {name}=VALUE; or write $(optenv {name} VALUE), which has a default"
    return error("xacro-error", f"xacro cannot expand the file: {message}", span, help, related)


def _not_markup(answer: Mapping[str, Any], document: Document, path: Path, sources: Sources) -> Diagnostic:
    """Return the error about a file that is no XML."""
    broken = Path(os.path.normpath(answer["markup"]))
    span, related = _place([broken.name], answer, document, path, sources)
    try:
        parse(read_source(broken, span))
    except MarkupError as problem:
        return replace(problem.diagnostic, related=(*problem.diagnostic.related, *related))
    return error("xml-syntax", answer["message"], span, "", related)


def _failure(answer: Mapping[str, Any], document: Document, path: Path, sources: Sources) -> Diagnostic:
    """Return the error that xacro reports, at the expression or the name that it is about."""
    text = " ".join(re.sub(r"<class '[^']*'>:", "", answer["error"]).split())
    half = len(text) // 2
    if len(text) % 2 and text[:half] == text[half + 1 :]:  # xacro repeats some errors
        text = text[:half]
    expressions = [match[1] for match in _EXPRESSION.finditer(text)]
    words = [*(f"${{{one}}}" for one in expressions), *expressions]
    words += [f"<{name}" for name in re.findall(r"unknown macro name: (\S+)", text)]
    words += re.findall(r"'([^']+)'", text)
    span, related = _place(words, answer, document, path, sources)
    message = f"xacro cannot expand the file: {text}"[:600]
    return error("xacro-error", message, span, answer.get("help", ""), related)


def _place(
    words: Sequence[str], answer: Mapping[str, Any], document: Document, path: Path, sources: Sources
) -> tuple[Span, tuple[Related, ...]]:
    """Return the first word in the element that xacro was at, or in the files that it read, and how it came there."""
    stack = [_source(name, document, path) for name in answer.get("stack") or [str(path)]]
    included = tuple(Related("included from", one.span(0)) for one in reversed(stack[:-1]))[:_MOST_RELATED]
    place = answer.get("at")
    element = sources.element(place)
    if place is not None and element is not None:
        tag = element.document.source.text[element.start : element.opened]
        found = next((word for word in words if word and word in tag), None)
        related = (*sources.via(place), *included)
        if found is not None:
            return element.document.span(element.start + tag.find(found), len(found)), related
        included = related
    files = [stack[-1], *(_source(name, document, path) for name in answer.get("files", ()))]
    for file in files:  # properties are evaluated late, where they are used
        text = COMMENT.sub(lambda match: re.sub(r"\S", " ", match[0]), file.source.text)
        found = next((word for word in words[:1] if word and text.count(word) == 1), None)
        if found is not None:
            return file.span(text.index(found), len(found)), included
    return element.span if element is not None else stack[-1].span(0), included


def _source(name: str, document: Document, path: Path) -> Document:
    if os.path.abspath(name) != os.path.abspath(path):
        try:
            return Document(read_source(Path(os.path.normpath(name))))
        except MarkupError:
            pass
    return document
