"""The transform between two frames of a robot, as tf2 computes it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Literal

from rosorin_compile.model import STATIC_TRANSFORM_PUBLISHER, Edge, Publisher, Robot
from rosorin_compile.model.joint import NODE
from rosorin_compile.model.kinematics import Graph, NoWay, Position
from rosorin_compile.model.tf2 import Answer, lookup
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
    answers = []
    try:
        for number, state in enumerate(states):
            Progress.step("looking up", number, len(states))
            answers.append(lookup(graph, source, target, state))
    except NoWay as problem:
        return [], [_no_way(case, problem)]
    return [_result(one, state) for one, state in zip(answers, states, strict=True)], _remarks(case, answers[0])


def _result(answer: Answer, positions: Mapping[str, Position]) -> FrameTransform:
    rows = [(*row, x) for row, x in zip(answer.rows, answer.translation, strict=True)]
    chain = []
    for step, up in ((move.step, move.up) for move in answer.way):
        name, kind = (None, "node") if step.joint is None else (step.joint.name, step.joint.type)
        nodes = tuple(TransformPublisher(one.name, one.kind, when or "always") for one, when in step.publishers)
        chain.append(TransformStep(step.parent, step.child, "up" if up else "down", name, kind, nodes))
    return FrameTransform(
        source=answer.source,
        target=answer.target,
        positions=dict(positions),
        translation=answer.translation,
        quaternion=answer.quaternion,
        rpy=answer.rpy,
        rpy_degrees=answer.degrees,
        matrix=(*rows, (0.0, 0.0, 0.0, 1.0)),
        chain=tuple(chain),
    )


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


def _remarks(case: Case, answer: Answer) -> list[Diagnostic]:
    """Return notes on transforms of the chain that the running robot has only sometimes, or not at all."""
    notes = []
    for step in (move.step for move in answer.way):
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
