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


class ExpandErrors:
    """The errors in the answer of the child process that expanded a file."""

    def __init__(self, answer: Mapping[str, Any], document: Document, path: Path, sources: Sources) -> None:
        self.answer, self.document, self.path, self.sources = answer, document, path, sources

    def diagnostics(self, arguments: Sequence[str], files: Sequence[Path]) -> list[Diagnostic]:
        """Return what kept the file from being expanded, or an argument that it does not have."""
        answer = self.answer
        if "absent" in answer:
            message = "xacro, which expands .xacro files, is not installed"
            return [error("extra-missing", message, self.document.root.span, pip_install("import"))]
        kind, name = answer.get("missing", ("", ""))
        known = self._arguments(files)
        unknown = [name for name in arguments if name not in known]
        # What a missing package declares is not known; if nothing is missing, xacro ignores an unknown argument.
        if unknown and "markup" not in answer and kind != "package":
            message = f'{self.path.name} has no argument "{unknown[0]}"'
            suggestion = Suggestion(unknown[0], known, none="it has none")
            return [error("unknown-argument", message, self.document.root.span, suggestion)]
        if "markup" in answer:
            return [self._not_markup()]
        if kind:
            return [self._missing(kind, name, answer.get("at"))]
        return [self._failure()] if "error" in answer else []

    def _arguments(self, files: Sequence[Path]) -> list[str]:
        known = dict.fromkeys(self.answer.get("arguments", ()))
        for file in files:
            try:
                known |= dict.fromkeys(_ARGUMENT.findall(read_source(file).text))
            except MarkupError:
                continue
        return sorted(known)

    def _missing(self, kind: str, name: str, place: Place | None) -> Diagnostic:
        """Return the error about a package, an argument or a variable of the environment that is missing."""
        inner, related = self._innermost_file()
        words = {
            "package": [f"(find {name})", f"package://{name}/", name],
            "argument": [f"$(arg {name})", f"'{name}'", name],
            "variable": [f"$(env {name})", f"'{name}'", name],
        }[kind]
        element = self.sources.element(place)
        if place is not None and element is not None:
            span, related = _in_tag(element, words) or element.span, self.sources.via(place)
        else:
            span = _find(inner, words) or inner.span(0)
        if kind == "package":
            help = f"say where it is: --package {name}=PATH"
            return error("package-missing", f'the package "{name}" is not found', span, help, related)
        message, help = f'the argument "{name}" has no value', f"give it one: {name}:=VALUE"
        if kind == "variable":
            message = f'the environment variable "{name}" is not set'
            help = f"set it: export {name}=VALUE; or write $(optenv {name} VALUE), which has a default"
        return error("xacro-error", f"xacro cannot expand the file: {message}", span, help, related)

    def _not_markup(self) -> Diagnostic:
        """Return the error about a file that is no XML."""
        path = Path(os.path.normpath(self.answer["markup"]))
        inner, related = self._innermost_file()
        element = self.sources.element(self.answer.get("at"))
        at = (_in_tag(element, [path.name]) or element.span) if element else inner.span(0)
        span = _find(inner, [path.name]) or at
        try:
            parse(read_source(path, span))
        except MarkupError as problem:
            return replace(problem.diagnostic, related=(*problem.diagnostic.related, *related))
        return error("xml-syntax", self.answer["message"], span, "", related)

    def _failure(self) -> Diagnostic:
        """Return the error that xacro reports, at the expression or the name that it is about."""
        answer = self.answer
        inner, related = self._innermost_file()
        text = " ".join(re.sub(r"<class '[^']*'>:", "", answer["error"]).split())
        half = len(text) // 2
        if len(text) % 2 and text[:half] == text[half + 1 :]:  # xacro repeats some errors
            text = text[:half]
        expressions = [match[1] for match in _EXPRESSION.finditer(text)]
        words = [*(f"${{{one}}}" for one in expressions), *expressions]
        words += [f"<{name}" for name in re.findall(r"unknown macro name: (\S+)", text)]
        words += re.findall(r"'([^']+)'", text)
        place: Place | None = answer.get("at")
        element, span = self.sources.element(place), None
        if place is not None and element is not None:
            calls = self.sources.via(place)
            related = (*calls, *(one for one in related if not calls or not one.message.startswith("when expanding")))
            span = _in_tag(element, words)
        span = span or _find(inner, words)
        for name in answer.get("files", ()):  # properties are evaluated late, where they are used
            span = span or _find(self._source(name), words[:1])
        if span is None and element is not None:
            span = element.span
        if span is None and answer.get("line"):
            span = Span(inner.source, answer["line"], 1)
        message, help = f"xacro cannot expand the file: {text}"[:600], answer.get("help", "")
        return error("xacro-error", message, span or inner.span(0), help, related)

    def _source(self, name: str) -> Document:
        if os.path.abspath(name) != os.path.abspath(self.path):
            try:
                return Document(read_source(Path(os.path.normpath(name))))
            except MarkupError:
                pass
        return self.document

    def _innermost_file(self) -> tuple[Document, tuple[Related, ...]]:
        """Return the file that xacro was reading, with the macros and files that it came from."""
        stack = [name for name in self.answer.get("stack", ()) if name] or [str(self.path)]
        macros = dict.fromkeys(reversed(self.answer.get("macros", ())))
        related = [Related(f'when expanding the macro "{name}"', None) for name in macros]
        related += [Related("included from", self._source(name).span(0)) for name in reversed(stack[:-1])]
        return self._source(stack[-1]), tuple(related[:_MOST_RELATED])


def _in_tag(element: Element, words: Sequence[str]) -> Span | None:
    """Return the place of the first word that the start tag of an element contains."""
    tag = element.document.source.text[element.start : element.opened]
    found = next((word for word in words if word and word in tag), None)
    return None if found is None else element.document.span(element.start + tag.find(found), len(found))


def _find(document: Document, words: Sequence[str]) -> Span | None:
    """Return the place of the first word that a file contains once, but for comments."""
    text = COMMENT.sub(lambda match: re.sub(r"\S", " ", match[0]), document.source.text)
    found = next((word for word in words if word and text.count(word) == 1), None)
    return None if found is None else document.span(text.index(found), len(found))
