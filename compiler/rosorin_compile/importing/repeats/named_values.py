"""Define limits, dynamics, inertias and colours that several links or joints share under ``let``."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator
from typing import Any

from rosorin_compile.source.tree import Map, Path, Seq
from rosorin_compile.source.units import Quantity

from ..description import free_name, identifier, is_default
from ..layout import ROTATING, Expression, in_degrees, joint_unit
from .nodes import flattened, table
from .part_names import part_name

_RESERVED = ("name", "mirrored", "prefix", "first", "meshes")
_MIN_PLACES = 3
_MIN_SAVED = 50  # characters that a name has to save
_KEYS = (("limit", "dynamics", "contact", "inertial", "rgba"), ("inertia",))  # the outer ones first

Place = tuple[str, Map]  # the name of a link or joint, and the entry in it that has the value


def with_named_values(tree: Map) -> Map:
    """Return a tree in which repeated values have names; values of the given tree are replaced."""
    parts = (tree.get("parts") or {}).values()
    taken = {name for part in parts for key in ("params", "let") for name in part.get(key) or ()} | {*_RESERVED}
    named: dict[str, Any] = {}
    for keys in _KEYS:
        groups: dict[tuple[Path, str, bool], list[Place]] = defaultdict(list)
        for name, entry, path, is_rotating in _entries(tree):
            for key in keys:
                value = entry.get(key)
                items = [item for _, item in flattened(value)] if isinstance(value, (Map, Seq)) else []
                if any(items) and not any(isinstance(item, Expression) for item in items):
                    text = repr(sorted(map(repr, flattened(value))))
                    groups[(*path, key), text, is_rotating].append((name, entry))
        worth = {group: places for group, places in groups.items() if _is_worth(str(group[0][-1]), places)}
        for (path, _, is_rotating), places in worth.items():
            key = str(path[-1])
            is_only = sum(other[0][-1] == key for other in worth) == 1
            name = free_name(_name(key, places, is_only), taken)
            taken.add(name)
            named[name] = _shown(places[0][1][key], path, is_rotating)
            for _, entry in places:
                entry[key] = Expression(f"${{{name}}}")
    if not named:
        return tree
    made = tree.copied()
    made.put("let", table(tree.span, named), tree.span, tree.span)
    return made


def _entries(tree: Map) -> Iterator[tuple[str, Map, Path, bool]]:
    """Yield the entries that may have values with names: its owner, its path in the schema, and if it rotates."""
    for body in (*(tree.get("parts") or {}).values(), tree):
        for name, joint in (body.get("joints") or {}).items():
            yield name, joint, ("joints", "*"), joint["type"] in ROTATING
        for name, link in (body.get("links") or {}).items():
            inner: list[tuple[Path, Any]] = [((), link), (("inertial",), link.get("inertial"))]
            inner += [(("visual", 0), one) for key in ("visual", "collision") for one in link.get(key) or ()]
            yield from ((name, one, ("links", "*", *at), False) for at, one in inner if isinstance(one, Map))


def _is_worth(key: str, places: list[Place]) -> bool:
    text = str(places[0][1][key])
    saved = (len(text) - len(key) - 6) * len(places) - len(text)
    return len(places) >= _MIN_PLACES and (key == "rgba" or saved >= _MIN_SAVED)


def _name(key: str, places: list[Place], is_only: bool) -> str:
    """Return a name for a value: the colour's, or what it is, with whose it is if there are several of the kind."""
    materials = {str(entry.get("material") or "") for _, entry in places}
    material = materials.pop() if key == "rgba" and len(materials) == 1 else ""
    if material.isascii() and material[:1].isalpha():
        return identifier(material)
    owners = sorted({name for name, _ in places})
    owner, word = part_name(owners, owners[:1]), "colour" if key == "rgba" else key
    return identifier(word if is_only or owner == "piece" else f"{owner}_{word}")


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
