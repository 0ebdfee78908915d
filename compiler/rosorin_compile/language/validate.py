"""Validate the expanded tree against the JSON Schema: structure, units and finite numbers; rules check the rest."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping
from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING, Any

from rosorin_compile.source.diagnostics import Diagnostic
from rosorin_compile.source.tree import Map, Seq, value_at
from rosorin_compile.source.units import Dimension, Quantity, describe, parse_unit
from rosorin_compile.source.wording import count_of, hidden_letter, in_words, suggest, swaps

from . import suggestions
from .annotations import Misfit, misfits_of, validator_of
from .expand.provenance import problem_at
from .schema import Steps, backend_of, part_at, resolve, subject, unit_at, with_outputs

if TYPE_CHECKING:
    from rosorin_compile.formats import Format

    from .expand.scope import Scope


_validators: dict[tuple[Any, ...], tuple[dict[str, Any], Any]] = {}  # schema and validator by options of the outputs
_MOST_VALIDATORS = 100
MOST = 1e150  # with larger sizes, the volume or inertia of a body may overflow


def validate(tree: Map, formats: Mapping[str, Format], scope: Scope | None = None) -> list[Diagnostic]:
    """Validate the structure, units and numbers of a tree, and return diagnostics.

    ``formats`` are the output formats by name. With ``scope``, errors are reported at the arguments that cause them.
    """
    walk = _Walk(tree, formats)
    walk.through(tree)
    diagnostics = []
    for path, value in walk.not_finite:
        too_large = f"is {value:g}, and nothing can be calculated with more than {MOST:g}"
        message = f"{subject(path)} {too_large if math.isfinite(value) else 'is not a finite number'}"
        help = "write a finite number, or remove the key"
        diagnostics.append(problem_at(scope, tree, path, "not-finite", message, help))
    reported = {tuple(path) for path in (*(one[0] for one in walk.misfits), *(one[0] for one in walk.not_finite))}
    schema = with_outputs(tree.get("outputs"), formats)
    options = schema["properties"]["outputs"].get("properties", {})
    # Options of a format are never freed, so id() is a valid cache key.
    key = tuple((name, *map(id, one["properties"].values())) for name, one in options.items())
    if key not in _validators:
        if len(_validators) >= _MOST_VALIDATORS:
            _validators.clear()
        _validators[key] = schema, validator_of(schema)
    schema, validator = _validators[key]
    for misfit in misfits_of(validator, tree):
        if tuple(misfit.path) not in reported:
            diagnostics += _Report(tree, misfit, schema, scope).diagnostics()
    for path, quantity, allowed in walk.misfits:
        named = " or ".join(map(describe, allowed)) or "a plain number"
        text = quantity.text or f"{float(quantity):g}"
        message = f"{subject(path)} must be {named}, but {text} is {describe(quantity.dimension)}"
        has_unit = any(map(any, allowed))
        help = "correct the unit; a bare number is in SI units" if has_unit else "write the number without a unit"
        diagnostics.append(problem_at(scope, tree, path, "wrong-unit", message, help))
    return diagnostics


_Dimensions = tuple[Dimension, ...]


class _Walk:
    """Find errors that JSON Schema cannot express: wrong dimensions, NaN, infinity. Visit shared values only once."""

    def __init__(self, tree: Map, formats: Mapping[str, Format]) -> None:
        self.tree, self.formats = tree, formats
        self.path: Steps = []
        self.done: set[int] = set()
        self.not_finite: list[tuple[Steps, float]] = []
        self.misfits: list[tuple[Steps, Quantity, _Dimensions]] = []

    def through(self, value: Map | Seq) -> None:
        before = len(self.not_finite) + len(self.misfits)
        allowed: dict[str | int, _Dimensions | None] = {}
        for key, item in value.items() if isinstance(value, Map) else enumerate(value):
            kind = type(item)
            if kind is str or kind is bool or item is None or (kind is float and -MOST <= item <= MOST):
                continue
            if kind is Map or kind is Seq:
                if id(item) not in self.done:
                    self.path.append(key)
                    self.through(item)
                    self.path.pop()
                continue
            steps = [*self.path, key]
            if kind is Quantity:
                step = 0 if type(key) is int else key  # all items of a list have the same schema
                if step not in allowed:
                    allowed[step] = self._allowed((*self.path, step))
                dimensions = allowed[step]
                if dimensions is not None and item.dimension not in dimensions:
                    self.misfits.append((steps, item, dimensions))
            # Limits and masses may exceed MOST: imported limits may be 1.8e308, and a rule checks masses.
            is_free = "limit" in steps or key == "mass"
            if isinstance(item, float) and not -MOST <= item <= MOST and not (math.isfinite(item) and is_free):
                self.not_finite.append((steps, float(item)))
        sound = before == len(self.not_finite) + len(self.misfits)
        if sound or value.via is None or not value.via.made:  # an error in a part is reported for each use of the part
            self.done.add(id(value))

    def _allowed(self, path: tuple[str | int, ...]) -> _Dimensions | None:
        if path[0] == "outputs" and len(path) == 3:
            entry = self.tree["outputs"][path[1]]
            format = self.formats.get(str(entry.get("backend", backend_of(str(path[1]), entry))))
            option = format.options.get(str(path[2]), {}) if format is not None else {}
            unit = parse_unit(option.get("x-unit", "")) if option.get("type") in ("number", "integer") else None
            return None if unit is None else (unit[1],)
        units = unit_at(path)
        parsed = [parse_unit(unit) for unit in ([units] if isinstance(units, str) else units or ())]
        return None if units is None else tuple(unit[1] for unit in parsed if unit is not None)


# Sections that expansion removes, so that they are not in the schema of the expanded tree.
_EXPANDED = ("parts", "sensor_types", "use")
_SIGNS = {"&": "an anchor", "#": "a comment", "!": "a tag"}
_TYPES = {"string": "text", "number": "a number", "integer": "a whole number", "boolean": "true or false"}
_TYPES |= {"object": "a mapping", "array": "a list"}
# (rule, message) by JSON Schema keyword, for errors that need no help text.
_SIMPLE = {
    "minimum": ("wrong-value", "{where} is {value}, but must be at least {wanted}"),
    "maximum": ("wrong-value", "{where} is {value}, but must be at most {wanted}"),
    "exclusiveMinimum": ("wrong-value", "{where} is {value}, but must be more than {wanted}"),
    "exclusiveMaximum": ("wrong-value", "{where} is {value}, but must be less than {wanted}"),
    "multipleOf": ("wrong-value", "{where} is {value}, not a multiple of {wanted}"),
    "uniqueItems": ("wrong-value", "{where} has an item twice"),
    "minLength": ("wrong-value", "{where} is shorter than {wanted} letters"),
    "maxLength": ("wrong-value", "{where} is longer than {wanted} letters"),
    "minProperties": ("missing-key", "{where} is empty: write one of {keys}"),
    "maxProperties": ("wrong-value", "{where} has more than one key: write one of {keys}"),
    "const": ("wrong-value", "{where} is {value}, but the newest known version is {wanted}: update rosorin-compile"),
    "pattern": ("bad-name", '{where} cannot be "{value}"'),
}


class _Report:
    def __init__(self, tree: Map, misfit: Misfit, schema: Mapping[str, Any], scope: Scope | None) -> None:
        self.tree, self.misfit, self.scope = tree, misfit, scope
        self.path, self.where = misfit.path, subject(misfit.path)
        self.part, self.defined = part_at(misfit.schema_path[:-1], schema)
        self.kind = (self.defined or str(self.path[0])) if self.path else "top"
        self.value = value_at(tree, tuple(self.path))

    def diagnostics(self) -> list[Diagnostic]:
        wanted, where, value, keyword = self.misfit.wanted, self.where, self.value, self.misfit.keyword
        meaning = _sentence(str(self.part.get("description", "")))
        if "propertyNames" in self.misfit.schema_path[-2:-1]:
            name = str(self.misfit.value)
            message = f'"{name}" is not a valid name in {where}'
            return self._make("bad-name", message, self._name_help(name), [*self.path, name], True)
        methods = dict.fromkeys(("required", "dependencies"), self._missing_key)
        methods |= {"type": self._wrong_type, "additionalProperties": self._unknown_keys}
        if keyword in methods:
            return methods[keyword]()
        if keyword in ("minItems", "maxItems"):
            bound = "at least " if keyword == "minItems" else "at most "
            bound = "" if self.part.get("minItems") == self.part.get("maxItems") else bound
            message = f"{where} has {count_of(len(value), 'item')}, not {bound}{wanted}"
            right = f"write {bound}{count_of(wanted, 'item')}{f': {meaning}' if meaning else ''}"
            return self._make("wrong-length", message, lambda: suggestions.items_meant(value, self.part) or right)
        if keyword == "minLength" and not value:
            return self._make("empty-text", f"{where} is empty", "write some text, or remove the key")
        if keyword == "enum":
            kinds = {"joint": "joint type", "source": "status"}
            kind = "which gazebo" if self.path[-1] == "gazebo" else kinds.get(self.kind, "")
            return [not_allowed(self.tree, self.path, value, wanted, kind, self.scope)]
        rule, message = _SIMPLE.get(keyword, ("wrong-shape", f"{{where}} does not fit the schema: {keyword}"))
        keys = ", ".join(self.part.get("properties", {}))
        message = message.format(where=where, value=value, wanted=wanted, keys=keys)
        if keyword in ("minimum", "maximum", "minProperties", "maxProperties", "const"):  # the message is sufficient
            meaning = ""
        return self._make(rule, message, (self._name_help(str(value)) if keyword == "pattern" else "") or meaning)

    def _name_help(self, name: str) -> str:
        odd = hidden_letter(name) or next((letter for letter in name if letter.isspace() and letter not in " \n\t"), "")
        return f"it contains {in_words(odd)}: type the name again" if odd else str(self.part.get("x-form", ""))

    def _make(
        self, rule: str, message: str, help: str | Callable[[], str] = "", path: Steps | None = None, key: bool = False
    ) -> list[Diagnostic]:
        problem = problem_at(self.scope, self.tree, path or self.path, rule, message, key=key)
        return [replace(problem, help=help) if isinstance(help, str) else replace(problem, suggest=help)]

    def _unknown_keys(self) -> list[Diagnostic]:
        known = self.part.get("properties", {})
        if not self.path:
            known = {**known, **dict.fromkeys(_EXPANDED)}
        unexpected = dict.fromkeys(self.misfit.unexpected_keys())
        tails, found = suggestions.text_tails(self.value, unexpected), list[Diagnostic]()
        for key in (key for key in unexpected if key not in tails):
            help = partial(suggestions.key_meant, key, self.value, known, self.kind, self.path)
            found += self._make("unknown-key", f'{self.where} has no key "{key}"', help, [*self.path, key], True)
        return found

    def _missing_key(self) -> list[Diagnostic]:
        key = self.misfit.key
        legal = self.part.get("properties", {})
        meant = [one for one in self.value if one not in legal and suggestions.is_meant(one, key, self.kind, legal)]
        if key == "inertia" and any("of" in swaps(other) for other in self.value):
            return []  # the unknown key is reported instead
        if meant and self.path[:1] != ["outputs"]:
            return []  # the misspelled key is reported instead
        if meant and key in swaps(meant[0]):  # outputs: other keys are only valid for some formats
            message = f'{self.where} has no key "{meant[0]}"'
            return self._make("unknown-key", message, suggest(key), [*self.path, meant[0]], True)
        help = _sentence({**resolve(legal.get(key, {})), **legal.get(key, {})}.get("description", ""))
        if key == "inertia":
            help = 'write ixx, iyy and izz, or "of: collision" next to "mass" to calculate them from the shapes'
        help = help if key == "inertia" else f'add "{key}"{help and f": {help}"}'
        return self._make("missing-key", f'{self.where} needs the key "{key}"', help, self.path, key=True)

    def _wrong_type(self) -> list[Diagnostic]:
        types, unit = self.misfit.kinds(), self.part.get("x-unit") or []
        units = [unit] if isinstance(unit, str) else unit
        *others, last = [_TYPES[name] for name in types if name != "null"]
        wanted = f"{', '.join(others)} or {last}" if others else last
        wanted += f" ({' or '.join(filter(None, units))})" if units else ""
        parent = value_at(self.tree, tuple(self.path[:-1]))
        is_only = isinstance(parent, Seq) and len(parent) == 1 and "number" in types
        if is_only and isinstance(self.value, str) and len(suggestions.numbers_in(self.value)) > 1:
            return []  # the length of the list is reported instead
        fallen = suggestions.fallen_out(self.tree, self.path, self.part)
        if fallen and not (fallen[1] and "null" in types):
            return []
        help: str | Callable[[], str] = partial(self._type_help, types, units)
        if fallen:
            help = f'"{self.path[-1]}" is a key, not the name of an entry: indent it below "{fallen[0]}"'
        return self._make("wrong-type", f"{self.where} must be {wanted}, not {_found(self.value)}", help)

    def _type_help(self, types: list[str], units: list[str]) -> str:
        value, key = self.value, next((str(step) for step in reversed(self.path) if isinstance(step, str)), "")
        is_number = not {"number", "integer"}.isdisjoint(types)
        if value is None:
            span = self.tree.locate(self.path).span
            sign = span.source.line(span.line)[span.column - 1 :].lstrip()[:1]
            if sign in _SIGNS:
                return f'"{sign}" begins {_SIGNS[sign]} here: put the text in quotes'
        if is_number and isinstance(value, str):
            return suggestions.number_meant(value, units, key)
        if "integer" in types and isinstance(value, Quantity):
            return f"write {float(value):g}: a plain number, without a unit"
        if "number" in types and isinstance(value, (Map, Seq)) and len(value) == 1:
            inner = value[0] if isinstance(value, Seq) else next(iter(value.values()))
            if isinstance(value, Map) and inner is None:
                return f'write "${{{next(iter(value))}}}" with the quotes to use a named value'
            if isinstance(inner, (int, float)):
                return f'write "{key}: {suggestions.format_scalar(inner)}"'
        if "array" in types:
            return suggestions.list_meant(value, key, self.part)
        if "object" in types:
            return suggestions.mapping_meant(value, self.part)
        if value is None and is_number:
            return "write the number after the colon, or remove the key"
        if types == ["boolean"]:
            return suggestions.flag_meant(value) or "write true or false"
        if "string" not in types:
            return ""
        if isinstance(value, (bool, int, float)):
            return "put it in quotes to make it text"
        is_element = isinstance(value, Map) and self.defined == "element"
        return 'write the element as XML text: "- <NAME .../>"' if is_element else f'write "{key}: NAME"'


def not_allowed(
    tree: Map, path: Steps, value: Any, options: Iterable[Any], kind: str = "", scope: Scope | None = None
) -> Diagnostic:
    """Return the error for a value that is not one of the allowed ``options``; ``kind`` selects the synonyms."""
    allowed = list(options)
    names = list(dict.fromkeys(str(one).lower() if isinstance(one, bool) else str(one) for one in allowed))
    if isinstance(value, bool) and str(value).lower() in allowed:
        message = f"{subject(path)} cannot be the boolean {str(value).lower()}"
        help = f'write "{str(value).lower()}" with the quotes: here it is text, not a boolean'
        return problem_at(scope, tree, path, "wrong-value", message, help)

    def suggest() -> str:
        if isinstance(value, str) and value in names:  # true is a boolean, "true" is a string
            return f"write {value} without quotes"
        help = suggestions.word_meant(str(value), names, kind)
        if isinstance(value, str) and "true" in names:
            help = suggestions.flag_meant(value) or help
        return f"{help} (possible values: {', '.join(names)})" if help[:5] != "known" else f"possible values{help[5:]}"

    error = problem_at(scope, tree, path, "wrong-value", f'{subject(path)} cannot be "{value}"')
    return replace(error, suggest=suggest)


def _sentence(text: str) -> str:
    return text[:1].lower() + text[1:].rstrip(".")


def _found(value: Any) -> str:
    if value is None or isinstance(value, bool):
        return "empty" if value is None else str(value).lower()
    if isinstance(value, (int, float)):
        return f"the quantity {value.text or float(value)}" if isinstance(value, Quantity) else f"the number {value}"
    return f'the text "{value}"' if isinstance(value, str) else "a list" if isinstance(value, Seq) else "a mapping"
