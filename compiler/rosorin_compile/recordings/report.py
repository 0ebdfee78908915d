"""A verdict as text for people, and as JUnit XML for CI."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from xml.sax.saxutils import escape, quoteattr

from rosorin_compile.source.diagnostics import ERROR, NOTE, WARNING, Diagnostic, and_more, counted, masked, printable

from .expected import Expected
from .findings import rate_text, seconds
from .judge import Verdict, answer_finding
from .judge_tree import best_way
from .recording import Answer, FrameRow, Recording
from .series import Series
from .timing import SECOND, Pace

_EDGE_HEAD = ("edge", "by", "topic", "seen", "rate", "largest gap", "age, oldest", "value")
_SENSOR_HEAD = ("topic", "frame", "seen", "rate", "placed in", "at its stamp", "tree behind, most")
_MAX_ROWS = 200
_NO_TIME = 0.5e-3  # s; stamps ahead by less are within the accuracy of reading a clock
# Errors that tell nothing about the robot: there was too little to compare.
_TOO_LITTLE = {
    "recording-empty",
    "recording-foreign",
    "recording-type",
    "recording-no-static",
    "frames-prefixed",
    "text-not-understood",
    "text-frames",
    "not-compared",
}


def table(verdict: Verdict) -> list[str]:
    """Return the edges, the stamped messages and the answers of tf2_echo as tables."""
    recording = verdict.recording
    lines: list[str] = []
    answers = [(answer.name, str(answer.line), _outcome(recording, answer)) for answer in recording.answers]
    for head, rows in (
        (_EDGE_HEAD, list(_edges(recording))),
        (_SENSOR_HEAD, list(_sensors(recording))),
        (("tf2_echo", "line", "value"), answers),
    ):
        if rows:
            lines += ([""] if lines else []) + _columns([head, *rows[:_MAX_ROWS]])
            if len(rows) > _MAX_ROWS:
                lines.append(f"...{and_more(len(rows) - _MAX_ROWS)}; --format json has them all")
    return lines


def summary(verdict: Verdict, name: str, strict: bool) -> str:
    """Return the last line: the size of the recording, and the outcome."""
    recording = verdict.recording
    parts = [counted(recording.messages, "message")] if recording.messages else []
    if recording.timed and recording.start is not None and recording.end > recording.start:
        parts.append(f"{(recording.end - recording.start) / SECOND:.1f} s")
    edges = len(recording.into) or len(recording.rows)
    parts += [counted(edges, "edge")] if edges else []
    parts += [f"{counted(len(recording.answers), 'answer')} of tf2_echo"] if recording.answers else []
    size = f" ({', '.join(parts)})" if parts else ""
    counts = [(verdict.count(severity), severity) for severity in (ERROR, WARNING, NOTE)]
    problems = ", ".join(counted(number, word) for number, word in counts if number)
    errors = {finding.rule for finding in verdict.findings if finding.severity == ERROR}
    if errors and errors <= _TOO_LITTLE:
        return f"{name}: could not be compared: {problems}{size}"
    if verdict.fails(strict):
        return f"{name}: the robot that ran is not the one that is described: {problems}{size}"
    return f"{name}: as described{f', {problems}' if problems else ''}{size}"


def _outcome(recording: Recording, answer: Answer) -> str:
    finding = answer_finding(recording, answer)
    if finding is None:
        return "as described"
    return "not compared" if finding.rule == "not-compared" else "not as described"


def _edges(recording: Recording) -> Iterator[Sequence[str]]:
    """Yield the rows of edges: those of the description first."""
    into, rows, edges = recording.into, {row.child: row for row in recording.rows}, best_way(recording).edges
    described = {edge.child: edge for edge in edges}
    for child in dict.fromkeys([*described, *into, *rows]):
        edge = described.get(child)
        if child in into:
            for series in into[child]:
                yield _series_row(recording, series, edge)
        elif child in rows:
            yield _frame_row(recording, rows[child], edge)
        elif recording.complete and edge is not None:
            yield (edge.name, edge.publisher.name, "-", "never", "-", "-", "-", "missing")


def _series_row(recording: Recording, series: Series, edge: Expected | None) -> Sequence[str]:
    pace, gap, age = series.pace, "-", "-"
    if not series.static and recording.timed:
        gap = seconds(pace.gap.seconds) if pace.count > 1 else "-"
        age = _age(pace, recording)
    rate = "-" if series.static else rate_text(pace.rate)
    owner = _publishers(recording, edge)
    return (series.name, owner, series.topic, f"{pace.count:,}", rate, gap, age, _value(series))


def _frame_row(recording: Recording, row: FrameRow, edge: Expected | None) -> Sequence[str]:
    rate, age, topic = "-", "-", "/tf_static"
    if not row.static:
        topic, rate = "/tf", rate_text(row.rate)
        if row.age is not None:
            age = f"{seconds(-row.age)} ahead" if row.age < -_NO_TIME else seconds(max(0.0, row.age))
    value = "not described"
    if edge is not None:
        value = "parent as described" if edge.parent == row.parent else "wrong parent"
    return (row.name, _publishers(recording, edge), topic, "yes", rate, "-", age, value)


def _age(pace: Pace, recording: Recording) -> str:
    """Return the mean age of an edge, or how far it is dated ahead, and the largest age of its newest stamp."""
    mean = pace.mean_age
    if math.isnan(mean):
        return "no stamp"
    if pace.other_clock:
        return f"{seconds(abs(mean))} {'behind' if mean > 0 else 'ahead'}: another clock"
    oldest = seconds(max(0.0, pace.oldest_until(recording.end).seconds))
    return f"{seconds(-mean)} ahead, {oldest}" if mean < -_NO_TIME else f"{seconds(max(0.0, mean))}, {oldest}"


def _publishers(recording: Recording, edge: Expected | None) -> str:
    """Return the nodes that may publish an edge: a recording does not tell which of several it was."""
    if edge is None:
        return "?"
    if recording.description.options.modes:
        return edge.publisher.name
    edges = recording.description.by_child[edge.child]
    return " or ".join(dict.fromkeys(other.publisher.name for other in edges))


def _value(series: Series) -> str:
    """Return in a few words how the value of an edge compares with the description."""
    if series.edge is None:
        return "not described"
    if series.edge.parent != series.parent:
        return "wrong parent"
    if series.bad == series.pace.count:
        return "no rotation"
    if series.wrong:
        return "wrong" if series.wrong == series.compared else f"wrong in {series.wrong:,} of {series.compared:,}"
    if series.by_state:
        return f"as described, {series.by_state:,} by joint state"
    if series.compared:
        return "as its joint can be" if series.edge.moving else "as described"
    return "known to its publisher alone"


def _sensors(recording: Recording) -> Iterator[Sequence[str]]:
    states = recording.joints.pace
    if states.count:
        yield ("/joint_states", "-", f"{states.count:,}", rate_text(states.rate), "-", "-", "-")
    for use in recording.uses:
        start = (use.topic, use.frame or '""', f"{use.pace.count:,}", rate_text(use.pace.rate))
        lookups = [one for one in use.lookups.values() if one.asked and one.target != use.frame]
        if not lookups:
            yield (*start, "-", "-", "-")
        for one in lookups:
            lag = f"{seconds(one.mean_lag)}, {seconds(one.largest_lag)}" if one.failed else "-"
            yield (*start, one.target, f"{one.asked - one.failed:,} of {one.asked:,}", lag)


def _columns(rows: Sequence[Sequence[str]]) -> list[str]:
    rows = [[printable(cell, keep="\t") for cell in row] for row in rows]
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    return ["  ".join(f"{cell:<{width}}" for cell, width in zip(row, widths, strict=True)).rstrip() for row in rows]


def as_junit(verdict: Verdict, strict: bool = False) -> str:
    """Return a verdict as JUnit XML: a test case for each edge, topic and joint that fails if it has an error."""
    recording, robot = verdict.recording, quoteattr(verdict.description.robot.name)
    names = [edge.name for edge in best_way(recording).edges] if recording.complete else []
    names += [one.name for one in (*recording.series.values(), *recording.answers)]
    cases: dict[str, list[Diagnostic]] = {name: [] for name in [*names, *(use.topic for use in recording.uses)]}
    for finding in verdict.findings:
        cases.setdefault(finding.of[0], []).append(finding)
    failing = {ERROR, WARNING} if strict else {ERROR}
    failed = sum(any(finding.severity in failing for finding in findings) for findings in cases.values())
    counts = f'tests="{len(cases)}" failures="{failed}"'
    lines = ['<?xml version="1.0" encoding="UTF-8"?>', f"<testsuites {counts}>", f"  <testsuite name={robot} {counts}>"]
    for name, findings in cases.items():
        lines.append(f"    <testcase classname={robot} name={quoteattr(masked(name))}>")
        for finding in findings:
            evidence = [related.message for related in finding.related if related.span is None]
            text = escape(masked("\n".join([finding.message, *evidence, finding.help]), keep="\n"))
            if finding.severity in failing:
                message = quoteattr(masked(finding.message))
                lines.append(f'      <failure message={message} type="{finding.rule}">{text}</failure>')
            else:
                lines.append(f"      <system-out>{finding.severity}[{finding.rule}]: {text}</system-out>")
        lines.append("    </testcase>")
    return "\n".join([*lines, "  </testsuite>", "</testsuites>", ""])
