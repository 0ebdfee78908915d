"""The facts of an SDF of ours: frames, joints and links as written, in the terms of ``formats.facts``.

A link or a frame sits in what its pose is relative to; where that is a joint, in what the pose of the joint is relative
to. A shape belongs to the frame that its pose is relative to. Beside those terms there are of a joint "damping",
"friction", "spring_stiffness" and "spring_reference"; of a shape its "name" and its colour ("visual 1 red"), and the
"file" of a mesh; and the elements that no other artifact has, by their names or numbers, as the text that they come to.

The importer reads an SDF, too, but not for this: a proof that the artifacts are right had better not go through the
code that reads those of others.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from typing import TYPE_CHECKING, NamedTuple

from ...model import Pose, Transform
from ...numbers import six
from ...xml.elements import canonical
from ..facts import AXES, ROTATION_ROUNDING, FactSheet, number_of
from ..format import Fact, Facts

if TYPE_CHECKING:
    from xml.etree.ElementTree import Element

_WORLD, _MODEL = "world", "__model__"
_INERTIA = ("ixx", "iyy", "izz", "ixy", "ixz", "iyz")
_COLOUR = ("red", "green", "blue", "alpha")
_OF_MODEL = ("link", "frame", "joint", "pose")
_OF_LINK = ("pose", "inertial", "visual", "collision")
_OF_JOINT = ("pose", "parent", "child", "axis")
_SOLIDS = ("box", "cylinder", "capsule", "sphere", "ellipsoid", "mesh")
_LENGTHS = {"cylinder": ("radius", "length"), "capsule": ("radius", "length"), "sphere": ("radius",)}


class _Placed(NamedTuple):
    """What a pose is relative to, and the pose."""

    parent: str
    pose: Transform


class _Sheet(FactSheet):
    """Facts of an SDF, whose numbers are the texts of elements."""

    def __init__(self, text: str) -> None:
        super().__init__(text, "sdf")
        self.exact = any(_is_long(word) for element in self.root.iter() for word in (element.text or "").split())
        self._turning = ROTATION_ROUNDING + 4 * self.tolerance(1.0)

    def numbers(self, element: Element, tag: str, count: int) -> tuple[float, ...]:
        """Return the numbers of a child. Raises ValueError unless there are so many."""
        found = tuple(map(number_of, self.word(element, tag).split()))
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


def _is_long(word: str) -> bool:
    """Say whether a word is a number that was printed with more than six digits."""
    try:
        return len(word) > 6 and float(six(number_of(word))) != number_of(word)
    except ValueError:
        return False


def read(text: str) -> Facts:
    """Return what an SDF says about frames, joints and links. Raises ValueError if it is damaged."""
    sheet = _Sheet(text)
    model = sheet.root.find("model")
    if model is None:
        raise ValueError("there is no <model>")
    joints = {sheet.text(joint, "name"): _placed(joint, "") for joint in model.iterfind("joint")}
    ends = {sheet.text(joint, "name"): sheet.word(joint, "parent") for joint in model.iterfind("joint")}
    for element in (*model.iterfind("link"), *model.iterfind("frame")):
        _frame(sheet, element, joints, ends)
    for link in model.iterfind("link"):
        _link(sheet, link)
    for joint in model.iterfind("joint"):
        _joint(sheet, joint)
    _elements(sheet, Fact("robot", sheet.text(model, "name"), ""), model, _OF_MODEL)
    return sheet.facts


def _placed(element: Element, default: str) -> _Placed:
    """Return where an element sits. Raises ValueError for a pose that has not six numbers, or none."""
    pose = element.find("pose")
    if pose is None:
        return _Placed(default, Transform())
    values = tuple(map(number_of, (pose.text or "").split()))
    if len(values) not in (0, 6):
        raise ValueError(f"<pose> of <{element.tag}>: 6 numbers are needed")
    x, y, z, *rpy = values or (0.0,) * 6
    return _Placed(pose.get("relative_to", default), Pose((x, y, z), (rpy[0], rpy[1], rpy[2])).transform())


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
        xx, yy, zz, xy, xz, yz = (sheet.one(inertia, entry) for entry in _INERTIA)
        sheet.add_inertial(name, sheet.one(inertial, "mass"), _placed(inertial, "").pose, (xx, yy, zz, xy, xz, yz))
    others = []
    for purpose in ("visual", "collision"):
        counts: dict[str, int] = {}
        for shape in link.iterfind(purpose):
            if not any(solid.tag in _SOLIDS for solid in shape.iterfind("geometry/*")):
                others.append(shape)
                continue
            owner, pose = _placed(shape, name)
            counts[owner] = counts.get(owner, 0) + 1
            _shape(sheet, owner, f"{purpose} {counts[owner]}", shape, pose)
        for owner, count in counts.items():
            sheet.add(Fact("link", owner, f"{purpose} shapes"), float(count), tolerance=0.0)
    for number, shape in enumerate(others, 1):
        sheet.add(Fact("link", name, f"element {number} of its own {shape.tag}"), canonical(shape))
    _elements(sheet, Fact("link", name, ""), link, _OF_LINK)


def _shape(sheet: _Sheet, link: str, label: str, shape: Element, pose: Transform) -> None:
    geometry = shape.find("geometry")
    if geometry is None or len(geometry) != 1:
        raise ValueError(f"{label} of link {link} has not one geometry")
    solid = geometry[0]
    sheet.add_shape(link, label, solid.tag, _sizes(sheet, solid), pose)
    if solid.tag == "mesh":
        sheet.add(Fact("link", link, f"{label} file"), sheet.word(solid, "uri"))
    sheet.add(Fact("link", link, f"{label} name"), sheet.text(shape, "name"))
    material = shape.find("material")
    if material is None:
        return
    if material.find("diffuse") is not None:
        for colour, value in zip(_COLOUR, sheet.numbers(material, "diffuse", 4), strict=True):
            sheet.add(Fact("link", link, f"{label} {colour}"), value)
    texture = material.findtext("pbr/metal/albedo_map")
    if texture:
        sheet.add(Fact("link", link, f"{label} texture"), texture)


def _sizes(sheet: _Sheet, solid: Element) -> tuple[float, ...]:
    if solid.tag == "box":
        return sheet.numbers(solid, "size", 3)
    if solid.tag == "ellipsoid":
        return tuple(2 * radius for radius in sheet.numbers(solid, "radii", 3))
    if solid.tag == "mesh":
        return sheet.numbers(solid, "scale", 3) if solid.find("scale") is not None else (1.0, 1.0, 1.0)
    if solid.tag in _LENGTHS:
        return tuple(sheet.one(solid, size) for size in _LENGTHS[solid.tag])
    raise ValueError(f"a description has no <{solid.tag}>")


def _joint(sheet: _Sheet, joint: Element) -> None:
    name, kind, child = sheet.text(joint, "name"), sheet.text(joint, "type"), sheet.word(joint, "child")
    sheet.add(Fact("joint", name, "type"), kind)
    sheet.add(Fact("joint", name, "child"), child)
    axis = joint.find("axis")
    if axis is not None:
        _axis(sheet, axis, name, "m" if kind == "prismatic" else "rad")
    _elements(sheet, Fact("joint", name, ""), joint, _OF_JOINT)


def _axis(sheet: _Sheet, axis: Element, name: str, unit: str) -> None:
    force = "N" if unit == "m" else "N*m"
    for letter, value in zip(AXES, sheet.numbers(axis, "xyz", 3), strict=True):
        sheet.add(Fact("joint", name, f"axis {letter}"), value)
    limits = {"lower": unit, "upper": unit, "effort": force, "velocity": f"{unit}/s"}
    dynamics = {"damping": f"{force}*s/{unit}", "friction": force}
    dynamics |= {"spring_stiffness": f"{force}/{unit}", "spring_reference": unit}
    for tag, units in (("limit", limits), ("dynamics", dynamics)):
        element = axis.find(tag)
        for quantity, of in units.items() if element is not None else ():
            if element is not None and element.find(quantity) is not None:
                sheet.add(Fact("joint", name, quantity), sheet.one(element, quantity), of)
    mimic = axis.find("mimic")
    if mimic is not None:
        factor = sheet.one(mimic, "multiplier")
        sheet.add(Fact("joint", name, "mimic joint"), sheet.text(mimic, "joint"))
        sheet.add(Fact("joint", name, "mimic multiplier"), factor)
        at = sheet.one(mimic, "reference") if mimic.find("reference") is not None else 0.0
        sheet.add(Fact("joint", name, "mimic offset"), sheet.one(mimic, "offset") - factor * at, unit)
