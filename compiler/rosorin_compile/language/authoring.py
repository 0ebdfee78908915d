"""The authoring schema: the schema of descriptions as they are written, for completion and help in editors.

It is derived from the schema of the expanded tree. As written, a number may also be a quantity or an expression, a name
may contain expressions, an entry may have a loop and a condition; parts, their uses, named values and sensor types are
in ``schemas/authoring_sections.json``. JSON Schema draft 7 is the draft that every editor understands.
"""

from __future__ import annotations

import json
import re
from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING, Any

from rosorin_compile.source import files
from rosorin_compile.source import rule_registry as registry
from rosorin_compile.source.project import data_folder
from rosorin_compile.source.rule_registry import Rule
from rosorin_compile.source.units import UNITS, parse_unit

from .annotations import ANNOTATIONS
from .schema import of_parts, of_types, with_formats
from .suppressions import STAYS

if TYPE_CHECKING:
    from rosorin_compile.formats import Format

Schema = dict[str, Any]

_WHOLE = r"^\$\{[\s\S]*\}$"  # text that is one expression, so that it has the type of its value
_SOME = r"\$\{"  # text with an expression in it
_NUMBER = r"^[-+]?(\d+\.?\d*|\.\d+)([eE][-+]?\d+)?\s*"
_LITERAL = ("rosorin_compile", "args", "modes", "include")  # sections that are never evaluated
_INNER = ("items", "additionalProperties", "propertyNames", "not", "if", "then", "else")
_COPIED = ("description", "title", "default", "const", "minLength", "minItems", "format", "minimum", "maximum")
_WORDS = {"number": "a number", "integer": "a whole number", "boolean": "true or false", "array": "a list"}
_WORDS["object"] = "a mapping"
_CONTROLS = {"for": {"$ref": "#/definitions/for"}, "if": {"$ref": "#/definitions/if"}}
# The topics of rules that run while a robot is compiled.
_COMPILING = (
    *(registry.FILES, registry.ARGUMENTS, registry.SHAPE, registry.JOINTS, registry.NUMBERS, registry.POSES),
    *(registry.FRAMES, registry.OUTPUTS, registry.FORMATS, registry.SIMULATION, registry.PHYSICS),
)


def authoring_schema(formats: Iterable[Format]) -> Schema:
    """Return the schema of the files of a description, with the options of the outputs of some formats."""
    plain = with_formats(formats)
    sections = {
        name: section if name in _LITERAL else _as_written(section, plain, entry=False)
        for name, section in plain["properties"].items()
    }
    definitions = {
        name: fragment if name == "arg" else _as_written(fragment, plain)
        for name, fragment in _definitions(plain).items()
    }
    element = definitions["element"]  # a text, which may also be the ``value`` beside a loop or a condition
    value = {"value": {"type": "string", "description": element["description"]}, **_CONTROLS}
    element |= {"type": ["string", "object"], "properties": value, "required": ["value"], "additionalProperties": False}
    added, added_definitions = added_sections(plain, sections, definitions["arg"])
    schema: Schema = {
        "$schema": "http://json-schema.org/draft-07/schema#",
        "$id": "authoring",
        "title": plain["title"],
        "description": f"{plain['description']} This file, or the one that includes it, begins with robot.",
        "type": "object",
        "properties": {**sections, **added},
        "additionalProperties": False,
        "definitions": {**definitions, **added_definitions},
    }
    result: Schema = _draft_7(schema)
    return result


def added_sections(plain: Mapping[str, Any], sections: Mapping[str, Any], arg: Schema) -> tuple[Schema, Schema]:
    """Return the sections and the definitions that only files have: parts, uses, named values, sensor types.

    ``sections`` are those of the schema ``plain`` as they may be written, ``arg`` is the definition of an argument.
    """
    added = json.loads(files.read_text(data_folder("schemas") / "authoring_sections.json"))
    properties, definitions = added["properties"], added["definitions"]
    properties["include"] = {**sections["include"], **properties["include"]}
    inside = {name: sections[name] for name in of_parts()}
    definitions["part"]["properties"] |= inside
    definitions["use"]["properties"]["content"]["properties"] = inside
    bounds = definitions["bounded_param"]["properties"]
    definitions["bounded_param"] = {**arg, "properties": {**arg["properties"], **bounds}}
    keys = plain["$defs"]["sensor"]["properties"]
    for key in of_types():
        reference = keys[key].get("$ref", f"sensor/properties/{key}").removeprefix("#/$defs/")
        definitions["sensor_type"]["properties"][key] = {"$ref": f"#/definitions/{reference}"}
    return properties, definitions


def documented_schema(formats: Iterable[Format]) -> Schema:
    """Return the schema of descriptions with the sections that only files have, for the reference."""
    plain = with_formats(formats)
    sections, added = added_sections(plain, plain["properties"], plain["$defs"]["arg"])
    definitions = {**_definitions(plain), **added}
    return {**plain, "properties": {**plain["properties"], **sections}, "$defs": definitions}


def _definitions(plain: Schema) -> Schema:
    """Return the definitions of the plain schema, with the rules that ``accept`` may name."""
    acceptance = plain["$defs"]["acceptance"]
    rules = [rule for rule in Rule.every() if (rule.asked or rule.topic in _COMPILING) and (rule.accept or rule.mild)]
    names = sorted(rule.id for rule in rules if rule.id not in STAYS)
    rule = {"enum": names, "description": acceptance["properties"]["rule"]["description"]}
    return {**plain["$defs"], "acceptance": {**acceptance, "properties": {**acceptance["properties"], "rule": rule}}}


def _as_written(fragment: Schema, plain: Schema, entry: bool = True) -> Schema:
    """Return a fragment of the plain schema as it may be written; ``entry``: with a loop and a condition."""
    if "$ref" in fragment or "const" in fragment:
        return fragment
    made = {key: fragment[key] for key in _COPIED if key in fragment}
    if "enum" in fragment:
        return {**made, "anyOf": [{"enum": fragment["enum"]}, {"type": "string", "pattern": _WHOLE}]}
    made |= {key: _as_written(fragment[key], plain) for key in _INNER if isinstance(fragment.get(key), dict)}
    for key in ("anyOf", "oneOf", "allOf"):
        if key in fragment:
            made[key] = [_as_written(item, plain) for item in fragment[key]]
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
        made["properties"] = {name: _as_written(value, plain) for name, value in fragment["properties"].items()}
    types = [fragment["type"]] if isinstance(fragment.get("type"), str) else list(fragment.get("type", []))
    if types:
        made |= _types(types, fragment)
    if entry and "object" in types:
        if fragment.get("minProperties") == 1 and "properties" in fragment:  # loops and conditions do not count
            required = [{"required": [name]} for name in fragment["properties"]]
            exactly = fragment.get("maxProperties") == 1
            made["if"], made["then"] = {"type": "object"}, {"oneOf" if exactly else "anyOf": required}
        made["properties"] = {**made.get("properties", {}), **_CONTROLS}
    return made


def _types(types: list[str], fragment: Schema) -> Schema:
    """Return the types that may be written for those of a value, and the pattern of its text."""
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


def _draft_7(fragment: Any) -> Any:
    """Return a schema with definitions where draft 7 has them, without annotations for the compiler."""
    if isinstance(fragment, list):
        return [_draft_7(item) for item in fragment]
    if not isinstance(fragment, Mapping):
        return fragment
    made = {}
    for key, value in fragment.items():
        if key not in ANNOTATIONS and not (key == "propertyNames" and value.keys() <= ANNOTATIONS):
            made[key] = value.replace("#/$defs/", "#/definitions/") if key == "$ref" else _draft_7(value)
    return made
