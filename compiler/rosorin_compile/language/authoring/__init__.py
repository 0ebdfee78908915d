"""The authoring schema: the schema of descriptions as they are written, for completion and help in editors.

It is made from the schema of the plain tree, in which every expression is a value already, so that it cannot fall
behind. While a description is written, a number may also be a quantity or an expression, a name may hold expressions,
an entry may have a loop and a condition, and there are parts, their uses, named values, types of sensors (``added``).
That of this version stands in ``schemas``; with the sections of plug-ins it is made when somebody asks for it.
JSON Schema draft 7: the draft that every editor understands.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from .added import added_definitions, added_sections
from .added import definitions as plain_definitions

if TYPE_CHECKING:
    from ..language import Language

Schema = dict[str, Any]

WHOLE = r"^\$\{[\s\S]*\}$"  # text that is one expression, so that it has the type of its value
SOME = r"\$\{"  # text with an expression in it
_NUMBER = r"^[-+]?(\d+\.?\d*|\.\d+)([eE][-+]?\d+)?\s*"
_CLOSED = ("rosorin_compile", "args", "modes", "include")  # taken as they stand, never evaluated
_INNER = ("items", "additionalProperties", "propertyNames", "not", "if", "then", "else")
_SAME = ("description", "title", "default", "const", "minLength", "minItems", "format", "minimum", "maximum")

_WORDS = {"number": "a number", "integer": "a whole number", "boolean": "true or false", "array": "a list"}
_WORDS["object"] = "a mapping"

CONTROLS: Schema = {
    "for": {"$ref": "#/definitions/for"},
    "if": {"$ref": "#/definitions/if"},
}


def for_editors(language: Language) -> Schema:
    """Return the schema of the files of a description."""
    return _Authoring(language).whole()


class _Authoring:
    """Makes the schema of what is written of that of what it means."""

    def __init__(self, language: Language) -> None:
        self.language = language

    def whole(self) -> Schema:
        """Return the schema of a file."""
        plain = self.language.schema
        sections = {
            name: section if name in _CLOSED else self._opened(section, entry=False)
            for name, section in plain["properties"].items()
        }
        definitions = {
            name: fragment if name == "arg" else self._opened(fragment)
            for name, fragment in plain_definitions(self.language).items()
        }
        definitions["element"] = _with_value(definitions["element"])
        added = added_definitions(self.language, sections, definitions["arg"])
        made: Schema = {
            "$schema": "http://json-schema.org/draft-07/schema#",
            "$id": "authoring",
            "title": plain["title"],
            "description": f"{plain['description']} This file, or the one that includes it, begins with robot.",
            "type": "object",
            "properties": {**sections, **added_sections(sections)},
            "additionalProperties": False,
            "definitions": {**definitions, **added},
        }
        done: Schema = self._with_definitions(made)
        return done

    def _opened(self, fragment: Schema, entry: bool = True) -> Schema:
        """Return a fragment of the plain schema as it may be written; ``entry``: with a loop and a condition."""
        if "$ref" in fragment or "const" in fragment:
            return fragment
        made = {key: fragment[key] for key in _SAME if key in fragment}
        if "enum" in fragment:
            return {**made, "anyOf": [{"enum": fragment["enum"]}, {"type": "string", "pattern": WHOLE}]}
        made |= {key: self._opened(fragment[key]) for key in _INNER if isinstance(fragment.get(key), dict)}
        made |= {key: list(map(self._opened, fragment[key])) for key in ("anyOf", "oneOf", "allOf") if key in fragment}
        made |= {key: fragment[key] for key in ("required", "dependencies") if key in fragment}
        if "maxItems" in fragment and "object" not in self._resolved(fragment.get("items", {})).get("type", ()):
            made["maxItems"] = fragment["maxItems"]  # a list of entries may have a loop in it
        if fragment.get("additionalProperties") is False:
            made["additionalProperties"] = False
            made["patternProperties"] = {SOME: True}  # a key may be an expression
        if "properties" in fragment:
            made["properties"] = {name: self._opened(value) for name, value in fragment["properties"].items()}
        types = [fragment["type"]] if isinstance(fragment.get("type"), str) else list(fragment.get("type", []))
        if types:
            made |= self._types(types, fragment)
        return _as_entry(made, fragment) if entry and "object" in types else made

    def _types(self, types: list[str], fragment: Schema) -> Schema:
        """Return the types that may be written for those of a value, and what its text looks like."""
        made: Schema = {"type": types[0] if types == ["string"] else list(dict.fromkeys([*types, "string"]))}
        if "string" in types:
            if "pattern" in fragment:
                made["pattern"] = f"({fragment['pattern']})|{SOME}".replace('\\"', '"')  # editors allow no idle escape
            return made
        units = fragment.get("x-unit", [])
        units = [units] if isinstance(units, str) else units
        quantities = self._quantities(units) if "number" in types else []
        made["pattern"] = "|".join([WHOLE, *quantities])
        what = (
            f"a number in {' or '.join(filter(None, units))}, one with a unit, "
            if quantities
            else f"{_WORDS.get(types[0], types[0])} "
        )
        made["patternErrorMessage"] = f"Write {what}or one expression: ${{...}}."  # editors show it for the pattern
        return made

    def _quantities(self, units: list[str]) -> list[str]:
        """Return patterns of quantities that fit one of some units, with a unit of its kind or a compound one."""
        same = {name for unit in units for name in self.language.units_for(unit)}
        if not any(map(self.language.is_unit, units)):
            return []
        fitting = "|".join(re.escape(name) for name in self.language.units if name in same)
        every = "|".join(map(re.escape, self.language.units))
        factor = rf"({every})(\^-?\d)?"
        compound = rf"{factor}([*/]{factor})+|({every})\^-?\d"
        return [rf"{_NUMBER}({'|'.join(filter(None, [fitting, compound]))})$"]

    def _resolved(self, fragment: Schema) -> Schema:
        """Return what a fragment refers to, or the fragment itself."""
        if "$ref" not in fragment:
            return fragment
        made: Schema = self.language.schema["$defs"][fragment["$ref"].rsplit("/", 1)[1]]
        return made

    def _with_definitions(self, fragment: Any) -> Any:
        """Return a schema whose definitions stand where draft 7 has them; what only the compiler reads is left out."""
        if isinstance(fragment, list):
            return [self._with_definitions(item) for item in fragment]
        if not isinstance(fragment, Mapping):
            return fragment
        made, left_out = {}, self.language.annotations
        for key, value in fragment.items():
            if key in left_out or (key == "propertyNames" and value.keys() <= left_out):
                continue
            made[key] = value.replace("#/$defs/", "#/definitions/") if key == "$ref" else self._with_definitions(value)
        return made


def _as_entry(made: Schema, fragment: Schema) -> Schema:
    """Return a mapping that may have a loop and a condition, which do not count among its keys."""
    names = list(fragment.get("properties", ()))
    if fragment.get("minProperties") == 1 and names:
        exactly = fragment.get("maxProperties") == 1
        made["if"], made["then"] = {"type": "object"}, {"oneOf" if exactly else "anyOf": _each_required(names)}
    made["properties"] = {**made.get("properties", {}), **CONTROLS}
    return made


def _with_value(text: Schema) -> Schema:
    """Return a text that may also stand as ``value`` beside a loop or a condition."""
    properties = {"value": {"type": "string", "description": text["description"]}, **CONTROLS}
    return {**text, "type": ["string", "object"], "properties": properties, "required": ["value"]} | {
        "additionalProperties": False
    }


def _each_required(names: list[str]) -> list[Schema]:
    return [{"required": [name]} for name in names]
