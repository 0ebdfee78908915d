"""Plainly: a record of the model made of an entry whose keys are called as the fields of the record.

What has another name in the model, or is worked out, is given beside the entry.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import fields, is_dataclass
from functools import cache
from types import NoneType, UnionType
from typing import Any, TypeVar, Union, get_args, get_origin, get_type_hints

T = TypeVar("T")
Convert = Callable[[Any], Any]


def record_of(kind: Callable[..., T], entry: Mapping[str, Any] | None, /, **given: Any) -> T:
    """Return a record of a kind: each field from its key in the entry, or from ``given``; else it has its default."""
    said = entry or {}
    found = {name: convert(said[name]) for name, convert in _fields(kind) if name in said and name not in given}
    return kind(**found, **given)


def plain(value: Any) -> Any:
    """Return a value of a description without its place, and where it comes from: quantities as numbers in SI units."""
    if isinstance(value, Mapping):
        return {str(key): plain(item) for key, item in value.items() if key != "source"}
    if isinstance(value, list):
        return tuple(plain(item) for item in value)
    if isinstance(value, float):
        return float(value)
    return str(value) if isinstance(value, str) else value


@cache
def _fields(kind: Any) -> tuple[tuple[str, Convert], ...]:
    """Return the fields of a record, each with what makes its value of one of a description."""
    hints = get_type_hints(kind)
    return tuple((field.name, _converter(hints[field.name])) for field in fields(kind))


def _converter(hint: Any) -> Convert:
    """Return what makes a value of a type: quantities become numbers in SI units, lists tuples."""
    kind, inner = get_origin(hint), [_converter(one) for one in get_args(hint) if one not in (NoneType, Ellipsis)]
    if hint is float:
        return float
    if kind in (Union, UnionType):
        return _or_none(inner[0]) if len(inner) == 1 else _same
    if kind is tuple:
        return _tuple(inner)
    if isinstance(kind, type) and issubclass(kind, Mapping):
        return lambda value: {key: inner[1](one) for key, one in value.items()}
    if isinstance(hint, type) and is_dataclass(hint):
        return lambda value: record_of(hint, value)
    return _same


def _same(value: Any) -> Any:
    return value


def _or_none(convert: Convert) -> Convert:
    return lambda value: None if value is None else convert(value)


def _tuple(inner: list[Convert]) -> Convert:
    """Return what makes a tuple: of as many values as it has types, or of any number of one type."""
    if len(inner) == 1:
        return lambda value: tuple(map(inner[0], value))
    return lambda value: tuple(convert(one) for convert, one in zip(inner, value, strict=True))
