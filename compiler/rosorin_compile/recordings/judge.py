"""Compare a recording with its description: clocks, joints, sensors and tf2_echo (``judge_edges`` checks edges)."""

from collections.abc import Iterator, Sequence
from dataclasses import replace

from rosorin_compile.compare.golden_check import compare
from rosorin_compile.formats import FORMATS
from rosorin_compile.formats.format import Artifact
from rosorin_compile.model import ROBOT_STATE_PUBLISHER, Sensor, Transform
from rosorin_compile.model.kinematics import NoWay
from rosorin_compile.source.diagnostics import ERROR, WARNING, Diagnostic, Help, Suggestion
from rosorin_compile.source.numbers import amount
from rosorin_compile.source.progress import Progress
from rosorin_compile.source.wording import and_more, count_of, first_of, nearest, phrase, quote

from .judge_edges import check_prefix, dropped_transforms, edges, late, leaps_text, missing_edges, other_modes, stale
from .recording import Answer, FrameUse, Recording
from .results import YEAR, Lookup, difference, pose_text, problem, rate_text, seconds, share, sort_findings, value_rule
from .series import AHEAD, SIMULATED, Pace

_SHOWN, _FEW = 8, 3
_STATES, _ROBOT = "/joint_states", "/robot_description"
# s: report stamps that are farther in the future. AMCL stamps map -> odom 1 s ahead, slam_toolbox 0.5 s.
_FAR_AHEAD = 1.2
# Topics share a finding if their stamps are equally far ahead, within this fraction or this time (s).
_SIMILAR, _NEAR = 0.1, 0.1
_FAILS = 0.05  # smallest share of failed lookups to report; a few are normal, because messages overtake each other
# An unknown frame_id is an error in messages of these packages, and a warning in other messages.
_PLACED = ("sensor_msgs", "geometry_msgs", "nav_msgs", "visualization_msgs", "vision_msgs", "stereo_msgs")
_IMAGES = ("sensor_msgs/msg/Image", "sensor_msgs/msg/CompressedImage", "sensor_msgs/msg/CameraInfo")
# Message types by the type of a sensor in the description (parts/sensors.yaml).
_MESSAGES = {
    "lidar_2d": ("sensor_msgs/msg/LaserScan", "sensor_msgs/msg/MultiEchoLaserScan"),
    "lidar_3d": ("sensor_msgs/msg/PointCloud2",),
    "camera": _IMAGES,
    "depth_camera": (*_IMAGES, "sensor_msgs/msg/PointCloud2"),
    "imu": ("sensor_msgs/msg/Imu",),
    "range_finder": ("sensor_msgs/msg/Range",),
    "gnss": ("sensor_msgs/msg/NavSatFix",),
    "magnetometer": ("sensor_msgs/msg/MagneticField",),
    "force_torque": ("geometry_msgs/msg/WrenchStamped",),
}
_OF_SENSORS = {each for types in _MESSAGES.values() for each in types}


def judge(recording: Recording, artifacts: Sequence[Artifact]) -> list[Diagnostic]:
    """Compare a recording with its description and the compiled artifacts; return the findings, errors first."""
    Progress.step("judging the recording")
    findings = list(recording.troubles)
    if (prefix := check_prefix(recording)) is not None:  # without the right prefix, no frame can be compared
        findings += [prefix, *_clocks(recording), *_joints(recording)]
        return sort_findings([*findings, *_robot_description(recording, artifacts)])
    findings += dropped_transforms(recording)
    tree = recording.series or recording.answers or recording.refused
    stamped = recording.uses and not recording.timed
    if tree or stamped or recording.joints.pace.count or recording.descriptions:
        for rule in (edges, other_modes, missing_edges, stale, late, _clocks, _joints):
            findings += rule(recording)
        findings += [*_robot_description(recording, artifacts), *_sensors(recording), *_answers(recording)]
    if not any(finding.severity == ERROR for finding in findings):
        findings += _nothing_compared(recording, bool(tree))
    return sort_findings(findings)


def _nothing_compared(recording: Recording, has_tree: bool) -> Iterator[Diagnostic]:
    """Yield a finding if a recording has no transforms, or if none of its transforms is in the description."""
    topics, subject = sorted(recording.topics), "the recording"
    if not has_tree and recording.messages == 0 and not topics:
        yield problem("recording-empty", subject, "the recording has no messages")
    elif not has_tree:
        help, shown = "", f": it has {first_of(topics, 6)}" if topics else ""
        namespaced = next((topic for topic in topics if topic.endswith("/tf")), "")
        if namespaced and not recording.description.options.namespace:
            help = f"--namespace {namespaced.removesuffix('/tf')} reads {namespaced}"
        yield problem("recording-foreign", subject, f"the recording has no transforms{shown}", help)
    elif not any(series.has_parent for series in recording.series.values()) and not recording.answers:
        count = count_of(len(recording.series), "edge")
        message = f"none of the {count} of the recording is described: nothing could be compared"
        help = "look whether this is the recording of this robot, and its description"
        yield problem("not-compared", subject, message, help, severity=ERROR)


def _joints(recording: Recording) -> Iterator[Diagnostic]:
    states, robot = recording.joints, recording.description.robot
    moving = [series for series in recording.series.values() if series.compared and not series.constant]
    if not states.pace.count:
        message = f"there is no {_STATES}: {len(moving)} moving edges were compared only with what their joints can do"
        yield from [problem("not-compared", _STATES, message)] if moving else []
        return
    names = recording.description.joint_names
    if unknown := [name for name in states.reported if name not in robot.joint]:
        message = f"{_STATES} names joints that are not described: {quote(unknown, _SHOWN)}"
        help: Help = Suggestion(unknown[0], names) if len(unknown) == 1 else ""
        yield problem("joint-state-unknown", _STATES, message, help)
    if absent := [joint.name for joint in robot.joints if joint.name in names - states.reported.keys()]:
        message = f"{_STATES} never names {', '.join(absent)}: robot_state_publisher does not publish what hangs on it"
        yield problem("joint-state-missing", _STATES, message)
    if states.leaps.two:
        message = f"{_STATES} has two values in turns: {leaps_text(states.leaps)}"
        yield problem("joint-states-two-values", _STATES, message)
    if recording.short_states:
        many = share(recording.short_states, states.pace.count)
        yield problem("joint-state-short", _STATES, f"{many} messages of {_STATES} have fewer positions than names")
    for name, seen in states.reported.items():
        joint = robot.joint.get(name)
        unit = "m" if joint is not None and joint.type == "prismatic" else "rad"
        if seen.not_numbers:
            message = f"{name} is not a number in {share(seen.not_numbers, seen.seen)} messages of {_STATES}"
            yield problem("joint-not-a-number", _STATES, message)
        if seen.beyond and seen.lowest is not None and seen.highest is not None:
            lower, upper = states.limits(name)
            excess = amount(max(lower - seen.lowest, seen.highest - upper), unit)
            message = f"{name} is beyond its limits in {share(seen.beyond, seen.seen)} messages, by {excess} at most"
            evidence = [f"seen {seen.lowest:.6g} to {seen.highest:.6g}, described {lower:.6g} to {upper:.6g} {unit}"]
            yield problem("joint-beyond-limit", name, message, evidence=evidence)
        if seen.wrong and joint is not None and joint.mimic is not None:
            ratio = f"{joint.mimic.multiplier:.6g} times {joint.mimic.joint}"
            ratio += f" {joint.mimic.offset:+.6g} {unit}" if joint.mimic.offset else ""
            many, most = share(seen.wrong, seen.compared), amount(seen.farthest, unit)
            message = f"{name} is not {ratio} in {many} messages of {_STATES}, by {most} at most"
            yield problem("joint-off-its-leader", name, message)
    if unmatched := [series.name for series in moving if not series.by_state]:
        message = f"{first_of(unmatched, _FEW)} never had the stamp of a message of {_STATES} that names its joint: "
        yield problem("not-compared", _STATES, f"{message}compared only with what the joint can do")


def _robot_description(recording: Recording, artifacts: Sequence[Artifact]) -> Iterator[Diagnostic]:
    if (compiled := next((one for one in artifacts if FORMATS.feeds(one, ROBOT_STATE_PUBLISHER)), None)) is None:
        return
    if len(recording.descriptions) > 1:
        message = f"{_ROBOT} carried {len(recording.descriptions)} different robots"
        yield problem("robot-description-changed", _ROBOT, message)
    for ran in (one for one in recording.descriptions if one.rstrip() != compiled.text.encode().rstrip()):
        comparison = compare(recording.description.robot, [compiled], {compiled.file: ran})
        if comparison.changes:
            evidence = [f"ran -> compiled: {change.line()}" for change in comparison.changes[:_SHOWN]]
            more, many = and_more(len(comparison.changes) - _SHOWN), count_of(len(comparison.changes), "difference")
            evidence += [f"...{more}"] if more else []
            message = f"{_ROBOT} is not the compiled {compiled.file}: {many} of meaning"
            yield problem("other-robot-description", _ROBOT, message, evidence=evidence)
        elif any("damaged" in text.remark for text in comparison.texts):
            evidence = [text.remark.partition("(")[2].partition("): ")[0] for text in comparison.texts if text.remark]
            yield problem("other-robot-description", _ROBOT, f"{_ROBOT} cannot be read as a URDF", evidence=evidence)
        else:
            message = f"{_ROBOT} means what the compiled {compiled.file} means, in another text"
            yield problem("robot-description-text", _ROBOT, message)


def _answers(recording: Recording) -> Iterator[Diagnostic]:
    judged = [_answer(recording, answer) for answer in recording.answers]
    nothing = not recording.series and all(found and found.rule == "not-compared" for found in judged)
    yield from (replace(finding, severity=ERROR) if nothing else finding for finding in judged if finding)
    answered = {answer.name for answer in recording.answers}
    for question in {one.name: one for one in recording.refused if one.name not in answered}.values():
        frames = [frame for frame in (question.source, question.target) if f'"{frame}"' in question.why]
        owners = [edge for frame in frames for edge in recording.description.by_child.get(frame, ())]
        help = owners[0].advice if owners else Suggestion(question.target, recording.description.frames)
        message = f"tf2_echo got no answer for {question.name}: {question.why}"
        yield problem("edge-missing", question.name, message, help, [f"line {question.line}"])


def answer_outcome(recording: Recording, answer: Answer) -> str:
    """Return "as described", "not as described" or "not compared" for a transform printed by tf2_echo."""
    if (finding := _answer(recording, answer)) is None:
        return "as described"
    return "not compared" if finding.rule == "not-compared" else "not as described"


def _answer(recording: Recording, answer: Answer) -> Diagnostic | None:
    """Compare a transform printed by tf2_echo with the description; return a finding, or None if both are equal."""
    description, robot, name = recording.description, recording.description.robot, answer.name
    known = description.frames | set(robot.link)
    for frame in (frame for frame in (answer.source, answer.target) if frame not in known):
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
    for reading in answer.readings:
        printed = Transform((reading.turn or expected).rows, reading.xyz or expected.xyz)
        moved = max(abs(a - b) for a, b in zip(expected.xyz, printed.xyz, strict=True)) > reading.metres
        turned = expected.angle_to(printed) > reading.radians
        if not (moved or turned):  # equal within the rounding of the printed digits
            continue
        recorded = Transform(printed.rows if turned else expected.rows, printed.xyz if moved else expected.xyz)
        place, turn = pose_text(printed).split(", ")
        shown = place if reading.turn is None else turn if reading.xyz is None else f"{place}, {turn}"
        evidence = [f"described: {pose_text(expected)}", f"printed:   {shown} (line {answer.line})"]
        edge = next((edge for edge in recording.description.edges if edge.name == answer.name), None)
        help = f"{edge.owner} publishes it: deploy what is compiled, or correct the description" if edge else ""
        message = f"{answer.name} is {difference(expected, recorded)} against the description"
        return problem(value_rule(expected, recorded), answer.name, message, help, evidence)
    return None


def _clocks(recording: Recording) -> Iterator[Diagnostic]:
    moving = [one for one in recording.series.values() if not one.static and not one.has_two_sources]
    streams: list[tuple[str, Pace]] = [(f"{one.name}{one.by_owner}", one.pace) for one in moving]
    streams += [("/joint_states", recording.joints.pace)] if recording.joints.pace.count else []
    streams += [(use.topic, use.pace) for use in recording.uses]
    if zero := [name for name, pace in streams if pace.unstamped]:
        yield problem("stamp-zero", zero[0], f"{_are(zero)} stamped with time zero")
    if back := [(name, pace.farthest_jump) for name, pace in streams if pace.jumps]:
        name, (far, at) = max(back, key=lambda one: one[1].seconds)
        where = f", {recording.since_start(at):.1f} s into the recording" if recording.timed else ""
        message = f"the stamps of {first_of([one for one, _ in back], _FEW)} jump back, by {seconds(far)} at most"
        yield problem("stamp-jumps-back", name, f"{message}{where}")
    if not recording.timed:
        leads = [(one.name, -one.age) for one in moving if one.age is not None]  # from view_frames
        yield from _other(recording, [(name, lead) for name, lead in leads if abs(lead) > YEAR])
        yield from _ahead([(name, lead) for name, lead in leads if lead <= YEAR])
        return
    streams = [(name, pace) for name, pace in streams if not pace.unstamped]
    yield from _other(recording, [(name, pace.most_ahead) for name, pace in streams if pace.other_clock])
    streams = [(name, pace) for name, pace in streams if not pace.other_clock]
    steps = [(name, pace.step) for name, pace in streams if pace.step is not None and not pace.jumps]
    waiting = sorted(steps, key=lambda one: -one[1].size)
    while waiting:
        time, was, now, size = waiting[0][1]
        near, since = max(_NEAR, _SIMILAR * size), recording.since_start(time)
        names = [name for name, step in waiting if abs(step.before - was) + abs(step.after - now) <= near]
        waiting = [one for one in waiting if one[0] not in names]
        whose = first_of(names, _FEW) if len(names) < max(len(streams), 2) else "the recorder"
        before, after = (f"{seconds(abs(lead))} {'ahead' if lead > 0 else 'behind'}" for lead in (was, now))
        when = f"from {since:.1f} s into the recording on" if since > 0 else "in the end"
        message = f"the clock of {whose} was set: stamps are {before} at first, {after} {when}"
        yield problem("stamp-clock-set", names[0], message)
    yield from _ahead([(name, pace.most_ahead) for name, pace in streams])


def _are(names: Sequence[str]) -> str:
    return f"{first_of(names, _FEW)} {'is' if len(names) == 1 else 'are'}"


def _other(recording: Recording, leads: Sequence[tuple[str, float]]) -> Iterator[Diagnostic]:
    """Yield findings for stamps from another clock; ``leads`` has topics or edges, and by how much (s) it is ahead."""
    for ahead in (False, True):
        if not (group := [(name, abs(lead)) for name, lead in leads if (lead > 0) == ahead]):
            continue
        names, far, help = [name for name, _ in group], min(lead for _, lead in group), ""
        if ahead and recording.start < SIMULATED:
            help = "the wall clock among times of a simulation: use_sim_time for all nodes or for none"
        elif far > YEAR:
            help = "simulation time (use_sim_time for all nodes or for none), or a computer that begins in 1970"
        message = f"{_are(names)} stamped by another clock, {seconds(far)} {'ahead' if ahead else 'behind'}"
        yield problem("stamp-other-clock", names[0], message, help)


def _ahead(leads: Sequence[tuple[str, float]]) -> Iterator[Diagnostic]:
    """Yield findings for topics and edges with stamps in the future, one for each group with a similar offset."""
    waiting = sorted((one for one in leads if one[1] > _FAR_AHEAD), key=lambda one: -one[1])
    while waiting:
        most = waiting[0][1]
        names = [name for name, lead in waiting if most - lead <= max(_NEAR, _SIMILAR * most)]
        waiting = waiting[len(names) :]
        was = "it was" if len(names) == 1 else "they were"
        message = f"{_are(names)} dated {seconds(most)} ahead of the time when {was} recorded"
        help = "all streams are: the clock of the recorder is behind" if len(names) == len(leads) > 1 else ""
        yield problem("stamp-ahead", names[0], message, help)


def _sensors(recording: Recording) -> Iterator[Diagnostic]:
    """Yield findings for each frame_id that is unknown, available too late, or missing at the time of a stamp."""
    failing: dict[str, list[tuple[FrameUse, Lookup]]] = {}
    late: dict[str, list[FrameUse]] = {}
    for use in recording.uses:
        if finding := _unknown(recording, use) or (_slashed(recording, use) if use.slashed else None):
            yield finding
            continue
        if use.early and use.ready is not None:
            late.setdefault(use.frame, []).append(use)
        base = recording.description.top(use.frame)
        lookups, slowest = use.lookups.get(base), use.slowest.get(base)
        if lookups is None or slowest is None or lookups.failed <= max(2, _FAILS * lookups.asked):
            continue
        if not use.pace.other_clock and not slowest.pace.other_clock:
            failing.setdefault(use.frame, []).append((use, lookups))
    yield from _not_as_declared(recording)
    for uses in late.values():
        worst = max(uses, key=lambda use: use.early)
        first, ready = recording.since_start(worst.pace.first), recording.since_start(worst.ready or 0)
        message = f'the frame "{worst.frame}" came {seconds(ready - first)} after the first message of {worst.topic}'
        evidence = [f"first message {first:.2f} s into the recording, {worst.waited_for} at {ready:.2f} s"]
        evidence += [f"{use.topic}: {share(use.early, use.pace.count)} messages could not be placed" for use in uses]
        yield problem("frame-late", worst.topic, message, evidence=evidence)
    for group in failing.values():
        use, lookups = max(group, key=lambda entry: entry[1].failed / entry[1].asked)
        slowest = use.slowest[lookups.target]
        lag = f"the tree was {seconds(lookups.mean_lag)} behind, {seconds(lookups.largest_lag)} at most"
        message = f"{use.topic}: {use.frame} in {lookups.target} could not be looked up at the exact stamp for "
        message += f"{share(lookups.failed, lookups.asked)} messages; {lag}"
        evidence = [f"slowest is {slowest.name}{slowest.by_owner} at {rate_text(slowest.pace.rate)}"]
        if slowest.by_state:
            evidence[0] += f", which follows {_STATES} at {rate_text(recording.joints.pace.rate)}"
        if use.pace.most_ahead > AHEAD:
            evidence.append(f"its own stamps are up to {seconds(use.pace.most_ahead)} ahead of the time when they came")
        evidence += [f"also {other.topic}: {share(its.failed, its.asked)}" for other, its in group if other is not use]
        yield problem("lookup-fails", use.topic, message, evidence=evidence)


def _severity(use: FrameUse) -> str:
    return ERROR if not use.type or use.type.split("/")[0] in _PLACED else WARNING


def _unknown(recording: Recording, use: FrameUse) -> Diagnostic | None:
    known = recording.description.frames
    if use.frame in known or use.frame in recording.parents or use.frame in recording.parents.values():
        return None
    if not use.frame:
        message, matters = f"{use.topic} is stamped with no frame", not use.type or use.type.startswith("sensor_msgs/")
        return problem("frame-unknown", use.topic, message, severity=WARNING) if matters else None
    many = count_of(use.pace.count, "message")
    message = f'{use.topic} is stamped "{use.frame}" ({many}), a frame that is neither described nor published'
    help: Help = ""
    if use.frame in recording.description.robot.link:
        help = "the description has this frame, but no node that publishes it"
    elif nearest(use.frame, known):
        help = Suggestion(use.frame, known)
    return problem("frame-unknown", use.topic, message, help, severity=_severity(use))


def _slashed(recording: Recording, use: FrameUse) -> Diagnostic:
    name = recording.description.options.prefix + use.frame
    many = share(use.slashed, use.pace.count) if use.slashed < use.pace.count else f"{use.slashed:,}"
    message = f'{use.topic} is stamped "/{name}" ({many} messages): tf2 rejects lookups of a frame that begins with "/"'
    help = f'set frame_id to "{name}" in the driver: tf2 strips the "/" of a transform, not of a message'
    return problem("frame-with-slash", use.topic, message, help, severity=_severity(use))


def _not_as_declared(recording: Recording) -> Iterator[Diagnostic]:
    """Yield findings for sensors whose messages have a different frame_id than the frame in the description."""
    suspects: dict[tuple[str, ...], list[Sensor]] = {}
    sensors = recording.description.robot.sensors
    for sensor in sensors:
        types = _MESSAGES.get(sensor.type, ())
        used = {use.frame for use in recording.uses if use.type in types or use.type not in _OF_SENSORS}
        if sensor.stamps and not used & set(sensor.stamps):
            explained = set()  # topics of another sensor or ROS node, or with a frame_id that is reported already
            for use in recording.uses:
                stamps = [one.stamps for one in recording.description.robot.publishers]
                stamps += [one.stamps for one in sensors if use.type in _MESSAGES.get(one.type, (use.type,))]
                is_below = any(recording.chain(use.frame, frame) for frame in sensor.stamps)
                if is_below or any(use.frame in some for some in stamps) or _unknown(recording, use) is not None:
                    explained.add(use.topic)
            if fitting := [use.topic for use in recording.uses if use.type in types and use.topic not in explained]:
                suspects.setdefault(tuple(dict.fromkeys(fitting)), []).append(sensor)
    for topics, suspected in suspects.items():
        uses = [use for use in recording.uses if use.topic in topics]
        frames = list(dict.fromkeys(use.frame for use in uses))
        declared = phrase((f"{quote(one.stamps)} ({one.name})" for one in suspected), most=4)
        many = count_of(sum(use.pace.count for use in uses), "message")
        message = f"{phrase(topics, most=4)} {'is' if len(topics) == 1 else 'are'} stamped {quote(frames)} ({many}), "
        message += f"and no message with what is declared: {declared}"
        help = f"set frame_id in the driver, or declare what it stamps: stamps: [{', '.join(frames)}]"
        severity = ERROR if recording.description.frames >= set(frames) else WARNING
        yield problem("frame-not-as-declared", topics[0], message, help, severity=severity)
