"""Described: what a reader gives as plain values, made the tree of a description and held against the rules.

A reader says what stands in its file as YAML would have it after includes, arguments and expressions; where it says no
place for a value (``Opened.at``), that of what holds it is taken.
"""

from __future__ import annotations

from collections.abc import Mapping
from numbers import Integral, Real
from typing import Any

from rosorin_compile.language.schema import Steps, subject, unit_at
from rosorin_compile.source.diagnostics import Span
from rosorin_compile.source.load import MAX_DEPTH
from rosorin_compile.source.plugins import diagnostic_of
from rosorin_compile.source.rule_registry import READING, Rule
from rosorin_compile.source.tree import Map, Seq
from rosorin_compile.source.units import Quantity
from rosorin_compile.source.xml.files import printable_name

from .checked import accept
from .format import Opened, Placed
from .imported import Imported, LeftOut

RULES = (
    Rule(
        "file-syntax",
        "A file is not written as its format wants; the reader of another package says so.",
        "Correct the place that is named.",
        READING,
    ),
)

_LARGEST = 10**18  # from here on, YAML's whole numbers are floats (see ``load``)


def imported(made: object, opened: Opened) -> Imported:
    """Return what comes of a file, whatever its reader gives: Imported, a description, or one with diagnostics.

    Raises TypeError for what is none of them.
    """
    if isinstance(made, Imported):
        if not (made.tree is None or isinstance(made.tree, Map)):
            raise TypeError(f"the tree of what is imported is a Map, not {type(made.tree).__name__}")
        return made._replace(diagnostics=[diagnostic_of(one) for one in made.diagnostics])
    description, said = made if isinstance(made, tuple) and len(made) == 2 else (made, ())
    diagnostics = list(said)
    for one in diagnostics:
        diagnostic_of(one)
    tree = as_tree(description, opened.source.start(), [])
    if not isinstance(tree, Map):
        raise TypeError(f"a reader gives a description, not {type(description).__name__}")
    name = printable_name(opened.path)
    for key, value in (("robot", opened.path.stem), ("source", {"status": "imported", "note": f"from {name}"})):
        if key not in tree:
            tree.put(key, as_tree(value, tree.span, [key]), tree.span, tree.span)
    left = [one for one in diagnostics if one.rule == "import-cannot-carry"]
    what = tuple(LeftOut(one.message.removesuffix(" is not carried over"), one.span or tree.span) for one in left)
    if not opened.options.checked:
        return Imported(tree, diagnostics, files=(opened.path,), left_out=what)
    accepted, told = accept(tree, opened.options.lenient)
    return Imported(accepted, [*diagnostics, *told], files=(opened.path,), left_out=what)


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
