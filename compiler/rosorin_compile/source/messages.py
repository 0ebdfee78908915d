"""Merge diagnostics that report the same mistake, sort them, and compute "did you mean" suggestions."""

import re
from collections.abc import Iterable, Sequence
from dataclasses import replace
from difflib import get_close_matches
from itertools import accumulate, count
from typing import NamedTuple

from .diagnostics import ERROR, NOTE, WARNING, Diagnostic, MadeSpan, Related, Span, Suggestion, Use
from .wording import and_more, count_of, first_of, swaps

MAX_WORDED = 200  # maximum number of suggestions to compute, because they are slow
_PLACES = 6  # maximum number of related positions that merging adds to a diagnostic
_ORDER = {ERROR: 0, WARNING: 1, NOTE: 2}
# Rules about a single value: if entries share the value, for example by an alias, report the problem only once.
_OF_VALUES = {"unknown-key", "missing-key", "wrong-type", "wrong-value", "wrong-length", "wrong-unit", "not-finite"}
_OF_VALUES |= {"bad-name", "empty-text", "wrong-shape"}
_NAME = re.compile(r'(the key )?"[^"]*"|\[\d+\]')
_SUBJECT = r"^.*?(?= (has|needs|is|cannot|does|must)\b)"
_QUOTED = r'"[^"]*"'
_VARYING = re.compile(r'"[^"]*"|[-+]?\d[\d,.]*(e[-+]?\d+)?')


def arrange(diagnostics: Iterable[Diagnostic]) -> list[Diagnostic]:
    """Merge diagnostics of the same mistake, sort them by position, and compute at most 200 suggestions."""
    causes: dict[object, list[Diagnostic]] = {}
    for diagnostic in map(with_calls, diagnostics):
        span, rule, message = diagnostic.span, diagnostic.rule, diagnostic.message
        if span is not None:  # ignore names: entries that share a faulty value have different names
            message = _NAME.sub(lambda found: found[0] if found[1] else "", message)
            message = re.sub(_SUBJECT, "", message) if rule in _OF_VALUES else message
        causes.setdefault((rule, message, span and (span.source.path, *span[1:3])), []).append(diagnostic)
    return add_suggestions(sorted(map(_merged, causes.values()), key=order))


def add_suggestions(diagnostics: Iterable[Diagnostic]) -> list[Diagnostic]:
    """Call ``suggest`` of the first 200 diagnostics that have this function, and store the result as ``help``."""
    left = count(-MAX_WORDED)  # the first MAX_WORDED numbers are negative
    return [d.with_help() if d.suggest is None or next(left) < 0 else replace(d, suggest=None) for d in diagnostics]


def order(d: Diagnostic) -> tuple[object, ...]:
    """Return a sort key: file, line, column, then severity. Diagnostics without a position come last."""
    place = (0, d.span.source.path, d.span.line, d.span.column) if d.span else (1, "", 0, 0)
    return (*place, _ORDER[d.severity], d.rule, d.message)


def with_calls(diagnostic: Diagnostic) -> Diagnostic:
    """Add related positions to a diagnostic: the xacro macro calls that generated the faulty value."""
    via = diagnostic.span.via if isinstance(diagnostic.span, MadeSpan) else ()
    new = [call for call in via if call not in diagnostic.related]
    return replace(diagnostic, related=(*diagnostic.related, *new)) if new else diagnostic


def _merged(same: list[Diagnostic]) -> Diagnostic:
    first = same[0]
    uses: dict[Related, None] = {}
    for other in same[1:]:
        uses |= dict.fromkeys([use for use in other.related if isinstance(use, Use) and use not in first.related][:1])
    others = 0 if uses else len({diagnostic.message for diagnostic in same}) - 1
    more = and_more(others, "entry that uses this value" if others == 1 else "entries that use this value")
    names = [name for other in same[1:] for name in re.findall(_QUOTED, other.message) if name not in first.message]
    more = f"the same applies to {first_of([*dict.fromkeys(names)], _PLACES)}" if more and names else more
    before, after = ([Related(t.strip(), None)] if t else [] for t in (more, and_more(len(uses) - _PLACES)))
    return replace(first, related=(*before, *first.related, *[*uses][:_PLACES], *after))


def and_here(spans: Sequence[Span]) -> tuple[Related, ...]:
    """Return "and here" at each of the first six spans, and "and in 3 more places" if there are nine spans."""
    left = len(spans) - _PLACES
    more = [Related(f"and in {count_of(left, 'more place')}", None)] if left > 0 else []
    return (*(Related("and here", span) for span in spans[:_PLACES]), *more)


def gather(diagnostics: Sequence[Diagnostic], severities: Iterable[str]) -> list[Diagnostic]:
    """Merge diagnostics with a severity in ``severities`` that differ only in names and numbers; list all positions."""
    groups: dict[object, list[Diagnostic]] = {}
    for index, diagnostic in enumerate(diagnostics):
        is_alone = diagnostic.severity not in severities or diagnostic.span is None or diagnostic.rule == "stand-in"
        kind = (diagnostic.rule, diagnostic.severity, _VARYING.sub("", diagnostic.message))
        groups.setdefault(index if is_alone else kind, []).append(diagnostic)
    result = []
    for first, *others in groups.values():
        spans = sorted((other.span for other in others if other.span), key=lambda span: (span.source.path, *span[1:3]))
        message = f"{first.message},{and_more(len(others), 'of this kind')}"
        related = (*first.related, *and_here(spans))
        result.append(replace(first, message=message, related=related) if others else first)
    return result


UNNAMED = "is defined here and may be the misspelt name"  # message at an unused definition with a similar name
USED = "used here"
_MEANT = r'did you mean "([^"]+)"\?'
# Rules that suggest a key, value, type or unit instead of a name that the user defined.
_OF_SHAPE = ("unknown-key", "wrong-value", "wrong-type", "wrong-unit", "unknown-option")


class Offer(NamedTuple):
    """An unknown name (``name``), and the valid name that the help suggests instead (``meant``)."""

    name: str
    meant: str


def offer(diagnostic: Diagnostic) -> Offer | None:
    """Return the unknown name in an error and the suggested name, or None if the error suggests no name."""
    is_name = diagnostic.severity == ERROR and diagnostic.rule not in _OF_SHAPE
    if not is_name or (found := re.match(_MEANT, diagnostic.with_help().help)) is None:
        return None
    meant = found[1]
    if isinstance(diagnostic.suggest, Suggestion):
        return Offer(diagnostic.suggest.word, meant)
    names = [name for name in re.findall(r'"([^"]+)"', diagnostic.message) if name != meant]
    similar = [*(name for name in names if name in swaps(meant)), *get_close_matches(meant, names, 1, 0.0)]
    return Offer(similar[0], meant) if similar else None


def merge_by_name(diagnostics: Iterable[Diagnostic]) -> list[Diagnostic]:
    """Merge errors about the same unknown name, or about names that resemble the same unused definition."""
    groups: list[list[Diagnostic]] = []
    known: dict[object, list[Diagnostic]] = {}
    for diagnostic in sorted(diagnostics, key=order):
        keys: list[object] = []
        if diagnostic.span is not None and (offered := offer(diagnostic)):
            homes = [note.span for note in diagnostic.related if note.message.endswith(UNNAMED)]
            keys = [offered.name, tuple(sorted(offered)), *((home.source.path, *home[1:3]) for home in homes if home)]
            steps = [*zip(offered.name.split("."), offered.meant.split("."), strict=False)]
            differing = [step for step in steps if step[0] != step[1]]
            # Report one mistake, not two, if "arm.x" and "arm.y" are unknown, and "leg.x" and "leg.y" are suggested.
            keys += differing if len(steps) > 1 and len(differing) == 1 else []
        same = next((known[key] for key in keys if key in known), None)
        if same is None:
            groups.append(same := [])
        same.append(diagnostic)
        for key in keys:
            known.setdefault(key, same)
    result: list[Diagnostic] = []
    for first, *rest in groups:  # errors of the same rule at the same position are separate mistakes: keep them
        separate = [other for other in rest if other.span == first.span and other.rule == first.rule]
        others = [other for other in rest if other not in separate]
        shown = [first.span, *(related.span for related in first.related)]
        notes = [note for other in others for note in other.related if note.message.endswith(UNNAMED)]
        new = {note.span: note for note in reversed(notes) if note.span not in shown}
        places = dict.fromkeys(other.span for other in others if other.span and other.span not in (*shown, *new))
        result += [replace(first, related=(*first.related, *new.values(), *and_here(list(places)))), *separate]
    return result


def move_to_name(diagnostic: Diagnostic, offered: Offer | None) -> Diagnostic:
    """Move an error to the related position that has the unknown name; list the old position as a related position."""
    span, related = diagnostic.span, diagnostic.related
    if span is None or offered is None:
        return diagnostic
    there = place_of_word([span, *(further.span for further in related)], offered.name, offered.meant)
    if there is None or there == span:
        return diagnostic
    return replace(diagnostic, span=there, related=(*(r for r in related if r.span != there), Related(USED, span)))


def place_of_word(spans: Iterable[Span | None], name: str, other: str) -> Span | None:
    """Return the first span at which the source has a word that is in ``name`` but not in ``other``, or None."""
    for span in filter(None, spans):
        text = span.source.line(span.line)[span.column - 1 :]
        depths = accumulate((letter in "[{") - (letter in "]}") for letter in text)
        # The text of a value in brackets ends at the closing bracket, or at the end of the line.
        end = next((at for at, depth in enumerate(depths) if depth == 0), len(text))
        words = re.findall(r"[\w-]+", text[: end or span.length])
        if any(word in name and word not in other for word in words):
            return span
    return None
