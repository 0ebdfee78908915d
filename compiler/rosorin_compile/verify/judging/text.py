"""Judging pasted text: answers of tf2_echo, and the tree of view_frames."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from typing import NamedTuple

from ...diagnostic import ERROR, NOTE, WARNING, Diagnostic, did_you_mean
from ...model import Joint, Transform
from ..expected import Description, Expected
from ..findings import difference, half_turn_about, pose_text, problem, seconds
from ..recording.recording import Asked, FrameRow, Reading, Recording, Refused


class _Step(NamedTuple):
    """One step between two frames that hang together: over a joint, or over an edge of another node."""

    frame: str
    up: bool
    joint: Joint | None
    edge: Expected | None


def _steps(description: Description) -> dict[str, list[_Step]]:
    """Return the steps from each frame: also over joints that nobody publishes, which tf2_echo may not know."""
    steps: dict[str, list[_Step]] = {}
    pairs: list[tuple[str, str, Joint | None, Expected | None]] = []
    pairs += [(joint.parent, joint.child, joint, None) for joint in description.robot.joints]
    pairs += [(edge.parent, edge.child, None, edge) for edge in description.edges if edge.joint is None]
    for parent, child, joint, edge in pairs:
        steps.setdefault(parent, []).append(_Step(child, False, joint, edge))
        steps.setdefault(child, []).append(_Step(parent, True, joint, edge))
    return steps


def _way(description: Description, source: str, target: str) -> list[_Step] | None:
    """Return the steps from one frame to another; None if they do not hang together."""
    steps = _steps(description)
    came: dict[str, tuple[str, _Step]] = {}
    waiting = [source]
    for frame in waiting:
        for step in steps.get(frame, ()):
            if step.frame not in came and step.frame != source:
                came[step.frame] = (frame, step)
                waiting.append(step.frame)
    way: list[_Step] = []
    here = target
    while here != source:
        if here not in came:
            return None
        here, step = came[here]
        way.append(step)
    return way[::-1]


def _placed(description: Description, way: list[_Step], positions: Mapping[str, float]) -> Transform:
    """Return where the way leads; every edge of it has a value."""
    result = Transform()
    for step in way:
        value = step.edge.transform if step.edge is not None and step.edge.transform is not None else Transform()
        if step.joint is not None:
            value = step.joint.transform(description.robot.position(step.joint, positions))
        result = result.then(value.inverse() if step.up else value)
    return result


def asked(recording: Recording) -> Iterator[Diagnostic]:
    """Yield the answers of tf2_echo that are not what the description gives."""
    refused = {(question.source, question.target): question for question in recording.refused}
    answers = []
    for answer in recording.asked:
        refused.pop((answer.source, answer.target), None)
        answers.append(list(_answer(recording, answer)))
    nothing = not recording.series and all(of and of[0].rule == "not-compared" for of in answers)
    for finding in (finding for of in answers for finding in of):
        yield finding._replace(severity=ERROR) if nothing else finding
    for question in refused.values():
        yield _refused(recording, question)


def outcome(recording: Recording, answer: Asked) -> str:
    """Return in a few words how an answer compares with the description."""
    finding = next(_answer(recording, answer), None)
    if finding is None:
        return "as described"
    return "not compared" if finding.rule == "not-compared" else "not as described"


def _answer(recording: Recording, answer: Asked) -> Iterator[Diagnostic]:
    description = recording.description
    name = f"{answer.source} -> {answer.target}"
    known = description.frames | set(description.robot.link)
    for frame in (answer.source, answer.target):
        if frame not in known:
            message = f'tf2_echo was asked for "{frame}", a frame that is not described'
            yield problem("frame-unknown", name, message, did_you_mean(frame, known))
            return
    way = _way(description, answer.source, answer.target)
    unknown = [step.edge for step in way or () if step.edge is not None and step.edge.transform is None]
    if way is None or unknown:
        missing = ", ".join(f"{edge.name}, which {edge.owner} alone knows" for edge in unknown)
        message = f"{name} cannot be compared: between them is {missing or 'nothing that is described'}"
        yield problem("not-compared", name, message, "ask for frames of the robot itself", severity=NOTE)
        return
    needed = {description.leader(step.joint)[0] for step in way if step.joint is not None and step.joint.moves}
    absent = [joint.name for joint in description.robot.joints if joint.name in needed - set(answer.positions)]
    if absent:
        message = f"{name} cannot be compared: where {', '.join(absent)} stood is not known"
        yield problem("not-compared", name, message, "give --pose, or paste /joint_states above", severity=NOTE)
        return
    expected = _placed(description, way, answer.positions)
    for reading in answer.readings:
        finding = _reading(recording, name, answer, reading, expected)
        if finding is not None:
            yield finding
            return


def _reading(
    recording: Recording, name: str, answer: Asked, reading: Reading, expected: Transform
) -> Diagnostic | None:
    """Return the finding for one of the forms of an answer; None if it fits as far as it is printed."""
    printed = Transform(reading.rows or expected.rows, reading.xyz or expected.xyz)
    _, radians, _ = difference(expected, printed)
    moved = max(abs(a - b) for a, b in zip(expected.xyz, printed.xyz, strict=True)) > reading.metres
    turned = radians > reading.radians
    if not moved and not turned:
        return None
    # What is within the digits that were printed is no difference to speak of.
    recorded = Transform(printed.rows if turned else expected.rows, printed.xyz if moved else expected.xyz)
    metres, radians, words = difference(expected, recorded)
    rule = "mounted-backwards" if half_turn_about(expected, recorded) == "z" else "edge-wrong-value"
    evidence = [f"described: {pose_text(expected)}", f"printed:   {_printed(reading, printed)} (line {answer.line})"]
    edge = next((edge for edge in recording.description.edges if edge.name == name), None)
    help = "deploy what is compiled, or correct the description"
    if edge is not None:
        help = f"{edge.owner} publishes it: {help}"
    message = f"{name} is {words} against the description"
    return problem(rule, name, message, help, evidence=evidence, numbers={"metres": metres, "radians": radians})


def _printed(reading: Reading, pose: Transform) -> str:
    """Return a pose in words, of it only what was printed."""
    place, turn = pose_text(pose).split(", ")
    if reading.rows is None:
        return place
    return turn if reading.xyz is None else f"{place}, {turn}"


def _refused(recording: Recording, question: Refused) -> Diagnostic:
    name = f"{question.source} -> {question.target}"
    message = f"tf2_echo got no answer for {name}: {question.why}"
    owners = [
        edge
        for frame in (question.source, question.target)
        if f'"{frame}"' in question.why
        for edge in recording.description.by_child.get(frame, ())
    ]
    help = did_you_mean(question.target, recording.description.frames)
    if owners:
        help = f"{owners[0].owner} should publish {owners[0].name}"
    return problem("edge-missing", name, message, help, evidence=[f"line {question.line}"])


def rows(recording: Recording) -> Iterator[Diagnostic]:
    """Yield what is wrong with the tree that view_frames saw."""
    for row in recording.rows:
        yield from _row(recording, row)


def _row(recording: Recording, row: FrameRow) -> Iterator[Diagnostic]:
    name = f"{row.parent} -> {row.child}"
    expected = recording.description.by_child.get(row.child)
    if expected is None:
        message = f"{name} was published, but no such edge is described"
        help = did_you_mean(row.child, recording.description.frames)
        help = help if help.startswith("did you mean") else "declare it under edges, with the node that publishes it"
        yield problem("edge-not-described", name, message, help, severity=WARNING)
        return
    edge = next((edge for edge in expected if edge.parent == row.parent), expected[0])
    if edge.parent != row.parent:
        message = f'the parent of "{row.child}" is "{row.parent}", described is "{edge.parent}"'
        yield problem("edge-wrong-parent", name, message, f"{edge.owner} should publish {edge.name}")
    if row.still and edge.moving:
        message = f"{name} moves, but came on /tf_static: listeners take it for fixed"
        yield problem("edge-not-moving", name, message, f"{edge.owner} should publish it on /tf, again and again")
    elif not row.still and not edge.moving:
        message = (
            f"{name} never moves, but came on /tf at {row.rate:.1f} Hz: it can be late, which a static one never is"
        )
        yield problem("edge-not-static", name, message, f"{edge.owner} should publish it on /tf_static")
    limit = recording.description.options.stale
    if not row.still and row.age is not None and not math.isnan(row.age) and row.age > limit:
        message = f"{name} went {seconds(row.age)} stale, when view_frames looked"
        help = f"whoever asks then gets where things were {seconds(row.age)} ago: look why {edge.owner} stopped"
        evidence = [f"average rate {row.rate:.1f} Hz"]
        yield problem("edge-stale", name, message, f"{help} (--stale: {seconds(limit)})", evidence=evidence)
