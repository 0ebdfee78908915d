"""Facts: what is said of a robot, thing by thing, by its model and by its artifacts.

All call a thing by the same name and put it in the same terms, so that a fact of the URDF and one of the MJCF can be
compared; readers of XML share parsing and numbers with their printed precision:

==========  ==========================================================================================================
frame       by child link: "parent", "origin x|y|z" in the parent (m), "roll|pitch|yaw" (rad; see ``angles``)
joint       by joint: "type", "child", "axis x|y|z", "lower|upper|velocity|effort", "damping|friction|armature",
            "mimic joint|multiplier|offset"
link        by link: "mass", "centre of mass x|y|z", "inertia xx|yy|zz|xy|xz|yz" about the centre of mass along the axes
            of the link, "collision shapes"; of each shape "collision 1 geometry", "collision 1 origin x", "collision 1
            roll", "collision 1 size x" (full extents); the same with "visual"
==========  ==========================================================================================================
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import lru_cache
from typing import TYPE_CHECKING

from ..model import Inertial, Joint, Pose, Robot, Transform, Vector
from ..model.geometry import dot
from ..numbers import SIX, six
from ..xml.elements import tree_of
from .format import Fact, Facts, Value, row_name

if TYPE_CHECKING:
    from xml.etree.ElementTree import Element

AXES = ("x", "y", "z")
ANGLES = ("roll", "pitch", "yaw")
INERTIA = ("xx", "yy", "zz", "xy", "xz", "yz")
_ORIGIN = tuple(f"origin {axis}" for axis in AXES)
_CENTRE = tuple(f"centre of mass {axis}" for axis in AXES)
_MOMENTS = tuple(f"inertia {name}" for name in INERTIA)
# The names of the sizes of a shape: full extents and full lengths in metres, as in URDF; of a mesh a bare factor.
SIZES = {
    "box": ("size x", "size y", "size z"),
    "cylinder": ("radius", "length"),
    "capsule": ("radius", "length"),
    "sphere": ("radius",),
    "ellipsoid": ("size x", "size y", "size z"),
    "mesh": ("scale x", "scale y", "scale z"),
}
# What a rotation loses on its way through a quaternion or a matrix and back, in radians; measured: below 1e-15.
ROTATION_ROUNDING = 1e-12

_UPRIGHT = Transform().rows

Six = tuple[float, float, float, float, float, float]


def parse(text: str, tag: str) -> Element:
    """Return the root element of an XML text. Raises ValueError if it is damaged or its root is not ``tag``."""
    root = tree_of(text)
    if root.tag != tag:
        raise ValueError(f"the root element is {root.tag}, not {tag}")
    return root


def number_of(text: str) -> float:
    """Return a number of an attribute. Raises ValueError if it is none or not finite."""
    value = float(text)
    if "_" in text or not math.isfinite(value):
        raise ValueError(f"not a number: {text}")
    return value


@lru_cache(maxsize=20_000)
def _numbers_of(text: str) -> tuple[float, ...]:
    """Return the numbers of an attribute; the same ones stand in many. Raises ValueError if one is none."""
    return tuple(map(number_of, text.split()))


# Six letters are six digits at most: nothing is left for ``six`` to shorten.
_FEW = 6


def is_exact(root: Element) -> bool:
    """Say whether an artifact was printed with number_format exact: it holds a number that ``six`` would shorten."""
    texts = {text for element in root.iter() for name, text in element.items() if name != "name"}
    tokens = {token for text in texts for token in text.split()}
    for token in tokens:
        if len(token) <= _FEW:
            continue
        try:
            value = number_of(token)
        except ValueError:
            continue
        if float(six(value)) != value:
            return True
    return False


_tolerance_of_six = lru_cache(maxsize=20_000)(SIX.tolerance)


class FactSheet:
    """Collects the facts of one XML artifact."""

    def __init__(self, text: str, tag: str) -> None:
        self.root = parse(text, tag)
        self.facts: Facts = {}
        self.exact = is_exact(self.root)
        # How well a printed rotation is known (rad).
        self._turning = ROTATION_ROUNDING + 4 * self.tolerance(1.0)

    def tolerance(self, value: float) -> float:
        """Return how well a printed value is known: 0 where every digit was printed."""
        return 0.0 if self.exact else _tolerance_of_six(value)

    def text(self, element: Element, attribute: str) -> str:
        """Return an attribute. Raises ValueError if it is not there."""
        value = element.get(attribute)
        if value is None:
            raise ValueError(f"<{element.tag}> has no {attribute}")
        return value

    def vector(self, element: Element, attribute: str, length: int, default: Sequence[float]) -> tuple[float, ...]:
        """Return the numbers of an attribute. Raises ValueError unless there are ``length`` of them."""
        text = element.get(attribute)
        if text is None:
            return tuple(default)
        found = _numbers_of(text)
        if len(found) != length:
            raise ValueError(f'<{element.tag} {attribute}="{text}">: {length} numbers are needed')
        return found

    def vector3(self, element: Element, attribute: str, default: Vector = (0.0, 0.0, 0.0)) -> Vector:
        """Return the three numbers of an attribute. Raises ValueError unless there are three."""
        x, y, z = self.vector(element, attribute, 3, default)
        return (x, y, z)

    def number(self, element: Element, attribute: str, default: float = 0.0) -> float:
        """Return the number of an attribute. Raises ValueError if it is none."""
        return self.vector(element, attribute, 1, (default,))[0]

    def add(self, fact: Fact, value: float | str, unit: str = "", tolerance: float | None = None) -> None:
        """Take down a fact; the tolerance of a number is what was printed of it unless it is given."""
        if isinstance(value, str):
            self.facts[fact] = Value(value)
        else:
            self.facts[fact] = Value(value, unit, self.tolerance(value) if tolerance is None else tolerance)

    def add_frame(self, link: str, parent: str, transform: Transform) -> None:
        """Take down where a link sits in its parent."""
        self.add(Fact("frame", link, "parent"), parent)
        for axis, value in zip(_ORIGIN, transform.xyz, strict=True):
            self.add(Fact("frame", link, axis), value, "m")
        for angle, value in zip(ANGLES, angles(transform), strict=True):
            self.add(Fact("frame", link, angle), value, "rad", self._turning)

    def add_inertial(self, link: str, mass: float, frame: Transform, inertia: Six) -> None:
        """Take down mass (kg), centre of mass (m), and inertia (kg*m^2; xx yy zz xy xz yz along ``frame``)."""
        self.add(Fact("link", link, "mass"), mass, "kg")
        for axis, value in zip(_CENTRE, frame.xyz, strict=True):
            self.add(Fact("link", link, axis), value, "m")
        rounding = 0.0 if self.exact else _turned(inertia, 4 * self.tolerance(1.0))
        if frame.rows != _UPRIGHT:
            rounding += max(map(abs, inertia)) * ROTATION_ROUNDING + 3 * max(map(self.tolerance, inertia))
        for name, value in zip(_MOMENTS, along_link(inertia, frame), strict=True):
            tolerance = self.tolerance(value) + rounding
            self.add(Fact("link", link, name), value, "kg*m^2", tolerance)

    def add_shape(self, link: str, shape: str, kind: str, sizes: Sequence[float], transform: Transform) -> None:
        """Take down a shape, such as "collision 3": its kind, where its middle is in the link, its full sizes (m)."""
        self.add(Fact("link", link, f"{shape} geometry"), kind)
        for axis, value in zip(AXES, transform.xyz, strict=True):
            self.add(Fact("link", link, f"{shape} origin {axis}"), value, "m")
        for angle, value in zip(ANGLES, angles(transform), strict=True):
            self.add(Fact("link", link, f"{shape} {angle}"), value, "rad", self._turning)
        unit = "" if kind == "mesh" else "m"
        for name, value in zip(SIZES.get(kind, ()), sizes, strict=False):
            self.add(Fact("link", link, f"{shape} {name}"), value, unit, 2 * self.tolerance(value))


# Where -pi ends and +pi begins: ``six`` prints pi as 3.141593, which reads as -3.1415926 + 2 pi.
PI_CUT = 2e-6


def angles(transform: Transform) -> Vector:
    """Return fixed-axis roll, pitch, yaw (rad) in the one form that is compared.

    Many triples mean one rotation; the one taken has its pitch within +-pi/2, and roll and yaw above -pi as far as
    rounding can tell, so that +pi and -pi are one angle.
    """
    if transform.rows == _UPRIGHT:
        return (0.0, 0.0, 0.0)
    roll, pitch, yaw = (a + math.tau if a < PI_CUT - math.pi else a + 0.0 for a in transform.rpy())
    return (roll, pitch, yaw)


def _turned(inertia: Six, angle: float) -> float:
    """Return by how much a small turn (rad) moves the entries of an inertia at most.

    A turn w changes I by w x I - I x w, which is the same for I - c of any multiple c of the unit matrix.
    """
    moments, products = inertia[:3], inertia[3:]
    size = (max(moments) - min(moments)) / 2 + 2 * max(map(abs, products))
    return 2 * size * angle


def along_link(inertia: Six, frame: Transform) -> Six:
    """Return an inertia (xx yy zz xy xz yz along the axes of ``frame``) along the axes of the link: R I R^T."""
    if frame.rows == _UPRIGHT:
        return inertia
    xx, yy, zz, xy, xz, yz = inertia
    a, b, c = (_times(((xx, xy, xz), (xy, yy, yz), (xz, yz, zz)), row) for row in frame.rows)
    r, s, t = frame.rows
    return (dot(r, a), dot(s, b), dot(t, c), dot(r, b), dot(r, c), dot(s, c))


def _times(rows: tuple[Vector, Vector, Vector], v: Vector) -> Vector:
    return (dot(rows[0], v), dot(rows[1], v), dot(rows[2], v))


NO_TOLERANCE: Vector = (0.0, 0.0, 0.0)


def frame_facts(
    child: str, parent: str, pose: Pose, metres: Vector = NO_TOLERANCE, radians: Vector = NO_TOLERANCE
) -> Facts:
    """Return where a frame sits in its parent; ``metres`` and ``radians`` are how well its numbers are known.

    Angles are as they were written, if that is the form in which they are compared (see ``angles``).
    """
    rpy = pose.rpy
    compared = rpy if rpy == (0.0, 0.0, 0.0) else angles(pose.transform())
    if any(abs(one - other) >= ROTATION_ROUNDING for one, other in zip(rpy, compared, strict=True)):
        rpy = compared
        radians = (ROTATION_ROUNDING + 4 * max(radians),) * 3
    facts: Facts = {Fact("frame", child, "parent"): Value(parent)}
    for axis, value, tolerance in zip(_ORIGIN, pose.xyz, metres, strict=True):
        facts[Fact("frame", child, axis)] = Value(float(value), "m", tolerance)
    for angle, value, tolerance in zip(ANGLES, rpy, radians, strict=True):
        facts[Fact("frame", child, angle)] = Value(float(value), "rad", tolerance)
    return facts


def facts_of(robot: Robot) -> Facts:
    """Return what the model says about frames, joints and masses, in the terms of the artifacts."""
    facts: Facts = {}
    for joint in robot.joints:
        facts |= frame_facts(joint.child, joint.parent, joint.origin)
        facts |= _joint_facts(joint)
    for edge in robot.edges:
        # Of several rows for one frame the first one bears its name alone.
        if edge.joint:
            facts |= frame_facts(row_name(edge), edge.parent, robot.joint[edge.joint].origin)
        elif edge.pose is not None and Fact("frame", edge.child, "parent") not in facts:
            facts |= frame_facts(edge.child, edge.parent, edge.pose)
    for link in robot.links:
        facts |= mass_facts(link.name, link.inertial) if link.inertial is not None else {}
    return facts


def _joint_facts(joint: Joint) -> Facts:
    values: dict[str, Value] = {"type": Value(joint.type), "child": Value(joint.child)}
    unit = "m" if joint.type == "prismatic" else "rad"
    if joint.moves or joint.type == "planar":
        values |= {f"axis {axis}": Value(float(value)) for axis, value in zip(AXES, joint.axis, strict=True)}
    if joint.moves and joint.limit:
        limits = {"lower": joint.limit.lower, "upper": joint.limit.upper, "velocity": joint.limit.velocity}
        limits["effort"] = joint.limit.effort
        values |= {quantity: Value(float(value), unit) for quantity, value in limits.items() if value is not None}
    if joint.mimic:
        values["mimic joint"] = Value(joint.mimic.joint)
        values["mimic multiplier"] = Value(float(joint.mimic.multiplier))
        values["mimic offset"] = Value(float(joint.mimic.offset), unit)
    return {Fact("joint", joint.name, quantity): value for quantity, value in values.items()}


def mass_facts(link: str, inertial: Inertial) -> Facts:
    """Return what is said of the mass of a link."""
    values = {"mass": Value(float(inertial.mass), "kg")}
    values |= {axis: Value(float(v), "m") for axis, v in zip(_CENTRE, inertial.pose.xyz, strict=True)}
    six = (inertial.ixx, inertial.iyy, inertial.izz, inertial.ixy, inertial.ixz, inertial.iyz)
    along = along_link(six, inertial.pose.transform())
    values |= {name: Value(float(value), "kg*m^2") for name, value in zip(_MOMENTS, along, strict=True)}
    return {Fact("link", link, quantity): value for quantity, value in values.items()}
