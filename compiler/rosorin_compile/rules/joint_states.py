"""Requested positions of joints: named poses, positions with units, pulses, and sweeps."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from itertools import product
from types import MappingProxyType
from typing import Literal, NamedTuple

from rosorin_compile.language.expression import ExpressionError, evaluate
from rosorin_compile.model import Joint, Robot
from rosorin_compile.model.geometry import quaternion_of, rotation_of_rpy
from rosorin_compile.model.kinematics import Position, Positions, position_of
from rosorin_compile.model.servos import ServoGroup, nearest, servo_of, to_radians, within
from rosorin_compile.source.diagnostics import WARNING, Diagnostic, RequestError, did_you_mean
from rosorin_compile.source.numbers import exact
from rosorin_compile.source.rule_registry import ASKING, Rule
from rosorin_compile.source.units import (
    ANGLE,
    LENGTH,
    NUMBER,
    Dimension,
    Quantity,
    describe,
    dimension_of,
    unknown_unit,
)

from .case import Case

RULES = (Rule("position-beyond-limit", "A requested position is beyond a limit: a warning.", "Change it.", ASKING),)

NOTHING: Mapping[str, object] = MappingProxyType({})
ROUNDING = 1e-6  # positions come from pulses and printed limits: a hair beyond is rounding
MAX_STATES = 100_000
_WHOLE = re.compile(r"[+-]?[0-9]{1,9}")
_NUMBER = re.compile(r"[+-]?([0-9]+\.?[0-9]*|\.[0-9]+)([eE][+-]?[0-9]+)?")
# The numbers of a joint as people write them.
_FORMS: Mapping[str, tuple[tuple[str, ...], ...]] = {
    "planar": (("x", "y", "angle"),),
    "floating": (("x", "y", "z", "roll", "pitch", "yaw"), ("x", "y", "z", "qx", "qy", "qz", "qw")),
    "ball": (("roll", "pitch", "yaw"), ("qx", "qy", "qz", "qw")),
}


class Beyond(NamedTuple):
    """A joint beyond a limit: ``side`` is "lower" or "upper"."""

    joint: Joint
    position: float
    side: str
    limit: float


class Sweep(NamedTuple):
    """A joint that goes from one position to another in equal steps, both ends included."""

    joint: str
    positions: tuple[float, ...]


def pose_of(robot: Robot, name: str) -> dict[str, float]:
    """Return the positions of a named pose. Raises RequestError."""
    try:
        return dict(robot.positions(name))
    except KeyError as problem:
        raise RequestError(str(problem.args[0])) from None


def split(text: str, example: str) -> tuple[str, str]:
    """Return the name and the value of NAME=VALUE. Raises RequestError."""
    name, equals, value = (part.strip() for part in text.partition("="))
    if not equals or not name or not value:
        raise RequestError(f'"{text}" is not {example}')
    return name, value


def free_joint(robot: Robot, name: str) -> Joint:
    """Return the joint of a name, if it has a position of its own that is one number. Raises RequestError."""
    if name not in robot.joint:
        known = [joint.name for joint in robot.joints if joint.moves and joint.mimic is None]
        raise RequestError(f'there is no joint "{name}"; {did_you_mean(name, known) or "none moves"}')
    joint = robot.joint[name]
    if joint.mimic is not None:
        raise RequestError(f'joint "{name}" follows "{joint.mimic.joint}": set that one')
    if not joint.moves:
        why = "it never moves" if joint.type == "fixed" else "its position is not one number"
        raise RequestError(f'joint "{name}" is {joint.type}: {why}')
    return joint


def place(robot: Robot, name: str, text: str) -> Position:
    """Return the position of a joint from its text: several numbers for a planar one. Raises RequestError."""
    joint = robot.joint.get(name)
    if joint is None or joint.type not in _FORMS:
        return position(free_joint(robot, name), text)
    parts = [part.strip() for part in text.split(",")]
    form = next((form for form in _FORMS[joint.type] if len(form) == len(parts)), None)
    if form is None:
        forms = " or ".join(f"{name}={','.join(form)}" for form in _FORMS[joint.type])
        raise RequestError(f'joint "{name}" is {joint.type}: write {forms}')
    kinds = [LENGTH if key in "xyz" else NUMBER if key.startswith("q") else ANGLE for key in form]
    numbers = tuple(_number(joint, part, kind) for part, kind in zip(parts, kinds, strict=True))
    if "roll" in form:
        *xyz, roll, pitch, yaw = numbers
        return (*xyz, *quaternion_of(rotation_of_rpy((roll, pitch, yaw))))
    if "qw" in form and not any(numbers[-4:]):
        raise RequestError(f'the quaternion of joint "{name}" is zero: {text}')
    return numbers


def position(joint: Joint, text: str) -> float:
    """Return a position from its text: a number in SI units, a quantity, an expression. Raises RequestError."""
    return _number(joint, text, ANGLE if joint.type in ("revolute", "continuous") else LENGTH)


def _number(joint: Joint, text: str, expected: Dimension) -> float:
    subject = f'the position of joint "{joint.name}"'
    number: object = Quantity.parse(text)
    if number is None and _NUMBER.fullmatch(text):
        number = float(text)
    elif number is None:
        unit = unknown_unit(text)
        if unit is not None:
            raise RequestError(f'{subject} has an unknown unit: "{unit}"')
        try:
            number = evaluate(text, dict[str, object]().__getitem__)
        except ExpressionError as problem:
            raise RequestError(f"{subject} cannot be read: {text}: {problem.message}") from None
    if isinstance(number, bool) or not isinstance(number, (int, float)):
        raise RequestError(f"{subject} is no number: {text}")
    dimension = dimension_of(number)
    if dimension not in (None, NUMBER, expected):
        what = f"{text} is {describe(dimension)}, not {describe(expected)}"
        raise RequestError(f'joint "{joint.name}" is {joint.type}: {what}')
    if not math.isfinite(number):
        raise RequestError(f"{subject} is not finite: {text}")
    return float(number)


def positions(
    robot: Robot, pose: str = "", joints: Mapping[str, object] = NOTHING, pulses: Mapping[str, object] = NOTHING
) -> dict[str, Position]:
    """Return the positions of a named pose ("" for none), overridden by those of pulses, then by those of joints.

    Positions are numbers in rad or m, or texts such as "30deg". Raises RequestError, and NoPulse for a pulse that does
    not exist.
    """
    found: dict[str, Position] = {**(pose_of(robot, pose) if pose else {})}
    for name, pulse in pulses.items():
        found |= to_radians(robot, {name: whole(str(pulse))})
    for name, value in joints.items():
        numbers = value if isinstance(value, Sequence) and not isinstance(value, str) else [value]
        found[name] = place(robot, name, ",".join(map(str, numbers)))
    return found


def whole(text: str) -> int:
    """Return a pulse from its text. Raises RequestError if it is no whole number."""
    if not _WHOLE.fullmatch(text):
        raise RequestError(f"a pulse is a whole number, {text} is none")
    return int(text)


def sweep_of(robot: Robot, text: str) -> Sweep:
    """Return the sweep of JOINT=FROM:TO:COUNT. Raises RequestError."""
    name, value = split(text, "JOINT=FROM:TO:COUNT")
    joint, parts = free_joint(robot, name), [part.strip() for part in value.split(":")]
    if len(parts) != 3 or not _WHOLE.fullmatch(parts[2]):
        raise RequestError(f'"{text}" is not JOINT=FROM:TO:COUNT')
    first, last, count = position(joint, parts[0]), position(joint, parts[1]), int(parts[2])
    if not 1 <= count <= MAX_STATES:
        raise RequestError(f"a sweep has 1 to {MAX_STATES:,} states, not {count:,}")
    steps = [first + (last - first) * i / max(count - 1, 1) for i in range(count)]
    return Sweep(name, (*steps[:-1], last if count > 1 else first))


def states(start: Positions, sweeps: Sequence[Sweep]) -> Iterator[dict[str, Position]]:
    """Yield all combinations of sweeps, the last one fastest. Raises RequestError for too many."""
    count = math.prod(len(sweep.positions) for sweep in sweeps)
    if count > MAX_STATES:
        raise RequestError(f"the sweeps have {count:,} states together; {MAX_STATES:,} are the most")
    for values in product(*(sweep.positions for sweep in sweeps)):
        yield {**start, **{sweep.joint: value for sweep, value in zip(sweeps, values, strict=True)}}


def beyond(robot: Robot, state: Positions) -> Iterator[Beyond]:
    """Yield the joints that a state puts beyond a limit, those that follow a joint of the state included."""
    for joint in robot.joints:
        leader = joint
        while leader.mimic is not None:
            leader = robot.joint[leader.mimic.joint]
        if leader.name not in state or joint.limit is None or joint.type == "continuous":
            continue
        here, lower, upper = position_of(robot, joint, state), joint.limit.lower, joint.limit.upper
        if isinstance(here, tuple):
            continue
        if lower is not None and here < lower - ROUNDING:
            yield Beyond(joint, here, "lower", lower)
        elif upper is not None and here > upper + ROUNDING:
            yield Beyond(joint, here, "upper", upper)


def beyond_limit(case: Case, found: Beyond, severity: str = WARNING) -> Diagnostic:
    """Return the diagnostic of a position beyond a limit, at the place of the limit."""
    joint, side = found.joint, "below" if found.side == "lower" else "above"
    message = f'joint "{joint.name}" at {exact(found.position)} {joint.unit} is {side} its {found.side} limit'
    message += f" of {exact(found.limit)} {joint.unit}"
    help, path = "the joint does not get there; with --strict this is an error", case.joint(joint, "limit", found.side)
    return case.problem("position-beyond-limit", message, path, help, severity=severity)


# --- pulses of servos ---


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
        reached = to_radians(robot, {name: pulse})[name]
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
