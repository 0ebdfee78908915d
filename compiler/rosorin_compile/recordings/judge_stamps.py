"""Judge stamped messages: clocks that differ or were set, frames, and whether tf2 could have transformed them."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from rosorin_compile.model import Sensor
from rosorin_compile.source.diagnostics import ERROR, WARNING, Diagnostic, Help, Suggestion
from rosorin_compile.source.wording import counted, first_of, listed, nearest

from .findings import YEAR, problem, rate_text, seconds, share
from .recording import FrameUse, Lookups, Recording
from .timing import AHEAD, SECOND, SIMULATED, Pace, Step

_SHOWN = 3
# AMCL dates map -> odom 1 s ahead (transform_tolerance), slam_toolbox 0.5 s; more than this (s) is reported.
_FAR_AHEAD = 1.2
# Clocks that differ by less (a share, or s) are the same.
_SIMILAR, _NEAR = 0.1, 0.1
_FAILS = 0.05  # share of failed lookups from which on they are reported; a few messages are overtaken
# Messages of these packages are about a place; the header of others may be only a stamp.
_PLACED = ("sensor_msgs", "geometry_msgs", "nav_msgs", "visualization_msgs", "vision_msgs", "stereo_msgs")
_IMAGES = ("sensor_msgs/msg/Image", "sensor_msgs/msg/CompressedImage", "sensor_msgs/msg/CameraInfo")
# The messages of the sensor types that ship with the tool (parts/sensors.yaml).
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

Leads = Sequence[tuple[str, float]]  # name of a stream, and how far it is dated ahead (s)


def clocks(recording: Recording) -> Iterator[Diagnostic]:
    """Yield the faults of the clocks that stamp."""
    moving = [one for one in recording.series.values() if not one.static and not one.has_two_sources]
    streams: list[tuple[str, Pace]] = [(f"{one.name}{one.by_owner}", one.pace) for one in moving]
    streams += [("/joint_states", recording.joints.pace)] if recording.joints.pace.count else []
    streams += [(use.topic, use.pace) for use in recording.uses]
    if zero := [name for name, pace in streams if pace.unstamped]:
        yield problem("stamp-zero", zero[0], f"{_are(zero)} stamped with time zero")
    if back := [(name, pace.farthest_jump) for name, pace in streams if pace.jumps]:
        name, (far, at) = max(back, key=lambda one: one[1].seconds)
        where = f", {recording.since_start(at):.1f} s into the recording" if recording.timed else ""
        names = first_of([name for name, _ in back], _SHOWN)
        message = f"the stamps of {names} jump back, by {seconds(far)} at most{where}"
        yield problem("stamp-jumps-back", name, message)
    if recording.timed:
        streams = [(name, pace) for name, pace in streams if not pace.unstamped]
        yield from _other(recording, [(name, pace.most_ahead) for name, pace in streams if pace.other_clock])
        streams = [(name, pace) for name, pace in streams if not pace.other_clock]
        steps = [(name, pace.step) for name, pace in streams if pace.step is not None and not pace.jumps]
        yield from _steps(recording, steps, len(streams))
        yield from _ahead([(name, pace.most_ahead) for name, pace in streams])


def row_clocks(recording: Recording) -> Iterator[Diagnostic]:
    """Yield the faults of the clocks of the edges that view_frames saw."""
    leads = [(row.name, -row.age) for row in recording.rows if not row.static and row.age is not None]
    yield from _other(recording, [(name, lead) for name, lead in leads if abs(lead) > YEAR])
    yield from _ahead([(name, lead) for name, lead in leads if lead <= YEAR])


def _are(names: Sequence[str]) -> str:
    return f"{first_of(names, _SHOWN)} {'is' if len(names) == 1 else 'are'}"


def _other(recording: Recording, leads: Leads) -> Iterator[Diagnostic]:
    """Yield the findings for streams with other clocks: those behind, and those ahead."""
    for ahead in (False, True):
        group = [(name, abs(lead)) for name, lead in leads if (lead > 0) == ahead]
        if not group:
            continue
        names, far, help = [name for name, _ in group], min(lead for _, lead in group), ""
        if ahead and (recording.start or 0) < SIMULATED:
            help = "the wall clock among times of a simulation: use_sim_time for all nodes or for none"
        elif far > YEAR:
            help = "simulation time (use_sim_time for all nodes or for none), or a computer that begins in 1970"
        message = f"{_are(names)} stamped by another clock, {seconds(far)} {'ahead' if ahead else 'behind'}"
        yield problem("stamp-other-clock", names[0], message, help)


def _ahead(leads: Leads) -> Iterator[Diagnostic]:
    """Yield the findings for streams that are dated ahead; each clock once."""
    waiting = sorted((one for one in leads if one[1] > _FAR_AHEAD), key=lambda one: -one[1])
    while waiting:
        most = waiting[0][1]
        names = [name for name, lead in waiting if most - lead <= max(_NEAR, _SIMILAR * most)]
        waiting = waiting[len(names) :]
        was = "it was" if len(names) == 1 else "they were"
        message = f"{_are(names)} dated {seconds(most)} ahead of the time when {was} recorded"
        help = "all streams are: the clock of the recorder is behind" if len(names) == len(leads) > 1 else ""
        yield problem("stamp-ahead", names[0], message, help)


def _steps(recording: Recording, steps: Sequence[tuple[str, Step]], count: int) -> Iterator[Diagnostic]:
    """Yield the findings for clocks that were set, of ``count`` streams; each clock once."""
    waiting = sorted(steps, key=lambda one: -one[1].size)
    while waiting:
        first = waiting[0][1]
        near = max(_NEAR, _SIMILAR * first.size)
        same = [one for one in waiting if abs(one[1].before - first.before) + abs(one[1].after - first.after) <= near]
        waiting = [one for one in waiting if one not in same]
        names, at = [name for name, _ in same], recording.since_start(first.time)
        whose = first_of(names, _SHOWN) if len(names) < max(count, 2) else "the recorder"
        before, after = (
            f"{seconds(abs(lead))} {'ahead' if lead > 0 else 'behind'}" for lead in (first.before, first.after)
        )
        when = f"from {at:.1f} s into the recording on" if at > 0 else "in the end"
        message = f"the clock of {whose} was set: stamps are {before} at first, {after} {when}"
        yield problem("stamp-clock-set", names[0], message)


def sensors(recording: Recording) -> Iterator[Diagnostic]:
    """Yield the faults of the frames of stamped messages."""
    failing: dict[str, list[tuple[FrameUse, Lookups]]] = {}
    late: dict[str, list[FrameUse]] = {}
    for use in recording.uses:
        if finding := _unknown(recording, use) or _slashed(recording, use):
            yield finding
            continue
        if use.early and use.ready is not None:
            late.setdefault(use.frame, []).append(use)
        lookups = use.lookups.get(recording.description.top(use.frame))
        if lookups is None or lookups.slowest is None or lookups.failed <= max(2, _FAILS * lookups.asked):
            continue
        if not use.pace.other_clock and not lookups.slowest.pace.other_clock:
            failing.setdefault(use.frame, []).append((use, lookups))
    yield from _not_as_declared(recording)
    start = recording.start or 0
    for uses in late.values():
        worst = max(uses, key=lambda use: use.early)
        ready = worst.ready or 0
        message = f'the frame "{worst.frame}" did not exist when the first message of {worst.topic} came: '
        message += f"{seconds((ready - worst.pace.first) / SECOND)} later it did"
        first = f"first message {(worst.pace.first - start) / SECOND:.2f} s into the recording"
        evidence = [
            f"{first}, {worst.waited_for} at {(ready - start) / SECOND:.2f} s",
            f"{share(worst.early, worst.pace.count)} messages could not be placed",
        ]
        evidence += [f"also {use.topic}: {share(use.early, use.pace.count)}" for use in uses if use is not worst]
        yield problem("frame-late", worst.topic, message, evidence=evidence)
    for group in failing.values():
        use, lookups = max(group, key=lambda entry: entry[1].failed / entry[1].asked)
        message = f"{use.topic}: {use.frame} in {lookups.target} could not be looked up at the exact stamp for "
        message += f"{share(lookups.failed, lookups.asked)} messages; the tree was {seconds(lookups.mean_lag)} behind, "
        evidence = []
        if (slowest := lookups.slowest) is not None:
            follows = f", which follows /joint_states at {rate_text(recording.joints.pace.rate)}"
            why = f"slowest is {slowest.name}{slowest.by_owner} at {rate_text(slowest.pace.rate)}"
            evidence = [f"{why}{follows if slowest.by_state else ''}"]
        if use.pace.most_ahead > AHEAD:
            evidence.append(f"its own stamps are up to {seconds(use.pace.most_ahead)} ahead of the time when they came")
        evidence += [f"also {other.topic}: {share(its.failed, its.asked)}" for other, its in group if other is not use]
        message += f"{seconds(lookups.largest_lag)} at most"
        yield problem("lookup-fails", use.topic, message, evidence=evidence)


def _severity(use: FrameUse) -> str:
    """Return the severity of a wrong frame: an error if the message is about a place. Text does not name types."""
    return ERROR if not use.type or use.type.split("/")[0] in _PLACED else WARNING


def _unknown(recording: Recording, use: FrameUse) -> Diagnostic | None:
    known = recording.description.frames
    if use.frame in known or use.frame in recording.parents or use.frame in recording.parents.values():
        return None
    if not use.frame:
        if use.type and not use.type.startswith("sensor_msgs/"):
            return None
        message = f"{use.topic} is stamped with no frame"
        return problem("frame-unknown", use.topic, message, severity=WARNING)
    many = counted(use.pace.count, "message")
    message = f'{use.topic} is stamped "{use.frame}" ({many}), a frame that is neither described nor published'
    help: Help = ""
    if use.frame in recording.description.robot.link:
        help = "the description has this frame, but says that nobody publishes it"
    elif nearest(use.frame, known):
        help = Suggestion(use.frame, known)
    return problem("frame-unknown", use.topic, message, help, severity=_severity(use))


def _slashed(recording: Recording, use: FrameUse) -> Diagnostic | None:
    if not use.slashed:
        return None
    name = recording.description.options.prefix + use.frame
    many = share(use.slashed, use.pace.count) if use.slashed < use.pace.count else f"{use.slashed:,}"
    message = f'{use.topic} is stamped "/{name}" ({many} messages): tf2 refuses to look up a frame that begins with "/"'
    help = f'set frame_id to "{name}" in the driver: tf2 strips the "/" of a transform, not of a message'
    return problem("frame-with-slash", use.topic, message, help, severity=_severity(use))


def _not_as_declared(recording: Recording) -> Iterator[Diagnostic]:
    """Yield the sensors whose frame no message has while all messages of their types have another one."""
    topics: dict[str, list[FrameUse]] = {}
    for use in recording.uses:
        topics.setdefault(use.topic, []).append(use)
    suspects: dict[tuple[str, ...], list[Sensor]] = {}
    for sensor in recording.description.robot.sensors:
        types = _MESSAGES.get(sensor.type, ())
        used = {use.frame for use in recording.uses if use.type in types or use.type not in _OF_SENSORS}
        if sensor.stamps and not used & set(sensor.stamps):
            candidates = [topic for topic, uses in topics.items() if uses[0].type in types]
            fit = tuple(topic for topic in candidates if not _is_explained(recording, topics[topic], sensor))
            if fit:
                suspects.setdefault(fit, []).append(sensor)
    for names, group in suspects.items():
        uses = [use for topic in names for use in topics[topic]]
        frames = list(dict.fromkeys(use.frame for use in uses))
        stamped = listed(f'"{frame}"' for frame in frames)
        stamps = [listed(f'"{frame}"' for frame in sensor.stamps) for sensor in group]
        declared = listed((f"{text} ({one.name})" for text, one in zip(stamps, group, strict=True)), most=4)
        message = f"{listed(names, most=4)} {'is' if len(names) == 1 else 'are'} stamped {stamped} "
        message += f"({counted(sum(use.pace.count for use in uses), 'message')}), "
        message += f"and no message with what is declared: {declared}"
        help = f"set frame_id in the driver, or say what it stamps: stamps: [{', '.join(frames)}]"
        severity = ERROR if recording.description.frames >= set(frames) else WARNING
        yield problem("frame-not-as-declared", names[0], message, help, severity=severity)


def _is_explained(recording: Recording, uses: Sequence[FrameUse], sensor: Sensor) -> bool:
    """Return True if the frames of a topic are of other nodes, have a finding, or are below the sensor's frame."""
    robot, message_type, frames = recording.description.robot, uses[0].type, {use.frame for use in uses}
    declared = [one.stamps for one in robot.publishers]
    declared += [one.stamps for one in robot.sensors if message_type in _MESSAGES.get(one.type, (message_type,))]
    names = tuple(frame for stamps in declared for frame in stamps)
    for frame in frames:
        above = [frame]
        while (parent := recording.parents.get(above[-1], "")) and parent not in above:
            above.append(parent)
        if frame in names or set(above) & set(sensor.stamps):
            return True
    if any(_unknown(recording, use) for use in uses):
        return True
    # A frame that contains the name of a declared one is a matter of prefixes.
    strange = frames - recording.description.frames
    return any(
        frame.endswith(names) or frame.startswith(tuple(f"{name} without " for name in names)) for frame in strange
    )
