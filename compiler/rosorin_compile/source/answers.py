"""Results as JSON: the form of a diagnostic, and the conversion of result dataclasses to plain values."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import Field, fields, is_dataclass
from types import MappingProxyType
from typing import Annotated, Any, Literal, TypedDict

NOT_JSON: Mapping[str, bool] = MappingProxyType({"json": False})  # metadata of a field that is left out of the JSON


class _Place(TypedDict, total=False):
    file: Annotated[str, "The file that it is about; left out where there is no place, as the next three."]
    line: Annotated[int, "The line, from 1."]
    column: Annotated[int, "The column, from 1."]
    length: Annotated[int, "How many characters it is about."]


class Related(_Place):
    """Another place that belongs to a diagnostic, or a remark without one."""

    message: Annotated[str, "What is there."]


class Said(_Place):
    """A diagnostic."""

    rule: Annotated[str, "The id of the rule, which `rosorin-compile rule` explains."]
    severity: Annotated[Literal["error", "warning", "note"], "How bad it is."]
    message: Annotated[str, "What is wrong."]
    help: Annotated[str, "The way out; empty where the message has it."]
    related: list[Related]


def is_in_json(field: Field[Any]) -> bool:
    """Return True if a field of a result is part of its JSON: diagnostics are next to the result, not in it."""
    return field.name != "diagnostics" and bool(field.metadata.get("json", True))


def to_json(value: Any) -> Any:
    """Return a result as values that JSON has: dataclasses and named tuples become objects.

    >>> to_json(Related(message="here"))
    {'message': 'here'}
    """
    if is_dataclass(value) and not isinstance(value, type):
        return {one.name: to_json(getattr(value, one.name)) for one in fields(value) if is_in_json(one)}
    if hasattr(value, "_asdict"):
        return {name: to_json(inner) for name, inner in value._asdict().items()}
    if isinstance(value, Mapping):
        return {str(key): to_json(inner) for key, inner in value.items()}
    if isinstance(value, (list, tuple)):
        return [to_json(inner) for inner in value]
    return value


ANSWERS: dict[str, Any] = {}
