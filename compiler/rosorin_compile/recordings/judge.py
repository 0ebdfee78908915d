"""Judge: all findings about a recording, the most serious first.

Edges, the tree, stamps and sensors have modules of their own (``judge_edges``, ``judge_tree``, ``judge_stamps``,
``judge_sensors``); joints, the description that the robot ran with and pasted text are judged here. ``Verdict`` is what
comes out.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

from rosorin_compile.compare.committed import compare
from rosorin_compile.formats import FORMATS
from rosorin_compile.formats.format import Artifact
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
from rosorin_compile.source.numbers import amount
from rosorin_compile.source.progress import Progress
from rosorin_compile.source.rule_registry import Heading, Rule

from . import judge_edges, judge_sensors, judge_stamps, judge_tree
from .expected import Description
from .findings import YEAR, difference, half_turn_about, ordered, pose_text, problem, seconds, share
from .joints import Follower, JointLog, Range
from .judge_edges import leaps_text
from .recording import Asked, FrameRow, Reading, Recording, Refused

RULES = (
    Rule(
        "recording-empty",
        "There is not one message.",
        "Record `/tf`, `/tf_static`, `/joint_states` and `/robot_description`.",
        Heading.RECORDINGS,
    ),
    Rule(
        "recording-foreign",
        "There is not one transform.",
        "Record those topics; `--namespace` if they have one.",
        Heading.RECORDINGS,
    ),
    Rule(
        "not-compared",
        "A note: something could not be compared, because a pose or the joint states are not known. An error if "
        "nothing else was there.",
        "`--pose NAME`; record `/joint_states`.",
        Heading.RECORDINGS,
    ),
    Rule(
        "joint-state-unknown",
        "`/joint_states` names a joint that is not described.",
        "Correct the driver, or the description.",
        Heading.RECORDINGS,
    ),
    Rule(
        "joint-state-missing",
        "`/joint_states` leaves out a joint that robot_state_publisher moves.",
        "Correct the driver.",
        Heading.RECORDINGS,
    ),
    Rule(
        "joint-state-short", "A joint state has fewer positions than names.", "Correct the driver.", Heading.RECORDINGS
    ),
    Rule(
        "joint-states-two-values",
        "Two nodes publish joint states of the same joints.",
        "Stop one of them.",
        Heading.RECORDINGS,
    ),
    Rule("joint-not-a-number", "A position is NaN or infinite.", "Mend the driver.", Heading.RECORDINGS),
    Rule(
        "joint-beyond-limit",
        "A warning: a joint was beyond its limits.",
        "Correct the limits, the zero of the servo, or what drives it there.",
        Heading.RECORDINGS,
    ),
    Rule(
        "joint-off-its-leader",
        "A warning: a driver reports a joint that mimics another one elsewhere than where that one puts it.",
        "Correct `mimic`, or let the driver leave followers out: robot_state_publisher takes what is reported.",
        Heading.RECORDINGS,
    ),
    Rule(
        "other-robot-description",
        "`/robot_description` is another robot than the compiled URDF.",
        "Deploy what is compiled.",
        Heading.RECORDINGS,
    ),
    Rule(
        "robot-description-text",
        "A note: it means the same, in another text.",
        "Deploy what is compiled.",
        Heading.RECORDINGS,
    ),
    Rule(
        "robot-description-changed",
        "A warning: there was more than one while the robot ran.",
        "Start one robot_state_publisher, with one URDF.",
        Heading.RECORDINGS,
    ),
)


def judge(recording: Recording, artifacts: Sequence[Artifact]) -> list[Diagnostic]:
    """Return what is wrong with a recording, held against the description and the compiled artifacts."""
    Progress.step("judging the recording")
    findings = list(recording.troubles)
    prefixed = judge_tree.prefixed(recording)
    if prefixed is not None:  # of frames that have other names nothing else can be said
        findings += [prefixed, *judge_stamps.clocks(recording), *joints(recording)]
        return ordered([*findings, *robot_description(recording, artifacts)])
    findings += judge_edges.dropped(recording)
    nothing = not (recording.series or recording.rows or recording.asked or recording.refused)
    if (
        nothing
        and (recording.timed or not recording.sensors)
        and not recording.joints.pace.count
        and not recording.descriptions
    ):
        return ordered([*findings, *_nothing(recording, findings)])
    findings += judge_edges.edges(recording)
    findings += judge_tree.other_modes(recording)
    findings += judge_tree.missing(recording)
    findings += judge_tree.stale(recording)
    findings += judge_tree.late(recording)
    findings += judge_stamps.clocks(recording)
    findings += joints(recording)
    findings += robot_description(recording, artifacts)
    findings += judge_sensors.sensors(recording)
    findings += rows(recording)
    findings += asked(recording)
    if recording.too_many:
        message = f"there are more than {len(recording.series):,} edges; the others were not looked at"
        findings.append(problem("recording-foreign", "the recording", message, "no robot has as many frames"))
    findings += _nothing(recording, findings) if nothing else _no_edge(recording, findings)
    return ordered(findings)


def _nothing(recording: Recording, findings: Sequence[Diagnostic]) -> Iterator[Diagnostic]:
    """Yield the finding for a recording of no edge at all, unless an error says so: nothing can be concluded of it."""
    if not any(finding.severity == ERROR for finding in findings):
        yield _foreign(recording)


def _no_edge(recording: Recording, findings: Sequence[Diagnostic]) -> Iterator[Diagnostic]:
    """Yield the finding for a recording of which not one edge is described, unless an error says so."""
    known = recording.description.by_child
    edges = [(one.parent, one.child) for one in recording.series.values()]
    edges += [(row.parent, row.child) for row in recording.rows]
    described = any(parent == edge.parent for parent, child in edges for edge in known.get(child, ()))
    if described or recording.asked or any(finding.severity == ERROR for finding in findings):
        return
    message = f"none of the {counted(len(edges), 'edge')} of the recording is described: nothing could be compared"
    help = "look whether this is the recording of this robot, and its description"
    yield problem("not-compared", "the recording", message, help)


def _foreign(recording: Recording) -> Diagnostic:
    topics = sorted(recording.topics)
    help = "record /tf, /tf_static, /joint_states and /robot_description"
    if recording.messages == 0 and not topics:
        return problem("recording-empty", "the recording", "the recording has no messages", help)
    shown = f": it has {first_of(topics, 6)}" if topics else ""
    namespaced = [topic for topic in topics if topic.endswith("/tf")]
    if namespaced and not recording.description.options.namespace:
        help = f"--namespace {namespaced[0].removesuffix('/tf')} reads {namespaced[0]}"
    return problem("recording-foreign", "the recording", f"the recording has no transforms{shown}", help)


@dataclass(frozen=True)
class Verdict:
    """A recording, the description that it was compared with, and the findings, the most serious first."""

    recording: Recording
    description: Description
    findings: list[Diagnostic]

    def count(self, severity: str) -> int:
        """Return how many findings are of a severity."""
        return sum(finding.severity == severity for finding in self.findings)

    def fails(self, strict: bool = False) -> bool:
        """Whether the robot that ran is not the one that is described; ``strict`` takes warnings for errors."""
        return bool(self.count(ERROR) or (strict and self.count(WARNING)))


_SHOWN, _FEW = 8, 3
_TOPIC = "/joint_states"


def joints(recording: Recording) -> Iterator[Diagnostic]:
    """Yield what is wrong with the joint states, and what could not be compared without them."""
    log = recording.joints
    robot = recording.description.robot
    moving = [series for series in recording.series.values() if not series.constant and series.reference is not None]
    if not log.pace.count:
        if moving:
            message = (
                f"there is no {_TOPIC}: {len(moving)} moving edges were compared only with what their joints can do"
            )
            yield problem("not-compared", _TOPIC, message, f"record {_TOPIC}, too", severity=NOTE)
        return
    yield from _unknown(recording, [name for name in log.names if name not in robot.joint])
    absent = [joint.name for joint in robot.joints if joint.name in recording.description.joint_names - set(log.names)]
    if absent:
        message = f"{_TOPIC} never names {', '.join(absent)}: robot_state_publisher does not publish what hangs on it"
        help = "the driver has to report every joint that robot_state_publisher moves"
        yield problem("joint-state-missing", _TOPIC, message, help, numbers={"joints": absent})
    if log.leaps.two:
        message = f"{_TOPIC} has two values in turns: {leaps_text(log.leaps)}"
        help = "two nodes publish joint states, such as joint_state_publisher beside the driver: stop one"
        yield problem("joint-states-two-values", _TOPIC, message, help)
    if log.too_short:
        message = f"{share(log.too_short, log.pace.count)} messages of {_TOPIC} have fewer positions than names"
        yield problem("joint-state-short", _TOPIC, message, "the driver has to give a position for each name")
    for name, seen in log.ranges.items():
        yield from _range(log, name, seen)
    for name, follower in log.followers.items():
        yield from _follower(log, name, follower)
    unmatched = [series for series in moving if series.values.compared and not series.values.by_state]
    if unmatched and len(unmatched) < len(moving):
        names = first_of([series.name for series in unmatched], _FEW)
        message = f"{names} never had the stamp of a message of {_TOPIC} that names its joint: compared only with what "
        message += "the joint can do"
        yield problem("not-compared", _TOPIC, message, "look who else publishes it", severity=NOTE)
    elif unmatched:
        message = f"no transform has the stamp of a message of {_TOPIC}: compared only with what the joints can do"
        help = "robot_state_publisher with ignore_timestamp, or another clock, does that"
        yield problem("not-compared", _TOPIC, message, help, severity=NOTE)


def _unknown(recording: Recording, names: Sequence[str]) -> Iterator[Diagnostic]:
    for name in names if len(names) <= _FEW else ():
        help = did_you_mean(name, recording.description.joint_names)
        message = f'{_TOPIC} names "{name}", a joint that is not described'
        yield problem("joint-state-unknown", _TOPIC, message, help)
    if len(names) > _FEW:
        shown = first_of([f'"{name}"' for name in names], _SHOWN)
        message = f"{_TOPIC} names {len(names)} joints that are not described: {shown}"
        help = "describe them, or look whether this is the recording of this robot"
        yield problem("joint-state-unknown", _TOPIC, message, help, numbers={"joints": list(names)})


def _follower(log: JointLog, name: str, follower: Follower) -> Iterator[Diagnostic]:
    joint = log.description.robot.joint[name]
    if not follower.off or joint.mimic is None:
        return
    unit = "m" if joint.type == "prismatic" else "rad"
    often, most = share(follower.off, follower.seen), amount(follower.farthest, unit)
    ratio = f"{joint.mimic.multiplier:.6g} times {joint.mimic.joint}"
    ratio += f" {joint.mimic.offset:+.6g} {unit}" if joint.mimic.offset else ""
    message = f"{name} is not {ratio} in {often} messages of {_TOPIC}, by {most} at most"
    help = "robot_state_publisher takes what is reported: correct the ratio, or let the driver leave followers out"
    yield problem("joint-off-its-leader", name, message, help, severity=WARNING, numbers={"apart": follower.farthest})


def _range(log: JointLog, name: str, seen: Range) -> Iterator[Diagnostic]:
    if seen.not_numbers:
        message = f"{name} is no number in {share(seen.not_numbers, seen.seen)} messages of {_TOPIC}"
        yield problem("joint-not-a-number", _TOPIC, message, "mend the driver")
    if seen.beyond:
        lower, upper = log.limits(name)
        excess = max(lower - seen.lowest, seen.highest - upper)
        unit = "m" if log.description.robot.joint[name].type == "prismatic" else "rad"
        often, most = share(seen.beyond, seen.seen), amount(excess, unit)
        message = f"{name} is beyond its limits in {often} messages, by {most} at most"
        evidence = [f"seen {_span(seen.lowest, seen.highest)} {unit}, described {_span(lower, upper)} {unit}"]
        help = "correct the limits, the zero of the servo, or what drives it there"
        yield problem(
            "joint-beyond-limit", name, message, help, severity=WARNING, evidence=evidence, numbers={"excess": excess}
        )


def _span(lower: float, upper: float) -> str:
    texts = [f"{value:.6g}" if math.isfinite(value) else "any" for value in (lower, upper)]
    return f"{texts[0]} to {texts[1]}"


def robot_description(recording: Recording, artifacts: Sequence[Artifact]) -> Iterator[Diagnostic]:
    """Yield how the URDF that ran differs from the compiled one."""
    compiled = next((one for one in artifacts if FORMATS.feeds(one, ROBOT_STATE_PUBLISHER)), None)
    if not recording.descriptions or compiled is None:
        return
    topic = "/robot_description"
    if len(recording.descriptions) > 1:
        message = f"{topic} carried {len(recording.descriptions)} different robots"
        help = "two robot_state_publishers, or one that was given another URDF while it ran"
        yield problem("robot-description-changed", topic, message, help, severity=WARNING)
    for ran in recording.descriptions:
        if ran.rstrip() == compiled.text.encode().rstrip():
            continue
        comparison = compare(recording.description.robot, [compiled], {compiled.file: ran})
        evidence = [f"ran -> compiled: {change.line()}" for change in comparison.changes[:_SHOWN]]
        if len(comparison.changes) > _SHOWN:
            evidence.append(f"...{and_more(len(comparison.changes) - _SHOWN)}")
        if comparison.changes:
            many = counted(len(comparison.changes), "difference")
            message = f"{topic} is not the compiled {compiled.file}: {many} of meaning"
            help = "deploy what is compiled, and start robot_state_publisher again"
            yield problem("other-robot-description", topic, message, help, evidence=evidence)
        elif any("damaged" in difference.remark for difference in comparison.texts):
            message = f"{topic} cannot be read as a URDF"
            evidence = [text.remark.partition("(")[2].removesuffix(")") for text in comparison.texts if text.remark]
            yield problem("other-robot-description", topic, message, "look what was given to it", evidence=evidence)
        else:
            message = f"{topic} means what the compiled {compiled.file} means, in another text"
            help = "deploy what is compiled, so that the two stay the same"
            yield problem("robot-description-text", topic, message, help, severity=NOTE)


def asked(recording: Recording) -> Iterator[Diagnostic]:
    """Yield the answers of tf2_echo that are not what the description gives."""
    refused = {(question.source, question.target): question for question in recording.refused}
    answers = []
    for answer in recording.asked:
        refused.pop((answer.source, answer.target), None)
        answers.append(list(_answer(recording, answer)))
    nothing = not recording.series and all(of and of[0].rule == "not-compared" for of in answers)
    for finding in (finding for of in answers for finding in of):
        yield replace(finding, severity=ERROR) if nothing else finding
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
    robot = description.robot
    try:
        way = robot.kinematics.graph.way(answer.source, answer.target)
    except NoWay as no_way:
        missing = [f"{s.parent} -> {s.child}, which {description.owners(s.child)} alone knows" for s in no_way.missing]
        message = f"{name} cannot be compared: between them is {', '.join(missing) or 'nothing that is described'}"
        yield problem("not-compared", name, message, "ask for frames of the robot itself", severity=NOTE)
        return
    joints = [move.step.joint for move in way if move.step.joint is not None and move.step.joint.moves]
    needed = {description.leader(joint)[0] for joint in joints}
    absent = [joint.name for joint in robot.joints if joint.name in needed - set(answer.positions)]
    if absent:
        message = f"{name} cannot be compared: where {', '.join(absent)} stood is not known"
        yield problem("not-compared", name, message, "give --pose, or paste /joint_states above", severity=NOTE)
        return
    expected = Transform()
    for move in way:
        value = move.step.transform(robot, answer.positions)
        expected = expected.then(value.inverse() if move.up else value)
    for reading in answer.readings:
        finding = _reading(recording, name, answer, reading, expected)
        if finding is not None:
            yield finding
            return


def _reading(
    recording: Recording, name: str, answer: Asked, reading: Reading, expected: Transform
) -> Diagnostic | None:
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
    yield from judge_stamps.of_rows(recording)


def _row(recording: Recording, row: FrameRow) -> Iterator[Diagnostic]:
    name = f"{row.parent} -> {row.child}"
    expected = recording.description.by_child.get(row.child)
    if expected is None:
        message = f"{name} was published, but no such edge is described"
        help = did_you_mean(row.child, recording.description.frames)
        help = help if help.startswith("did you mean") else "declare it under edges, with the node that publishes it"
        yield problem("edge-not-described", name, message, help, severity=WARNING)
        return
    edge = recording.expected(row.parent, row.child, row.still) or expected[0]
    if edge.parent != row.parent:
        message = f'the parent of "{row.child}" is "{row.parent}", described is "{edge.parent}"'
        yield problem("edge-wrong-parent", name, message, f"{edge.owner} should publish {edge.name}")
    yield from judge_edges.on_wrong_topic(name, row.still, edge, f" at {row.rate:.1f} Hz")
    limit = recording.description.options.stale
    if not row.still and row.age is not None and limit < row.age <= YEAR:
        message = f"{name} went {seconds(row.age)} stale, when view_frames looked"
        help = f"whoever asks then gets where things were {seconds(row.age)} ago: look why {edge.owner} stopped"
        evidence = [f"average rate {row.rate:.1f} Hz"]
        yield problem("edge-stale", name, message, f"{help} (--stale: {seconds(limit)})", evidence=evidence)
