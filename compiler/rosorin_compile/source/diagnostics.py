"""Errors, warnings and notes with positions in files, and their format on the command line."""

from collections.abc import Callable, Collection, Iterable, Mapping
from dataclasses import dataclass, field, replace
from typing import Any, NamedTuple

from .wording import and_more, count_of, did_you_mean, first_of, nearest, phrase, printable, quote, split_lines

__all__ = ["and_more", "count_of", "did_you_mean", "first_of", "nearest", "phrase", "printable", "quote"]

ERROR, WARNING, NOTE = "error", "warning", "note"
TRUSTED = (("trusted", True),)  # ``numbers`` of a warning about trusted code, which is not printed
_COLOURS = {ERROR: "\033[31m", WARNING: "\033[33m", NOTE: "\033[34m"}
_BOLD, _PLAIN = "\033[1m", "\033[0m"
MAX_SHOWN = 160  # maximum number of characters of a source line to print


class Source(NamedTuple):
    """The text of a file, and the path by which messages refer to the file."""

    path: str
    text: str

    def __repr__(self) -> str:
        return f"Source({self.path!r})"

    def line(self, number: int) -> str:
        """Return line ``number`` (from 1) without its line end, or an empty string if there is no such line."""
        lines = split_lines(self.text)
        return lines[number - 1] if 0 < number <= len(lines) else ""

    def span(self, offset: int = 0, length: int = 1) -> "Span":
        """Convert an offset in the text (from 0, in characters) to a ``Span`` of ``length`` characters."""
        lines = split_lines(self.text[:offset])
        return Span(self, len(lines), len(lines[-1]) + 1, max(1, length))


class Span(NamedTuple):
    """A range of characters in one line of a source. ``line`` and ``column`` count from 1; ``length`` is at least 1."""

    source: Source
    line: int
    column: int
    length: int = 1


class Related(NamedTuple):
    """A further position that helps to understand a diagnostic, with a message such as "first defined here"."""

    message: str
    span: Span | None

    def __str__(self) -> str:
        return f"{_place(self.span)}{printable(self.message)}"


class Use(Related):
    """The position of the entry of "use" that inserted the part with the faulty YAML, or of the loop around it."""

    __slots__ = ()


def _place(span: Span | None) -> str:
    return f"{printable(span.source.path)}:{span.line}:{span.column}: " if span else ""


class MadeSpan(Span):
    """The source position of a generated value; ``via`` has the xacro macro calls that led to it, innermost first."""

    via: tuple[Related, ...] = ()


@dataclass(frozen=True)
class Suggestion:
    """A callable that computes the help for the unknown name ``word``. It is slow: call it only to print the help."""

    word: str
    candidates: Collection[str]  # valid names; the help suggests the most similar name
    otherwise: str = ""  # begins the help if no candidate is similar; the list of candidates follows
    instead: str = ""  # the entire help if no candidate is similar, without the list of candidates
    details: str = ""  # added in parentheses to a suggestion; used like ``instead`` if that is empty
    none: str = ""  # the help if ``candidates`` is empty
    places: Mapping[str, Span] = field(default_factory=dict)  # where each candidate is defined
    others: Collection[str] = ()  # more valid names, suggested only if no name in ``candidates`` is similar

    def __call__(self) -> str:
        is_other = self.others and nearest(self.word, self.candidates) is None and nearest(self.word, self.others)
        help = did_you_mean(self.word, self.others if is_other else self.candidates, self.otherwise) or self.none
        if help.startswith("did"):
            return f"{help} ({self.details})" if self.details else help
        return self.instead or self.details or help

    def related_places(self) -> tuple[Related, ...]:
        """Return the definition of the most similar candidate as a related position, or () if it has no position."""
        near = nearest(self.word, self.candidates) if self.places else None
        span = self.places.get(near) if near is not None else None
        return (Related(f'"{near}" is defined here', span),) if span else ()


Help = str | Callable[[], str]


@dataclass(frozen=True)
class Diagnostic:
    """An error, warning or note, which refers to the rule with the id ``rule``.

    ``help`` suggests a fix; ``suggest``, if not None, computes the help when it is printed. ``of`` names the subject:
    links and joints, or a transform, topic or line of a recording. ``numbers`` are (name, value) pairs in SI units, so
    that programs need not parse the message.
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
        """Return the diagnostic with the result of ``suggest`` as ``help``."""
        if self.suggest is None:
            return self
        near = self.suggest.related_places() if isinstance(self.suggest, Suggestion) else ()
        return replace(self, help=self.suggest(), suggest=None, related=(*near, *self.related))

    def __str__(self) -> str:
        return self.as_text().partition("\n")[0]

    def as_text(self, colour: bool = False) -> str:
        """Format the diagnostic for a terminal: position, message, source line, help; ``colour`` adds ANSI colours."""
        this, span = self.with_help(), self.span
        head, message, help = f"{self.severity}[{self.rule}]", printable(this.message), printable(this.help)
        if colour:
            head, message = _COLOURS[self.severity] + head + _PLAIN, _BOLD + message + _PLAIN
        lines = [f"{_place(span)}{head}: {message}"]
        if span and self.severity != NOTE:
            # Mark the span with carets. If the line is long, print only the part around the span.
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
    """Format diagnostics for a terminal; ``colour`` adds ANSI colours."""
    return "".join(diagnostic.as_text(colour) for diagnostic in diagnostics)


def error(rule: str, message: str, span: Span | None, help: Help = "", related: Iterable[Related] = ()) -> Diagnostic:
    """Create an error. ``help`` may be a function, which is called only if the error is printed."""
    return diagnostic(rule, ERROR, message, span, help, related)


def diagnostic(
    rule: str, severity: str, message: str, span: Span | None, help: Help = "", related: Iterable[Related] = ()
) -> Diagnostic:
    """Create a diagnostic. ``help`` may be a function, which is called only if the diagnostic is printed."""
    text, suggest = (help, None) if isinstance(help, str) else ("", help)
    return Diagnostic(rule, severity, message, span, tuple(related), text, suggest=suggest)


def has_errors(diagnostics: Iterable[Diagnostic]) -> bool:
    """Return True if any of the diagnostics is an error."""
    return any(d.severity == ERROR for d in diagnostics)


class DiagnosticError(Exception):
    """Raised if processing cannot continue; ``diagnostic`` is the error to report."""

    def __init__(self, diagnostic: Diagnostic) -> None:
        super().__init__(diagnostic.message)
        self.diagnostic = diagnostic


class SourceError(DiagnosticError):
    """Raised if a file cannot be read or parsed."""


class RequestError(ValueError):
    """Raised for an invalid argument of an API function, or an invalid option of a command."""


class MissingPackages(RequestError, ImportError):
    """Raised if optional Python packages are missing; the message has the command that installs them."""


class UnknownName(RequestError, KeyError):
    """Raised for an unknown name, as in: the robot (``owner``) has no joint (``kind``) called "arm" (``name``)."""

    def __init__(self, kind: str, name: str, candidates: Iterable[str] = (), owner: str = "", none: str = "") -> None:
        super().__init__(kind, name, tuple(candidates), owner, none)

    def __str__(self) -> str:
        kind, name, candidates, owner, none = self.args
        help = Suggestion(name, candidates, none=none)()
        return f'{f"{owner} has" if owner else "there is"} no {kind} "{name}"' + (f"; {help}" if help else "")
