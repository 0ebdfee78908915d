"""Leaves of the language: the keys of a description that carry a value, and other values for them.

The key of a leaf has no names of entries: that of joints -> elbow -> limit -> upper is ``joints.limit.upper``.
"""

from __future__ import annotations

import json
import re
from collections import defaultdict
from collections.abc import Iterator, Mapping
from itertools import permutations
from typing import Any, NamedTuple

from rosorin_compile.language.schema import own_schema

Path = tuple[str | int, ...]
SCHEMA = own_schema("description")
# What only readers of the description need; formats carry nothing of it.
ABOUT_THE_DESCRIPTION = ("rosorin_compile", "include", "args", "let", "accept", "outputs")
_SOURCE = "source"
_FEW = 6


class Leaf(NamedTuple):
    """A value of a description: its key, its path, and its schema."""

    key: str
    path: Path
    schema: Mapping[str, Any]


def all_keys() -> set[str]:
    """Return the keys of all leaves that the schema has."""
    return {".".join(key) for key in _keys(SCHEMA, (), ())}


def leaves(description: Mapping[str, Any]) -> list[Leaf]:
    """Return the leaves that a description sets."""
    return list(_leaves(SCHEMA, description, (), ()))


def _forms(schema: Mapping[str, Any]) -> list[Mapping[str, Any]]:
    while "$ref" in schema:
        rest = {key: value for key, value in schema.items() if key != "$ref"}
        schema = {**SCHEMA["$defs"][schema["$ref"].rsplit("/", 1)[-1]], **rest}
    inner = [form for way in ("oneOf", "anyOf", "allOf") for one in schema.get(way, ()) for form in _forms(one)]
    return [schema, *inner]


def _is_entry(schema: Mapping[str, Any]) -> bool:
    return any("properties" in form for form in _forms(schema))


def _below(schema: Mapping[str, Any]) -> Iterator[tuple[str, Mapping[str, Any]]]:
    """Yield the schemas of what a value holds: by key, "*" for keys that are names, "#" for entries of lists."""
    for form in _forms(schema):
        for key, value in form.get("properties", {}).items():
            if key != _SOURCE:
                yield key, value
        others, items = form.get("additionalProperties"), form.get("items")
        if isinstance(others, dict):
            yield "*", others
        if isinstance(items, dict) and _is_entry(items):
            yield "#", items


def _keys(schema: Mapping[str, Any], key: tuple[str, ...], within: tuple[str, ...]) -> Iterator[tuple[str, ...]]:
    reference = schema.get("$ref", "")
    if reference and reference in within:
        return
    below = list(_below(schema))
    for step, inner in below:
        if key or step not in ABOUT_THE_DESCRIPTION:
            more = (step,) if step not in ("*", "#") else ()
            yield from _keys(inner, (*key, *more), (*within, reference) if reference else within)
    if not below:
        yield key


def _leaves(schema: Mapping[str, Any], value: Any, path: Path, key: tuple[str, ...]) -> Iterator[Leaf]:
    below = defaultdict[str, list[Mapping[str, Any]]](list)
    for step, inner in _below(schema):
        below[step].append(inner)
    if isinstance(value, dict) and below:
        for name, item in value.items():
            if name == _SOURCE or (not key and name in ABOUT_THE_DESCRIPTION):
                continue
            more = (name,) if name in below else ()
            inner = {"anyOf": below.get(name) or below["*"]}
            yield from _leaves(inner, item, (*path, name), (*key, *more))
    elif isinstance(value, list) and below.get("#") and any(isinstance(item, dict) for item in value):
        for index, item in enumerate(value):
            yield from _leaves({"anyOf": below["#"]}, item, (*path, index), key)
    else:
        yield Leaf(".".join(key), path, schema)


def names_by_kind(description: Mapping[str, Any]) -> dict[str, list[str]]:
    """Return the names that a description gives, by kind as the schema calls it: link, joint, material ..."""
    names = defaultdict[str, list[str]](list)

    def walk(schema: Mapping[str, Any], value: Any) -> None:
        for form in _forms(schema):
            if "x-gives" in form and isinstance(value, str):
                names[form["x-gives"]].append(value)
            if isinstance(value, dict):
                names[form.get("propertyNames", {}).get("x-gives", "")] += value
                known = form.get("properties", {})
                for key, item in value.items():
                    inner = known.get(key, form.get("additionalProperties"))
                    if isinstance(inner, dict):
                        walk(inner, item)
            elif isinstance(value, list) and isinstance(form.get("items"), dict):
                for item in value:
                    walk(form["items"], item)

    walk(SCHEMA, description)
    return names


def value_at(description: Any, path: Path) -> Any:
    """Return the value at a path."""
    for step in path:
        description = description[step]
    return description


def changed(description: Mapping[str, Any], leaf: Leaf, names: Mapping[str, list[str]]) -> Iterator[dict[str, Any]]:
    """Yield descriptions that differ in the value of one leaf; not all of them are valid."""
    old = value_at(description, leaf.path)
    forms = _forms(leaf.schema)
    for value in _others(old, forms, names):
        yield _with(description, leaf.path, value)
    if leaf.key.endswith(".when"):  # which depends on a mode: on another one, everywhere
        for mode, other in permutations(names["mode"], 2):
            yield json.loads(json.dumps(description).replace(mode, other))
    if isinstance(old, str) and old and not any("enum" in form for form in forms):
        text = json.dumps(description)
        yield json.loads(text.replace(f'{json.dumps(old)[:-1]}"', f'{json.dumps(old)[:-1]}_x"'))
    yield _without(description, leaf.path)


def _others(value: Any, forms: list[Mapping[str, Any]], names: Mapping[str, list[str]]) -> Iterator[Any]:
    if isinstance(value, bool):
        yield not value
    for form in forms:
        yield from (other for other in form.get("enum", ()) if other != value)
    if isinstance(value, int) and not isinstance(value, bool):
        yield from (value + 1, value - 1)
    elif isinstance(value, float):
        yield from (value * 1.1, value * 0.9, value * 1.0001) if value else (0.01, -0.01)
    elif isinstance(value, str):
        kinds = [form["x-names"] for form in forms if form.get("x-names")]
        yield from (name for kind in kinds for name in _named(kind, names) if name != value)
        if not kinds:
            if "<" in value:
                yield re.sub(r"\d(?=[^\d]*$)", lambda digit: str((int(digit[0]) + 1) % 10), value)
            yield f"{value}_x"
    elif isinstance(value, list):
        yield from _other_lists(value, forms, names)
    elif isinstance(value, dict):
        for key, item in value.items():
            yield from ({**value, key: other} for other in _others(item, [{}], names))


def _other_lists(value: list[Any], forms: list[Mapping[str, Any]], names: Mapping[str, list[str]]) -> Iterator[Any]:
    items = [inner for form in forms if isinstance(form.get("items"), dict) for inner in _forms(form["items"])]
    for index in range(min(len(value), 3)):
        for number, other in enumerate(_others(value[index], items, names)):
            if number < _FEW:
                yield [*value[:index], other, *value[index + 1 :]]
    if len(value) > 1:
        yield value[:-1]
        yield value[::-1]
    kinds = [form["x-names"] for form in items if form.get("x-names")]
    yield from ([*value, name] for kind in kinds for name in _named(kind, names)[:_FEW] if name not in value)


def _named(kind: str, names: Mapping[str, list[str]]) -> list[str]:
    return [name for one in kind.split(" or ") for name in names.get(one, ())]


def _with(description: Mapping[str, Any], path: Path, value: Any) -> dict[str, Any]:
    """Return a description with another value at a path; what it shares with the old one is not changed."""
    made: Any = description.copy()  # type: ignore[attr-defined]
    inner = made
    for step in path[:-1]:
        inner[step] = inner[step].copy()
        inner = inner[step]
    inner[path[-1]] = value
    result: dict[str, Any] = made
    return result


def _without(description: Mapping[str, Any], path: Path) -> dict[str, Any]:
    made = _with(description, path, None)
    del value_at(made, path[:-1])[path[-1]]
    return made
