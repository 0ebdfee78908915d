"""Servo pulses of a robot and the positions that they set."""

from __future__ import annotations

import math
from collections.abc import Mapping
from contextlib import suppress
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
            requested = None if name in pulses else positions[name]
            made[name] = _joint_pulse(robot, name, pulses.get(name), requested)
        if not made:
            raise RequestError(f'no joint of the pose "{pose}" has a servo')
    for name, value in values.items():
        servo_of(robot, name)
        text, is_number = str(value), False
        with suppress(ValueError):
            is_number = math.isnan(float(text)) or True
        joint = robot.joint[name]
        if is_number and not unit:
            made[name] = _joint_pulse(robot, name, whole(text), None)
        else:
            text += " deg" if is_number and unit == "deg" and joint.type != "prismatic" else ""
            made[name] = _joint_pulse(robot, name, None, position(joint, text))
    return list(made.values())


def _joint_pulse(robot: Robot, name: str, pulse: int | None, requested: float | None) -> JointPulse:
    """Return the row of a pulse, or of the pulse nearest to a position."""
    joint, group = robot.joint[name], servo_of(robot, name)
    if pulse is None:
        found = nearest(group, requested or 0.0, name)
        pulse, reached = found.pulse, found.position
    else:
        reached = position_of(group, pulse, name)
    return JointPulse(
        joint=name,
        servos=group.name,
        pulse=pulse,
        position=reached,
        unit="m" if joint.type == "prismatic" else "rad",
        degrees=None if joint.type == "prismatic" else math.degrees(reached),
        asked=requested,
        off=None if requested is None else reached - requested,
        pulses_within_limits=within(group, joint.limit),
    )
