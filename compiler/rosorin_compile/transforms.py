"""Compute the pose of one frame relative to another."""

import math
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field, replace

from rosorin_compile.joint_values import beyond_limits, combine_sweeps, positions, sweep_of
from rosorin_compile.model import Robot, Transform
from rosorin_compile.model.geometry import quaternion_of
from rosorin_compile.model.kinematics import Graph, NoWay, Position, Positions, Step
from rosorin_compile.request import FilePath, Packages, Request, Values
from rosorin_compile.rules.case import Case
from rosorin_compile.rules.publishers import check_modes, holds
from rosorin_compile.source.diagnostics import NOTE, Diagnostic, RequestError, UnknownName, error, has_errors
from rosorin_compile.source.progress import Progress
from rosorin_compile.source.tree import Path
from rosorin_compile.source.wording import phrase


@dataclass(frozen=True)
class FrameTransform:
    """The pose of the frame ``target`` in the frame ``source``, in metres and radians, at joint ``positions``.

    ``rpy`` are angles about fixed axes; ``quaternion`` is (x, y, z, w) with the sign of tf2; ``matrix`` is 4x4.
    """

    source: str
    target: str
    positions: Mapping[str, Position]
    translation: tuple[float, float, float]
    quaternion: tuple[float, float, float, float]
    rpy: tuple[float, float, float]
    rpy_degrees: tuple[float, float, float]
    matrix: tuple[tuple[float, ...], ...]


@dataclass(frozen=True)
class Transforms:
    """The pose of one frame relative to another, for each combination of joint positions.

    ``swept`` maps each joint with a sweep to its unit (rad or m). If ``diagnostics`` has errors, ``transforms`` is
    empty; ``robot`` is None if the errors are in its files.
    """

    transforms: tuple[FrameTransform, ...] = ()
    swept: Mapping[str, str] = field(default_factory=dict)
    diagnostics: tuple[Diagnostic, ...] = ()
    robot: Robot | None = field(default=None, repr=False)


class NotPublished(RequestError):
    """Raised if no ROS node publishes a frame in the requested modes."""


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
    """Compute the pose of one frame relative to another, with the same numbers as ``tf2_echo``.

    Args:
        source: The frame in which the pose is expressed.
        target: The frame whose pose is returned.
        pose: The name of a pose of the description. Joints without a position are at zero.
        joints: Positions by joint: numbers in rad or m, or strings such as ``"30deg"``. They override all others.
        pulses: Servo pulses by joint. They override ``pose``.
        sweeps: Ranges of positions by joint, ``"FROM:TO:COUNT"``; several ranges yield all combinations.
        modes: Modes of the robot that are on (True) or off. If any is set, all others are off.
        strict: Treat positions beyond a limit as errors.

    Example:
        >>> import rosorin_compile
        >>> (found,) = rosorin_compile.transform("rosorin", "base_link", "laser").transforms
        >>> found.translation
        (0.048156, 7.5552e-05, 0.106748)
    """
    case, diagnostics = Request.from_arguments(robot, arguments, packages, trust=trust).load_case()
    if case is None:
        return Transforms(diagnostics=diagnostics)
    start = positions(case.robot, pose, joints, pulses)
    swept = {name: sweep_of(case.robot, name, text) for name, text in (sweeps or {}).items()}
    states = combine_sweeps(start, swept)
    diagnostics = (*diagnostics, *beyond_limits(case, states, strict))
    if has_errors(diagnostics):
        return Transforms(diagnostics=diagnostics, robot=case.robot)
    every = graph = Graph(case.robot)
    if requested := check_modes(case.robot, modes or {}):  # all modes that are not requested are off
        combination = {**dict.fromkeys(case.robot.modes, False), **requested}
        edges = tuple(edge for edge in case.robot.edges if holds(edge.when, combination))
        graph = Graph(replace(case.robot, edges=edges))
    for frame in (source, target):
        if frame not in every.moves:
            raise UnknownName("frame", frame, every.frames)
        if frame not in graph.moves:
            raise NotPublished(f'in these modes no node publishes the frame "{frame}"')
    try:
        steps = [move.step for move in graph.way(source, target)]
    except NoWay as problem:
        return Transforms(diagnostics=(*diagnostics, _no_way(case, problem)), robot=case.robot)
    found = []
    for number, state in enumerate(states):
        Progress.step("looking up", number, len(states))
        found.append(lookup(graph, source, target, state))
    units = {name: case.robot.joint[name].unit for name in swept}
    return Transforms(tuple(found), units, (*diagnostics, *_remarks(case, steps)), case.robot)


def lookup(graph: Graph, source: str, target: str, positions: Positions) -> FrameTransform:
    """Return the pose of ``target`` in ``source`` at joint positions (rad or m), as ``lookupTransform`` of tf2 does.

    Raises NoWay if no transforms connect the frames, and KeyError for an unknown frame.
    """
    way, pose = graph.way(source, target), Transform()
    for move in way:
        there = move.step.transform(graph.robot, positions)
        pose = pose.then(there.inverse() if move.up else there)
    # Compute the angles from the quaternion, to get the same rounding as tf2.
    x, y, z, w = quaternion = quaternion_of(pose.rows)
    turn = Transform.of_quaternion((0.0, 0.0, 0.0), (w, x, y, z))
    roll, pitch, yaw = turn.rpy()
    degrees = roll * (180.0 / math.pi), pitch * (180.0 / math.pi), yaw * (180.0 / math.pi)
    matrix = (*((*row, x) for row, x in zip(turn.rows, pose.xyz, strict=True)), (0.0, 0.0, 0.0, 1.0))
    numbers = (pose.xyz, quaternion, (roll, pitch, yaw), degrees, matrix)
    return FrameTransform(source, target, dict(positions), *numbers)


def _no_way(case: Case, problem: NoWay) -> Diagnostic:
    source, target = problem.source, problem.target
    if not problem.missing:
        help = "declare the transform that joins them under edges, with who publishes it"
        return error("transform-not-known", f"{source} and {target} are in trees that do not meet", None, help)
    missing = [edge for step in problem.missing for edge in step.edges]
    paths: list[Path] = [("edges", case.robot.edges.index(edge)) for edge in missing]
    related = []
    for edge, path in zip(missing, paths, strict=True):
        when = f"when {edge.when}" if edge.when else "always"
        related.append((f"{edge.parent} -> {edge.child}: {edge.publisher.name} publishes it {when}", path))
    edges = phrase(f"{step.parent} -> {step.child}" for step in problem.missing)
    message = f"{edges}, on the way from {source} to {target}, depends on the mode"
    help = "choose a mode: --mode NAME"
    if any(edge.pose is None for edge in missing):
        message = f"the description has no numbers for {edges}, on the way from {source} to {target}"
        help = f"ask the running robot, ros2 run tf2_ros tf2_echo {source} {target}; or give the edge xyz and rpy"
    return case.problem("transform-not-known", message, paths[0], help, related=related)


def _remarks(case: Case, steps: Iterable[Step]) -> Iterator[Diagnostic]:
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
