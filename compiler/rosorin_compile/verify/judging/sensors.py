"""Judging sensors: the frames that stamped messages name, when they were there, and lookups at the exact stamps."""

from __future__ import annotations

from collections.abc import Iterator

from ...diagnostic import ERROR, WARNING, Diagnostic, did_you_mean, nearest
from ...registry import RECORDINGS, Rule
from ...wording import counted
from ..arrays import SECOND
from ..findings import problem, rate_text, seconds, share
from ..recording.recording import Recording
from ..recording.sensors import FrameUse, Lookups, SensorLog
from .edges import owner_of

RULES = (
    Rule(
        "frame-unknown",
        "A message names a frame that is neither described nor published.",
        "Correct `frame_id` in the driver, or describe the frame.",
        RECORDINGS,
    ),
    Rule(
        "frame-late",
        "The first messages of a sensor came before its frame was there.",
        "Wait for the frame, or start its publisher first.",
        RECORDINGS,
    ),
    Rule(
        "lookup-fails",
        "tf2 could not have answered at the exact stamps of messages when they came, because an edge comes too seldom.",
        "Ask for the latest transform, wait with a timeout, or publish more often.",
        RECORDINGS,
    ),
)

# From this share of lookups on that fail they are told of; one in a hundred is a message that was overtaken.
FAILS = 0.05
# What messages of these packages say is somewhere; a header of others may be a mere stamp.
_PLACED = ("sensor_msgs", "geometry_msgs", "nav_msgs", "visualization_msgs", "vision_msgs", "stereo_msgs")


def sensors(recording: Recording) -> Iterator[Diagnostic]:
    """Yield what is wrong with the frames of stamped messages."""
    failing: dict[str, list[tuple[SensorLog, FrameUse, Lookups]]] = {}
    late: dict[str, list[tuple[SensorLog, FrameUse]]] = {}
    for log in recording.sensors.values():
        for use in log.frames.values():
            finding = _unknown(recording, log, use)
            if finding is not None:
                yield finding
                continue
            if use.early and use.ready is not None:
                late.setdefault(use.frame, []).append((log, use))
            lookups = use.lookups.get(recording.description.top(use.frame))
            if lookups is not None and lookups.failed > max(2, FAILS * lookups.asked):
                failing.setdefault(use.frame, []).append((log, use, lookups))
    for frame, uses in late.items():
        yield _late(recording, frame, uses)
    for frame, asked in failing.items():
        yield _failing(recording, frame, asked)


def _unknown(recording: Recording, log: SensorLog, use: FrameUse) -> Diagnostic | None:
    """Return the finding for a frame that is in no tree."""
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
    placed = not log.kind or log.kind.split("/")[0] in _PLACED
    return problem("frame-unknown", log.topic, message, help, severity=ERROR if placed else WARNING)


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
    log, _, lookups = max(asked, key=lambda entry: entry[2].failed / entry[2].asked)
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
    evidence += [f"also {o.topic}: {share(its.failed, its.asked)}" for o, _, its in asked if o is not log]
    help = "ask for the latest transform where things move slowly, wait with a timeout, or publish the edge more often"
    numbers = {"share": lookups.failed / lookups.asked, "lag": lookups.mean_lag, "lag_most": lookups.lag_most}
    return problem("lookup-fails", log.topic, message, help, evidence=evidence, numbers=numbers)
