"""The pose of one frame in another, as tf2 computes it."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from typing import Literal

from rosorin_compile.joint_values import beyond_limits, combine_sweeps, positions, sweep_of
from rosorin_compile.model import STATIC_TRANSFORM_PUBLISHER, Publisher, Robot, Transform, Vector
from rosorin_compile.model.geometry import Quaternion, Rows, plus, quaternion_of
from rosorin_compile.model.joint import NODE, motion
from rosorin_compile.model.kinematics import Graph, NoWay, Position, Positions, Step, position_of
from rosorin_compile.request import FilePath, Packages, Request, Values
from rosorin_compile.rules.case import Case
from rosorin_compile.rules.publishers import check_modes, holds
from rosorin_compile.source.diagnostics import (
    ERROR,
    NOTE,
    WARNING,
    Diagnostic,
    RequestError,
    UnknownName,
    error,
    has_errors,
)
from rosorin_compile.source.progress import Progress
from rosorin_compile.source.wording import listed


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


@dataclass(frozen=True)
class Transforms:
    """The pose of a frame in another, for each state of the joints.

    ``swept`` has the unit of each joint with a sweep. ``transforms`` is empty with errors in ``diagnostics``, and
    without ``robot`` the errors are in its files.
    """

    transforms: tuple[FrameTransform, ...] = ()
    swept: Mapping[str, str] = field(default_factory=dict)
    diagnostics: tuple[Diagnostic, ...] = ()
    robot: Robot | None = field(default=None, repr=False)


class NotPublished(RequestError):
    """No node publishes a frame in the requested modes."""


def transform(
    robot: FilePath | Request,
    source: str,
    target: str,
    arguments: Values = None,
    packages: Packages = None,
    *,
    pose: str = "",
    joints: Values = None,
    pulses: Values = None,
    sweeps: Mapping[str, str] | None = None,
    modes: Mapping[str, bool] | None = None,
    strict: bool = False,
    trust: bool = False,
) -> Transforms:
    """Return the pose of a frame in another, with the numbers that ``tf2_echo`` prints.

    Args:
        source: The frame in which the pose is expressed.
        target: The frame whose pose is returned.
        pose: A named pose of the description; joints that nothing sets are at zero.
        joints: Positions by joint: numbers in rad or m, or texts such as ``"30deg"``. They override all others.
        pulses: Pulses of servos by joint; they override ``pose``.
        sweeps: Positions to use in turn by joint, ``"FROM:TO:COUNT"``; of several, all combinations.
        modes: Modes of the robot that are on or off; if any is set, all others are off.
        strict: Treat positions beyond a limit as errors.

    Example:
        >>> import rosorin_compile
        >>> (found,) = rosorin_compile.transform("rosorin", "base_link", "laser").transforms
        >>> found.translation
        (0.048156, 7.5552e-05, 0.106748)
    """
    case, diagnostics = Request.of(robot, arguments, packages, trust=trust).load_case()
    if case is None:
        return Transforms(diagnostics=diagnostics)
    start = positions(case.robot, pose, joints, pulses)
    swept = {name: sweep_of(case.robot, name, text) for name, text in (sweeps or {}).items()}
    states = list(combine_sweeps(start, swept))
    diagnostics = (*diagnostics, *beyond_limits(case, states, ERROR if strict else WARNING))
    if has_errors(diagnostics):
        return Transforms(diagnostics=diagnostics, robot=case.robot)
    graph = _graph(case.robot, source, target, check_modes(case.robot, modes or {}))
    try:
        steps = [move.step for move in graph.way(source, target)]
    except NoWay as problem:
        return Transforms(diagnostics=(*diagnostics, _no_way(case, problem)), robot=case.robot)
    found = []
    for number, state in enumerate(states):
        Progress.step("looking up", number, len(states))
        found.append(lookup(graph, source, target, state))
    units = {name: "m" if case.robot.joint[name].type == "prismatic" else "rad" for name in swept}
    return Transforms(tuple(found), units, (*diagnostics, *_remarks(case, steps)), case.robot)


def _graph(robot: Robot, source: str, target: str, modes: Mapping[str, bool]) -> Graph:
    """Return the graph of the edges that are published in some modes, or of all edges without modes.

    Modes that are left out are off. Raises UnknownName for an unknown frame, and NotPublished for one that nobody
    publishes in these modes.
    """
    every = graph = Graph(robot)
    if modes:
        combination = {**dict.fromkeys(robot.modes, False), **modes}
        graph = Graph(replace(robot, edges=tuple(edge for edge in robot.edges if holds(edge.when, combination))))
    for frame in (source, target):
        if frame not in every.moves:
            raise UnknownName("frame", frame, every.frames)
        if frame not in graph.moves:
            raise NotPublished(f'in these modes no node publishes the frame "{frame}"')
    return graph


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
    path = ("edges", case.robot.edges.index(missing[0]))
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
