"""Materials of URDF: those of the robot, which visuals name, and those that stand in a visual."""

from __future__ import annotations

import re

from rosorin_compile.source.diagnostics import NOTE, Diagnostic, Related, Span
from rosorin_compile.source.tree import Map, Seq
from rosorin_compile.source.wording import and_more
from rosorin_compile.source.xml.markup import Element

from .reading import Reading, check_element, named
from .values import PLAIN, number_of, put_numbers

_NOT_IN_NAMES = re.compile(r"[<>&\"'\x00-\x1f]")


def put_material(entry: Map, element: Element, reading: Reading) -> None:
    """Set material, rgba and texture of a visual from its <material>."""
    name = _name(element, reading)
    if name:
        attribute = element.attributes["name"]
        entry.put("material", name, attribute.name_span, attribute.span)
    _surface(entry, element, reading)


def _name(element: Element, reading: Reading) -> str | None:
    """Return the name of a material, as a description can have it; None after an error."""
    name = reading.attribute(element, "name")
    clean = None if name is None else " ".join(_NOT_IN_NAMES.sub("_", name).split())
    if clean != name:
        message = f'the material "{name}" is called "{clean}": a name has no markup and no spaces around it'
        reading.diagnostics.append(Diagnostic("import-changed", NOTE, message, element.attributes["name"].span))
    return clean


def read_materials(robot: Element, reading: Reading) -> Map | None:
    """Return the materials that stand directly in <robot>; None if there are none."""
    made: Map | None = None
    first: dict[str, Element] = {}
    for element in robot.children:
        if element.tag != "material":
            continue
        name = _name(element, reading)
        if not name:
            if name is not None:
                reading.cannot_carry("a material of the robot without a name", element.span)
            continue
        made = Map(element.span) if made is None else made
        entry = Map(element.span)
        _surface(entry, element, reading)
        if name in made:
            message = f'the material "{name}" is defined twice'
            if reading.options.lenient:
                reading.cannot_carry(f'a second material "{name}"', element.span, "the first is taken")
            else:
                related = [Related("the first", first[name].span)]
                reading.error("duplicate-name", message, element.span, "remove one; --lenient takes the first", related)
            continue
        first[name] = element
        reading.paths[id(element)] = ("materials", name)
        made.put(name, entry, element.attributes["name"].span, element.span)
    return made


def _surface(entry: Map, element: Element, reading: Reading) -> None:
    """Set rgba and texture of an entry."""
    color = reading.single(element, "color")
    if color is not None:
        check_element(color, reading)
        before = len(reading.diagnostics)
        if reading.attribute(color, "rgba") is not None:
            _rgba(entry, color, reading)
        reading.spoilt(color, "the colour", before)
    texture = reading.single(element, "texture")
    if texture is not None:
        check_element(texture, reading)
        attribute = texture.attributes.get("filename")
        file = None if attribute is None else reading.attribute(texture, "filename")
        if attribute is not None and file:
            entry.put("texture", file, attribute.name_span, attribute.span)
        elif not file:  # exporters write an empty <texture/>
            reading.ignored("a texture without a file name has no effect", texture.span)
    check_element(element, reading)


def _rgba(entry: Map, color: Element, reading: Reading) -> None:
    attribute = color.attributes["rgba"]
    words = attribute.words()
    if len(words) != 3:
        put_numbers(entry, color, "rgba", reading)
        return
    values = [number_of(word, PLAIN, color, "rgba", reading) for word in words]
    message = f"rgba of {named(color)} has 3 numbers; it takes 4"
    help = "add the opacity: 1 hides what is behind"
    if None in values or not reading.lenient("wrong-count", message, attribute.span, help, "takes an opacity of 1"):
        return
    made = Seq(attribute.span)
    for value, word in zip([*values, 1], [*words, words[-1]], strict=True):
        made.put(value, word.span)
    entry.put("rgba", made, attribute.name_span, attribute.span)


def settle(tree: Map, reading: Reading) -> None:
    """Take the name from each material that has another look than the one of that name before it.

    A name has one meaning in a URDF: urdfdom takes the first for all, other readers what stands in the visual. What
    stands there is kept.
    """
    looks: dict[str, tuple[object, object]] = {}
    others: list[tuple[str, Span]] = []
    for name, entry in (tree.get("materials") or {}).items():
        if "rgba" in entry or "texture" in entry:
            looks[name] = _look(entry)
    for name, link in (tree.get("links") or {}).items():
        for visual in link.get("visual", ()):
            if "material" not in visual or not ("rgba" in visual or "texture" in visual):
                continue
            if looks.setdefault(visual["material"], _look(visual)) == _look(visual):
                continue
            others.append((f'the material "{visual["material"]}" of link "{name}"', visual.value_spans["material"]))
            del visual["material"]
    if others:
        (what, span), *more = others
        message = f"{what} looks otherwise than the first of that name, which ROS takes for all: it keeps its look and"
        message += " loses the name"
        if more:
            message += f",{and_more(len(more), 'of this kind')}"
        reading.diagnostics.append(Diagnostic("import-changed", NOTE, message, span))


def _look(entry: Map) -> tuple[object, object]:
    rgba = entry.get("rgba")
    return (None if rgba is None else tuple(map(float, rgba)), entry.get("texture"))
