"""What stands beside the bodies: joints that follow others, links that may touch, and named poses."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from ...diagnostics import Span
from ...diagnostics.wording import counted
from ...frontend.tree import Map, Seq
from ...xml.markup import Element
from . import SETTINGS
from .reading import (
    BALL,
    FREE,
    HINGE,
    SLIDE,
    Names,
    Reading,
    angles_about_xyz,
    numbers,
    plain,
    put,
    put_number,
    tidy,
    tidy_position,
)

_CONNECT, _WELD, _JOINT = range(3)
_SOFT = {"solref": [0.02, 1.0], "solimp": [0.9, 0.95, 0.001, 0.5, 2.0]}  # MuJoCo's own
_NEAR = 1e-9  # rad or m
_EXCLUDED = "excluded from contact in the MJCF"


def add_mimics(reading: Reading) -> None:
    """Let joints follow others where an equality says so; list the other equalities."""
    elements = reading.markup.listed("equality")
    entries = reading.facts["equalities"]
    if len(elements) != len(entries):
        elements = [reading.markup.named("equality", entry["name"]) or reading.markup.root for entry in entries]
    lost: dict[str, list[Element]] = {}
    for entry, element in zip(entries, elements, strict=True):
        if not _is_mimic(reading, entry):
            lost.setdefault(element.tag, []).append(element)
            continue
        joint = reading.joints[reading.joint_of[entry["first"]]]
        mimic = Map(element.span)
        leader = element.attributes.get("joint2")
        put(mimic, "joint", reading.joint_of[entry["second"]], leader.span if leader else None)
        offset, factor = (tidy(value) for value in entry["data"][:2])
        if factor != 1:
            put_number(mimic, "multiplier", factor, element, "polycoef", 1)
        if offset:
            put_number(mimic, "offset", offset, element, "polycoef", 0)
        for word, usual in _SOFT.items():
            values = [tidy(value) for value in entry[word]]
            if values != usual:
                put(mimic, word, numbers(values, element, word))
        put(joint, "mimic", mimic)
    named = [e for entry, e in zip(entries, elements, strict=True) if entry["name"] and e.tag not in lost]
    if named:
        what = "the name of an equality" if len(named) == 1 else f"the names of {len(named)} equalities"
        reading.changed(f"{what}: in ours it is called as the joint that follows", named[0].span)
    for tag, same in lost.items():
        what = f"the equality <{tag}>" if len(same) == 1 else f"{len(same)} equalities <{tag}>"
        help, others = "only a joint that follows one other is known", [element.span for element in same[1:]]
        reading.lost(what, same[0].span, help, len(same) > 1, others)


def _is_mimic(reading: Reading, entry: Mapping[str, Any]) -> bool:
    """Say whether an equality lets one joint follow another in proportion, and neither leads to a circle."""
    if entry["type"] != _JOINT or not entry["active"] or any(entry["data"][2:5]):
        return False
    first, second = entry["first"], entry["second"]
    if first not in reading.joint_of or second not in reading.joint_of:
        return False
    follower = reading.joint_of[first]
    here: str | None = reading.joint_of[second]
    while here is not None and here != follower:
        mimic = reading.joints[here].get("mimic")
        here = mimic["joint"] if mimic else None
    return here is None and "mimic" not in reading.joints[follower]


def add_poses(reading: Reading) -> None:
    """Add the keyframes: positions of the joints that have one and follow no other; joints not named are at zero."""
    elements = reading.markup.listed("keyframe", "key")
    poses, names = Map(reading.markup.root.span), Names()
    for number, key in enumerate(reading.facts["keys"]):
        element = elements[number] if number < len(elements) else reading.markup.root
        positions = Map(element.span)
        for index, joint in enumerate(reading.facts["joints"]):
            for name, value in _positions(reading, index, joint, key["qpos"]):
                if value and "mimic" not in reading.joints[name]:
                    put_number(positions, name, value, element)
        pose = Map(element.span)
        put(pose, "positions", positions)
        put(poses, names.give(key["name"] or f"key_{number}"), pose, element.span)
    if poses:
        put(reading.tree, "poses", poses)


def _positions(reading: Reading, index: int, joint: Mapping[str, Any], qpos: list[float]) -> list[tuple[str, float]]:
    """Return the positions that a keyframe gives to the joints that carry one of MuJoCo's."""
    at = joint["address"]
    if joint["body"] in reading.motion_of:
        return []
    if joint["type"] in (SLIDE, HINGE):
        value = qpos[at] - reading.facts["zero"][at]
        return [(reading.joint_of[index], tidy(value) if joint["type"] == SLIDE else tidy_position(value))]
    if joint["type"] == BALL:
        return list(zip(reading.ball_of[index], angles_about_xyz(qpos[at : at + 4]), strict=True))
    return []


def settings(reading: Reading) -> Map:
    """Return the settings of the simulation that the file names, and the integrator, which it has in any case."""
    made, flags = Map(reading.markup.root.span), Map(reading.markup.root.span)
    put(made, "integrator", reading.facts["integrator"])
    for element in reading.markup.sections("option"):
        for name, attribute in element.attributes.items():
            values = [_number(word.text) for word in attribute.words()]
            if name not in SETTINGS or name in ("integrator", "flag"):
                continue
            if "enum" in SETTINGS[name]:
                put(made, name, attribute.value, attribute.span)
            elif values and None not in values:
                put(made, name, _listed(values, attribute.span), attribute.span)
        for flag in reading.markup.children(element):
            for name, attribute in flag.attributes.items() if flag.tag == "flag" else ():
                put(flags, name, attribute.value, attribute.span)
    if flags:
        put(made, "flag", flags)
    return made


def _number(text: str) -> float | int | None:
    try:
        return plain(float(text))
    except ValueError:
        return None


def _listed(values: Sequence[Any], span: Span) -> Any:
    """Return one value as it is, several as a list."""
    if len(values) == 1:
        return values[0]
    made = Seq(span)
    for value in values:
        made.put(value, span)
    return made


def tell_of_controls(reading: Reading) -> None:
    """Say that a keyframe asks its servos for something else than where it puts their joints."""
    elements = reading.markup.listed("keyframe", "key")
    spans = []
    for number, key in enumerate(reading.facts["keys"]):
        actuators = [(at, a) for at, a in enumerate(reading.facts["actuators"]) if a["target"][0] in reading.servos]
        joints = [reading.facts["joints"][actuator["target"][0]] for _, actuator in actuators]
        pairs = zip(actuators, joints, strict=True)
        if any(abs(key["ctrl"][at] - key["qpos"][joint["address"]]) > _NEAR for (at, _), joint in pairs):
            spans.append((elements[number] if number < len(elements) else reading.markup.root).span)
    if spans:
        what = f"the controls of {counted(len(spans), 'key')}, which are not where the key puts the joints,"
        reading.lost(what, spans[0], "the servos are asked to hold the pose", True, spans[1:])


def tell_of_free_joints(reading: Reading) -> None:
    """Say that poses do not tell where the robot is, nor what floats or slides in a plane."""
    free = any(joint["type"] == FREE for joint in reading.facts["joints"]) or bool(reading.motion_of)
    if reading.facts["keys"] and free:
        elements = reading.markup.listed("keyframe", "key")
        span = (elements[0] if elements else reading.markup.root).span
        reading.ignored("where the keyframes put what moves freely: a pose has joints of one position", span)
