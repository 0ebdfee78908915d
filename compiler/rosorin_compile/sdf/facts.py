"""The facts of an SDF of ours: frames, joints and links as written, in the terms of ``formats.facts``.

A link or a frame sits in what its pose is relative to; where that is a joint, in what the pose of the joint is relative
to. A shape belongs to the frame that its pose is relative to. Beside those terms there are of a joint "damping",
"friction", "spring_stiffness" and "spring_reference"; of a shape its "name" and its colour ("visual 1 red"), and the
"file" of a mesh; and the elements that no other artifact has, by their names or numbers, as the text that they come to.

The importer reads an SDF by the same ``grammar``, but not for this: a proof that the artifacts are right had better not
go through the code that reads those of others.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, NamedTuple

from rosorin_compile.formats.facts import FactSheet, numbers_of
from rosorin_compile.formats.format import Fact, Facts
from rosorin_compile.model import Transform
from rosorin_compile.model.geometry import rotation_of_rpy
from rosorin_compile.source.xml.elements import canonical

from .words import INERTIA, MOTION, PARTS_OF_LINK, SOLIDS

if TYPE_CHECKING:
    from xml.etree.ElementTree import Element

    from rosorin_compile.formats.expectation import Expectation
    from rosorin_compile.formats.facts import Block, Deviations
    from rosorin_compile.formats.format import Value

_WORLD, _MODEL = "world", "__model__"
_COLOUR = ("red", "green", "blue", "alpha")
_OF_MODEL = ("link", "frame", "joint", "pose")
_OF_JOINT = ("pose", "parent", "child", "axis")
_NOWHERE = (0.0,) * 6


class _Placed(NamedTuple):
    """What a pose is relative to, and the pose."""

    parent: str
    pose: Transform


class _Sheet(FactSheet):
    """Facts of an SDF, whose numbers are the texts of elements."""

    def numbers_written(self) -> Iterator[str]:
        """Yield the texts in which numbers stand."""
        return (element.text or "" for element in self.root.iter())

    def numbers(self, element: Element, tag: str, count: int) -> tuple[float, ...]:
        """Return the numbers of a child. Raises ValueError unless there are so many."""
        found = numbers_of(self.word(element, tag))
        if len(found) != count:
            raise ValueError(f"<{tag}> of <{element.tag}>: {count} numbers are needed")
        return found

    def one(self, element: Element, tag: str) -> float:
        """Return the number of a child. Raises ValueError if there is none."""
        return self.numbers(element, tag, 1)[0]

    def word(self, element: Element, tag: str) -> str:
        """Return the text of a child. Raises ValueError if there is none."""
        text = element.findtext(tag)
        if text is None:
            raise ValueError(f"<{element.tag}> has no <{tag}>")
        return text.strip()


def read(text: str) -> Facts:
    """Return what an SDF says about frames, joints and links. Raises ValueError if it is damaged."""
    return _read(_Sheet(text, "sdf")).facts


def against(text: str, known: Expectation) -> Deviations:
    """Return what an SDF says that is not known. Raises ValueError if it is damaged."""
    return _read(_Sheet(text, "sdf", known)).deviations()


def _read(sheet: _Sheet) -> _Sheet:
    model = sheet.root.find("model")
    if model is None:
        raise ValueError("there is no <model>")
    links, every = model.findall("link"), model.findall("joint")
    joints = {sheet.text(joint, "name"): _placed(joint, "") for joint in every}
    ends = {sheet.text(joint, "name"): sheet.word(joint, "parent") for joint in every}
    for element in (*links, *model.findall("frame")):
        _frame(sheet, element, joints, ends)
    for link in links:
        _link(sheet, link)
    for joint in every:
        _joint(sheet, joint)
    _elements(sheet, Fact("robot", sheet.text(model, "name"), ""), model, _OF_MODEL)
    return sheet


def _placed(element: Element, default: str) -> _Placed:
    """Return where an element sits. Raises ValueError for a pose that has not six numbers, or none."""
    pose = element.find("pose")
    if pose is None:
        return _Placed(default, Transform())
    values = numbers_of(pose.text or "")
    if len(values) not in (0, 6):
        raise ValueError(f"<pose> of <{element.tag}>: 6 numbers are needed")
    x, y, z, *rpy = values or _NOWHERE
    return _Placed(pose.get("relative_to", default), Transform(rotation_of_rpy((rpy[0], rpy[1], rpy[2])), (x, y, z)))


def _frame(sheet: _Sheet, element: Element, joints: Mapping[str, _Placed], ends: Mapping[str, str]) -> None:
    """Take down where a link or a frame sits; the root sits nowhere."""
    name = sheet.text(element, "name")
    parent, pose = _placed(element, element.get("attached_to", ""))
    if parent in joints:
        above, origin = joints[parent]
        parent, pose = _WORLD if ends[parent] == _WORLD else above, origin.then(pose)
    if parent not in ("", _MODEL):
        sheet.add_frame(name, parent, pose)


def _elements(sheet: _Sheet, fact: Fact, element: Element, known: tuple[str, ...]) -> None:
    """Take down the elements that no other artifact has, by their names where those tell them apart."""
    kept = [one for one in element if one.tag not in known]
    if sheet.known is not None and kept:
        sheet.add(fact, "")  # nothing of it is known but the name
        return
    names = Counter((one.tag, one.get("name", "")) for one in kept)
    for number, inner in enumerate(kept, 1):
        name = inner.get("name", "")
        called = f"{inner.tag} {name}" if name and names[inner.tag, name] == 1 else f"{number} {inner.tag}"
        sheet.add(fact._replace(quantity=f"element {called}"), canonical(inner))


def _link(sheet: _Sheet, link: Element) -> None:
    name = sheet.text(link, "name")
    inertial = link.find("inertial")
    if inertial is not None:
        inertia = inertial.find("inertia")
        if inertia is None:
            raise ValueError(f"the inertial of link {name} has no <inertia>")
        xx, yy, zz, xy, xz, yz = (sheet.one(inertia, entry) for entry in INERTIA)
        sheet.add_inertial(name, sheet.one(inertial, "mass"), _placed(inertial, "").pose, (xx, yy, zz, xy, xz, yz))
    others = []
    for purpose in ("visual", "collision"):
        counts: dict[str, int] = {}
        for shape in link.findall(purpose):
            if not any(solid.tag in SOLIDS for geometry in shape.findall("geometry") for solid in geometry):
                others.append(shape)
                continue
            owner, pose = _placed(shape, name)
            counts[owner] = counts.get(owner, 0) + 1
            _shape(sheet, owner, f"{purpose} {counts[owner]}", shape, pose)
        for owner, count in counts.items():
            sheet.add(Fact("link", owner, f"{purpose} shapes"), float(count), tolerance=0.0)
    for number, shape in enumerate(others, 1):
        said = canonical(shape) if sheet.known is None else ""
        sheet.add(Fact("link", name, f"element {number} of its own {shape.tag}"), said)
    _elements(sheet, Fact("link", name, ""), link, PARTS_OF_LINK)


def _shape(sheet: _Sheet, link: str, label: str, shape: Element, pose: Transform) -> None:
    geometry = shape.find("geometry")
    if geometry is None or len(geometry) != 1:
        raise ValueError(f"{label} of link {link} has not one geometry")
    solid = geometry[0]
    sheet.add_shape(link, label, solid.tag, _sizes(sheet, solid), pose)
    if solid.tag == "mesh":
        sheet.add_of_shape(link, label, "file", sheet.word(solid, "uri"))
    sheet.add_of_shape(link, label, "name", sheet.text(shape, "name"))
    material = shape.find("material")
    if material is None:
        return
    if material.find("diffuse") is not None:
        for colour, value in zip(_COLOUR, sheet.numbers(material, "diffuse", 4), strict=True):
            sheet.add_of_shape(link, label, colour, value)
    texture = material.findtext("pbr/metal/albedo_map") if material.find("pbr") is not None else None
    if texture:
        sheet.add_of_shape(link, label, "texture", texture)


def _sizes(sheet: _Sheet, solid: Element) -> tuple[float, ...]:
    if solid.tag not in SOLIDS:
        raise ValueError(f"a description has no <{solid.tag}>")
    if solid.tag == "mesh" and solid.find("scale") is None:
        return (1.0, 1.0, 1.0)
    found = [number for tag, many in SOLIDS[solid.tag].items() for number in sheet.numbers(solid, tag, many)]
    return tuple(2 * radius for radius in found) if solid.tag == "ellipsoid" else tuple(found)


def _joint(sheet: _Sheet, joint: Element) -> None:
    name, kind, child = sheet.joint(sheet.text(joint, "name")), sheet.text(joint, "type"), sheet.word(joint, "child")
    axis = joint.find("axis")
    key = None if axis is None else tuple((one.tag, one.text, *one.items()) for one in axis.iter())
    sheet.add_joint(name, child, sheet.once((kind, key), lambda: _motion(sheet, axis, kind)))
    _elements(sheet, Fact("joint", name, ""), joint, _OF_JOINT)


def _motion(sheet: _Sheet, axis: Element | None, kind: str) -> Block:
    """Return what is said of a joint but where it sits."""
    said: dict[str, Value] = {"type": sheet.value(kind)}
    if axis is None:
        return said
    unit = "m" if kind == "prismatic" else "rad"
    force = "N" if unit == "m" else "N*m"
    x, y, z = sheet.numbers(axis, "xyz", 3)
    said |= sheet.axis((x, y, z))
    for tag, units in MOTION.items():
        element = axis.find(tag)
        for quantity, of in units.items() if element is not None else ():
            if element is not None and element.find(quantity) is not None:
                said[quantity] = sheet.value(sheet.one(element, quantity), of.format(q=unit, f=force))
    mimic = axis.find("mimic")
    if mimic is not None:
        factor = sheet.one(mimic, "multiplier")
        said["mimic joint"] = sheet.value(sheet.joint(sheet.text(mimic, "joint")))
        said["mimic multiplier"] = sheet.value(factor)
        at = sheet.one(mimic, "reference") if mimic.find("reference") is not None else 0.0
        said["mimic offset"] = sheet.value(sheet.one(mimic, "offset") - factor * at, unit)
    return said
