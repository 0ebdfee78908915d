"""Telling: where in a scalar an expression stands, what is wrong with it, and values in a few letters."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from ..diagnostic import MAX_LISTED, Span, did_you_mean, nearest
from ..expression.functions import BUILT_IN, CONSTANTS, ExpressionError, functions
from ..expression.interpolation import Piece
from ..quantity import UNITS
from ..tree import Instance, Place, Seq
from ..wording import first_of


def explained(problem: ExpressionError, piece: Piece, text: str, place: Place, known: set[str]) -> tuple[Place, str]:
    """Return where in the text at ``place`` an expression is wrong, and the way out; ``known`` are names in scope."""
    help = problem.help
    if problem.unknown.endswith("()"):
        help = did_you_mean(problem.unknown[:-2], {*functions(), *(one.name for one in BUILT_IN)})
    elif problem.unknown:
        close, names = nearest(problem.unknown, {*known, *CONSTANTS, *UNITS}), first_of(sorted(known), MAX_LISTED)
        help = f'did you mean "{close}"?' if close else f"known here: {names}" if names else "name it in let"
    where = shifted(place, text, piece.offset + 2)
    if "\n" not in piece.text and where.span != place.span:
        indent = len(piece.text) - len(piece.text.lstrip())
        column = where.span.column + indent + max(0, problem.column)
        where = Place(where.span._replace(column=column, length=1), where.via)
    return where, help


def short(value: Any) -> str:
    """Return the value of a loop's round in a few letters."""
    if isinstance(value, list) and not any(isinstance(item, (list, Mapping)) for item in value):
        return ", ".join(map(str, value))[:40]
    if isinstance(value, (list, Mapping)):
        return f"{type(value).__name__.lower().replace('seq', 'a list').replace('map', 'a table')} of {len(value)}"
    return str(value)[:40]


def as_tree(value: list[Any], span: Span, via: Instance | None) -> Seq:
    """Return a list made by an expression as a Seq, so that its items have a place."""
    if isinstance(value, Seq):
        return value
    made = Seq(span, via)
    for item in value:
        made.put(as_tree(item, span, via) if type(item) is list else item, span)
    return made


def shifted(place: Place, text: str, offset: int) -> Place:
    """Return the place of a character within a scalar; the start of the scalar where it runs over several lines."""
    span = place.span
    if span.length < len(text):
        return place
    first = span.source.line(span.line)[span.column - 1 : span.column]
    quote = 1 if first in ("'", '"') and not text.startswith(first) else 0
    length = max(1, span.length - quote - offset)
    return Place(span._replace(column=span.column + quote + offset, length=length), place.via)
