"""What stands beside the bodies: joints that follow others, links that may touch, and named poses."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from rosorin_compile.model.standing import HOME
from rosorin_compile.source.diagnostics import Span
from rosorin_compile.source.tree import Map, Seq
from rosorin_compile.source.xml.markup import Element

from .bodies import STIFF
from .entries import add_constraint
from .reading import (
    BALL,
    FREE,
    HINGE,
    SLIDE,
    Reading,
    numbers,
    plain,
    put,
    put_number,
    put_pose,
    tidy,
    tidy_position,
    transform,
)
from .settings import SETTINGS
from .worded import put_words, value_of

_JOINT = 2  # mjEQ_JOINT
_NEAR = 1e-12  # rad or m: rounding
_NEAR_KEY = 1e-9  # rad or m: of two that are the same but for rounding
_REST = {"solref": [], "solimp": [0.5, 2.0]}  # what MuJoCo has for the numbers that nobody says


def add_equalities(reading: Reading) -> None:
    """Let joints follow others where an equality says so; add the other equalities as constraints."""
    elements = reading.markup.listed("equality")
    nodes, entries = reading.facts["elements"]["equalities"], reading.facts["equalities"]
    if len(elements) != len(entries):
        elements = [reading.markup.named("equality", entry["name"]) or reading.markup.root for entry in entries]
    constraints = Map(reading.markup.root.span)
    for index, (entry, node, element) in enumerate(zip(entries, nodes, elements, strict=True)):
        if not _is_mimic(reading, entry):
            add_constraint(reading, constraints, index, node, element)
            continue
        follower = reading.joint_of[entry["first"]]
        name, mimic = reading.name("constraint", entry["name"], follower, index), _mimic(reading, entry, element)
        if name != follower:
            put(mimic, "name", name)
        put(reading.joints[follower], "mimic", mimic)
    if constraints:
        put(reading.tree, "constraints", constraints)


def _mimic(reading: Reading, entry: Mapping[str, Any], element: Element) -> Map:
    """Return the entry of a joint that follows another."""
    mimic = Map(element.span)
    leader = element.attributes.get("joint2")
    put(mimic, "joint", reading.joint_of[entry["second"]], leader.span if leader else None)
    first, second = (reading.facts["zero"][reading.facts["joints"][entry[at]]["address"]] for at in ("first", "second"))
    factor = tidy(entry["data"][1])
    offset = tidy(entry["data"][0] + first - factor * second)  # MuJoCo counts both from where the file has them
    if factor != 1:
        put_number(mimic, "multiplier", factor, element, "polycoef", 1)
    if offset:
        put_number(mimic, "offset", offset, element, "polycoef", 0)
    for word, usual in STIFF.items():
        values = [tidy(value) for value in entry[word]]
        if tuple(values[: len(usual)]) != usual or values[len(usual) :] != _REST[word]:
            put(mimic, word, numbers(values, element, word))
    return mimic


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
    """Add the keyframes: positions of joints, where the free base is, and what is asked of actuators.

    Joints not named are at zero, and so are those that follow another one. An actuator that is not named is at zero,
    but a servo holds its joint where it is.
    """
    elements = reading.markup.listed("keyframe", "key")
    poses = Map(reading.markup.root.span)
    nodes = reading.facts["elements"]["keys"]
    for number, key in enumerate(reading.facts["keys"]):
        element = elements[number] if number < len(elements) else reading.markup.root
        positions = Map(element.span)
        for index, joint in enumerate(reading.facts["joints"]):
            for name, value in _positions(reading, index, joint, key["qpos"]):
                if value and "mimic" not in reading.joints[name]:
                    put_number(positions, name, value, element)
        if key["name"] == HOME and reading.is_ours and _is_usual(reading, positions):
            continue
        pose = Map(element.span)
        put(pose, "positions", positions)
        if reading.free_base:
            base = Map(element.span)
            put(base, "xyz", numbers([tidy(value) for value in key["qpos"][:3]], element))
            put_pose(base, transform(key["qpos"][:3], key["qpos"][3:7]), element)
            put(pose, "base", base)
        controls = _controls(reading, key, element)
        if controls:
            put(pose, "controls", controls)
        said = {word: text for word, text in (nodes[number] if number < len(nodes) else {}).items() if word != "qpos"}
        if _is_beyond(reading, key["qpos"]):
            said["qpos"] = " ".join(repr(tidy(value)) for value in _whole(reading, key["qpos"]))
        _more(reading, pose, said, element)
        name = reading.name("key", key["name"], f"key_{number}", number)
        put(poses, name, pose, element.span)
    if poses:
        put(reading.tree, "poses", poses)


def _is_beyond(reading: Reading, qpos: list[float]) -> bool:
    """Say whether a keyframe puts something where a pose cannot: a follower off its way, or what floats anywhere."""
    at: dict[str, float] = {}
    for index, joint in enumerate(reading.facts["joints"]):
        at.update(_positions(reading, index, joint, qpos))
        beyond = joint["body"] in reading.motion_of or (joint["type"] == FREE and not reading.free_base)
        beyond = beyond or joint["type"] == BALL
        size = {FREE: 7, BALL: 4}.get(joint["type"], 1)
        place = range(joint["address"], joint["address"] + size)
        if beyond and any(abs(qpos[i] - reading.facts["zero"][i]) > _NEAR for i in place):
            return True
    for name, value in at.items():
        mimic = reading.joints[name].get("mimic")
        if mimic is not None:
            led = mimic.get("multiplier", 1) * at.get(mimic["joint"], 0.0) + mimic.get("offset", 0)
            if abs(led - value) > _NEAR_KEY:
                return True
    return False


def _whole(reading: Reading, qpos: list[float]) -> list[float]:
    """Return the positions of all joints as an MJCF of ours counts them, in the order of the file."""
    made: list[float] = []
    for index, joint in enumerate(reading.facts["joints"]):
        at, kind = joint["address"], joint["type"]
        if joint["body"] in reading.motion_of or kind in (FREE, BALL):
            made += qpos[at : at + {FREE: 7, BALL: 4}.get(kind, 1)]
        else:
            made += [value for _, value in _positions(reading, index, joint, qpos)]
    return made


def _more(reading: Reading, pose: Map, said: Mapping[str, str], element: Element) -> None:
    """Set what the language has no word for; speeds only where the joints have as many as in the file."""
    more = {key: text for key, text in said.items() if key not in ("name", "ctrl")}
    for name in put_words(pose, more, "pose", element):
        reading.lost(f'"{name}" of a key', element.span)


def _controls(reading: Reading, key: Mapping[str, Any], element: Element) -> Map:
    """Return what a keyframe asks of actuators, where that is not what they do by themselves."""
    made = Map(element.span)
    for number, fact in enumerate(reading.facts["actuators"]):
        name = reading.actuator_of.get(number)
        if name is None:
            continue
        asked, usual = key["ctrl"][fact["at"]], 0.0
        held = reading.servos.get(number)
        if held is not None:
            usual = fact["gear"][0] * key["qpos"][reading.facts["joints"][held]["address"]]
        follows = held is not None and "mimic" in reading.joints[reading.joint_of[held]]
        if follows or abs(asked - usual) > _NEAR:
            put_number(made, name, tidy(asked), element)
    return made


def _is_usual(reading: Reading, positions: Mapping[str, float]) -> bool:
    """Say whether positions (rad or m) are those of the key home that a robot without such a pose has."""
    for name, joint in reading.joints.items():
        limit = joint.get("limit") or {}
        lower, upper = limit.get("lower", 0.0), limit.get("upper", 0.0)
        usual = lower if lower > 0.0 else upper if upper < 0.0 else 0.0
        if "mimic" not in joint and abs(positions.get(name, 0.0) - usual) > _NEAR:
            return False
    return True


def _positions(reading: Reading, index: int, joint: Mapping[str, Any], qpos: list[float]) -> list[tuple[str, float]]:
    """Return the positions that a keyframe gives to the joints that carry one of MuJoCo's."""
    at = joint["address"]
    if joint["body"] in reading.motion_of:
        return []
    if joint["type"] in (SLIDE, HINGE):
        return [(reading.joint_of[index], tidy(qpos[at]) if joint["type"] == SLIDE else tidy_position(qpos[at]))]
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
                many = SETTINGS[name]["type"] == "array"
                put(made, name, _listed(values, attribute.span) if many else values[0], attribute.span)
        for flag in reading.markup.children(element):
            for name, attribute in flag.attributes.items() if flag.tag == "flag" else ():
                put(flags, name, attribute.value, attribute.span)
    _attached(reading, made, flags)
    if flags:
        put(made, "flag", flags)
    return made


def _attached(reading: Reading, made: Map, flags: Map) -> None:
    """Set the settings that hold though the text of the main file does not say them."""
    root = reading.markup.root
    for name, text in reading.facts["elements"]["options"].items():
        flag = name.removeprefix("flag ")
        if flag != name and flag not in flags:
            put(flags, flag, text)
        elif flag == name and name in SETTINGS and name not in made:
            put(made, name, value_of(text, SETTINGS[name], root, name))
        elif flag == name and name not in SETTINGS:
            reading.lost(f'the setting "{name}"', root.span)


def _number(text: str) -> float | int | None:
    try:
        return plain(float(text))
    except ValueError:
        return None


def _listed(values: Sequence[Any], span: Span) -> Any:
    """Return values as a list."""
    made = Seq(span)
    for value in values:
        made.put(value, span)
    return made
