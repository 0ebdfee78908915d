"""Read links, joints and materials of a xacro as entries of the language, their values not evaluated yet."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from rosorin_compile.source.xml.markup import Element

from .texts import Unsupported
from .tree import (
    FILE,
    FREE,
    NAME,
    XML,
    Body,
    Call,
    Entry,
    Given,
    Handed,
    Item,
    Piece,
    Scope,
    Text,
    Whens,
    is_plain,
    literal,
    note,
)

if TYPE_CHECKING:
    from .build import Found, Program

_SHAPES: dict[str, tuple[tuple[str, str], ...]] = {
    "box": (("size", "length3"),),
    "sphere": (("radius", "length"),),
    "cylinder": (("radius", "length"), ("length", "length")),
    "capsule": (("radius", "length"), ("length", "length")),
}
_NUMBERS = {
    "limit": ("lower", "upper", "effort", "velocity"),
    "dynamics": ("damping", "friction"),
    "safety_controller": ("soft_lower_limit", "soft_upper_limit", "k_position", "k_velocity"),
    "calibration": ("rising", "falling", "reference_position"),
}
# What is read by its attributes alone.
_LEAVES = {
    "origin",
    "mass",
    "inertia",
    "color",
    "texture",
    "mesh",
    "parent",
    "child",
    "axis",
    "mimic",
    *_SHAPES,
    *_NUMBERS,
}
_MOMENTS = ("ixx", "iyy", "izz", "ixy", "ixz", "iyz")
_OF_DIMENSION = ("lower", "upper", "soft_lower_limit", "soft_upper_limit", "offset", "rising", "falling")
_ROTATING = ("revolute", "continuous")
_WITHOUT_EFFECT = {"fixed": ("axis", "limit", "mimic", "dynamics"), "floating": ("axis", "limit")}
# Where an origin may be inserted; it is read in the same way.
ORIGIN_LEVELS = frozenset(("inertial", "solid", "joint", "origin"))


def read_entry(program: Program, element: Element, scope: Scope, level: str, body: Body) -> Entry:
    """Return the entry for the content of an element of a level, such as ``link`` or ``geometry``."""
    entry = Entry()
    for found in program.flow(element, scope, (), level, body):
        read_found(program, found, level, entry)
    return entry


def read_found(program: Program, found: Found, level: str, entry: Entry) -> None:
    """Add what ``Program.flow`` found at a level to an entry. Raises Unsupported."""
    child, scope, when, comments, body = found
    if isinstance(child, Call):
        items = {item.key: item for item in reversed(child.macro.entry.items)} if child.macro.entry else {}
        for item in reversed(items.values()):
            if isinstance(item.value, list):
                for index in range(len(item.value)):
                    entry.add(item.key, Given(child, item.key, index), when)
            else:
                entry.put(item.key, Given(child, item.key), when)
    elif isinstance(child, Handed):
        levels = child.macro.block_levels
        known = levels.setdefault(child.name, level)
        if known != level and not {known, level} <= ORIGIN_LEVELS:
            raise Unsupported(f'the block "{child.name}" is inserted in several kinds of elements')
        levels[child.name] = known if known == level else "origin"
        entry.put("&", child, when)
    elif child.tag in _LEAVES and child.children:
        raise Unsupported(f"<{child.children[0].tag}> in <{child.tag}>", child.children[0].span)
    elif not _READ[level](program, child, scope, when, entry, comments, body):
        if level not in ("link", "joint", "solid"):
            raise Unsupported(f"<{child.tag}> cannot be translated", child.span)
        entry.add("urdf_elements", program.xml(child, scope, body), when)


def joint_entry(program: Program, element: Element, scope: Scope, body: Body) -> Entry:
    """Return the entry of a joint."""
    kind = program.names.value(element, "type", scope, NAME)
    made = read_entry(program, element, scope, "joint", body)
    made.items.insert(0, Item("type", kind))
    word = kind.plain or ""
    made.items = [item for item in made.items if item.key not in _WITHOUT_EFFECT.get(word, ())]
    set_dimensions(made, word, word in ("revolute", "prismatic"))
    for item in made.items:
        if item.key == "limit" and word == "continuous" and isinstance(item.value, Entry):
            ends = [one for one in item.value.items if one.key in ("lower", "upper")]
            if all(one.value.plain is not None and literal(one.value.plain) == 0 for one in ends):
                item.value.items = [one for one in item.value.items if one not in ends]
    return made


def set_dimensions(joint: Entry, kind: str, has_range: bool) -> None:
    """Set whether the numbers of a joint of a type are angles or lengths; a range that is not given is zero."""
    sink = "angle" if kind in _ROTATING else "length" if kind == "prismatic" else "number"
    for item in joint.items:
        entry = item.value
        if item.key not in (*_NUMBERS, "mimic") or not isinstance(entry, Entry):
            continue
        for name in ("upper", "lower") if item.key == "limit" and has_range else ():
            if name not in entry.keys():  # noqa: SIM118 - an entry, not a mapping
                entry.items.insert(0, Item(name, Text([Piece("text", "0")])))
        for number in (one for one in entry.items if isinstance(one.value, Text) and one.key != "joint"):
            speed = "speed" if number.key == "velocity" and kind in _ROTATING else "number"
            number.value.sink = sink if number.key in _OF_DIMENSION else speed
            note(number.value)


def _in_link(
    program: Program, child: Element, scope: Scope, when: Whens, entry: Entry, comments: tuple[str, ...], body: Body
) -> bool:
    if child.tag == "inertial":
        entry.put("inertial", read_entry(program, child, scope, "inertial", body), when)
    elif child.tag in ("visual", "collision"):
        solid = read_entry(program, child, scope, "solid", body)
        if child.get("name"):  # a part puts nothing before it
            solid.items.insert(0, Item("name", program.names.value(child, "name", scope, XML)))
        if child.tag == "collision":
            solid.items = [item for item in solid.items if item.key not in ("material", "rgba", "texture")]
            for found in program.flow(child, scope, (), "collision", body):
                if isinstance(found.item, Element) and found.item.tag == "material":
                    solid.add("urdf_elements", program.xml(found.item, found.scope, body), found.when)
        entry.add(child.tag, solid, when, comments)
    else:
        return False
    return True


def _in_inertial(
    program: Program, child: Element, scope: Scope, when: Whens, entry: Entry, _: tuple[str, ...], body: Body
) -> bool:
    if child.tag == "mass":
        entry.put("mass", program.names.value(child, "value", scope, "mass"), when)
    elif child.tag == "inertia":
        moments = Entry()
        for name in _MOMENTS:
            if name in child.attributes and not (name in _MOMENTS[3:] and _is_zero(child.get(name))):
                moments.put(name, program.names.value(child, name, scope, "number"))
        entry.put("inertia", moments, when)
    else:
        return _origin(program, child, scope, when, entry, (), body)
    return True


def _origin(
    program: Program, child: Element, scope: Scope, when: Whens, entry: Entry, _: tuple[str, ...], __: Body
) -> bool:
    if child.tag != "origin":
        return False
    for name in child.attributes:
        if name not in ("xyz", "rpy"):
            raise Unsupported(f"the attribute {name} of <origin>", child.span)
    for name, sink in (("xyz", "length3"), ("rpy", "angle3")):
        if name in child.attributes and not (_is_zero(child.get(name)) and name not in entry.keys()):  # noqa: SIM118 - an entry, not a mapping
            entry.put(name, program.names.value(child, name, scope, sink), when)
    return True


def _in_solid(
    program: Program, child: Element, scope: Scope, when: Whens, entry: Entry, _: tuple[str, ...], body: Body
) -> bool:
    if child.tag == "geometry":
        inner = read_entry(program, child, scope, "geometry", body)
    elif child.tag == "material":
        if child.get("name"):  # a part has none of its own
            entry.put("material", program.names.value(child, "name", scope, XML), when)
        inner = read_entry(program, child, scope, "material", body)
    else:
        return _origin(program, child, scope, when, entry, (), body)
    for item in inner.items:
        entry.put(item.key, item.value, (*when, *item.when))
    return True


def _in_material(
    program: Program, child: Element, scope: Scope, when: Whens, entry: Entry, _: tuple[str, ...], __: Body
) -> bool:
    if child.tag == "color":
        entry.put("rgba", program.names.value(child, "rgba", scope, "number4"), when)
    elif child.tag == "texture":
        if child.get("filename"):
            entry.put("texture", program.names.value(child, "filename", scope, FILE), when)
    else:
        return False
    return True


def _in_geometry(
    program: Program, child: Element, scope: Scope, when: Whens, entry: Entry, _: tuple[str, ...], __: Body
) -> bool:
    made = Entry()
    if child.tag == "mesh":
        made.put("file", program.names.value(child, "filename", scope, FILE))
        if "scale" in child.attributes and child.get("scale").split() != ["1", "1", "1"]:
            made.put("scale", program.names.value(child, "scale", scope, "number3"))
    elif child.tag in _SHAPES:
        for name, sink in _SHAPES[child.tag]:
            made.put(name, program.names.value(child, name, scope, sink))
    else:
        return child.tag == "material"  # no reader looks there; the import reports it
    entry.put(child.tag, made, when)
    return True


def _in_joint(
    program: Program, child: Element, scope: Scope, when: Whens, entry: Entry, _: tuple[str, ...], body: Body
) -> bool:
    made = Entry()
    if child.tag in ("parent", "child"):
        entry.put(child.tag, program.names.value(child, "link", scope, NAME), when)
        return True
    if child.tag == "axis":
        entry.put("axis", program.names.value(child, "xyz", scope, "number3"), when)
        return True
    if child.tag == "mimic":
        made.put("joint", program.names.value(child, "joint", scope, NAME))
    elif child.tag not in _NUMBERS:
        return _origin(program, child, scope, when, entry, (), body)
    for name in _NUMBERS.get(child.tag, ("multiplier", "offset")):
        if name in child.attributes:
            made.put(name, program.names.value(child, name, scope, FREE))
    entry.put(child.tag, made, when)
    return True


def _is_zero(text: str) -> bool:
    numbers = [literal(word) for word in text.split()] if is_plain(text) else []
    return bool(numbers) and all(number == 0 and not isinstance(number, bool) for number in numbers)


_READ: dict[str, Any] = {
    "link": _in_link,
    "inertial": _in_inertial,
    "solid": _in_solid,
    "geometry": _in_geometry,
    "joint": _in_joint,
    "material": _in_material,
    "origin": _origin,
}
