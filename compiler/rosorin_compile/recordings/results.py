"""Findings about recordings, and the result of ``verify`` as dataclasses, text tables, and JUnit XML for CI.

The JSON schema of the result is ``schemas/recording.schema.json``.
"""

import math
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Annotated, Any

from rosorin_compile.formats.templating import Templates
from rosorin_compile.model import Transform, Vector
from rosorin_compile.source.diagnostics import ERROR, NOTE, WARNING, Diagnostic, Help, Related, diagnostic
from rosorin_compile.source.numbers import amount, to_fixed
from rosorin_compile.source.rule_registry import find_declared
from rosorin_compile.source.wording import and_more, count_of, mask_controls, printable

YEAR = 365.25 * 86400.0  # s
_NEAR = math.radians(2.0)  # rad: tolerance for rotations by 90 or 180 degrees
_AXES = ("x", "y", "z")
_EDGE_HEAD = ("edge", "by", "topic", "seen", "rate", "largest gap", "age, oldest", "value")
_SENSOR_HEAD = ("topic", "frame", "seen", "rate", "placed in", "at its stamp", "tree behind, most")
_MAX_ROWS = 200
_NO_TIME = 0.5e-3  # s: smaller offsets between clocks are measurement errors
# Rules that report a recording as unsuitable for a comparison.
_TOO_LITTLE = {"recording-empty", "recording-foreign", "recording-type", "recording-no-static", "frames-prefixed"}
_TOO_LITTLE |= {"text-not-understood", "text-frames", "not-compared"}


def problem(
    rule: str, subject: str, message: str, help: Help = "", evidence: Iterable[str] = (), severity: str = ""
) -> Diagnostic:
    """Create a finding about a subject (an edge, topic or joint); ``evidence`` is printed below the message.

    If ``help`` or ``severity`` is empty, the default of the rule is used.
    """
    related, known = tuple(Related(line, None) for line in evidence), find_declared(rule)
    usual = known.help[:1].lower() + known.help[1:].rstrip(".").replace("`", "")
    return replace(diagnostic(rule, severity or known.severity, message, None, help or usual, related), of=(subject,))


def sort_findings(findings: Iterable[Diagnostic]) -> list[Diagnostic]:
    """Remove duplicate findings, and sort the rest by severity (a stable sort)."""
    unique: dict[tuple[object, ...], Diagnostic] = {}
    for finding in findings:
        unique.setdefault((finding.rule, finding.of, finding.message), finding)
    return sorted(unique.values(), key=lambda finding: (ERROR, WARNING, NOTE).index(finding.severity))


def seconds(value: float) -> str:
    """Format a duration in s, ms or years with at most three digits.

    >>> seconds(12.34), seconds(0.0981), seconds(0.0021), seconds(1.79e9)
    ('12.3 s', '98 ms', '2.1 ms', '56.7 years')
    """
    if value >= YEAR:
        return f"{value / YEAR:.1f} years"
    return f"{value:.1f} s" if value >= 1 else f"{value * 1e3:.{int(value < 0.01)}f} ms"


def rate_text(rate: float | None) -> str:
    """Format a rate in Hz, or return "-" if it is unknown."""
    return "-" if rate is None or math.isnan(rate) else f"{rate:.1f} Hz"


def share(part: int, total: int) -> str:
    """Format a number of messages as a share of all messages, such as "12 of 300 (4 %)"."""
    percent = 100 * part / total if total else 0.0
    shown = f"{percent:.0f}" if percent >= 1 or percent == 0 else f"{percent:.1g}"
    return f"{part:,} of {total:,} ({shown} %)"


def pose_text(transform: Transform) -> str:
    """Format a transform in metres and degrees."""
    xyz = " ".join(to_fixed(value, 6) for value in transform.xyz)
    rpy = " ".join(to_fixed(math.degrees(value), 3) for value in transform.rpy())
    return f"{xyz} m, {rpy} deg"


def difference(described: Transform, recorded: Transform) -> str:
    """Return the difference between two transforms as text, in metres and degrees.

    Translations are along the axes of the parent, rotations about the axes of the described child.
    """
    move = [b - a for a, b in zip(described.xyz, recorded.xyz, strict=True)]
    axis, angle = described.turn_to(recorded)
    far, parts = math.hypot(*move), []
    if angle > 1e-7:
        name, degrees = _main_axis(axis), math.degrees(angle)
        along = f"({', '.join(to_fixed(value, 2) for value in axis)})"
        shown = f"{degrees:.1f}" if degrees >= 1 else f"{degrees:.2g}"
        if name and abs(angle - math.pi) < _NEAR:
            shown = "180"
        elif name:
            shown = "90" if abs(degrees - 90) < 0.05 else shown
            shown = f"-{shown}" if axis[_AXES.index(name)] < 0 else shown
        parts.append(f"turned by {shown} deg about {name or along}")
    if far > 1e-7:
        steps = [(name, step) for name, step in zip(_AXES, move, strict=True) if abs(step) > 0.02 * far]
        words = (f"{'-' if step < 0 else '+'}{amount(abs(step), 'm')} in {name}" for name, step in steps)
        parts.append(f"moved by {', '.join(words)}")
    return " and ".join(parts)


def value_rule(described: Transform, recorded: Transform) -> str:
    """Return the rule id for a wrong transform: ``mounted-backwards`` (a half turn about z) or ``edge-wrong-value``."""
    axis, angle = described.turn_to(recorded)
    return "mounted-backwards" if abs(angle - math.pi) <= _NEAR and _main_axis(axis) == "z" else "edge-wrong-value"


def _main_axis(axis: Vector) -> str:
    """Return the axis, "x", "y" or "z", that is within 4 degrees of a unit vector, or "" if there is none."""
    largest = max(range(3), key=lambda at: abs(axis[at]))
    return _AXES[largest] if abs(axis[largest]) > math.cos(2 * _NEAR) else ""


@dataclass(frozen=True)
class RecordedEdge:
    """A transform parent -> child (an edge) on /tf or /tf_static, or an expected edge that was not recorded."""

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
        """The edge as text, such as "base_link -> laser"."""
        return f"{self.parent} -> {self.child}"


@dataclass
class RecordedJoint:
    """The positions of a joint in /joint_states; those of a mimic joint are compared with the joint that it follows."""

    name: Annotated[str, "Its name."]
    lowest: Annotated[float | None, "The lowest position in radians or metres."]
    highest: Annotated[float | None, "The highest position in radians or metres."]
    seen: Annotated[int, "The number of reported positions."]
    beyond: Annotated[int, "The number of positions beyond its limits."]
    not_numbers: Annotated[int, "The number of positions that are not finite."]
    compared: Annotated[int, "The number of positions compared with the leader."] = 0
    wrong: Annotated[int, "The number of them that differ from what the leader implies."] = 0
    farthest: Annotated[float, "The largest difference in radians or metres."] = 0.0


@dataclass(frozen=True)
class Lookup:
    """Results of simulated tf2 lookups of ``target``: one per message, when it arrives, at the time of its stamp."""

    target: Annotated[str, "The requested frame."]
    asked: Annotated[int, "The number of lookups."]
    failed: Annotated[int, "The number of lookups that tf2 could not have answered."] = 0
    mean_lag: Annotated[float, "The mean delay of the tree behind the stamp for failed lookups, in seconds."] = 0.0
    largest_lag: Annotated[float, "The largest delay in seconds."] = 0.0


@dataclass(frozen=True)
class RecordedSensor:
    """The messages on a topic that have the same frame_id in their header."""

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
    """A transform that tf2_echo printed, compared with the description."""

    name: Annotated[str, "The source and the target frame."]
    line: Annotated[int, "The line of the text where it begins."]
    value: Annotated[str, "How it compares with the description, in words."]


@dataclass(frozen=True)
class Finding:
    """A difference between a recording and the description."""

    rule: Annotated[str, "The id of the rule; see docs/rules.md."]
    severity: Annotated[str, "error, warning or note."]
    subject: Annotated[str, "The edge, topic or joint."]
    message: Annotated[str, "What is wrong."]
    help: Annotated[str, "A suggestion."]
    evidence: Annotated[list[str], "The observations."]
    file: Annotated[str | None, "The file of the description that describes the subject."] = None
    line: Annotated[int | None, "The line in that file."] = None


@dataclass(frozen=True)
class Verification:
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
        """Return True if there is an error or, with ``strict``, a warning."""
        return any(one.severity == "error" or (strict and one.severity == "warning") for one in self.findings)


def table(result: Verification) -> list[str]:
    """Format the edges, the messages with headers and the output of tf2_echo as text tables."""
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


def summary(result: Verification, name: str, strict: bool) -> str:
    """Summarize the size of the recording and the result of the comparison in one line."""
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
    """Format the mean age of transforms when they arrive, and the largest age that the newest transform reached."""
    if edge.mean_age is None:
        return "-" if edge.oldest is None else "no stamp"
    if edge.other_clock:
        return f"{seconds(abs(edge.mean_age))} {'behind' if edge.mean_age > 0 else 'ahead'}: another clock"
    mean = f"{seconds(-edge.mean_age)} ahead" if edge.mean_age < -_NO_TIME else seconds(max(0.0, edge.mean_age))
    return mean if edge.oldest is None else f"{mean}, {seconds(max(0.0, edge.oldest))}"


def _columns(rows: Sequence[Sequence[str]]) -> list[str]:
    rows = [[printable(cell, keep="\t") for cell in row] for row in rows]
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    return ["  ".join(f"{cell:<{width}}" for cell, width in zip(row, widths, strict=True)).rstrip() for row in rows]


def as_junit(result: Verification, strict: bool = False) -> str:
    """Format a result as JUnit XML: a test case for each edge, topic and joint, which fails if it has an error."""
    names = [edge.name for edge in result.edges] + [answer.name for answer in result.answers]
    names += [use.topic for use in result.sensors]
    cases: dict[str, list[Finding]] = {mask_controls(name): [] for name in names}
    for finding in result.findings:
        cases.setdefault(mask_controls(finding.subject), []).append(finding)
    failing = ("error", "warning") if strict else ("error",)
    failed = sum(any(finding.severity in failing for finding in findings) for findings in cases.values())
    values = {"robot": result.robot, "cases": cases, "failing": failing, "failed": failed, "masked": mask_controls}
    return Templates.own("recordings/junit.xml.jinja", values)
