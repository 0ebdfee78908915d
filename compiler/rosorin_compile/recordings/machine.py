"""A verdict as a result of plain values (schemas/recording.schema.json), and as JUnit XML for CI."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any
from xml.sax.saxutils import escape, quoteattr

from rosorin_compile.source.diagnostics import ERROR, NOTE, WARNING, Diagnostic, masked

from .answers import EchoAnswer, Finding, Lookup, RecordedEdge, RecordedJoint, RecordedSensor, SeenFrame, Verified
from .arrays import SECOND
from .judge import Verdict
from .judge_tree import best_way
from .pace import Pace
from .recording import FrameUse, Recording, SensorLog
from .series import Series


def as_result(verdict: Verdict, source: str) -> Verified:
    """Return a verdict as a result of plain values."""
    recording = verdict.recording
    span = (recording.end - recording.start) / SECOND if recording.timed and recording.start is not None else None
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
        missing=tuple(edge.name for edge in way.edges) if recording.whole else (),
        frames=tuple(SeenFrame(row.parent, row.child, row.still, _finite(row.rate), row.age) for row in recording.rows),
        joints=tuple(_joints(recording)),
        sensors=tuple(_sensor(log, use) for log in recording.sensors.values() for use in log.frames.values()),
        answers=tuple(EchoAnswer(one.source, one.target, one.line) for one in recording.asked),
        findings=tuple(map(_finding, verdict.findings)),
        diagnostics=tuple(verdict.findings),
        verdict=verdict,
    )


def _finite(value: float) -> float | None:
    return float(value) if math.isfinite(value) else None


def _plain(value: Any) -> Any:
    return _finite(value) if isinstance(value, float) else value


def _pace(pace: Pace) -> dict[str, Any]:
    return {
        "count": pace.count,
        "rate": _finite(pace.rate),
        "largest_gap": pace.gap.seconds if pace.aged else None,
        "mean_age": _finite(pace.mean_age),
    }


def _edge(recording: Recording, series: Series) -> RecordedEdge:
    values = series.values
    oldest = series.pace.oldest_until(recording.end).seconds if recording.timed and not series.still else None
    return RecordedEdge(
        parent=series.parent,
        child=series.child,
        topic=series.topic,
        described=series.edge is not None,
        described_parent=series.edge.parent if series.edge is not None else None,
        publisher=series.edge.publisher.name if series.edge is not None else None,
        **_pace(series.pace),
        oldest=oldest,
        compared=values.compared,
        by_joint_state=values.by_state if series.edge is not None and series.edge.moving else 0,
        wrong=values.wrong,
        farthest_metres=_finite(values.farthest[0]),
        farthest_radians=_finite(values.farthest[1]),
        values=len(values.seen) + (1 if values.others else 0),
        two_values_at_one_stamp=series.leaps.twice_different,
        leaps_back=series.leaps.returns,
    )


def _joints(recording: Recording) -> Iterator[RecordedJoint]:
    for name, seen in recording.joints.ranges.items():
        described = name in recording.description.robot.joint
        lowest, highest = _finite(seen.lowest), _finite(seen.highest)
        yield RecordedJoint(name, described, lowest, highest, seen.seen, seen.beyond)


def _sensor(log: SensorLog, use: FrameUse) -> RecordedSensor:
    lookups = [Lookup(one.target, one.asked, one.failed, one.mean_lag, one.lag_most) for one in use.lookups.values()]
    return RecordedSensor(
        topic=log.topic,
        type=log.kind,
        frame=use.frame,
        **_pace(use.pace),
        before_the_frame=use.early,
        lookups=lookups,
    )


def _finding(finding: Diagnostic) -> Finding:
    place = next((related.span for related in finding.related if related.span is not None), None)
    return Finding(
        finding.rule,
        finding.severity,
        finding.of[0],
        finding.message,
        finding.help,
        [related.message for related in finding.related if related.span is None],
        {key: _plain(value) for key, value in finding.numbers},
        place.source.path if place else None,
        place.line if place else None,
    )


def as_junit(verdict: Verdict, strict: bool = False) -> str:
    """Return a verdict as JUnit XML: a test case for each edge, topic and joint, failed where an error is about it."""
    cases: dict[str, list[Diagnostic]] = {}
    way = best_way(verdict.recording)
    names = [edge.name for edge in way.present] if verdict.recording.whole else []
    names += [series.name for series in verdict.recording.series.values()]
    names += [f"{answer.source} -> {answer.target}" for answer in verdict.recording.asked]
    names += list(verdict.recording.sensors)
    for name in names:
        cases.setdefault(name, [])
    for finding in verdict.findings:
        cases.setdefault(finding.of[0], []).append(finding)
    failing = {ERROR, WARNING} if strict else {ERROR}
    failed = sum(any(finding.severity in failing for finding in findings) for findings in cases.values())
    robot = verdict.description.robot.name
    lines = ['<?xml version="1.0" encoding="UTF-8"?>', f'<testsuites tests="{len(cases)}" failures="{failed}">']
    lines.append(f'  <testsuite name={_quoted(robot)} tests="{len(cases)}" failures="{failed}" errors="0" skipped="0">')
    for name, findings in cases.items():
        lines += _case(robot, name, findings, failing)
    return "\n".join([*lines, "  </testsuite>", "</testsuites>", ""])


def _case(robot: str, name: str, findings: list[Diagnostic], failing: set[str]) -> Iterator[str]:
    start = f"    <testcase classname={_quoted(robot)} name={_quoted(name)}"
    if not findings:
        yield f"{start}/>"
        return
    yield f"{start}>"
    for finding in findings:
        text = "\n".join([finding.message, *(r.message for r in finding.related if r.span is None), finding.help])
        if finding.severity in failing:
            message, kind = _quoted(finding.message), _quoted(finding.rule)
            yield f"      <failure message={message} type={kind}>{escape(_masked(text))}</failure>"
        else:
            word = "note" if finding.severity == NOTE else "warning"
            yield f"      <system-out>{escape(_masked(f'{word}[{finding.rule}]: {text}'))}</system-out>"
    yield "    </testcase>"


def _quoted(text: str) -> str:
    return quoteattr(_masked(text))


def _masked(text: str) -> str:
    return masked(text, keep="\t\n")
