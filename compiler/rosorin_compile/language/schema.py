"""The JSON Schemas of the tool with the sections of plug-ins, and queries for sections, paths and units."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from functools import cache, lru_cache
from typing import TYPE_CHECKING, Any

from .annotations import WITHIN, Node, annotated_sections, describe_path, own_schema
from .annotations import Steps as Steps
from .section_registry import piece, plugged_sections

if TYPE_CHECKING:
    from rosorin_compile.formats import Format

TEMPLATE = "template"  # an output with this key is made by a template, whatever its name
LAST = ("accept", "outputs")  # the sections at the end of a description, behind those of plug-ins


@cache
def schema(name: str = "description") -> dict[str, Any]:
    """Return a schema that ships with the tool; that of descriptions with the sections of plug-ins."""
    own = own_schema(name)
    added = {name: piece(section) for name, section in plugged_sections().items()} if name == "description" else {}
    if not added:
        return own
    last = {name: own["properties"][name] for name in LAST}
    first = {name: fragment for name, fragment in own["properties"].items() if name not in last}
    return {**own, "properties": {**first, **added, **last}}


def keys_of(section: str) -> Collection[str]:
    """Return the keys of a section that is one entry."""
    keys: Collection[str] = resolve(schema()["properties"][section])["properties"].keys()
    return keys


def has_entries(section: str) -> bool:
    """Return True if a section has many entries, by name or in a list."""
    fragment = resolve(schema()["properties"].get(section, {}))
    return "items" in fragment or isinstance(fragment.get("additionalProperties"), dict)


@cache
def keys_of_xml() -> frozenset[str]:
    """Return the keys whose values are lists of elements of XML."""
    keys = (item for entry in (schema(), *schema()["$defs"].values()) for item in entry.get("properties", {}).items())
    return frozenset(key for key, inner in keys if inner.get("items", {}).get("$ref") == "#/$defs/element")


@cache
def sections() -> Mapping[str, Node]:
    """Return the annotations of each section of a description that has any."""
    return annotated_sections(schema())


@cache
def merged(*how: str, in_parts: bool = False) -> tuple[str, ...]:
    """Return the sections that are joined in one of some ways; with ``in_parts`` those that may stand in a part."""
    return tuple(key for key, node in sections().items() if node.merge in how and (node.in_parts or not in_parts))


@cache
def named_as(kind: str) -> tuple[str, ...]:
    """Return the sections whose keys are the names of things of a kind."""
    return tuple(key for key, node in sections().items() if node.keys is not None and node.keys.gives == kind)


@cache
def of_topic(topic: str) -> tuple[str, ...]:
    """Return the sections of a topic."""
    return tuple(key for key, node in sections().items() if node.topic == topic)


@cache
def of_parts() -> tuple[str, ...]:
    """Return the sections that may stand in a part."""
    return tuple(key for key, node in sections().items() if node.in_parts)


@cache
def of_types() -> tuple[str, ...]:
    """Return the keys of a sensor that a type of sensors may say, in the order of the schema."""
    entries = [node.others for node in sections().values() if node.others is not None]
    return tuple(
        key for entry in entries for key, node in entry.properties.items() if node is not None and node.in_types
    )


def is_one_entry(section: str) -> bool:
    """Return True if a section of a part is one entry, not many by name or in a list."""
    node = sections().get(section)
    return node is not None and node.in_parts and node.merge in ("", WITHIN)


def holds_many(section: str) -> bool:
    """Return True if a section is one entry with entries by name in it, which several parts and files may add to."""
    return section in merged(WITHIN)


def with_outputs(outputs: Any, formats: Mapping[str, Format]) -> dict[str, Any]:
    """Return the schema of descriptions with the options of the outputs of one; each entry by its format."""
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
    """Return the backend of an entry of outputs that does not say it: its name, unless it names a template."""
    return TEMPLATE if TEMPLATE in entry else name


def subject(path: Steps) -> str:
    """Return a path in words: ``joint "joint1" limit lower``.

    >>> subject(["joints", "joint1", "xyz", 2])
    'joint "joint1" xyz[2]'
    """
    return describe_path(path, schema())


def part_at(path: Steps, whole: Mapping[str, Any]) -> tuple[Any, str]:
    """Return the part of a schema that a validator came to on a path, and the last definition on the way ("": none).

    What ``then`` says is found with or without ``if`` before it: jsonschema 3.2 names it.
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
    """Return the unit (or units) that the schema asks for at a path of a description; "" for a plain number.

    None where the schema has no number at all.
    """
    node = fragment_at(path)
    if node.get("type") not in ("number", "integer") and "x-unit" not in node:  # a number, or a list of them
        return None
    unit: str | list[str] = node.get("x-unit", "")
    return unit


def joint_unit(path: Sequence[str | int], slides: bool, leader_slides: bool | None = None) -> str | None:
    """Return the unit of a number that belongs to a joint, where the schema leaves it to the type of the joint.

    ``slides`` is true for a prismatic joint; ``leader_slides`` is the same for the joint that it follows.
    """
    units = unit_at(path)
    if units is None or isinstance(units, str):
        return units
    if tuple(path[-2:]) != ("mimic", "multiplier"):
        return units[-1 if slides else 0]
    plain, per_angle, per_length = units  # the unit of the follower over that of its leader
    return plain if leader_slides in (None, slides) else per_angle if slides else per_length


def fragment_at(path: Sequence[str | int]) -> Mapping[str, Any]:
    """Return what the schema says of the value at a path of a description; nothing where it says nothing.

    Of what is said beside a reference and behind it, the nearer one counts.
    """
    # The names of entries and the indices of items make no difference: what is asked for is found once for all.
    steps = [0 if isinstance(step, int) else step for step in path]
    if len(steps) > 1 and has_entries(str(steps[0])):
        steps[1] = "*"
    return _fragment_at(tuple(steps))


@lru_cache(maxsize=2_000)
def _fragment_at(path: tuple[str | int, ...]) -> Mapping[str, Any]:
    node: Any = schema()
    for step in path:
        inner = node.get("items")
        if not isinstance(step, int):
            inner = node.get("properties", {}).get(step, node.get("additionalProperties", inner))
        if not isinstance(inner, dict):
            return {}
        node = {**resolve(inner), **inner} if "$ref" in inner else inner
    found: Mapping[str, Any] = node
    return found


def resolve(node: dict[str, Any]) -> dict[str, Any]:
    """Return what a fragment of the schema of descriptions refers to, or the fragment itself."""
    reference = node.get("$ref")
    return schema()["$defs"][reference.rsplit("/", 1)[1]] if reference else node
