"""Define limits, dynamics, inertials and colours that several links or joints share under ``let``."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator
from typing import Any

from rosorin_compile.source.tree import Map, Path, Seq
from rosorin_compile.source.units import Quantity

from ..description import free_name, identifier, is_default
from ..layout import ROTATING, Expression, in_degrees, joint_unit
from .nodes import scalars, table

_RESERVED = ("name", "mirrored", "prefix", "first")
_MIN_PLACES = 3
_MIN_SAVED = 50  # characters that a name has to save
_KEYS = ("limit", "dynamics", "inertial", "rgba")


def with_named_values(tree: Map) -> Map:
    """Return a tree in which repeated values have names; values of the given tree are replaced."""
    parts = (tree.get("parts") or {}).values()
    taken = {name for part in parts for key in ("params", "let") for name in part.get(key) or ()} | {*_RESERVED}
    groups: dict[tuple[Path, str, bool], list[Map]] = defaultdict(list)
    for entry, path, is_rotating in _entries(tree):
        for key in _KEYS:
            value = entry.get(key)
            items = [item for _, item in scalars(value)] if isinstance(value, (Map, Seq)) else []
            if any(items) and not any(isinstance(item, Expression) for item in items):
                text = repr(sorted(map(repr, scalars(value))))
                groups[(*path, key), text, is_rotating].append(entry)
    named: dict[str, Any] = {}
    for (path, _, is_rotating), entries in groups.items():
        key = str(path[-1])
        value = entries[0][key]
        saved = (len(str(value)) - len(key) - 6) * len(entries) - len(str(value))
        if len(entries) < _MIN_PLACES or (key != "rgba" and saved < _MIN_SAVED):
            continue
        materials = {str(entry.get("material") or "") for entry in entries}
        word = materials.pop() if key == "rgba" and len(materials) == 1 else ""
        if not (word.isascii() and word[:1].isalpha()):
            word = "colour" if key == "rgba" else key
        name = free_name(identifier(word), taken)
        taken.add(name)
        named[name] = _shown(value, path, is_rotating)
        for entry in entries:
            entry[key] = Expression(f"${{{name}}}")
    if not named:
        return tree
    made = tree.copy()
    made.put("let", table(tree.span, named), tree.span, tree.span)
    return made


def _entries(tree: Map) -> Iterator[tuple[Map, Path, bool]]:
    """Yield the entries that may have values with names, with their paths in the schema, and if they rotate."""
    for body in (*(tree.get("parts") or {}).values(), tree):
        for joint in (body.get("joints") or {}).values():
            yield joint, ("joints", "*"), joint["type"] in ROTATING
        for link in (body.get("links") or {}).values():
            shapes = [one for key in ("visual", "collision") for one in link.get(key) or ()]
            inner = [(link, ("links", "*")), *((one, ("links", "*", "visual", 0)) for one in shapes)]
            yield from ((one, path, False) for one, path in inner if isinstance(one, Map))


def _shown(value: Any, path: Path, is_rotating: bool) -> Any:
    """Return a table without default values, angles of a rotating joint in degrees where those are short."""
    if not isinstance(value, Map):
        return value
    made = Map(value.span)
    for key, item in value.items():
        here = (*path, key)
        if is_default(here, item):
            continue
        unit = joint_unit(*map(str, here[2:])) if is_rotating else ""
        text = in_degrees(item, unit) if unit and isinstance(item, float) and item else ""
        shown = Quantity.parse(text) if text else _shown(item, here, is_rotating)
        made.put(key, shown, value.key_spans[key], value.value_spans[key])
    return made
