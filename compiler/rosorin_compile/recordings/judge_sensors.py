"""Judge the frames of stamped messages, and whether tf2 could have transformed them on arrival."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from rosorin_compile.model import Sensor
from rosorin_compile.source.diagnostics import (
    ERROR,
    WARNING,
    Diagnostic,
    Help,
    Suggestion,
    counted,
    listed,
    nearest,
)

from .findings import problem, rate_text, seconds, share
from .recording import FrameUse, Lookups, Recording
from .timing import AHEAD, SECOND

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
    for uses in late.values():
        yield _late(recording, uses)
    for group in failing.values():
        yield _failing(recording, group)


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


def _late(recording: Recording, uses: Sequence[FrameUse]) -> Diagnostic:
    """Return the finding for messages that came before their frame was available."""
    worst = max(uses, key=lambda use: use.early)
    start, ready = recording.start or 0, worst.ready or 0
    wait, first = (ready - worst.pace.first) / SECOND, (worst.pace.first - start) / SECOND
    message = f'the frame "{worst.frame}" did not exist when the first message of {worst.topic} came: '
    message += f"{seconds(wait)} later it did"
    evidence = [
        f"first message {first:.2f} s into the recording, {worst.waited_for} at {(ready - start) / SECOND:.2f} s",
        f"{share(worst.early, worst.pace.count)} messages could not be placed",
    ]
    evidence += [f"also {use.topic}: {share(use.early, use.pace.count)}" for use in uses if use is not worst]
    return problem("frame-late", worst.topic, message, evidence=evidence)


def _failing(recording: Recording, group: Sequence[tuple[FrameUse, Lookups]]) -> Diagnostic:
    """Return the finding for lookups of one frame that failed."""
    use, lookups = max(group, key=lambda entry: entry[1].failed / entry[1].asked)
    message = f"{use.topic}: {use.frame} in {lookups.target} could not be looked up at the exact stamp for "
    message += f"{share(lookups.failed, lookups.asked)} messages; the tree was {seconds(lookups.mean_lag)} behind, "
    message += f"{seconds(lookups.largest_lag)} at most"
    evidence = []
    if (slowest := lookups.slowest) is not None:
        owner = f" ({slowest.owner})" if slowest.owner else ""
        follows = f", which follows /joint_states at {rate_text(recording.joints.pace.rate)}"
        why = f"slowest is {slowest.name}{owner} at {rate_text(slowest.pace.rate)}"
        evidence = [f"{why}{follows if slowest.by_state else ''}"]
    if use.pace.most_ahead > AHEAD:
        evidence.append(f"its own stamps are up to {seconds(use.pace.most_ahead)} ahead of the time when they came")
    evidence += [f"also {other.topic}: {share(its.failed, its.asked)}" for other, its in group if other is not use]
    return problem("lookup-fails", use.topic, message, evidence=evidence)
