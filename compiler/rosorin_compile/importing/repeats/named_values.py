"""Define limits, dynamics, contacts, inertias and colours that several links or joints share under ``let``."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator
from typing import Any, NamedTuple

from rosorin_compile.source.tree import Map, Seq
from rosorin_compile.source.units import Quantity

from ..description import free_name, identifier
from ..layout import ROTATING, Expression, in_degrees, joint_unit
from .nodes import flattened, table
from .parameters import RESERVED
from .part_names import part_name
from .parts import has_default

_MIN_PLACES = 3
_MIN_SAVED = 50  # characters that a name has to save
_KEYS = (("limit", "dynamics", "contact", "inertial", "rgba"), ("inertia",))  # the outer ones first


class _Place(NamedTuple):
    """Where a value is: in an entry, under a key, of a link or joint, which rotates or not."""

    entry: Map
    key: str
    owner: str
    is_rotating: bool

    @property
    def value(self) -> Any:
        return self.entry[self.key]


def with_named_values(tree: Map) -> Map:
    """Return a tree in which repeated values have names; values of the given tree are replaced."""
    parts = (tree.get("parts") or {}).values()
    taken = {name for part in parts for key in ("params", "let") for name in part.get(key) or ()} | {*RESERVED}
    named: dict[str, Any] = {}
    for keys in _KEYS:
        groups: dict[Any, list[_Place]] = defaultdict(list)
        for place in _places(tree, keys):
            text = repr(sorted(map(repr, flattened(place.value))))
            groups[place.key, text, place.is_rotating].append(place)
        worth = [places for places in groups.values() if _is_worth(places)]
        for places in worth:
            is_only = sum(other[0].key == places[0].key for other in worth) == 1
            name = free_name(_name(places, is_only), taken)
            taken.add(name)
            named[name] = _shown(places[0].value, places[0].key, places[0].is_rotating)
            for place in places:
                place.entry[place.key] = Expression(f"${{{name}}}")
    if not named:
        return tree
    made = tree.copied()
    made.put("let", table(tree.span, named), tree.span, tree.span)
    return made


def _places(tree: Map, keys: tuple[str, ...]) -> Iterator[_Place]:
    for body in (*(tree.get("parts") or {}).values(), tree):
        owners = [(name, joint, joint["type"] in ROTATING) for name, joint in (body.get("joints") or {}).items()]
        for name, link in (body.get("links") or {}).items():
            shapes = [one for key in ("visual", "collision") for one in link.get(key) or ()]
            owners += [(name, entry, False) for entry in (link, *shapes, link.get("inertial"))]
        for name, entry, is_rotating in owners:
            if isinstance(entry, Map):
                yield from (_Place(entry, key, name, is_rotating) for key in keys if _is_plain(entry.get(key)))


def _is_plain(value: Any) -> bool:
    """Return True if a value can be named: a table or a list without expressions."""
    items = [item for _, item in flattened(value)] if isinstance(value, (Map, Seq)) else []
    return any(items) and not any(isinstance(item, Expression) for item in items)


def _is_worth(places: list[_Place]) -> bool:
    key, text = places[0].key, str(places[0].value)
    saved = (len(text) - len(key) - 6) * len(places) - len(text)
    return len(places) >= _MIN_PLACES and (key == "rgba" or saved >= _MIN_SAVED)


def _name(places: list[_Place], is_only: bool) -> str:
    """Return a name for a value: the colour's, or what it is, with whose it is if there are several of the kind."""
    word = "colour" if places[0].key == "rgba" else places[0].key
    materials = {str(place.entry.get("material") or "") for place in places} if word == "colour" else {""}
    material = materials.pop() if len(materials) == 1 else ""
    if material.isascii() and material[:1].isalpha():
        return identifier(material)
    owners = sorted({place.owner for place in places})
    owner = part_name(owners, owners[:1])
    return identifier(word if is_only or owner == "piece" else f"{owner}_{word}")


def _shown(value: Any, key: str, is_rotating: bool) -> Any:
    """Return a table without default values, angles of a rotating joint in degrees where those are short."""
    if not isinstance(value, Map):
        return value
    made = Map(value.span)
    for inner, item in value.items():
        if has_default(inner, item):
            continue
        unit = joint_unit(key, inner) if is_rotating else ""
        text = in_degrees(item, unit) if unit and isinstance(item, float) and item else ""
        shown = Quantity.parse(text) if text else _shown(item, inner, is_rotating)
        made.put(inner, shown, value.key_spans[inner], value.value_spans[inner])
    return made
