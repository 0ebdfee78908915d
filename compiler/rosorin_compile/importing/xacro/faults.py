"""Faults: what keeps a xacro from being expanded, each at its place in the file that somebody wrote.

Everything that is missing is told at once; what xacro itself says stands at the element that it was at.
"""

from __future__ import annotations

import os
import re
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from rosorin_compile.formats.imported import ReadOptions
from rosorin_compile.source.diagnostics import Diagnostic, Related, Span, did_you_mean, error
from rosorin_compile.source.installing import pip_install
from rosorin_compile.source.rule_registry import READING, Rule
from rosorin_compile.source.xml.files import read_source
from rosorin_compile.source.xml.markup import Document, Element, MarkupError, parse

from .origins import Place, Sources

RULES = (
    Rule("xacro-error", "xacro cannot expand the file.", "The message is that of xacro.", READING),
    Rule(
        "package-missing",
        "A ROS package is not found.",
        "`--package NAME=PATH`; in an include `packages: {NAME: FOLDER}`",
        READING,
    ),
    Rule(
        "extra-missing",
        "What reads the format is not installed.",
        "The command that the message has: it installs the extra of what this installation came from.",
        READING,
    ),
)

_ARGUMENT = re.compile(r"""<xacro:arg\s[^>]*?\bname\s*=\s*["']([^"']+)["']""")
_EXPRESSION = re.compile(r"when evaluating expression '(.*?)'(?: when|$)")
_COMMENT = re.compile("<!--.*?-->", re.DOTALL)
_UNDEFINED = "Undefined substitution argument"
_UNSET = "environment variable '"


def faults(
    answer: dict[str, Any],
    document: Document,
    path: Path,
    options: ReadOptions,
    files: tuple[Path, ...],
    sources: Sources,
) -> list[Diagnostic]:
    """Return what kept the file from being expanded, or an argument that it does not have."""
    if "absent" in answer:
        help = pip_install("import")
        return [error("extra-missing", "xacro, which expands .xacro files, is not installed", document.root.span, help)]
    asked = answer.get("missing", ())
    if "package" in answer and not asked:
        asked = [("package", answer["package"], answer.get("at"))]
    missing = [_missing(one, answer, document, path, sources) for one in asked]
    known = _known(answer, files)
    unknown = [name for name in options.arguments if name not in known]
    # Without a file, nobody knows what it declares; with all, xacro would say nothing, or that another has no value.
    if unknown and "markup" not in answer and not any(one.rule == "package-missing" for one in missing):
        message = f'{path.name} has no argument "{unknown[0]}"'
        help = did_you_mean(unknown[0], known) or "it has none"
        return [error("unknown-argument", message, document.root.span, help)]
    if "markup" in answer:
        return [*missing, _not_markup(answer, document, path, sources)]
    if "error" in answer and not (missing and _is_about_missing(answer["error"])):
        missing.append(_failure(answer, document, path, sources))
    return missing


def _is_about_missing(error: str) -> bool:
    return error.startswith(_UNDEFINED) or _UNSET in error


def _missing(
    missing: tuple[str, str, Place | None], answer: dict[str, Any], document: Document, path: Path, sources: Sources
) -> Diagnostic:
    kind, name, place = missing
    inner, related = _within(answer, document, path)
    words = {
        "package": [f"(find {name})", f"package://{name}/", name],
        "argument": [f"$(arg {name})", f"'{name}'", name],
        "variable": [f"$(env {name})", f"'{name}'", name],
    }[kind]
    element = None if place is None else sources.element(place)
    if place is not None and element is not None:
        span, related = _in_tag(element, words) or element.span, sources.via(place)
    else:
        span = _find(inner, words) or inner.span(0)
    if kind == "package":
        help = f"say where it is: --package {name}=PATH"
        return error("package-missing", f'the package "{name}" is not found', span, help, related)
    if kind == "argument":
        message, help = f'the argument "{name}" has no value', f"give it one: {name}:=VALUE"
    else:
        message = f'the environment variable "{name}" is not set'
        help = f"set it: export {name}=VALUE; or write $(optenv {name} VALUE), which has a default"
    return error("xacro-error", f"xacro cannot expand the file: {message}", span, help, related)


def _in_tag(element: Element, words: Sequence[str]) -> Span | None:
    tag = element.document.source.text[element.start : element.opened]
    for word in words:
        at = tag.find(word) if word else -1
        if at >= 0:
            return element.document.span(element.start + at, len(word))
    return None


def _known(answer: dict[str, Any], files: tuple[Path, ...]) -> list[str]:
    known = dict.fromkeys(answer.get("arguments", ()))
    for file in files:
        try:
            known |= dict.fromkeys(_ARGUMENT.findall(read_source(file).text))
        except MarkupError:
            continue
    return sorted(known)


def _source(name: str, document: Document, path: Path) -> Document:
    if os.path.abspath(name) != os.path.abspath(path):
        try:
            return Document(read_source(Path(os.path.normpath(name))))
        except MarkupError:
            pass
    return document


def _within(answer: dict[str, Any], document: Document, path: Path) -> tuple[Document, tuple[Related, ...]]:
    stack = [name for name in answer.get("stack", ()) if name] or [str(path)]
    macros = dict.fromkeys(reversed(answer.get("macros", ())))
    related = [Related(f'when expanding the macro "{name}"', None) for name in macros]
    inner = _source(stack[-1], document, path)
    for name in reversed(stack[:-1]):
        related.append(Related("included from", _source(name, document, path).span(0)))
    return inner, tuple(related[:12])


def _find(document: Document, words: list[str]) -> Span | None:
    text = _COMMENT.sub(lambda match: re.sub(r"\S", " ", match[0]), document.source.text)
    for word in words:
        if word and text.count(word) == 1:
            return document.span(text.index(word), len(word))
    return None


def _not_markup(answer: dict[str, Any], document: Document, path: Path, sources: Sources) -> Diagnostic:
    name = answer["markup"]
    inner, related = _within(answer, document, path)
    place: Place | None = answer.get("at")
    element = sources.element(place) if place else None
    at = _in_tag(element, [Path(name).name]) or element.span if element else None
    span = _find(inner, [Path(name).name]) or at or inner.span(0)
    try:
        parse(read_source(Path(os.path.normpath(name)), span))
    except MarkupError as problem:
        return replace(problem.diagnostic, related=(*problem.diagnostic.related, *related))
    return error("xml-syntax", answer["message"], span, "", related)


def _failure(answer: dict[str, Any], document: Document, path: Path, sources: Sources) -> Diagnostic:
    inner, related = _within(answer, document, path)
    what = _once(" ".join(re.sub(r"<class '[^']*'>:", "", answer["error"]).split()))
    words = [f"${{{match[1]}}}" for match in _EXPRESSION.finditer(what)]
    words += [match[1] for match in _EXPRESSION.finditer(what)]
    words += [f"<{name}" for name in re.findall(r"unknown macro name: (\S+)", what)]
    words += re.findall(r"'([^']+)'", what)
    place: Place | None = answer.get("at")
    element = sources.element(place) if place else None
    span = None
    if place is not None and element is not None:
        calls = sources.via(place)
        related = (*calls, *(one for one in related if not one.message.startswith("when expanding") or not calls))
        span = _in_tag(element, words)
    span = span or _find(inner, words)
    for name in answer.get("files", ()):  # properties are evaluated late, where they are used
        span = span or _find(_source(name, document, path), words[:1])
    if span is None and element is not None:
        span = element.span
    if span is None and answer.get("line"):
        span = Span(inner.source, answer["line"], 1)
    message, help = f"xacro cannot expand the file: {what}"[:600], answer.get("help", "")
    return error("xacro-error", message, span or inner.span(0), help, related)


def _once(text: str) -> str:
    half = len(text) // 2
    return text[:half] if len(text) % 2 and text[:half] == text[half + 1 :] else text
