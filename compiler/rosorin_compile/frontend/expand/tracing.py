"""Tracing: from a number in the evaluated tree back to the number that a person wrote.

``mass: ${m}`` in a part stands where the part does, and nobody looks there: who wrote the number wrote it behind
``with``, or under ``let``. Nothing is kept for this while a description is expanded; it is looked up once there is
something to say.
"""

from __future__ import annotations

from collections.abc import Iterator

from ...diagnostics import Span
from ...startup import TYPE_CHECKING, patterns
from ..expression import names_in, pieces
from ..tree import Instance, Map, Place, Seq
from .scope import Scope

if TYPE_CHECKING:
    from typing import Any

# A name alone, or an entry of a table or a list: ${m}, ${wheel.mass}, ${sizes[0]}.
_ONE = patterns.compile(r"([^\W\d]\w*)((?:\.[^\W\d]\w*|\[\d+\])*)\Z")
_STEP = patterns.compile(r"\.([^\W\d]\w*)|\[(\d+)\]")
MAX_STEPS = 20


def traced(root: Scope, span: Span, via: Instance | None) -> Span | None:
    """Return where the value at a place was written; None if it was written there.

    ``via`` tells how what holds the value came to be. A value that a part of another file calculates from what is
    given to it is that of the argument, or, of several, that of the entry of ``use``.
    """
    scope = _scope(root, via)
    found = _written(root, scope, span, MAX_STEPS)
    if found == span and _is_foreign(root, scope):
        outside = list(dict.fromkeys(_given(root, scope, span, MAX_STEPS)))
        use = _use(root, scope)
        found = outside[0] if len(outside) == 1 else use.span if use else span
    return None if found == span else found


def _scope(root: Scope, via: Instance | None) -> Scope:
    """Return the scope in which a value was evaluated that came by ``via``."""
    scopes: dict[int, Scope] = root.ledger.scopes
    while via is not None and id(via) not in scopes:
        via = via.parent
    return root if via is None else scopes[id(via)]


def _is_foreign(root: Scope, scope: Scope) -> bool:
    """Say whether a scope belongs to a file of parts, of the library or of another package."""
    while scope.parent is not None:
        scope = scope.parent
    return scope is not root


def _use(root: Scope, scope: Scope) -> Instance | None:
    """Return how the description itself came to use the part that a scope belongs to."""
    via = scope.via
    while via is not None and _is_foreign(root, _scope(root, via.parent)):
        via = via.parent
    return via


def _expressions(span: Span) -> list[str]:
    """Return the expressions in the scalar that is written at a place; none if it runs over several lines."""
    text = span.source.line(span.line)[span.column - 1 : span.column - 1 + span.length].strip("\"'")
    if not text.startswith("${"):
        return []
    found = list(pieces(text))
    return [] if any(piece.unclosed for piece in found) else [one.text.strip() for one in found if one.is_expression]


def _written(root: Scope, scope: Scope, span: Span, steps: int) -> Span:
    """Follow names that stand alone, to the last place that a person may have written a number at."""
    expressions = _expressions(span) if steps else []
    match = _ONE.match(expressions[0]) if len(expressions) == 1 else None
    further = _behind(root, scope, match[1], match[2]) if match else None
    if further is None:
        return span
    place, inside = further
    if _is_foreign(root, inside):  # a default of the part: what it says is no number of the description
        return span
    return _written(root, inside, place, steps - 1)


def _given(root: Scope, scope: Scope, span: Span, steps: int) -> Iterator[Span]:
    """Yield the places outside of its file that the expression of a part depends on."""
    for expression in _expressions(span) if steps else []:
        for name in names_in(expression):
            further = _behind(root, scope, name, "")
            if further is None or name in ("name", "mirrored"):  # what each part knows of its use: no number
                continue
            place, inside = further
            if _is_foreign(root, inside):
                yield from _given(root, inside, place, steps - 1)
            else:
                yield _written(root, inside, place, steps - 1)


def _behind(root: Scope, scope: Scope, name: str, keys: str) -> tuple[Span, Scope] | None:
    """Return where the value of a name was written, and the scope that its own expression was evaluated in."""
    owner: Scope | None = scope
    while owner is not None and name not in owner.places:
        owner = owner.parent
    if owner is None:
        return None
    place = owner.said.get(name, owner.places[name])
    inside = owner if name in owner.said else _outside(root, owner)
    value = owner.values.get(name)
    for key, index in _STEP.findall(keys):
        step: Any = key or int(index)
        if not ((isinstance(value, Map) and step in value) or (isinstance(value, Seq) and step in range(len(value)))):
            return None
        place = Place(value.value_spans[step], value.via)
        value = value[step]
    return place.span, inside


def _outside(root: Scope, owner: Scope) -> Scope:
    """Return the scope in which the arguments of a part were evaluated: that of its use."""
    return _scope(root, owner.via.parent) if owner.via else root
