"""Parameters of a controller held against what the robot knows, be they of a description or of a file.

What is known of its type is in ``parameters`` beside this folder.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Iterator, Mapping
from typing import Any

from rosorin_compile.model import Robot
from rosorin_compile.ros.sections.control.hardware import JOINT_WORDS, POSITION, VELOCITY
from rosorin_compile.source.diagnostics import WARNING, Suggestion, listed, nearest, quoted

from ..parameters.checking import Finding
from ..parameters.tables import Kind
from .derived import COMMANDS, Derived
from .types import SHORT

_TOLERANCE = 0.005  # of a size: people round, and measure wheels that are pressed flat
_LEAST = 0.0005  # m
_JOINTS = re.compile(r"(?:\w+_)?(?:joints?|joint_name|wheels?_names|joints_names|dof_names|state_names)")
_NOT_OF_URDF = ("extra_joints",)
_FRAMES = ("base_frame_id", "frame_id", "odom_frame_id")
_WORLD = ("map", "odom", "world", "earth")
_OF_INTERFACES = (SHORT["joint_trajectory"], SHORT["admittance"])
_SEVERAL_INTERFACES = "forward_command_controller/MultiInterfaceForwardCommandController"
_GRIPPERS = (SHORT["position_gripper"], SHORT["effort_gripper"])
# Drives that measure positions of their wheels unless `position_feedback` is false; others measure velocities.
_BY_POSITION = tuple(
    SHORT[word]
    for word in ("diff_drive", "omni_wheel_drive", "ackermann_steering", "bicycle_steering", "tricycle_steering")
)
_SIZES = ("radius", "separation", "wheelbase", "track", "width", "axis")


def missing(
    name: str, kind: Kind | None, given: Iterable[str], help: Callable[[list[str]], str] | None = None
) -> Iterator[Finding]:
    """Yield the parameters that a controller needs and nobody gives; ``help`` says of them where to give them."""
    if kind is None:
        return
    meant = {nearest(key, kind.like(key)) for key in given if kind.key(key) is None}  # which is told
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
            yield from _same(name, key, value, known.values[key], severity)
    yield from _commanded(name, kind, values, robot)


def frames_of(name: str, values: Mapping[str, Any], robot: Robot) -> Iterator[Finding]:
    """Yield the frames that parameters name and the robot does not have."""
    frames = {*robot.link, *(end for edge in robot.edges for end in (edge.parent, edge.child))}
    for key, value in values.items():
        last = key.rpartition(".")[2]
        there = {*frames, *_WORLD} if last == "odom_frame_id" else frames
        if last in _FRAMES and isinstance(value, str) and value and value.lstrip("/") not in there:
            message = f'"{key}" of {name} names "{value}", which is no frame of the robot'
            help = Suggestion(value, there)
            yield Finding("controller-name", message, key, help, unknown=value, known=there)


def _texts(value: Any) -> list[str]:
    values = value if isinstance(value, (list, tuple)) else [value]
    return [one for one in values if isinstance(one, str) and one]


def _joints_of(name: str, key: str, value: Any, robot: Robot) -> Iterator[Finding]:
    if "." in key or not _JOINTS.fullmatch(key) or key in _NOT_OF_URDF:
        return
    moving = {joint.name for joint in robot.joints if not joint.is_fixed}
    controllers = {controller.name for controller in robot.controllers}
    for one in _texts(value):
        before, slash, joint = one.rpartition("/")
        if slash and joint in moving and (before in controllers or not controllers):
            continue  # it stands behind a controller of the chain
        if one not in moving:
            what = "a fixed joint" if one in robot.joint else "which is no joint of the robot"
            message, help = f'"{key}" of {name} names "{one}", {what}', Suggestion(one, moving)
            yield Finding("controller-name", message, key, help, unknown=one, known=moving)


def _same(name: str, key: str, value: Any, wanted: Any, severity: str) -> Iterator[Finding]:
    if _JOINTS.fullmatch(key):
        if (sorted(value) if isinstance(value, (list, tuple)) else value) == (
            sorted(wanted) if isinstance(wanted, list) else wanted
        ) or key in ("joints", "joint"):
            return
        message = f'"{key}" of {name} is {_names(value)}, and the drive says {_names(wanted)}'
        yield Finding("controller-differs", message, key, "correct one of the two", severity)
    elif _is_size(key) and isinstance(value, (int, float)) and isinstance(wanted, float):
        if abs(value - wanted) <= max(_LEAST, _TOLERANCE * abs(wanted)):
            return
        message = f'"{key}" of {name} is {value:.6g}, and the robot says {wanted:.6g}'
        twice = abs(value - 2 * wanted) <= max(_LEAST, _TOLERANCE * abs(wanted))
        half = abs(2 * value - wanted) <= max(_LEAST, _TOLERANCE * abs(wanted))
        help = f"it is {'twice' if twice else 'half'} that: " if twice or half else ""
        help += f"write {wanted:.6g}, or correct the robot"
        yield Finding("controller-differs", message, key, help, severity)


def _is_size(key: str) -> bool:
    last = key.rpartition(".")[2]
    if key.startswith("kinematics.base_frame_offset"):
        return True
    return "multiplier" not in key and last.rpartition("_")[2].lower() in _SIZES


def _names(value: Any) -> str:
    return quoted(map(str, value)) if isinstance(value, (list, tuple)) else f'"{value}"'


def claims(kind: str, values: Mapping[str, Any]) -> Iterator[tuple[str, str, str]]:
    """Yield the commands that a controller of a type claims while it is active: joint, command, and the key of it.

    What stands behind another controller, as ``pid/wheel``, is claimed of that.
    """
    for key, joints, words in _wanted(kind, values):
        yield from ((joint, word, key) for joint in joints for word in words if "/" not in joint)


def _commanded(name: str, kind: str, values: Mapping[str, Any], robot: Robot) -> Iterator[Finding]:
    if not robot.control:
        return
    there = {(one.name, word) for block in robot.control for one in block.joints for word in one.commands}
    for key, joints, words in _wanted(kind, values):
        words = [word for word in words if word in JOINT_WORDS]
        lacking = [one for one in joints if one in robot.joint and any((one, word) not in there for word in words)]
        if lacking:
            message = f"{name} commands the {listed(words)} of {quoted(lacking, most=4)}, which no hardware block has"
            help = f"in control: joints: {{{lacking[0]}: {{command: {words[0]}}}}}"
            yield Finding("controller-interface", message, key, help, WARNING)
    states = {(one.name, word) for block in robot.control for one in block.joints for word in one.states}
    for key, joint, word in _states(kind, values):
        if joint in robot.joint and (joint, word) not in states:
            message = f'{name} reads the {word} of "{joint}", which no hardware block has: it does not become active'
            help = f"in control: joints: {{{joint}: {{state: [{word}]}}}}, if the hardware measures it"
            yield Finding("controller-interface", message, key, help, WARNING)
            break
    sensor = values.get("sensor_name")
    named = {one.name for block in robot.control for one in block.sensors}
    if isinstance(sensor, str) and sensor and sensor not in named:
        message = f'"sensor_name" of {name} is "{sensor}", and no hardware block has a sensor of this name'
        suggestion = Suggestion(sensor, named, none=f"in control: sensors: {{{sensor}: {{}}}}")
        yield Finding("controller-interface", message, "sensor_name", suggestion, WARNING)


def _states(kind: str, values: Mapping[str, Any]) -> Iterator[tuple[str, str, str]]:
    if kind in _OF_INTERFACES:
        words = _texts(values.get("state_interfaces"))
        yield from (("state_interfaces", joint, word) for joint in _texts(values.get("joints")) for word in words)
    elif kind in _GRIPPERS:
        yield from (("joint", joint, word) for joint in _texts(values.get("joint")) for word in (POSITION, VELOCITY))
    elif _drives(kind):
        turning = POSITION if values.get("position_feedback", kind in _BY_POSITION) else VELOCITY
        for key, joints, words in _wanted(kind, values):
            yield from ((key, joint, POSITION if words == [POSITION] else turning) for joint in joints)


def _drives(kind: str) -> bool:
    return kind in [SHORT[one] for one in SHORT if "drive" in one or "steering" in one or one == "tricycle"]


def _wanted(kind: str, values: Mapping[str, Any]) -> Iterator[tuple[str, list[str], list[str]]]:
    driving = _drives(kind)
    for key, value in values.items():
        if not _JOINTS.fullmatch(key) or key in _NOT_OF_URDF:
            continue
        joints = list(dict.fromkeys(_texts(value)))
        words: Any = []
        if driving and "state" not in key:
            steers = "steering" in key or (
                key in ("front_wheels_names", "rear_wheels_names")
                and (key == "front_wheels_names") == values.get("front_steering", True)
            )
            words = [POSITION if steers else VELOCITY]
        elif kind in COMMANDS:
            words = [COMMANDS[kind]]
        elif kind == SHORT["forward_command"]:
            words = [values["interface_name"]] if values.get("interface_name") else []
        elif kind == _SEVERAL_INTERFACES and key == "joint":
            words = _texts(values.get("interface_names"))
        elif kind in _OF_INTERFACES and key == ("command_joints" if values.get("command_joints") else "joints"):
            words = _texts(values.get("command_interfaces"))
        elif kind == SHORT["pid"] and key == "dof_names":
            words = [values["command_interface"]] if values.get("command_interface") else []
        if words and joints:
            yield key, joints, [str(word) for word in words]
