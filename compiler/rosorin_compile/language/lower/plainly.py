"""Plainly: a record of the model made of an entry whose keys are called as the fields of the record.

What has another name in the model, or is worked out, is given beside the entry. A field that is a ``Pose`` is made of
``xyz`` and ``rpy``.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import fields, is_dataclass
from functools import cache
from types import NoneType, UnionType
from typing import Any, TypeVar, Union, get_args, get_origin, get_type_hints

from rosorin_compile.model import Pose, Vector
from rosorin_compile.model.geometry import IDENTITY

T = TypeVar("T")
Convert = Callable[[Any], Any]


def record_of(kind: Callable[..., T], entry: Mapping[str, Any] | None, /, **given: Any) -> T:
    """Return a record of a kind: each field from its key in the entry, or from ``given``; else it has its default."""
    said = entry or {}
    found = {name: convert(said[name]) for name, convert in _fields(kind) if name in said and name not in given}
    placed = {name: pose_of_entry(said) for name in _poses(kind) if name not in given}
    return kind(**found, **placed, **given)


def vector_of(value: Any, default: Vector = (0.0, 0.0, 0.0)) -> Vector:
    """Return three numbers of a description as a vector."""
    if value is None:
        return default
    x, y, z = value
    return (float(x), float(y), float(z))


def pose_of_entry(entry: Mapping[str, Any]) -> Pose:
    """Return the pose that ``xyz`` (m) and ``rpy`` (rad) of an entry say."""
    if "xyz" not in entry and "rpy" not in entry:
        return IDENTITY
    return Pose(vector_of(entry.get("xyz")), vector_of(entry.get("rpy")))


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
    return tuple((field.name, _converter(hints[field.name])) for field in fields(kind) if hints[field.name] is not Pose)


@cache
def _poses(kind: Any) -> tuple[str, ...]:
    """Return the fields of a record that are a pose."""
    hints = get_type_hints(kind)
    return tuple(field.name for field in fields(kind) if hints[field.name] is Pose)


def named_records(kind: Callable[..., T], entries: Mapping[str, Any] | None) -> dict[str, T]:
    """Return the records of entries by name, each with its name if it has a field for that."""
    named = is_dataclass(kind) and any(field.name == "name" for field in fields(kind))
    return {
        str(name): record_of(kind, entry, **({"name": str(name)} if named else {}))
        for name, entry in (entries or {}).items()
    }


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
        of = get_args(hint)[1]
        if isinstance(of, type) and is_dataclass(of):
            return lambda value: named_records(of, value)
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
