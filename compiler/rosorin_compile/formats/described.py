"""Convert the plain values that a reader returns into the tree of a description.

A reader returns what YAML would have after includes, arguments and expressions. A value without a place of its own
(``Opened.at``) has that of the value that contains it.
"""

from __future__ import annotations

from collections.abc import Mapping
from numbers import Integral, Real
from typing import Any

from rosorin_compile.language.annotations import Steps
from rosorin_compile.language.schema import subject, unit_at
from rosorin_compile.source.diagnostics import Span
from rosorin_compile.source.load import MAX_DEPTH
from rosorin_compile.source.tree import Map, Seq
from rosorin_compile.source.units import Quantity

from .format import Placed

_LARGEST = 10**18  # from here on, YAML's whole numbers are floats (see ``load``)


def as_tree(value: Any, span: Span, path: Steps | None = None) -> Any:
    """Return a plain value as a tree; what has no place of its own is at ``span``. Raises TypeError."""
    path = path or []
    if isinstance(value, Placed):
        return as_tree(value.value, value.span, path)
    if len(path) > MAX_DEPTH:
        raise TypeError(f"{subject(path[:3])} is nested deeper than {MAX_DEPTH} levels")
    if isinstance(value, Mapping):
        tree = Map(span)
        for key, item in value.items():
            if not isinstance(key, str):
                raise TypeError(f"{subject(path)} has a key that is no text: {key!r}")
            place = item.span if isinstance(item, Placed) else span
            tree.put(str(key), as_tree(item, span, [*path, key]), place, place)
        return tree
    if isinstance(value, (list, tuple)):
        items = Seq(span)
        for index, item in enumerate(value):
            place = item.span if isinstance(item, Placed) else span
            items.put(as_tree(item, span, [*path, index]), place)
        return items
    return _scalar(value, path)


def _scalar(value: Any, path: Steps) -> Any:
    """Return a scalar; text that stands for a number may have a unit, as in YAML. Raises TypeError."""
    if isinstance(value, str):
        quantity = Quantity.parse(value) if unit_at(path) is not None else None
        return str(value) if quantity is None else quantity
    if value is None or isinstance(value, (bool, float)):
        return value
    if isinstance(value, Integral) and abs(int(value)) < _LARGEST:
        return int(value)
    if isinstance(value, Real):
        return float(value)
    raise TypeError(f"{subject(path)} is of the type {type(value).__name__}, which no description holds")
