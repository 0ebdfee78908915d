"""The transform between two frames of a robot: the operations of tf2 in the same order.

``lookupTransform`` of tf2 (geometry2, ``tf2/src/buffer_core.cpp``) walks from both frames up to where they meet and
multiplies quaternions on the way, so that even signs and zeros of the result follow from the order of operations. The
formulas are those of Bullet's linear algebra in geometry2 (``tf2/LinearMath/Quaternion.h`` and ``Matrix3x3.h``, equal
in Humble and Jazzy). Quaternions are x, y, z, w.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Literal

from rosorin_compile.model import STATIC_TRANSFORM_PUBLISHER, Edge, Publisher, Robot, Transform, Vector
from rosorin_compile.model.geometry import Quaternion, Rows, plus, quaternion_of
from rosorin_compile.model.joint import NODE, motion
from rosorin_compile.model.kinematics import Graph, Move, NoWay, Position, Positions, Step, position_of
from rosorin_compile.source.diagnostics import NOTE, Diagnostic, RequestError, UnknownName, did_you_mean, error
from rosorin_compile.source.progress import Progress
from rosorin_compile.source.rule_registry import ASKING, Rule
from rosorin_compile.source.wording import listed

from .case import Case
from .publishers import holds

RULES = (
    Rule("transform-not-known", "The description has no numbers for a transform.", "Try `--mode NAME`.", ASKING),
    Rule("transform-unpublished", "A note: nobody publishes a transform of the chain.", "Publish it.", ASKING),
    Rule("transform-sometimes", "A note: some modes do not publish a transform.", "Try `--mode NAME`.", ASKING),
)


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
            raise UnknownName(f'there is no frame "{frame}"; {did_you_mean(frame, every.frames)}')
        if frame not in graph.moves:
            raise NotPublished(f'in these modes nobody publishes the frame "{frame}"')
    found = []
    try:
        way = graph.way(source, target)
    except NoWay as problem:
        return [], [_no_way(case, problem)]
    for number, state in enumerate(states):
        Progress.step("looking up", number, len(states))
        found.append(lookup(graph, source, target, state))
    return found, _remarks(case, way)


def lookup(graph: Graph, source: str, target: str, positions: Positions) -> FrameTransform:
    """Return the pose of ``target`` in ``source`` at joint positions (rad or m).

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
    roll, pitch, yaw = angles = rpy(rows)
    chain = []
    for step, up in ((move.step, move.up) for move in way):
        name, kind = (None, "node") if step.joint is None else (step.joint.name, step.joint.type)
        nodes = tuple(TransformPublisher(one.name, one.kind, when or "always") for one, when in step.publishers)
        chain.append(TransformStep(step.parent, step.child, "up" if up else "down", name, kind, nodes))
    return FrameTransform(
        source=source,
        target=target,
        positions=dict(positions),
        translation=translation,
        quaternion=quaternion,
        rpy=angles,
        rpy_degrees=(roll * (180.0 / math.pi), pitch * (180.0 / math.pi), yaw * (180.0 / math.pi)),
        matrix=(*((*row, x) for row, x in zip(rows, translation, strict=True)), (0.0, 0.0, 0.0, 1.0)),
        chain=tuple(chain),
    )


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
    return (
        aw * bx + ax * bw + ay * bz - az * by,
        aw * by + ay * bw + az * bx - ax * bz,
        aw * bz + az * bw + ax * by - ay * bx,
        aw * bw - ax * bx - ay * by - az * bz,
    )


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
    return (
        (1.0 - (yy + zz), xy - wz, xz + wy),
        (xy + wz, 1.0 - (xx + zz), yz - wx),
        (xz - wy, yz + wx, 1.0 - (xx + yy)),
    )


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
        related.append(case.related(message, _path(case.robot, edge)))
    edges = listed(f"{step.parent} -> {step.child}" for step in problem.missing)
    message = f"the description has no numbers for {edges}, on the way from {source} to {target}"
    help = f"ask the running robot, ros2 run tf2_ros tf2_echo {source} {target}; or give the edge xyz and rpy"
    if all(edge.pose is not None for edge in missing):
        message = f"{edges}, on the way from {source} to {target}, depends on the mode"
        help = "choose a mode: --mode NAME"
    return case.problem("transform-not-known", message, _path(case.robot, missing[0]), help, related=related)


def _publisher(publisher: Publisher) -> str:
    if publisher.kind == STATIC_TRANSFORM_PUBLISHER:
        return f"the static_transform_publisher {publisher.name}"
    return f"{publisher.name} ({publisher.about})" if publisher.kind == NODE and publisher.about else publisher.name


def _remarks(case: Case, way: Sequence[Move]) -> list[Diagnostic]:
    """Return notes on transforms of the chain that the running robot has only sometimes, or not at all."""
    notes = []
    for step in (move.step for move in way):
        path = _path(case.robot, step.edges[0]) if step.joint is None else case.joint(step.joint)
        if not step.publishers:
            why = step.joint.publisher.about if step.joint is not None else ""
            message = f"nobody publishes {step.parent} -> {step.child}{f': {why}' if why else ''}"
            help = "the answer is that of the description; tf2 on the robot may have none, or another one"
            notes.append(case.problem("transform-unpublished", message, path, help, severity=NOTE))
        elif all(when for _, when in step.publishers):
            whens = " or ".join(dict.fromkeys(when for _, when in step.publishers))
            message = f"{step.parent} -> {step.child} is published when {whens}"
            notes.append(case.problem("transform-sometimes", message, path, severity=NOTE))
    return notes


def _path(robot: Robot, edge: Edge) -> tuple[str | int, ...]:
    """Return the path of an edge in the list of the description."""
    return "edges", next(index for index, one in enumerate(robot.edges) if one is edge)
