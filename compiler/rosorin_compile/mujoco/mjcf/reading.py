"""Reading: what is known while an MJCF is read, and how values get from MuJoCo's terms into the tree.

``Reading`` holds the compiled model, its text, the names that were given, and the tree so far. The functions after it
tell what moves a body as a planar or floating joint does, put values into the tree, and turn MuJoCo's numbers into
those that a person would write: without the noise of its quaternions.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Mapping, Sequence
from typing import Any, NamedTuple

from rosorin_compile.formats.format import cannot_carry
from rosorin_compile.formats.imported import LeftOut
from rosorin_compile.model import Transform, Vector
from rosorin_compile.model.geometry import IDENTITY, Rows
from rosorin_compile.model.geometry import unit as normalized
from rosorin_compile.model.motion import plane_axes
from rosorin_compile.source.diagnostics import NOTE, WARNING, Diagnostic, Span, and_here
from rosorin_compile.source.rule_registry import Heading, Rule
from rosorin_compile.source.tree import Map, Seq
from rosorin_compile.source.xml.markup import Element

from .bodies import COLLISION, SHOWN, SHOWN_WHEEL, WHEEL
from .source import Markup, Places, says, spans_of

RULES = (
    Rule(
        "import-changed",
        "A note: something is carried over, but not as the file says it: under another name, counted from another "
        "zero.",
        topic=Heading.READING,
    ),
    Rule(
        "import-verbatim",
        "A note: the language has no word for something of an MJCF; the description has it as it stands in the file.",
        topic=Heading.READING,
    ),
    Rule(
        "import-stand-in",
        "A note: a limit that the source does not have, and that readers of URDF ask for; a number stands in for it.",
        "Put in what the robot has, and take it out of the `stand_ins` of that limit.",
        Heading.READING,
    ),
    Rule("mjcf-warning", "A warning of MuJoCo's own about the file.", "As MuJoCo says.", Heading.READING),
)


FREE, BALL, SLIDE, HINGE = range(4)


class Kept(NamedTuple):
    """An element that is kept as it is, what it is, its place, and the link that has it, if any."""

    node: Mapping[str, Any]
    tag: str
    span: Span
    link: str


class Reading:
    """One MJCF on its way into a tree.

    ``links`` and ``joints`` are sections of ``tree``. ``link_of`` is the link of each body by its index, 0 being the
    world; the world is a link only if ``ground`` is true. ``joint_of`` is the name of each hinge and slide,
    ``site_of`` the link of a site, ``ball_of`` the name of each ball, and ``motion_of`` the planar or
    floating joint of a body. ``servos`` are the names of the servos that are carried, by joint, in the order of the
    file, and ``stand_ins`` the limits that it does not have: joint, number and place by the key of ``limit``. ``pairs``
    are the elements of pairs of geoms that ours has anyway.
    """

    def __init__(self, markup: Markup, places: Places, facts: Mapping[str, Any]) -> None:
        self.markup = markup
        self.places = places
        self.facts = facts
        self.diagnostics: list[Diagnostic] = []
        self.left_out: list[LeftOut] = []
        self.tree = Map(markup.root.span)
        self.links = Map(markup.root.span)
        self.joints = Map(markup.root.span)
        self.link_names, self.joint_names = Names(), Names()
        self.link_of: dict[int, str] = {}
        self.joint_of: dict[int, str] = {}
        self.material_of: dict[int, str] = {}
        self.site_of: dict[int, str] = {}
        self.ball_of: dict[int, str] = {}
        self.motion_of: dict[int, Motion] = {}
        self.actuators: list[str] = []
        self.actuator_of: dict[int, str] = {}
        self.servos: dict[int, int] = {}
        self.in_order = True
        self.implied_contacts = True
        self.told: set[Element] = set()
        self.groups: dict[str, int] = {}
        self.of_scene: set[tuple[str, str]] = set()
        self.names: dict[str, Names] = {}
        self.renamed: dict[str, dict[str, str]] = {}
        self.given: dict[str, dict[int, str]] = {}
        self.elements: list[Kept] = []
        self.stand_ins: dict[str, list[tuple[str, float, Span]]] = {}
        self.pairs: set[Element] = set()
        self.joints_in: dict[int, list[int]] = {}
        for index, joint in enumerate(facts["joints"]):
            self.joints_in.setdefault(joint["body"], []).append(index)
        self.balls_on = {joint["body"] for joint in facts["joints"] if joint["type"] == BALL}
        self.tops = [index for index, body in enumerate(facts["bodies"]) if index and body["parent"] == 0]
        held = [facts["joints"][at]["type"] for top in self.tops for at in self.joints_in.get(top, ())]
        self.ground = len(self.tops) != 1 or any(kind != FREE for kind in held)
        self.free_base = not self.ground and held == [FREE]
        ours = [f"{facts['name']}_{purpose}" for purpose in (COLLISION, WHEEL, SHOWN, SHOWN_WHEEL)]
        self.is_ours = any(geom["class"] in ours for geom in facts["geoms"])

    def name(self, kind: str, name: str, made_up: str = "", index: int = -1) -> str:
        """Return the name of an object that no other of its kind has: its own, or one that is made up."""
        given = self.names.setdefault(kind, Names()).give(name or made_up)
        if index >= 0:
            self.given.setdefault(kind, {})[index] = given
        if name and given != name:
            self.renamed.setdefault(kind, {})[name] = given
        return given

    def called(self, kind: str, name: str) -> str:
        """Return what an object is called in the description, given its name in the MJCF."""
        return self.renamed.get(kind, {}).get(name) or legal(name)

    def kept(self, node: Mapping[str, Any], tag: str, span: Span, link: str = "") -> None:
        """Keep an element as it is: in the body of a link, or at the top."""
        self.elements.append(Kept(node, tag, span, link))

    def lost(self, what: str, span: Span, help: str = "", many: bool = False, others: Sequence[Span] = ()) -> None:
        """Say that something of the robot is not in the tree; ``many`` if ``what`` is a plural."""
        self.diagnostics.append(cannot_carry(what, span, help, many, others))
        self.left_out.append(LeftOut(what, span))

    def ignored(self, what: str, span: Span) -> None:
        """Say that something was passed over that is no part of the robot."""
        self.diagnostics.append(Diagnostic("import-ignored", NOTE, what, span))

    def kept_as_is(self, what: str, spans: Sequence[Span]) -> None:
        """Say that something is in the tree as it stands in the file, at its first place and at others."""
        self.diagnostics.append(Diagnostic("import-verbatim", NOTE, what, spans[0], and_here(spans[1:])))

    def changed(self, what: str, span: Span) -> None:
        """Say that something is in the tree, but otherwise than the file says it."""
        self.diagnostics.append(Diagnostic("import-changed", NOTE, what, span))

    def stood_in(self, what: str, span: Span) -> None:
        """Say that the tree has a number that the file does not say."""
        self.diagnostics.append(Diagnostic("import-stand-in", NOTE, what, span, (), "put in what the robot really has"))

    def warned(self, what: str, span: Span) -> None:
        """Pass on a warning of MuJoCo's own."""
        self.diagnostics.append(Diagnostic("mjcf-warning", WARNING, what, span))

    def new_link(self, name: str, element: Element) -> Map:
        """Return a new, empty link that stands where ``element`` is."""
        made = Map(element.span)
        own = element.attributes.get("name")
        self.links.put(name, made, own.span if own and own.value == name else element.span, element.span)
        return made

    def new_joint(self, name: str, kind: str, parent: str, child: str, element: Element) -> Map:
        """Return a new joint that stands where ``element`` is."""
        made = Map(element.span)
        own = element.attributes.get("name")
        self.joints.put(name, made, own.span if own and own.value == name else element.span, element.span)
        put(made, "type", kind)
        put(made, "parent", parent)
        put(made, "child", child)
        return made


_SAME = 1e-12
_ENDS = {
    (SLIDE, SLIDE, HINGE): ("planar", ("_TX", "_TY", "_RZ")),
    (SLIDE, SLIDE, SLIDE, BALL): ("floating", ("_TX", "_TY", "_TZ", "_R")),
}
_ALONG: Sequence[Vector] = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))


class Motion(NamedTuple):
    """A joint of several coordinates: its name, its type, and the normal of its plane if it has one."""

    name: str
    kind: str
    axis: Vector | None


def motion_of(reading: Reading, body: int) -> Motion | None:
    """Return the planar or floating joint that the joints of a body are, None if they are none."""
    held = [reading.facts["joints"][at] for at in reading.joints_in.get(body, ())]
    kind, ends = _ENDS.get(tuple(joint["type"] for joint in held), ("", ()))
    if not ends or any(_is_special(reading, joint) for joint in held):
        return None
    name = held[0]["name"].removesuffix(ends[0])
    if not name or [joint["name"] for joint in held] != [name + end for end in ends]:
        return None
    axis = unit(held[-1]["axis"]) if kind == "planar" else None
    along = plane_axes(axis) if axis else _ALONG
    slides = [joint["axis"] for joint in held[:-1]]
    if any(abs(a - b) > _SAME for one, own in zip(slides, along, strict=True) for a, b in zip(one, own, strict=True)):
        return None
    return Motion(name, kind, axis)


def _is_special(reading: Reading, joint: Mapping[str, Any]) -> bool:
    """Say whether a joint has what a planar or floating joint has no word for."""
    facts, dof = reading.facts, joint["dof"]
    if joint["type"] != SLIDE and any(joint["pos"]):
        return True
    shifted = joint["type"] != BALL and facts["zero"][joint["address"]] != 0
    held = any(facts[word][dof] for word in ("damping", "friction", "armature"))
    more = set(joint["element"]["attributes"]) - {"name", "type", "pos", "axis", "range", "group"}
    return bool(shifted or held or more or joint["limited"] or joint["forced"])


_ILLEGAL = re.compile(r"[<>&\"'\s\x00-\x1f\x7f]+")


def numbers(values: Sequence[float], element: Element, attribute: str = "") -> Seq:
    """Return a list of numbers; their places are the digits of the attribute where it says these very values."""
    made = Seq(element.span)
    source = element.attributes.get(attribute)
    for value, span in zip(values, spans_of(source, values, element.span), strict=True):
        made.put(plain(value), span)
    return made


def plain(value: float) -> float | int:
    """Return a whole number as an int, as the description would say it."""
    return int(value) if value == int(value) and abs(value) < 1e15 else value


def put(entry: Map, key: str, value: Any, span: Span | None = None) -> None:
    """Set a key of an entry; the place is that of the entry, unless one is given."""
    place = span or getattr(value, "span", None) or entry.span
    entry.put(key, value, place, place)


def put_number(entry: Map, key: str, value: float, element: Element, attribute: str = "", at: int = 0) -> None:
    """Set a number; its place is the word ``at`` of the attribute where that says this very value."""
    words = element.attributes.get(attribute)
    word = words.words()[at : at + 1] if words else []
    span = word[0].span if word and says(word[0].text, value) else element.span
    entry.put(key, plain(value), element.span, span)


def put_pose(entry: Map, place: Transform, element: Element) -> None:
    """Set xyz and rpy of an entry, where they are not zero."""
    xyz = tidy_vector(place.xyz)
    rpy = rpy_of(place.rows)
    if xyz != IDENTITY.xyz:
        put(entry, "xyz", numbers(xyz, element, "pos"))
    if rpy != IDENTITY.rpy:
        put(entry, "rpy", numbers(rpy, element))


def source(entry: Map, status: str, note: str) -> None:
    """Say where the values of an entry come from."""
    made = Map(entry.span)
    put(made, "status", status)
    put(made, "note", note)
    put(entry, "source", made)


def legal(name: str) -> str:
    """Return a name without what names of the description never have: markup, quotes, outer or other white space."""
    return " ".join(_ILLEGAL.sub("_", word) for word in name.split(" ") if word)


class Names:
    """Names that are given once: those of the file, and plain ones for what has none."""

    def __init__(self) -> None:
        self.taken: set[str] = set()

    def give(self, name: str) -> str:
        """Return the name, or with a number behind it if it is taken."""
        word = legal(name) or "unnamed"
        made, count = word, 1
        while made in self.taken:
            count += 1
            made = f"{word}_{count}"
        self.taken.add(made)
        return made


DEGREE = math.pi / 180
ROUNDING = 1e-15  # of sums and products of numbers near 1
ANGLE_ROUNDING = 1e-12  # rad
NO_POSE = Transform()


def tidy(value: float, zero: float = ROUNDING) -> float:
    """Return the short decimal that a number misses by rounding alone, else the number; below ``zero`` it is 0.

    >>> tidy(0.30000000000000004), tidy(0.1234567890123456), tidy(1e-17), tidy(-0.0)
    (0.3, 0.1234567890123456, 0.0, 0.0)
    """
    if abs(value) < zero or not math.isfinite(value):
        return value if not math.isfinite(value) else 0.0
    for digits in range(1, 14):
        short = float(f"{value:.{digits}g}")
        if abs(short - value) <= ROUNDING * abs(value):
            return short
    return value


def tidy_angle(value: float) -> float:
    """Return an angle (rad), a whole number of degrees exactly where it misses one by rounding; -180 deg is 180 deg.

    >>> tidy_angle(1.5707963267948963) == 90 * DEGREE, tidy_angle(-math.pi) == math.pi
    (True, True)
    """
    degrees = round(value / DEGREE) if math.isfinite(value) else 0
    if degrees and abs(value - degrees * DEGREE) <= ANGLE_ROUNDING:
        return 180 * DEGREE if degrees == -180 else degrees * DEGREE
    return tidy(value, ANGLE_ROUNDING)


def tidy_position(value: float) -> float:
    """Return a position of a joint that turns (rad): as ``tidy_angle``, but -180 deg stays what it is."""
    degrees = round(value / DEGREE) if math.isfinite(value) else 0
    if degrees and abs(value - degrees * DEGREE) <= ANGLE_ROUNDING * max(1.0, abs(degrees) / 180):
        return degrees * DEGREE
    return tidy(value)


def rotation(quaternion: Sequence[float]) -> Rows:
    """Return the rotation matrix, as rows, of a quaternion (w, x, y, z) of any length above zero."""
    return transform(NO_POSE.xyz, quaternion).rows


def transform(pos: Sequence[float], quat: Sequence[float]) -> Transform:
    """Return the transform of a position (m) and a quaternion (w, x, y, z)."""
    x, y, z = pos
    return Transform.of_quaternion((x, y, z), quat)


def shift(offset: Sequence[float]) -> Transform:
    """Return the transform that only moves (m)."""
    x, y, z = offset
    return Transform(xyz=(x, y, z))


def rpy_of(rows: Rows) -> Vector:
    """Return a rotation as fixed-axis roll, pitch, yaw in radians, whole degrees where it misses them by rounding.

    Where pitch is near 90 degrees, roll alone and yaw alone mean little. Yaw is therefore measured after roll was taken
    out, so that all three together are the rotation to the last digit, and roll is 0 where nothing of it can be seen.
    """
    (a, b, c), (d, e, f), (g, h, i) = rows
    horizontal = math.hypot(h, i)
    roll = math.atan2(h, i) if horizontal > ANGLE_ROUNDING else 0.0
    sine, cosine = math.sin(roll), math.cos(roll)
    yaw = math.atan2(c * sine - b * cosine, e * cosine - f * sine)
    pitch = math.atan2(-g, a * math.cos(yaw) + d * math.sin(yaw))
    return (tidy_angle(roll), tidy_angle(pitch), tidy_angle(yaw))


def tidy_vector(values: Iterable[float], zero: float = ROUNDING) -> Vector:
    """Return three numbers freed of rounding."""
    x, y, z = (tidy(value, zero) for value in values)
    return (x, y, z)


def unit(axis: Sequence[float]) -> Vector:
    """Return an axis with length 1; MuJoCo has made it so already, but for rounding."""
    x, y, z = axis
    return tidy_vector(normalized((x, y, z)))


def angles_about_xyz(quaternion: Sequence[float]) -> Vector:
    """Return the turns about x, then the new y, then the new z that make a rotation (rad)."""
    (_, _, c), (d, e, f), (g, h, i) = rotation(quaternion)
    first = math.atan2(-f, i) if math.hypot(f, i) > ANGLE_ROUNDING else 0.0
    sine, cosine = math.sin(first), math.cos(first)
    third = math.atan2(d * cosine + g * sine, e * cosine + h * sine)
    second = math.atan2(c, i * cosine - f * sine)
    return (tidy_angle(first), tidy_angle(second), tidy_angle(third))


def full_inertia(diagonal: Sequence[float], rows: Rows) -> dict[str, float]:
    """Return the moments along the axes of the link of an inertia that is diagonal in the axes of ``rows``."""
    largest = max(map(abs, diagonal))

    def moment(j: int, k: int) -> float:
        return sum(rows[j][n] * diagonal[n] * rows[k][n] for n in range(3))

    cells = {"ixx": (0, 0), "iyy": (1, 1), "izz": (2, 2), "ixy": (0, 1), "ixz": (0, 2), "iyz": (1, 2)}
    return {name: tidy(moment(*cell), ROUNDING * largest) for name, cell in cells.items()}
