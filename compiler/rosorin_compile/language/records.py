"""Convert entries of a description to dataclasses of the model.

``record_of`` fills each field from the key of the same name, so that a new key needs a field in the model and nothing
here. Values that follow from other keys are passed to it explicitly.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping
from dataclasses import fields, is_dataclass
from functools import cache, partial
from types import NoneType, UnionType
from typing import Any, Protocol, TypeVar, Union, get_args, get_origin, get_type_hints

from rosorin_compile.model import Pose, Vector
from rosorin_compile.model.simulation import Attribute, Values
from rosorin_compile.source.diagnostics import Help
from rosorin_compile.source.tree import Path

from .schema import fragment_at

T = TypeVar("T")
Convert = Callable[[Any], Any]


class Problem(Protocol):
    """Reports a problem at a path of the tree, or at the last key of the path."""

    def __call__(self, rule: str, message: str, path: Path, help: Help = "", *, key: bool = False) -> None: ...


def entries_of(tree: Mapping[str, Any], section: str) -> list[tuple[str, Any]]:
    """Return the entries of a section in the order of the model: by name, or as they are written (x-ordered)."""
    entries = (tree.get(section) or {}).items()
    return list(entries) if fragment_at((section,)).get("x-ordered") else sorted(entries)


def record_of(kind: Callable[..., T], entry: Mapping[str, Any] | None, /, **given: Any) -> T:
    """Return a dataclass whose fields come from the keys of an entry, or from ``given``; else they have defaults.

    A field of type ``Pose`` comes from ``xyz`` (m) and ``rpy`` (rad); one called ``values`` has the remaining keys.
    """
    entry = entry or {}
    converters, poses, has_values = _fields(kind)
    found = {name: convert(entry[name]) for name, convert in converters.items() if name in entry and name not in given}
    for name in poses:
        if name not in given:
            found[name] = pose_of_entry(entry)
    if has_values and "values" not in given:
        found["values"] = values_of(entry, ("xyz", "rpy", "source", *converters))
    return kind(**found, **given)


def named_records(kind: Callable[..., T], entries: Mapping[str, Any] | None) -> dict[str, T]:
    """Return the records of entries by name, each with its name if it has a field for that."""
    names = {str(name): {"name": str(name)} if "name" in _fields(kind)[0] else {} for name in entries or ()}
    return {name: record_of(kind, (entries or {})[name], **given) for name, given in names.items()}


def _records(kind: Callable[..., T], value: Any) -> tuple[T, ...]:
    """Return the records of a list of entries, of entries by name, of a list of names, or of one name."""
    if isinstance(value, Mapping):
        return tuple(named_records(kind, value).values())
    items = [value] if isinstance(value, str) else value or ()
    return tuple(record_of(kind, None, name=str(i)) if isinstance(i, str) else record_of(kind, i) for i in items)


def vector_of(value: Any, default: Vector = (0.0, 0.0, 0.0)) -> Vector:
    """Return three numbers of a description as a vector."""
    if value is None:
        return default
    x, y, z = value
    return (float(x), float(y), float(z))


def pose_of_entry(entry: Mapping[str, Any]) -> Pose:
    """Return the pose given by ``xyz`` (m) and ``rpy`` (rad) of an entry."""
    return Pose(vector_of(entry.get("xyz")), vector_of(entry.get("rpy")))


def plain(value: Any) -> Any:
    """Return a value without places and sources: quantities as numbers in SI units, lists as tuples."""
    if isinstance(value, Mapping):
        return {str(key): plain(item) for key, item in value.items() if key != "source"}
    if isinstance(value, list):
        return tuple(plain(item) for item in value)
    if isinstance(value, float):
        return float(value)
    return str(value) if isinstance(value, str) else value


def values_of(entry: Mapping[str, Any] | None, known: Collection[str] = ()) -> dict[str, Attribute]:
    """Return MJCF attributes by name; ``known`` are other keys of the entry."""
    return {key: _attribute_of(value) for key, value in sorted((entry or {}).items()) if key not in known}


def renamed_values(entry: Mapping[str, Any], words: Mapping[str, str]) -> dict[str, Attribute]:
    """Return the values of an entry under the names that MJCF has for its keys."""
    return {word: _attribute_of(entry[key]) for key, word in words.items() if key in entry}


def _attribute_of(value: Any) -> Attribute:
    if isinstance(value, list):
        return tuple(_attribute_of(item) for item in value)  # type: ignore[misc]
    if value is None or isinstance(value, bool):
        return value
    return str(value) if isinstance(value, str) else float(value)


@cache
def _fields(kind: Any) -> tuple[dict[str, Convert], tuple[str, ...], bool]:
    """Return the converters of fields by name, the names of fields that are poses, and whether it has ``values``."""
    types = get_type_hints(kind)
    hints = {field.name: types[field.name] for field in fields(kind)}
    poses = tuple(name for name, hint in hints.items() if hint is Pose)
    has_values = hints.get("values") == Values
    return {name: _converter(hint) for name, hint in hints.items() if hint is not Pose}, poses, has_values


def _converter(hint: Any) -> Convert:
    """Return the conversion to a type: quantities become numbers in SI units, lists (or one item) become tuples."""
    if hint == Values:
        return values_of
    if hint is float:
        return float
    kind = get_origin(hint)
    inner = [_converter(one) for one in get_args(hint) if one not in (NoneType, Ellipsis)]
    if kind in (Union, UnionType):
        if len(inner) != 1:
            return plain
        return lambda value: None if value is None else inner[0](value)
    if kind is tuple and is_dataclass(get_args(hint)[0]):
        return partial(_records, get_args(hint)[0])
    if kind is tuple and len(inner) == 1:
        return lambda value: tuple(map(inner[0], value if isinstance(value, (list, tuple)) else [value]))
    if kind is tuple:
        return lambda value: tuple(convert(one) for convert, one in zip(inner, value, strict=True))
    if isinstance(kind, type) and issubclass(kind, Mapping):
        of = get_args(hint)[1]
        if isinstance(of, type) and is_dataclass(of):
            return lambda value: named_records(of, value)
        return lambda value: {key: inner[1](one) for key, one in value.items()}
    if isinstance(hint, type) and is_dataclass(hint):
        return lambda value: record_of(hint, value)
    return lambda value: value
