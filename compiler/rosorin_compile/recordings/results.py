"""The result of verify as plain values (schemas/recording.schema.json)."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Annotated, Any, Literal

from rosorin_compile.source.diagnostics import Diagnostic

if TYPE_CHECKING:
    from .judge import Verdict
    from .recording import FrameUse, Recording
    from .series import Series
    from .timing import Pace


@dataclass(frozen=True)
class RecordedEdge:
    """One edge on one topic."""

    parent: Annotated[str, "The parent frame."]
    child: Annotated[str, "The child frame."]
    topic: Annotated[str, "The topic: /tf or /tf_static."]
    described: Annotated[bool, "Whether the description has an edge into this frame."]
    described_parent: Annotated[str | None, "The parent frame in the description."]
    publisher: Annotated[str | None, "The node that should publish it. A recording does not name the actual one."]
    count: Annotated[int, "The number of transforms."]
    rate: Annotated[float | None, "The rate in hertz; null for fewer than two."]
    largest_gap: Annotated[float | None, "The longest time between two of them in seconds; null for text."]
    mean_age: Annotated[float | None, "The mean age on arrival in seconds; null for text."]
    oldest: Annotated[float | None, "The largest age of the newest transform in seconds; null on /tf_static."]
    compared: Annotated[int, "The number of transforms compared with the description."]
    by_joint_state: Annotated[int, "The number of them compared with the joint state of the same stamp."]
    wrong: Annotated[int, "The number of transforms that differ from the description."]
    farthest_metres: Annotated[float | None, "The largest distance from the described value in metres."]
    farthest_radians: Annotated[float | None, "The largest angle from the described value in radians."]
    values: Annotated[int, "The number of different values of an edge that should be constant."]
    two_values_at_one_stamp: Annotated[int, "The number of stamps with two values."]
    leaps_back: Annotated[int, "The number of leaps back to an earlier value."]


@dataclass(frozen=True)
class SeenFrame:
    """One frame of view_frames."""

    parent: Annotated[str, "The parent frame."]
    child: Annotated[str, "The frame."]
    static: Annotated[bool, "Whether it was published on /tf_static."]
    rate: Annotated[float | None, "Its average rate in hertz."]
    age: Annotated[float | None, "The age of its newest transform in seconds; null if unknown."]


@dataclass(frozen=True)
class RecordedJoint:
    """A joint of /joint_states."""

    name: Annotated[str, "Its name."]
    described: Annotated[bool, "Whether the description has it."]
    lowest: Annotated[float | None, "The lowest position in radians or metres."]
    highest: Annotated[float | None, "The highest position in radians or metres."]
    seen: Annotated[int, "The number of reported positions."]
    beyond_limits: Annotated[int, "The number of positions beyond its limits."]


@dataclass(frozen=True)
class Lookup:
    """Lookups at the exact stamps of the messages on their arrival."""

    target: Annotated[str, "The requested frame."]
    asked: Annotated[int, "The number of lookups."]
    failed: Annotated[int, "The number of lookups that tf2 could not have answered."]
    mean_lag: Annotated[float, "The mean delay of the tree behind the stamp for failed lookups, in seconds."]
    largest_lag: Annotated[float, "The largest delay in seconds."]


@dataclass(frozen=True)
class RecordedSensor:
    """The messages of a topic that name one frame."""

    topic: Annotated[str, "The topic."]
    type: Annotated[str, "Its type; empty if unknown."]
    frame: Annotated[str, "The frame_id."]
    count: Annotated[int, "The number of messages."]
    rate: Annotated[float | None, "The rate in hertz; null for fewer than two."]
    largest_gap: Annotated[float | None, "The longest time between two of them in seconds; null for text."]
    mean_age: Annotated[float | None, "The mean age on arrival in seconds; null for text."]
    before_the_frame: Annotated[int, "The number of messages before the frame was in the tree."]
    lookups: Annotated[list[Lookup], "Lookups by target."]


@dataclass(frozen=True)
class EchoAnswer:
    """An answer of tf2_echo."""

    source: Annotated[str, "The source frame."]
    target: Annotated[str, "The target frame."]
    line: Annotated[int, "The line of the text where it begins."]


@dataclass(frozen=True)
class Finding:
    """A difference from the description."""

    rule: Annotated[str, "The id of the rule; see docs/rules.md."]
    severity: Annotated[str, "error, warning or note."]
    subject: Annotated[str, "The edge, topic or joint."]
    message: Annotated[str, "What is wrong."]
    help: Annotated[str, "A suggestion."]
    evidence: Annotated[list[str], "The observations."]
    numbers: Annotated[dict[str, Any], "The numbers of the message in SI units."]
    file: Annotated[str | None, "The file of the description that describes the subject."] = None
    line: Annotated[int | None, "The line in that file."] = None


@dataclass(frozen=True)
class Verified:
    """A recording compared with a description.

    If the comparison was not possible, ``verdict`` is None and ``diagnostics`` has the reason.
    """

    robot: Annotated[str, "The name of the robot."]
    source: Annotated[str, "The recording."]
    recording: Annotated[Literal[1], "The version of this format."] = 1
    form: Annotated[str, "The kind of recording."] = ""
    as_described: Annotated[bool, "Whether there is no error."] = False
    messages: Annotated[int, "The number of messages."] = 0
    seconds: Annotated[float | None, "The duration in seconds; null for text."] = None
    modes: Annotated[Mapping[str, bool], "The modes that fit best, or those of --mode."] = field(default_factory=dict)
    edges: Annotated[tuple[RecordedEdge, ...], "The recorded edges."] = ()
    missing: Annotated[tuple[str, ...], "The edges that are missing."] = ()
    frames: Annotated[tuple[SeenFrame, ...], "The frames of view_frames."] = ()
    joints: Annotated[tuple[RecordedJoint, ...], "The joints of /joint_states."] = ()
    sensors: Annotated[tuple[RecordedSensor, ...], "Stamped messages."] = ()
    answers: Annotated[tuple[EchoAnswer, ...], "The answers of tf2_echo."] = ()
    findings: Annotated[tuple[Finding, ...], "The differences from the description, the most serious first."] = ()
    diagnostics: tuple[Diagnostic, ...] = ()
    verdict: Any = field(default=None, repr=False, compare=False)


def result_of(verdict: Verdict, source: str) -> Verified:
    """Return a verdict as a result of plain values."""
    from .judge_tree import best_way

    recording, described = verdict.recording, verdict.description.robot.joint
    span = (recording.end - recording.start) / 1e9 if recording.timed and recording.start is not None else None
    way = best_way(recording)
    return Verified(
        robot=verdict.description.robot.name,
        source=source,
        form=recording.form,
        as_described=not verdict.fails(),
        messages=recording.messages,
        seconds=span,
        modes=dict(way.modes),
        edges=tuple(_edge(recording, series) for series in recording.series.values()),
        missing=tuple(edge.name for edge in way.missing) if recording.complete else (),
        frames=tuple(SeenFrame(r.parent, r.child, r.static, _finite(r.rate), r.age) for r in recording.rows),
        joints=tuple(
            RecordedJoint(name, name in described, _finite(seen.lowest), _finite(seen.highest), seen.seen, seen.beyond)
            for name, seen in recording.joints.ranges.items()
        ),
        sensors=tuple(map(_sensor, recording.uses)),
        answers=tuple(EchoAnswer(one.source, one.target, one.line) for one in recording.answers),
        findings=tuple(map(_finding, verdict.findings)),
        diagnostics=tuple(verdict.findings),
        verdict=verdict,
    )


def _finite(value: Any) -> Any:
    return value if not isinstance(value, float) or math.isfinite(value) else None


def _pace(pace: Pace) -> tuple[int, float | None, float | None, float | None]:
    """Return count, rate, largest gap and mean age."""
    return pace.count, _finite(pace.rate), pace.gap.seconds if pace.timed else None, _finite(pace.mean_age)


def _edge(recording: Recording, series: Series) -> RecordedEdge:
    edge = series.edge
    oldest = series.pace.oldest_until(recording.end).seconds if recording.timed and not series.static else None
    return RecordedEdge(
        series.parent,
        series.child,
        series.topic,
        edge is not None,
        edge.parent if edge is not None else None,
        edge.publisher.name if edge is not None else None,
        *_pace(series.pace),
        oldest,
        series.compared,
        series.by_state,
        series.wrong,
        _finite(series.farthest[0]),
        _finite(series.farthest[1]),
        len(series.values) + bool(series.other_values),
        series.leaps.contradictions,
        series.leaps.returns,
    )


def _sensor(use: FrameUse) -> RecordedSensor:
    lookups = [Lookup(one.target, one.asked, one.failed, one.mean_lag, one.largest_lag) for one in use.lookups.values()]
    return RecordedSensor(use.topic, use.type, use.frame, *_pace(use.pace), use.early, lookups)


def _finding(finding: Diagnostic) -> Finding:
    place = next((related.span for related in finding.related if related.span is not None), None)
    return Finding(
        finding.rule,
        finding.severity,
        finding.of[0],
        finding.message,
        finding.help,
        [related.message for related in finding.related if related.span is None],
        {key: _finite(value) for key, value in finding.numbers},
        place.source.path if place else None,
        place.line if place else None,
    )
