"""Cases that are files: what they say of themselves in comments, and diagnostics in the form of these comments."""

from __future__ import annotations

import re
from pathlib import Path

from rosorin_compile.diagnostics import Diagnostic, Span, arrange
from rosorin_compile.formats.imported import Imported, ReadOptions
from rosorin_compile.formats.reading import read_robot

_HEADER = re.compile(r"<!--\n(.*?)-->\n", re.DOTALL)


def header(path: Path) -> list[str]:
    """Return the lines of the comment at the top of a foreign file."""
    found = _HEADER.match(path.read_text("utf-8"))
    assert found, f"{path.name} does not begin with a comment"
    return found[1].splitlines()


def read(path: Path) -> Imported:
    """Return what reading a foreign file gives, with the options that it asks for."""
    words = [word for line in header(path) if line.startswith("options: ") for word in line.split()[1:]]
    arguments = dict(word.split(":=", 1) for word in words if ":=" in word)
    return read_robot(path, ReadOptions(arguments=arguments, lenient="lenient" in words, environment={}))


def told(diagnostics: list[Diagnostic], main: str) -> list[str]:
    """Return diagnostics as the comments of a description whose first file is ``main``; all letters are visible."""
    return [f"# {_visible(line)}" for line in _lines(diagnostics, main)]


def told_in_xml(diagnostics: list[Diagnostic], main: str) -> list[str]:
    """Return diagnostics, in order, as the lines of an XML comment, which holds no two dashes: they stand as =="""
    return [line.replace("--", "==").replace("\0", "\\0") for line in _lines(arrange(diagnostics), main)]


def _lines(diagnostics: list[Diagnostic], main: str) -> list[str]:
    lines = []
    for diagnostic in diagnostics:
        where = _place(diagnostic.span, main)
        lines.append(f"expect: {where}{diagnostic.severity}[{diagnostic.rule}]: {diagnostic.message}")
        lines += [f"  help: {diagnostic.help}"] if diagnostic.help else []
        lines += [f"  related: {_place(other.span, main)}{other.message}" for other in diagnostic.related]
    return lines


def _place(span: Span | None, main: str) -> str:
    if span is None:
        return ""
    file = "" if span.source.path == main else f"{span.source.path.removeprefix(main).strip()}:"
    return f"{file}{span.line}:{span.column}: "


def _visible(text: str) -> str:
    return "".join(letter if letter.isprintable() else f"\\x{ord(letter):02x}" for letter in text)
