"""The result of verify."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Annotated, Any, Literal

from rosorin_compile.source.diagnostics import Diagnostic


@dataclass(frozen=True)
class RecordedEdge:
    """One edge on one topic."""

    parent: Annotated[str, "The frame above."]
    child: Annotated[str, "The frame below."]
    topic: Annotated[str, "The topic that it came on: /tf or /tf_static."]
    described: Annotated[bool, "Whether the description has an edge into this frame."]
    described_parent: Annotated[str | None, "The frame above in the description."]
    publisher: Annotated[str | None, "Who should publish it. A recording does not say who did."]
    count: Annotated[int, "How many messages or transforms there were."]
    rate: Annotated[float | None, "How many a second, in hertz; null of fewer than two."]
    largest_gap: Annotated[
        float | None,
        "The longest time between two of them, in seconds; null where it is not known when they came.",
    ]
    mean_age: Annotated[float | None, "The mean age when they were received; null where that is not known, in seconds."]
    oldest: Annotated[
        float | None,
        "The oldest that the newest transform ever was, in seconds; null on /tf_static.",
    ]
    compared: Annotated[int, "How many transforms were compared with the description."]
    by_joint_state: Annotated[int, "How many of them with the joint state of the same stamp."]
    wrong: Annotated[int, "How many of them were not as described."]
    farthest_metres: Annotated[float | None, "The farthest that one of them was away, in metres; null beyond numbers."]
    farthest_radians: Annotated[float | None, "The farthest that one was turned away, in radians; null beyond numbers."]
    values: Annotated[int, "How many different values an edge had that should stand still."]
    two_values_at_one_stamp: Annotated[int, "How often a stamp came twice with two values."]
    leaps_back: Annotated[int, "How often the edge leaped to where it had been shortly before."]


@dataclass(frozen=True)
class SeenFrame:
    """One frame of view_frames."""

    parent: Annotated[str, "The frame above."]
    child: Annotated[str, "The frame."]
    static: Annotated[bool, "Whether it came on /tf_static."]
    rate: Annotated[float | None, "Its average rate, in hertz."]
    age: Annotated[
        float | None, "The age of its newest transform when view_frames looked, in seconds; null if unknown."
    ]


@dataclass(frozen=True)
class RecordedJoint:
    """A joint of /joint_states."""

    name: Annotated[str, "Its name."]
    described: Annotated[bool, "Whether the description has it."]
    lowest: Annotated[float | None, "The lowest position, in radians or metres."]
    highest: Annotated[float | None, "The highest position, in radians or metres."]
    seen: Annotated[int, "How often it was named."]
    beyond_limits: Annotated[int, "How often it was beyond its limits."]


@dataclass(frozen=True)
class Lookup:
    """Lookups at the exact stamps of the messages, when they came."""

    target: Annotated[str, "The frame that was asked for."]
    asked: Annotated[int, "How many."]
    failed: Annotated[int, "How many tf2 could not have answered."]
    mean_lag: Annotated[float, "How far the tree was behind the stamp, mean of those that failed, in seconds."]
    largest_lag: Annotated[float, "How far it was behind at most, in seconds."]


@dataclass(frozen=True)
class RecordedSensor:
    """The messages of a topic that name one frame."""

    topic: Annotated[str, "The topic."]
    type: Annotated[str, "Its type; empty where it is not known."]
    frame: Annotated[str, "The frame_id."]
    count: Annotated[int, "How many messages or transforms there were."]
    rate: Annotated[float | None, "How many a second, in hertz; null of fewer than two."]
    largest_gap: Annotated[
        float | None,
        "The longest time between two of them, in seconds; null where it is not known when they came.",
    ]
    mean_age: Annotated[float | None, "The mean age when they were received; null where that is not known, in seconds."]
    before_the_frame: Annotated[int, "How many came before the frame was in the tree."]
    lookups: Annotated[list[Lookup], "Lookups by target."]


@dataclass(frozen=True)
class EchoAnswer:
    """An answer of tf2_echo."""

    source: Annotated[str, "The frame in which."]
    target: Annotated[str, "The frame that."]
    line: Annotated[int, "The line of the text where it begins."]


@dataclass(frozen=True)
class Finding:
    """Something that is not as described."""

    rule: Annotated[str, "The id of the rule; docs/rules.md has them all."]
    severity: Annotated[str, "How serious it is: error, warning or note."]
    subject: Annotated[str, "The edge, topic or joint that it is about."]
    message: Annotated[str, "What is wrong."]
    help: Annotated[str, "The way out."]
    evidence: Annotated[list[str], "What it is concluded from."]
    numbers: Annotated[dict[str, Any], "The numbers of the message, in SI units."]
    file: Annotated[str | None, "The file of the description where this is described."] = None
    line: Annotated[int | None, "The line in that file."] = None


@dataclass(frozen=True)
class Verified:
    """A recording compared with a description.

    ``verdict`` is the ``judge.Verdict`` with all statistics. Without it the comparison was not possible, and
    ``diagnostics`` has the reason.
    """

    robot: Annotated[str, "The name of the robot."]
    source: Annotated[str, "What was read."]
    recording: Annotated[Literal[1], "The version of this format."] = 1
    form: Annotated[str, "What it is, in words."] = ""
    as_described: Annotated[bool, "Whether there is no error."] = False
    messages: Annotated[int, "How many messages were read."] = 0
    seconds: Annotated[float | None, "How long the recording is; null for text, in seconds."] = None
    modes: Annotated[Mapping[str, bool], "The modes that fit best, or that were given."] = field(default_factory=dict)
    edges: Annotated[tuple[RecordedEdge, ...], "The edges that were recorded."] = ()
    missing: Annotated[tuple[str, ...], "The edges that should be there and are not."] = ()
    frames: Annotated[tuple[SeenFrame, ...], "What view_frames saw."] = ()
    joints: Annotated[tuple[RecordedJoint, ...], "What /joint_states named."] = ()
    sensors: Annotated[tuple[RecordedSensor, ...], "Stamped messages."] = ()
    answers: Annotated[tuple[EchoAnswer, ...], "What tf2_echo answered."] = ()
    findings: Annotated[tuple[Finding, ...], "What is not as described, the most serious first."] = ()
    diagnostics: tuple[Diagnostic, ...] = ()
    verdict: Any = field(default=None, repr=False, compare=False)
