"""Reads a URDF back as facts, in the terms in which the other artifacts say the same (see ``formats.facts``).

Which numbers an element has, in which unit, and its defaults: ``grammar``. Only the URDF has: joint "child",
"calibration rising", "safety k_velocity"; link "visual 1 material|name|texture" and "collision 1 file" of a mesh; the
materials of the robot, as Fact("material", name, "red"); and elements that no other artifact has, by their number and
tag, as the text that they come to: Fact("link", name, "element 1 gazebo"), of the robot itself as Fact("robot", name,
"element 1 transmission").

The importer reads a URDF by the same grammar, but not for this: it takes four to five times as long (500 links: 0.25 s
for 0.05 s; XML with the place of each element and attribute alone takes 0.09 s, without 0.02 s), it refuses what a hand
may have done to a committed file and a comparison still reads, and it hands on a robot in the form of the language, in
which names of materials and the numbers of shapes are others. A proof that the artifacts are right had better not go
through the code that made them.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

from rosorin_compile.model import Transform
from rosorin_compile.model.geometry import rotation_of_rpy

from ..facts import SIZES, FactSheet, Six, number_of
from ..format import Fact, Facts
from .grammar import CHILDREN, MOVING, NUMBERS, SHAPES

if TYPE_CHECKING:
    from xml.etree.ElementTree import Element

    from ..expectation import Expectation
    from ..facts import Block, Deviations
    from ..format import Value

_ENDS = ("parent", "child", "origin")
# What is said of a joint, with what its quantities begin with.
_OF_MOTION = {"limit": "", "dynamics": "", "calibration": "calibration ", "safety_controller": "safety "}
_COLOUR = ("red", "green", "blue", "alpha")


def read(text: str) -> Facts:
    """Return what a URDF says about frames, joints and links. Raises ValueError if it is damaged."""
    return _read(FactSheet(text, "robot")).facts


def against(text: str, known: Expectation) -> Deviations:
    """Return what a URDF says that is not known. Raises ValueError if it is damaged."""
    return _read(FactSheet(text, "robot", known)).deviations()


def _read(sheet: FactSheet) -> FactSheet:
    materials = {material.get("name", ""): material for material in sheet.root.findall("material")}
    for name, material in materials.items():
        for quantity, value in _look(sheet, material).items():
            sheet.add(Fact("material", name, quantity), value)
    links: set[str] = set()
    for link in sheet.root.findall("link"):
        name = sheet.text(link, "name")
        links.add(name)
        _link(sheet, name, link, materials)
        link.clear()  # of thousands of links it would be half of the memory
    for joint in sheet.root.findall("joint"):
        for end in ("parent", "child"):
            if sheet.text(_child(joint, end), "link") not in links:
                raise ValueError(f"the {end} of joint {sheet.text(joint, 'name')} is no link")
        _joint(sheet, joint)
        joint.clear()
    _elements(sheet, ("robot", sheet.root.get("name", ""), ""), sheet.root, CHILDREN["robot"])
    return sheet


def _elements(
    sheet: FactSheet,
    what: tuple[str, str, str],
    element: Element,
    known: Sequence[str],
    foreign: Sequence[Element] = (),
) -> None:
    """Take down the elements that no other artifact has; space between elements means nothing.

    ``what`` is the kind and the name of what they are of, and what their quantities begin with.
    """
    kept = [inner for inner in element if inner.tag not in known or (foreign and inner in foreign)]
    if sheet.known is not None and kept:
        sheet.add(Fact(*what), "")  # nothing of it is known but the name
        return
    for number, inner in enumerate(kept, 1):
        kind, name, begin = what
        sheet.add(Fact(kind, name, f"{begin} element {number} {inner.tag}".strip()), _plain(inner))


def _plain(element: Element) -> str:
    """Return an element as text in one form: attributes sorted, space between elements left out."""
    said = "".join(f' {name}="{value}"' for name, value in sorted(element.items()))
    inner = [_words(element.text), *(_plain(child) + _words(child.tail) for child in element)]
    return f"<{element.tag}{said}>{''.join(inner)}</{element.tag}>"


def _words(text: str | None) -> str:
    return (text or "").strip()


def _child(element: Element, tag: str) -> Element:
    found = element.find(tag)
    if found is None:
        raise ValueError(f"<{element.tag}> has no <{tag}>")
    return found


def _transform(sheet: FactSheet, element: Element) -> Transform:
    """Return what the <origin> of an element says; none is the identity."""
    origin = element.find("origin")
    if origin is None:
        return Transform()
    return sheet.once(("origin", origin.get("xyz"), origin.get("rpy")), lambda: _placed(sheet, origin))


def _placed(sheet: FactSheet, origin: Element) -> Transform:
    return Transform(rotation_of_rpy(sheet.vector3(origin, "rpy")), sheet.vector3(origin, "xyz"))


def _joint(sheet: FactSheet, joint: Element) -> None:
    name, kind = sheet.text(joint, "name"), sheet.text(joint, "type")
    child, parent = sheet.text(_child(joint, "child"), "link"), sheet.text(_child(joint, "parent"), "link")
    _elements(sheet, ("joint", name, ""), joint, CHILDREN["joint"])
    key = ("joint", kind, *((part.tag, *part.items()) for part in joint if part.tag not in _ENDS))
    sheet.add_frame(child, parent, _transform(sheet, joint))
    sheet.add_joint(name, child, sheet.once(key, lambda: _motion(sheet, joint, kind)))


def _motion(sheet: FactSheet, joint: Element, kind: str) -> Block:
    """Return what is said of a joint but where it sits."""
    said: dict[str, Value] = {"type": sheet.value(kind)}
    if kind not in MOVING:
        return said
    unit = MOVING[kind]
    axis = joint.find("axis")
    xyz = (1.0, 0.0, 0.0) if axis is None else sheet.vector3(axis, "xyz")
    said |= sheet.axis(xyz)
    for tag, called in _OF_MOTION.items():
        element = joint.find(tag)
        for quantity, numbers in NUMBERS[tag].items():
            if element is not None and quantity in element.attrib:
                said[called + quantity] = sheet.value(sheet.number(element, quantity), numbers.unit_at(unit))
    mimic = joint.find("mimic")
    if mimic is not None:
        said["mimic joint"] = sheet.value(sheet.text(mimic, "joint"))
        multiplier, offset = _numbers(sheet, mimic)
        said["mimic multiplier"] = sheet.value(multiplier)
        said["mimic offset"] = sheet.value(offset, unit)
    return said


def _numbers(sheet: FactSheet, element: Element) -> tuple[float, ...]:
    """Return the numbers of an element one behind the other; those that it does not say are its defaults."""
    found: tuple[float, ...] = ()
    for name, (many, _, default) in NUMBERS[element.tag].items():
        found += sheet.vector(element, name, many, (default,) * many)
    return found


def _link(sheet: FactSheet, name: str, link: Element, materials: Mapping[str, Element]) -> None:
    inertia = _inertia(sheet, link)
    if inertia is not None:
        sheet.add_inertial(name, *inertia)
    shapes_of = {"collision": link.findall("collision"), "visual": link.findall("visual")}
    foreign = [shape for shapes in shapes_of.values() for shape in shapes if _is_foreign(shape)]
    for purpose, every in shapes_of.items():
        shapes = [shape for shape in every if shape not in foreign]
        if shapes and sheet.known is None:
            sheet.add(Fact("link", name, f"{purpose} shapes"), float(len(shapes)), tolerance=0.0)
        for number, shape in enumerate(shapes, 1):
            _shape(sheet, name, f"{purpose} {number}", shape, materials)
    _elements(sheet, ("link", name, ""), link, CHILDREN["link"], foreign)


def _inertia(sheet: FactSheet, link: Element) -> tuple[float, Transform, Six] | None:
    """Return what the <inertial> of a link says; None where it has none."""
    inertial = link.find("inertial")
    if inertial is None:
        return None
    key = ("inertial", *((part.tag, *part.items()) for part in inertial))
    return sheet.once(key, lambda: _inertial(sheet, inertial))


def _inertial(sheet: FactSheet, inertial: Element) -> tuple[float, Transform, Six]:
    """Return a mass, its frame, and the inertia along that."""
    mass, inertia = number_of(sheet.text(_child(inertial, "mass"), "value")), _child(inertial, "inertia")
    xx, yy, zz, xy, xz, yz = (number_of(sheet.text(inertia, entry)) for entry in NUMBERS["inertia"])
    return mass, _transform(sheet, inertial), (xx, yy, zz, xy, xz, yz)


def _is_foreign(shape: Element) -> bool:
    """Say whether a shape is of a geometry that the language has no word for: a description keeps it as it is."""
    geometry = shape.find("geometry")
    return geometry is not None and len(geometry) == 1 and geometry[0].tag not in SIZES


def _shape(sheet: FactSheet, link: str, label: str, shape: Element, materials: Mapping[str, Element]) -> None:
    geometry = _child(shape, "geometry")
    if len(geometry) != 1:
        raise ValueError(f"{label} of link {link} has {len(geometry)} geometries")
    solid = geometry[0]
    if solid.tag not in SHAPES:
        raise ValueError(f"URDF has no <{solid.tag}>")
    sizes = sheet.once(("solid", solid.tag, *solid.items()), lambda: _numbers(sheet, solid))
    sheet.add_shape(link, label, solid.tag, sizes, _transform(sheet, shape))
    if solid.tag == "mesh":
        sheet.add_of_shape(link, label, "file", sheet.text(solid, "filename"))
    if "name" in shape.attrib:
        sheet.add_of_shape(link, label, "name", sheet.text(shape, "name"))
    _elements(sheet, ("link", link, label), shape, CHILDREN["visual"])
    material = shape.find("material")
    if material is None:
        return
    called = sheet.text(material, "name")
    sheet.add_of_shape(link, label, "material", called)
    look = _look(sheet, material) or _look(sheet, materials.get(called, material))
    for quantity, value in look.items():
        sheet.add_of_shape(link, label, quantity, value)


def _look(sheet: FactSheet, material: Element) -> dict[str, float | str]:
    """Return what a material looks like: its colour, number by number, and its texture."""
    found: dict[str, float | str] = {}
    colour, texture = material.find("color"), material.find("texture")
    if colour is not None and sheet.text(colour, "rgba"):
        found |= zip(_COLOUR, _numbers(sheet, colour), strict=True)
    if texture is not None:
        found["texture"] = sheet.text(texture, "filename")
    return found
