"""The words of the language, each with its type, as lines: from the schema of descriptions."""

from __future__ import annotations

import json
from collections.abc import Iterator
from typing import Any

from rosorin_compile.project import data_folder

_TYPES = ("type", "x-unit", "enum", "const", "pattern", "default", "minItems", "maxItems", "minimum", "maximum")
_BOUNDS = ("exclusiveMinimum", "exclusiveMaximum", "minLength", "minProperties", "maxProperties", "uniqueItems")


def lines() -> Iterator[str]:
    """Yield each key of each object of the schema with its type; what the schema says for people is left out."""
    schema = json.loads((data_folder("schemas") / "description.schema.json").read_text("utf-8"))
    yield from _of("description", schema)
    for name, fragment in sorted(schema["$defs"].items()):
        yield from _of(name, fragment)


def _of(name: str, fragment: dict[str, Any]) -> Iterator[str]:
    yield f"{name}: {_type(fragment)}"
    needed = set(fragment.get("required", ()))
    for key, value in sorted(fragment.get("properties", {}).items()):
        yield from _of(f"{name}.{key}{'!' if key in needed else ''}", value)
    for pattern, value in sorted(fragment.get("patternProperties", {}).items()):
        yield from _of(f"{name}./{pattern}/", value)
    if isinstance(fragment.get("additionalProperties"), dict):
        yield from _of(f"{name}.*", fragment["additionalProperties"])
    items = fragment.get("items")
    for number, item in enumerate(items if isinstance(items, list) else [items] if items else []):
        yield from _of(f"{name}[{number if isinstance(items, list) else ''}]", item)
    for way in ("oneOf", "anyOf", "allOf"):
        for number, value in enumerate(fragment.get(way, ())):
            yield from _of(f"{name}|{way}{number}", value)


def _type(fragment: dict[str, Any]) -> str:
    """Return what a value has to be, in one line."""
    said = [fragment["$ref"].rsplit("/", 1)[-1]] if "$ref" in fragment else []
    said += [f"{key}={json.dumps(fragment[key])}" for key in (*_TYPES, *_BOUNDS) if key in fragment]
    if fragment.get("additionalProperties") is False:
        said.append("closed")
    return " ".join(said) or "any"
