"""Validate: the plain tree held against the JSON Schema. Shape, units and finite numbers; no meaning.

``Complaint`` tells what the validator has to say in the words of the description.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from functools import lru_cache
from typing import TYPE_CHECKING, Any

from ..diagnostics import Diagnostic, did_you_mean, error
from ..diagnostics.registry import ARGUMENTS, SHAPE, Rule
from ..units import UNITS, Dimension, Quantity, describe, parse_unit, unknown_unit
from .schema import Steps, resolve, schema_at, subject, unit_at, validator_of, with_outputs
from .tree import Map, Seq, locate

if TYPE_CHECKING:
    from ..formats import Format

RULES = (
    Rule(
        "wrong-unit",
        "A quantity is of another kind: a mass where a length belongs, metres for a joint that turns.",
        "Correct the unit, or the type of the joint.",
        SHAPE,
    ),
    Rule("not-finite", "A number is NaN or infinite.", "Write a number, or leave the key out.", SHAPE),
    Rule(
        "bad-name",
        "A name has a form that it may not have, such as `<` or a quote, or a space at its end.",
        "Letters, digits and `_` are safe. Spaces within and `/` are allowed; names of values and arguments are plain "
        "words.",
        ARGUMENTS,
    ),
    Rule(
        "unknown-key",
        "An entry has no such key.",
        "The message names the nearest one and all that are legal.",
        SHAPE,
    ),
    Rule("missing-key", "An entry lacks a key that it needs.", "Add it.", SHAPE),
    Rule(
        "wrong-type",
        "A value is of another type: a text where a number belongs, a unit that nobody knows.",
        "Write what the message asks for.",
        SHAPE,
    ),
    Rule("wrong-value", "A value is not one of those that are allowed.", "Choose one of them.", SHAPE),
    Rule("wrong-length", "A list has too many or too few items.", "Positions have three numbers, pairs two.", SHAPE),
    Rule("empty-text", "A text that says something is empty.", "Say it, or leave the key out.", SHAPE),
    Rule(
        "wrong-shape",
        "A value does not fit the schema in another way.",
        "Compare it with [the language](language.md#entries).",
        SHAPE,
    ),
)


def validate(tree: Map, formats: Mapping[str, Format]) -> list[Diagnostic]:
    """Return what is wrong with the shape of a tree, with the units of its quantities, and with its numbers.

    ``formats`` are those that outputs may name.
    """
    walk = _Walk()
    plain = walk.plain(tree)
    diagnostics = [walk.diagnostics_of(tree, path) for path in walk.not_finite]
    schema = with_outputs(plain.get("outputs"), formats)
    held = validator_of(schema)
    if not held.is_valid(plain):
        for problem in held.iter_errors(plain):
            diagnostics += Complaint(tree, problem, schema).diagnostics()
    for path, quantity in walk.misfits:
        diagnostics += _wrong_unit(tree, path, quantity)
    return diagnostics


class _Walk:
    """Turns the tree into values that the validator takes, and notes what it cannot see: quantities, NaN, infinity.

    A piece that needs no change is taken as it is, and a piece that stands in many places is walked once.
    """

    def __init__(self) -> None:
        self.path: Steps = []
        self.done: dict[int, Any] = {}
        self.not_finite: list[Steps] = []
        self.misfits: list[tuple[Steps, Quantity]] = []

    def plain(self, value: Map | Seq) -> Any:
        known = self.done.get(id(value))
        if known is None:
            known = self.done[id(value)] = self._walk(value)
        return known

    def _walk(self, value: Map | Seq) -> Any:
        changed: Any = None
        pairs: Any = value.items() if isinstance(value, Map) else enumerate(value)
        for key, item in pairs:
            kind = type(item)
            if kind is str or kind is bool or item is None:
                continue
            if kind is Map or kind is Seq:
                self.path.append(key)
                plain = self.plain(item)
                self.path.pop()
            else:
                plain = self._scalar(item, key)
            if plain is not item:
                if changed is None:
                    changed = dict(value) if isinstance(value, Map) else list(value)
                changed[key] = plain
        return value if changed is None else changed

    def _allowed(self, key: str | int) -> tuple[Dimension, ...] | None:
        """Return the dimensions that a number may have at a key of the piece that is walked; None for any."""
        # The names of entries and the indices of items make no difference.
        path = self.path
        where = (path[0], "*", *[0 if type(s) is int else s for s in path[2:]]) if len(path) > 1 else tuple(path)
        last = "*" if len(path) == 1 else 0 if type(key) is int else key
        return _dimensions((*where, last))

    def _scalar(self, item: Any, key: str | int) -> Any:
        if isinstance(item, Quantity):
            allowed = self._allowed(key)
            if allowed is not None and item.dimension not in allowed:
                self.misfits.append(([*self.path, key], item))
        if isinstance(item, float):
            if not math.isfinite(item):
                self.not_finite.append([*self.path, key])
                return 0.0
            return float(item) if isinstance(item, Quantity) else item
        if isinstance(item, int):
            return float(item) if abs(item) > 2**53 else item
        return str(item)

    def diagnostics_of(self, tree: Map, path: Steps) -> Diagnostic:
        place = locate(tree, path)
        message = f"{subject(path)} is not a finite number"
        return error("not-finite", message, place.span, "write a number, or leave the entry out", place.stack())


@lru_cache(maxsize=2_000)
def _dimensions(path: tuple[str | int, ...]) -> tuple[Dimension, ...] | None:
    """Return the dimensions that the schema allows at a path; None where it has no number, for others to judge."""
    wanted = unit_at(path)
    if wanted is None:
        return None
    units = [parse_unit(unit) for unit in ([wanted] if isinstance(wanted, str) else wanted)]
    return tuple(unit[1] for unit in units if unit is not None)


def _wrong_unit(tree: Map, path: Steps, quantity: Quantity) -> list[Diagnostic]:
    """Return an error: a quantity has another dimension than its place in the schema asks for."""
    place = locate(tree, path)
    named = " or ".join(describe(dimension) for dimension in _dimensions(tuple(path)) or ())
    text = quantity.text or f"{float(quantity):g}"
    message = f"{subject(path)} is {named or 'a plain number'}, but {text} is {describe(quantity.dimension)}"
    return [error("wrong-unit", message, place.span, "correct the unit; a bare number is in SI units", place.stack())]


# Sections that expansion has made plain entries of: the schema of the plain tree lacks them.
_EXPANDED = ("parts", "sensor_types", "use")


class Complaint:
    """One complaint of the validator, told in the words of the description."""

    def __init__(self, tree: Map, problem: Any, schema: Mapping[str, Any]) -> None:
        self.tree = tree
        self.schema = schema
        self.path: Steps = list(problem.instance_path)
        self.keyword = type(problem.kind).__name__
        self.kind = problem.kind
        self.schema_path: Steps = list(problem.schema_path)
        self.where = subject(self.path)
        node: Any = tree
        for step in self.path:
            node = node[step]
        self.value = node

    def diagnostics(self) -> list[Diagnostic]:
        method = getattr(self, f"_{self.keyword.lower()}", self._other)
        told: list[Diagnostic] = method()
        return told

    def _fragment(self, above: int) -> Any:
        """Return the fragment of the schema that complains, or one above it."""
        return schema_at(self.schema_path[: len(self.schema_path) - above], self.schema)

    def _make(
        self, rule: str, message: str, help: str = "", path: Steps | None = None, key: bool = False
    ) -> Diagnostic:
        place = locate(self.tree, self.path if path is None else path, key=key)
        return error(rule, message, place.span, help, place.stack())

    def _additionalproperties(self) -> list[Diagnostic]:
        known = self._fragment(1).get("properties", {})
        if not self.path:
            known = {**known, **dict.fromkeys(_EXPANDED)}
        return [
            self._make("unknown-key", f'{self.where} has no key "{key}"', _legal(key, known), [*self.path, key], True)
            for key in self.kind.unexpected
        ]

    def _required(self) -> list[Diagnostic]:
        key = self.kind.property
        wanted = schema_at([*self.schema_path[:-1], "properties", key], self.schema)
        meaning = wanted.get("description") or resolve(wanted).get("description", "")
        path = self.path
        return [self._make("missing-key", f'{self.where} needs the key "{key}"', _sentence(meaning), path, key=True)]

    def _type(self) -> list[Diagnostic]:
        types = self.kind.types
        wanted = " or ".join(_TYPES[name] for name in types if name != "null")
        expected = self._fragment(1)
        unit = expected.get("x-unit")
        if unit:
            wanted += f" ({unit if isinstance(unit, str) else ' or '.join(unit)})"
        help = _type_help(self.value, types, [unit] if isinstance(unit, str) else unit or [])
        return [self._make("wrong-type", f"{self.where} is {wanted}, not {_found(self.value)}", help)]

    def _enum(self) -> list[Diagnostic]:
        return [not_allowed(self.tree, self.path, self.value, self.kind.options)]

    def _constant(self) -> list[Diagnostic]:
        wanted = self._fragment(0)
        help = f"this tool knows only {wanted}"
        return [self._make("wrong-value", f"{self.where} cannot be {self.value}", help)]

    def _minitems(self) -> list[Diagnostic]:
        return [self._count(f"at least {self.kind.limit}")]

    def _maxitems(self) -> list[Diagnostic]:
        return [self._count(f"at most {self.kind.limit}")]

    def _count(self, wanted: str) -> Diagnostic:
        fragment = self._fragment(1)
        if fragment.get("minItems") == fragment.get("maxItems"):
            wanted = str(fragment.get("minItems"))
        message = f"{self.where} has {len(self.value)} items, not {wanted}"
        return self._make("wrong-length", message, _sentence(fragment.get("description", "")))

    def _minimum(self) -> list[Diagnostic]:
        return [self._make("wrong-value", f"{self.where} is {self.value}, less than {self.kind.limit}")]

    def _maximum(self) -> list[Diagnostic]:
        return [self._make("wrong-value", f"{self.where} is {self.value}, more than {self.kind.limit}")]

    def _pattern(self) -> list[Diagnostic]:
        help = _sentence(str(self._fragment(1).get("description", "")))
        return [self._make("bad-name", f'{self.where} cannot be "{self.value}"', help)]

    def _propertynames(self) -> list[Diagnostic]:
        name = self.kind.value.instance
        message = f'"{name}" cannot be a name in {self.where}'
        plain = self.schema_path[0] != "$defs"  # else it is the form that links and joints have
        help = "use letters, digits and _" if plain else "no markup, no quotes; spaces only within"
        return [self._make("bad-name", message, help, [*self.path, name], True)]

    def _minlength(self) -> list[Diagnostic]:
        return [self._make("empty-text", f"{self.where} is empty", "say something, or leave the key out")]

    def _dependentrequired(self) -> list[Diagnostic]:
        return [self._make("missing-key", f"{self.where} needs both min and max", "give both corners, or size")]

    def _minproperties(self) -> list[Diagnostic]:
        keys = ", ".join(self._fragment(1).get("properties", {}))
        return [self._make("missing-key", f"{self.where} is empty", f"legal keys: {keys}")]

    def _maxproperties(self) -> list[Diagnostic]:
        keys = ", ".join(self._fragment(1).get("properties", {}))
        return [self._make("wrong-value", f"{self.where} has more than one key", f"give one of {keys}")]

    def _other(self) -> list[Diagnostic]:
        return [self._make("wrong-shape", f"{self.where} does not fit the schema: {self.keyword}")]


def not_allowed(tree: Map, path: Steps, value: Any, options: Iterable[Any]) -> Diagnostic:
    """Return an error: the value at a path is not one of those that are allowed."""
    names = list(dict.fromkeys(map(str, options)))
    help = did_you_mean(str(value), names)
    if help.startswith("did"):
        help += f" (one of {', '.join(names)})"
    place = locate(tree, path)
    return error("wrong-value", f'{subject(path)} cannot be "{value}"', place.span, help, place.stack())


_TYPES = {
    "string": "text",
    "number": "a number",
    "integer": "a whole number",
    "boolean": "true or false",
    "object": "a mapping",
    "array": "a list",
}


def _legal(key: str, known: dict[str, Any]) -> str:
    help = did_you_mean(key, known)
    return help if not help.startswith("did") else f"{help} (legal: {', '.join(sorted(known))})"


def _sentence(text: str) -> str:
    return text[:1].lower() + text[1:].rstrip(".") if text else ""


def _found(value: Any) -> str:
    if value is None:
        return "empty"
    if isinstance(value, bool):
        return f"{str(value).lower()}"
    if isinstance(value, Quantity):
        return f"the quantity {value.text or float(value)}"
    if isinstance(value, (int, float)):
        return f"the number {value}"
    if isinstance(value, str):
        return f'the text "{value}"'
    return "a list" if isinstance(value, Seq) else "a mapping"


def _units_like(wanted: list[str]) -> list[str]:
    """Return the units of the dimensions that are wanted; all units if none has a name of its own."""
    dimensions = [unit[1] for unit in map(parse_unit, wanted) if unit is not None]
    return [name for name, (_, dimension) in UNITS.items() if dimension in dimensions] or list(UNITS)


def _type_help(value: Any, types: list[str], wanted: list[str]) -> str:
    if isinstance(value, str) and "number" in types:
        unit = unknown_unit(value)
        if unit:
            return f'there is no unit "{unit}"; {did_you_mean(unit, _units_like(wanted))}'
        return "write a number, a quantity such as 12.5 mm, or an expression ${...}"
    if isinstance(value, (int, float)) and types == ["string"]:
        return "put it in quotes to make it text"
    return ""
