"""Judging sensors: the frames of stamped messages, and whether tf2 could have placed them when they came."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from rosorin_compile.model import Sensor
from rosorin_compile.source.diagnostics import ERROR, WARNING, Diagnostic, counted, did_you_mean, listed, nearest
from rosorin_compile.source.rule_registry import Heading, Rule

from .arrays import SECOND
from .findings import problem, rate_text, seconds, share
from .judge_edges import owner_of
from .pace import AHEAD
from .recording import FrameUse, Lookups, Recording, SensorLog

RULES = (
    Rule(
        "frame-unknown",
        "A message names a frame that is neither described nor published.",
        "Correct `frame_id` in the driver, or describe the frame.",
        Heading.RECORDINGS,
    ),
    Rule(
        "frame-with-slash",
        'Messages are stamped with a frame that begins with "/". tf2 refuses to look it up; of a transform it strips '
        "the slash.",
        "Set `frame_id` without it.",
        Heading.RECORDINGS,
    ),
    Rule(
        "frame-not-as-declared",
        "No message has the frame that a sensor is declared to stamp, and all messages of its kind have another one.",
        "Correct `frame_id` in the driver, or say under `stamps` what it stamps.",
        Heading.RECORDINGS,
    ),
    Rule(
        "frame-late",
        "The first messages of a sensor came before its frame was there.",
        "Wait for the frame, or start its publisher first.",
        Heading.RECORDINGS,
    ),
    Rule(
        "lookup-fails",
        "tf2 could not have answered at the exact stamps of messages when they came, because an edge comes too seldom.",
        "Ask for the latest transform, wait with a timeout, or publish more often.",
        Heading.RECORDINGS,
    ),
)

# From this share of lookups on that fail they are told of; one in a hundred is a message that was overtaken.
FAILS = 0.05
# What messages of these packages say is somewhere; a header of others may be a mere stamp.
_PLACED = ("sensor_msgs", "geometry_msgs", "nav_msgs", "visualization_msgs", "vision_msgs", "stereo_msgs")
_IMAGES = ("sensor_msgs/msg/Image", "sensor_msgs/msg/CompressedImage", "sensor_msgs/msg/CameraInfo")
# The messages that the types of sensors give which ship with the tool (parts/sensors.yaml).
GIVES = {
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
_GIVEN = {kind for kinds in GIVES.values() for kind in kinds}


def sensors(recording: Recording) -> Iterator[Diagnostic]:
    """Yield what is wrong with the frames of stamped messages."""
    failing: dict[str, list[tuple[SensorLog, FrameUse, Lookups]]] = {}
    late: dict[str, list[tuple[SensorLog, FrameUse]]] = {}
    for log in recording.sensors.values():
        for use in log.frames.values():
            finding = _unknown_frames(recording, log, use)
            if finding is not None:
                yield finding
                continue
            if use.slashed:
                yield _slashed(recording, log, use)
                continue
            if use.early and use.ready is not None:
                late.setdefault(use.frame, []).append((log, use))
            lookups = use.lookups.get(recording.description.top(use.frame))
            fails = lookups is not None and lookups.failed > max(2, FAILS * lookups.asked)
            if lookups is not None and fails and not _of_other_clocks(recording, use, lookups):
                failing.setdefault(use.frame, []).append((log, use, lookups))
    yield from _not_as_declared(recording)
    for frame, uses in late.items():
        yield _late(recording, frame, uses)
    for frame, asked in failing.items():
        yield _failing(recording, frame, asked)


def _of_other_clocks(recording: Recording, use: FrameUse, lookups: Lookups) -> bool:
    """Whether lookups fail because messages, or the edge that comes last, are stamped by another clock."""
    slowest = max(lookups.slowest, key=lambda name: lookups.slowest[name])
    paces = [use.pace, *(series.pace for series in recording.series.values() if series.name == slowest)]
    return any(pace.other_clock for pace in paces)


def _unknown_frames(recording: Recording, log: SensorLog, use: FrameUse) -> Diagnostic | None:
    known = recording.description.frames
    recorded = use.frame in recording.parents or use.frame in recording.parents.values()
    if use.frame in known or recorded or (not use.frame and not _is_sensor(log.kind)):
        return None
    if not use.frame:
        message = f"{log.topic} is stamped with no frame"
        return problem("frame-unknown", log.topic, message, "let the driver set frame_id", severity=WARNING)
    many = counted(use.pace.count, "message")
    message = f'{log.topic} is stamped "{use.frame}" ({many}), a frame that is neither described nor published'
    near = nearest(use.frame, known)
    help = did_you_mean(use.frame, known) if near else "set frame_id in the driver, or describe the frame"
    if use.frame in recording.description.robot.link:
        help = "the description has this frame, but says that nobody publishes it"
    return problem("frame-unknown", log.topic, message, help, severity=ERROR if _is_placed(log.kind) else WARNING)


def _slashed(recording: Recording, log: SensorLog, use: FrameUse) -> Diagnostic:
    name = recording.description.options.prefix + use.frame
    many = share(use.slashed, use.pace.count) if use.slashed < use.pace.count else f"{use.slashed:,}"
    message = f'{log.topic} is stamped "/{name}" ({many} messages): tf2 refuses to look up a frame that begins with "/"'
    help = f'set frame_id to "{name}" in the driver: tf2 strips the "/" of a transform, not of a message'
    severity = ERROR if _is_placed(log.kind) else WARNING
    return problem("frame-with-slash", log.topic, message, help, severity=severity)


def _not_as_declared(recording: Recording) -> Iterator[Diagnostic]:
    """Yield the sensors whose frame no message has that may be theirs, while all messages of their kind have others."""
    suspects: dict[tuple[str, ...], list[Sensor]] = {}
    for sensor in recording.description.robot.sensors:
        kinds = GIVES.get(sensor.type, ())
        theirs = [log for log in recording.sensors.values() if log.kind in kinds or log.kind not in _GIVEN]
        if not sensor.stamps or any(set(sensor.stamps) & log.frames.keys() for log in theirs):
            continue
        fit = [log for log in theirs if log.kind in kinds and not _explained(recording, log, sensor)]
        if fit:
            suspects.setdefault(tuple(log.topic for log in fit), []).append(sensor)
    for topics, sensors_of in suspects.items():
        yield _other_frame(recording, [recording.sensors[topic] for topic in topics], sensors_of)


def _explained(recording: Recording, log: SensorLog, sensor: Sensor) -> bool:
    """Say whether the frames of a topic are those of others, are told of elsewhere, or of another eye of a sensor.

    That hangs on a frame which the sensor stamps.
    """
    robot = recording.description.robot
    others = [one.stamps for one in robot.publishers]
    others += [one.stamps for one in robot.sensors if log.kind in GIVES.get(one.type, (log.kind,))]
    own = tuple(frame for frames in others for frame in frames)
    if any(frame in own or _hangs_on(recording, frame, sensor.stamps) for frame in log.frames):
        return True
    if any(_unknown_frames(recording, log, use) for use in log.frames.values()):
        return True
    # A frame with the name of a declared one in it is a matter of prefixes.
    strange = log.frames.keys() - recording.description.frames
    return any(frame.endswith(own) or frame.startswith(tuple(f"{name} without " for name in own)) for frame in strange)


def _hangs_on(recording: Recording, frame: str, above: Sequence[str]) -> bool:
    for _ in range(len(recording.parents) + 1):  # there may be a loop
        if frame in above:
            return True
        frame = recording.parents.get(frame, "")
    return False


def _other_frame(recording: Recording, logs: Sequence[SensorLog], sensors_of: Sequence[Sensor]) -> Diagnostic:
    frames = list(dict.fromkeys(frame for log in logs for frame in log.frames))
    many = counted(sum(use.pace.count for log in logs for use in log.frames.values()), "message")
    said = listed(f'"{frame}"' for frame in frames)
    names = listed((f"{listed(f'{frame!r}' for frame in one.stamps)} ({one.name})" for one in sensors_of), most=4)
    message = f"{listed((log.topic for log in logs), most=4)} {'is' if len(logs) == 1 else 'are'} stamped {said} "
    message += f"({many}), and no message with what is declared: {names}".replace("'", '"')
    help = f"set frame_id in the driver, or say what it stamps: stamps: [{', '.join(frames)}]"
    severity = ERROR if recording.description.frames >= set(frames) else WARNING
    numbers = {"frames": frames}
    return problem("frame-not-as-declared", logs[0].topic, message, help, severity=severity, numbers=numbers)


def _is_placed(kind: str) -> bool:
    """Say whether messages of a type say what is somewhere; of pasted text the type is not known."""
    return not kind or kind.split("/")[0] in _PLACED


def _is_sensor(kind: str) -> bool:
    return kind.startswith("sensor_msgs/") or kind == ""


def _late(recording: Recording, frame: str, uses: list[tuple[SensorLog, FrameUse]]) -> Diagnostic:
    log, use = max(uses, key=lambda both: both[1].early)
    start = recording.start or 0
    ready = start if use.ready is None else use.ready
    wait = (ready - use.pace.first) / SECOND
    first = (use.pace.first - start) / SECOND
    message = (
        f'the frame "{frame}" did not exist when the first message of {log.topic} came: {seconds(wait)} later it did'
    )
    evidence = [
        f"first message {first:.2f} s into the recording, {use.waited_for} at {(ready - start) / SECOND:.2f} s",
        f"{share(use.early, use.pace.count)} messages could not be placed",
    ]
    evidence += [f"also {other.topic}: {share(its.early, its.pace.count)}" for other, its in uses if other is not log]
    help = "let whoever uses the sensor wait for its frame, or start the publisher of the frame first"
    return problem(
        "frame-late", log.topic, message, help, evidence=evidence, numbers={"seconds": wait, "messages": use.early}
    )


def _failing(recording: Recording, frame: str, asked: list[tuple[SensorLog, FrameUse, Lookups]]) -> Diagnostic:
    log, use, lookups = max(asked, key=lambda entry: entry[2].failed / entry[2].asked)
    slowest = max(lookups.slowest, key=lambda name: lookups.slowest[name])
    series = next(series for series in recording.series.values() if series.name == slowest and not series.still)
    message = (
        f"{log.topic}: {frame} in {lookups.target} could not be looked up at the exact stamp for "
        f"{share(lookups.failed, lookups.asked)} messages; the tree was {seconds(lookups.mean_lag)} behind, "
        f"{seconds(lookups.lag_most)} at most"
    )
    why = f"slowest is {slowest}{owner_of(series)} at {rate_text(series.pace.rate)}"
    if series.values.by_state:
        why += f", which follows /joint_states at {rate_text(recording.joints.pace.rate)}"
    evidence = [why]
    if use.pace.most_ahead > AHEAD:
        evidence.append(f"its own stamps are up to {seconds(use.pace.most_ahead)} ahead of the time when they came")
    evidence += [f"also {o.topic}: {share(its.failed, its.asked)}" for o, _, its in asked if o is not log]
    help = "ask for the latest transform where things move slowly, wait with a timeout, or publish the edge more often"
    numbers = {"share": lookups.failed / lookups.asked, "lag": lookups.mean_lag, "lag_most": lookups.lag_most}
    return problem("lookup-fails", log.topic, message, help, evidence=evidence, numbers=numbers)
