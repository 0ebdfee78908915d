"""The authoring schema as it is committed: the schema of descriptions as they are written, for editors.

    python docs/make/authoring.py > schemas/authoring.schema.json

``python tests/renew.py schema`` does that too. The schema is derived from that of the expanded tree; parts, their uses,
named values and sensor types are in language/sections/authoring.json. Every editor understands draft 7 of JSON Schema.
"""

from __future__ import annotations

import json
import sys
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

from rosorin_compile.formats import FORMATS, Format
from rosorin_compile.language.schema import CONTROLS, Schema, as_written, draft_7, of_parts, of_types, schema
from rosorin_compile.language.suppressions import STAYS
from rosorin_compile.source.rule_registry import Heading, find

SECTIONS = Path(__file__).parents[2] / "compiler/rosorin_compile/language/sections/authoring.json"
_LITERAL = ("rosorin_compile", "args", "modes", "include")  # sections that are never evaluated
# The topics of rules that run while a robot is compiled.
_COMPILING = (
    *(Heading.FILES, Heading.ARGUMENTS, Heading.SHAPE, Heading.JOINTS, Heading.NUMBERS, Heading.POSES),
    *(Heading.FRAMES, Heading.OUTPUTS, Heading.FORMATS, Heading.SIMULATION, Heading.PHYSICS),
)


def text() -> str:
    """Return the authoring schema as it is committed."""
    return json.dumps(authoring_schema(FORMATS.values()), indent=1, ensure_ascii=False) + "\n"


def authoring_schema(formats: Iterable[Format]) -> Schema:
    """Return the schema of the files of a description, with the options of the outputs of some formats."""
    plain = with_formats(formats)
    sections = {
        name: section if name in _LITERAL else as_written(section, plain, entry=False)
        for name, section in plain["properties"].items()
    }
    definitions = {
        name: fragment if name == "arg" else as_written(fragment, plain)
        for name, fragment in _definitions(plain).items()
    }
    element = definitions["element"]  # a text, which may also be the ``value`` beside a loop or a condition
    value = {"value": {"type": "string", "description": element["description"]}, **CONTROLS}
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
    result: Schema = draft_7(schema)
    return result


def added_sections(plain: Mapping[str, Any], sections: Mapping[str, Any], arg: Schema) -> tuple[Schema, Schema]:
    """Return the sections and the definitions that only files have: parts, uses, named values, sensor types.

    ``sections`` are those of the schema ``plain`` as they may be written, ``arg`` is the definition of an argument.
    """
    added = json.loads(SECTIONS.read_text("utf-8"))
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
    rules = [
        rule for rule in find().values() if (rule.asked or rule.topic in _COMPILING) and (rule.accept or rule.mild)
    ]
    names = sorted(rule.id for rule in rules if rule.id not in STAYS)
    rule = {"enum": names, "description": acceptance["properties"]["rule"]["description"]}
    return {**plain["$defs"], "acceptance": {**acceptance, "properties": {**acceptance["properties"], "rule": rule}}}


def with_formats(formats: Iterable[Format]) -> dict[str, Any]:
    """Return the schema of descriptions with the options of every format, each with the formats that have it."""
    options: dict[str, dict[str, Any]] = {}
    meanings: dict[str, dict[str, list[str]]] = {}
    for format in formats:
        for key, option in format.options.items():
            merged = options.setdefault(key, dict(option))
            if "enum" in merged and "enum" in option:  # each format's own values are checked by ``with_outputs``
                merged["enum"] = [*merged["enum"], *(one for one in option["enum"] if one not in merged["enum"])]
            meanings.setdefault(key, {}).setdefault(option.get("description", ""), []).append(format.name)
    for key, option in options.items():
        texts = [
            f"{', '.join(names)}: {text[:1].lower() + text[1:] if text[1:2].islower() or text[1:2] == ' ' else text}"
            for text, names in meanings[key].items()
        ]
        option["description"] = " ".join(texts)
    root = schema()
    output = root["$defs"]["output"]
    output = {**output, "properties": {**output["properties"], **options}, "additionalProperties": False}
    return {**root, "$defs": {**root["$defs"], "output": output}}


if __name__ == "__main__":
    sys.stdout.write(text())
