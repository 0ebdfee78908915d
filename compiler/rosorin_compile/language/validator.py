"""The one validator of JSON Schemas: jsonschema's for draft 7, any version of it from 3.2 on.

Its versions differ in the order of errors, in their words, and in what a look-up of ``$ref`` costs. So errors are
sorted by place, the words are ours, and a schema is handed over with what it refers to put in its place.
"""

from __future__ import annotations

import json
from collections.abc import Collection, Iterable, Iterator, Mapping
from functools import cache
from typing import Any, NamedTuple

from rosorin_compile.source.diagnostics import did_you_mean
from rosorin_compile.source.wording import counted

from .annotations import Steps, describe_path, own_schema

# The order in which kinds are named, whatever order a schema has.
_KINDS = ("null", "boolean", "integer", "number", "string", "array", "object")
_NAMING = ("required", "dependencies")


class Misfit(NamedTuple):
    """A value that does not fit a schema: where, what does not fit, what is asked for, by which part of the schema.

    ``value`` is a name where one does not fit, whose mapping is at the path. ``branches`` are those of a choice that
    were tried and do not fit, ``key`` is the one that is missing.
    """

    path: Steps
    keyword: str
    wanted: Any
    value: Any
    part: Mapping[str, Any]
    schema_path: Steps
    branches: int = 0
    key: str = ""

    def unexpected(self) -> list[str]:
        """Return the keys that ``additionalProperties`` does not allow."""
        return [key for key in self.value if key not in self.part.get("properties", {})]

    def kinds(self) -> list[str]:
        """Return what ``type`` allows."""
        return sorted([self.wanted] if isinstance(self.wanted, str) else self.wanted, key=_KINDS.index)


def validator_of(schema: Mapping[str, Any]) -> Any:
    """Return the validator of a schema."""
    from jsonschema import Draft7Validator  # takes 45 ms, which an unchanged run does without

    return Draft7Validator(inlined(schema))


@cache
def validator(name: str) -> Any:
    """Return the validator of one of the schemas that ship with the tool."""
    return validator_of(own_schema(name))


def inlined(whole: Mapping[str, Any]) -> dict[str, Any]:
    """Return a schema with what it refers to in its place; no part of ours holds itself.

    Draft 7 sees nothing that stands beside a reference. Raises ValueError for one that leads nowhere.
    """
    done: dict[str, Any] = {}

    def of(part: Any) -> Any:
        if isinstance(part, list):
            return [of(one) for one in part]
        if not isinstance(part, Mapping):
            return part
        if not isinstance(part.get("$ref"), str):
            made = {key: of(one) for key, one in part.items() if key != "$defs"}
            return {**made, "pattern": _in_python(made["pattern"])} if isinstance(made.get("pattern"), str) else made
        name = part["$ref"]
        if name not in done:
            done[name] = of(_named(whole, name))
        return done[name]

    made: dict[str, Any] = of(whole)
    return made


# Patterns of schemas are those of ECMA 262, which Python reads otherwise: ``$`` before a line feed, digits of other
# scripts. What is a space to either of them is one.
_OTHERWISE = (("\\d", "[0-9]"), ("\\s", r"\s\ufeff"))


def _in_python(pattern: str) -> str:
    """Return a pattern of a schema as Python has it; ``$`` stands at the end in all of ours."""
    for theirs, ours in _OTHERWISE:
        pattern = pattern.replace(theirs, ours)
    return pattern[:-1] + r"(?!\n)$" if pattern.endswith("$") else pattern


def _named(whole: Any, reference: str) -> Any:
    try:
        for step in reference.removeprefix("#/").split("/"):
            whole = whole[step]
    except (KeyError, TypeError):
        raise ValueError(f"the schema has nothing that $ref names: {reference}") from None
    return whole


def misfits_of(validator: Any, value: Any) -> list[Misfit]:
    """Return what does not fit in a value, the first place first."""
    errors = list(validator.iter_errors(value))
    return sorted(_misfits(errors), key=_Places(value).of) if errors else []


def _misfits(errors: Iterable[Any]) -> Iterator[Misfit]:
    told = set()
    for error in errors:
        path, schema_path = list(error.absolute_path), list(error.absolute_schema_path)
        given = (path, error.validator, error.validator_value, error.instance, error.schema, schema_path)
        where = repr((path, schema_path))
        if error.validator not in _NAMING:
            yield Misfit(*given, branches=len(error.context))
        elif where not in told:
            told.add(where)
            yield from (Misfit(*given, key=key) for key in _missing(error))


def _missing(error: Any) -> list[str]:
    keys = error.validator_value
    if error.validator == "dependencies":
        keys = [key for given, wanted in keys.items() if given in error.instance for key in wanted]
    return [key for key in dict.fromkeys(keys) if key not in error.instance]


class _Places:
    """The order of the places in a value."""

    def __init__(self, value: Any) -> None:
        self.value = value
        self.known: dict[int, dict[str, int]] = {}

    def of(self, misfit: Misfit) -> list[int]:
        """Return the numbers of the entries on the way to the place of a misfit."""
        node, numbers = self.value, []
        for step in misfit.path:
            numbers.append(step if isinstance(step, int) else self._number(node, step))
            node = node[step]
        return numbers

    def _number(self, node: Mapping[str, Any], key: str) -> int:
        if id(node) not in self.known:
            self.known[id(node)] = {one: number for number, one in enumerate(node)}
        return self.known[id(node)][key]


def misfits(name: str, value: Any) -> list[str]:
    """Return what of a JSON value does not fit one of the schemas that ship with the tool, a sentence each."""
    return [f"{describe_path(one.path, own_schema())}: {words(one)}" for one in misfits_of(validator(name), value)]


_LIMITS = {
    "minItems": ("has less than", "item"),
    "maxItems": ("has more than", "item"),
    "minProperties": ("has less than", "property"),
    "maxProperties": ("has more than", "property"),
    "minLength": ("is shorter than", "character"),
    "maxLength": ("is longer than", "character"),
    "minimum": ("is less than the minimum of", ""),
    "maximum": ("is greater than the maximum of", ""),
    "exclusiveMinimum": ("is less than or equal to the minimum of", ""),
    "exclusiveMaximum": ("is greater than or equal to the maximum of", ""),
}


def words(misfit: Misfit) -> str:
    """Return a sentence about a misfit of JSON."""
    wanted, keyword = misfit.wanted, misfit.keyword
    shown = _json(misfit.value)
    if keyword in _LIMITS:
        compared, thing = _LIMITS[keyword]
        return f"{shown} {compared} {counted(wanted, thing) if thing else _json(wanted)}"
    if keyword in _NAMING:
        return f"{_json(misfit.key)} is a required property"
    if keyword == "additionalProperties":
        keys = [f"'{key}'" for key in misfit.unexpected()]
        verb = "was" if len(keys) == 1 else "were"
        return f"Additional properties are not allowed ({', '.join(keys)} {verb} unexpected)"
    if keyword == "type":
        kinds = misfit.kinds()
        return f"{shown} is not of type{'s' if len(kinds) > 1 else ''} {', '.join(map(_json, kinds))}"
    if keyword == "enum":
        return f"{shown} is not one of {_choice(wanted)}"
    if keyword == "const":
        return f"{_json(wanted)} was expected"
    if keyword == "pattern":
        return f'{shown} does not match "{wanted}"'
    if keyword == "uniqueItems":
        return f"{shown} has non-unique elements"
    if keyword in ("anyOf", "oneOf"):
        valid = "not valid under any" if misfit.branches else "valid under more than one"
        return f"{shown} is {valid} of the schemas listed in the '{keyword}' keyword"
    return f"{shown} does not fit the schema: {keyword}"


def _choice(options: list[Any]) -> str:
    named = [_json(one) for one in options]
    if len(named) > 3:
        named = [*named[:2], f"{len(named) - 2} other candidates"]
    return " or ".join(filter(None, [", ".join(named[:-1]), named[-1]]))


def _json(value: Any) -> str:
    return json.dumps(value, ensure_ascii=False, separators=(",", ":"))


def check_schema(part: Mapping[str, Any], whole: Mapping[str, Any], *, strict: bool = False) -> None:
    """Raise ValueError where a part of a schema is no JSON Schema of draft 7, or refers to what the whole has not.

    ``strict``: also for a word that draft 7 does not know.
    """
    from jsonschema import Draft7Validator, FormatChecker

    judge = Draft7Validator(Draft7Validator.META_SCHEMA, format_checker=FormatChecker(["regex"]))
    for wrong in misfits_of(judge, dict(part)):
        raise ValueError(words(wrong))
    _check_words(part, Draft7Validator.META_SCHEMA["properties"] if strict else None)
    inlined(whole)


# What later drafts have, and draft 7 lets pass in silence.
_LATER = (
    *("prefixItems", "dependentRequired", "dependentSchemas", "unevaluatedItems", "unevaluatedProperties"),
    *("minContains", "maxContains", "$dynamicRef", "$recursiveRef"),
)
_BESIDE = ("$ref", "description", "title", "default", "examples")


def _check_words(part: Any, known: Collection[str] | None, is_named: bool = False) -> None:
    """Raise ValueError where a part of a schema has words that draft 7 does not heed; ``is_named``: keys are names."""
    if isinstance(part, list):
        for one in part:
            _check_words(one, known)
    if not isinstance(part, Mapping):
        return
    for word, inner in part.items():
        if not is_named and word in _LATER:
            raise ValueError(f"{word} is no word of JSON Schema draft 7")
        if not is_named and "$ref" in part and word not in _BESIDE and not word.startswith("x-"):
            raise ValueError(f"{word} has no meaning beside $ref, in JSON Schema draft 7")
        if not is_named and known is not None and word not in known and not word.startswith("x-"):
            raise ValueError(f"{word} is no word of JSON Schema draft 7; {did_you_mean(word, sorted(known))}")
        if word not in ("default", "examples", "enum", "const") or is_named:
            _check_words(inner, known, not is_named and word in ("properties", "patternProperties"))
