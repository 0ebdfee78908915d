"""The JSON schemas of the artifacts and of what commands print, and how they are walked through."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from typing import Any, NamedTuple

from rosorin_compile.language.schema import own_schema
from support.paths import SCHEMAS

KEY, PATTERN, OTHER, ITEM, WAY = "key", "pattern", "other key", "item", "way"
WAYS = ("oneOf", "anyOf", "allOf")


def schema(name: str) -> Any:
    """Return a schema of the folder schemas."""
    if name == "description":  # of which pieces stand in the folders of sections
        return own_schema()
    return json.loads((SCHEMAS / f"{name}.schema.json").read_text("utf-8"))


class Inner(NamedTuple):
    """A schema within a schema: of a key by its name, of keys by their pattern, of all other keys, of items, a way.

    Items of a list that has a schema for each place have its number for a name, a way has its word and number.
    """

    kind: str
    name: str
    fragment: Mapping[str, Any]


def inner(fragment: Mapping[str, Any]) -> Iterator[Inner]:
    """Yield the schemas right within a schema; what it refers to is none of them."""
    for name, value in sorted(fragment.get("properties", {}).items()):
        yield Inner(KEY, name, value)
    for pattern, value in sorted(fragment.get("patternProperties", {}).items()):
        yield Inner(PATTERN, pattern, value)
    if isinstance(fragment.get("additionalProperties"), dict):
        yield Inner(OTHER, "", fragment["additionalProperties"])
    items = fragment.get("items")
    if isinstance(items, dict):
        yield Inner(ITEM, "", items)
    for number, value in enumerate(items if isinstance(items, list) else ()):
        yield Inner(ITEM, str(number), value)
    for way in WAYS:
        for number, value in enumerate(fragment.get(way, ())):
            yield Inner(WAY, f"{way}{number}", value)


def properties(described: Any, path: str = "") -> list[tuple[str, Any]]:
    """Return each property and each list item of a schema with its path, and what it names in $defs once."""
    found = []
    if isinstance(described, dict):
        found += [one for name, inner in described.get("$defs", {}).items() for one in properties(inner, f"#{name}")]
        for name, inner in described.get("properties", {}).items():
            found += [(f"{path}/{name}", inner), *properties(inner, f"{path}/{name}")]
        items = described.get("items")
        inner_schemas = [*(items if isinstance(items, list) else [items]), described.get("additionalProperties")]
        for inner in [*inner_schemas, *described.get("oneOf", [])]:
            found += ([(f"{path}[]", inner)] if isinstance(inner, dict) else []) + properties(inner, f"{path}[]")
    return found
