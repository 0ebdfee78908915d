"""Diagnostics: the errors, warnings and notes that stages return, with positions in files, and their text form."""

from collections.abc import Callable, Collection, Iterable, Mapping
from dataclasses import dataclass, field, replace
from typing import Any, NamedTuple

from .wording import and_more, count_of, did_you_mean, first_of, nearest, phrase, printable, quote, split_lines

__all__ = ["and_more", "count_of", "did_you_mean", "first_of", "nearest", "phrase", "printable", "quote"]

ERROR, WARNING, NOTE = "error", "warning", "note"
TRUSTED = (("trusted", True),)  # ``numbers`` of a warning that trusted code will run, which is not printed
_COLOURS = {ERROR: "\033[31m", WARNING: "\033[33m", NOTE: "\033[34m"}
_BOLD, _PLAIN = "\033[1m", "\033[0m"
MAX_SHOWN = 160  # characters of a source line


class Source(NamedTuple):
    """A file that was read: its path as shown to the user, and its text."""

    path: str
    text: str

    def __repr__(self) -> str:
        return f"Source({self.path!r})"

    def line(self, number: int) -> str:
        """Return line ``number`` (1-based) without its line end; empty beyond the end of the file."""
        lines = split_lines(self.text)
        return lines[number - 1] if 0 < number <= len(lines) else ""

    def span(self, offset: int = 0, length: int = 1) -> "Span":
        """Return the span of ``length`` characters at an offset."""
        lines = split_lines(self.text[:offset])
        return Span(self, len(lines), len(lines[-1]) + 1, max(1, length))


class Span(NamedTuple):
    """A position in a source: line and column count from 1, in characters; ``length`` is at least 1."""

    source: Source
    line: int
    column: int
    length: int = 1


@dataclass(frozen=True)
class Related:
    """A second position that helps to understand a diagnostic, such as "first defined here"."""

    message: str
    span: Span | None

    def __str__(self) -> str:
        return f"{_place(self.span)}{printable(self.message)}"


class Use(Related):
    """A second position that the mistake affects: an entry of ``use`` with the part, or an iteration of the loop."""

    __slots__ = ()


def _place(span: Span | None) -> str:
    return f"{printable(span.source.path)}:{span.line}:{span.column}: " if span else ""


class MadeSpan(Span):
    """A position from which a program generated something; ``via`` has the calls that led to it, innermost first."""

    via: tuple[Related, ...] = ()


@dataclass(frozen=True)
class Suggestion:
    """A callable that returns the help for the unknown name ``word``; slow, so only called for printed diagnostics."""

    word: str
    candidates: Collection[str]  # valid names; a similar one is suggested
    otherwise: str = ""  # if no candidate is similar, the text before the list of candidates
    instead: str = ""  # if no candidate is similar, the text in place of the list of candidates
    details: str = ""  # like ``instead``, but also added after a suggested name
    none: str = ""  # the help if there are no candidates
    places: Mapping[str, Span] = field(default_factory=dict)  # where the candidates are defined
    others: Collection[str] = ()  # further valid names, compared only if no candidate is similar

    def __call__(self) -> str:
        is_other = self.others and nearest(self.word, self.candidates) is None and nearest(self.word, self.others)
        help = did_you_mean(self.word, self.others if is_other else self.candidates, self.otherwise) or self.none
        if help.startswith("did"):
            return f"{help} ({self.details})" if self.details else help
        return self.instead or self.details or help

    def related_places(self) -> tuple[Related, ...]:
        """Return the place where the most similar candidate is defined."""
        near = nearest(self.word, self.candidates) if self.places else None
        span = self.places.get(near) if near is not None else None
        return (Related(f'"{near}" is defined here', span),) if span else ()


Help = str | Callable[[], str]


@dataclass(frozen=True)
class Diagnostic:
    """An error, warning or note: ``rule`` is its kebab-case id; ``help`` suggests a fix, or ``suggest`` computes it.

    ``of`` names its subject: the link or joint under which a description may accept it, or an edge, topic or line of a
    recording. ``numbers``, in SI units, are for programs.
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

    def with_help(self) -> "Diagnostic":
        """Return the diagnostic with its suggestion as help."""
        if self.suggest is None:
            return self
        near = self.suggest.related_places() if isinstance(self.suggest, Suggestion) else ()
        return replace(self, help=self.suggest(), suggest=None, related=(*near, *self.related))

    def __str__(self) -> str:
        return self.as_text().partition("\n")[0]

    def as_text(self, colour: bool = False) -> str:
        """Return the diagnostic as the command line prints it: position, message, source line, help."""
        this, span = self.with_help(), self.span
        head, message, help = f"{self.severity}[{self.rule}]", printable(this.message), printable(this.help)
        if colour:
            head, message = _COLOURS[self.severity] + head + _PLAIN, _BOLD + message + _PLAIN
        lines = [f"{_place(span)}{head}: {message}"]
        if span and self.severity != NOTE:
            # Carets mark the span; of a long line, only the part around the span is shown.
            line = span.source.line(span.line)
            first = max(0, span.column - 1 - MAX_SHOWN // 2) if len(line) > MAX_SHOWN else 0
            shown = printable(line[first : first + MAX_SHOWN].replace("\t", " "))
            column = min(span.column - 1 - first, len(shown))
            carets = "^" * max(1, min(span.length, len(shown) - column))
            lines += [f"{span.line:5} | {shown}".rstrip(), f"{'':5} | {' ' * column}{carets} {help}".rstrip()]
        elif help:
            lines.append(f"    {help}")
        return "\n".join([*lines, *(f"      {related}" for related in this.related)]) + "\n"

    def as_object(self) -> dict[str, object]:
        def where(span: Span | None) -> dict[str, object]:
            return {"file": span.source.path, **dict(zip(span._fields[1:], span[1:], strict=True))} if span else {}

        this = self.with_help()
        head = {"rule": self.rule, "severity": self.severity, "message": this.message, **where(self.span)}
        related = [{"message": related.message, **where(related.span)} for related in this.related]
        return {**head, "help": this.help, "related": related}


def text(diagnostics: Iterable[Diagnostic], colour: bool = False) -> str:
    """Return diagnostics as the command line prints them: position, message, source line, help."""
    return "".join(diagnostic.as_text(colour) for diagnostic in diagnostics)


def error(rule: str, message: str, span: Span | None, help: Help = "", related: Iterable[Related] = ()) -> Diagnostic:
    """Return a diagnostic of severity error."""
    return diagnostic(rule, ERROR, message, span, help, related)


def diagnostic(
    rule: str, severity: str, message: str, span: Span | None, help: Help = "", related: Iterable[Related] = ()
) -> Diagnostic:
    """Return a diagnostic; if the help is slow to compute, pass a function, which ``messages`` calls when needed."""
    text, suggest = (help, None) if isinstance(help, str) else ("", help)
    return Diagnostic(rule, severity, message, span, tuple(related), text, suggest=suggest)


def has_errors(diagnostics: Iterable[Diagnostic]) -> bool:
    """Return True if any of the diagnostics is an error."""
    return any(d.severity == ERROR for d in diagnostics)


class DiagnosticError(Exception):
    """Processing cannot continue; ``diagnostic`` has the reason."""

    def __init__(self, diagnostic: Diagnostic) -> None:
        super().__init__(diagnostic.message)
        self.diagnostic = diagnostic


class SourceError(DiagnosticError):
    """A file cannot be read or parsed."""


class RequestError(ValueError):
    """An argument of the API or an option of a command is invalid; the message is the reason."""


class MissingPackages(RequestError, ImportError):
    """Python packages of an extra are not installed; the message has the command that installs them."""


class UnknownName(RequestError, KeyError):
    """An argument names something that does not exist, as in: the robot (``owner``) has no joint (``kind``) "arm"."""

    def __init__(self, kind: str, name: str, candidates: Iterable[str] = (), owner: str = "", none: str = "") -> None:
        super().__init__(kind, name, tuple(candidates), owner, none)

    def __str__(self) -> str:
        kind, name, candidates, owner, none = self.args
        help = Suggestion(name, candidates, none=none)()
        return f'{f"{owner} has" if owner else "there is"} no {kind} "{name}"' + (f"; {help}" if help else "")
