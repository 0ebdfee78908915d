"""Load the schemas that ship with the tool, parse the annotations in them (``schemas/README.md``), and validate data.

Validation follows JSON Schema draft 7, with any version of jsonschema from 3.2 on. These versions differ in the order
and the text of errors, and in the cost of ``$ref``. So errors are sorted by position and reworded here, and references
are replaced by their targets before validation.
"""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from functools import cache, reduce
from operator import getitem
from typing import Any, Literal, NamedTuple

from rosorin_compile.source import files
from rosorin_compile.source.diagnostics import UnknownName
from rosorin_compile.source.project import data_folder
from rosorin_compile.source.units import UNITS, parse_unit

Steps = list[str | int]

_TYPES = ("null", "boolean", "integer", "number", "string", "array", "object")
_NAMING = ("required", "dependencies")
_BESIDE_REFERENCE = r"^(\$ref|description|title|default|examples|x-.*)$"


@cache
def own_schema(name: str = "description") -> dict[str, Any]:
    """Return a schema that ships with the tool, without the sections of plug-ins."""
    made: dict[str, Any] = json.loads(files.read_text(data_folder("schemas") / f"{name}.schema.json"))
    return made


def describe_path(path: Steps, whole: Mapping[str, Any]) -> str:
    """Format a path for messages: ``"limit.lower" of joint "joint1"``; ``whole`` is the schema of descriptions."""
    if not path:
        return "the description"
    called = whole["properties"].get(path[0], {}).get("x-called") if len(path) > 1 else ""
    keys = "".join(f"[{step}]" if isinstance(step, int) else f".{step}" for step in path[2 if called else 0 :])
    owner = f'{called} "{path[1]}"' if called else ""
    return f'"{keys[1:]}"{owner and f" of {owner}"}' if keys else owner


# Kinds whose names are also valid where a name of another kind is required: every frame is also a site in the MJCF,
# unnamed actuators and cameras get the name of their joint or sensor, and shapes are named LINK_collision_1.
ALSO: dict[str, tuple[str, ...]] = {"site": ("link",), "actuator": ("joint",), "camera": ("sensor",)}
ALSO |= {"shape": ("link",), "sensor": ("hardware sensor",), "link or joint": ("link", "joint")}
# For each value of x-mirror, the keys that mirroring changes; the schema must define at least one of them.
# The value "sides" is not listed: it renames keys (left to right) instead of changing values.
MIRRORED_KEYS: dict[str, tuple[str, ...]] = {"pose": ("xyz", "rpy"), "grid": ("origin", "heights", "bottom")}
MIRRORED_KEYS |= {"inertia": ("ixy", "ixz", "iyz"), "bounds": ("min", "max")}
MIRRORED_KEYS |= {key: (key,) for key in ("axis", "direction", "dir", "at", "scale", "gear")}
MIRROR, GIVES, NAMES, INSIDE, SPELT = "x-mirror", "x-gives", "x-names", "x-names-in", "x-spelt"
ROBOT, WORLD = "robot", "world"
SIMULATION, DESCRIPTION = "simulation", "description"
ENTRIES, ITEMS, WITHIN = "entries", "items", "within"


class Node(NamedTuple):
    """The annotations (``x-...``) of a schema fragment, and of the schema fragments in it."""

    names: str = ""
    gives: str = ""
    otherwise: str = ""
    scope: str = ""
    spelt: str = ""
    said: str | Literal[False] = ""
    among: str = ""
    inside: str = ""
    mirror: Sequence[str] = ()
    attached: Sequence[str] = ()
    in_parts: bool = False
    in_types: bool = False
    accepted: Sequence[str] = ()
    whole: bool = False
    called: str = ""
    explained: bool | str = False
    topic: str = ""
    compared: str = ""
    merge: str = ""
    sourced: bool = False
    within: str = ""
    keys: Node | None = None
    properties: Mapping[str, Node | None] = {}
    others: Node | None = None
    items: Node | None = None
    of: frozenset[str] = frozenset()

    def value_of(self, key: str) -> Node | None:
        """Return the annotations for the value of a key, or None if there are none."""
        return self.properties.get(key, self.others)

    def left_out(self, entry: Mapping[str, Any]) -> Iterator[tuple[str, str, str]]:
        """Yield each missing key whose default is derived from other keys, with the kind and value of the default."""
        for key, below in self.properties.items():
            if below is not None and below.otherwise and key not in entry:
                with suppress(KeyError):  # the key from which the default is derived is also missing
                    yield key, below.gives, below.otherwise.format_map(texts(entry))


_BELOW = {"propertyNames": "keys", "additionalProperties": "others", "items": "items"}
# Annotations in the schema, and the field of ``Node`` for each.
_FIELDS = Node._fields[: Node._fields.index("keys")]
WORDS = {INSIDE if field == "inside" else f"x-{field.replace('_', '-')}": field for field in _FIELDS}
# All annotations, including those that only suggestions, lowering and import read. Validators and editors ignore them.
ANNOTATIONS = frozenset((*WORDS, "x-unmirrored", "x-also", "x-instead", "x-file", "x-first", "x-ordered"))


def texts(entry: Mapping[str, Any]) -> dict[str, str]:
    """Return the entries of a mapping whose values are strings."""
    return {key: value for key, value in entry.items() if isinstance(value, str)}


def annotated_sections(whole: Mapping[str, Any]) -> dict[str, Node]:
    """Return the annotations of each section of a description schema; omit sections without annotations."""
    definitions: dict[str, Node | None] = {}

    def node_of(fragment: Any) -> Node | None:
        if not isinstance(fragment, Mapping):
            return None
        name = fragment.get("$ref", "").rpartition("/")[2]
        if name and name not in definitions:
            definitions[name] = node_of(whole["$defs"][name])
        base = definitions.get(name)
        found: dict[str, Any] = {WORDS[word]: value for word, value in fragment.items() if word in WORDS}
        below = {of: node_of(fragment.get(word)) for word, of in _BELOW.items()}
        found |= {of: node for of, node in below.items() if node is not None}
        properties = {key: node_of(one) for key, one in fragment.get("properties", {}).items()}
        found |= {"properties": properties} if any(properties.values()) else {}
        if not found:
            return base
        made = (base or Node())._replace(**found)
        words = [word for word, value in ((MIRROR, made.mirror), (INSIDE, made.inside), (SPELT, made.spelt)) if value]
        if made.gives and not made.scope:
            words.append(GIVES)
        elif (kind := made.names or made.gives) and made.scope != ROBOT:
            words += [kind, *ALSO.get(kind, ())]
        inner = (made.keys, made.others, made.items, *made.properties.values())
        return made._replace(of=frozenset(words).union(*(one.of for one in inner if one is not None)))

    nodes = {key: node_of(fragment) for key, fragment in whole["properties"].items()}
    return {key: node for key, node in nodes.items() if node is not None}


def check_annotations(piece: Any, own: Mapping[str, Any]) -> None:
    """Raise ValueError for an invalid annotation, key or unit in a schema fragment; ``own`` is the built-in schema."""
    words = {word for word, _ in _annotations(own)} | ANNOTATIONS
    for word, value in _annotations(piece):
        if word not in words:
            raise UnknownName("annotation", word, words, "the schema")
        for unit in (value if isinstance(value, list) else [value]) if word == "x-unit" else ():
            if unit and parse_unit(unit) is None:
                raise UnknownName("unit for x-unit", unit, UNITS)
    for part in mappings_in(piece):
        keys = part.get("properties", {})
        for way in part.get(MIRROR, ()):
            if way not in MIRRORED_KEYS:
                raise UnknownName(f"value for {MIRROR}", way, MIRRORED_KEYS)
            if keys.keys().isdisjoint(MIRRORED_KEYS[way]):
                raise ValueError(f"{MIRROR} is {way} in its schema, beside no {' and no '.join(MIRRORED_KEYS[way])}")
        attached = (key for one in keys.values() if isinstance(one, Mapping) for key in one.get("x-attached", ()))
        for key in (key for key in attached if key not in keys):
            raise UnknownName("key for x-attached", key, keys, "the schema")


def kinds_of(piece: Any, annotation: str) -> set[str]:
    """Return the kinds of names that a schema fragment defines (``x-gives``) or refers to (``x-names``)."""
    return {value for word, value in _annotations(piece) if word == annotation}


def mappings_in(piece: Any) -> Iterator[Mapping[str, Any]]:
    """Yield a schema fragment and all mappings in it."""
    if isinstance(piece, Mapping):
        yield piece
    for inner in piece.values() if isinstance(piece, Mapping) else piece if isinstance(piece, list) else ():
        yield from mappings_in(inner)


def _annotations(piece: Any) -> Iterator[tuple[str, Any]]:
    for part in mappings_in(piece):
        yield from ((word, value) for word, value in part.items() if word.startswith("x-"))


class Misfit(NamedTuple):
    """A validation error: the ``value`` at ``path`` violates ``keyword: wanted`` of the JSON Schema fragment ``part``.

    For ``propertyNames``, ``value`` is the invalid key, and ``path`` leads to its mapping. ``key`` is a missing key.
    """

    path: Steps
    keyword: str
    wanted: Any
    value: Any
    part: Mapping[str, Any]
    schema_path: Steps
    key: str = ""

    def unexpected_keys(self) -> list[str]:
        """Return the keys that ``additionalProperties`` does not allow."""
        return [key for key in self.value if key not in self.part.get("properties", {})]

    def kinds(self) -> list[str]:
        """Return the allowed types in a fixed order."""
        return sorted([self.wanted] if isinstance(self.wanted, str) else self.wanted, key=_TYPES.index)


def validator_of(schema: Mapping[str, Any]) -> Any:
    """Return a jsonschema validator for a schema."""
    from jsonschema import Draft7Validator  # takes 45 ms: import only if something changed

    return Draft7Validator(inline_references(schema))


@cache
def validator(name: str) -> Any:
    """Return the validator of a schema that ships with the tool."""
    return validator_of(own_schema(name))


def inline_references(whole: Mapping[str, Any]) -> dict[str, Any]:
    """Return a schema with each ``$ref`` replaced by its target. The schema must not be recursive."""
    done: dict[str, Any] = {}

    def of(part: Any) -> Any:
        if isinstance(part, list):
            return [of(one) for one in part]
        if not isinstance(part, Mapping):
            return part
        if not isinstance(name := part.get("$ref"), str):
            made = {key: of(one) for key, one in part.items() if key != "$defs"}
            if isinstance(pattern := made.get("pattern"), str):  # JSON Schema patterns have the syntax of JavaScript
                pattern = pattern.replace("\\d", "[0-9]").replace("\\s", r"\s\ufeff")
                made["pattern"] = pattern[:-1] + r"(?!\n)$" if pattern.endswith("$") else pattern
            return made
        if name not in done:
            try:
                done[name] = of(reduce(getitem, name.removeprefix("#/").split("/"), whole))
            except (KeyError, TypeError):
                raise ValueError(f"the schema has nothing that $ref names: {name}") from None
        return done[name]

    inlined: dict[str, Any] = of(whole)
    return inlined


def misfits_of(validator: Any, value: Any) -> list[Misfit]:
    """Validate a value; return the errors sorted by their position in it."""
    found: list[Misfit] = []
    reported = set()
    for error in validator.iter_errors(value):
        path, schema_path = list(error.absolute_path), list(error.absolute_schema_path)
        misfit = Misfit(path, error.validator, error.validator_value, error.instance, error.schema, schema_path)
        if error.validator not in _NAMING:
            found.append(misfit)
        elif (where := repr((path, schema_path))) not in reported:  # jsonschema may yield one error per missing key
            reported.add(where)
            keys = error.validator_value
            if error.validator == "dependencies":
                keys = [key for given, wanted in keys.items() if given in error.instance for key in wanted]
            found += [misfit._replace(key=key) for key in dict.fromkeys(keys) if key not in error.instance]

    def place(misfit: Misfit) -> list[int]:
        """Return the path of a misfit with each key replaced by its index in the mapping, as a sort key."""
        node, steps = value, []
        for step in misfit.path:
            steps.append(step if isinstance(step, int) else list(node).index(step))
            node = node[step]
        return steps

    return sorted(found, key=place)


def misfits(name: str, value: Any) -> list[str]:
    """Validate a JSON value against a schema that ships with the tool; return a message for each error."""
    return [f"{describe_path(one.path, own_schema())}: {words_of(one)}" for one in misfits_of(validator(name), value)]


def words_of(misfit: Misfit) -> str:
    """Return the message for an error in JSON data."""
    if misfit.keyword in _NAMING:
        return f"{_json(misfit.key)} is a required property"
    if misfit.keyword == "additionalProperties":
        return f"unknown properties: {', '.join(misfit.unexpected_keys())}"
    return f"{_json(misfit.value)} does not match {misfit.keyword} {_json(misfit.wanted)}"


def _json(value: Any) -> str:
    return json.dumps(value, ensure_ascii=False, separators=(",", ":"))[:200]


def check_schema(part: Mapping[str, Any], whole: Mapping[str, Any]) -> None:
    """Raise ValueError if a schema fragment is invalid in draft 7, or has a reference without a target.

    Keywords that draft 7 ignores are also errors: unknown keywords (except ``x-...``), and keywords next to ``$ref``.
    """
    from jsonschema import Draft7Validator, FormatChecker

    draft = {key: value for key, value in Draft7Validator.META_SCHEMA.items() if key != "$id"}
    draft |= {"patternProperties": {"^x-": {}}, "additionalProperties": False}
    draft |= {"if": {"required": ["$ref"]}, "then": {"propertyNames": {"pattern": _BESIDE_REFERENCE}}}
    for misfit in misfits_of(Draft7Validator(draft, format_checker=FormatChecker(["regex"])), dict(part)):
        if misfit.keyword == "additionalProperties":
            unknown = next(word for word in misfit.unexpected_keys() if not word.startswith("x-"))
            raise UnknownName("keyword", unknown, draft["properties"], "JSON Schema draft 7")
        raise ValueError(words_of(misfit))
    inline_references(whole)
