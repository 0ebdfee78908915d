"""The result of verify as JSON values (schemas/recording.schema.json), as text tables, and as JUnit XML for CI."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Annotated, Any

from rosorin_compile.formats.templating import Templates
from rosorin_compile.source.diagnostics import Diagnostic
from rosorin_compile.source.wording import and_more, count_of, mask_controls, printable

from .findings import rate_text, seconds

_EDGE_HEAD = ("edge", "by", "topic", "seen", "rate", "largest gap", "age, oldest", "value")
_SENSOR_HEAD = ("topic", "frame", "seen", "rate", "placed in", "at its stamp", "tree behind, most")
_MAX_ROWS = 200
_NO_TIME = 0.5e-3  # s: smaller offsets are within the accuracy of reading a clock
# Errors for recordings with too little data to compare.
_TOO_LITTLE = {"recording-empty", "recording-foreign", "recording-type", "recording-no-static", "frames-prefixed"}
_TOO_LITTLE |= {"text-not-understood", "text-frames", "not-compared"}


@dataclass(frozen=True)
class RecordedEdge:
    """An edge on a topic, or a missing edge."""

    parent: Annotated[str, "The parent frame."]
    child: Annotated[str, "The child frame."]
    topic: Annotated[str, "The topic: /tf or /tf_static; empty for a missing edge."]
    publisher: Annotated[str, "The nodes that should publish it; empty for an edge that is not described."]
    value: Annotated[str, "How its value compares with the description, in words."]
    count: Annotated[int | None, "The number of transforms; null for an edge of view_frames."] = None
    rate: Annotated[float | None, "The rate in hertz; null for fewer than two, and on /tf_static."] = None
    largest_gap: Annotated[float | None, "The longest time between two of them in seconds; null for text."] = None
    mean_age: Annotated[float | None, "The mean age on arrival in seconds; null for text."] = None
    oldest: Annotated[float | None, "The largest age of the newest transform in seconds; null on /tf_static."] = None
    other_clock: Annotated[bool, "Whether all stamps are of another clock."] = False
    compared: Annotated[int, "The number of transforms compared with the description."] = 0
    by_state: Annotated[int, "The number of them compared with the joint state of the same stamp."] = 0
    wrong: Annotated[int, "The number of transforms that differ from the description."] = 0

    @property
    def name(self) -> str:
        """The parent and child as text."""
        return f"{self.parent} -> {self.child}"


@dataclass(frozen=True)
class RecordedJoint:
    """A joint in /joint_states."""

    name: Annotated[str, "Its name."]
    lowest: Annotated[float | None, "The lowest position in radians or metres."]
    highest: Annotated[float | None, "The highest position in radians or metres."]
    seen: Annotated[int, "The number of reported positions."]
    beyond: Annotated[int, "The number of positions beyond its limits."]


@dataclass(frozen=True)
class Lookup:
    """Results of looking up the frame of each message at its stamp, at its time of arrival."""

    target: Annotated[str, "The requested frame."]
    asked: Annotated[int, "The number of lookups."]
    failed: Annotated[int, "The number of lookups that tf2 could not have answered."] = 0
    mean_lag: Annotated[float, "The mean delay of the tree behind the stamp for failed lookups, in seconds."] = 0.0
    largest_lag: Annotated[float, "The largest delay in seconds."] = 0.0


@dataclass(frozen=True)
class RecordedSensor:
    """The messages on a topic with the same frame."""

    topic: Annotated[str, "The topic."]
    type: Annotated[str, "Its type; empty if unknown."]
    frame: Annotated[str, "The frame_id."]
    count: Annotated[int, "The number of messages."]
    rate: Annotated[float | None, "The rate in hertz; null for fewer than two."]
    largest_gap: Annotated[float | None, "The longest time between two of them in seconds; null for text."]
    mean_age: Annotated[float | None, "The mean age on arrival in seconds; null for text."]
    early: Annotated[int, "The number of messages before the frame was in the tree."]
    lookups: Annotated[list[Lookup], "Lookups by target."]


@dataclass(frozen=True)
class EchoAnswer:
    """An answer of tf2_echo."""

    name: Annotated[str, "The source and the target frame."]
    line: Annotated[int, "The line of the text where it begins."]
    value: Annotated[str, "How it compares with the description, in words."]


@dataclass(frozen=True)
class Finding:
    """A difference from the description."""

    rule: Annotated[str, "The id of the rule; see docs/rules.md."]
    severity: Annotated[str, "error, warning or note."]
    subject: Annotated[str, "The edge, topic or joint."]
    message: Annotated[str, "What is wrong."]
    help: Annotated[str, "A suggestion."]
    evidence: Annotated[list[str], "The observations."]
    file: Annotated[str | None, "The file of the description that describes the subject."] = None
    line: Annotated[int | None, "The line in that file."] = None


@dataclass(frozen=True)
class Verified:
    """The result of comparing a recording with a description.

    If the comparison was not possible, ``data`` is None and ``diagnostics`` has the reason.
    """

    robot: Annotated[str, "The name of the robot."]
    source: Annotated[str, "The recording."]
    form: Annotated[str, "The kind of recording."] = ""
    messages: Annotated[int, "The number of messages."] = 0
    seconds: Annotated[float | None, "The duration in seconds; null for text."] = None
    modes: Annotated[Mapping[str, bool], "The modes that fit best, or those of --mode."] = field(default_factory=dict)
    edges: Annotated[tuple[RecordedEdge, ...], "The edges that are described or recorded."] = ()
    joints: Annotated[tuple[RecordedJoint, ...], "The joints of /joint_states."] = ()
    sensors: Annotated[tuple[RecordedSensor, ...], "Stamped messages."] = ()
    answers: Annotated[tuple[EchoAnswer, ...], "The answers of tf2_echo."] = ()
    findings: Annotated[tuple[Finding, ...], "The differences from the description, the most serious first."] = ()
    as_described: Annotated[bool, "Whether there is no error."] = False
    diagnostics: tuple[Diagnostic, ...] = ()
    data: Any = field(default=None, repr=False, compare=False)

    def fails(self, strict: bool = False) -> bool:
        """Return True if the recorded robot differs from the description; ``strict`` treats warnings as errors."""
        return any(one.severity == "error" or (strict and one.severity == "warning") for one in self.findings)


def table(result: Verified) -> list[str]:
    """Format the edges, the stamped messages and the answers of tf2_echo as tables."""
    lines: list[str] = []
    edges, sensors = list[Sequence[str]](), list[Sequence[str]]()
    for edge in result.edges:
        count = "yes" if edge.count is None else f"{edge.count:,}" if edge.count else "never"
        gap = "-" if edge.largest_gap is None or (edge.count or 0) < 2 else seconds(edge.largest_gap)
        pace = ("-", "-", "-") if edge.topic == "/tf_static" else (rate_text(edge.rate), gap, _age(edge))
        edges.append((edge.name, edge.publisher or "?", edge.topic or "-", count, *pace, edge.value))
    for use in result.sensors:
        start = (use.topic, use.frame or '""', f"{use.count:,}", rate_text(use.rate))
        lookups = [one for one in use.lookups if one.asked and one.target != use.frame]
        sensors += [] if lookups else [(*start, "-", "-", "-")]
        for one in lookups:
            lag = f"{seconds(one.mean_lag)}, {seconds(one.largest_lag)}" if one.failed else "-"
            sensors.append((*start, one.target, f"{one.asked - one.failed:,} of {one.asked:,}", lag))
    answers = [(answer.name, str(answer.line), answer.value) for answer in result.answers]
    for head, rows in ((_EDGE_HEAD, edges), (_SENSOR_HEAD, sensors), (("tf2_echo", "line", "value"), answers)):
        if rows:
            lines += ([""] if lines else []) + _columns([head, *rows[:_MAX_ROWS]])
            if len(rows) > _MAX_ROWS:
                lines.append(f"...{and_more(len(rows) - _MAX_ROWS)}; --format json has them all")
    return lines


def summary(result: Verified, name: str, strict: bool) -> str:
    """Return the last line of the output, with the size of the recording and the outcome."""
    edges = len({edge.child for edge in result.edges if edge.topic})
    parts = [count_of(result.messages, "message")] if result.messages else []
    parts += [f"{result.seconds:.1f} s"] if result.seconds else []
    parts += [count_of(edges, "edge")] if edges else []
    parts += [f"{count_of(len(result.answers), 'answer')} of tf2_echo"] if result.answers else []
    size = f" ({', '.join(parts)})" if parts else ""
    counts = Counter(finding.severity for finding in result.findings)
    problems = ", ".join(count_of(counts[word], word) for word in ("error", "warning", "note") if counts[word])
    errors = {finding.rule for finding in result.findings if finding.severity == "error"}
    if errors and errors <= _TOO_LITTLE:
        return f"{name}: could not be compared: {problems}{size}"
    if result.fails(strict):
        return f"{name}: the robot that ran is not the one that is described: {problems}{size}"
    return f"{name}: as described{f', {problems}' if problems else ''}{size}"


def _age(edge: RecordedEdge) -> str:
    """Format the mean age of an edge (or how far ahead it is stamped) and the largest age of its newest stamp."""
    if edge.mean_age is None:
        return "-" if edge.oldest is None else "no stamp"
    if edge.other_clock:
        return f"{seconds(abs(edge.mean_age))} {'behind' if edge.mean_age > 0 else 'ahead'}: another clock"
    ahead = edge.mean_age < -_NO_TIME
    mean = f"{seconds(-edge.mean_age)} ahead" if ahead else seconds(max(0.0, edge.mean_age))
    return mean if edge.oldest is None else f"{mean}, {seconds(max(0.0, edge.oldest))}"


def _columns(rows: Sequence[Sequence[str]]) -> list[str]:
    rows = [[printable(cell, keep="\t") for cell in row] for row in rows]
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    return ["  ".join(f"{cell:<{width}}" for cell, width in zip(row, widths, strict=True)).rstrip() for row in rows]


def as_junit(result: Verified, strict: bool = False) -> str:
    """Format a result as JUnit XML, with a test case for each edge, topic and joint, which fails for an error."""
    names = [edge.name for edge in result.edges] + [answer.name for answer in result.answers]
    names += [use.topic for use in result.sensors]
    cases: dict[str, list[Finding]] = {mask_controls(name): [] for name in names}
    for finding in result.findings:
        cases.setdefault(mask_controls(finding.subject), []).append(finding)
    failing = ("error", "warning") if strict else ("error",)
    failed = sum(any(finding.severity in failing for finding in findings) for findings in cases.values())
    values = {"robot": result.robot, "cases": cases, "failing": failing, "failed": failed, "masked": mask_controls}

    def text(finding: Finding) -> str:
        return mask_controls("\n".join([finding.message, *finding.evidence, finding.help]), keep="\n")

    return Templates.own("recordings/junit.xml.jinja", values | {"text": text})
