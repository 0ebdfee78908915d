"""The schemas of what commands answer as JSON, made from the types of their results.

A module ``answers`` beside commands has the types: its ``ANSWERS`` names that of each command, by the words that call
it. ``python tests/renew.py schema`` writes ``schemas/answer*.schema.json``, of which docs/make/json_reference.py makes
a page.
"""

from __future__ import annotations

import dataclasses
import json
import types
import typing
from collections.abc import Mapping, Sequence
from importlib import import_module
from typing import Any, Literal

from rosorin_compile.cli.answer import name_of
from rosorin_compile.source.answers import Said
from support.paths import COMPILER, PACKAGES

_PLAIN = {str: "string", bool: "boolean", int: "integer", float: "number", type(None): "null"}
_ABOUT = {
    "rosorin_compile": "The version of the tool.",
    "schema": "The name of this schema: what `rosorin-compile schema` takes.",
    "diagnostics": "What there is to say: errors, warnings, notes.",
    "result": "The answer; null where there is none, as after an error.",
}


class Schema:
    """The schema of one type: objects are definitions of their own, each named as its class is."""

    def __init__(self) -> None:
        self.definitions: dict[str, Any] = {}

    def of(self, kind: Any, about: str = "") -> dict[str, Any]:
        """Return the schema of a type; ``about`` says what it is."""
        made = self._made(kind)
        if not about:
            return made
        return {"allOf": [made], "description": about} if "$ref" in made else {**made, "description": about}

    def _made(self, kind: Any) -> dict[str, Any]:
        origin, inner = typing.get_origin(kind), typing.get_args(kind)
        if origin is typing.Annotated:
            return self.of(inner[0], inner[1])
        if kind is Any or kind is object:
            return {}
        if kind in _PLAIN:
            return {"type": _PLAIN[kind]}
        if origin is Literal:
            return {"enum": list(inner)}
        if origin in (typing.Union, types.UnionType):
            return self._one_of(inner)
        if origin in (list, Sequence) or (origin is tuple and inner[1:] == (...,)):
            return {"type": "array", "items": self.of(inner[0])}
        if origin is tuple:
            size = len(inner)
            return {"type": "array", "items": self.of(inner[0]), "minItems": size, "maxItems": size}
        if origin in (dict, Mapping):
            return {"type": "object", "additionalProperties": self.of(inner[1])}
        return self._object(kind)

    def _one_of(self, kinds: Sequence[Any]) -> dict[str, Any]:
        made = [self.of(one) for one in kinds]
        names = [one["type"] for one in made if set(one) == {"type"}]
        return {"type": names} if len(names) == len(made) else {"anyOf": made}

    def _object(self, kind: Any) -> dict[str, Any]:
        """Return the name of a definition: that of a class with typed fields, a typed dictionary or a named tuple."""
        name = kind.__name__
        if name not in self.definitions:
            self.definitions[name] = {}  # it may be in itself
            fields = typing.get_type_hints(kind, include_extras=True)
            if dataclasses.is_dataclass(kind):
                fields = {
                    one.name: fields[one.name]
                    for one in dataclasses.fields(kind)
                    if one.repr and one.name != "diagnostics"
                }
            needed = getattr(kind, "__required_keys__", fields)
            self.definitions[name] = {
                "type": "object",
                "description": " ".join((kind.__doc__ or "").replace("``", "`").split()),
                "properties": {field: self.of(of) for field, of in fields.items()},
                "required": [field for field in fields if field in needed],
                "additionalProperties": False,
            }
        return {"$ref": f"#/definitions/{name}"}


def answers() -> dict[str, Any]:
    """Return the type of the result of each command that has one of its own, by the words that call it."""
    found: dict[str, Any] = {}
    for path in (path for package in PACKAGES for path in sorted(package.rglob("answers.py"))):
        name = ".".join(path.relative_to(COMPILER).with_suffix("").parts)
        found |= import_module(name).ANSWERS
    return dict(sorted(found.items()))


def schema(command: str) -> dict[str, Any]:
    """Return the schema of what a command answers; that of all answers for the empty command."""
    types = Schema()
    name = name_of(command)
    said = types.of(list[Said])
    made = types.of(answers()[command]) if command else {}
    result = {"anyOf": [made, {"type": "null"}]} if made else {}
    title = f"What rosorin-compile {command} answers" if command else "An answer"
    properties: dict[str, dict[str, Any]] = {
        "rosorin_compile": {"type": "string"},
        "schema": {"const": name} if command else {"type": "string"},
        "diagnostics": said,
        "result": result,
    }
    return {
        "$schema": "http://json-schema.org/draft-07/schema#",
        "$id": name,
        "title": title,
        "description": "What --format json prints. SI units; names as in the description.",
        "type": "object",
        "properties": {key: {**value, "description": _ABOUT[key]} for key, value in properties.items()},
        "required": list(properties),
        "additionalProperties": False,
        "definitions": dict(sorted(types.definitions.items())),
    }


def files() -> dict[str, str]:
    """Return the schemas as they are committed, by the names of their files."""
    made = {name_of(command): schema(command) for command in ("", *answers())}
    return {f"{name}.schema.json": json.dumps(one, indent=2) + "\n" for name, one in made.items()}
