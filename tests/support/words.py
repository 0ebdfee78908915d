"""The words of the language, and those that a value of it uses: KIND.WORD, as the schema of descriptions has them."""

from collections.abc import Iterator, Mapping
from typing import Any

from support.schemas import ITEM, KEY, OTHER, PATTERN, WAY, Inner, inner

_TOP = "description"


def words(schema: Mapping[str, Any]) -> set[str]:
    """Return all words of a schema."""
    kinds = {_TOP: schema, **schema["$defs"]}
    return {word for name, fragment in kinds.items() for word in _words(name, fragment)}


def used(schema: Mapping[str, Any], value: Any) -> set[str]:
    """Return the words of a schema that stand in a description; keys that are no words are let be."""
    return set(_used(schema["$defs"], _TOP, schema, value))


def _words(name: str, fragment: Mapping[str, Any]) -> Iterator[str]:
    for one in inner(fragment):
        if one.kind == KEY:
            yield _below(name, one)
        yield from _words(_below(name, one), one.fragment)


def _used(kinds: Mapping[str, Any], name: str, fragment: Mapping[str, Any], value: Any) -> Iterator[str]:
    if "$ref" in fragment:
        kind = fragment["$ref"].rsplit("/", 1)[-1]
        yield from _used(kinds, kind, kinds[kind], value)
    for one in inner(fragment):
        for held in _held(one, fragment, value):
            if one.kind == KEY:
                yield _below(name, one)
            yield from _used(kinds, _below(name, one), one.fragment, held)


def _below(name: str, one: Inner) -> str:
    return name + {KEY: f".{one.name}", PATTERN: ".*", OTHER: ".*", ITEM: "[]", WAY: ""}[one.kind]


def _held(one: Inner, fragment: Mapping[str, Any], value: Any) -> Iterator[Any]:
    """Yield what a value holds that a schema within its own is about; the last of several items is about all behind."""
    if one.kind == WAY:
        yield value
    elif one.kind == ITEM and isinstance(value, list):
        first, last = int(one.name or 0), not one.name or int(one.name) == len(fragment["items"]) - 1
        yield from value[first:] if last else value[first : first + 1]
    elif one.kind != ITEM and isinstance(value, Mapping):
        known = fragment.get("properties", {})
        yield from (held for key, held in value.items() if (key == one.name if one.kind == KEY else key not in known))
