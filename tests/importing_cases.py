"""Cases of foreign files: what they say of themselves in the comment at their top, and what reading them tells."""

from __future__ import annotations

import re
from pathlib import Path

from rosorin_compile.diagnostic import Diagnostic, Span, arrange
from rosorin_compile.importing import Imported, ReadOptions, read_robot

_HEADER = re.compile(r"<!--\n(.*?)-->\n", re.DOTALL)


def header(path: Path) -> list[str]:
    """Return the lines of the comment at the top of a case."""
    found = _HEADER.match(path.read_text("utf-8"))
    assert found, f"{path.name} does not begin with a comment"
    return found[1].splitlines()


def read(path: Path) -> Imported:
    """Return what reading a case gives, with the options that it asks for."""
    words = [word for line in header(path) if line.startswith("options: ") for word in line.split()[1:]]
    arguments = dict(word.split(":=", 1) for word in words if ":=" in word)
    return read_robot(path, ReadOptions(arguments=arguments, lenient="lenient" in words, environment={}))


def told(diagnostics: list[Diagnostic], main: str) -> list[str]:
    """Return diagnostics as the lines of a case. Two dashes, which no comment may hold, stand as =="""
    lines = []
    for found in arrange(diagnostics):
        lines.append(f"expect: {place(found.span, main)}{found.severity}[{found.rule}]: {found.message}")
        if found.help:
            lines.append(f"  help: {found.help}")
        lines += [f"  related: {place(other.span, main)}{other.message}" for other in found.related]
    return [printable(line) for line in lines]


def place(span: Span | None, main: str) -> str:
    if span is None:
        return ""
    file = "" if span.source.path == main else f"{span.source.path.removeprefix(main).strip()}:"
    return f"{file}{span.line}:{span.column}: "


def printable(text: str) -> str:
    return text.replace("--", "==").replace("\0", "\\0")
