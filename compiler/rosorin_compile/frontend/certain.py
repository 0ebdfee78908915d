"""Whether a value certainly fits a schema, said without the validator, which costs 16 ms and 12 MiB before it speaks.

Most descriptions fit. Only what is plain is said here: the keywords that our schemas are made of, texts of one line,
and what no validator sees: that each number is finite, and each quantity of a kind that its place allows. All else, and
whatever does not fit, is left to ``validate``, which asks the validator and says what is wrong.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import partial
from math import isfinite
from typing import Any

from ..units import Dimension, Quantity, parse_unit

Fits = Callable[["Any"], bool]

# Beyond it, what is calculated of a number (a volume, a moment of inertia) may be beyond all numbers that there are.
MOST = 1e150
_LARGEST = 2**53  # whole numbers beyond are not all floats

_KINDS: dict[str, Fits] = {
    "object": lambda value: isinstance(value, dict),
    "array": lambda value: isinstance(value, list),
    "string": lambda value: isinstance(value, str),
    "boolean": lambda value: value is True or value is False,
    "null": lambda value: value is None,
    "integer": lambda value: type(value) is int and abs(value) <= _LARGEST,
}
_NUMBERS = ("number", "integer")
# Keywords that are about values of other kinds, too, which they let pass.
_ABOUT = {
    "properties": dict, "additionalProperties": dict, "required": dict, "propertyNames": dict, "minProperties": dict,
    "maxProperties": dict, "dependentRequired": dict, "items": list, "minItems": list, "maxItems": list,
    "uniqueItems": list, "pattern": str, "minLength": str, "minimum": (int, float), "maximum": (int, float),
    "exclusiveMinimum": (int, float),
}  # fmt: skip
# What a value is whose test of its kind comes first: of it nobody has to ask that again.
_PYTHON = {"object": dict, "array": list, "string": str, "number": (int, float), "integer": (int, float)}
# Keywords that say nothing of what fits.
_SAYING = frozenset(("description", "title", "default", "examples", "$schema", "$id", "$defs"))
# Those of a number that fits if one that is not larger does, and one that is not smaller.
_OF_NUMBERS = _SAYING | {"type", "x-unit", "minimum", "maximum", "exclusiveMinimum"}


class Certain:
    """Asks one schema; what is made of its parts is kept."""

    def __init__(self, schema: Mapping[str, Any]) -> None:
        self.schema = schema
        self.made: dict[int, Fits] = {}

    def fits(self, value: Any) -> bool:
        """Say whether a plain value certainly fits the schema."""
        return self.of(self.schema)(value)

    def of(self, schema: Any) -> Fits:
        """Return what says whether a value certainly fits a part of the schema."""
        if isinstance(schema, bool):
            return _is_sound if schema else lambda _: False
        known = self.made.get(id(schema))
        if known is None:
            self.made[id(schema)] = lambda value: self.made[id(schema)](value)  # for parts that hold themselves
            known = self.made[id(schema)] = self._made(schema)
        return known

    def _made(self, schema: Mapping[str, Any]) -> Fits:
        if set(schema) - _SAYING == {"$ref"}:
            return self.of(self._named(schema["$ref"]))
        tests = list(self._tests(schema))
        return tests[0] if len(tests) == 1 else _every(tests)

    def _named(self, reference: str) -> Any:
        """Return the part that a reference names; one elsewhere fits nothing certainly."""
        return self.schema["$defs"].get(reference.removeprefix("#/$defs/"), False)

    def _tests(self, schema: Mapping[str, Any]) -> Iterator[Fits]:
        """Yield a test a keyword; the kind of a value comes first, and last what no keyword looks at."""
        for word in sorted(schema, key=lambda word: word not in ("type", "$ref")):
            given = schema[word]
            if word == "$ref":
                yield self.of(self._named(given))
            elif word == "type":
                kinds = [_of_kind(kind, schema) for kind in ([given] if isinstance(given, str) else given)]
                yield kinds[0] if len(kinds) == 1 else partial(_any, kinds)
            elif word == "enum":
                texts = frozenset(one for one in given if isinstance(one, str))
                yield lambda value, texts=texts: isinstance(value, str) and value in texts  # type: ignore[misc]
            elif word == "const":
                yield lambda value, given=given: type(value) is type(given) and value == given  # type: ignore[misc]
            elif word == "if" and given.keys() == {"not"} and given["not"].keys() == {"required"}:
                yield partial(_lacking, given["not"]["required"], self.of(schema.get("then", True)))
            elif word == "oneOf" and all(isinstance(one.get("type"), str) for one in given):
                yield partial(_one_kind, [(_of_kind(one["type"], one), self.of(one)) for one in given])
            elif word == "prefixItems":
                yield partial(_row, [self.of(one) for one in given], self.of(schema.get("items", True)))
            elif word in ("properties", "additionalProperties"):
                if word == "properties" or "properties" not in schema:
                    yield self._of_entries(schema)
            elif word in _ABOUT and not (word == "items" and "prefixItems" in schema):
                test, kind = self._of(word, given), _ABOUT[word]
                yield test if _PYTHON.get(str(schema.get("type"))) == kind else partial(_about, kind, test)
            elif word not in ("then", "items", *_SAYING) and not word.startswith("x-"):
                yield lambda _: False  # left to the validator
        if _leaves(schema):
            yield _is_sound

    def _of_entries(self, schema: Mapping[str, Any]) -> Fits:
        known: dict[str, Fits] = {}
        properties, more = schema.get("properties", {}), schema.get("additionalProperties", True)

        def fits(value: Any) -> bool:
            if not isinstance(value, dict):
                return True
            for key, item in value.items():
                test = known.get(key)
                if test is None:
                    test = known[key] = self.of(properties.get(key, more))
                if not test(item):
                    return False
            return True

        return fits

    def _of(self, word: str, given: Any) -> Fits:
        """Return the test of a keyword, for values of its kind."""
        match word:
            case "required":
                return lambda value: all(key in value for key in given)
            case "propertyNames":
                return partial(_all, self.of(given))
            case "items":
                plain = isinstance(given, dict) and given.keys() <= _OF_NUMBERS
                return partial(_all_numbers if plain else _all, self.of(given))
            case "dependentRequired":
                return lambda value: all(key not in value or all(one in value for one in given[key]) for key in given)
            case "pattern":
                found = re.compile(given).search  # of other letters, \s and the like mean more in Python, or less
                return lambda value: value.isascii() and value.isprintable() and found(value) is not None
            case "uniqueItems":
                return lambda value: all(isinstance(one, str) for one in value) and len(set(value)) == len(value)
            case "minimum":
                return lambda value: value >= given
            case "exclusiveMinimum":
                return lambda value: value > given
            case "maximum":
                return lambda value: value <= given
            case "minItems" | "minProperties" | "minLength":
                return lambda value: len(value) >= given
            case _:
                return lambda value: len(value) <= given


def _of_kind(kind: str, schema: Mapping[str, Any]) -> Fits:
    """Return the test of a kind that a part of a schema names."""
    return partial(_number, _allowed(schema)) if kind == "number" else _KINDS[kind]


def _allowed(schema: Mapping[str, Any]) -> tuple[Dimension, ...] | None:
    """Return the dimensions that a number has which a part of a schema is about; None for any."""
    if schema["type"] not in _NUMBERS and "x-unit" not in schema:
        return None
    units = schema.get("x-unit", "")
    made = map(parse_unit, [units] if isinstance(units, str) else units)
    return tuple(unit[1] for unit in made if unit is not None)


def _number(allowed: tuple[Dimension, ...] | None, value: Any) -> bool:
    """Say whether a value is a number that can be reckoned with, of a dimension that is allowed if it has one."""
    kind = type(value)
    if kind is float:
        return -MOST <= value <= MOST  # type: ignore[no-any-return]
    if kind is int:
        return -_LARGEST <= value <= _LARGEST  # type: ignore[no-any-return]
    if not isinstance(value, Quantity) or not -MOST <= value <= MOST:
        return False
    return allowed is None or value.dimension in allowed


def _leaves(schema: Mapping[str, Any]) -> bool:
    """Say whether values within one that fits a part of a schema may be those of which no keyword says anything."""
    if schema.keys() & {"$ref", "oneOf", "enum", "const"}:
        return False
    kinds = schema.get("type", ("object", "array", "number"))
    return (
        "type" not in schema
        or ("object" in kinds and not schema.keys() & {"properties", "additionalProperties"})
        or ("array" in kinds and not schema.keys() & {"items", "prefixItems"})
    )


def _is_sound(value: Any) -> bool:
    """Say whether a value of which a schema says nothing is made of texts and finite numbers."""
    if isinstance(value, (str, bool)) or value is None:
        return True
    if isinstance(value, dict):
        return all(map(_is_sound, value.values()))
    if isinstance(value, list):
        return all(map(_is_sound, value))
    return _number(None, value)


def _every(tests: Sequence[Fits]) -> Fits:
    """Return what says whether a value passes all tests."""

    def fits(value: Any) -> bool:
        for test in tests:  # noqa: SIM110 - a generator a value would take twice as long
            if not test(value):
                return False
        return True

    return fits


def _any(tests: list[Fits], value: Any) -> bool:
    return any(test(value) for test in tests)


def _one_kind(tests: list[tuple[Fits, Fits]], value: Any) -> bool:
    """Say whether a value is of one of several kinds, and fits what is asked of that."""
    asked = [test for is_kind, test in tests if is_kind(value)]
    return len(asked) == 1 and asked[0](value)


def _row(tests: list[Fits], more: Fits, value: Any) -> bool:
    """Say whether the items of a list fit, each its own test."""
    if not isinstance(value, list):
        return True
    return all(test(item) for test, item in zip(tests, value, strict=False)) and all(map(more, value[len(tests) :]))


def _lacking(names: list[str], test: Fits, value: Any) -> bool:
    """Say whether a mapping has all the names, or else fits."""
    return (isinstance(value, dict) and all(name in value for name in names)) or test(value)


def _all(test: Fits, values: Any) -> bool:
    return all(map(test, values))


def _all_numbers(test: Fits, values: Any) -> bool:
    """Say whether all of a list fit of which each is to be a number between two others; most are of one kind."""
    if set(map(type, values)) == {float} and isfinite(sum(values)):  # else one may be no number
        return test(min(values)) and test(max(values))
    return all(map(test, values))


def _about(kind: Any, test: Fits, value: Any) -> bool:
    return test(value) if isinstance(value, kind) else True
