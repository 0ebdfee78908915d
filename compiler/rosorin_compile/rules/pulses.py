"""Servo pulses of a robot and the positions that they set."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal

from rosorin_compile.model import Robot
from rosorin_compile.model.servos import ServoGroup, nearest, position_of, servo_of, within
from rosorin_compile.source.diagnostics import RequestError

from .joint_states import pose_of, position, whole


@dataclass(frozen=True)
class Servos:
    """Servos with the same calibration: position = (pulse - zero) * rad_per_pulse, negated if ``flipped``.

    ``rad_per_pulse`` is metres for a sliding joint. ``pulse_range`` has the smallest and largest valid pulse.
    """

    name: str
    joints: tuple[str, ...]
    rad_per_pulse: float
    zero: int
    flipped: bool
    pulse_range: tuple[int, int]


@dataclass(frozen=True)
class JointPulse:
    """A pulse of a joint, and the position that it sets, in ``unit``.

    ``asked`` is the requested position and ``off`` its difference; both are None if a pulse was requested. ``degrees``
    is None for a sliding joint.
    """

    joint: str
    servos: str
    pulse: int
    position: float
    unit: Literal["rad", "m"]
    degrees: float | None
    asked: float | None
    off: float | None
    pulses_within_limits: tuple[int, int] | None


def servos(robot: Robot) -> tuple[ServoGroup, ...]:
    """Return the servo groups of a robot. Raises RequestError if it has none."""
    groups: tuple[ServoGroup, ...] = robot.servos
    if not groups:
        raise RequestError(f'the robot "{robot.name}" has no servos')
    return groups


def summary(group: ServoGroup) -> Servos:
    """Return the calibration of a group."""
    low, high = group.pulse_range
    return Servos(group.name, tuple(group.joints), group.rad_per_pulse, group.zero_pulse, group.flipped, (low, high))


def joint_pulses(robot: Robot, values: Mapping[str, object], pose: str = "", unit: str = "") -> list[JointPulse]:
    """Return the pulses of a named pose, then of values by joint: whole numbers are pulses, texts may have units.

    Numbers without a unit are positions in rad or m with ``unit`` "rad", in degrees or m with "deg". Raises
    RequestError for an invalid value, and NoPulse for a pulse that does not exist.
    """
    made: dict[str, JointPulse] = {}
    if pose:
        positions = pose_of(robot, pose)
        pulses = next(one.pulses for one in robot.poses if one.name == pose)
        for name in (name for group in servos(robot) for name in group.joints if name in positions):
            if name in pulses:
                made[name] = _of_pulse(robot, name, pulses[name])
            else:
                made[name] = _of_position(robot, name, positions[name])
        if not made:
            raise RequestError(f'no joint of the pose "{pose}" has a servo')
    for name, value in values.items():
        made[name] = _of_value(robot, name, str(value), unit)
    return list(made.values())


def _of_value(robot: Robot, name: str, text: str, unit: str) -> JointPulse:
    servo_of(robot, name)
    joint = robot.joint[name]
    if not _is_number(text):
        return _of_position(robot, name, position(joint, text))
    if unit == "deg" and joint.type != "prismatic":
        return _of_position(robot, name, position(joint, f"{text} deg"))
    return _of_position(robot, name, position(joint, text)) if unit else _of_pulse(robot, name, whole(text))


def _is_number(text: str) -> bool:
    try:
        float(text)
    except ValueError:
        return False
    return True


def _of_pulse(robot: Robot, name: str, pulse: int) -> JointPulse:
    return _row(robot, name, pulse, position_of(servo_of(robot, name), pulse, name))


def _of_position(robot: Robot, name: str, asked: float) -> JointPulse:
    found = nearest(servo_of(robot, name), asked, name)
    return _row(robot, name, found.pulse, found.position, asked)


def _row(robot: Robot, name: str, pulse: int, position: float, asked: float | None = None) -> JointPulse:
    joint, group = robot.joint[name], servo_of(robot, name)
    slides = joint.type == "prismatic"
    return JointPulse(
        name,
        group.name,
        pulse,
        position,
        "m" if slides else "rad",
        None if slides else math.degrees(position),
        asked,
        None if asked is None else position - asked,
        within(group, joint.limit),
    )
