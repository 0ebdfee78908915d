"""Misspelt names: an unknown name that a diagnostic offers another one for, told once however often it is used."""

from __future__ import annotations

import re
from collections.abc import Iterable
from dataclasses import replace
from typing import NamedTuple

from .diagnostics import ERROR, Diagnostic, Related, Span, and_here, order, swaps

# At the note to the definition that an unknown name is like, if nothing else is seen to name that.
UNNAMED = "is defined here, and may be what is misspelt"
USED = "used here"
_WORD = re.compile(r"[\w-]+")
_QUOTED = re.compile(r'"([^"]+)"')
_MEANT = re.compile(r'did you mean "([^"]+)"\?')
# Of these each is a mistake of its own, wherever it stands.
_OF_SHAPE = ("unknown-key", "wrong-value", "wrong-type", "wrong-unit", "unknown-option")


class Offer(NamedTuple):
    """A name that there is not, and the one that may be meant."""

    name: str
    meant: str


def offer(diagnostic: Diagnostic) -> Offer | None:
    """Return the name that an error is about and the one that it offers; None if it is about something else."""
    found = _MEANT.match(diagnostic.help) if diagnostic.severity == ERROR else None
    if found is None or diagnostic.rule in _OF_SHAPE:
        return None
    names = [name for name in _QUOTED.findall(diagnostic.message) if name != found[1]]
    return Offer(max(names, key=lambda name: _alike(name, found[1])), found[1]) if names else None


def _alike(one: str, other: str) -> tuple[bool, float]:
    import difflib

    return one in swaps(other), difflib.SequenceMatcher(None, one, other).ratio()


def told_once(diagnostics: Iterable[Diagnostic]) -> list[Diagnostic]:
    """Return the diagnostics; of those about one unknown name, or one definition that nothing names, the first.

    The places of the others become notes of that.
    """
    told: list[list[Diagnostic]] = []
    known: dict[object, list[Diagnostic]] = {}
    for diagnostic in sorted(diagnostics, key=order):
        keys = _keys(diagnostic)
        same = next((known[key] for key in keys if key in known), None)
        if same is None:
            told.append(same := [])
        same.append(diagnostic)
        for key in keys:
            known.setdefault(key, same)
    return [one for same in told for one in _first(same)]


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
    """Return the first of several diagnostics with the places of the others; those at its own place stay apart.

    These are of the uses of one part: ``arrange`` tells them together.
    """
    first = same[0]
    beside = [one for one in same[1:] if one.span == first.span and one.rule == first.rule]
    others = [one for one in same[1:] if one not in beside]
    told = [first.span, *(one.span for one in first.related)]
    notes = [one for other in others for one in other.related if one.message.endswith(UNNAMED)]
    new = {one.span: one for one in reversed(notes) if one.span not in told}
    places = dict.fromkeys(one.span for one in others if one.span is not None and one.span not in (*told, *new))
    return [replace(first, related=(*first.related, *new.values(), *and_here(list(places)))), *beside]


def placed(diagnostic: Diagnostic, offered: Offer) -> Diagnostic:
    """Return an error about an unknown name at the place, of those that led to it, where its letters were written."""
    span, related = diagnostic.span, diagnostic.related
    there = written([span, *(one.span for one in related)], offered.name, offered.meant)
    if span is None or there is None or there == span:
        return diagnostic
    related = (*(one for one in related if one.span != there), Related(USED, span))
    return replace(diagnostic, span=there, related=related)


def written(spans: Iterable[Span | None], name: str, other: str) -> Span | None:
    """Return the first of some places where a word stands that is in a name, and not in the other one."""
    for span in spans:
        if span is not None and any(word in name and word not in other for word in _WORD.findall(_text(span))):
            return span
    return None


def _text(span: Span) -> str:
    """Return what is written at a place: a word, or a list or a table as far as it stands in one line."""
    rest = span.source.line(span.line)[span.column - 1 :]
    if rest[:1] not in ("[", "{"):
        return rest[: span.length]
    depth = 0
    for at, letter in enumerate(rest):
        depth += (letter in "[{") - (letter in "]}")
        if depth == 0:
            return rest[:at]
    return rest
