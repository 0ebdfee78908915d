"""Validate against JSON Schema draft 7, with any version of jsonschema from 3.2 on.

Its versions differ in the order of errors, in their words, and in the cost of ``$ref``. So errors are sorted by place,
the words are ours, and references are replaced by their targets first.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from functools import cache
from typing import Any, NamedTuple

from rosorin_compile.source.diagnostics import UnknownName

from .annotations import Steps, describe_path, own_schema

_KINDS = ("null", "boolean", "integer", "number", "string", "array", "object")
_NAMING = ("required", "dependencies")
_BESIDE_REFERENCE = r"^(\$ref|description|title|default|examples|x-.*)$"


class Misfit(NamedTuple):
    """A value that does not fit a schema: its path, and the keyword, its value and its part of the schema.

    ``value`` is the name for ``propertyNames``, whose mapping is at the path; ``key`` is the one that is missing.
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
        """Return the types that are allowed, in a fixed order."""
        return sorted([self.wanted] if isinstance(self.wanted, str) else self.wanted, key=_KINDS.index)


def validator_of(schema: Mapping[str, Any]) -> Any:
    """Return the validator of a schema."""
    from jsonschema import Draft7Validator  # takes 45 ms, which an unchanged run does without

    return Draft7Validator(inline_references(schema))


@cache
def validator(name: str) -> Any:
    """Return the validator of one of the schemas that ship with the tool."""
    return validator_of(own_schema(name))


def inline_references(whole: Mapping[str, Any]) -> dict[str, Any]:
    """Return a schema with each reference replaced by its target; our schemas are not recursive."""
    done: dict[str, Any] = {}

    def of(part: Any) -> Any:
        if isinstance(part, list):
            return [of(one) for one in part]
        if not isinstance(part, Mapping):
            return part
        if not isinstance(part.get("$ref"), str):
            made = {key: of(one) for key, one in part.items() if key != "$defs"}
            if isinstance(pattern := made.get("pattern"), str):  # as JavaScript reads it
                pattern = pattern.replace("\\d", "[0-9]").replace("\\s", r"\s\ufeff")
                made["pattern"] = pattern[:-1] + r"(?!\n)$" if pattern.endswith("$") else pattern
            return made
        name = part["$ref"]
        if name not in done:
            target: Any = whole
            try:
                for step in name.removeprefix("#/").split("/"):
                    target = target[step]
            except (KeyError, TypeError):
                raise ValueError(f"the schema has nothing that $ref names: {name}") from None
            done[name] = of(target)
        return done[name]

    made: dict[str, Any] = of(whole)
    return made


def misfits_of(validator: Any, value: Any) -> list[Misfit]:
    """Return the misfits of a value, in the order of their places."""
    found: list[Misfit] = []
    reported = set()
    for error in validator.iter_errors(value):
        path, schema_path = list(error.absolute_path), list(error.absolute_schema_path)
        misfit = Misfit(path, error.validator, error.validator_value, error.instance, error.schema, schema_path)
        if error.validator not in _NAMING:
            found.append(misfit)
        elif (where := repr((path, schema_path))) not in reported:  # an error per key, or one for all of them
            reported.add(where)
            keys = error.validator_value
            if error.validator == "dependencies":
                keys = [key for given, wanted in keys.items() if given in error.instance for key in wanted]
            found += [misfit._replace(key=key) for key in dict.fromkeys(keys) if key not in error.instance]
    numbers: dict[int, dict[str, int]] = {}

    def place(misfit: Misfit) -> list[int]:
        """Return the numbers of the entries on the way to the place of a misfit."""
        node, steps = value, []
        for step in misfit.path:
            if not isinstance(step, int) and id(node) not in numbers:
                numbers[id(node)] = {key: number for number, key in enumerate(node)}
            steps.append(step if isinstance(step, int) else numbers[id(node)][step])
            node = node[step]
        return steps

    return sorted(found, key=place)


def misfits(name: str, value: Any) -> list[str]:
    """Return a sentence for each misfit of a JSON value, by the name of one of the schemas that ship with the tool."""
    return [f"{describe_path(one.path, own_schema())}: {words_of(one)}" for one in misfits_of(validator(name), value)]


def words_of(misfit: Misfit) -> str:
    """Return a sentence about a misfit of JSON."""
    if misfit.keyword in _NAMING:
        return f"{_json(misfit.key)} is a required property"
    if misfit.keyword == "additionalProperties":
        return f"unknown properties: {', '.join(misfit.unexpected_keys())}"
    return f"{_json(misfit.value)} does not match {misfit.keyword} {_json(misfit.wanted)}"


def _json(value: Any) -> str:
    return json.dumps(value, ensure_ascii=False, separators=(",", ":"))[:200]


def check_schema(part: Mapping[str, Any], whole: Mapping[str, Any]) -> None:
    """Raise ValueError if a part of a schema is not JSON Schema of draft 7, or has a reference without a target.

    Keywords that draft 7 ignores are errors: unknown ones (except ``x-...``), and those next to ``$ref``.
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
