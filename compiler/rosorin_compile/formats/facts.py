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
from collections.abc import Iterable, Iterator, Mapping, Sequence
from functools import lru_cache
from typing import TYPE_CHECKING, NamedTuple

from ..model import Box, Inertial, Joint, Pose, Robot, Transform, Vector
from ..model.geometry import Rows, dot
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

# Numbers of frames that are no farther apart (m, rotation entries) are one: rounding alone.
_NEAR = 1e-13
# Three coordinates may be off at once.
_ROOT_THREE = 3**0.5
COLLISION, VISUAL = "collision", "visual"

_UPRIGHT = Transform().rows

Six = tuple[float, float, float, float, float, float]


class Solid(NamedTuple):
    """A shape in the frame of its link: full sizes and middle (m), rotation, and what else an artifact says of it.

    Sizes of a mesh are factors. ``tolerance`` is how well the lengths are known (m), ``turn_tolerance`` how well the
    entries of the rotation.
    """

    kind: str
    sizes: tuple[float, ...]
    centre: Vector
    rows: Rows
    words: tuple[str, ...]
    tolerance: float
    turn_tolerance: float

    @property
    def box(self) -> Box | None:
        """The solid as a box along the axes of its link; None if it is none."""
        if self.kind != "box" or self.rows != _UPRIGHT or len(self.sizes) != 3:
            return None
        x, y, z = self.centre
        a, b, c = (size / 2 for size in self.sizes)
        return Box((x - a, y - b, z - c), (x + a, y + b, z + c))


class Known(NamedTuple):
    """What the model says: its facts; and where links sit and what they weigh, all numbers together.

    ``frames`` has the parent of a link, its place there (m) and its rotation; ``masses`` the mass (kg), where its
    centre is (m) and the inertia (kg*m^2), in the terms of the facts.
    """

    facts: Facts
    frames: Mapping[str, tuple[str, Vector, Rows]]
    masses: Mapping[str, tuple[float, Vector, Six]]


class Held(NamedTuple):
    """An artifact held against what is known: the facts that are said otherwise, and what is left to be compared.

    ``parents`` are those of all frames, ``solids`` the collision shapes by link, ``names`` all links that it has.
    """

    facts: Facts
    parents: Mapping[str, str]
    solids: Mapping[str, Sequence[Solid]]
    names: frozenset[str]


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
def numbers_of(text: str) -> tuple[float, ...]:
    """Return the numbers of a text; the same ones stand in many. Raises ValueError if one is none."""
    words = text.split()
    try:
        found = tuple(map(float, words))
    except ValueError:
        found = ()
    return found if "_" not in text and all(map(math.isfinite, found)) and found else tuple(map(number_of, words))


# Six letters are six digits at most: nothing is left for ``six`` to shorten.
_FEW = 6


def is_exact(texts: Iterable[str]) -> bool:
    """Say whether an artifact was printed with number_format exact: it holds a number that ``six`` would shorten."""
    seen = set[str]()
    for text in texts:
        if len(text) <= _FEW or text in seen:
            continue
        seen.add(text)
        for token in text.split():
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
    """Collects the facts of one XML artifact; with what is ``known`` only those that are otherwise, and solids.

    What is read is the same, and as much is refused: what is known is only not written down.
    """

    def __init__(self, text: str, tag: str, known: Known | None = None) -> None:
        self.root = parse(text, tag)
        self.facts: Facts = {}
        self.exact = is_exact(self.numbers_written())
        self.known = known
        self._parents: dict[str, str] = {}
        self._solids: dict[str, list[Solid]] = {}
        self._names: set[str] = set()
        # How well a printed rotation is known (rad).
        self._turning = ROTATION_ROUNDING + 4 * self.tolerance(1.0)

    def numbers_written(self) -> Iterator[str]:
        """Yield the texts in which numbers stand."""
        return (text for element in self.root.iter() for name, text in element.items() if name != "name")

    def held(self) -> Held:
        """Return what was found that is not known."""
        return Held(self.facts, self._parents, self._solids, frozenset(self._names.union(self._parents.values())))

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
        found = numbers_of(text)
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
        if self.known is not None:
            if fact[0] in _OF_LINKS:
                self._names.add(fact[1])
            meant = self.known.facts.get(fact)
            if meant is None or meant[0] == value:
                return
        if isinstance(value, str):
            self.facts[fact] = Value(value)
        else:
            self.facts[fact] = Value(value, unit, self.tolerance(value) if tolerance is None else tolerance)

    def add_frame(self, link: str, parent: str, transform: Transform) -> None:
        """Take down where a link sits in its parent."""
        known = self.known
        if known is not None:
            self._names.add(link)
            self._parents[link] = parent
            meant = known.frames.get(link)
            if meant is not None and meant[0] == parent and _is_at(transform, meant[1], meant[2]):
                return
        self.add(Fact("frame", link, "parent"), parent)
        for axis, value in zip(_ORIGIN, transform.xyz, strict=True):
            self.add(Fact("frame", link, axis), value, "m")
        for angle, value in zip(ANGLES, angles(transform), strict=True):
            fact = Fact("frame", link, angle)
            if known is None or fact in known.facts:  # one says little without the others
                self.facts[fact] = Value(value, "rad", self._turning)

    def add_inertial(self, link: str, mass: float, frame: Transform, inertia: Six) -> None:
        """Take down mass (kg), centre of mass (m), and inertia (kg*m^2; xx yy zz xy xz yz along ``frame``)."""
        along = along_link(inertia, frame)
        if self.known is not None:
            self._names.add(link)
            if self.known.masses.get(link) == (mass, frame.xyz, along):
                return
        self.add(Fact("link", link, "mass"), mass, "kg")
        for axis, value in zip(_CENTRE, frame.xyz, strict=True):
            self.add(Fact("link", link, axis), value, "m")
        rounding = 0.0 if self.exact else _turned(inertia, 4 * self.tolerance(1.0))
        if frame.rows != _UPRIGHT:
            rounding += max(map(abs, inertia)) * ROTATION_ROUNDING + 3 * max(map(self.tolerance, inertia))
        for name, value in zip(_MOMENTS, along, strict=True):
            tolerance = self.tolerance(value) + rounding
            self.add(Fact("link", link, name), value, "kg*m^2", tolerance)

    def add_shape(self, link: str, shape: str, kind: str, sizes: Sequence[float], transform: Transform) -> None:
        """Take down a shape, such as "collision 3": its kind, where its middle is in the link, its full sizes (m)."""
        if self.known is not None:
            self._names.add(link)
            if not math.isfinite(sum(sizes)):
                raise ValueError(f"{shape} of link {link} has no size")
            if shape.startswith(COLLISION):
                self._solids.setdefault(link, []).append(self._solid(kind, sizes, transform))
            return
        self.add(Fact("link", link, f"{shape} geometry"), kind)
        for axis, value in zip(AXES, transform.xyz, strict=True):
            self.add(Fact("link", link, f"{shape} origin {axis}"), value, "m")
        for angle, value in zip(ANGLES, angles(transform), strict=True):
            self.add(Fact("link", link, f"{shape} {angle}"), value, "rad", self._turning)
        unit = "" if kind == "mesh" else "m"
        for name, value in zip(SIZES.get(kind, ()), sizes, strict=False):
            self.add(Fact("link", link, f"{shape} {name}"), value, unit, 2 * self.tolerance(value))

    def add_of_shape(self, link: str, shape: str, quantity: str, value: float | str) -> None:
        """Take down what else is said of a shape, which the model is not asked for."""
        if self.known is None:
            self.add(Fact("link", link, f"{shape} {quantity}"), value)

    def _solid(self, kind: str, sizes: Sequence[float], transform: Transform) -> Solid:
        """Return a shape as ``add_shape`` would say it."""
        sizes = tuple(sizes[: len(SIZES.get(kind, ()))])
        if self.exact:
            return Solid(kind, sizes, transform.xyz, transform.rows, (), 0.0, 3 * self._turning)
        lengths = [_ROOT_THREE * max(map(self.tolerance, transform.xyz)), *(2 * self.tolerance(size) for size in sizes)]
        return Solid(kind, sizes, transform.xyz, transform.rows, (), max(lengths), 3 * self._turning)


_OF_LINKS = ("frame", "link")


def _is_at(transform: Transform, xyz: Vector, rows: Rows) -> bool:
    """Say whether a transform is at a place, as far as doubles tell."""
    if transform.xyz == xyz and transform.rows == rows:
        return True
    pairs = zip((transform.xyz, *transform.rows), (xyz, *rows), strict=True)
    return all(abs(a - b) <= _NEAR for one, other in pairs for a, b in zip(one, other, strict=True))


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
    mass, centre, moments = mass_of(inertial)
    values = {"mass": Value(float(mass), "kg")}
    values |= {axis: Value(float(v), "m") for axis, v in zip(_CENTRE, centre, strict=True)}
    values |= {name: Value(float(value), "kg*m^2") for name, value in zip(_MOMENTS, moments, strict=True)}
    return {Fact("link", link, quantity): value for quantity, value in values.items()}


def mass_of(inertial: Inertial) -> tuple[float, Vector, Six]:
    """Return mass (kg), centre of mass (m) and inertia (kg*m^2; xx yy zz xy xz yz along the axes of the link)."""
    six = (inertial.ixx, inertial.iyy, inertial.izz, inertial.ixy, inertial.ixz, inertial.iyz)
    return inertial.mass, inertial.pose.xyz, along_link(six, inertial.pose.transform())


def known_of(robot: Robot) -> Known:
    """Return what the model says, to hold artifacts against."""
    facts = facts_of(robot)
    frames = {
        joint.child: (joint.parent, joint.origin.xyz, joint.origin.transform().rows)
        for joint in robot.joints
        if facts[Fact("frame", joint.child, "parent")][0] == joint.parent
    }
    return Known(facts, frames, {link.name: mass_of(link.inertial) for link in robot.links if link.inertial})


def with_masses(known: Known, inertials: Mapping[str, Inertial]) -> Known:
    """Return what is known where some links weigh something else."""
    facts, masses = dict(known.facts), dict(known.masses)
    for link, inertial in inertials.items():
        facts |= mass_facts(link, inertial)
        masses[link] = mass_of(inertial)
    return Known(facts, known.frames, masses)
