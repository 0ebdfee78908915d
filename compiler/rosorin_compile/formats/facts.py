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
from collections.abc import Callable, Hashable, Iterable, Sequence
from functools import lru_cache
from typing import TYPE_CHECKING

from ..model import Inertial, Joint, Pose, Robot, Transform, Vector
from ..model.geometry import dot
from ..numbers import SIX, six
from ..xml.elements import tree_of
from .format import Block, Blocks, Fact, Facts, Value, row_name

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
        self.blocks: Blocks = []
        # What is said of many things in the same words is worked out once: their blocks are one object.
        self._known: dict[Hashable, Block] = {}
        self._transforms: dict[Hashable, Transform] = {}
        self._kept: dict[int, Transform] = {}
        self.exact = is_exact(self.root)
        # How well a printed rotation is known (rad).
        self._turning = ROTATION_ROUNDING + 4 * self.tolerance(1.0)

    @property
    def facts(self) -> Facts:
        """What was taken down, fact by fact."""
        return flat(self.blocks)

    def once(self, key: Hashable, make: Callable[[], Block]) -> Block:
        """Return what is made of words that may be said of many things; ``key`` are all of those words."""
        block = self._known.get(key)
        if block is None:
            block = self._known[key] = make()
        return block

    def transform(self, key: Hashable, make: Callable[[], Transform]) -> Transform:
        """Return the transform that is made of some words, ``key``: the same object for the same ones."""
        transform = self._transforms.get(key)
        if transform is None:
            transform = self._transforms[key] = make()
        return transform

    def _key(self, transform: Transform) -> int:
        """Return what tells a transform from others: it is kept, so that no other one gets its identity."""
        self._kept[id(transform)] = transform
        return id(transform)

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

    def value(self, value: float | str, unit: str = "", tolerance: float | None = None) -> Value:
        """Return a value; the tolerance of a number is what was printed of it unless it is given."""
        if isinstance(value, str):
            return Value(value)
        return Value(value, unit, self.tolerance(value) if tolerance is None else tolerance)

    def add(self, fact: Fact, value: float | str, unit: str = "", tolerance: float | None = None) -> None:
        """Take down a fact; its value as in ``value``."""
        self.blocks.append((fact[0], fact[1], {fact[2]: self.value(value, unit, tolerance)}))

    def add_frame(self, link: str, parent: str, transform: Transform) -> None:
        """Take down where a link sits in its parent."""
        self.blocks.append(("frame", link, {"parent": Value(parent)}))
        self.blocks.append(("frame", link, self.once(self._key(transform), lambda: self._origin(transform))))

    def _origin(self, transform: Transform) -> Block:
        values = {axis: self.value(value, "m") for axis, value in zip(_ORIGIN, transform.xyz, strict=True)}
        for angle, value in zip(ANGLES, angles(transform), strict=True):
            values[angle] = self.value(value, "rad", self._turning)
        return values

    def add_inertial(self, link: str, mass: float, frame: Transform, inertia: Six) -> None:
        """Take down mass (kg), centre of mass (m), and inertia (kg*m^2; xx yy zz xy xz yz along ``frame``)."""
        block = self.once((mass, self._key(frame), inertia), lambda: self._inertial(mass, frame, inertia))
        self.blocks.append(("link", link, block))

    def _inertial(self, mass: float, frame: Transform, inertia: Six) -> Block:
        values = {"mass": self.value(mass, "kg")}
        for axis, value in zip(_CENTRE, frame.xyz, strict=True):
            values[axis] = self.value(value, "m")
        rounding = 0.0 if self.exact else _turned(inertia, 4 * self.tolerance(1.0))
        if frame.rows != _UPRIGHT:
            rounding += max(map(abs, inertia)) * ROTATION_ROUNDING + 3 * max(map(self.tolerance, inertia))
        for name, value in zip(_MOMENTS, along_link(inertia, frame), strict=True):
            values[name] = self.value(value, "kg*m^2", self.tolerance(value) + rounding)
        return values

    def add_count(self, link: str, purpose: str, count: int) -> None:
        """Take down how many shapes a link has."""
        block = self.once((purpose, count), lambda: {f"{purpose} shapes": self.value(float(count), tolerance=0.0)})
        self.blocks.append(("link", link, block))

    def add_shape(self, link: str, shape: str, kind: str, sizes: Sequence[float], transform: Transform) -> None:
        """Take down a shape, such as "collision 3": its kind, where its middle is in the link, its full sizes (m)."""
        sizes = tuple(sizes)
        block = self.once(
            (shape, kind, sizes, self._key(transform)), lambda: self._shape(shape, kind, sizes, transform)
        )
        self.blocks.append(("link", link, block))

    def _shape(self, shape: str, kind: str, sizes: Sequence[float], transform: Transform) -> Block:
        values = {f"{shape} geometry": self.value(kind)}
        for axis, value in zip(AXES, transform.xyz, strict=True):
            values[f"{shape} origin {axis}"] = self.value(value, "m")
        for angle, value in zip(ANGLES, angles(transform), strict=True):
            values[f"{shape} {angle}"] = self.value(value, "rad", self._turning)
        unit = "" if kind == "mesh" else "m"
        for name, value in zip(SIZES.get(kind, ()), sizes, strict=False):
            values[f"{shape} {name}"] = self.value(value, unit, 2 * self.tolerance(value))
        return values


def flat(blocks: Iterable[tuple[str, str, Block]]) -> Facts:
    """Return what blocks say, fact by fact."""
    return {Fact(kind, name, quantity): value for kind, name, block in blocks for quantity, value in block.items()}


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


# What the model says of each thing: what many may say, and what it alone says (names of parents and children).
Known = dict[tuple[str, str], tuple[Block, Block]]


def said_by(robot: Robot) -> Known:
    """Return what the model says about frames, joints and masses, in the terms of the artifacts."""
    known: Known = {}
    once: dict[Hashable, Block] = {}
    for joint in robot.joints:
        known["frame", joint.child] = _frame(joint.parent, joint.origin, once)
        known["joint", joint.name] = _joint(joint, once)
    for edge in robot.edges:
        # Of several rows for one frame the first one bears its name alone.
        if edge.joint:
            known["frame", row_name(edge)] = _frame(edge.parent, robot.joint[edge.joint].origin, once)
        elif edge.pose is not None and ("frame", edge.child) not in known:
            known["frame", edge.child] = _frame(edge.parent, edge.pose, once)
    for link in robot.links:
        if link.inertial is not None:
            known["link", link.name] = (mass_block(link.inertial, once), _NOTHING)
    return known


_NOTHING: Block = {}


def _frame(parent: str, pose: Pose, once: dict[Hashable, Block]) -> tuple[Block, Block]:
    key = (pose.xyz, pose.rpy)
    if key not in once:
        facts = frame_facts("", "", pose)
        once[key] = {fact[2]: value for fact, value in facts.items() if fact[2] != "parent"}
    return once[key], {"parent": Value(parent)}


def _joint(joint: Joint, once: dict[Hashable, Block]) -> tuple[Block, Block]:
    limit, mimic = joint.limit, joint.mimic
    key = (
        *("joint", joint.type, joint.axis),
        limit and (limit.lower, limit.upper, limit.velocity, limit.effort),
        mimic and (mimic.joint, mimic.multiplier, mimic.offset),
    )
    if key not in once:
        once[key] = _joint_block(joint)
    return once[key], {"child": Value(joint.child)}


def _joint_block(joint: Joint) -> Block:
    values: dict[str, Value] = {"type": Value(joint.type)}
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
    return values


def mass_block(inertial: Inertial, once: dict[Hashable, Block]) -> Block:
    """Return what is said of the mass of a link; ``once`` remembers it."""
    six = (inertial.ixx, inertial.iyy, inertial.izz, inertial.ixy, inertial.ixz, inertial.iyz)
    key = (inertial.mass, inertial.pose.xyz, inertial.pose.rpy, six)
    if key not in once:
        values = {"mass": Value(float(inertial.mass), "kg")}
        values |= {axis: Value(float(v), "m") for axis, v in zip(_CENTRE, inertial.pose.xyz, strict=True)}
        along = along_link(six, inertial.pose.transform())
        values |= {name: Value(float(value), "kg*m^2") for name, value in zip(_MOMENTS, along, strict=True)}
        once[key] = values
    return once[key]
