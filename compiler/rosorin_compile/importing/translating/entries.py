"""Entries: links, joints and materials of a xacro as entries of the language, their values not evaluated yet."""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING, Any

from rosorin_compile.source.xml.markup import Element

from .blocks import ORIGIN_LEVELS, owner
from .contexts import Comments
from .inside import Found, Inside
from .keeping import Keeping, xml_of
from .pieces import Call, Entry, Given, Handed, Item, Macro, Whens, Xml
from .scopes import FILE, FREE, NAME, XML, Scope, Value, is_plain, literal, note
from .texts import Unsupported

if TYPE_CHECKING:
    from .walking import Walker

_SHAPES: dict[str, tuple[tuple[str, str], ...]] = {"box": (("size", "length3"),), "sphere": (("radius", "length"),)}
_SHAPES |= dict.fromkeys(("cylinder", "capsule"), (("radius", "length"), ("length", "length")))
# What is read by its attributes alone.
_LEAVES = frozenset(
    (
        *("origin", "mass", "inertia", "color", "texture", "box", "cylinder", "sphere", "capsule", "mesh"),
        *("parent", "child", "axis", "limit", "mimic", "dynamics", "safety_controller", "calibration"),
    )
)
_MOMENTS = ("ixx", "iyy", "izz", "ixy", "ixz", "iyz")
_OF_DIMENSION = ("lower", "upper", "soft_lower_limit", "soft_upper_limit", "offset", "rising", "falling")
_ROTATING = ("revolute", "continuous")
_WITHOUT_EFFECT = {"fixed": ("axis", "limit", "mimic", "dynamics"), "floating": ("axis", "limit")}


def link_entry(walker: Walker, element: Element, scope: Scope) -> Entry:
    """Return the entry of a link."""
    return reads(walker, element, scope, "link")


def reads(walker: Walker, element: Element, scope: Scope, level: str) -> Entry:
    """Return what an element of a level holds, or a macro that is called in such an element."""
    entry = Entry()
    Inside(walker, (), level, partial(_read_one, walker, level, entry)).each(element, scope)
    return entry


def one_of_level(walker: Walker, block: Element, scope: Scope, level: str) -> Entry:
    """Return what one element says that is to stand in one of a level."""
    entry = Entry()
    walker.take(block, scope, (), Inside(walker, (), level, partial(_read_one, walker, level, entry)))
    return entry


def _read_one(walker: Walker, level: str, entry: Entry, found: Found) -> None:
    child, scope, when, comments = found
    if isinstance(child, Call):
        for item in child.macro.entry.each() if child.macro.entry else ():
            if isinstance(item.value, list):
                for index in range(len(item.value)):
                    entry.add(item.key, Given(child, item.key, index), when)
            else:
                entry.put(item.key, Given(child, item.key), when)
        return
    if isinstance(child, Handed):
        macro, name = _macro_of(child.scope), child.parameter.name
        known = macro.block_levels.setdefault(name, level)
        if known != level and not {known, level} <= ORIGIN_LEVELS:
            raise Unsupported(f'the block "{name}" is inserted in several kinds of elements')
        macro.block_levels[name] = known if known == level else "origin"
        entry.put("&", child, when)
        return
    if child.tag in _LEAVES and child.children:
        raise Unsupported(f"<{child.children[0].tag}> in <{child.tag}>", child.children[0].span)
    read = {"link": _in_link, "inertial": _in_inertial, "solid": _in_solid, "geometry": _in_geometry}
    read |= {"joint": _in_joint, "material": _in_material, "origin": _origin_alone}
    if not read[level](walker, child, scope, when, entry, comments):
        if level not in ("link", "joint", "solid"):
            raise Unsupported(f"<{child.tag}> has no word here", child.span)
        entry.add("urdf_elements", xml_of(walker, child, scope), when)


def _macro_of(scope: Scope) -> Macro:
    macro = owner(scope)
    if macro is None:
        raise Unsupported("a block is inserted outside of macros")
    return macro


def _in_link(
    walker: Walker, child: Element, scope: Scope, when: Whens, entry: Entry, comments: tuple[str, ...]
) -> bool:
    if child.tag == "inertial":
        entry.put("inertial", reads(walker, child, scope, "inertial"), when)
    elif child.tag in ("visual", "collision"):
        solid = reads(walker, child, scope, "solid")
        if child.get("name"):
            solid.items.insert(0, solid_name(walker, child, scope))
        if child.tag == "collision":
            solid.items = [item for item in solid.items if item.key not in ("material", "rgba", "texture")]
            for made in _materials_in(walker, child, scope):
                solid.add("urdf_elements", made)
        entry.add(child.tag, solid, when, comments)
    else:
        return False
    return True


def _materials_in(walker: Walker, element: Element, scope: Scope) -> list[Any]:
    """Return the materials that an element of a collision holds, where nothing but readers of XML looks for them."""
    found: list[Any] = []
    for child in element.children:
        macro = walker.program.macro(child.tag.removeprefix("xacro:"), child)
        if _makes_material(walker, child):
            walker.take(child, scope, (), Keeping(walker, (), found))
        elif child.tag in ("xacro:if", "xacro:unless"):
            group = Xml("", when=(walker.condition(child, scope),), content=_materials_in(walker, child, scope))
            found += [group] if group.content else []
        elif child.tag.startswith("xacro:") and macro is not None:
            inner = macro.element
            walker.write_out(macro, child, scope, partial(_take_materials, walker, inner, found))
    return found


def _take_materials(walker: Walker, element: Element, found: list[Any], scope: Scope) -> None:
    found += _materials_in(walker, element, scope)


def _makes_material(walker: Walker, element: Element) -> bool:
    """Say whether an element of a collision is a material, or the call of a macro that makes one and nothing else."""
    macro = walker.program.macros.get(element.tag.removeprefix("xacro:"))
    if macro is None or not element.tag.startswith("xacro:"):
        return element.tag == "material"
    return [one.tag for one in macro.element.children] == ["material"]


def solid_name(walker: Walker, child: Element, scope: Scope) -> Item:
    return Item("name", walker.value(child, "name", scope, XML))  # a part puts nothing before it


def _in_inertial(walker: Walker, child: Element, scope: Scope, when: Whens, entry: Entry, _: Comments) -> bool:
    if child.tag == "mass":
        entry.put("mass", walker.value(child, "value", scope, "mass"), when)
    elif child.tag == "origin":
        origin(walker, child, scope, when, entry)
    elif child.tag == "inertia":
        moments = Entry()
        for name in _MOMENTS:
            if name in child.attributes and not _is_zero_product(name, child):
                moments.put(name, walker.value(child, name, scope, "number"))
        entry.put("inertia", moments, when)
    else:
        return False
    return True


def _is_zero_product(name: str, element: Element) -> bool:
    return name in ("ixy", "ixz", "iyz") and _is_zero(element.get(name))


def _is_zero(text: str) -> bool:
    return is_plain(text) and all(_is_number(word) and float(word) == 0 for word in text.split()) and bool(text.strip())


def _is_number(word: str) -> bool:
    value = literal(word)
    return isinstance(value, (int, float)) and not isinstance(value, bool)


def origin(walker: Walker, element: Element, scope: Scope, when: Whens, entry: Entry) -> None:
    """Put xyz and rpy of an origin."""
    for name in element.attributes:
        if name not in ("xyz", "rpy"):
            raise Unsupported(f"the attribute {name} of <origin>", element.span)
    for name, sink in (("xyz", "length3"), ("rpy", "angle3")):
        if name in element.attributes and not (_is_zero(element.get(name)) and name not in entry.names()):
            entry.put(name, walker.value(element, name, scope, sink), when)


def _origin_alone(walker: Walker, child: Element, scope: Scope, when: Whens, entry: Entry, _: Comments) -> bool:
    """Read a block that stands in elements of several kinds, each of which takes an origin."""
    if child.tag != "origin":
        return False
    origin(walker, child, scope, when, entry)
    return True


def _in_solid(walker: Walker, child: Element, scope: Scope, when: Whens, entry: Entry, _: Comments) -> bool:
    if child.tag == "origin":
        origin(walker, child, scope, when, entry)
    elif child.tag == "geometry":
        inner = reads(walker, child, scope, "geometry")
        for item in inner.items:
            entry.put(item.key, item.value, (*when, *item.when))
    elif child.tag == "material":
        _material(walker, child, scope, when, entry)
    else:
        return False
    return True


def _material(walker: Walker, child: Element, scope: Scope, when: Whens, entry: Entry) -> None:
    if child.get("name"):
        entry.put("material", walker.value(child, "name", scope, XML), when)  # a part has none of its own
    for item in reads(walker, child, scope, "material").items:
        entry.put(item.key, item.value, (*when, *item.when))


def material_entry(walker: Walker, element: Element, scope: Scope) -> Entry:
    """Return the look of a material."""
    return reads(walker, element, scope, "material")


def _in_material(walker: Walker, child: Element, scope: Scope, when: Whens, entry: Entry, _: Comments) -> bool:
    if child.tag == "color":
        entry.put("rgba", walker.value(child, "rgba", scope, "number4"), when)
    elif child.tag == "texture":
        if child.get("filename"):
            entry.put("texture", walker.value(child, "filename", scope, FILE), when)
    else:
        return False
    return True


def _in_geometry(walker: Walker, child: Element, scope: Scope, when: Whens, entry: Entry, _: Comments) -> bool:
    made = Entry()
    if child.tag == "mesh":
        made.put("file", walker.value(child, "filename", scope, FILE))
        if "scale" in child.attributes and child.get("scale").split() != ["1", "1", "1"]:
            made.put("scale", walker.value(child, "scale", scope, "number3"))
    elif child.tag in _SHAPES:
        for name, sink in _SHAPES[child.tag]:
            made.put(name, walker.value(child, name, scope, sink))
    else:
        return child.tag == "material"  # no reader looks there; the import says so
    entry.put(child.tag, made, when)
    return True


def joint_entry(walker: Walker, element: Element, scope: Scope) -> Entry:
    """Return the entry of a joint."""
    kind = walker.value(element, "type", scope, NAME)
    made = reads(walker, element, scope, "joint")
    made.items.insert(0, _type(kind))
    word = kind.text if is_plain(kind.text) else ""
    made.items = [item for item in made.items if item.key not in _WITHOUT_EFFECT.get(word, ())]
    for item in made.items:
        if item.key in ("limit", "mimic", "dynamics", "safety_controller", "calibration"):
            units_of(item.value, word)
        if item.key == "limit" and word == "continuous" and isinstance(item.value, Entry):
            ends = [one for one in item.value.items if one.key in ("lower", "upper")]
            if all(is_plain(one.value.text) and literal(one.value.text) == 0 for one in ends):
                item.value.items = [one for one in item.value.items if one not in ends]
    return made


def _type(kind: Value) -> Item:
    return Item("type", kind)


def units_of(entry: object, kind: str) -> None:
    """Say of the numbers of a joint of a type whether they are angles or lengths."""
    sink = "angle" if kind in _ROTATING else "length" if kind == "prismatic" else "number"
    for item in entry.items if isinstance(entry, Entry) else ():
        if not isinstance(item.value, Value) or item.key == "joint":
            continue
        turning = "speed" if item.key == "velocity" and kind in _ROTATING else "number"
        item.value.sink = sink if item.key in _OF_DIMENSION else turning
        note(item.value)


_NUMBERS = {
    "limit": ("lower", "upper", "effort", "velocity"),
    "dynamics": ("damping", "friction"),
    "safety_controller": ("soft_lower_limit", "soft_upper_limit", "k_position", "k_velocity"),
    "calibration": ("rising", "falling", "reference_position"),
}


def _in_joint(walker: Walker, child: Element, scope: Scope, when: Whens, entry: Entry, _: Comments) -> bool:
    if child.tag in ("parent", "child"):
        entry.put(child.tag, walker.value(child, "link", scope, NAME), when)
    elif child.tag == "origin":
        origin(walker, child, scope, when, entry)
    elif child.tag == "axis":
        entry.put("axis", walker.value(child, "xyz", scope, "number3"), when)
    elif child.tag == "mimic":
        made = Entry()
        made.put("joint", walker.value(child, "joint", scope, NAME))
        for name in ("multiplier", "offset"):
            if name in child.attributes:
                made.put(name, walker.value(child, name, scope, FREE))
        entry.put("mimic", made, when)
    elif child.tag in _NUMBERS:
        made = Entry()
        for name in _NUMBERS[child.tag]:
            if name in child.attributes:
                made.put(name, walker.value(child, name, scope, FREE))
            elif child.tag == "limit" and name in ("lower", "upper"):
                made.put(name, Value("0", scope, FREE))
        entry.put(child.tag, made, when)
    else:
        return False
    return True


__all__ = ["Xml", "joint_entry", "link_entry", "material_entry", "origin", "reads"]
