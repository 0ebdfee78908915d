"""Parameters of a controller held against what the robot knows, be they of a description or of a file.

What is known of its type is in ``parameters`` beside this folder.
"""

from __future__ import annotations

import re
from collections.abc import Collection, Container, Iterable, Iterator, Mapping
from typing import Any

from ...diagnostics import WARNING, did_you_mean
from ...diagnostics.registry import CONTROL, Rule
from ...diagnostics.wording import listed, quoted
from ...model import Robot
from ...model.control import JOINT_WORDS, POSITION, VELOCITY
from ..parameters.checking import Finding
from ..parameters.tables import Kind
from .known import COMMANDS, Known
from .types import SHORT

RULES = (
    Rule(
        "controller-missing",
        "A controller needs a parameter that nobody gives it.",
        "Give it; or say in the description what it follows from: `drive`, `sensors`, `control`.",
        CONTROL,
    ),
    Rule(
        "controller-name",
        "A controller names a joint, a frame or a sensor that the robot does not have.",
        "Correct the name.",
        CONTROL,
    ),
    Rule(
        "controller-differs",
        "A controller is told something else than the robot says: the radius of a wheel, the distance between two, "
        "which is on the left. A warning in a description.",
        "Correct one of the two; what is left out of a description is filled in.",
        CONTROL,
    ),
    Rule(
        "controller-interface",
        "A warning: a controller commands what no hardware block has.",
        "Give the joint this command in `control`, or name another joint.",
        CONTROL,
    ),
)

_TOLERANCE = 0.005  # of a size: people round, and measure wheels that are pressed flat
_LEAST = 0.0005  # m
_JOINTS = re.compile(r"(?:\w+_)?(?:joints?|joint_name|wheels?_names|joints_names|dof_names|state_names)")
_NOT_OF_URDF = ("extra_joints",)
_FRAMES = ("base_frame_id", "frame_id", "odom_frame_id")
_WORLD = ("map", "odom", "world", "earth")
_SIZES = ("radius", "separation", "wheelbase", "track", "width", "axis")


def missing(name: str, kind: Kind | None, given: Container[str], why: str) -> Iterator[Finding]:
    """Yield the parameters that a controller needs and nobody gives; ``why`` the robot does not know them."""
    needed = [key.name for key in kind.own() if key.needed and key.name not in given] if kind else []
    if needed:
        message = f"{name} needs {quoted(needed, most=4)}"
        help = f"{why}; give it in params" if why else f"params: {{{needed[0]}: ...}}"
        yield Finding("controller-missing", message, "", help)


def against_robot(
    name: str, kind: str, values: Mapping[str, Any], known: Known, robot: Robot, severity: str
) -> Iterator[Finding]:
    """Yield where parameters of a controller disagree with a robot; ``severity`` is that of other numbers."""
    for key, value in values.items():
        last = key.rpartition(".")[2]
        texts = [value] if isinstance(value, str) else value if isinstance(value, (list, tuple)) else []
        unknown = list(_not_there(robot, key, last, [one for one in texts if isinstance(one, str) and one]))
        for what, one, of in unknown:
            message = f'"{key}" of {name} names "{one}", which is no {what} of the robot'
            yield Finding("controller-name", message, key, did_you_mean(one, of))
        if not unknown and key in known.values:
            yield from _same(name, key, value, known.values[key], severity)
    yield from _commanded(name, kind, values, robot)


def _not_there(robot: Robot, key: str, last: str, texts: Iterable[str]) -> Iterator[tuple[str, str, Collection[str]]]:
    """Yield the names in a parameter that the robot does not have: what each should be, it, and those there are."""
    if last in _FRAMES:
        frames = {*robot.link, *(name for edge in robot.edges for name in (edge.parent, edge.child))}
        frames |= set(_WORLD) if last == "odom_frame_id" else set()
        yield from (("frame", one, frames) for one in texts if one.lstrip("/") not in frames)
    elif "." not in key and _JOINTS.fullmatch(last) and last not in _NOT_OF_URDF:
        yield from (("joint", one, robot.joint) for one in texts if one not in robot.joint)


def _same(name: str, key: str, value: Any, wanted: Any, severity: str) -> Iterator[Finding]:
    """Yield what a parameter says otherwise than the robot: a size, or which joint it is."""
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


def _commanded(name: str, kind: str, values: Mapping[str, Any], robot: Robot) -> Iterator[Finding]:
    """Yield the commands that a controller wants and that no hardware block has, where there are any blocks."""
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
    sensor = values.get("sensor_name")
    named = {one.name for block in robot.control for one in block.sensors}
    if isinstance(sensor, str) and sensor and sensor not in named:
        message = f'"sensor_name" of {name} is "{sensor}", and no hardware block has a sensor of this name'
        help = did_you_mean(sensor, named) if named else f"in control: sensors: {{{sensor}: {{}}}}"
        yield Finding("controller-interface", message, "sensor_name", help, WARNING)


def _wanted(kind: str, values: Mapping[str, Any]) -> Iterator[tuple[str, list[str], list[str]]]:
    """Yield keys that name joints, with the joints, and the commands that a controller wants of each."""
    driving = kind in [SHORT[one] for one in SHORT if "drive" in one or "steering" in one or one == "tricycle"]
    for key, value in values.items():
        if not _JOINTS.fullmatch(key) or key in _NOT_OF_URDF:
            continue
        joints = [value] if isinstance(value, str) else [str(one) for one in dict.fromkeys(value or ())]
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
        elif kind == SHORT["joint_trajectory"] and key == "joints" and not values.get("command_joints"):
            words = values.get("command_interfaces") or []
        if words and joints:
            yield key, joints, [str(word) for word in words]
