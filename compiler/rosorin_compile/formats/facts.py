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
import re
from collections.abc import Callable, Hashable, Iterable, Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple, TypeVar

from rosorin_compile.model import Box, Edge, Inertial, Pose, Transform, Vector
from rosorin_compile.model.geometry import Rows, dot
from rosorin_compile.source.memo import remembered
from rosorin_compile.source.numbers import SHORT, off_by_short, off_by_six, six
from rosorin_compile.source.xml.elements import tree_of

from .format import ANGLES, Fact, Facts, Value

if TYPE_CHECKING:
    from xml.etree.ElementTree import Element

    from .expectation import Expectation

    Made = TypeVar("Made")

AXES = ("x", "y", "z")
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
NO_TOLERANCE: Vector = (0.0, 0.0, 0.0)

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
    turn_tolerance: float = 0.0

    @property
    def box(self) -> Box | None:
        """The solid as a box whose edges are along the axes of its link; None if it is no such box."""
        if self.kind != "box" or self.rows != _UPRIGHT or len(self.sizes) != 3:
            return None
        x, y, z = self.centre
        a, b, c = (size / 2 for size in self.sizes)
        return Box((x - a, y - b, z - c), (x + a, y + b, z + c))


def parse(text: str, tag: str) -> Element:
    """Return the root element of an XML text. Raises ValueError if it is damaged or its root is not ``tag``."""
    root = _tree(text)
    if root.tag != tag:
        raise ValueError(f"the root element is {root.tag}, not {tag}")
    return root


# White space between elements: it says nothing, and is a third of the time and a quarter of the memory of a tree.
_BETWEEN = re.compile(">\n *<")


def _tree(text: str) -> Element:
    if "<![CDATA[" not in text:
        try:
            return tree_of(_BETWEEN.sub("><", text))
        except ValueError:
            pass  # it is said again with the line and the column in the text as it is
    return tree_of(text)


def number_of(text: str) -> float:
    """Return a number of an attribute. Raises ValueError if it is none or not finite."""
    value = float(text)
    if "_" in text or not math.isfinite(value):
        raise ValueError(f"not a number: {text}")
    return value


@remembered
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


def is_six(texts: Iterable[str]) -> bool:
    """Say whether an artifact was printed with number_format six, which would shorten none of its numbers."""
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
                return False
    return True


# Facts about one thing, by their quantity.
Block = Mapping[str, Value]


class Deviations(NamedTuple):
    """An artifact held against what is known: the facts that are said otherwise, and what is left to be compared.

    ``parents`` are those of all frames, ``solids`` the collision shapes by link, ``names`` all links that it has.
    ``data`` is what its schema is about, if it was read for this.
    """

    facts: Facts
    parents: Mapping[str, str]
    solids: Mapping[str, Sequence[Solid]]
    names: frozenset[str]
    data: object = None


class Sheet:
    """Collects the facts of an artifact; with what is ``known`` only those that are otherwise, and solids.

    What is read is the same, and as much is refused: what is known is only not written down.
    """

    def __init__(self, known: Expectation | None = None) -> None:
        self.facts: Facts = {}
        self.known = known
        self._parents: dict[str, str] = {}
        self._solids: dict[str, list[Solid]] = {}
        self._names: set[str] = set()
        self._once: dict[Hashable, Any] = {}
        self._same: set[tuple[int, int]] = set()

    def deviations(self, data: object = None) -> Deviations:
        """Return what was found that is not known; ``data`` is what a schema is about."""
        names = frozenset(self._names.union(self._parents.values()))
        return Deviations(self.facts, self._parents, self._solids, names, data)

    def take(self, kind: str, name: str, quantity: str, value: Value) -> None:
        """Take down a fact."""
        if self.known is None or self.is_news(self.known, kind, name, quantity, value[0]):
            self.facts[Fact(kind, name, quantity)] = value

    def is_news(self, known: Expectation, kind: str, name: str, quantity: str, value: float | str) -> bool:
        """Say whether something is known of what a fact says, and not that; what nothing is known of is no news."""
        if kind in _OF_LINKS:
            self._names.add(name)
        if kind == "link" and quantity not in _OF_MASSES:
            return False
        meant = known.block(kind, name).get(quantity)
        return meant is not None and meant[0] != value

    def once(self, key: Hashable, make: Callable[[], Made]) -> Made:
        """Return what is made of words that may be said of many things; ``key`` are all of those words."""
        made: Made | None = self._once.get(key)
        if made is None:
            made = self._once[key] = make()
        return made

    def add_joint(self, name: str, child: str, motion: Block) -> None:
        """Take down a joint; ``motion`` is all but its child, the same object where the same is said (``once``)."""
        if self.known is not None and self.known.child(name) in (child, ""):
            meant = self.known.motion(name)
            if (id(motion), id(meant)) in self._same:
                return
            if all(meant[quantity][0] == value[0] for quantity, value in motion.items() if quantity in meant):
                self._same.add((id(motion), id(meant)))
                return
        for number, (quantity, value) in enumerate(motion.items()):
            self.take("joint", name, quantity, value)
            if number == 0:
                self.take("joint", name, "child", Value(child))

    def named(self, link: str) -> str:
        """Return what the robot calls a link of the artifact; the name as it is where no other is known."""
        return link if self.known is None else self.known.names.get(link, link)

    def joint(self, name: str) -> str:
        """Return the name that the robot has for a joint of the artifact, as far as that is known."""
        return name if self.known is None else self.known.joints.get(name, name)

    def add_box(self, link: str, lower: Vector, upper: Vector) -> None:
        """Take down the box that a link collides with, between two corners (m)."""
        if self.known is None:
            for end, corner in (("min", lower), ("max", upper)):
                for axis, value in zip(AXES, corner, strict=True):
                    self.facts[Fact("link", link, f"box {end} {axis}")] = Value(value, "m")
        else:
            self._names.add(link)
            self._solids.setdefault(link, []).append(self.once(("box", lower, upper), lambda: _between(lower, upper)))

    def add_parent(self, child: str, parent: str, which: str = "") -> None:
        """Take down what a frame sits in; ``which`` stands behind the quantity, where a frame has several rows."""
        if self.known is not None:
            self._names.add(child)
            if not which:
                self._parents[child] = parent
            meant = self.known.place(f"{child}{which}")
            if meant is None or meant.parent == parent:
                return
        self.facts[Fact("frame", child, f"parent{which}")] = Value(parent)

    def add_pose(
        self, child: str, pose: Pose, metres: Vector = NO_TOLERANCE, radians: Vector = NO_TOLERANCE, which: str = ""
    ) -> None:
        """Add the facts of a frame's pose, those of ``frame_facts``; ``which`` as in ``add_parent``."""
        if self.known is not None:
            meant = self.known.place(f"{child}{which}")
            if meant is None or (meant.xyz == pose.xyz and meant.rpy == pose.rpy):
                return
            pairs = zip((*pose.xyz, *pose.rpy), (*meant.xyz, *meant.rpy), (*metres, *radians), strict=True)
            if all(abs(one - other) <= near for one, other, near in pairs):
                return
        for quantity, value in frame_block("", pose, metres, radians).items():
            if quantity != "parent":
                self.facts[Fact("frame", child, f"{quantity}{which}")] = value


class FactSheet(Sheet):
    """Collects the facts of one XML artifact."""

    def __init__(self, text: str, tag: str, known: Expectation | None = None) -> None:
        super().__init__(known)
        self.root = parse(text, tag)
        self.six = is_six(self.numbers_written())
        # How well a printed rotation is known (rad); 4 is more than the largest angle.
        self._turning = ROTATION_ROUNDING + 4 * self.tolerance(4.0)

    def numbers_written(self) -> Iterator[str]:
        """Yield the texts in which numbers stand."""
        return (text for element in self.root.iter() for name, text in element.items() if name != "name")

    def tolerance(self, value: float, largest: float = 0.0) -> float:
        """Return how well a printed value is known, 0 if each digit is there; ``largest`` is that of its vector."""
        return off_by_six(value, largest) if self.six else off_by_short(value, largest)

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

    def value(self, value: float | str, unit: str = "", tolerance: float | None = None) -> Value:
        """Return a value; the tolerance of a number is what was printed of it unless it is given."""
        if isinstance(value, str):
            return Value(value)
        return Value(value, unit, self.tolerance(value) if tolerance is None else tolerance)

    def axis(self, xyz: Vector) -> dict[str, Value]:
        """Return what is said of the direction of a joint, by quantity."""
        largest = _largest(xyz)
        return {
            f"axis {letter}": self.value(value, "", self.tolerance(value, largest))
            for letter, value in zip(AXES, xyz, strict=True)
        }

    def add(self, fact: Fact, value: float | str, unit: str = "", tolerance: float | None = None) -> None:
        """Take down a fact; its value as in ``value``."""
        if self.known is None or self.is_news(self.known, *fact, value):
            self.facts[fact] = self.value(value, unit, tolerance)

    def add_frame(self, link: str, parent: str, transform: Transform) -> None:
        """Take down where a link sits in its parent."""
        known = self.known
        if known is not None:
            self._names.add(link)
            self._parents[link] = parent
            meant = known.place(link)
            near = SHORT * _largest(transform.xyz)
            if meant is None or (meant.parent == parent and _is_at(transform, meant.xyz, meant.rows, near)):
                return
        self.facts[Fact("frame", link, "parent")] = Value(parent)
        largest = _largest(transform.xyz)
        for axis, value in zip(_ORIGIN, transform.xyz, strict=True):
            self.facts[Fact("frame", link, axis)] = self.value(value, "m", self.tolerance(value, largest))
        for angle, value in zip(ANGLES, angles(transform), strict=True):
            self.facts[Fact("frame", link, angle)] = Value(value, "rad", self._turning)

    def add_inertial(self, link: str, mass: float, frame: Transform, inertia: Six) -> None:
        """Take down mass (kg), centre of mass (m), and inertia (kg*m^2; xx yy zz xy xz yz along ``frame``)."""
        along = along_link(inertia, frame)
        if self.known is not None:
            self._names.add(link)
            meant = self.known.mass(link)
            if meant in (None, (mass, frame.xyz, along)) or (meant and _weighs(meant, mass, frame.xyz, along)):
                return
        self.add(Fact("link", link, "mass"), mass, "kg")
        largest = _largest(frame.xyz)
        for axis, value in zip(_CENTRE, frame.xyz, strict=True):
            self.add(Fact("link", link, axis), value, "m", self.tolerance(value, largest))
        rounding, largest = _turned(inertia, 4 * self.tolerance(1.0)), _largest(inertia)
        if frame.rows != _UPRIGHT:
            rounding += largest * ROTATION_ROUNDING + 3 * self.tolerance(largest)
        for name, value in zip(_MOMENTS, along, strict=True):
            tolerance = self.tolerance(value, largest) + rounding
            self.add(Fact("link", link, name), value, "kg*m^2", tolerance)

    def add_shape(self, link: str, shape: str, kind: str, sizes: Sequence[float], transform: Transform) -> None:
        """Take down a shape, such as "collision 3": its kind, where its middle is in the link, its full sizes (m)."""
        if self.known is not None:
            self._names.add(link)
            if not math.isfinite(sum(sizes)):
                raise ValueError(f"{shape} of link {link} has no size")
            if shape.startswith(COLLISION):
                key = ("shape", kind, *sizes, transform.xyz, transform.rows)
                solid = self.once(key, lambda: self._solid(kind, sizes, transform))
                self._solids.setdefault(link, []).append(solid)
            return
        self.add(Fact("link", link, f"{shape} geometry"), kind)
        largest = _largest(transform.xyz)
        for axis, value in zip(AXES, transform.xyz, strict=True):
            tolerance = self.tolerance(value, largest)
            self.add(Fact("link", link, f"{shape} origin {axis}"), value, "m", tolerance)
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
        length = max(_ROOT_THREE * self.tolerance(_largest(transform.xyz)), 2 * self.tolerance(_largest(sizes)))
        return Solid(kind, sizes, transform.xyz, transform.rows, (), length, 3 * self._turning)


def _between(lower: Vector, upper: Vector) -> Solid:
    """Return the box between two corners (m)."""
    box = Box(lower, upper)
    return Solid("box", box.size, box.centre, _UPRIGHT, (), 0.0)


_OF_LINKS = ("frame", "link")
_OF_MASSES = frozenset(("mass", *_CENTRE, *_MOMENTS))


def _is_at(transform: Transform, xyz: Vector, rows: Rows, near: float) -> bool:
    """Say whether a transform is at a place, as far as doubles tell, or ``near`` (m) it, as far as was printed."""
    if transform.xyz == xyz and transform.rows == rows:
        return True
    turned = ROTATION_ROUNDING if near else _NEAR
    pairs = zip(transform.rows, rows, strict=True)
    return _near(transform.xyz, xyz, max(near, _NEAR)) and all(_near(one, other, turned) for one, other in pairs)


def _weighs(meant: tuple[float, Vector, Six], mass: float, centre: Vector, along: Six) -> bool:
    """Say whether mass, centre and moments are those of the model, within the digits of number_format short."""
    pairs = (((meant[0],), (mass,)), (meant[1], centre), (meant[2], along))
    return all(_near(one, other, SHORT * _largest(one)) for one, other in pairs)


def _near(one: Sequence[float], other: Sequence[float], near: float) -> bool:
    return all(abs(a - b) <= near for a, b in zip(one, other, strict=True))


def _largest(values: Sequence[float]) -> float:
    return max(map(abs, values), default=0.0)


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


def frame_facts(
    child: str, parent: str, pose: Pose, metres: Vector = NO_TOLERANCE, radians: Vector = NO_TOLERANCE
) -> Facts:
    """Return where a frame sits in its parent; ``metres`` and ``radians`` are how well its numbers are known.

    Angles are as they were written, if that is the form in which they are compared (see ``angles``).
    """
    block = frame_block(parent, pose, metres, radians)
    return {Fact("frame", child, quantity): value for quantity, value in block.items()}


def frame_block(
    parent: str, pose: Pose, metres: Vector = NO_TOLERANCE, radians: Vector = NO_TOLERANCE
) -> dict[str, Value]:
    """Return the same by quantity."""
    rpy = pose.rpy
    compared = rpy if rpy == (0.0, 0.0, 0.0) else angles(pose.transform())
    if any(abs(one - other) >= ROTATION_ROUNDING for one, other in zip(rpy, compared, strict=True)):
        rpy = compared
        radians = (ROTATION_ROUNDING + 4 * max(radians),) * 3
    block = {"parent": Value(parent)}
    for axis, value, tolerance in zip(_ORIGIN, pose.xyz, metres, strict=True):
        block[axis] = Value(float(value), "m", tolerance)
    for angle, value, tolerance in zip(ANGLES, rpy, radians, strict=True):
        block[angle] = Value(float(value), "rad", tolerance)
    return block


def mass_block(inertial: Inertial) -> dict[str, Value]:
    """Return what is said of the mass of a link, by quantity."""
    mass, centre, moments = mass_of(inertial)
    values = {"mass": Value(float(mass), "kg")}
    values |= {axis: Value(float(v), "m") for axis, v in zip(_CENTRE, centre, strict=True)}
    return values | {name: Value(float(value), "kg*m^2") for name, value in zip(_MOMENTS, moments, strict=True)}


def mass_of(inertial: Inertial) -> tuple[float, Vector, Six]:
    """Return mass (kg), centre of mass (m) and inertia (kg*m^2; xx yy zz xy xz yz along the axes of the link)."""
    six = (inertial.ixx, inertial.iyy, inertial.izz, inertial.ixy, inertial.ixz, inertial.iyz)
    return inertial.mass, inertial.pose.xyz, along_link(six, inertial.pose.transform())


def facts_of(edges: Iterable[Edge]) -> Facts:
    """Return the facts of transforms."""
    facts: Facts = {}
    for edge in edges:
        if edge.pose is not None:
            facts |= frame_facts(edge.child, edge.parent, edge.pose, (5e-8,) * 3, (5e-9,) * 3)
        facts[Fact("frame", edge.child, "publisher")] = Value(edge.publisher.name)
    return facts
