"""The words of the language, and those that a value of it uses: KIND.WORD, as the schema of descriptions has them."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

_WAYS = ("oneOf", "anyOf", "allOf")
_TOP = "description"


def words(schema: Mapping[str, Any]) -> set[str]:
    """Return all words of a schema."""
    kinds = {_TOP: schema, **schema["$defs"]}
    return {word for name, fragment in kinds.items() for word in _words(name, fragment)}


def used(schema: Mapping[str, Any], value: Any) -> set[str]:
    """Return the words of a schema that stand in a description; keys that are no words are let be."""
    return set(_used(schema["$defs"], _TOP, schema, value))


def _words(name: str, fragment: Mapping[str, Any]) -> Iterator[str]:
    for key, value in fragment.get("properties", {}).items():
        yield f"{name}.{key}"
        yield from _words(f"{name}.{key}", value)
    for value in _others(fragment):
        yield from _words(f"{name}.*", value)
    for value in _items(fragment):
        yield from _words(f"{name}[]", value)
    for way in _WAYS:
        for value in fragment.get(way, ()):
            yield from _words(name, value)


def _used(kinds: Mapping[str, Any], name: str, fragment: Mapping[str, Any], value: Any) -> Iterator[str]:
    if "$ref" in fragment:
        kind = fragment["$ref"].rsplit("/", 1)[-1]
        yield from _used(kinds, kind, kinds[kind], value)
    for way in _WAYS:
        for one in fragment.get(way, ()):
            yield from _used(kinds, name, one, value)
    if isinstance(value, Mapping):
        known = fragment.get("properties", {})
        for key, inner in value.items():
            if key in known:
                yield f"{name}.{key}"
                yield from _used(kinds, f"{name}.{key}", known[key], inner)
            else:
                for one in _others(fragment):
                    yield from _used(kinds, f"{name}.*", one, inner)
    elif isinstance(value, list):
        items = _items(fragment)
        for number, inner in enumerate(value if items else ()):
            yield from _used(kinds, f"{name}[]", items[min(number, len(items) - 1)], inner)


def _others(fragment: Mapping[str, Any]) -> list[Mapping[str, Any]]:
    """Return what the values of keys have to be that are names."""
    more = fragment.get("additionalProperties")
    return [*fragment.get("patternProperties", {}).values(), *([more] if isinstance(more, dict) else [])]


def _items(fragment: Mapping[str, Any]) -> Sequence[Mapping[str, Any]]:
    items = fragment.get("items")
    return items if isinstance(items, list) else [items] if items else []
