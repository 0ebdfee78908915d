"""Loops: the rounds of a ``for``, each a scope of its own in which the names of the loop have their values."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any

from ..tree import Instance, Map, Place
from .ledger import Failed
from .telling import short

if TYPE_CHECKING:
    from .scope import Scope


def rounds(outer: Scope, item: Map) -> Iterator[Scope]:
    """Yield a scope for each round of a ``for``; several names are nested loops, the last one fastest.

    Without a ``for`` that is the scope around it, once. Raises Failed after reporting.
    """
    loops = item.get("for")
    if loops is None:
        yield outer
        return
    via = outer.via or item.via
    place = Place(item.value_spans["for"], via)
    if not isinstance(loops, Map) or not loops:
        help = "write for: {side: [left, right]}"
        outer.report("wrong-type", "for maps a name to the values that it takes", place, help)
        raise Failed
    scopes = [outer]
    for name, values in loops.items():
        where = Place(loops.value_spans[name], via)
        inner_scopes: list[Scope] = []
        counted = 0
        for scope in scopes:
            given = _values(scope, values, where)
            if len(given) > counted:  # as if every round had as many, so that a huge product is refused at once
                outer.count((len(given) - counted) * len(scopes), where.span, where.via)
                counted = len(given)
            for value in given:
                made = Instance(f"{name} = {short(value)}", where.span, scope.via or via, made=True)
                inner = scope.inner(made)
                _bind(inner, name, value, where)
                inner_scopes.append(inner)
        scopes = inner_scopes
    yield from scopes


def _values(scope: Scope, values: Any, place: Place) -> Sequence[Any]:
    """Return what a loop runs over: a list; for a table its keys."""
    found = scope.resolve(values, place)
    if isinstance(found, Mapping):
        return list(found)
    if isinstance(found, list):
        return found
    scope.report("wrong-type", "a loop runs over a list or a table", place, "write a list, or ${range(4)}")
    raise Failed


def _bind(scope: Scope, names: str, value: Any, place: Place) -> None:
    """Bind the name of a loop; ``key, value`` names take a row apart."""
    split = [name.strip() for name in names.split(",")]
    if len(split) == 1:
        scope.bind(split[0], value, place)
        return
    if not isinstance(value, list) or len(value) != len(split):
        scope.report("wrong-type", f"a turn of this loop does not give {len(split)} values", place, "")
        raise Failed
    for name, item in zip(split, value, strict=True):
        scope.bind(name, item, place)
