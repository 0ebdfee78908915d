"""Values: entries of the model as words with values, and which of them changed."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import fields, is_dataclass
from typing import Any

from rosorin_compile.model import Pose
from rosorin_compile.model.geometry import IDENTITY

from .difference import OTHER, Item
from .proof import Tolerance
from .wording import number_pair

# The value of each word that an entry says.
Said = Mapping[str, Any]
_UNSAID = ("source",)  # where a number comes from is no part of a robot


def changed_values(kind: str, old: Mapping[str, Said], new: Mapping[str, Said]) -> Iterator[Item]:
    """Yield what differs between entries by their names: what is new or gone, and each value that changed."""
    for name in dict.fromkeys([*old, *new]):
        mine, theirs = old.get(name), new.get(name)
        if mine is None or theirs is None:
            text = f"new: {name}" if mine is None else f"removed: {name}"
            yield Item(OTHER, name, kind, text, None if mine is None else name, None if theirs is None else name)
        else:
            yield from changed_entry(name, mine, theirs)


def changed_entry(name: str, old: Any, new: Any) -> Iterator[Item]:
    """Yield each value that changed of an entry that both robots have."""
    for word, one, other in differing(old, new):
        before, after = text_of(one, other), text_of(other, one)
        text = f"{name}: {word} {before or 'none'} -> {after or 'none'}"
        yield Item(OTHER, name, word, text, before or None, after or None)


def differing(one: Any, other: Any, word: str = "") -> Iterator[tuple[str, Any, Any]]:
    """Yield what differs between two entries of one kind: paths of words, and both values.

    Of lists of things with names it is the names, and what is said of those that both lists have.
    """
    if is_dataclass(one) and type(one) is type(other) and not isinstance(one, Pose):
        for field in fields(one):
            if field.name not in _UNSAID:
                yield from differing(getattr(one, field.name), getattr(other, field.name), _path(word, field.name))
    elif isinstance(one, Mapping) and isinstance(other, Mapping):
        for key in dict.fromkeys([*one, *other]):
            yield from differing(one.get(key), other.get(key), _path(word, key))
    elif _has_entries(one) or _has_entries(other):
        old, new = _named(one or ()), _named(other or ())
        if [*old] != [*new]:
            yield word, tuple(old), tuple(new)
        for name in old:
            if name in new:
                yield from differing(old[name], new[name], _path(word, name))
    elif not _same(one, other):
        yield word, one, other


def _path(word: str, key: object) -> str:
    return f"{word} {str(key).replace('_', ' ')}".strip()


def _has_entries(value: Any) -> bool:
    return isinstance(value, (tuple, list)) and any(is_dataclass(one) or isinstance(one, Mapping) for one in value)


def _named(values: Sequence[Any]) -> dict[str, Any]:
    """Return things by their names, those without one and later ones of the same name by number, too."""
    found: dict[str, Any] = {}
    counts = Counter[str]()
    for one in values:
        name = str(getattr(one, "name", "") or getattr(one, "element", ""))
        counts[name] += 1
        found[f"{name} {counts[name]}".strip() if not name or counts[name] > 1 else name] = one
    return found


def _same(one: Any, other: Any) -> bool:
    """Say whether two values are one, but for what calculating leaves of a number."""
    if isinstance(one, Pose) and isinstance(other, Pose):
        return _same((*one.xyz, *one.rpy), (*other.xyz, *other.rpy))
    if isinstance(one, (tuple, list)) and isinstance(other, (tuple, list)):
        return len(one) == len(other) and all(map(_same, one, other))
    if _is_number(one) and _is_number(other):
        return Tolerance.same(one, other)
    return text_of(one) == text_of(other)


def _is_number(value: Any) -> bool:
    return isinstance(value, (int, float)) and not isinstance(value, bool)


def text_of(value: Any, other: Any = None) -> str:
    """Return a value as a person reads it, with the digits that tell it from another; empty where it says nothing."""
    if value is None or value is False or value == () or value == IDENTITY:
        return "false" if value is False else ""
    if isinstance(value, Pose):
        twin = other if isinstance(other, Pose) else value
        return f"xyz {text_of(value.xyz, twin.xyz)} rpy {text_of(value.rpy, twin.rpy)}"
    if isinstance(value, (tuple, list)):
        twins = other if isinstance(other, (tuple, list)) and len(other) == len(value) else value
        return " ".join(text_of(one, twin) or "-" for one, twin in zip(value, twins, strict=True))
    if isinstance(value, frozenset):
        return " ".join(sorted(map(str, value)))
    if isinstance(value, bool):
        return "true"
    if _is_number(value):
        return number_pair(float(value), float(other) if _is_number(other) else float(value))[0]
    if is_dataclass(value):
        return " ".join(filter(None, (text_of(getattr(value, field.name)) for field in fields(value))))
    if isinstance(value, Mapping):
        return ", ".join(f"{key} {text_of(one)}" for key, one in value.items())
    return str(value)
