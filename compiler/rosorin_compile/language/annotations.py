"""Load the JSON Schemas that ship with the tool, parse their ``x-...`` annotations, and validate data.

The annotations are explained in ``schemas/README.md``. Validation follows JSON Schema draft 7 and works with jsonschema
3.2 and later. Its versions differ in the order and text of errors and in the cost of ``$ref``. Therefore, errors are
sorted by position and reworded here, and references are replaced by their targets before validation.
"""

from __future__ import annotations

import json
import math
from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from functools import cache, reduce
from operator import getitem
from typing import Any, Literal, NamedTuple, cast

from rosorin_compile.source import files
from rosorin_compile.source.diagnostics import UnknownName
from rosorin_compile.source.project import data_folder
from rosorin_compile.source.units import UNITS, Quantity, parse_unit

Steps = list[str | int]

_TYPES = ("null", "boolean", "integer", "number", "string", "array", "object")
_NUMBERS = (float, int, Quantity)
_NAMING = ("required", "dependencies")
_BESIDE_REFERENCE = r"^(\$ref|description|title|default|examples|x-.*)$"


@cache
def own_schema(name: str = "description") -> dict[str, Any]:
    """Load the JSON Schema ``schemas/NAME.schema.json``, without the sections that plug-ins add."""
    made: dict[str, Any] = json.loads(files.read_text(data_folder("schemas") / f"{name}.schema.json"))
    return made


def describe_path(path: Steps, whole: Mapping[str, Any]) -> str:
    """Format a path for messages, such as ``"limit.lower" of joint "joint1"``; ``whole`` is the description schema."""
    if not path:
        return "the description"
    called = whole["properties"].get(path[0], {}).get("x-called") if len(path) > 1 else ""
    keys = "".join(f"[{step}]" if isinstance(step, int) else f".{step}" for step in path[2 if called else 0 :])
    owner = f'{called} "{path[1]}"' if called else ""
    return f'"{keys[1:]}"{owner and f" of {owner}"}' if keys else owner


# For each kind of name, the kinds that are accepted in its place: in the MJCF, every frame is also a site,
# unnamed actuators and cameras get the name of their joint or sensor, and shapes are named LINK_collision_1.
ALSO: dict[str, tuple[str, ...]] = {"site": ("link",), "actuator": ("joint",), "camera": ("sensor",)}
ALSO |= {"shape": ("link",), "sensor": ("hardware sensor",), "link or joint": ("link", "joint")}
# The keys that mirroring changes, by value of ``x-mirror``; the schema fragment must define at least one of them.
# The value "sides" is not listed: it renames keys (left to right) instead of changing values.
MIRRORED_KEYS: dict[str, tuple[str, ...]] = {"pose": ("xyz", "rpy"), "grid": ("origin", "heights", "bottom")}
MIRRORED_KEYS |= {"inertia": ("ixy", "ixz", "iyz"), "bounds": ("min", "max")}
MIRRORED_KEYS |= {key: (key,) for key in ("axis", "direction", "dir", "at", "scale", "gear", "surfacevel")}
MIRRORED_KEYS |= dict.fromkeys(("camera", "sensor", "optical"), ("xyz", "rpy"))
MIRROR, GIVES, NAMES, INSIDE, SPELT = "x-mirror", "x-gives", "x-names", "x-names-in", "x-spelt"
ROBOT, WORLD = "robot", "world"
SIMULATION, DESCRIPTION = "simulation", "description"
ENTRIES, ITEMS, WITHIN = "entries", "items", "within"


class Node(NamedTuple):
    """The ``x-...`` annotations (``schemas/README.md``) of a schema, and the nodes of its properties and items."""

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
        """Return the node for the value of ``key``, or None if the schema of that value has no annotations."""
        return self.properties.get(key, self.others)

    def left_out(self, entry: Mapping[str, Any]) -> Iterator[tuple[str, str, str]]:
        """Yield (key, kind of name, default) for each missing key with a default name such as ``FRAME_joint``."""
        for key, below in self.properties.items():
            if below is not None and below.otherwise and key not in entry:
                with suppress(KeyError):  # the default refers to a key that is also missing
                    yield key, below.gives, below.otherwise.format_map(texts(entry))


_BELOW = {"propertyNames": "keys", "additionalProperties": "others", "items": "items"}
# ``WORDS`` maps each annotation to its field of ``Node``, such as "x-in-parts" to "in_parts".
_FIELDS = Node._fields[: Node._fields.index("keys")]
WORDS = {INSIDE if field == "inside" else f"x-{field.replace('_', '-')}": field for field in _FIELDS}
# All annotations, including annotations that are not in ``Node`` because only messages, lowering or import use them.
ANNOTATIONS = frozenset((*WORDS, "x-unmirrored", "x-also", "x-instead", "x-file", "x-first", "x-ordered", "x-form"))


def texts(entry: Mapping[str, Any]) -> dict[str, str]:
    """Return a copy of a mapping with only its string values."""
    return {key: value for key, value in entry.items() if isinstance(value, str)}


def annotated_sections(whole: Mapping[str, Any]) -> dict[str, Node]:
    """Map each section of the description schema ``whole`` to its annotations; omit sections without annotations."""
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
    """Raise ValueError if the schema of a plug-in has an invalid annotation; ``own`` is the built-in schema."""
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
    """Return all values of an annotation in a schema, such as the kinds of names that it defines (``x-gives``)."""
    return {value for word, value in _annotations(piece) if word == annotation}


def mappings_in(piece: Any) -> Iterator[Mapping[str, Any]]:
    """Yield all mappings in a schema recursively, beginning with the schema itself."""
    if isinstance(piece, Mapping):
        yield piece
    for inner in piece.values() if isinstance(piece, Mapping) else piece if isinstance(piece, list) else ():
        yield from mappings_in(inner)


def _annotations(piece: Any) -> Iterator[tuple[str, Any]]:
    for part in mappings_in(piece):
        yield from ((word, value) for word, value in part.items() if word.startswith("x-"))


class Misfit(NamedTuple):
    """A JSON Schema validation error: ``value`` at ``path`` violates the constraint ``keyword: wanted``.

    ``part`` is the schema fragment with the constraint. For "required" and "dependencies", ``key`` is the missing key.
    For "propertyNames", ``value`` is the invalid key, and ``path`` the path of the mapping that contains it.
    """

    path: Steps
    keyword: str
    wanted: Any
    value: Any
    part: Mapping[str, Any]
    schema_path: Steps
    key: str = ""

    def unexpected_keys(self) -> list[str]:
        """Return the keys of ``value`` that ``additionalProperties`` does not allow."""
        return [key for key in self.value if key not in self.part.get("properties", {})]

    def kinds(self) -> list[str]:
        """Return the JSON types that the keyword ``type`` allows, in a fixed order."""
        return sorted([self.wanted] if isinstance(self.wanted, str) else self.wanted, key=_TYPES.index)


def validator_of(schema: Mapping[str, Any]) -> Any:
    """Return a jsonschema validator (draft 7) for a schema."""
    return _draft_7()(inline_references(schema))


@cache
def _draft_7() -> Any:
    from jsonschema import Draft7Validator, validators  # the import takes 45 ms

    keywords, extend = Draft7Validator.VALIDATORS, cast(Any, validators.extend)
    others = keywords.keys() - {"type", "minimum"}

    def is_number(value: Any, part: Any) -> bool:
        # Most values are numbers. jsonschema takes 20 times as long for each of them as this comparison.
        is_plain = type(value) in _NUMBERS and isinstance(part, dict) and part.get("type") == "number"
        return is_plain and others.isdisjoint(part) and not value < part.get("minimum", -math.inf)

    def items(validator: Any, part: Any, value: Any, schema: Any) -> Any:
        is_done = isinstance(value, list) and all(is_number(item, part) for item in value)
        return () if is_done else keywords["items"](validator, part, value, schema)

    def properties(validator: Any, parts: Any, value: Any, schema: Any) -> Any:
        some = value.items() if isinstance(value, dict) else ()
        left = {key: parts[key] for key, item in some if key in parts and not is_number(item, parts[key])}
        return keywords["properties"](validator, left, value, schema)

    return extend(Draft7Validator, {"items": items, "properties": properties})


@cache
def validator(name: str) -> Any:
    """Return the validator for ``schemas/NAME.schema.json``; the result is cached."""
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
            if isinstance(pattern := made.get("pattern"), str):  # convert from JavaScript to Python syntax
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
    """Validate a JSON value and return the errors in the order of their positions in the value."""
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
        node, steps = value, []
        for step in misfit.path:
            steps.append(step if isinstance(step, int) else list(node).index(step))
            node = node[step]
        return steps

    return sorted(found, key=place)


def misfits(name: str, value: Any) -> list[str]:
    """Validate a JSON value against ``schemas/NAME.schema.json`` and return one message per error."""
    return [f"{describe_path(one.path, own_schema())}: {words_of(one)}" for one in misfits_of(validator(name), value)]


def words_of(misfit: Misfit) -> str:
    """Format a validation error in JSON data as a message."""
    if misfit.keyword in _NAMING:
        return f"{_json(misfit.key)} is a required property"
    if misfit.keyword == "additionalProperties":
        return f"unknown properties: {', '.join(misfit.unexpected_keys())}"
    return f"{_json(misfit.value)} does not match {misfit.keyword} {_json(misfit.wanted)}"


def _json(value: Any) -> str:
    return json.dumps(value, ensure_ascii=False, separators=(",", ":"))[:200]


def check_schema(part: Mapping[str, Any], whole: Mapping[str, Any]) -> None:
    """Raise ValueError if ``part`` is not a valid JSON Schema (draft 7), or if a ``$ref`` in ``whole`` has no target.

    Unlike draft 7, reject unknown keywords (except ``x-...``) and keywords next to ``$ref``.
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
