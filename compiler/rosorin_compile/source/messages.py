"""Merge, order and word the diagnostics of all stages, after the last stage.

One mistake in a value that many entries use, or in a part, is reported once with its uses. An unknown name for which
there is a suggestion is reported once, however often it is used. Suggestions are computed here, for as many diagnostics
as are shown.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from dataclasses import replace
from difflib import SequenceMatcher
from typing import NamedTuple

from .diagnostics import ERROR, NOTE, WARNING, Diagnostic, MadeSpan, Related, Span, Suggestion, Use
from .wording import and_more, counted, swaps

MAX_WORDED = 200  # diagnostics with a suggestion: more than a person reads
_PLACES = 6  # further places of one diagnostic
_ORDER = {ERROR: 0, WARNING: 1, NOTE: 2}
_EACH = ("stand-in",)  # rules that are reported one by one
# Rules about a value as it is written, whatever entry it belongs to.
_OF_VALUES = (
    *("unknown-key", "missing-key", "wrong-type", "wrong-value", "wrong-length"),
    *("wrong-unit", "not-finite", "bad-name", "empty-text", "wrong-shape"),
)
_NAME = re.compile(r'(the key )?"[^"]*"|\[\d+\]')
_SUBJECT = re.compile(r"^.*?(?= (has|needs|is|cannot|does)\b)")
_VARYING = re.compile(r'"[^"]*"|[-+]?\d[\d,.]*(e[-+]?\d+)?')


def arrange(diagnostics: Iterable[Diagnostic]) -> list[Diagnostic]:
    """Merge the diagnostics of one mistake, and order them by file, line and column; those without a place come last.

    Suggestions are computed for the first 200 of them.
    """
    causes: dict[tuple[object, ...], list[Diagnostic]] = {}
    for diagnostic in map(with_calls, diagnostics):
        span, rule, message = diagnostic.span, diagnostic.rule, diagnostic.message
        cause: tuple[object, ...] = (rule, message)
        if span is not None:  # without the names of the entries that share the value
            message = _NAME.sub(lambda found: found[0] if found[1] else "", message)
            message = _SUBJECT.sub("", message) if rule in _OF_VALUES else message
            cause = (rule, message, span.source.path, span.line, span.column)
        causes.setdefault(cause, []).append(diagnostic)
    return worded(sorted(map(_merged, causes.values()), key=order))


def worded(diagnostics: Iterable[Diagnostic]) -> list[Diagnostic]:
    """Compute the suggestions of diagnostics, for the first 200 of them."""
    count = 0
    result = []
    for one in diagnostics:
        count += one.suggest is not None
        result.append(one.worded() if count <= MAX_WORDED else replace(one, suggest=None))
    return result


def order(d: Diagnostic) -> tuple[object, ...]:
    """Return the key to sort diagnostics by: file, line and column, the worst first; those without a place last."""
    place = (0, d.span.source.path, d.span.line, d.span.column) if d.span else (1, "", 0, 0)
    return (*place, _ORDER[d.severity], d.rule, d.message)


def with_calls(diagnostic: Diagnostic) -> Diagnostic:
    """Add the calls of macros that led to the place of a diagnostic."""
    via = diagnostic.span.via if isinstance(diagnostic.span, MadeSpan) else ()
    new = [one for one in via if one not in diagnostic.related]
    return replace(diagnostic, related=(*diagnostic.related, *new)) if new else diagnostic


def _merged(same: list[Diagnostic]) -> Diagnostic:
    """Return the first of several diagnostics of one mistake, with the other uses or the number of other entries."""
    first = same[0]
    uses: dict[Use, None] = {}
    for other in same[1:]:
        new = (one for one in other.related if isinstance(one, Use) and one not in first.related)
        uses |= dict.fromkeys([*new][:1])
    if uses:
        left = [Related(and_more(len(uses) - _PLACES).strip(), None)] if len(uses) > _PLACES else []
        return replace(first, related=(*first.related, *[*uses][:_PLACES], *left))
    others = len({diagnostic.message for diagnostic in same}) - 1
    if not others:
        return first
    more = and_more(others, "entry that uses this value" if others == 1 else "entries that use this value").strip()
    return replace(first, related=(Related(more, None), *first.related))


def and_here(spans: Sequence[Span]) -> tuple[Related, ...]:
    """Return the first six of further places, and the number of the others."""
    places = [Related("and here", span) for span in spans[:_PLACES]]
    left = len(spans) - _PLACES
    return (*places, Related(f"and in {counted(left, 'more place')}", None)) if left > 0 else tuple(places)


def gathered(diagnostics: Sequence[Diagnostic], severities: Iterable[str]) -> list[Diagnostic]:
    """Merge diagnostics that differ in names and numbers alone into the first, with the places of the others.

    Those without a place, or of a severity that is not in ``severities``, stay as they are.
    """
    groups: dict[object, list[Diagnostic]] = {}
    for index, one in enumerate(diagnostics):
        is_alone = one.severity not in severities or one.span is None or one.rule in _EACH
        key = index if is_alone else (one.rule, one.severity, _VARYING.sub("", one.message))
        groups.setdefault(key, []).append(one)
    result = []
    for first, *others in groups.values():
        spans = sorted((one.span for one in others if one.span), key=lambda span: (span.source.path, *span[1:3]))
        message = f"{first.message},{and_more(len(others), 'of this kind')}"
        related = (*first.related, *and_here(spans))
        result.append(replace(first, message=message, related=related) if others else first)
    return result


# --- unknown names ---

# The note at the definition that an unknown name is similar to, if nothing else names it.
UNNAMED = "is defined here, and may be what is misspelt"
USED = "used here"
_MEANT = re.compile(r'did you mean "([^"]+)"\?')
# Each of these is a mistake of its own, wherever it is.
_OF_SHAPE = ("unknown-key", "wrong-value", "wrong-type", "wrong-unit", "unknown-option")


class Offer(NamedTuple):
    """An unknown name, and the suggested one."""

    name: str
    meant: str


def offer(diagnostic: Diagnostic) -> Offer | None:
    """Return the unknown name of an error and the name that its help suggests, or None for another error."""
    if diagnostic.severity != ERROR or diagnostic.rule in _OF_SHAPE:
        return None
    found = _MEANT.match(diagnostic.worded().help)
    if found is None:
        return None
    meant = found[1]
    if isinstance(diagnostic.suggest, Suggestion):
        return Offer(diagnostic.suggest.word, meant)
    names = [name for name in re.findall(r'"([^"]+)"', diagnostic.message) if name != meant]

    def similarity(name: str) -> tuple[bool, float]:
        return name in swaps(meant), SequenceMatcher(None, name, meant).ratio()

    return Offer(max(names, key=similarity), meant) if names else None


def told_once(diagnostics: Iterable[Diagnostic]) -> list[Diagnostic]:
    """Merge the diagnostics about one unknown name, or about one definition that nothing names, into the first."""
    groups: list[list[Diagnostic]] = []
    known: dict[object, list[Diagnostic]] = {}
    for diagnostic in sorted(diagnostics, key=order):
        keys = _keys(diagnostic)
        same = next((known[key] for key in keys if key in known), None)
        if same is None:
            groups.append(same := [])
        same.append(diagnostic)
        for key in keys:
            known.setdefault(key, same)
    return [one for same in groups for one in _first(same)]


def _keys(diagnostic: Diagnostic) -> list[object]:
    offered = offer(diagnostic)
    if offered is None or diagnostic.span is None:
        return []
    homes = [one.span for one in diagnostic.related if one.message.endswith(UNNAMED)]
    keys: list[object] = [offered.name, tuple(sorted(offered))]
    keys += [(home.source.path, home.line, home.column) for home in homes if home]
    steps = zip(offered.name.split("."), offered.meant.split("."), strict=False)
    group = [pair for pair in steps if pair[0] != pair[1]]
    return [*keys, *group] if "." in offered.name and len(group) == 1 else keys  # of a.b and a.c the a


def _first(same: list[Diagnostic]) -> list[Diagnostic]:
    """Return the first of several diagnostics with the places of the others.

    Those at its own place are of the uses of one part, and stay separate: ``arrange`` merges them.
    """
    first = same[0]
    separate = [one for one in same[1:] if one.span == first.span and one.rule == first.rule]
    others = [one for one in same[1:] if one not in separate]
    shown = [first.span, *(one.span for one in first.related)]
    notes = [one for other in others for one in other.related if one.message.endswith(UNNAMED)]
    new = {one.span: one for one in reversed(notes) if one.span not in shown}
    places = dict.fromkeys(one.span for one in others if one.span is not None and one.span not in (*shown, *new))
    return [replace(first, related=(*first.related, *new.values(), *and_here(list(places)))), *separate]


def placed(diagnostic: Diagnostic, offered: Offer) -> Diagnostic:
    """Move an error about an unknown name to the place, among those that led to it, where the name was written."""
    span, related = diagnostic.span, diagnostic.related
    there = written([span, *(one.span for one in related)], offered.name, offered.meant)
    if span is None or there is None or there == span:
        return diagnostic
    related = (*(one for one in related if one.span != there), Related(USED, span))
    return replace(diagnostic, span=there, related=related)


def written(spans: Iterable[Span | None], name: str, other: str) -> Span | None:
    """Return the first place with a word that is in a name, and not in the other name."""
    for span in spans:
        if span is None:
            continue
        text = span.source.line(span.line)[span.column - 1 :]
        depth = 0
        for at, letter in enumerate(text):  # of a list or a table the part that is in this line
            depth += (letter in "[{") - (letter in "]}")
            if depth == 0:
                text = text[: at if at else span.length]
                break
        if any(word in name and word not in other for word in re.findall(r"[\w-]+", text)):
            return span
    return None
