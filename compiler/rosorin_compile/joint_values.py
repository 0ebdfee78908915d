"""Parse the joint positions that a user requests: numbers with units, servo pulses, named poses and sweeps."""

import math
import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import product

from rosorin_compile.language.expression import ExpressionError, evaluate
from rosorin_compile.model import Joint, Robot
from rosorin_compile.model.geometry import quaternion_of, rotation_of_rpy
from rosorin_compile.model.kinematics import Position, Positions
from rosorin_compile.model.servos import ServoGroup, nearest, pulses_within, servo_of, to_radians
from rosorin_compile.request import FilePath, Packages, Request, Values
from rosorin_compile.rules.case import Case
from rosorin_compile.source import units
from rosorin_compile.source.diagnostics import ERROR, WARNING, Diagnostic, RequestError, UnknownName
from rosorin_compile.source.numbers import exact
from rosorin_compile.source.units import ANGLE, LENGTH, NUMBER, Dimension, Quantity, describe, dimension_of

MAX_STATES = 100_000
_ROUNDING = 1e-6  # tolerance (rad or m) of limits, because positions computed from pulses are rounded
_WHOLE = re.compile(r"[+-]?[0-9]{1,9}")
_NUMBER = re.compile(r"[+-]?([0-9]+\.?[0-9]*|\.[0-9]+)([eE][+-]?[0-9]+)?")
_COORDINATES: Mapping[str, tuple[tuple[str, ...], ...]] = {
    "planar": (("x", "y", "angle"),),
    "floating": (("x", "y", "z", "roll", "pitch", "yaw"), ("x", "y", "z", "qx", "qy", "qz", "qw")),
    "ball": (("roll", "pitch", "yaw"), ("qx", "qy", "qz", "qw")),
}


def positions(
    robot: Robot, pose: str = "", joints: Values = None, pulses: Mapping[str, object] | None = None
) -> dict[str, Position]:
    """Return the requested joint positions (rad or m) by joint name.

    ``pulses`` override the positions of ``pose``, and ``joints`` override both. Values of ``joints`` are numbers in rad
    or m, or strings such as "30deg". Raises RequestError, and NoPulse for a pulse out of range.
    """
    found: dict[str, Position] = {**(robot.positions(pose) if pose else {})}
    for name, pulse in (pulses or {}).items():
        found |= to_radians(robot, {name: _whole(str(pulse))})
    for name, value in (joints or {}).items():
        numbers = value if isinstance(value, Sequence) and not isinstance(value, str) else [value]
        found[name] = position(robot, name, ",".join(map(str, numbers)))
    return found


def position(robot: Robot, name: str, text: str) -> Position:
    """Parse a position such as "30deg"; planar, floating and ball joints have several numbers. Raises RequestError."""
    joint = robot.joint.get(name)
    if joint is None or joint.type not in _COORDINATES:
        return _single(_movable_joint(robot, name), text)
    parts, forms = [part.strip() for part in text.split(",")], _COORDINATES[joint.type]
    if (form := next((form for form in forms if len(form) == len(parts)), None)) is None:
        usage = " or ".join(f"{name}={','.join(form)}" for form in forms)
        raise RequestError(f'joint "{name}" is {joint.type}: write {usage}')
    kinds = [LENGTH if key in "xyz" else NUMBER if key.startswith("q") else ANGLE for key in form]
    numbers = tuple(_number(joint, part, kind) for part, kind in zip(parts, kinds, strict=True))
    if "roll" in form:
        *xyz, roll, pitch, yaw = numbers
        return (*xyz, *quaternion_of(rotation_of_rpy((roll, pitch, yaw))))
    if "qw" in form and not any(numbers[-4:]):
        raise RequestError(f'the quaternion of joint "{name}" is zero: {text}')
    return numbers


def sweep_of(robot: Robot, name: str, text: str) -> tuple[float, ...]:
    """Parse the sweep "FROM:TO:COUNT" into COUNT evenly spaced positions of a joint. Raises RequestError."""
    joint, parts = _movable_joint(robot, name), [part.strip() for part in text.split(":")]
    if len(parts) != 3 or not _WHOLE.fullmatch(parts[2]):
        raise RequestError(f'"{name}={text}" is not JOINT=FROM:TO:COUNT')
    first, last, count = _single(joint, parts[0]), _single(joint, parts[1]), int(parts[2])
    if not 1 <= count <= MAX_STATES:
        raise RequestError(f"a sweep has 1 to {MAX_STATES:,} states, not {count:,}")
    return (*(first + (last - first) * i / (count - 1) for i in range(count - 1)), last if count > 1 else first)


def combine_sweeps(start: Positions, sweeps: Mapping[str, Sequence[float]]) -> list[dict[str, Position]]:
    """Return a copy of ``start`` with each combination of positions, the last joint fastest. Raises RequestError."""
    count = math.prod(map(len, sweeps.values()))
    if count > MAX_STATES:
        raise RequestError(f"the sweeps have {count:,} states together; {MAX_STATES:,} are the most")
    return [{**start, **dict(zip(sweeps, values, strict=True))} for values in product(*sweeps.values())]


def _movable_joint(robot: Robot, name: str) -> Joint:
    if (joint := robot.joint.get(name)) is None:
        movable = [joint.name for joint in robot.joints if joint.moves and joint.mimic is None]
        raise UnknownName("joint", name, movable, none="none moves")
    if joint.mimic is not None:
        raise RequestError(f'joint "{name}" follows "{joint.mimic.joint}": set that one')
    if not joint.moves:
        why = "it never moves" if joint.type == "fixed" else "its position is not one number"
        raise RequestError(f'joint "{name}" is {joint.type}: {why}')
    return joint


def _single(joint: Joint, text: str) -> float:
    return _number(joint, text, LENGTH if joint.type == "prismatic" else ANGLE)


def _number(joint: Joint, text: str, expected: Dimension) -> float:
    subject = f'the position of joint "{joint.name}"'
    if (unit := units.unknown_unit(text)) is not None:
        raise RequestError(f'{subject} has an unknown unit: "{unit}"')
    value: object = Quantity.parse(text)
    try:
        value = evaluate(text, dict[str, object]().__getitem__) if value is None else value
    except ExpressionError as problem:
        raise RequestError(f"{subject} cannot be read: {text}: {problem.message}") from None
    if isinstance(value, bool) or not isinstance(value, (int, float)) or not math.isfinite(value):
        raise RequestError(f"{subject} is not a finite number: {text}")
    if (dimension := dimension_of(value)) not in (None, NUMBER, expected):
        what = f"{text} is {describe(dimension)}, not {describe(expected)}"
        raise RequestError(f'joint "{joint.name}" is {joint.type}: {what}')
    return float(value)


def _whole(text: str) -> int:
    if not _WHOLE.fullmatch(text):
        raise RequestError(f"a pulse is a whole number, {text} is none")
    return int(text)


def beyond_limits(case: Case, states: Iterable[Positions], strict: bool = False) -> list[Diagnostic]:
    """Return a warning (an error if ``strict`` is True) for each joint limit that any of the ``states`` exceeds."""
    found: dict[tuple[str, str], Diagnostic] = {}
    help, severity = "the joint does not get there; with --strict this is an error", ERROR if strict else WARNING
    for state, joint in product(states, case.robot.joints):
        leader = joint
        while leader.mimic is not None:
            leader = case.robot.joint[leader.mimic.joint]
        here = case.robot.position(joint, state) if leader.name in state else ()
        if isinstance(here, tuple) or joint.limit is None or joint.type == "continuous":
            continue
        for side, sign, word in (("lower", -1, "below"), ("upper", 1, "above")):
            end, unit = getattr(joint.limit, side), joint.unit
            if end is not None and (here - end) * sign > _ROUNDING and (joint.name, side) not in found:
                limit = f"its {side} limit of {exact(end)} {unit}"
                message = f'joint "{joint.name}" at {exact(here)} {unit} is {word} {limit}'
                path = case.joint(joint, "limit", side)
                found[joint.name, side] = case.problem("position-beyond-limit", message, path, help, severity=severity)
    return list(found.values())


@dataclass(frozen=True)
class JointPulse:
    """A servo pulse, and the joint position in ``unit`` (rad or m) that results from it.

    ``difference`` is ``position`` minus the ``requested`` position; both are None if a pulse was requested. ``degrees``
    is None for a prismatic joint.
    """

    joint: str
    servos: str
    pulse: int
    position: float
    unit: str
    degrees: float | None
    requested: float | None
    difference: float | None
    pulses_within_limits: tuple[int, int] | None


@dataclass(frozen=True)
class Pulses:
    """Servo pulses with the resulting joint positions, and the calibration of the servos.

    Each group in ``servos`` has one calibration: position = (pulse - zero_pulse) * rad_per_pulse, negated if
    ``flipped``. For a prismatic joint, ``rad_per_pulse`` is in metres. ``without_servo`` has the joints of the pose
    that no servo moves.
    """

    servos: tuple[ServoGroup, ...] = ()
    joints: tuple[JointPulse, ...] = ()
    without_servo: tuple[str, ...] = ()
    diagnostics: tuple[Diagnostic, ...] = ()
    robot: Robot | None = field(default=None, repr=False)


def pulses(
    robot: FilePath | Request,
    values: Values = None,
    arguments: Values = None,
    packages: Packages = None,
    *,
    pose: str = "",
    unit: str = "",
    strict: bool = False,
    trust: bool = False,
) -> Pulses:
    """Convert servo pulses to joint positions, or joint positions to the nearest servo pulses.

    Args:
        values: Pulses (integers) or positions (strings with a unit, such as ``"30deg"``) by joint name.
        pose: A named pose to convert; ``values`` override its positions.
        unit: ``"rad"`` or ``"deg"``: numbers in ``values`` are positions in this unit (or metres), not pulses.
        strict: Treat positions beyond a limit as errors.

    Raises:
        NoPulse: A pulse is out of range, or no pulse sets a requested position.

    Example:
        >>> import rosorin_compile
        >>> (joint,) = rosorin_compile.pulses("rosorin", {"joint1": "30deg"}).joints
        >>> joint.pulse, round(joint.degrees, 2)
        (375, 30.0)
    """
    case, diagnostics = Request.from_arguments(robot, arguments, packages, trust=trust).load_case()
    if case is None:
        return Pulses(diagnostics=diagnostics)
    servos = case.robot.servos
    if not servos:
        raise RequestError(f'the robot "{case.robot.name}" has no servos')
    posed = dict(case.robot.positions(pose)) if pose else {}
    with_servo = [name for group in servos for name in group.joints if name in posed]
    if pose and not with_servo:
        raise RequestError(f'no joint of the pose "{pose}" has a servo')
    pulses_of_pose = next((one.pulses for one in case.robot.poses if pose and one.name == pose), {})
    rows = {name: _joint_pulse(case.robot, name, pulses_of_pose.get(name), posed[name]) for name in with_servo}
    for name, value in (values or {}).items():
        servo_of(case.robot, name)
        text, is_number = str(value), _NUMBER.fullmatch(str(value)) is not None
        if is_number and not unit:
            rows[name] = _joint_pulse(case.robot, name, _whole(text), 0.0)
        else:
            text += " deg" if is_number and unit == "deg" and case.robot.joint[name].type != "prismatic" else ""
            rows[name] = _joint_pulse(case.robot, name, None, _single(case.robot.joint[name], text))
    diagnostics = (*diagnostics, *beyond_limits(case, [{row.joint: row.position for row in rows.values()}], strict))
    without = tuple(name for name in posed if name not in with_servo)
    return Pulses(servos, tuple(rows.values()), without, diagnostics, case.robot)


def _joint_pulse(robot: Robot, name: str, pulse: int | None, requested: float) -> JointPulse:
    joint, group = robot.joint[name], servo_of(robot, name)
    compared: tuple[float | None, float | None] = (None, None)
    if pulse is None:
        pulse, reached, difference = nearest(group, requested, name)
        compared = requested, difference
    else:
        reached = to_radians(robot, {name: pulse})[name]
    degrees = None if joint.unit == "m" else math.degrees(reached)
    limits = pulses_within(group, joint.limit)
    return JointPulse(name, group.name, pulse, reached, joint.unit, degrees, *compared, limits)
