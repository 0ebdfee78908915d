"""Keyframes become poses, and <option> the settings of the simulation."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from rosorin_compile.mujoco.rest_pose import HOME
from rosorin_compile.source.tree import Map, Seq
from rosorin_compile.source.xml.markup import Element

from .reading import BALL, FREE, HINGE, SLIDE, Reading
from .settings import SETTINGS
from .values import numbers, plain, put, put_number, put_pose, tidy, tidy_position, transform, value_of

_NEAR = 1e-12  # rad or m: rounding
_NEAR_KEY = 1e-9  # rad or m: of two that are the same but for rounding


def add_poses(reading: Reading) -> None:
    """Add the keyframes: positions of joints, where the free base is, and the controls of actuators.

    Joints not named are at zero, and so are those that follow another one. An actuator that is not named is at zero,
    but a servo holds its joint where it is.
    """
    elements, nodes = reading.markup.listed("keyframe", "key"), reading.facts["elements"]["keys"]
    poses = Map(reading.markup.root.span)
    for number, key in enumerate(reading.facts["keys"]):
        element = elements[number] if number < len(elements) else reading.markup.root
        positions, pose = Map(element.span), Map(element.span)
        for name, value in _positions(reading, key["qpos"]):
            if value and "mimic" not in reading.joints[name]:
                put_number(positions, name, value, element)
        if key["name"] == HOME and reading.is_ours and _is_usual(reading, positions):
            if len(reading.facts["keys"]) > 1:  # simulators begin at the first key: the order of keys matters
                put(poses, HOME, pose)
            continue
        put(pose, "positions", positions)
        if reading.free_base:
            base = Map(element.span)
            put(base, "xyz", numbers([tidy(value) for value in key["qpos"][:3]], element))
            put_pose(base, transform(key["qpos"][:3], key["qpos"][3:7]), element)
            put(pose, "base", base)
        controls = _controls(reading, key, element)
        if controls:
            put(pose, "controls", controls)
        attributes = nodes[number] if number < len(nodes) else {}
        more = {word: text for word, text in attributes.items() if word not in ("name", "ctrl", "qpos")}
        if _is_beyond(reading, key["qpos"]):
            more["qpos"] = " ".join(repr(tidy(value)) for value in _all_positions(reading, key["qpos"]))
        reading.put_words(pose, more, "pose", element, "a key")
        put(poses, reading.name("key", key["name"], f"key_{number}", number), pose, element.span)
    if poses:
        put(reading.tree, "poses", poses)


def _positions(reading: Reading, qpos: list[float]) -> Iterator[tuple[str, float]]:
    """Yield the positions that a keyframe gives to hinges and slides."""
    for index, name in sorted(reading.joint_of.items()):
        joint = reading.facts["joints"][index]
        at = qpos[joint["address"]]
        yield name, tidy(at) if joint["type"] == SLIDE else tidy_position(at)


def _is_beyond(reading: Reading, qpos: list[float]) -> bool:
    """Return True if a keyframe has what a pose cannot have: a follower off its way, or a place of what floats."""
    for joint in reading.facts["joints"]:
        floats = joint["body"] in reading.motion_of or (joint["type"] == FREE and not reading.free_base)
        place = range(joint["address"], joint["address"] + {FREE: 7, BALL: 4}.get(joint["type"], 1))
        if (floats or joint["type"] == BALL) and any(abs(qpos[i] - reading.facts["zero"][i]) > _NEAR for i in place):
            return True
    at = dict(_positions(reading, qpos))
    for name, value in at.items():
        mimic = reading.joints[name].get("mimic")
        if mimic is not None:
            follows = mimic.get("multiplier", 1) * at.get(mimic["joint"], 0.0) + mimic.get("offset", 0)
            if abs(follows - value) > _NEAR_KEY:
                return True
    return False


def _all_positions(reading: Reading, qpos: list[float]) -> list[float]:
    """Return the positions of all joints as an MJCF of ours counts them, in the order of the file."""
    positions: list[float] = []
    for joint in reading.facts["joints"]:
        at, kind = joint["address"], joint["type"]
        if joint["body"] in reading.motion_of or kind in (FREE, BALL):
            positions += qpos[at : at + {FREE: 7, BALL: 4}.get(kind, 1)]
        else:
            positions.append(tidy_position(qpos[at]) if kind == HINGE else tidy(qpos[at]))
    return positions


def _controls(reading: Reading, key: Mapping[str, Any], element: Element) -> Map:
    """Return the controls that a keyframe has for actuators, where those are not what a pose implies."""
    controls = Map(element.span)
    for number, name in sorted(reading.actuator_of.items()):
        fact, held = reading.facts["actuators"][number], reading.servos.get(number)
        control, usual = key["ctrl"][fact["at"]], 0.0
        if held is not None:
            usual = fact["gear"][0] * key["qpos"][reading.facts["joints"][held]["address"]]
        follows = held is not None and "mimic" in reading.joints[reading.joint_of[held]]
        if follows or abs(control - usual) > _NEAR:
            put_number(controls, name, tidy(control), element)
    return controls


def _is_usual(reading: Reading, positions: Mapping[str, float]) -> bool:
    """Return True if positions (rad or m) are those of the key home that a robot without such a pose has."""
    for name, joint in reading.joints.items():
        limit = joint.get("limit") or {}
        lower, upper = limit.get("lower", 0.0), limit.get("upper", 0.0)
        usual = lower if lower > 0.0 else upper if upper < 0.0 else 0.0
        if "mimic" not in joint and abs(positions.get(name, 0.0) - usual) > _NEAR:
            return False
    return True


def settings(reading: Reading) -> Map:
    """Return the settings of the simulation that the file has, and the integrator, which it has in any case."""
    options, flags = Map(reading.markup.root.span), Map(reading.markup.root.span)
    put(options, "integrator", reading.facts["integrator"])
    for element in reading.markup.sections("option"):
        for name, attribute in element.attributes.items():
            values = [_number(word.text) for word in attribute.words()]
            if name not in SETTINGS or name in ("integrator", "flag"):
                continue
            if "enum" in SETTINGS[name]:
                put(options, name, attribute.value, attribute.span)
            elif values and None not in values:
                listed = Seq(attribute.span)
                for value in values:
                    listed.put(value, attribute.span)
                put(options, name, listed if SETTINGS[name]["type"] == "array" else values[0], attribute.span)
        for flag in reading.markup.children(element):
            for name, attribute in flag.attributes.items() if flag.tag == "flag" else ():
                put(flags, name, attribute.value, attribute.span)
    root = reading.markup.root
    for name, text in reading.facts["elements"]["options"].items():  # also those of attached models
        flag = name.removeprefix("flag ")
        if flag != name and flag not in flags:
            put(flags, flag, text)
        elif flag == name and name in SETTINGS and name not in options:
            put(options, name, value_of(text, SETTINGS[name], root, name))
        elif flag == name and name not in SETTINGS:
            reading.lost(f'the setting "{name}"', root.span)
    if flags:
        put(options, "flag", flags)
    return options


def _number(text: str) -> float | int | None:
    try:
        return plain(float(text))
    except ValueError:
        return None
