"""Values: what stands in several places of a description, and is the same, gets a name under ``let``.

Limits, contacts, inertias and colours as a whole; of single numbers those with so many digits that a reader would have
to compare them.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator
from typing import Any, NamedTuple

from rosorin_compile.source.numbers import exact
from rosorin_compile.source.tree import Map, Seq
from rosorin_compile.source.units import Quantity

from ..layout import ROTATING, Expression, in_degrees, joint_unit
from .forms import says_nothing
from .names import whole
from .parameters import identifier, means_something

FEW = 3  # places, from which on a table or a colour has a name
FEW_NUMBERS = 4  # places, for a single number
MANY_DIGITS = 15  # of a number that has a name: as many as a computer writes
WORTH = 50  # letters that a name has to save
_TABLES = ("limit", "dynamics", "contact", "inertial", "inertia")
_NUMBERS = {
    **dict.fromkeys(("mass", "radius", "length"), ""),
    **dict.fromkeys(("ixx", "iyy", "izz"), "moment"),
}
_SHAPES = ("visual", "collision")


class Place(NamedTuple):
    """Where a value stands: what holds it and under which key, and whose it is: a link or a joint."""

    holder: Map
    key: str
    owner: str
    turns: bool


def with_values(tree: Map) -> Map:
    """Return a tree in which values that stand in several places have names; the places in it are changed."""
    taken = _taken(tree)
    lets = Map(tree.span)
    for kinds in (("limit", "dynamics", "contact", "inertial", "rgba"), ("inertia",), tuple(_NUMBERS)):
        groups: dict[Any, list[Place]] = defaultdict(list)
        for place in _places(tree, kinds):
            groups[_group(place)].append(place)
        several = [those for those in groups.values() if _is_worth(those)]
        for those in several:
            alike = sum(_word(other[0]) == _word(those[0]) for other in several)
            name = _name(those, taken, alike > 1)
            taken.add(name)
            first = those[0]
            lets.put(name, _spelt(first), tree.span, first.holder.value_spans.get(first.key, tree.span))
            for place in those:
                place.holder[place.key] = Expression(f"${{{name}}}")
    if not lets:
        return tree
    made = Map(tree.span, tree.via)
    for key, value in tree.items():
        made.put(key, value, tree.key_spans[key], tree.value_spans[key])
    made.put("let", lets, tree.span, tree.span)
    return made


def copied(value: Any) -> Any:
    """Return a tree that may be changed without changing that of the source."""
    if isinstance(value, Map):
        made = Map(value.span, value.via)
        for key, item in value.items():
            made.put(key, copied(item), value.key_spans[key], value.value_spans[key])
        return made
    if isinstance(value, Seq):
        items = Seq(value.span, value.via)
        for item, span in zip(value, value.value_spans, strict=True):
            items.put(copied(item), span)
        return items
    return value


def _taken(tree: Map) -> set[str]:
    """Return the names that mean something already, somewhere."""
    parts = (tree.get("parts") or {}).values()
    return {name for part in parts for key in ("params", "let") for name in part.get(key) or ()} | {
        "meshes",
        "mesh_scale",
        "name",
        "prefix",
        "mirrored",
    }


def _places(tree: Map, kinds: tuple[str, ...]) -> Iterator[Place]:
    """Yield the places of values of some kinds, in links and joints, those of parts too."""
    for body in (*(tree.get("parts") or {}).values(), tree):
        for name, joint in (body.get("joints") or {}).items():
            yield from (Place(joint, key, name, joint["type"] in ROTATING) for key in kinds if _fits(joint, key))
        for name, link in (body.get("links") or {}).items():
            for holder in _holders(link):
                yield from (Place(holder, key, name, False) for key in kinds if _fits(holder, key))


def _holders(link: Map) -> Iterator[Map]:
    """Yield what holds values of a link: itself, its inertial, its shapes and what those are."""
    yield link
    inertial = link.get("inertial")
    if isinstance(inertial, Map):
        yield inertial
        if isinstance(inertial.get("inertia"), Map):
            yield inertial["inertia"]
    for purpose in _SHAPES:
        for shape in link.get(purpose) or ():
            if isinstance(shape, Map):
                yield shape
                yield from (item for item in shape.values() if isinstance(item, Map))


def _fits(holder: Map, key: str) -> bool:
    value = holder.get(key)
    if key in _NUMBERS:
        return isinstance(value, float) and not isinstance(value, Quantity) and len(_digits(value)) >= MANY_DIGITS
    said = value.values() if isinstance(value, Map) else value if isinstance(value, Seq) else ()
    return any(said) and _is_plain(value)


def _digits(value: float) -> str:
    return exact(abs(value)).partition("e")[0].replace(".", "").strip("0")


def _is_plain(value: Any) -> bool:
    items = value.values() if isinstance(value, Map) else value if isinstance(value, Seq) else ()
    return not isinstance(value, Expression) and all(map(_is_plain, items))


def _group(place: Place) -> Any:
    """Return what places have in common that may share a name."""
    value = place.holder[place.key]
    return place.key if place.key not in _NUMBERS else _word(place), place.turns, _frozen(value)


def _frozen(value: Any) -> Any:
    if isinstance(value, Map):
        return frozenset((key, _frozen(item)) for key, item in value.items())
    return tuple(map(_frozen, value)) if isinstance(value, Seq) else (type(value) is bool, value)


def _is_worth(places: list[Place]) -> bool:
    key, value = places[0].key, places[0].holder[places[0].key]
    if key in _NUMBERS:
        return len(places) >= FEW_NUMBERS
    if key == "rgba":
        return len(places) >= FEW
    length = len(str(value))
    return len(places) >= FEW and (length - len(key) - 6) * len(places) - length >= WORTH


def _word(place: Place) -> str:
    return _NUMBERS.get(place.key) or {"rgba": "colour"}.get(place.key, place.key)


def _name(places: list[Place], taken: set[str], several: bool) -> str:
    """Return a name for a value: what it is, and whose where there are several of the kind."""
    word = _word(places[0])
    looks = {str(place.holder.get("material") or "") for place in places} if places[0].key == "rgba" else {""}
    look = looks.pop() if len(looks) == 1 else ""
    look = identifier(look) if look.isascii() and look[:1].isalpha() else ""
    owners = sorted({place.owner for place in places})
    owner = whole(owners, owners[:1]) if several else ""
    wanted = look or identifier(f"{owner}_{word}" if owner and owner not in ("piece", "limb") else word)
    name, number = wanted, 1
    while name in taken or means_something(name):
        number += 1
        name = f"{wanted}_{number}"
    return name


def _spelt(place: Place) -> Any:
    """Return a value as it stands under ``let``: angles in degrees where a person would write them so."""
    value = place.holder[place.key]
    if not isinstance(value, Map):
        return value
    return _lean(value, place.key, place.turns)


def _lean(value: Map, under: str, turns: bool) -> Map:
    made = Map(value.span)
    for key, item in value.items():
        if isinstance(item, Map):
            item = _lean(item, key, turns)
        elif says_nothing(key, item):
            continue
        unit = joint_unit(under, key) if turns else ""
        text = in_degrees(item, unit) if unit and isinstance(item, float) and item else ""
        made.put(key, Quantity.parse(text) if text else item, value.key_spans[key], value.value_spans[key])
    return made
