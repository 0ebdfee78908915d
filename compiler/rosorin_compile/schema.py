"""The JSON Schemas that ship with the tool: reading them, asking them about a path, naming a path in words."""

from __future__ import annotations

import json
from collections.abc import Sequence
from functools import cache, lru_cache
from typing import Any

from .data import data_folder

Steps = list[str | int]


@cache
def schema(name: str = "description") -> dict[str, Any]:
    """Return one of the schemas that ship with the tool."""
    path = data_folder("schemas") / f"{name}.schema.json"
    loaded: dict[str, Any] = json.loads(path.read_text("utf-8"))
    return loaded


@cache
def validator(name: str = "description") -> Any:
    """Return the validator of one of the schemas that ship with the tool."""
    import jsonschema_rs

    return jsonschema_rs.Draft202012Validator(schema(name))


def misfits(name: str, value: Any) -> list[str]:
    """Return what of a JSON value does not fit one of the schemas that ship with the tool, a sentence each."""
    return [f"{subject(list(p.instance_path))}: {p.message}" for p in validator(name).iter_errors(value)]


_ENTRIES = {
    "links": "link",
    "joints": "joint",
    "sensors": "sensor",
    "publishers": "publisher",
    "servos": "servo group",
    "poses": "pose",
    "outputs": "output",
    "args": "argument",
    "modes": "mode",
}


def subject(path: Steps) -> str:
    """Return a path in words: ``joint "joint1" limit lower``.

    >>> subject(["joints", "joint1", "xyz", 2])
    'joint "joint1" xyz[2]'
    """
    if not path:
        return "the description"
    words: str = str(path[0])
    rest = path[1:]
    if path[0] in _ENTRIES and rest:
        words, rest = f'{_ENTRIES[str(path[0])]} "{rest[0]}"', rest[1:]
    for step in rest:
        words += f"[{step}]" if isinstance(step, int) else f" {step}"
    return words


def schema_at(path: Steps) -> Any:
    """Return the fragment of the schema at a path of the schema; an empty one if the path does not exist."""
    node: Any = schema()
    for step in path:
        if isinstance(node, dict):
            node = node.get(str(step), {})
        elif isinstance(node, list) and isinstance(step, int):
            node = node[step]
    return node


def unit_at(path: Sequence[str | int]) -> str | list[str] | None:
    """Return the unit (or units) that the schema asks for at a path of a description; "" for a plain number.

    None where the schema has no number at all.
    """
    # The names of entries and the indices of items make no difference: what is asked for is found once for all.
    return _unit_of(tuple("*" if i == 1 else 0 if isinstance(step, int) else step for i, step in enumerate(path)))


@lru_cache(maxsize=2_000)
def _unit_of(path: tuple[str | int, ...]) -> str | list[str] | None:
    node: Any = schema()
    for step in path:
        node = resolve(node)
        if isinstance(step, int):
            node = node.get("items")
        else:
            node = node.get("properties", {}).get(step, node.get("additionalProperties", node.get("items")))
        if not isinstance(node, dict):
            return None
    node = resolve(node)
    if node.get("type") not in ("number", "integer"):
        return None
    unit: str | list[str] = node.get("x-unit", "")
    return unit


def resolve(node: dict[str, Any]) -> dict[str, Any]:
    """Return what a fragment of the schema of descriptions refers to, or the fragment itself."""
    reference = node.get("$ref")
    return schema()["$defs"][reference.rsplit("/", 1)[1]] if reference else node
