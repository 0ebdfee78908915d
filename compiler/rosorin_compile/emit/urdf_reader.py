"""Reads a URDF back as facts, in the terms in which the other artifacts say the same (see ``xml_facts``).

Defaults are those of http://wiki.ros.org/urdf/XML and ``ros/urdfdom@jazzy:urdf_parser``. Only the URDF has: joint
"child"; link "visual 1 material", "visual 1 red|green|blue|alpha" and "collision 1 file" of a mesh.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from ..model import Pose, Transform
from . import Fact, Facts
from .xml_facts import AXES, FactSheet, number_of

if TYPE_CHECKING:
    from xml.etree.ElementTree import Element

_MOVING = {"revolute": "rad", "continuous": "rad", "prismatic": "m"}
_INERTIA = ("ixx", "iyy", "izz", "ixy", "ixz", "iyz")
_COLOUR = ("red", "green", "blue", "alpha")


def read(text: str) -> Facts:
    """Return what a URDF says about frames, joints and links. Raises ValueError if it is damaged."""
    sheet = FactSheet(text, "robot")
    for link in sheet.root.iterfind("link"):
        _link(sheet, link)
    for joint in sheet.root.iterfind("joint"):
        _joint(sheet, joint)
    return sheet.facts


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
    return Pose(sheet.vector3(origin, "xyz"), sheet.vector3(origin, "rpy")).transform()


def _joint(sheet: FactSheet, joint: Element) -> None:
    name, kind = sheet.text(joint, "name"), sheet.text(joint, "type")
    child = sheet.text(_child(joint, "child"), "link")
    sheet.add_frame(child, sheet.text(_child(joint, "parent"), "link"), _transform(sheet, joint))
    sheet.add(Fact("joint", name, "type"), kind)
    sheet.add(Fact("joint", name, "child"), child)
    if kind in _MOVING:
        _motion(sheet, joint, name, _MOVING[kind])


def _motion(sheet: FactSheet, joint: Element, name: str, unit: str) -> None:
    force = "N" if unit == "m" else "N*m"
    axis = joint.find("axis")
    xyz = (1.0, 0.0, 0.0) if axis is None else sheet.vector3(axis, "xyz")
    for letter, value in zip(AXES, xyz, strict=True):
        sheet.add(Fact("joint", name, f"axis {letter}"), value)
    limits = {"lower": unit, "upper": unit, "effort": force, "velocity": f"{unit}/s"}
    dynamics = {"damping": f"{force}*s/{unit}", "friction": force}
    for tag, quantities in (("limit", limits), ("dynamics", dynamics)):
        element = joint.find(tag)
        for quantity, dimension in quantities.items():
            if element is not None and quantity in element.attrib:
                sheet.add(Fact("joint", name, quantity), sheet.number(element, quantity), dimension)
    mimic = joint.find("mimic")
    if mimic is not None:
        sheet.add(Fact("joint", name, "mimic joint"), sheet.text(mimic, "joint"))
        sheet.add(Fact("joint", name, "mimic multiplier"), sheet.number(mimic, "multiplier", 1.0))
        sheet.add(Fact("joint", name, "mimic offset"), sheet.number(mimic, "offset"), unit)


def _link(sheet: FactSheet, link: Element) -> None:
    name = sheet.text(link, "name")
    inertial = link.find("inertial")
    if inertial is not None:
        mass, inertia = number_of(sheet.text(_child(inertial, "mass"), "value")), _child(inertial, "inertia")
        xx, yy, zz, xy, xz, yz = (number_of(sheet.text(inertia, entry)) for entry in _INERTIA)
        sheet.add_inertial(name, mass, _transform(sheet, inertial), (xx, yy, zz, xy, xz, yz))
    for purpose in ("collision", "visual"):
        shapes = link.findall(purpose)
        if shapes:
            sheet.add(Fact("link", name, f"{purpose} shapes"), float(len(shapes)), tolerance=0.0)
        for number, shape in enumerate(shapes, 1):
            _shape(sheet, name, f"{purpose} {number}", shape)


def _shape(sheet: FactSheet, link: str, label: str, shape: Element) -> None:
    geometry = _child(shape, "geometry")
    if len(geometry) != 1:
        raise ValueError(f"{label} of link {link} has {len(geometry)} geometries")
    solid = geometry[0]
    sheet.add_shape(link, label, solid.tag, _sizes(sheet, solid), _transform(sheet, shape))
    if solid.tag == "mesh":
        sheet.add(Fact("link", link, f"{label} file"), sheet.text(solid, "filename"))
    material = shape.find("material")
    if material is None:
        return
    sheet.add(Fact("link", link, f"{label} material"), sheet.text(material, "name"))
    colour = material.find("color")
    if colour is not None:
        for name, value in zip(_COLOUR, sheet.vector(colour, "rgba", 4, ()), strict=True):
            sheet.add(Fact("link", link, f"{label} {name}"), value)


def _sizes(sheet: FactSheet, solid: Element) -> tuple[float, ...]:
    if solid.tag == "box":
        return sheet.vector3(solid, "size")
    if solid.tag == "mesh":
        return sheet.vector3(solid, "scale", (1.0, 1.0, 1.0))
    if solid.tag == "sphere":
        return (sheet.number(solid, "radius"),)
    if solid.tag == "cylinder":
        return (sheet.number(solid, "radius"), sheet.number(solid, "length"))
    raise ValueError(f"URDF 1.0 has no <{solid.tag}>")
