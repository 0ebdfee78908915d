"""The JSON Schemas of the tool, extended by plug-ins, and functions to look up sections, paths and units.

Plug-ins define sections with entry points ``rosorin_compile.sections``. Their schemas are merged into the schema of
descriptions, so all code that uses the schema also handles them.
"""

import json
import re
from collections.abc import Collection, Mapping, Sequence
from functools import cache, lru_cache
from typing import TYPE_CHECKING, Any, NamedTuple

from rosorin_compile.model.sections import ENTRIES, ITEMS, Section
from rosorin_compile.source import files
from rosorin_compile.source.diagnostics import Diagnostic, UnknownName
from rosorin_compile.source.plugins import Plugin, broken_plugin, load
from rosorin_compile.source.project import data_folder
from rosorin_compile.source.rule_registry import OF_PLUGINS, Check, find
from rosorin_compile.source.units import UNITS, parse_unit

from . import annotations as schema_words
from .annotations import ANNOTATIONS, GIVES, NAMES, WITHIN, Node, check_schema, describe_path, kinds_of, own_schema
from .annotations import Steps as Steps

if TYPE_CHECKING:
    from rosorin_compile.formats import Format

TEMPLATE = "template"  # an output that has this key uses the template format, whatever the name of the output
LAST = ("accept", "outputs")  # sections that are placed after the sections of plug-ins
_RESERVED = ("parts", "use", "sensor_types", "help")  # sections that only exist before expansion


class PluginSections(NamedTuple):
    """The sections that plug-ins define, as (plug-in, section), and errors about plug-ins with invalid sections."""

    sections: tuple[tuple[Plugin, Section[Any]], ...]
    diagnostics: tuple[Diagnostic, ...]


@cache
def plugin_sections() -> PluginSections:
    """Load the sections of plug-ins; report and exclude sections that refer to an undefined kind of name."""

    def is_taken(name: str) -> bool:
        own = own_schema()
        taken = (*own["properties"], *_RESERVED, *(f"$defs/{one}" for one in own["$defs"]))
        return name in taken or ("-" in name and bool(find([name])))

    loaded, diagnostics = load("sections", Section, _marks, is_taken)
    known = kinds_of(own_schema(), GIVES) | kinds_of(own_schema(), NAMES) if loaded else set()
    known |= {kind for _, section in loaded for kind in kinds_of(section.schema, GIVES)}
    sections, problems = [], [*diagnostics]
    for plugin, section in loaded:
        for kind in (unknown := sorted(kinds_of(section.schema, NAMES) - known)):
            why = f"has a schema with an unknown name: {UnknownName('kind', kind, known)}"
            problems.append(broken_plugin(plugin, why))
        if not unknown:
            sections.append((plugin, section))
            OF_PLUGINS.update((rule.id, rule) for check in section.all_checks() for rule in check.rules)
    return PluginSections(tuple(sections), tuple(problems))


def plugged_sections() -> Mapping[str, Section[Any]]:
    """Return the sections of plug-ins by name."""
    return {section.name: section for _, section in plugin_sections().sections}


def piece(section: Section[Any]) -> dict[str, Any]:
    """Return the JSON Schema of a plug-in section, with default values for missing annotations."""
    defaults: dict[str, Any] = {"x-compared": section.schema.get("x-called", section.name)}
    if section.form in (ENTRIES, ITEMS):
        defaults["x-merge"] = section.form
    if section.form == ENTRIES:
        defaults["x-explained"] = True
    made: dict[str, Any] = _looked_up({**defaults, **section.schema})
    key = {ENTRIES: "additionalProperties", ITEMS: "items"}.get(section.form)
    entry = made if key is None else made[key]
    # Names by which ``accept`` can refer to errors in an entry: the name of the entry and of links and joints in it.
    keys = made.get("$defs", {}).get(entry.get("$ref", "").rpartition("/")[2], entry).get("properties", {})
    kinds = ((name, inner.get("x-names", inner.get("x-gives"))) for name, inner in keys.items())
    named = [f"{{{name}}}" for name, kind in kinds if kind in ("link", "joint")]
    entry = {"x-accepted": ["{1}", *named] if section.form == ENTRIES else named, **entry}
    return entry if key is None else {**made, key: entry}


def _looked_up(fragment: Any) -> Any:
    if isinstance(fragment, list):
        return [_looked_up(item) for item in fragment]
    if not isinstance(fragment, Mapping):
        return fragment
    made = {key: _looked_up(item) for key, item in fragment.items()}
    is_usual = fragment.get("x-names", "link") in ("link", "joint")  # names of links and joints need no x-among
    return made if is_usual else {"x-among": schema_words.DESCRIPTION, **made}


def _marks(section: Section[Any]) -> Collection[str]:
    section.check()
    if not all(isinstance(check, Check) for check in section.all_checks()):
        raise TypeError("its checks are functions under @rule")
    definitions = section.schema.get("$defs", {})
    pieces = {**definitions, section.name: {key: one for key, one in section.schema.items() if key != "$defs"}}
    own = {"type": "object", "properties": pieces}
    check_schema(own, {**own_schema(), **own, "$defs": {**own_schema()["$defs"], **definitions}})
    schema_words.check_annotations(piece(section), own_schema())
    rules = [id for check in section.all_checks() for id in check.ids()]
    return [section.name, *rules, *(f"$defs/{name}" for name in definitions)]


@cache
def schema(name: str = "description") -> dict[str, Any]:
    """Return ``schemas/NAME.schema.json``; the description schema includes the sections of plug-ins."""
    own = own_schema(name)
    added = {name: piece(section) for name, section in plugged_sections().items()} if name == "description" else {}
    if not added:
        return own
    last = {name: own["properties"][name] for name in LAST}
    first = {name: fragment for name, fragment in own["properties"].items() if name not in last}
    definitions = {name: one for piece in added.values() for name, one in piece.pop("$defs", {}).items()}
    return {**own, "properties": {**first, **added, **last}, "$defs": {**own["$defs"], **definitions}}


def keys_of(section: str) -> Collection[str]:
    """Return the valid keys of a section that is a single entry, not a table of entries."""
    keys: Collection[str] = resolve(schema()["properties"][section])["properties"].keys()
    return keys


@cache
def keys_of_xml() -> frozenset[str]:
    """Return the names of all keys whose values are lists of XML elements."""
    keys = (item for entry in (schema(), *schema()["$defs"].values()) for item in entry.get("properties", {}).items())
    return frozenset(key for key, inner in keys if inner.get("items", {}).get("$ref") == "#/$defs/element")


@cache
def sections() -> Mapping[str, Node]:
    """Map each section of a description to its annotations; omit sections without annotations."""
    return schema_words.annotated_sections(schema())


@cache
def merged_sections(*how: str, in_parts: bool = False) -> tuple[str, ...]:
    """Return the sections whose ``x-merge`` is in ``how``; with ``in_parts``, only sections that parts may contain."""
    return tuple(key for key, node in sections().items() if node.merge in how and (node.in_parts or not in_parts))


@cache
def named_as(kind: str) -> tuple[str, ...]:
    """Return the sections whose keys are names of a kind, such as "joint"."""
    return tuple(key for key, node in sections().items() if node.keys is not None and node.keys.gives == kind)


@cache
def of_parts() -> tuple[str, ...]:
    """Return the sections that parts may contain."""
    return tuple(key for key, node in sections().items() if node.in_parts)


@cache
def of_types() -> tuple[str, ...]:
    """Return the keys of a sensor that its sensor type may define, in the order of the schema."""
    keys = [item for node in sections().values() if node.others for item in node.others.properties.items()]
    return tuple(key for key, node in keys if node is not None and node.in_types)


def is_one_entry(section: str) -> bool:
    """Return True if parts may contain the section and it is a single entry, not a table or list of entries."""
    node = sections().get(section)
    return node is not None and node.in_parts and node.merge in ("", WITHIN)


def holds_many(section: str) -> bool:
    """Return True if the section is a single entry with tables and lists that several parts and files may extend."""
    return section in merged_sections(WITHIN)


def with_outputs(outputs: Any, formats: "Mapping[str, Format]") -> dict[str, Any]:
    """Return the description schema, extended by the options of the formats that ``outputs`` uses."""
    root = schema()
    output, section = root["$defs"]["output"], root["properties"]["outputs"]
    entries: dict[str, Any] = {}
    for name, entry in outputs.items() if isinstance(outputs, Mapping) else ():
        backend = entry.get("backend", backend_of(name, entry)) if isinstance(entry, Mapping) else ""
        if isinstance(backend, str) and backend in formats:
            entries[name] = {**output, "properties": {**output["properties"], **formats[backend].options}}
    if not entries:
        return root
    return {**root, "properties": {**root["properties"], "outputs": {**section, "properties": entries}}}


def backend_of(name: str, entry: Mapping[str, Any]) -> str:
    """Return the format of an output that lacks ``backend``: "template" if it has a template, otherwise its name."""
    return TEMPLATE if TEMPLATE in entry else name


def subject(path: Steps) -> str:
    """Format a path for messages, such as ``"limit.lower" of joint "joint1"``."""
    return describe_path(path, schema())


def part_at(path: Steps, whole: Mapping[str, Any]) -> tuple[Any, str]:
    """Return the schema fragment at a schema path, and the name of the last definition on the path, or "".

    The step ``if`` before ``then`` is ignored, because only jsonschema 3.2 includes it.
    """
    node, name = whole, ""
    for number, step in enumerate(path):
        if step == "if" and path[number + 1 : number + 2] == ["then"]:
            continue
        node = node[step]  # type: ignore[index]
        if isinstance(node, dict) and isinstance(node.get("$ref"), str):
            name = node["$ref"].rsplit("/", 1)[1]
            node = whole["$defs"][name]
    return node, name


def unit_at(path: Sequence[str | int]) -> str | list[str] | None:
    """Return the unit (or list of units) of the value at a path, "" for a plain number, or None for other values."""
    node = fragment_at(path)
    if node.get("type") not in ("number", "integer") and "x-unit" not in node:  # neither a number nor a list of numbers
        return None
    unit: str | list[str] = node.get("x-unit", "")
    return unit


def joint_unit(path: Sequence[str | int], slides: bool, leader_slides: bool | None = None) -> str | None:
    """Return the unit of the value at a path; if the schema has several units, choose by the type of the joint.

    ``slides`` is True for a prismatic joint; ``leader_slides`` is the same for the joint that it mimics, if any.
    """
    units = unit_at(path)
    if units is None or isinstance(units, str):
        return units
    if tuple(path[-2:]) != ("mimic", "multiplier"):
        return units[-1 if slides else 0]
    plain, per_angle, per_length = units  # units of the follower per unit of the leader
    return plain if leader_slides in (None, slides) else per_angle if slides else per_length


def fragment_at(path: Sequence[str | int]) -> Mapping[str, Any]:
    """Return the schema fragment for the value at a path of a description, or an empty mapping."""
    # All entries of a table and all items of a list have the same schema, so they share a cached result.
    steps = [0 if isinstance(step, int) else step for step in path]
    if len(steps) > 1:
        section = resolve(schema()["properties"].get(steps[0], {}))
        if "items" in section or isinstance(section.get("additionalProperties"), dict):
            steps[1] = "*"
    return _fragment_at(tuple(steps))


@lru_cache(maxsize=2_000)
def _fragment_at(path: tuple[str | int, ...]) -> Mapping[str, Any]:
    node: dict[str, Any] = schema()
    for step in path:
        inner = node.get("items")
        if not isinstance(step, int):
            inner = node.get("properties", {}).get(step, node.get("additionalProperties", inner))
        if not isinstance(inner, dict):
            return {}
        node = {**resolve(inner), **inner} if "$ref" in inner else inner
    return node


def resolve(node: dict[str, Any]) -> dict[str, Any]:
    """Return the definition to which a schema fragment refers (``$ref``), or the fragment itself."""
    return schema()["$defs"][node["$ref"].rsplit("/", 1)[1]] if "$ref" in node else node


Schema = dict[str, Any]

_WHOLE = r"^\$\{[\s\S]*\}$"  # matches a string that is a single expression, whose value may have any type
_SOME = r"\$\{"  # matches a string that contains an expression
_NUMBER = r"^[-+]?(\d+\.?\d*|\.\d+)([eE][-+]?\d+)?\s*"
_INNER = ("items", "additionalProperties", "propertyNames", "not", "if", "then", "else")
_COPIED = ("description", "title", "default", "const", "minLength", "minItems", "format", "minimum", "maximum")
_WORDS = {"number": "a number", "integer": "a whole number", "boolean": "true or false", "array": "a list"}
_WORDS["object"] = "a mapping"
CONTROLS = {"for": {"$ref": "#/definitions/for"}, "if": {"$ref": "#/definitions/if"}}


def authoring_schema() -> str:
    """Return the JSON Schema for files before expansion, including the sections of plug-ins, as text for editors."""
    text = files.read_text(data_folder("schemas") / "authoring.schema.json")
    if not plugged_sections():
        return text
    committed, plain = json.loads(text), schema()
    properties, definitions = committed["properties"], committed["definitions"]
    after = {name: properties.pop(name) for name in list(properties)[list(properties).index(LAST[0]) :]}
    rules = definitions["acceptance"]["properties"]["rule"]["anyOf"][0]["enum"]
    of_part, content = (definitions[one]["properties"] for one in ("part", "use"))
    for name, section in plugged_sections().items():
        fragment = draft_7(as_written(plain["properties"][name], plain, entry=False))
        for table in (properties, of_part, content["content"]["properties"]) if name in of_parts() else (properties,):
            table[name] = fragment
        rules += [rule.id for check in section.all_checks() for rule in check.rules if rule.accept or rule.mild]
    properties |= after
    missing = [name for name in plain["$defs"] if name not in definitions]
    definitions |= {name: draft_7(as_written(plain["$defs"][name], plain)) for name in missing}
    return json.dumps(committed, indent=1, ensure_ascii=False) + "\n"


def as_written(fragment: Schema, plain: Schema, entry: bool = True) -> Schema:
    """Adapt a schema fragment to files before expansion: allow expressions and, if ``entry``, loops and conditions."""
    if "$ref" in fragment or "const" in fragment:
        return fragment
    made = {key: fragment[key] for key in _COPIED if key in fragment}
    if "enum" in fragment:
        return {**made, "anyOf": [{"enum": fragment["enum"]}, {"type": "string", "pattern": _WHOLE}]}
    made |= {key: as_written(fragment[key], plain) for key in _INNER if isinstance(fragment.get(key), dict)}
    for key in (key for key in ("anyOf", "oneOf", "allOf") if key in fragment):
        made[key] = [as_written(item, plain) for item in fragment[key]]
    made |= {key: fragment[key] for key in ("required", "dependencies") if key in fragment}
    if "maxItems" in fragment and "object" not in resolve(fragment.get("items", {})).get("type", ()):
        made["maxItems"] = fragment["maxItems"]  # not for lists of entries, which may contain a loop
    if fragment.get("additionalProperties") is False:
        made["additionalProperties"] = False
        made["patternProperties"] = {_SOME: True}  # keys may contain expressions
    if "properties" in fragment:
        made["properties"] = {name: as_written(value, plain) for name, value in fragment["properties"].items()}
    types = [fragment["type"]] if isinstance(fragment.get("type"), str) else list(fragment.get("type", []))
    if types:
        made |= _types(types, fragment)
    if entry and "object" in types:
        if fragment.get("minProperties") == 1 and "properties" in fragment:  # "for" and "if" must not count as keys
            required = [{"required": [name]} for name in fragment["properties"]]
            exactly = fragment.get("maxProperties") == 1
            made["if"], made["then"] = {"type": "object"}, {"oneOf" if exactly else "anyOf": required}
        made["properties"] = {**made.get("properties", {}), **CONTROLS}
    return made


def _types(types: list[str], fragment: Schema) -> Schema:
    made: Schema = {"type": types[0] if types == ["string"] else list(dict.fromkeys([*types, "string"]))}
    if "string" in types:
        if "pattern" in fragment:
            made["pattern"] = f"({fragment['pattern']})|{_SOME}".replace('\\"', '"')  # some editors reject \"
        return made
    units = fragment.get("x-unit", [])
    units = [units] if isinstance(units, str) else units
    dimensions = {unit[1] for unit in map(parse_unit, units) if unit is not None}
    patterns, what = [_WHOLE], f"{_WORDS.get(types[0], types[0])} "
    if "number" in types and dimensions:
        fitting = "|".join(re.escape(name) for name, (_, dimension) in UNITS.items() if dimension in dimensions)
        every = "|".join(map(re.escape, UNITS))
        compound = rf"({every})(\^-?\d)?([*/]({every})(\^-?\d)?)+|({every})\^-?\d"
        patterns.append(rf"{_NUMBER}({'|'.join(filter(None, [fitting, compound]))})$")
        what = f"a number in {' or '.join(filter(None, units))}, one with a unit, "
    made["pattern"] = "|".join(patterns)
    made["patternErrorMessage"] = f"Write {what}or one expression: ${{...}}."  # VS Code shows it
    return made


def draft_7(fragment: Any) -> Any:
    """Rename ``$defs`` of a schema to ``definitions``, as in draft 7, and remove annotations for the compiler."""
    if isinstance(fragment, list):
        return [draft_7(item) for item in fragment]
    if not isinstance(fragment, Mapping):
        return fragment
    made = {}
    for key, value in fragment.items():
        if key not in ANNOTATIONS and not (key == "propertyNames" and value.keys() <= ANNOTATIONS):
            made[key] = value.replace("#/$defs/", "#/definitions/") if key == "$ref" else draft_7(value)
    return made
