"""Validate: the plain tree held against the JSON Schema. Shape, units and finite numbers; no meaning."""

from __future__ import annotations

import math
from typing import Any

from .complaints import Complaint
from .diagnostic import Diagnostic, error
from .quantity import Quantity, describe, parse_unit
from .schema import Steps, subject, unit_at, validator
from .tree import Map, Seq, locate


def validate(tree: Map) -> list[Diagnostic]:
    """Return what is wrong with the shape of a tree, with the units of its quantities, and with its numbers."""
    walk = _Walk()
    plain = walk.plain(tree)
    diagnostics = [walk.diagnostics_of(tree, path) for path in walk.not_finite]
    held = validator()
    if not held.is_valid(plain):
        for problem in held.iter_errors(plain):
            diagnostics += Complaint(tree, problem).diagnostics()
    for path, quantity in walk.quantities:
        diagnostics += _check_unit(tree, path, quantity)
    return diagnostics


class _Walk:
    """Copies the tree into plain values and notes what the validator cannot see."""

    def __init__(self) -> None:
        self.path: Steps = []
        self.not_finite: list[Steps] = []
        self.quantities: list[tuple[Steps, Quantity]] = []

    def plain(self, value: Any) -> Any:
        kind = type(value)
        if kind is Map:
            made = {}
            for key, item in value.items():
                self.path.append(key)
                made[key] = self.plain(item)
                self.path.pop()
            return made
        if kind is Seq:
            items = []
            for index, item in enumerate(value):
                self.path.append(index)
                items.append(self.plain(item))
                self.path.pop()
            return items
        if kind is float or kind is Quantity:
            return self._number(value)
        if kind is int and abs(value) > 2**53:
            return float(value)
        return str(value) if isinstance(value, str) else value

    def _number(self, value: float) -> float:
        if isinstance(value, Quantity):
            self.quantities.append((list(self.path), value))
        if not math.isfinite(value):
            self.not_finite.append(list(self.path))
            return 0.0
        return float(value)

    def diagnostics_of(self, tree: Map, path: Steps) -> Diagnostic:
        place = locate(tree, path)
        message = f"{subject(path)} is not a finite number"
        return error("not-finite", message, place.span, "write a number, or leave the entry out", place.stack())


def _check_unit(tree: Map, path: Steps, quantity: Quantity) -> list[Diagnostic]:
    """Return an error if a quantity has another dimension than its place in the schema asks for."""
    wanted = unit_at(path)
    if wanted is None:
        return []
    units = [wanted] if isinstance(wanted, str) else wanted
    found = [parse_unit(unit) for unit in units]
    if any(unit is not None and unit[1] == quantity.dimension for unit in found):
        return []
    place = locate(tree, path)
    named = " or ".join(describe(unit[1]) for unit in found if unit is not None) or "a plain number"
    text = quantity.text or f"{float(quantity):g}"
    message = f"{subject(path)} is {named}, but {text} is {describe(quantity.dimension)}"
    return [error("wrong-unit", message, place.span, "correct the unit; a bare number is in SI units", place.stack())]
