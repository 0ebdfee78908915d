"""Two URDFs compared as robots: what they say, whatever the order, the form of numbers and what is left to defaults.

An element or attribute that is not compared is an error, so that no difference can hide in it.
"""

from __future__ import annotations

import xml.etree.ElementTree as ET
import xml.etree.ElementTree as ElementTree
from collections.abc import Mapping
from typing import Any

from rosorin_compile.formats.templating import Templates
from rosorin_compile.formats.urdf import write as urdf
from rosorin_compile.model import Output, Pose, Robot

Facts = dict[str, "float | str"]

TOLERANCE = 1e-12

_INERTIA = ("ixx", "ixy", "ixz", "iyy", "iyz", "izz")
_SIZES = {"box": ("size",), "cylinder": ("radius", "length"), "sphere": ("radius",), "mesh": ("scale",)}

# Elements of the robot that are no business of ours: compared as XML, in their order.
_KEPT = ("gazebo", "ros2_control", "transmission")


def facts(urdf: str) -> Facts:
    """Return all that a URDF says, by what it is about. Raises ValueError on what is not compared."""
    root = ET.fromstring(urdf)
    _only(root, {"name"}, {"link", "joint", "material", *_KEPT})
    found: Facts = {"robot": root.attrib["name"]}
    kept = [element for element in root if element.tag in _KEPT]
    found |= {f"kept {i}": ET.canonicalize(ET.tostring(each), strip_text=True) for i, each in enumerate(kept)}
    colours = {m.attrib["name"]: _colour(m) for m in root.findall("material")}
    for link in root.findall("link"):
        _take(found, f"link {link.attrib['name']}", _link(link, colours))
    for joint in root.findall("joint"):
        _take(found, f"joint {joint.attrib['name']}", _joint(joint))
    return found


def differences(left: Facts, right: Facts) -> list[str]:
    """Return what two URDFs do not agree on, one line each; numbers agree to 1e-12."""
    found = []
    for key in sorted(left.keys() | right.keys()):
        a, b = left.get(key), right.get(key)
        if isinstance(a, float) and isinstance(b, float):
            if abs(a - b) > TOLERANCE * max(1.0, abs(a), abs(b)):
                found.append(f"{key}: {a!r} and {b!r}")
        elif a != b:
            found.append(f"{key}: {a!r} and {b!r}")
    return found


def _take(found: Facts, subject: str, said: Facts) -> None:
    if subject in found:
        raise ValueError(f"{subject} is there twice")
    found[subject] = "is there"
    found.update({f"{subject} {key}": value for key, value in said.items()})


def _only(element: ET.Element, attributes: set[str], children: set[str]) -> None:
    unknown = [*(element.attrib.keys() - attributes), *({child.tag for child in element} - children)]
    if unknown or (element.text or "").strip():
        raise ValueError(f"not compared in <{element.tag}>: {', '.join(unknown) or element.text}")


def _link(link: ET.Element, colours: dict[str, Any]) -> Facts:
    _only(link, {"name"}, {"inertial", "visual", "collision"})
    said: Facts = {}
    inertial = link.find("inertial")
    if inertial is not None:
        said |= {f"inertial {key}": value for key, value in _inertial(inertial).items()}
    for purpose in ("visual", "collision"):
        for number, shape in enumerate(link.findall(purpose), 1):
            said |= {f"{purpose} {number} {key}": value for key, value in _shape(shape, colours).items()}
    return said


def _inertial(inertial: ET.Element) -> Facts:
    _only(inertial, set(), {"origin", "mass", "inertia"})
    mass, moments = _child(inertial, "mass"), _child(inertial, "inertia")
    _only(mass, {"value"}, set())
    _only(moments, set(_INERTIA), set())
    said: Facts = {"mass": float(mass.attrib["value"])}
    return said | _origin(inertial) | {key: float(moments.attrib[key]) for key in _INERTIA}


def _shape(shape: ET.Element, colours: dict[str, Any]) -> Facts:
    _only(shape, {"name"}, {"origin", "geometry", "material"})
    (solid,) = _child(shape, "geometry")
    sizes = _SIZES[solid.tag]
    _only(solid, {*sizes, "filename"}, set())
    said: Facts = {"kind": solid.tag, **_origin(shape)}
    if "name" in shape.attrib:
        said["name"] = shape.attrib["name"]
    if solid.tag == "mesh":
        said["file"] = solid.attrib["filename"]
    for size in sizes:
        said |= _vector(size, solid.get(size, "1 1 1") if size == "scale" else solid.attrib[size])
    material = shape.find("material")
    if material is not None:
        name = material.attrib["name"]
        said["material"] = name
        said |= _vector("colour", _colour(material) or colours.get(name) or "")
    return said


def _colour(material: ET.Element) -> str:
    _only(material, {"name"}, {"color"})
    colour = material.find("color")
    return "" if colour is None else colour.attrib["rgba"]


def _joint(joint: ET.Element) -> Facts:
    tags = {"parent", "child", "origin", "axis", "limit", "mimic", "dynamics"}
    _only(joint, {"name", "type"}, tags)
    kind = joint.attrib["type"]
    said: Facts = {"type": kind, **_origin(joint)}
    said |= {tag: _child(joint, tag).attrib["link"] for tag in ("parent", "child")}
    if kind != "fixed":
        axis = joint.find("axis")
        said |= _vector("axis", "1 0 0" if axis is None else axis.attrib["xyz"])
    for tag, quantities in (("limit", ("lower", "upper", "effort", "velocity")), ("dynamics", ("damping", "friction"))):
        element = joint.find(tag)
        if element is not None:
            _only(element, set(quantities), set())
            said |= {f"{tag} {quantity}": float(element.get(quantity, "0")) for quantity in quantities}
    mimic = joint.find("mimic")
    if mimic is not None:
        _only(mimic, {"joint", "multiplier", "offset"}, set())
        said["mimic"] = mimic.attrib["joint"]
        said |= {"multiplier": float(mimic.get("multiplier", "1")), "offset": float(mimic.get("offset", "0"))}
    return said


def _origin(element: ET.Element) -> Facts:
    """Return the pose of an element, its orientation as a matrix: several rpy are one orientation."""
    origin = element.find("origin")
    xyz, rpy = ("0 0 0", "0 0 0") if origin is None else (origin.get("xyz", "0 0 0"), origin.get("rpy", "0 0 0"))
    if origin is not None:
        _only(origin, {"xyz", "rpy"}, set())
    x, y, z = map(float, xyz.split())
    roll, pitch, yaw = map(float, rpy.split())
    transform = Pose((x, y, z), (roll, pitch, yaw)).transform()
    said: Facts = {f"xyz {i}": value for i, value in enumerate((x, y, z))}
    return said | {f"rotation {i} {j}": v for i, row in enumerate(transform.rows) for j, v in enumerate(row)}


def _vector(name: str, text: str) -> Facts:
    return {f"{name} {i}": float(word) for i, word in enumerate(text.split())}


def _child(element: ET.Element, tag: str) -> ET.Element:
    found = element.find(tag)
    if found is None:
        raise ValueError(f"<{element.tag}> has no <{tag}>")
    return found


def emit(robot: Robot, options: Mapping[str, Any] | None = None) -> str:
    options = {"number_format": "exact", **(options or {})}
    text, diagnostics = urdf.write(robot, Output("urdf", "urdf", "robot.urdf", options), Templates())
    assert diagnostics == []
    return text


def parsed(text: str) -> ElementTree.Element:
    return ElementTree.fromstring(text)


def link(text: str, name: str) -> ElementTree.Element:
    return next(element for element in parsed(text).iter("link") if element.get("name") == name)


def numbers(text: str | None) -> list[float]:
    return [float(token) for token in (text or "").split(" ")]
