"""Judge a recording: all findings, the most serious first."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

from rosorin_compile.compare.committed import compare
from rosorin_compile.formats import FORMATS
from rosorin_compile.formats.format import Artifact, Value
from rosorin_compile.model import ROBOT_STATE_PUBLISHER, Transform
from rosorin_compile.model.kinematics import NoWay
from rosorin_compile.source.diagnostics import (
    ERROR,
    NOTE,
    WARNING,
    Diagnostic,
    and_more,
    counted,
    did_you_mean,
    first_of,
)
from rosorin_compile.source.progress import Progress

from .expected import Description
from .findings import difference, ordered, pose_text, problem, share, value_rule
from .judge_clocks import clocks, row_clocks
from .judge_edges import dropped, edges, leaps_text, row
from .judge_sensors import sensors
from .judge_tree import late, missing, other_modes, prefixed, stale
from .recording import Answer, Reading, Recording

_SHOWN, _FEW = 8, 3
_STATES, _ROBOT = "/joint_states", "/robot_description"


@dataclass(frozen=True)
class Verdict:
    """A recording, the description that it was compared with, and the findings, the most serious first."""

    recording: Recording
    description: Description
    findings: list[Diagnostic]

    def count(self, severity: str) -> int:
        """Return the number of findings of a severity."""
        return sum(finding.severity == severity for finding in self.findings)

    def fails(self, strict: bool = False) -> bool:
        """Return True if the robot that ran is not the described one; ``strict`` treats warnings as errors."""
        return bool(self.count(ERROR) or (strict and self.count(WARNING)))


def judge(recording: Recording, artifacts: Sequence[Artifact]) -> list[Diagnostic]:
    """Compare a recording with its description and the compiled artifacts."""
    Progress.step("judging the recording")
    findings = list(recording.troubles)
    prefix = prefixed(recording)
    if prefix is not None:  # nothing else is known about frames with other names
        findings += [prefix, *clocks(recording), *_joints(recording)]
        return ordered([*findings, *_robot_description(recording, artifacts)])
    findings += dropped(recording)
    tree = recording.series or recording.rows or recording.answers or recording.refused
    stamped = recording.uses and not recording.timed
    if tree or stamped or recording.joints.pace.count or recording.descriptions:
        for rule in (edges, other_modes, missing, stale, late, clocks, _joints):
            findings += rule(recording)
        findings += _robot_description(recording, artifacts)
        findings += sensors(recording)
        for frame in recording.rows:
            findings += row(recording, frame)
        findings += row_clocks(recording)
        findings += _answers(recording)
    if not any(finding.severity == ERROR for finding in findings):
        findings += _no_edge(recording) if tree else [_no_transform(recording)]
    return ordered(findings)


def _no_transform(recording: Recording) -> Diagnostic:
    topics = sorted(recording.topics)
    help = "record /tf, /tf_static, /joint_states and /robot_description"
    if recording.messages == 0 and not topics:
        return problem("recording-empty", "the recording", "the recording has no messages", help)
    namespaced = [topic for topic in topics if topic.endswith("/tf")]
    if namespaced and not recording.description.options.namespace:
        help = f"--namespace {namespaced[0].removesuffix('/tf')} reads {namespaced[0]}"
    shown = f": it has {first_of(topics, 6)}" if topics else ""
    return problem("recording-foreign", "the recording", f"the recording has no transforms{shown}", help)


def _no_edge(recording: Recording) -> Iterator[Diagnostic]:
    """Yield the finding for a recording of which no edge is described."""
    known = recording.description.by_child
    recorded = [*recording.series.values(), *recording.rows]
    described = any(one.parent == edge.parent for one in recorded for edge in known.get(one.child, ()))
    if not described and not recording.answers:
        message = f"none of the {counted(len(recorded), 'edge')} of the recording is described: nothing could be "
        help = "look whether this is the recording of this robot, and its description"
        yield problem("not-compared", "the recording", f"{message}compared", help)


def _joints(recording: Recording) -> Iterator[Diagnostic]:
    states, robot = recording.joints, recording.description.robot
    moving = [series for series in recording.series.values() if not series.constant and series.comparable]
    if not states.pace.count:
        if moving:
            message = f"there is no {_STATES}: {len(moving)} moving edges were compared only with what their joints "
            yield problem("not-compared", _STATES, f"{message}can do", f"record {_STATES}, too", severity=NOTE)
        return
    unknown = [name for name in states.ranges if name not in robot.joint]
    for name in unknown if len(unknown) <= _FEW else ():
        help = did_you_mean(name, recording.description.joint_names)
        yield problem("joint-state-unknown", _STATES, f'{_STATES} names "{name}", a joint that is not described', help)
    if len(unknown) > _FEW:
        shown = first_of([f'"{name}"' for name in unknown], _SHOWN)
        message = f"{_STATES} names {len(unknown)} joints that are not described: {shown}"
        help = "describe them, or look whether this is the recording of this robot"
        yield problem("joint-state-unknown", _STATES, message, help, numbers={"joints": unknown})
    silent = recording.description.joint_names - states.ranges.keys()
    absent = [joint.name for joint in robot.joints if joint.name in silent]
    if absent:
        message = f"{_STATES} never names {', '.join(absent)}: robot_state_publisher does not publish what hangs on it"
        help = "the driver has to report every joint that robot_state_publisher moves"
        yield problem("joint-state-missing", _STATES, message, help, numbers={"joints": absent})
    if states.leaps.two:
        message = f"{_STATES} has two values in turns: {leaps_text(states.leaps)}"
        help = "two nodes publish joint states, such as joint_state_publisher beside the driver: stop one"
        yield problem("joint-states-two-values", _STATES, message, help)
    if states.too_short:
        message = f"{share(states.too_short, states.pace.count)} messages of {_STATES} have fewer positions than names"
        yield problem("joint-state-short", _STATES, message, "the driver has to give a position for each name")
    for name in states.ranges:
        yield from _range(recording, name)
    for name in states.followers:
        yield from _follower(recording, name)
    unmatched = [series for series in moving if series.compared and not series.by_state]
    if unmatched and len(unmatched) < len(moving):
        names = first_of([series.name for series in unmatched], _FEW)
        message = (
            f"{names} never had the stamp of a message of {_STATES} that names its joint: compared only with what "
        )
        message += "the joint can do"
        yield problem("not-compared", _STATES, message, "look who else publishes it", severity=NOTE)
    elif unmatched:
        message = f"no transform has the stamp of a message of {_STATES}: compared only with what the joints can do"
        help = "robot_state_publisher with ignore_timestamp, or another clock, does that"
        yield problem("not-compared", _STATES, message, help, severity=NOTE)


def _range(recording: Recording, name: str) -> Iterator[Diagnostic]:
    seen = recording.joints.ranges[name]
    if seen.not_numbers:
        message = f"{name} is no number in {share(seen.not_numbers, seen.seen)} messages of {_STATES}"
        yield problem("joint-not-a-number", _STATES, message, "mend the driver")
    if seen.beyond:
        lower, upper = recording.joints.limits(name)
        excess = max(lower - seen.lowest, seen.highest - upper)
        unit = "m" if recording.description.robot.joint[name].type == "prismatic" else "rad"
        message = f"{name} is beyond its limits in {share(seen.beyond, seen.seen)} messages, by "
        message += f"{Value(excess, unit).amount()} at most"
        seen_text, limits = (
            f"{seen.lowest:.6g} to {seen.highest:.6g} {unit}",
            [f"{value:.6g}" if math.isfinite(value) else "any" for value in (lower, upper)],
        )
        evidence = [f"seen {seen_text}, described {limits[0]} to {limits[1]} {unit}"]
        help, numbers = "correct the limits, the zero of the servo, or what drives it there", {"excess": excess}
        yield problem("joint-beyond-limit", name, message, help, severity=WARNING, evidence=evidence, numbers=numbers)


def _follower(recording: Recording, name: str) -> Iterator[Diagnostic]:
    follower, joint = recording.joints.followers[name], recording.description.robot.joint[name]
    if not follower.off or joint.mimic is None:
        return
    unit = "m" if joint.type == "prismatic" else "rad"
    ratio = f"{joint.mimic.multiplier:.6g} times {joint.mimic.joint}"
    ratio += f" {joint.mimic.offset:+.6g} {unit}" if joint.mimic.offset else ""
    message = f"{name} is not {ratio} in {share(follower.off, follower.seen)} messages of {_STATES}, by "
    message += f"{Value(follower.farthest, unit).amount()} at most"
    help = "robot_state_publisher takes what is reported: correct the ratio, or let the driver leave followers out"
    yield problem("joint-off-its-leader", name, message, help, severity=WARNING, numbers={"apart": follower.farthest})


def _robot_description(recording: Recording, artifacts: Sequence[Artifact]) -> Iterator[Diagnostic]:
    """Yield the differences between the URDF that ran and the compiled one."""
    compiled = next((one for one in artifacts if FORMATS.feeds(one, ROBOT_STATE_PUBLISHER)), None)
    if compiled is None:
        return
    if len(recording.descriptions) > 1:
        message = f"{_ROBOT} carried {len(recording.descriptions)} different robots"
        help = "two robot_state_publishers, or one that was given another URDF while it ran"
        yield problem("robot-description-changed", _ROBOT, message, help, severity=WARNING)
    for ran in recording.descriptions:
        if ran.rstrip() == compiled.text.encode().rstrip():
            continue
        comparison = compare(recording.description.robot, [compiled], {compiled.file: ran})
        if comparison.changes:
            evidence = [f"ran -> compiled: {change.line()}" for change in comparison.changes[:_SHOWN]]
            more = len(comparison.changes) - _SHOWN
            evidence += [f"...{and_more(more)}"] if more > 0 else []
            many = counted(len(comparison.changes), "difference")
            message = f"{_ROBOT} is not the compiled {compiled.file}: {many} of meaning"
            help = "deploy what is compiled, and start robot_state_publisher again"
            yield problem("other-robot-description", _ROBOT, message, help, evidence=evidence)
        elif any("damaged" in text.remark for text in comparison.texts):
            evidence = [text.remark.partition("(")[2].removesuffix(")") for text in comparison.texts if text.remark]
            message, help = f"{_ROBOT} cannot be read as a URDF", "look what was given to it"
            yield problem("other-robot-description", _ROBOT, message, help, evidence=evidence)
        else:
            message = f"{_ROBOT} means what the compiled {compiled.file} means, in another text"
            help = "deploy what is compiled, so that the two stay the same"
            yield problem("robot-description-text", _ROBOT, message, help, severity=NOTE)


def _answers(recording: Recording) -> Iterator[Diagnostic]:
    """Yield the answers of tf2_echo that differ from the description, and questions that were never answered."""
    judged = [answer_finding(recording, answer) for answer in recording.answers]
    nothing = not recording.series and all(found and found.rule == "not-compared" for found in judged)
    for finding in filter(None, judged):
        yield replace(finding, severity=ERROR) if nothing else finding
    answered = {answer.name for answer in recording.answers}
    for question in {one.name: one for one in recording.refused if one.name not in answered}.values():
        frames = [frame for frame in (question.source, question.target) if f'"{frame}"' in question.why]
        owners = [edge for frame in frames for edge in recording.description.by_child.get(frame, ())]
        help = did_you_mean(question.target, recording.description.frames)
        help = f"{owners[0].owner} should publish {owners[0].name}" if owners else help
        message = f"tf2_echo got no answer for {question.name}: {question.why}"
        yield problem("edge-missing", question.name, message, help, evidence=[f"line {question.line}"])


def answer_finding(recording: Recording, answer: Answer) -> Diagnostic | None:
    """Return the finding about one answer of tf2_echo, or None if it is as described."""
    description, robot, name = recording.description, recording.description.robot, answer.name
    known = description.frames | set(robot.link)
    for frame in (answer.source, answer.target):
        if frame not in known:
            message = f'tf2_echo was asked for "{frame}", a frame that is not described'
            return problem("frame-unknown", name, message, did_you_mean(frame, known))
    try:
        way = robot.kinematics.graph.way(answer.source, answer.target)
    except NoWay as no_way:
        steps = [f"{s.parent} -> {s.child}, which {description.owners(s.child)} alone knows" for s in no_way.missing]
        message = f"{name} cannot be compared: between them is {', '.join(steps) or 'nothing that is described'}"
        return problem("not-compared", name, message, "ask for frames of the robot itself", severity=NOTE)
    joints = [move.step.joint for move in way if move.step.joint is not None and move.step.joint.moves]
    needed = {description.leader(joint) for joint in joints} - answer.positions.keys()
    absent = [joint.name for joint in robot.joints if joint.name in needed]
    if absent:
        message = f"{name} cannot be compared: where {', '.join(absent)} stood is not known"
        return problem("not-compared", name, message, "give --pose, or paste /joint_states above", severity=NOTE)
    expected = Transform()
    for move in way:
        value = move.step.transform(robot, answer.positions)
        expected = expected.then(value.inverse() if move.up else value)
    findings = (_reading(recording, answer, reading, expected) for reading in answer.readings)
    return next(filter(None, findings), None)


def _reading(recording: Recording, answer: Answer, reading: Reading, expected: Transform) -> Diagnostic | None:
    printed = Transform((reading.turn or expected).rows, reading.xyz or expected.xyz)
    moved = max(abs(a - b) for a, b in zip(expected.xyz, printed.xyz, strict=True)) > reading.metres
    turned = expected.angle_to(printed) > reading.radians
    if not moved and not turned:
        return None
    # Differences within the printed digits are left out.
    recorded = Transform(printed.rows if turned else expected.rows, printed.xyz if moved else expected.xyz)
    metres, radians, words = difference(expected, recorded)
    place, turn = pose_text(printed).split(", ")
    shown = place if reading.turn is None else turn if reading.xyz is None else f"{place}, {turn}"
    evidence = [f"described: {pose_text(expected)}", f"printed:   {shown} (line {answer.line})"]
    edge = next((edge for edge in recording.description.edges if edge.name == answer.name), None)
    help = f"{edge.owner} publishes it: " if edge is not None else ""
    help += "deploy what is compiled, or correct the description"
    message, numbers = f"{answer.name} is {words} against the description", {"metres": metres, "radians": radians}
    return problem(value_rule(expected, recorded), answer.name, message, help, evidence=evidence, numbers=numbers)
