"""Joints of URDF as entries of ``joints`` (http://wiki.ros.org/urdf/XML/joint, ros/urdfdom:joint.cpp)."""

from __future__ import annotations

from rosorin_compile.source.diagnostics import did_you_mean
from rosorin_compile.source.rule_registry import READING, Rule
from rosorin_compile.source.tree import Map, Path
from rosorin_compile.source.wording import plural, quoted
from rosorin_compile.source.xml.markup import Element

from .grammar import NUMBERS, TYPES
from .reading import Reading, check_element, named, put
from .values import PLAIN, put_all, put_numbers, put_origin

RULES = (Rule("joint-type", "URDF has no such type of joint.", "Correct it.", READING),)

# The types of joints that have ends, whose numbers have units.
_LIMITED = ("revolute", "prismatic")
# What has no effect on a joint of a type. That of an axis is not told: exporters write one for every joint.
_WITHOUT_EFFECT = {"fixed": ("axis", "limit", "mimic", "dynamics"), "floating": ("axis", "limit")}


def read_joint(element: Element, path: Path, reading: Reading) -> Map:
    """Return the entry of a <joint>."""
    entry = Map(element.span)
    kind = _kind(element, entry, reading)
    reading.magnitudes.types.add(kind)
    for end in ("parent", "child"):
        _end(element, end, entry, path, reading)
    put_origin(entry, element, path, reading)
    position = TYPES[kind] if kind in _LIMITED else PLAIN
    for part, read in _READERS.items():
        inner = reading.single(element, part)
        if inner is None:
            continue
        reading.paths[id(inner)] = (*path, part)
        if part in _WITHOUT_EFFECT.get(kind, ()):
            if part != "axis":
                reading.ignored(f"<{part}> of a {kind} joint has no effect", inner.span)
            continue
        read(inner, entry, position, reading)
    if kind in _LIMITED and "limit" not in entry and reading.single(element, "limit") is None:
        _no_limit(element, kind, reading)
    check_element(element, reading, entry)
    return entry


def _kind(element: Element, entry: Map, reading: Reading) -> str:
    kind = reading.attribute(element, "type")
    if kind is None:
        return ""
    attribute = element.attributes["type"]
    if kind not in TYPES:
        message = f'{named(element)} is of type "{kind}", which URDF does not have'
        help = did_you_mean(kind, TYPES)
        reading.error("joint-type", message, attribute.span, help.replace("known:", "it has"))
        return ""
    entry.put("type", kind, attribute.name_span, attribute.span)
    return kind


def _end(element: Element, end: str, entry: Map, path: Path, reading: Reading) -> None:
    """Set parent or child."""
    inner = reading.single(element, end)
    if inner is None:
        reading.error("missing-element", f"{named(element)} has no <{end}>", element.span, f'add <{end} link="..."/>')
        return
    check_element(inner, reading)
    reading.paths[id(inner)] = (*path, end)
    link = reading.attribute(inner, "link")
    if link is not None:
        attribute = inner.attributes["link"]
        entry.put(end, link, attribute.name_span, attribute.span)
        if not link:
            reading.error("missing-attribute", f"link of {named(inner)} is empty", attribute.span, "name a link")


def _no_limit(element: Element, kind: str, reading: Reading) -> None:
    message = f"{named(element)} is {kind} and has no <limit>"
    help = 'add <limit lower="" upper="" effort="" velocity=""/>'
    if kind == "revolute":
        help += ", or make it continuous"
    reading.lenient("limit-missing", message, element.span, help, "takes it without")


def _axis(element: Element, joint: Map, _: str, reading: Reading) -> None:
    check_element(element, reading)
    if reading.attribute(element, "xyz") is None:
        return
    attribute = element.attributes["xyz"]
    put_numbers(joint, element, "xyz", reading, "axis")
    if "axis" in joint:
        joint.key_spans["axis"], joint.value_spans["axis"] = element.span, attribute.span


def _limit(element: Element, joint: Map, position: str, reading: Reading) -> None:
    """Set the limit; what is left out of lower and upper is 0, as readers take it."""
    entry = Map(element.span)
    check_element(element, reading)
    for name in NUMBERS["limit"]:
        put_numbers(entry, element, name, reading, position=position)
        if position and name in ("lower", "upper") and name not in element.attributes:
            entry.put(name, 0, element.span, element.span)
    missing = [name for name in ("effort", "velocity") if name not in element.attributes]
    if missing:
        message = f"{named(element)} lacks the {plural('attribute', len(missing))} {quoted(missing)}"
        help = "add them, the largest torque or force and the largest speed: readers of URDF refuse a limit without"
        reading.lenient("limit-incomplete", message, element.span, help, "takes it without")
    put(joint, "limit", entry, element)


def _mimic(element: Element, joint: Map, position: str, reading: Reading) -> None:
    entry = Map(element.span)
    check_element(element, reading)
    leader = reading.attribute(element, "joint")
    if leader is None:
        return
    attribute = element.attributes["joint"]
    if leader and leader not in reading.joints and reading.options.lenient:
        reading.cannot_carry(named(element), element.span, "the joint that it follows is not there")
        return
    entry.put("joint", leader, attribute.name_span, attribute.span)
    if not leader:
        reading.error("missing-attribute", f"joint of {named(element)} is empty", attribute.span, "name a joint")
    put_all(entry, element, reading, position)
    put(joint, "mimic", entry, element)


def _dynamics(element: Element, joint: Map, _: str, reading: Reading) -> None:
    entry = Map(element.span)
    check_element(element, reading)
    put_all(entry, element, reading)
    if not NUMBERS["dynamics"].keys() & element.attributes.keys():
        message = f"{named(element)} has neither damping nor friction"
        help = "add one, or remove the element: urdfdom, the reader of ROS, refuses the joint"
        reading.lenient("missing-attribute", message, element.span, help, "leaves it out")
        return
    put(joint, "dynamics", entry, element)


def _calibration(element: Element, joint: Map, position: str, reading: Reading) -> None:
    entry = Map(element.span)
    check_element(element, reading)
    put_all(entry, element, reading, position)
    if entry:
        put(joint, "calibration", entry, element)
    else:
        reading.ignored("<calibration> without a value has no effect", element.span)


def _safety(element: Element, joint: Map, position: str, reading: Reading) -> None:
    entry = Map(element.span)
    check_element(element, reading)
    put_all(entry, element, reading, position)
    reading.need(element, "k_velocity")
    put(joint, "safety_controller", entry, element)


_READERS = {
    "axis": _axis,
    "limit": _limit,
    "mimic": _mimic,
    "dynamics": _dynamics,
    "calibration": _calibration,
    "safety_controller": _safety,
}
