"""Joints of URDF as entries of ``joints`` (http://wiki.ros.org/urdf/XML/joint, ros/urdfdom:joint.cpp)."""

from __future__ import annotations

from ...diagnostics import did_you_mean
from ...diagnostics.registry import READING, Rule
from ...diagnostics.wording import plural, quoted
from ...frontend.tree import Map, Path
from ...xml.markup import Element
from .reading import Reading, named, put
from .values import ANGLES, LENGTHS, PLAIN, need_numbers, put_number, put_numbers, put_origin

RULES = (Rule("joint-type", "URDF has no such type of joint.", "Correct it.", READING),)

TYPES = ("revolute", "continuous", "prismatic", "fixed", "floating", "planar")
_PARTS = ("axis", "limit", "mimic", "dynamics", "calibration", "safety_controller")
_WORDS = ("origin", "parent", "child", *_PARTS)
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
    for part in _PARTS:
        inner = reading.single(element, part)
        if inner is None:
            continue
        reading.paths[id(inner)] = (*path, part)
        if part in _WITHOUT_EFFECT.get(kind, ()):
            if part != "axis":
                reading.ignored(f"<{part}> of a {kind} joint has no effect", inner.span)
            continue
        _READERS[part](inner, entry, kind, reading)
    if kind in ("revolute", "prismatic") and "limit" not in entry and reading.single(element, "limit") is None:
        _no_limit(element, kind, reading)
    reading.known(element, _WORDS, ("name", "type"), entry)
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
    reading.known(inner, (), ("link",), None)
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


def _unit(kind: str) -> str:
    return {"revolute": ANGLES, "prismatic": LENGTHS}.get(kind, PLAIN)


def _axis(element: Element, joint: Map, _: str, reading: Reading) -> None:
    reading.known(element, (), ("xyz",), None)
    if reading.attribute(element, "xyz") is None:
        return
    attribute = element.attributes["xyz"]
    put_numbers(joint, "axis", element, "xyz", 3, PLAIN, reading)
    if "axis" in joint:
        joint.key_spans["axis"], joint.value_spans["axis"] = element.span, attribute.span


def _limit(element: Element, joint: Map, kind: str, reading: Reading) -> None:
    """Set the limit; what is left out of lower and upper is 0, as readers take it."""
    entry = Map(element.span)
    reading.known(element, (), ("lower", "upper", "effort", "velocity"), None)
    for name in ("lower", "upper"):
        put_number(entry, name, element, name, _unit(kind), reading)
        if kind in ("revolute", "prismatic") and name not in element.attributes:
            entry.put(name, 0, element.span, element.span)
    missing = [name for name in ("effort", "velocity") if name not in element.attributes]
    for name in ("effort", "velocity"):
        put_number(entry, name, element, name, PLAIN, reading)
    if missing:
        message = f"{named(element)} lacks the {plural('attribute', len(missing))} {quoted(missing)}"
        help = "add them, the largest torque or force and the largest speed: readers of URDF refuse a limit without"
        reading.lenient("limit-incomplete", message, element.span, help, "takes it without")
    put(joint, "limit", entry, element)


def _mimic(element: Element, joint: Map, kind: str, reading: Reading) -> None:
    entry = Map(element.span)
    reading.known(element, (), ("joint", "multiplier", "offset"), None)
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
    put_number(entry, "multiplier", element, "multiplier", PLAIN, reading)
    put_number(entry, "offset", element, "offset", _unit(kind), reading)
    put(joint, "mimic", entry, element)


def _dynamics(element: Element, joint: Map, _: str, reading: Reading) -> None:
    entry = Map(element.span)
    reading.known(element, (), ("damping", "friction"), None)
    for name in ("damping", "friction"):
        put_number(entry, name, element, name, PLAIN, reading)
    if not {"damping", "friction"} & element.attributes.keys():
        message = f"{named(element)} has neither damping nor friction"
        help = "add one, or remove the element: urdfdom, the reader of ROS, refuses the joint"
        reading.lenient("missing-attribute", message, element.span, help, "leaves it out")
        return
    put(joint, "dynamics", entry, element)


def _calibration(element: Element, joint: Map, kind: str, reading: Reading) -> None:
    entry = Map(element.span)
    names = ("rising", "falling", "reference_position")
    reading.known(element, (), names, None)
    for name in names:
        put_number(entry, name, element, name, _unit(kind), reading)
    if entry:
        put(joint, "calibration", entry, element)
    else:
        reading.ignored("<calibration> without a value has no effect", element.span)


def _safety(element: Element, joint: Map, kind: str, reading: Reading) -> None:
    entry = Map(element.span)
    reading.known(element, (), ("soft_lower_limit", "soft_upper_limit", "k_position", "k_velocity"), None)
    for name in ("soft_lower_limit", "soft_upper_limit"):
        put_number(entry, name, element, name, _unit(kind), reading)
    put_number(entry, "k_position", element, "k_position", PLAIN, reading)
    need_numbers(entry, element, ("k_velocity",), PLAIN, reading)
    put(joint, "safety_controller", entry, element)


_READERS = {
    "axis": _axis,
    "limit": _limit,
    "mimic": _mimic,
    "dynamics": _dynamics,
    "calibration": _calibration,
    "safety_controller": _safety,
}
