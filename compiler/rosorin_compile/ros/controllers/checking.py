"""Parameters of a controller held against what the robot knows, be they of a description or of a file.

What is known of its type is in ``parameters`` and in the table of ports.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Iterator, Mapping
from typing import Any

from rosorin_compile.model import Robot
from rosorin_compile.ros.sections.control.hardware import JOINT_WORDS, POSITION, VELOCITY
from rosorin_compile.source.diagnostics import NOTE, WARNING, Suggestion, listed, nearest, quoted

from ..parameters.checking import Finding
from ..parameters.tables import DISTRIBUTIONS, Kind, plugins
from ..ports import full_type, interfaces_of, short_words
from .derived import Derived

_TOLERANCE = 0.005  # of a size: people round, and measure wheels that are pressed flat
_LEAST = 0.0005  # m
_JOINTS = re.compile(
    r"(?!extra_joints)(?:\w+_)?(?:joints?|joint_name|wheels?_names|joints_names|dof_names|state_names)"
)
_FRAMES = ("base_frame_id", "frame_id", "odom_frame_id")
_WORLD = ("map", "odom", "world", "earth")
_SIZES = ("radius", "separation", "wheelbase", "track", "width", "axis")


def of_type(name: str, kind: str, distribution: str) -> Finding | None:
    """Return what is wrong with the type of a controller in a distribution, any of them if it is empty."""
    known, every, plugin = plugins(distribution), plugins(""), full_type(kind)
    if plugin in known:
        return None
    message = f'the controller "{name}" is of type "{kind}"'
    if plugin in every:
        others = listed(one.capitalize() for one in DISTRIBUTIONS if plugin in plugins(one))
        message += f", which {distribution.capitalize()} does not have; it is one of {others}"
        return Finding("controller-type", message, "type", "take another type, or ask for that distribution")
    words = [*known, *(word for word, of in short_words().items() if of in known)]
    package, packages = kind.partition("/")[0], {*every.values(), *(one.partition("/")[0] for one in every)}
    help = Suggestion(kind, words, instead=f"short words: {', '.join(short_words())}; any other is PACKAGE/CLASS")
    if "/" not in kind or package in packages:
        return Finding("controller-type", f"{message}, which does not exist", "type", help)
    message += ", of a package that is not known: its parameters are not checked"
    meant = nearest(package, packages)  # vendors call theirs after those that they know
    if meant and abs(len(meant) - len(package)) < 2 and nearest(kind, words):
        return Finding("controller-type", message, "type", help, WARNING)
    return Finding("controller-type", message, "type", "", NOTE)


def missing(
    name: str, kind: Kind | None, given: Iterable[str], help: Callable[[list[str]], str] | None = None
) -> Iterator[Finding]:
    """Yield that a controller lacks parameters that it needs; ``help`` makes the help about them."""
    if kind is None:
        return
    meant = {nearest(key, kind.like(key)) for key in given if kind.key(key) is None}  # misspelt, and reported
    needed = [key.name for key in kind.own() if key.needed and key.name not in given and key.name not in meant]
    if needed:
        message = f"{name} needs {quoted(needed, most=4)}: it does not start"
        yield Finding("controller-missing", message, "", help(needed) if help else f"add {needed[0]}: VALUE")


def against_robot(
    name: str, kind: str, values: Mapping[str, Any], known: Derived, robot: Robot, severity: str
) -> Iterator[Finding]:
    """Yield where parameters of a controller disagree with a robot; ``severity`` is that of other numbers."""
    for key, value in values.items():
        wrong = list(_joints_of(name, key, value, robot))
        yield from wrong
        if not wrong and key in known.values:
            yield from _differing(name, key, value, known.values[key], severity)
    if robot.control:
        yield from _interfaces(name, kind, values, robot)


def frames_of(name: str, values: Mapping[str, Any], robot: Robot) -> Iterator[Finding]:
    """Yield the frames that parameters name and the robot does not have."""
    frames = {*robot.link, *(end for edge in robot.edges for end in (edge.parent, edge.child))}
    for key, value in values.items():
        last = key.rpartition(".")[2]
        there = {*frames, *_WORLD} if last == "odom_frame_id" else frames
        if last in _FRAMES and isinstance(value, str) and value and value.lstrip("/") not in there:
            message = f'"{key}" of {name} names "{value}", which is no frame of the robot'
            yield Finding("controller-name", message, key, Suggestion(value, there), unknown=value, known=there)


def _texts(value: Any) -> list[str]:
    values = value if isinstance(value, (list, tuple)) else [value]
    return [one for one in values if isinstance(one, str) and one]


def _joints_of(name: str, key: str, value: Any, robot: Robot) -> Iterator[Finding]:
    moving = {joint.name for joint in robot.joints if not joint.is_fixed}
    controllers = {controller.name for controller in robot.controllers}
    for one in _texts(value) if _JOINTS.fullmatch(key) else ():
        before, slash, joint = one.rpartition("/")
        if slash and joint in moving and (before in controllers or not controllers):
            continue  # a controller of the chain claims it
        if one not in moving:
            what = "a fixed joint" if one in robot.joint else "which is no joint of the robot"
            message, help = f'"{key}" of {name} names "{one}", {what}', Suggestion(one, moving)
            yield Finding("controller-name", message, key, help, unknown=one, known=moving)


def _differing(name: str, key: str, value: Any, wanted: Any, severity: str) -> Iterator[Finding]:
    last = key.rpartition(".")[2]
    is_size = "multiplier" not in key and last.rpartition("_")[2].lower() in _SIZES
    if _JOINTS.fullmatch(key):
        same = sorted(_texts(value)) == sorted(_texts(wanted))
        if not same and key not in ("joints", "joint"):
            names = [quoted(map(str, one)) if isinstance(one, (list, tuple)) else f'"{one}"' for one in (value, wanted)]
            message = f'"{key}" of {name} is {names[0]}, and the drive says {names[1]}'
            yield Finding("controller-differs", message, key, "correct one of the two", severity)
    elif (is_size or key.startswith("kinematics.base_frame_offset")) and isinstance(wanted, float):
        allowed = max(_LEAST, _TOLERANCE * abs(wanted))
        if not isinstance(value, (int, float)) or abs(value - wanted) <= allowed:
            return
        message = f'"{key}" of {name} is {value:.6g}, and the robot says {wanted:.6g}'
        help = f"write {wanted:.6g}, or correct the robot"
        yield Finding("controller-differs", message, key, help, severity)


def claims(kind: str, values: Mapping[str, Any]) -> Iterator[tuple[str, str, str]]:
    """Yield the commands that a controller of a type claims while it is active: joint, command, and the key of it.

    An interface of another controller, such as ``pid/wheel``, is claimed from that controller.
    """
    for key, joints, words in _commands(kind, values):
        yield from ((joint, word, key) for joint in joints for word in words if "/" not in joint)


def _commands(kind: str, values: Mapping[str, Any]) -> Iterator[tuple[str, list[str], list[str]]]:
    about = interfaces_of(kind)
    joints_key = about.get("joints", "joints")
    if values.get(about.get("instead", "")):
        joints_key = about["instead"]
    for key, value in values.items():
        if "drive" in about and _JOINTS.fullmatch(key) and "state" not in key:
            front = key.startswith("front_wheels") == values.get("front_steering", True)
            steers = "steering" in key or (key in ("front_wheels_names", "rear_wheels_names") and front)
            words = [POSITION if steers else VELOCITY]
        elif key == joints_key:
            words = _texts(about.get("command")) or _texts(values.get(about.get("commands", "")))
        else:
            continue
        if words and (joints := list(dict.fromkeys(_texts(value)))):
            yield key, joints, words


def _states(kind: str, values: Mapping[str, Any]) -> Iterator[tuple[str, str, str]]:
    about = interfaces_of(kind)
    if "drive" in about:
        by_position = values.get("position_feedback", about["turning"] == POSITION)
        for key, joints, words in _commands(kind, values):
            word = POSITION if words == [POSITION] or by_position else VELOCITY
            yield from ((key, joint, word) for joint in joints)
    else:
        key = about.get("joints", "joints")
        words = about.get("reads") or _texts(values.get(about.get("states", "")))
        where = about.get("states", key)
        yield from ((where, joint, word) for joint in _texts(values.get(key)) for word in words)


def _interfaces(name: str, kind: str, values: Mapping[str, Any], robot: Robot) -> Iterator[Finding]:
    """Yield the commands, the states and the sensor of a controller that no hardware block has."""
    joints = [one for block in robot.control for one in block.joints]
    there = {(one.name, word) for one in joints for word in one.commands}
    for key, names, every in _commands(kind, values):
        words = [word for word in every if word in JOINT_WORDS]
        lacking = [one for one in names if one in robot.joint and any((one, word) not in there for word in words)]
        if lacking:
            message = f"{name} commands the {listed(words)} of {quoted(lacking, most=4)}, which no hardware block has"
            help = f"in control: joints: {{{lacking[0]}: {{command: {words[0]}}}}}"
            yield Finding("controller-interface", message, key, help, WARNING)
    states = {(one.name, word) for one in joints for word in one.states}
    for key, joint, word in _states(kind, values):
        if joint in robot.joint and (joint, word) not in states:
            message = f'{name} reads the {word} of "{joint}", which no hardware block has: it does not become active'
            help = f"in control: joints: {{{joint}: {{state: [{word}]}}}}, if the hardware measures it"
            yield Finding("controller-interface", message, key, help, WARNING)
            break
    sensors = {one.name for block in robot.control for one in block.sensors}
    for sensor in _texts(values.get("sensor_name")):
        if sensor not in sensors:
            message = f'"sensor_name" of {name} is "{sensor}", and no hardware block has a sensor of this name'
            help_ = Suggestion(sensor, sensors, none=f"in control: sensors: {{{sensor}: {{}}}}")
            yield Finding("controller-interface", message, "sensor_name", help_, WARNING)
