"""Validate: the plain tree held against the JSON Schema. Shape, units and finite numbers; no meaning."""

from __future__ import annotations

import json
import math
from functools import cache
from typing import Any

from .data import data_folder
from .diagnostic import Diagnostic, did_you_mean, error
from .quantity import Quantity, describe, parse_unit, unknown_unit
from .tree import Map, Seq, locate

Steps = list[str | int]


@cache
def schema(name: str = "description") -> dict[str, Any]:
    """Return one of the schemas that ship with the tool."""
    path = data_folder("schemas") / f"{name}.schema.json"
    loaded: dict[str, Any] = json.loads(path.read_text("utf-8"))
    return loaded


@cache
def _validator(name: str = "description") -> Any:
    import jsonschema_rs

    return jsonschema_rs.Draft202012Validator(schema(name))


def misfits(name: str, value: Any) -> list[str]:
    """Return what of a JSON value does not fit one of the schemas that ship with the tool, a sentence each."""
    return [f"{subject(list(p.instance_path))}: {p.message}" for p in _validator(name).iter_errors(value)]


def validate(tree: Map) -> list[Diagnostic]:
    """Return what is wrong with the shape of a tree, with the units of its quantities, and with its numbers."""
    walk = _Walk()
    plain = walk.plain(tree)
    diagnostics = [walk.diagnostics_of(tree, path) for path in walk.not_finite]
    validator = _validator()
    if not validator.is_valid(plain):
        for problem in validator.iter_errors(plain):
            diagnostics += _Problem(tree, problem).diagnostics()
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


class _Problem:
    """One complaint of the validator, told in the words of the description."""

    def __init__(self, tree: Map, problem: Any) -> None:
        self.tree = tree
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
        found: list[Diagnostic] = method()
        return found

    def _make(
        self, rule: str, message: str, help: str = "", path: Steps | None = None, key: bool = False
    ) -> Diagnostic:
        place = locate(self.tree, self.path if path is None else path, key=key)
        return error(rule, message, place.span, help, place.stack())

    def _additionalproperties(self) -> list[Diagnostic]:
        known = _schema_at(self.schema_path[:-1]).get("properties", {})
        return [
            self._make("unknown-key", f'{self.where} has no key "{key}"', _legal(key, known), [*self.path, key], True)
            for key in self.kind.unexpected
        ]

    def _required(self) -> list[Diagnostic]:
        key = self.kind.property
        wanted = _schema_at([*self.schema_path[:-1], "properties", key])
        meaning = wanted.get("description") or _resolve(wanted).get("description", "")
        path = self.path
        return [self._make("missing-key", f'{self.where} needs the key "{key}"', _sentence(meaning), path, key=True)]

    def _type(self) -> list[Diagnostic]:
        types = self.kind.types
        wanted = " or ".join(_TYPES[name] for name in types if name != "null")
        expected = _schema_at(self.schema_path[:-1])
        unit = expected.get("x-unit")
        if unit:
            wanted += f" ({unit if isinstance(unit, str) else ' or '.join(unit)})"
        help = _type_help(self.value, types)
        return [self._make("wrong-type", f"{self.where} is {wanted}, not {_found(self.value)}", help)]

    def _enum(self) -> list[Diagnostic]:
        options = [str(option) for option in self.kind.options]
        help = did_you_mean(str(self.value), options)
        if help.startswith("did"):
            help += f" (one of {', '.join(options)})"
        return [self._make("wrong-value", f'{self.where} cannot be "{self.value}"', help)]

    def _constant(self) -> list[Diagnostic]:
        wanted = _schema_at(self.schema_path)
        help = f"this tool knows only {wanted}"
        return [self._make("wrong-value", f"{self.where} cannot be {self.value}", help)]

    def _minitems(self) -> list[Diagnostic]:
        return [self._count(f"at least {self.kind.limit}")]

    def _maxitems(self) -> list[Diagnostic]:
        return [self._count(f"at most {self.kind.limit}")]

    def _count(self, wanted: str) -> Diagnostic:
        fragment = _schema_at(self.schema_path[:-1])
        if fragment.get("minItems") == fragment.get("maxItems"):
            wanted = str(fragment.get("minItems"))
        message = f"{self.where} has {len(self.value)} items, not {wanted}"
        return self._make("wrong-length", message, _sentence(fragment.get("description", "")))

    def _pattern(self) -> list[Diagnostic]:
        return [self._make("bad-name", f'{self.where} cannot be "{self.value}"', _pattern_help(self.schema_path))]

    def _propertynames(self) -> list[Diagnostic]:
        name = self.kind.value.instance
        message = f'"{name}" cannot be a name in {self.where}'
        return [self._make("bad-name", message, "use letters, digits and _ without spaces", [*self.path, name], True)]

    def _minlength(self) -> list[Diagnostic]:
        return [self._make("empty-text", f"{self.where} is empty", "say something, or leave the key out")]

    def _dependentrequired(self) -> list[Diagnostic]:
        return [self._make("missing-key", f"{self.where} needs both min and max", "give both corners, or size")]

    def _minproperties(self) -> list[Diagnostic]:
        keys = ", ".join(_schema_at(self.schema_path[:-1]).get("properties", {}))
        return [self._make("missing-key", f"{self.where} is empty", f"legal keys: {keys}")]

    def _maxproperties(self) -> list[Diagnostic]:
        keys = ", ".join(_schema_at(self.schema_path[:-1]).get("properties", {}))
        return [self._make("wrong-value", f"{self.where} has more than one key", f"give one of {keys}")]

    def _other(self) -> list[Diagnostic]:
        return [self._make("wrong-shape", f"{self.where} does not fit the schema: {self.keyword}")]


_TYPES = {
    "string": "text",
    "number": "a number",
    "integer": "a whole number",
    "boolean": "true or false",
    "object": "a mapping",
    "array": "a list",
}

_ENTRIES = {
    "links": "link",
    "joints": "joint",
    "sensors": "sensor",
    "publishers": "publisher",
    "servos": "servo group",
    "poses": "pose",
    "outputs": "output",
    "args": "argument",
    "modes": "mode",
}


def subject(path: Steps) -> str:
    """Return a path in words: ``joint "joint1" limit lower``.

    >>> subject(["joints", "joint1", "xyz", 2])
    'joint "joint1" xyz[2]'
    """
    if not path:
        return "the description"
    words: str = str(path[0])
    rest = path[1:]
    if path[0] in _ENTRIES and rest:
        words, rest = f'{_ENTRIES[str(path[0])]} "{rest[0]}"', rest[1:]
    for step in rest:
        words += f"[{step}]" if isinstance(step, int) else f" {step}"
    return words


def _schema_at(path: Steps) -> Any:
    """Return the fragment of the schema at a path of the schema; an empty one if the path does not exist."""
    node: Any = schema()
    for step in path:
        if isinstance(node, dict):
            node = node.get(str(step), {})
        elif isinstance(node, list) and isinstance(step, int):
            node = node[step]
    return node


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


def _type_help(value: Any, types: list[str]) -> str:
    if isinstance(value, str) and "number" in types:
        unit = unknown_unit(value)
        if unit:
            from .quantity import UNITS

            return f'there is no unit "{unit}"; {did_you_mean(unit, UNITS)}'
        return "write a number, a quantity such as 12.5 mm, or an expression ${...}"
    if isinstance(value, (int, float)) and types == ["string"]:
        return "put it in quotes to make it text"
    return ""


def _pattern_help(path: Steps) -> str:
    fragment = _schema_at(path[:-1])
    return _sentence(str(fragment.get("description", "")))


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


def unit_at(path: Steps) -> str | list[str] | None:
    """Return the unit (or units) that the schema asks for at a path of a description; "" for a plain number.

    None where the schema has no number at all.
    """
    node: Any = schema()
    for step in path:
        node = _resolve(node)
        if isinstance(step, int):
            node = node.get("items")
        else:
            node = node.get("properties", {}).get(step, node.get("additionalProperties"))
        if not isinstance(node, dict):
            return None
    node = _resolve(node)
    if node.get("type") not in ("number", "integer"):
        return None
    unit: str | list[str] = node.get("x-unit", "")
    return unit


def _resolve(node: dict[str, Any]) -> dict[str, Any]:
    reference = node.get("$ref")
    return schema()["$defs"][reference.rsplit("/", 1)[1]] if reference else node
