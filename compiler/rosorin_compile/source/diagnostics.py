"""Diagnostics: errors, warnings and notes about a description, with the place in a file.

A stage neither prints nor raises for a problem in the user's files: it returns diagnostics. ``messages`` merges and
words them after the last stage.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Mapping
from dataclasses import dataclass, field, replace
from functools import lru_cache
from typing import Any, NamedTuple

from . import report
from .wording import MAX_LISTED as MAX_LISTED
from .wording import and_more as and_more
from .wording import counted as counted
from .wording import did_you_mean as did_you_mean
from .wording import first_of as first_of
from .wording import listed as listed
from .wording import masked as masked
from .wording import nearest as nearest
from .wording import printable as printable
from .wording import quoted as quoted
from .wording import split_lines
from .wording import swaps as swaps

ERROR, WARNING, NOTE = "error", "warning", "note"

# The ``numbers`` of a warning before trusted code is run: it is counted, and not shown.
TRUSTED = (("trusted", True),)


class Source(NamedTuple):
    """A file that was read: its path as shown to the user, and its text."""

    path: str
    text: str

    def __repr__(self) -> str:
        return f"Source({self.path!r}, ...)"

    def line(self, number: int) -> str:
        """Return line ``number`` (1-based) without its line end; empty beyond the end of the file."""
        lines = _lines(self.text)
        return lines[number - 1] if 0 < number <= len(lines) else ""

    def span(self, offset: int = 0, length: int = 1) -> Span:
        """Return the place of the characters from an offset on."""
        lines = split_lines(self.text[:offset])
        return Span(self, len(lines), len(lines[-1]) + 1, max(1, length))


_lines = lru_cache(maxsize=16)(split_lines)


class Span(NamedTuple):
    """A place in a source: line and column count from 1, in characters; ``length`` is at least 1."""

    source: Source
    line: int
    column: int
    length: int = 1

    @property
    def made(self) -> str | None:
        """The text that a program made of something at this place; None for text of the file itself."""
        return None


@dataclass(frozen=True)
class Related:
    """A second place that helps to understand a diagnostic, such as "first defined here"."""

    message: str
    span: Span | None


class Use(Related):
    """A second place that repeats what is wrong: the use of a part, the round of a loop."""

    __slots__ = ()


class MadeSpan(Span):
    """A place that a program made something of: ``text``, by the calls in ``via``, innermost first."""

    text: str = ""
    via: tuple[Related, ...] = ()

    @property
    def made(self) -> str:
        return self.text


@dataclass(frozen=True)
class Suggestion:
    """The help for a name that does not exist: the name, and those that exist.

    ``otherwise`` is before the list of names if none is similar; ``instead`` is in the place of the list, and ``none``
    is the help if there are no names. ``places`` are where the names are defined.
    """

    word: str
    candidates: Collection[str]
    otherwise: str = ""
    instead: str = ""
    none: str = ""
    places: Mapping[str, Span] = field(default_factory=dict)

    def __call__(self) -> str:
        """Return the help; ``messages`` calls it for the diagnostics that are shown."""
        help = did_you_mean(self.word, self.candidates, self.otherwise) or self.none
        return self.instead if self.instead and not help.startswith("did") else help

    def related(self) -> tuple[Related, ...]:
        """Return the place where the most similar name is defined."""
        near = nearest(self.word, self.candidates) if self.places else None
        span = self.places.get(near) if near is not None else None
        return (Related("the suggestion is defined here", span),) if span else ()


Help = str | Callable[[], str]


@dataclass(frozen=True)
class Diagnostic:
    """One problem or remark: ``rule`` is its kebab-case id, and ``help`` suggests a fix.

    ``of`` names its subject: the link or joint under which a description may accept it, or the edge, topic or line of a
    recording. ``numbers``, in SI units, are for programs. ``suggest`` makes the help; ``messages`` calls it after the
    last stage.
    """

    rule: str
    severity: str
    message: str
    span: Span | None = None
    related: tuple[Related, ...] = ()
    help: str = ""
    of: tuple[str, ...] = ()
    numbers: tuple[tuple[str, Any], ...] = ()
    suggest: Callable[[], str] | None = field(default=None, compare=False, repr=False)

    def worded(self) -> Diagnostic:
        """Return the diagnostic with its suggestion as help."""
        if self.suggest is None:
            return self
        near = self.suggest.related() if isinstance(self.suggest, Suggestion) else ()
        return replace(self, help=self.suggest(), suggest=None, related=(*near, *self.related))

    def __str__(self) -> str:
        return self.as_text().partition("\n")[0]

    def as_text(self) -> str:
        """Return the diagnostic as the command line prints it: place, message, the line of the file, help."""
        return report.text([self])

    def as_object(self) -> dict[str, object]:
        return report.as_object(self)


def error(rule: str, message: str, span: Span | None, help: Help = "", related: Iterable[Related] = ()) -> Diagnostic:
    """Return a diagnostic of severity error."""
    return diagnostic(rule, ERROR, message, span, help, related)


def diagnostic(
    rule: str, severity: str, message: str, span: Span | None, help: Help = "", related: Iterable[Related] = ()
) -> Diagnostic:
    """Return a diagnostic; a help that takes long to make is a function, which ``messages`` calls."""
    text, suggest = (help, None) if isinstance(help, str) else ("", help)
    return Diagnostic(rule, severity, message, span, tuple(related), text, suggest=suggest)


def has_errors(diagnostics: Iterable[Diagnostic]) -> bool:
    """Return True if any of the diagnostics is an error."""
    return any(d.severity == ERROR for d in diagnostics)


class SourceError(Exception):
    """A file that cannot be read or parsed; carries the diagnostic."""

    def __init__(self, diagnostic: Diagnostic) -> None:
        super().__init__(diagnostic.message)
        self.diagnostic = diagnostic


class RequestError(ValueError):
    """An argument of the API, or an option of a command, is invalid; the message has the reason."""


class MissingPackages(RequestError, ImportError):
    """Python packages that an extra brings are not installed; the message has the command that installs them."""


class UnknownName(RequestError, KeyError):
    """An argument names something that the robot does not have; the message has a suggestion."""

    __str__ = Exception.__str__
