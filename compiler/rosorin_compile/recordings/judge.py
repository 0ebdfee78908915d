"""Judge a recording: all findings, the most serious first."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import replace

from rosorin_compile.formats import FORMATS
from rosorin_compile.formats.format import Artifact
from rosorin_compile.model import ROBOT_STATE_PUBLISHER, Transform
from rosorin_compile.model.kinematics import NoWay
from rosorin_compile.output.committed import compare
from rosorin_compile.source.diagnostics import ERROR, Diagnostic, Suggestion
from rosorin_compile.source.numbers import amount
from rosorin_compile.source.progress import Progress
from rosorin_compile.source.wording import and_more, counted, did_you_mean, first_of

from .findings import difference, ordered, pose_text, problem, share, value_rule
from .judge_edges import dropped, edges, late, leaps_text, missing, other_modes, prefixed, row, stale
from .judge_stamps import clocks, row_clocks, sensors
from .recording import Answer, Reading, Recording

_SHOWN, _FEW = 8, 3
_STATES, _ROBOT = "/joint_states", "/robot_description"


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
        findings += [finding for frame in recording.rows for finding in row(recording, frame)]
        findings += row_clocks(recording)
        findings += _answers(recording)
    if not any(finding.severity == ERROR for finding in findings):
        findings += _nothing_compared(recording, bool(tree))
    return ordered(findings)


def _nothing_compared(recording: Recording, has_tree: bool) -> Iterator[Diagnostic]:
    """Yield the finding for a recording without transforms, or of which no edge is described."""
    topics = sorted(recording.topics)
    if not has_tree and recording.messages == 0 and not topics:
        yield problem("recording-empty", "the recording", "the recording has no messages")
        return
    if not has_tree:
        help, shown = "", f": it has {first_of(topics, 6)}" if topics else ""
        namespaced = [topic for topic in topics if topic.endswith("/tf")]
        if namespaced and not recording.description.options.namespace:
            help = f"--namespace {namespaced[0].removesuffix('/tf')} reads {namespaced[0]}"
        yield problem("recording-foreign", "the recording", f"the recording has no transforms{shown}", help)
        return
    recorded = [(one.parent, one.child) for one in recording.series.values()]
    recorded += [(row.parent, row.child) for row in recording.rows]
    described = {(edge.parent, child) for child, edges in recording.description.by_child.items() for edge in edges}
    if not described & set(recorded) and not recording.answers:
        many = counted(len(recorded), "edge")
        message = f"none of the {many} of the recording is described: nothing could be compared"
        help = "look whether this is the recording of this robot, and its description"
        yield problem("not-compared", "the recording", message, help, severity=ERROR)


def _joints(recording: Recording) -> Iterator[Diagnostic]:
    """Yield the faults of the joint states."""
    states, robot = recording.joints, recording.description.robot
    moving = [series for series in recording.series.values() if not series.constant and series.comparable]
    if not states.pace.count:
        message = f"there is no {_STATES}: {len(moving)} moving edges were compared only with what their joints can do"
        yield from [problem("not-compared", _STATES, message)] if moving else []
        return
    unknown = [name for name in states.ranges if name not in robot.joint]
    for name in unknown if len(unknown) <= _FEW else ():
        message = f'{_STATES} names "{name}", a joint that is not described'
        yield problem("joint-state-unknown", _STATES, message, Suggestion(name, recording.description.joint_names))
    if len(unknown) > _FEW:
        shown = first_of([f'"{name}"' for name in unknown], _SHOWN)
        message = f"{_STATES} names {len(unknown)} joints that are not described: {shown}"
        yield problem("joint-state-unknown", _STATES, message)
    silent = recording.description.joint_names - states.ranges.keys()
    if absent := [joint.name for joint in robot.joints if joint.name in silent]:
        message = f"{_STATES} never names {', '.join(absent)}: robot_state_publisher does not publish what hangs on it"
        yield problem("joint-state-missing", _STATES, message)
    if states.leaps.two:
        message = f"{_STATES} has two values in turns: {leaps_text(states.leaps)}"
        yield problem("joint-states-two-values", _STATES, message)
    if states.too_short:
        message = f"{share(states.too_short, states.pace.count)} messages of {_STATES} have fewer positions than names"
        yield problem("joint-state-short", _STATES, message)
    for name in states.ranges:
        yield from _joint(recording, name)
    unmatched = [series.name for series in moving if series.compared and not series.by_state]
    if unmatched and len(unmatched) < len(moving):
        message = f"{first_of(unmatched, _FEW)} never had the stamp of a message of {_STATES} that names its joint: "
        yield problem("not-compared", _STATES, f"{message}compared only with what the joint can do")
    elif unmatched:
        message = f"no transform has the stamp of a message of {_STATES}: compared only with what the joints can do"
        help = "robot_state_publisher with ignore_timestamp, or another clock, does that"
        yield problem("not-compared", _STATES, message, help)


def _joint(recording: Recording, name: str) -> Iterator[Diagnostic]:
    """Yield the faults of the positions of one joint."""
    seen, joint = recording.joints.ranges[name], recording.description.robot.joint.get(name)
    unit = "m" if joint is not None and joint.type == "prismatic" else "rad"
    if seen.not_numbers:
        message = f"{name} is no number in {share(seen.not_numbers, seen.seen)} messages of {_STATES}"
        yield problem("joint-not-a-number", _STATES, message)
    if seen.beyond:
        limits = recording.joints.limits(name)
        excess = amount(max(limits[0] - seen.lowest, seen.highest - limits[1]), unit)
        message = f"{name} is beyond its limits in {share(seen.beyond, seen.seen)} messages, by {excess} at most"
        lower, upper = (f"{value:.6g}" if math.isfinite(value) else "any" for value in limits)
        evidence = f"seen {seen.lowest:.6g} to {seen.highest:.6g} {unit}, described {lower} to {upper} {unit}"
        yield problem("joint-beyond-limit", name, message, evidence=[evidence])
    follower = recording.joints.followers.get(name)
    if follower and follower.off and joint is not None and joint.mimic is not None:
        ratio = f"{joint.mimic.multiplier:.6g} times {joint.mimic.joint}"
        ratio += f" {joint.mimic.offset:+.6g} {unit}" if joint.mimic.offset else ""
        many, most = share(follower.off, follower.seen), amount(follower.farthest, unit)
        message = f"{name} is not {ratio} in {many} messages of {_STATES}, by {most} at most"
        yield problem("joint-off-its-leader", name, message)


def _robot_description(recording: Recording, artifacts: Sequence[Artifact]) -> Iterator[Diagnostic]:
    """Yield the differences between the URDF that ran and the compiled one."""
    compiled = next((one for one in artifacts if FORMATS.feeds(one, ROBOT_STATE_PUBLISHER)), None)
    if compiled is None:
        return
    if len(recording.descriptions) > 1:
        message = f"{_ROBOT} carried {len(recording.descriptions)} different robots"
        yield problem("robot-description-changed", _ROBOT, message)
    for ran in recording.descriptions:
        if ran.rstrip() == compiled.text.encode().rstrip():
            continue
        comparison = compare(recording.description.robot, [compiled], {compiled.file: ran})
        if comparison.changes:
            evidence = [f"ran -> compiled: {change.line()}" for change in comparison.changes[:_SHOWN]]
            more, many = len(comparison.changes) - _SHOWN, counted(len(comparison.changes), "difference")
            evidence += [f"...{and_more(more)}"] if more > 0 else []
            message = f"{_ROBOT} is not the compiled {compiled.file}: {many} of meaning"
            yield problem("other-robot-description", _ROBOT, message, evidence=evidence)
        elif any("damaged" in text.remark for text in comparison.texts):
            evidence = [text.remark.partition("(")[2].removesuffix(")") for text in comparison.texts if text.remark]
            yield problem("other-robot-description", _ROBOT, f"{_ROBOT} cannot be read as a URDF", evidence=evidence)
        else:
            message = f"{_ROBOT} means what the compiled {compiled.file} means, in another text"
            yield problem("robot-description-text", _ROBOT, message)


def _answers(recording: Recording) -> Iterator[Diagnostic]:
    """Yield the answers of tf2_echo that differ from the description, and questions that were never answered."""
    judged = [_answer(recording, answer) for answer in recording.answers]
    nothing = not recording.series and all(found and found.rule == "not-compared" for found in judged)
    for finding in filter(None, judged):
        yield replace(finding, severity=ERROR) if nothing else finding
    answered = {answer.name for answer in recording.answers}
    for question in {one.name: one for one in recording.refused if one.name not in answered}.values():
        frames = [frame for frame in (question.source, question.target) if f'"{frame}"' in question.why]
        owners = [edge for frame in frames for edge in recording.description.by_child.get(frame, ())]
        help = owners[0].advice if owners else did_you_mean(question.target, recording.description.frames)
        message = f"tf2_echo got no answer for {question.name}: {question.why}"
        yield problem("edge-missing", question.name, message, help, [f"line {question.line}"])


def answer_outcome(recording: Recording, answer: Answer) -> str:
    """Return in a few words how an answer of tf2_echo compares with the description."""
    finding = _answer(recording, answer)
    if finding is None:
        return "as described"
    return "not compared" if finding.rule == "not-compared" else "not as described"


def _answer(recording: Recording, answer: Answer) -> Diagnostic | None:
    description, robot, name = recording.description, recording.description.robot, answer.name
    known = description.frames | set(robot.link)
    for frame in (answer.source, answer.target):
        if frame not in known:
            message = f'tf2_echo was asked for "{frame}", a frame that is not described'
            return problem("frame-unknown", name, message, Suggestion(frame, known))
    try:
        way = robot.kinematics.graph.way(answer.source, answer.target)
    except NoWay as no_way:
        steps = [f"{s.parent} -> {s.child}, which {description.owners(s.child)} alone knows" for s in no_way.missing]
        message = f"{name} cannot be compared: between them is {', '.join(steps) or 'nothing that is described'}"
        return problem("not-compared", name, message, "ask for frames of the robot itself")
    joints = [move.step.joint for move in way if move.step.joint is not None and move.step.joint.moves]
    needed = {description.leader(joint) for joint in joints} - answer.positions.keys()
    if absent := [joint.name for joint in robot.joints if joint.name in needed]:
        return problem("not-compared", name, f"{name} cannot be compared: where {', '.join(absent)} stood is not known")
    expected = Transform()
    for move in way:
        value = move.step.transform(robot, answer.positions)
        expected = expected.then(value.inverse() if move.up else value)
    findings = (_reading(recording, answer, reading, expected) for reading in answer.readings)
    return next(filter(None, findings), None)


def _reading(recording: Recording, answer: Answer, reading: Reading, expected: Transform) -> Diagnostic | None:
    """Return the finding about one form of an answer; differences within the printed digits are left out."""
    printed = Transform((reading.turn or expected).rows, reading.xyz or expected.xyz)
    moved = max(abs(a - b) for a, b in zip(expected.xyz, printed.xyz, strict=True)) > reading.metres
    turned = expected.angle_to(printed) > reading.radians
    if not moved and not turned:
        return None
    recorded = Transform(printed.rows if turned else expected.rows, printed.xyz if moved else expected.xyz)
    place, turn = pose_text(printed).split(", ")
    shown = place if reading.turn is None else turn if reading.xyz is None else f"{place}, {turn}"
    evidence = [f"described: {pose_text(expected)}", f"printed:   {shown} (line {answer.line})"]
    edge = next((edge for edge in recording.description.edges if edge.name == answer.name), None)
    help = f"{edge.owner} publishes it: deploy what is compiled, or correct the description" if edge else ""
    message = f"{answer.name} is {difference(expected, recorded)[2]} against the description"
    return problem(value_rule(expected, recorded), answer.name, message, help, evidence)
