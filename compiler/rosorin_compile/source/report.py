"""Write diagnostics as text for people, and as JSON objects."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from .wording import printable

if TYPE_CHECKING:
    from .diagnostics import Diagnostic, Related, Span

_COLOURS = {"error": "\033[31m", "warning": "\033[33m", "note": "\033[34m"}
_BOLD, _PLAIN = "\033[1m", "\033[0m"
MAX_SHOWN = 160  # letters of a line of a file


def text(diagnostics: Sequence[Diagnostic], colour: bool = False) -> str:
    """Return diagnostics for people: place, message, the line of the file, the help."""
    return "".join(_text(diagnostic.worded(), colour) for diagnostic in diagnostics)


def _text(diagnostic: Diagnostic, colour: bool) -> str:
    head = f"{diagnostic.severity}[{diagnostic.rule}]"
    message, help, span = printable(diagnostic.message), printable(diagnostic.help), diagnostic.span
    if colour:
        head, message = _COLOURS[diagnostic.severity] + head + _PLAIN, _BOLD + message + _PLAIN
    lines = [f"{_place(span)}{head}: {message}"]
    if span and diagnostic.severity != "note":
        # A row of carets under the place; a long line is shown around the place.
        line = span.source.line(span.line)
        first = max(0, span.column - 1 - MAX_SHOWN // 2) if len(line) > MAX_SHOWN else 0
        shown = printable(line[first : first + MAX_SHOWN].replace("\t", " "))
        column = min(span.column - 1 - first, len(shown))
        carets = "^" * max(1, min(span.length, len(shown) - column))
        lines += [f"{span.line:5} | {shown}".rstrip(), f"{'':5} | {' ' * column}{carets} {help}".rstrip()]
    elif help:
        lines.append(f"    {help}")
    return "\n".join([*lines, *(f"      {related_text(related)}" for related in diagnostic.related)]) + "\n"


def _place(span: Span | None) -> str:
    return f"{printable(span.source.path)}:{span.line}:{span.column}: " if span else ""


def related_text(related: Related) -> str:
    """Return a further place of a diagnostic in one line."""
    return f"{_place(related.span)}{printable(related.message)}"


def as_object(diagnostic: Diagnostic) -> dict[str, object]:
    """Return a diagnostic as a JSON object."""
    diagnostic = diagnostic.worded()

    def where(span: Span | None) -> dict[str, object]:
        return {"file": span.source.path, **dict(zip(span._fields[1:], span[1:], strict=True))} if span else {}

    head = {"rule": diagnostic.rule, "severity": diagnostic.severity, "message": diagnostic.message}
    related = [{"message": related.message, **where(related.span)} for related in diagnostic.related]
    return {**head, **where(diagnostic.span), "help": diagnostic.help, "related": related}
