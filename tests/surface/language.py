"""The words of the language, each with its type, as lines: from the schema of descriptions."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from typing import Any

from support.schemas import ITEM, KEY, OTHER, PATTERN, WAY, inner, schema

_TYPES = ("type", "x-unit", "enum", "const", "pattern", "default", "minItems", "maxItems", "minimum", "maximum")
_BOUNDS = ("exclusiveMinimum", "exclusiveMaximum", "minLength", "minProperties", "maxProperties", "uniqueItems")
_STEP = {KEY: ".{}", PATTERN: "./{}/", OTHER: ".*", ITEM: "[{}]", WAY: "|{}"}


def lines() -> Iterator[str]:
    """Yield each key of each object of the schema with its type; what the schema says for people is left out."""
    whole = schema("description")
    yield from _of("description", whole)
    for name, fragment in sorted(whole["$defs"].items()):
        yield from _of(name, fragment)


def _of(name: str, fragment: Mapping[str, Any]) -> Iterator[str]:
    yield f"{name}: {_type(fragment)}"
    needed = set(fragment.get("required", ()))
    for kind, key, value in inner(fragment):
        yield from _of(name + _STEP[kind].format(key) + ("!" if kind == KEY and key in needed else ""), value)


def _type(fragment: Mapping[str, Any]) -> str:
    """Return what a value has to be, in one line."""
    said = [fragment["$ref"].rsplit("/", 1)[-1]] if "$ref" in fragment else []
    said += [f"{key}={json.dumps(fragment[key])}" for key in (*_TYPES, *_BOUNDS) if key in fragment]
    if fragment.get("additionalProperties") is False:
        said.append("closed")
    return " ".join(said) or "any"
