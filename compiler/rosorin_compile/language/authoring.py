"""The authoring schema: the schema of descriptions as they are written, for completion and help in editors.

As written, a number may also be a quantity or an expression, a name may contain expressions, and an entry may have a
loop and a condition. ``docs/make/authoring.py`` derives the committed schema; sections of plug-ins are added here.
"""

from __future__ import annotations

import json
import re
from collections.abc import Mapping
from typing import Any

from rosorin_compile.source import files
from rosorin_compile.source.project import data_folder
from rosorin_compile.source.units import UNITS, parse_unit

from .annotations import ANNOTATIONS
from .schema import LAST, of_parts, plugged_sections, schema

Schema = dict[str, Any]

_WHOLE = r"^\$\{[\s\S]*\}$"  # text that is one expression, so that it has the type of its value
_SOME = r"\$\{"  # text with an expression in it
_NUMBER = r"^[-+]?(\d+\.?\d*|\.\d+)([eE][-+]?\d+)?\s*"
_INNER = ("items", "additionalProperties", "propertyNames", "not", "if", "then", "else")
_COPIED = ("description", "title", "default", "const", "minLength", "minItems", "format", "minimum", "maximum")
_WORDS = {"number": "a number", "integer": "a whole number", "boolean": "true or false", "array": "a list"}
_WORDS["object"] = "a mapping"
CONTROLS = {"for": {"$ref": "#/definitions/for"}, "if": {"$ref": "#/definitions/if"}}


def authoring_schema() -> str:
    """Return the schema of the files of a description as text, with the sections of plug-ins."""
    text = files.read_text(data_folder("schemas") / "authoring.schema.json")
    if not plugged_sections():
        return text
    committed, plain = json.loads(text), schema()
    properties = committed["properties"]
    after = {name: properties.pop(name) for name in list(properties)[list(properties).index(LAST[0]) :]}
    definitions = committed["definitions"]
    rules = definitions["acceptance"]["properties"]["rule"]["anyOf"][0]["enum"]
    for name, section in plugged_sections().items():
        fragment = draft_7(as_written(plain["properties"][name], plain, entry=False))
        properties[name] = fragment
        if name in of_parts():
            definitions["part"]["properties"][name] = fragment
            definitions["use"]["properties"]["content"]["properties"][name] = fragment
        rules += [rule.id for check in section.checks for rule in check.rules if rule.accept or rule.mild]
    properties |= after
    return json.dumps(committed, indent=1, ensure_ascii=False) + "\n"


def as_written(fragment: Schema, plain: Schema, entry: bool = True) -> Schema:
    """Return a fragment of the plain schema as it may be written; ``entry``: with a loop and a condition."""
    if "$ref" in fragment or "const" in fragment:
        return fragment
    made = {key: fragment[key] for key in _COPIED if key in fragment}
    if "enum" in fragment:
        return {**made, "anyOf": [{"enum": fragment["enum"]}, {"type": "string", "pattern": _WHOLE}]}
    made |= {key: as_written(fragment[key], plain) for key in _INNER if isinstance(fragment.get(key), dict)}
    for key in ("anyOf", "oneOf", "allOf"):
        if key in fragment:
            made[key] = [as_written(item, plain) for item in fragment[key]]
    made |= {key: fragment[key] for key in ("required", "dependencies") if key in fragment}
    items = fragment.get("items", {})
    if "$ref" in items:
        items = plain["$defs"][items["$ref"].rsplit("/", 1)[1]]
    if "maxItems" in fragment and "object" not in items.get("type", ()):
        made["maxItems"] = fragment["maxItems"]  # a list of entries may have a loop in it
    if fragment.get("additionalProperties") is False:
        made["additionalProperties"] = False
        made["patternProperties"] = {_SOME: True}  # a key may be an expression
    if "properties" in fragment:
        made["properties"] = {name: as_written(value, plain) for name, value in fragment["properties"].items()}
    types = [fragment["type"]] if isinstance(fragment.get("type"), str) else list(fragment.get("type", []))
    if types:
        made |= _types(types, fragment)
    if entry and "object" in types:
        if fragment.get("minProperties") == 1 and "properties" in fragment:  # loops and conditions do not count
            required = [{"required": [name]} for name in fragment["properties"]]
            exactly = fragment.get("maxProperties") == 1
            made["if"], made["then"] = {"type": "object"}, {"oneOf" if exactly else "anyOf": required}
        made["properties"] = {**made.get("properties", {}), **CONTROLS}
    return made


def _types(types: list[str], fragment: Schema) -> Schema:
    made: Schema = {"type": types[0] if types == ["string"] else list(dict.fromkeys([*types, "string"]))}
    if "string" in types:
        if "pattern" in fragment:
            made["pattern"] = f"({fragment['pattern']})|{_SOME}".replace('\\"', '"')  # editors allow no idle escape
        return made
    units = fragment.get("x-unit", [])
    units = [units] if isinstance(units, str) else units
    parsed = {unit: parse_unit(unit) for unit in units}
    patterns, what = [_WHOLE], f"{_WORDS.get(types[0], types[0])} "
    if "number" in types and any(parsed.values()):
        dimensions = {unit[1] for unit in parsed.values() if unit is not None}
        fitting = "|".join(re.escape(name) for name, (_, dimension) in UNITS.items() if dimension in dimensions)
        every = "|".join(map(re.escape, UNITS))
        factor = rf"({every})(\^-?\d)?"
        compound = rf"{factor}([*/]{factor})+|({every})\^-?\d"
        patterns.append(rf"{_NUMBER}({'|'.join(filter(None, [fitting, compound]))})$")
        what = f"a number in {' or '.join(filter(None, units))}, one with a unit, "
    made["pattern"] = "|".join(patterns)
    made["patternErrorMessage"] = f"Write {what}or one expression: ${{...}}."  # editors show it for the pattern
    return made


def draft_7(fragment: Any) -> Any:
    """Return a schema with definitions where draft 7 has them, without annotations for the compiler."""
    if isinstance(fragment, list):
        return [draft_7(item) for item in fragment]
    if not isinstance(fragment, Mapping):
        return fragment
    made = {}
    for key, value in fragment.items():
        if key not in ANNOTATIONS and not (key == "propertyNames" and value.keys() <= ANNOTATIONS):
            made[key] = value.replace("#/$defs/", "#/definitions/") if key == "$ref" else draft_7(value)
    return made
