"""Diagnostics: what the compiler has to say about a description, as values.

A stage never prints and never raises for a problem in the user's files: it returns diagnostics. Only the command line
turns them into text.

To be read in this order: this module (``Diagnostic`` and its ``Span``), ``wording`` (what all sentences share),
``registry`` (what each id means), ``report`` (diagnostics as text, JSON, SARIF, ...), ``console`` (how they reach the
person). ``bounded`` stands beside them: parsers of foreign JSON, Python and YAML that keep their depth in bounds.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import TYPE_CHECKING, Any, NamedTuple

from . import report
from .letters import difference, look
from .wording import and_more, counted, first_of, listed, masked, printable, quoted

if TYPE_CHECKING:
    import ast

__all__ = [
    "ERROR",
    "NOTE",
    "WARNING",
    "Diagnostic",
    "MissingPackages",
    "Related",
    "RequestError",
    "Source",
    "Span",
    "and_more",
    "arrange",
    "counted",
    "did_you_mean",
    "error",
    "first_of",
    "has_errors",
    "listed",
    "masked",
    "nearest",
    "printable",
    "quoted",
]


class RequestError(ValueError):
    """An argument of the API, or an option of a command, is invalid; the message has the reason."""


class MissingPackages(RequestError, ImportError):
    """Python packages that an extra brings are not installed; the message has the command that installs them."""


class UnknownName(RequestError, KeyError):
    """An argument names something that the robot does not have; the message has a suggestion."""

    __str__ = Exception.__str__


ERROR = "error"
WARNING = "warning"
NOTE = "note"

_ORDER = {ERROR: 0, WARNING: 1, NOTE: 2}


# The ``numbers`` of what is told before something is run that somebody trusts: it is counted, and not shown.
TRUSTED = (("trusted", True),)


class Source(NamedTuple):
    """A file that was read: its path as shown to the user, and its text."""

    path: str
    text: str

    def __repr__(self) -> str:
        """Return the path alone: a diagnostic that is shown in full would show its file in full."""
        return f"Source({self.path!r}, ...)"

    def line(self, number: int) -> str:
        """Return line ``number`` (1-based) without its line end; empty beyond the end of the file."""
        lines = _lines(self.text)
        return lines[number - 1] if 0 < number <= len(lines) else ""

    def start(self) -> Span:
        """Return the place of its first character."""
        return Span(self, 1, 1, 1)

    def json(self) -> Any:
        """Return what it says as JSON. Raises ValueError, with the place where there is one, also if it is too deep."""
        from .bounded import json_of

        return json_of(self.text)

    def yaml(self) -> Any:
        """Return what it says as YAML. Raises ValueError, with what is wrong, also if it is too deep."""
        from .bounded import yaml_of

        return yaml_of(self.text)

    def python(self, expression: bool = False) -> ast.Module | ast.Expression:
        """Return its syntax tree, as a program or an expression. Raises SyntaxError; ValueError if it is too deep."""
        from .bounded import python_of

        return python_of(self.text, expression)


@lru_cache(maxsize=16)
def _lines(text: str) -> list[str]:
    """Return the lines of a text, as YAML counts them."""
    text = text.replace("\r\n", "\n")
    for end in ("\r", "\x85", "\u2028", "\u2029"):
        text = text.replace(end, "\n")
    return text.split("\n")


class Span(NamedTuple):
    """A place in a source: line and column count from 1, in characters; ``length`` is at least 1."""

    source: Source
    line: int
    column: int
    length: int = 1

    @property
    def made(self) -> str | None:
        """The text that a program made of something at this place; None where it is what stands there."""
        return None


@dataclass(frozen=True)
class Related:
    """A second place that helps to understand a diagnostic, such as "first defined here"."""

    message: str
    span: Span | None


class Use(Related):
    """A second place that made what is wrong: the use of a part, the round of a loop."""

    __slots__ = ()


class MadeSpan(Span):
    """A place that a program made something of: ``text``, by the calls in ``via``, innermost first."""

    text: str = ""
    via: tuple[Related, ...] = ()

    @property
    def made(self) -> str:
        """The text that a program made."""
        return self.text


@dataclass(frozen=True)
class Diagnostic:
    """One problem or remark: ``rule`` is its kebab-case id, and ``help`` suggests a fix.

    ``of`` names its subject: the link or joint under which a description may accept it, or the edge, topic or line of a
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

    def __str__(self) -> str:
        """Return place, severity, rule and message in one line, as the command line begins with."""
        return self.as_text().partition("\n")[0]

    def as_text(self) -> str:
        """Return it as a person reads it, in lines: place, message, the line of the file, the way out."""
        return report.text([self])

    def as_object(self) -> dict[str, object]:
        """Return it as JSON has it."""
        return report.as_object(self)


def error(rule: str, message: str, span: Span | None, help: str = "", related: Iterable[Related] = ()) -> Diagnostic:
    """Return a diagnostic of severity error."""
    return Diagnostic(rule, ERROR, message, span, tuple(related), help)


def has_errors(diagnostics: Iterable[Diagnostic]) -> bool:
    """Say whether any of the diagnostics is an error."""
    return any(d.severity == ERROR for d in diagnostics)


def arrange(diagnostics: Iterable[Diagnostic]) -> list[Diagnostic]:
    """Return each diagnostic once, ordered by file, line and column; those without a place come last.

    One mistake in a value that many entries use, or in a part, is told for the first of them, with the other uses or
    with the number of the other entries.
    """
    causes: dict[tuple[object, ...], list[Diagnostic]] = {}
    for diagnostic in map(with_calls, diagnostics):
        causes.setdefault(_cause(diagnostic), []).append(diagnostic)
    return sorted((_together(same) for same in causes.values()), key=order)


# Rules about a value as it is written, whatever entry it belongs to.
_OF_VALUES = (
    *("unknown-key", "missing-key", "wrong-type", "wrong-value", "wrong-length"),
    *("wrong-unit", "not-finite", "bad-name", "empty-text", "wrong-shape"),
)
_NAME = re.compile(r'(the key )?"[^"]*"')
_INDEX = re.compile(r"\[\d+\]")
_SUBJECT = re.compile(r"^.*?(?= (has|needs|is|cannot|does)\b)")


def _cause(diagnostic: Diagnostic) -> tuple[object, ...]:
    """Return what is the same for all that is told of one mistake: the rule, the place, what is wrong there."""
    span, rule, said = diagnostic.span, diagnostic.rule, diagnostic.message
    if span is None:
        return (rule, said)
    said = _INDEX.sub("", _NAME.sub(lambda found: found[0] if found[1] else "", said))
    said = _SUBJECT.sub("", said) if rule in _OF_VALUES else said
    return (rule, said, span.source.path, span.line, span.column)


def with_calls(diagnostic: Diagnostic) -> Diagnostic:
    """Return a diagnostic with the calls of macros that led to its place."""
    span = diagnostic.span
    via = span.via if isinstance(span, MadeSpan) else ()
    new = [one for one in via if one not in diagnostic.related]
    return replace(diagnostic, related=(*diagnostic.related, *new)) if new else diagnostic


MAX_COMPARED = 60
MAX_LISTED = 40

_VARYING = re.compile(r'"[^"]*"|[-+]?\d[\d,.]*(e[-+]?\d+)?')
_PLACES = 6  # places named of one thing
_EACH = ("stand-in",)  # rules whose every case is told


def and_here(spans: Sequence[Span]) -> tuple[Related, ...]:
    """Return the further places of what is told once: the first of them, and the number of the others."""
    places = [Related("and here", span) for span in spans[:_PLACES]]
    left = len(spans) - _PLACES
    return (*places, Related(f"and in {counted(left, 'more place')}", None)) if left > 0 else tuple(places)


def gathered(diagnostics: Sequence[Diagnostic], severities: Iterable[str]) -> list[Diagnostic]:
    """Return the diagnostics; what is said several times, but for names and numbers, is said once.

    It is the first of them, with the number and the places of the others. Nothing is gathered that has no place, or
    that is of no kind in ``severities``.
    """
    groups: dict[object, list[Diagnostic]] = {}
    for index, one in enumerate(diagnostics):
        alone = one.severity not in severities or one.span is None or one.rule in _EACH
        key = index if alone else (one.rule, one.severity, _VARYING.sub("", one.message))
        groups.setdefault(key, []).append(one)
    once = {id(group[0]): group[1:] for group in groups.values() if len(group) > 1}
    said = {id(one) for others in once.values() for one in others}
    return [_gathered(one, once.get(id(one), [])) for one in diagnostics if id(one) not in said]


def _gathered(first: Diagnostic, others: Sequence[Diagnostic]) -> Diagnostic:
    """Return the first of several diagnostics that say nearly the same."""
    if not others:
        return first
    spans = (other.span for other in others if other.span)
    places = and_here(sorted(spans, key=lambda span: (span.source.path, span.line, span.column)))
    message = f"{first.message},{and_more(len(others), 'of this kind')}"
    return replace(first, message=message, related=(*first.related, *places))


def _together(same: list[Diagnostic]) -> Diagnostic:
    """Return the first of several diagnostics of one mistake, with the other uses or the number of other entries."""
    first = same[0]
    further = (next((one for one in other.related if _is_other_use(one, first)), None) for other in same[1:])
    uses = list(dict.fromkeys(use for use in further if use is not None))
    if uses:
        left = [Related(and_more(len(uses) - _PLACES).strip(), None)] if len(uses) > _PLACES else []
        return replace(first, related=(*first.related, *uses[:_PLACES], *left))
    others = len({diagnostic.message for diagnostic in same}) - 1
    if not others:
        return first
    more = and_more(others, "entry that uses this value" if others == 1 else "entries that use this value").strip()
    return replace(first, related=(Related(more, None), *first.related))


def _is_other_use(related: Related, first: Diagnostic) -> bool:
    return isinstance(related, Use) and related not in first.related


def order(d: Diagnostic) -> tuple[object, ...]:
    """Return what diagnostics are ordered by: file, line and column, the worst first; those without a place last."""
    place = (0, d.span.source.path, d.span.line, d.span.column) if d.span else (1, "", 0, 0)
    return (*place, _ORDER[d.severity], d.rule, d.message)


MAX_MEANT = 3


def nearest(word: str, known: Iterable[str]) -> str | None:
    """Return the known word that is most like ``word``, or None if none is alike."""
    close = _alike(word, sorted(known))
    return close[0] if close else None


def _alike(word: str, names: list[str]) -> list[str]:
    """Return the names that a word may stand for, the likeliest first; several only where they are equally likely."""
    import difflib

    if not word.isascii() and (same := [name for name in names if look(name) == look(word)]):
        return same[:1]
    if (known := set(names)) and (slips := [made for made in swaps(word) if made in known]):
        return slips[:1]
    if len(names) > MAX_COMPARED:  # comparing is slow, and there may be as many mistakes as names
        first = "".join(_parts(word))[:1] or word[:1]  # of /laser the l
        names = [name for name in names if name[:1].casefold() == first and abs(len(name) - len(word)) < 3]
        small = word.casefold()
        names = [name for name in names if name.casefold() == small][:1] or names[:MAX_COMPARED]
    parts = {name: _parts(name) for name in names} if len(word) > 1 else {}  # everything is like a single letter
    own = _parts(word)
    plain = {"".join(of): name for name, of in parts.items()}
    text = "".join(own) or word
    if text in plain:
        return [plain[text]]
    if turned := [name for name, of in parts.items() if of != own and sorted(of) == sorted(own)]:
        return turned[:1]
    lower = {name.casefold(): name for name in parts}
    if misspelt := difflib.get_close_matches(word.casefold(), lower, n=1, cutoff=0.85):
        return [lower[misspelt[0]]]
    if within := [name for name, of in parts.items() if _holds(of, own) or _holds(own, of)]:
        return sorted(within, key=lambda name: (abs(len(name) - len(word)), name))[:MAX_MEANT]
    alike = difflib.get_close_matches(word.casefold(), lower, n=1, cutoff=0.75 if len(word) > 3 else 0.66)
    return [lower[one] for one in alike]


def swaps(word: str) -> Iterator[str]:
    """Yield what a word may have been before two letters side by side changed places."""
    for at in range(1, len(word)):
        one, other = word[at - 1], word[at]
        if one != other:
            yield f"{word[: at - 1]}{other}{one}{word[at + 1 :]}"


def _parts(name: str) -> list[str]:
    """Return the words of a name in small letters: those of ``left_wheel`` are left and wheel."""
    return [part for part in _BETWEEN.split(name.casefold()) if part]


_BETWEEN = re.compile(r"[\W_]+")


def _holds(longer: list[str], shorter: list[str]) -> bool:
    """Say whether the words of one name stand in another, side by side, or begin or end it without a gap."""
    one, other = "".join(longer), "".join(shorter)
    if len(other) < 3 or len(one) <= len(other):
        return False
    if len(other) > 3 and (one.startswith(other) or one.endswith(other)):
        return True
    return any(longer[i : i + len(shorter)] == shorter for i in range(len(longer) - len(shorter) + 1))


def did_you_mean(word: str, known: Iterable[str], otherwise: str = "") -> str:
    """Return 'did you mean "x"?' for the nearest known words, or the list of known words if none is near.

    ``otherwise`` is what to do then: it comes before the list.
    """
    if otherwise:
        return or_else(did_you_mean(word, known), otherwise)
    names = sorted(known)
    close = _alike(word, names)
    if close:
        quoted = [f'"{name}"' for name in close]
        told = f"did you mean {' or '.join(quoted)}?"
        alike = not (word + close[0]).isascii() and look(word) == look(close[0])
        return told + (f" the two differ in {difference(word, close[0])}" if alike else "")
    return f"known: {first_of(names, MAX_LISTED)}" if names else ""


def or_else(guess: str, otherwise: str) -> str:
    """Return 'did you mean "x"?' as it is; before a list of known words what to do."""
    if guess.startswith("did"):
        return guess
    return f"{otherwise} ({guess})" if guess else otherwise
