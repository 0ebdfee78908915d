"""Answers about joints and frames: requested positions, sweeps, pulses of servos, and transforms as tf2 has them."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from itertools import product
from types import MappingProxyType
from typing import Literal

from rosorin_compile.language.expression import ExpressionError, evaluate
from rosorin_compile.model import STATIC_TRANSFORM_PUBLISHER, Joint, Publisher, Robot, Transform, Vector
from rosorin_compile.model.geometry import Quaternion, Rows, plus, quaternion_of, rotation_of_rpy
from rosorin_compile.model.joint import NODE, motion
from rosorin_compile.model.kinematics import Graph, NoWay, Position, Positions, Step, position_of
from rosorin_compile.model.servos import nearest, servo_of, to_radians, within
from rosorin_compile.rules.case import Case
from rosorin_compile.rules.publishers import holds
from rosorin_compile.source import units
from rosorin_compile.source.diagnostics import NOTE, Diagnostic, RequestError, UnknownName, error
from rosorin_compile.source.numbers import exact
from rosorin_compile.source.progress import Progress
from rosorin_compile.source.tree import Path
from rosorin_compile.source.units import ANGLE, LENGTH, NUMBER, Dimension, Quantity, describe, dimension_of
from rosorin_compile.source.wording import listed

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


def pose_of(robot: Robot, name: str) -> dict[str, float]:
    """Return the positions of a named pose. Raises UnknownName."""
    return dict(robot.positions(name))


def free_joint(robot: Robot, name: str) -> Joint:
    """Return the joint of a name, if it has a position of its own that is one number. Raises RequestError."""
    if name not in robot.joint:
        known = [joint.name for joint in robot.joints if joint.moves and joint.mimic is None]
        raise UnknownName("joint", name, known, none="none moves")
    joint = robot.joint[name]
    if joint.mimic is not None:
        raise RequestError(f'joint "{name}" follows "{joint.mimic.joint}": set that one')
    if not joint.moves:
        why = "it never moves" if joint.type == "fixed" else "its position is not one number"
        raise RequestError(f'joint "{name}" is {joint.type}: {why}')
    return joint


def position(robot: Robot, name: str, text: str) -> Position:
    """Return the position of a joint from its text: several numbers for a planar one. Raises RequestError."""
    joint = robot.joint.get(name)
    if joint is None or joint.type not in _FORMS:
        return _single(free_joint(robot, name), text)
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


def _single(joint: Joint, text: str) -> float:
    return _number(joint, text, LENGTH if joint.type == "prismatic" else ANGLE)


def _number(joint: Joint, text: str, expected: Dimension) -> float:
    """Return a number in SI units from a number, a quantity or an expression. Raises RequestError."""
    subject = f'the position of joint "{joint.name}"'
    value: object = Quantity.parse(text)
    if value is None and _NUMBER.fullmatch(text):
        value = float(text)
    elif value is None:
        if (unit := units.unknown_unit(text)) is not None:
            raise RequestError(f'{subject} has an unknown unit: "{unit}"')
        try:
            value = evaluate(text, dict[str, object]().__getitem__)
        except ExpressionError as problem:
            raise RequestError(f"{subject} cannot be read: {text}: {problem.message}") from None
    if isinstance(value, bool) or not isinstance(value, (int, float)) or not math.isfinite(value):
        raise RequestError(f"{subject} is no finite number: {text}")
    dimension = dimension_of(value)
    if dimension not in (None, NUMBER, expected):
        what = f"{text} is {describe(dimension)}, not {describe(expected)}"
        raise RequestError(f'joint "{joint.name}" is {joint.type}: {what}')
    return float(value)


def positions(
    robot: Robot, pose: str = "", joints: Mapping[str, object] = NOTHING, pulses: Mapping[str, object] = NOTHING
) -> dict[str, Position]:
    """Return the positions of a named pose ("" for none), overridden by those of pulses, then by those of joints.

    Positions are numbers in rad or m, or texts such as "30deg". Raises RequestError, and NoPulse for a pulse that does
    not exist.
    """
    found: dict[str, Position] = {**(pose_of(robot, pose) if pose else {})}
    for name, pulse in pulses.items():
        found |= to_radians(robot, {name: _whole(str(pulse))})
    for name, value in joints.items():
        numbers = value if isinstance(value, Sequence) and not isinstance(value, str) else [value]
        found[name] = position(robot, name, ",".join(map(str, numbers)))
    return found


def _whole(text: str) -> int:
    if not _WHOLE.fullmatch(text):
        raise RequestError(f"a pulse is a whole number, {text} is none")
    return int(text)


def sweep_of(robot: Robot, name: str, text: str) -> tuple[str, tuple[float, ...]]:
    """Return a joint and the positions of FROM:TO:COUNT, both ends included. Raises RequestError."""
    joint, parts = free_joint(robot, name), [part.strip() for part in text.split(":")]
    if len(parts) != 3 or not _WHOLE.fullmatch(parts[2]):
        raise RequestError(f'"{name}={text}" is not JOINT=FROM:TO:COUNT')
    first, last, count = _single(joint, parts[0]), _single(joint, parts[1]), int(parts[2])
    if not 1 <= count <= MAX_STATES:
        raise RequestError(f"a sweep has 1 to {MAX_STATES:,} states, not {count:,}")
    steps = [first + (last - first) * i / max(count - 1, 1) for i in range(count)]
    return name, (*steps[:-1], last if count > 1 else first)


def states(start: Positions, sweeps: Sequence[tuple[str, tuple[float, ...]]]) -> Iterator[dict[str, Position]]:
    """Yield all combinations of sweeps, the last one fastest. Raises RequestError for too many."""
    count = math.prod(len(positions) for _, positions in sweeps)
    if count > MAX_STATES:
        raise RequestError(f"the sweeps have {count:,} states together; {MAX_STATES:,} are the most")
    for values in product(*(positions for _, positions in sweeps)):
        yield {**start, **{name: value for (name, _), value in zip(sweeps, values, strict=True)}}


def beyond_limits(case: Case, states: Iterable[Positions], severity: str) -> list[Diagnostic]:
    """Return a diagnostic for each joint and end of its limits that states exceed, also where it follows another."""
    found: dict[tuple[str, str], Diagnostic] = {}
    help = "the joint does not get there; with --strict this is an error"
    for state, joint in product(states, case.robot.joints):
        leader = joint
        while leader.mimic is not None:
            leader = case.robot.joint[leader.mimic.joint]
        here = position_of(case.robot, joint, state) if leader.name in state else ()
        if isinstance(here, tuple) or joint.limit is None or joint.type == "continuous":
            continue
        for side, sign, word in (("lower", -1, "below"), ("upper", 1, "above")):
            end, unit, path = getattr(joint.limit, side), joint.unit, case.joint(joint, "limit", side)
            if end is not None and (here - end) * sign > ROUNDING and (joint.name, side) not in found:
                message = (
                    f'joint "{joint.name}" at {exact(here)} {unit} is {word} its {side} limit of {exact(end)} {unit}'
                )
                made = case.problem("position-beyond-limit", message, path, help, severity=severity)
                found[joint.name, side] = made
    return list(found.values())


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


def calibrations(robot: Robot) -> tuple[Servos, ...]:
    """Return the calibrations of the servo groups of a robot. Raises RequestError if it has none."""
    if not robot.servos:
        raise RequestError(f'the robot "{robot.name}" has no servos')
    groups = robot.servos
    return tuple(Servos(g.name, g.joints, g.rad_per_pulse, g.zero_pulse, g.flipped, g.pulse_range) for g in groups)


def joint_pulses(robot: Robot, values: Mapping[str, object], pose: str = "", unit: str = "") -> list[JointPulse]:
    """Return the pulses of a named pose, then of values by joint: whole numbers are pulses, texts may have units.

    Numbers without a unit are positions in rad or m with ``unit`` "rad", in degrees or m with "deg". Raises
    RequestError for an invalid value, and NoPulse for a pulse that does not exist.
    """
    made: dict[str, JointPulse] = {}
    if pose:
        positions = pose_of(robot, pose)
        pulses = next(one.pulses for one in robot.poses if one.name == pose)
        for name in (name for group in robot.servos for name in group.joints if name in positions):
            made[name] = _joint_pulse(robot, name, pulses.get(name), positions[name])
        if not made:
            raise RequestError(f'no joint of the pose "{pose}" has a servo')
    for name, value in values.items():
        servo_of(robot, name)
        text, is_number = str(value), False
        with suppress(ValueError):
            is_number = math.isnan(float(text)) or True
        if is_number and not unit:
            made[name] = _joint_pulse(robot, name, _whole(text), 0.0)
        else:
            text += " deg" if is_number and unit == "deg" and robot.joint[name].type != "prismatic" else ""
            made[name] = _joint_pulse(robot, name, None, _single(robot.joint[name], text))
    return list(made.values())


def _joint_pulse(robot: Robot, name: str, pulse: int | None, requested: float) -> JointPulse:
    """Return the row of a pulse or, without one, of the pulse nearest to a position."""
    joint, group = robot.joint[name], servo_of(robot, name)
    found = nearest(group, requested, name) if pulse is None else None
    number = found.pulse if found else pulse or 0
    reached = found.position if found else to_radians(robot, {name: number})[name]
    unit: Literal["rad", "m"] = "m" if joint.type == "prismatic" else "rad"
    degrees, asked = None if unit == "m" else math.degrees(reached), requested if found else None
    off = reached - requested if found else None
    return JointPulse(name, group.name, number, reached, unit, degrees, asked, off, within(group, joint.limit))


# --- transforms ---


@dataclass(frozen=True)
class TransformPublisher:
    """A node that publishes an edge. ``when`` is the condition in modes, or "always"."""

    name: str
    kind: str
    when: str


@dataclass(frozen=True)
class TransformStep:
    """An edge between two frames; ``direction`` is "up" to a parent or "down" to a child.

    ``joint`` is None, and ``type`` is "node", for an edge that another node publishes.
    """

    parent: str
    child: str
    direction: Literal["up", "down"]
    joint: str | None
    type: str
    publishers: tuple[TransformPublisher, ...]


@dataclass(frozen=True)
class FrameTransform:
    """The pose of ``target`` in ``source`` at joint ``positions``: metres, and radians about fixed axes.

    ``quaternion`` is x y z w with the sign that tf2 prints, ``matrix`` has four rows, ``chain`` the edges on the way.
    """

    source: str
    target: str
    positions: Mapping[str, Position]
    translation: tuple[float, float, float]
    quaternion: tuple[float, float, float, float]
    rpy: tuple[float, float, float]
    rpy_degrees: tuple[float, float, float]
    matrix: tuple[tuple[float, ...], ...]
    chain: tuple[TransformStep, ...]


class NotPublished(RequestError):
    """No node publishes a frame in the requested modes."""


def transforms(
    case: Case, source: str, target: str, states: Sequence[Mapping[str, Position]], modes: Mapping[str, bool]
) -> tuple[list[FrameTransform], list[Diagnostic]]:
    """Return the pose of one frame in another at each state of the joints, and diagnostics about the chain.

    With ``modes``, only edges that are published in these modes are used, and modes that are left out are off. Raises
    UnknownName for an unknown frame, and NotPublished for one that nobody publishes in these modes.
    """
    robot, every = case.robot, Graph(case.robot)
    if modes:
        combination = {**dict.fromkeys(robot.modes, False), **modes}
        robot = replace(robot, edges=tuple(edge for edge in robot.edges if holds(edge.when, combination)))
    graph = Graph(robot)
    for frame in (source, target):
        if frame not in every.moves:
            raise UnknownName("frame", frame, every.frames)
        if frame not in graph.moves:
            raise NotPublished(f'in these modes no node publishes the frame "{frame}"')
    try:
        way = graph.way(source, target)
    except NoWay as problem:
        return [], [_no_way(case, problem)]
    found = []
    for number, state in enumerate(states):
        Progress.step("looking up", number, len(states))
        found.append(lookup(graph, source, target, state))
    return found, list(_remarks(case, [move.step for move in way]))


# The operations of tf2 in the same order: ``lookupTransform`` (geometry2, ``tf2/src/buffer_core.cpp``) walks from both
# frames up to where they meet and multiplies quaternions on the way, so that even signs and zeros of the result follow
# from the order of operations. The formulas are those of ``tf2/LinearMath`` (equal in Humble and Jazzy).


def lookup(graph: Graph, source: str, target: str, positions: Positions) -> FrameTransform:
    """Return the pose of ``target`` in ``source`` at joint positions (rad or m), as tf2 computes it.

    Raises NoWay, and KeyError for unknown frames.
    """
    way = graph.way(source, target)
    to_top = [move.step for move in way if move.up]
    from_top = [move.step for move in reversed(way) if not move.up]
    below, above = _accumulate(graph, from_top, positions), _accumulate(graph, to_top, positions)
    # tf2 leaves out the frame that it starts from only where it meets it on its way: never at the root of its tree.
    quaternion, translation = below
    if way and (to_top or source not in graph.published):
        x, y, z, w = above[0]
        quaternion = (-x, -y, -z, w)
        x, y, z = above[1]
        translation = _rotate(quaternion, (-x, -y, -z))
        if from_top or target not in graph.published:
            translation = plus(_rotate(quaternion, below[1]), translation)
            quaternion = _product(quaternion, below[0])
    rows = _rows_of(quaternion)
    angles = rpy(rows)
    roll, pitch, yaw = (angle * (180.0 / math.pi) for angle in angles)
    matrix = (*((*row, x) for row, x in zip(rows, translation, strict=True)), (0.0, 0.0, 0.0, 1.0))
    chain = []
    for step, up in way:
        name, kind = (None, "node") if step.joint is None else (step.joint.name, step.joint.type)
        nodes = tuple(TransformPublisher(one.name, one.kind, when or "always") for one, when in step.publishers)
        chain.append(TransformStep(step.parent, step.child, "up" if up else "down", name, kind, nodes))
    where = (translation, quaternion, angles, (roll, pitch, yaw), matrix)
    return FrameTransform(source, target, dict(positions), *where, tuple(chain))


def _accumulate(graph: Graph, steps: Iterable[Step], positions: Positions) -> tuple[Quaternion, Vector]:
    """Return the lowest frame of steps in the highest, accumulated upwards."""
    quaternion: Quaternion = (0.0, 0.0, 0.0, 1.0)
    vector: Vector = (0.0, 0.0, 0.0)
    for step in steps:
        joint = step.joint
        pose = step.pose if joint is None else joint.origin
        assert pose is not None  # noqa: S101 - the graph leaves out steps without numbers
        # Not pose.transform(): publishers keep the rounding of sines, and the signs of the zeros that follow from it.
        transform = Transform(rows_of_rpy(pose.rpy), pose.xyz)
        if joint is not None and not joint.is_fixed:
            position = position_of(graph.robot, joint, positions)
            transform = transform.then(motion(joint.type, joint.axis, position))
        rotation = quaternion_of(transform.rows)
        vector = plus(_rotate(rotation, vector), transform.xyz)
        quaternion = _product(rotation, quaternion)
    return quaternion, vector


def _product(a: Quaternion, b: Quaternion) -> Quaternion:
    """Return the rotation ``b``, then ``a``."""
    ax, ay, az, aw = a
    bx, by, bz, bw = b
    x, y = aw * bx + ax * bw + ay * bz - az * by, aw * by + ay * bw + az * bx - ax * bz
    return x, y, aw * bz + az * bw + ax * by - ay * bx, aw * bw - ax * bx - ay * by - az * bz


def _rotate(q: Quaternion, v: Vector) -> Vector:
    x, y, z, w = q
    a, b, c = v
    turned = (w * a + y * c - z * b, w * b + z * a - x * c, w * c + x * b - y * a, -x * a - y * b - z * c)
    return _product(turned, (-x, -y, -z, w))[:3]


def _rows_of(quaternion: Quaternion) -> Rows:
    x, y, z, w = quaternion
    s = 2.0 / (x * x + y * y + z * z + w * w)
    xs, ys, zs = x * s, y * s, z * s
    wx, wy, wz = w * xs, w * ys, w * zs
    xx, xy, xz = x * xs, x * ys, x * zs
    yy, yz, zz = y * ys, y * zs, z * zs
    first, second = (1.0 - (yy + zz), xy - wz, xz + wy), (xy + wz, 1.0 - (xx + zz), yz - wx)
    return first, second, (xz - wy, yz + wx, 1.0 - (xx + yy))


def rows_of_rpy(angles: Vector) -> Rows:
    """Return the rotation matrix of fixed-axis roll, pitch, yaw in radians, like tf2's ``Matrix3x3::setRPY``."""
    (si, ci), (sj, cj), (sh, ch) = ((math.sin(angle), math.cos(angle)) for angle in angles)
    cc, cs, sc, ss = ci * ch, ci * sh, si * ch, si * sh
    return ((cj * ch, sj * sc - cs, sj * cc + ss), (cj * sh, sj * ss + cc, sj * cs - sc), (-sj, cj * si, cj * ci))


def rpy(rows: Rows) -> Vector:
    """Return fixed-axis roll, pitch, yaw (radians) like ``getRPY`` of tf2: the solution with a pitch within 90 degrees.

    The pitch is exactly +-90 degrees, and the yaw zero, only where the matrix has 1 or more: within rounding is not
    enough. A pitch of zero is -0.0, since tf2 negates an arc sine.
    """
    down = rows[2][0]
    if abs(down) >= 1:
        return (math.atan2(rows[2][1], rows[2][2]), math.copysign(math.pi / 2, -down), 0.0)
    pitch = -math.asin(down)
    level = math.cos(pitch)
    roll = math.atan2(rows[2][1] / level, rows[2][2] / level)
    return (roll, pitch, math.atan2(rows[1][0] / level, rows[0][0] / level))


def _no_way(case: Case, problem: NoWay) -> Diagnostic:
    """Return why the description has no transform: which edges are missing, who publishes them, and when."""
    source, target = problem.source, problem.target
    if not problem.missing:
        help = "declare the transform that joins them under edges, with who publishes it"
        return error("transform-not-known", f"{source} and {target} are in trees that do not meet", None, help)
    related = []
    missing = [edge for step in problem.missing for edge in step.edges]
    for edge in missing:
        numbers = "a pose of its own" if edge.pose is not None else "known to that node alone"
        when = f"when {edge.when}" if edge.when else "always"
        message = f"{edge.parent} -> {edge.child}: {_publisher(edge.publisher)} publishes it {when}, {numbers}"
        related.append(case.related(message, ("edges", case.robot.edges.index(edge))))
    edges = listed(f"{step.parent} -> {step.child}" for step in problem.missing)
    message = f"the description has no numbers for {edges}, on the way from {source} to {target}"
    help = f"ask the running robot, ros2 run tf2_ros tf2_echo {source} {target}; or give the edge xyz and rpy"
    if all(edge.pose is not None for edge in missing):
        message = f"{edges}, on the way from {source} to {target}, depends on the mode"
        help = "choose a mode: --mode NAME"
    path: Path = ("edges", case.robot.edges.index(missing[0]))
    return case.problem("transform-not-known", message, path, help, related=related)


def _publisher(publisher: Publisher) -> str:
    if publisher.kind == STATIC_TRANSFORM_PUBLISHER:
        return f"the static_transform_publisher {publisher.name}"
    return f"{publisher.name} ({publisher.about})" if publisher.kind == NODE and publisher.about else publisher.name


def _remarks(case: Case, steps: Iterable[Step]) -> Iterator[Diagnostic]:
    """Yield notes on transforms of the chain that the running robot has only sometimes, or not at all."""
    for step in steps:
        path = case.joint(step.joint) if step.joint else ("edges", case.robot.edges.index(step.edges[0]))
        if not step.publishers:
            why = f": {step.joint.publisher.about}" if step.joint and step.joint.publisher.about else ""
            message = f"no node publishes {step.parent} -> {step.child}{why}"
            help = "the answer is that of the description; tf2 on the robot may have none, or another one"
            yield case.problem("transform-unpublished", message, path, help, severity=NOTE)
        elif all(when for _, when in step.publishers):
            whens = " or ".join(dict.fromkeys(when for _, when in step.publishers))
            message = f"{step.parent} -> {step.child} is published when {whens}"
            yield case.problem("transform-sometimes", message, path, severity=NOTE)
