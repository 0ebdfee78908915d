"""The result of verify as text for people, and as JUnit XML for CI."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Sequence
from xml.sax.saxutils import escape, quoteattr

from rosorin_compile.source.diagnostics import and_more, counted, printable
from rosorin_compile.source.wording import masked

from .findings import seconds
from .results import Finding, RecordedEdge, Verified

_EDGE_HEAD = ("edge", "by", "topic", "seen", "rate", "largest gap", "age, oldest", "value")
_SENSOR_HEAD = ("topic", "frame", "seen", "rate", "placed in", "at its stamp", "tree behind, most")
_MAX_ROWS = 200
_NO_TIME = 0.5e-3  # s; stamps ahead by less are within the accuracy of reading a clock
# Errors that tell nothing about the robot: there was too little to compare.
_TOO_LITTLE = {"recording-empty", "recording-foreign", "recording-type", "recording-no-static", "frames-prefixed"}
_TOO_LITTLE |= {"text-not-understood", "text-frames", "not-compared"}


def table(result: Verified) -> list[str]:
    """Return the edges, the stamped messages and the answers of tf2_echo as tables."""
    lines: list[str] = []
    answers = [(answer.name, str(answer.line), answer.value) for answer in result.answers]
    edges, sensors = [_edge_row(edge) for edge in result.edges], list(_sensor_rows(result))
    for head, rows in ((_EDGE_HEAD, edges), (_SENSOR_HEAD, sensors), (("tf2_echo", "line", "value"), answers)):
        if rows:
            lines += ([""] if lines else []) + _columns([head, *rows[:_MAX_ROWS]])
            if len(rows) > _MAX_ROWS:
                lines.append(f"...{and_more(len(rows) - _MAX_ROWS)}; --format json has them all")
    return lines


def summary(result: Verified, name: str, strict: bool) -> str:
    """Return the last line: the size of the recording, and the outcome."""
    edges = len({edge.child for edge in result.edges if edge.topic})
    parts = [counted(result.messages, "message")] if result.messages else []
    parts += [f"{result.seconds:.1f} s"] if result.seconds else []
    parts += [counted(edges, "edge")] if edges else []
    parts += [f"{counted(len(result.answers), 'answer')} of tf2_echo"] if result.answers else []
    size = f" ({', '.join(parts)})" if parts else ""
    counts = Counter(finding.severity for finding in result.findings)
    problems = ", ".join(counted(counts[word], word) for word in ("error", "warning", "note") if counts[word])
    errors = {finding.rule for finding in result.findings if finding.severity == "error"}
    if errors and errors <= _TOO_LITTLE:
        return f"{name}: could not be compared: {problems}{size}"
    if result.fails(strict):
        return f"{name}: the robot that ran is not the one that is described: {problems}{size}"
    return f"{name}: as described{f', {problems}' if problems else ''}{size}"


def _edge_row(edge: RecordedEdge) -> Sequence[str]:
    count = "yes" if edge.count is None else f"{edge.count:,}" if edge.count else "never"
    gap = "-" if edge.largest_gap is None or (edge.count or 0) < 2 else seconds(edge.largest_gap)
    if edge.topic == "/tf_static":
        return (edge.name, edge.publisher or "?", edge.topic, count, "-", "-", "-", edge.value)
    return (edge.name, edge.publisher or "?", edge.topic or "-", count, _rate(edge.rate), gap, _age(edge), edge.value)


def _age(edge: RecordedEdge) -> str:
    """Return the mean age of an edge, or how far it is dated ahead, and the largest age of its newest stamp."""
    if edge.mean_age is None:
        return "-" if edge.oldest is None else "no stamp"
    if edge.other_clock:
        return f"{seconds(abs(edge.mean_age))} {'behind' if edge.mean_age > 0 else 'ahead'}: another clock"
    ahead = edge.mean_age < -_NO_TIME
    mean = f"{seconds(-edge.mean_age)} ahead" if ahead else seconds(max(0.0, edge.mean_age))
    return mean if edge.oldest is None else f"{mean}, {seconds(max(0.0, edge.oldest))}"


def _rate(rate: float | None) -> str:
    return "-" if rate is None else f"{rate:.1f} Hz"


def _sensor_rows(result: Verified) -> Iterator[Sequence[str]]:
    for use in result.sensors:
        start = (use.topic, use.frame or '""', f"{use.count:,}", _rate(use.rate))
        lookups = [one for one in use.lookups if one.asked and one.target != use.frame]
        if not lookups:
            yield (*start, "-", "-", "-")
        for one in lookups:
            lag = f"{seconds(one.mean_lag)}, {seconds(one.largest_lag)}" if one.failed else "-"
            yield (*start, one.target, f"{one.asked - one.failed:,} of {one.asked:,}", lag)


def _columns(rows: Sequence[Sequence[str]]) -> list[str]:
    rows = [[printable(cell, keep="\t") for cell in row] for row in rows]
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    return ["  ".join(f"{cell:<{width}}" for cell, width in zip(row, widths, strict=True)).rstrip() for row in rows]


def as_junit(result: Verified, strict: bool = False) -> str:
    """Return a result as JUnit XML: a test case for each edge, topic and joint that fails if it has an error."""
    names = [*(edge.name for edge in result.edges), *(answer.name for answer in result.answers)]
    cases: dict[str, list[Finding]] = {name: [] for name in [*names, *(use.topic for use in result.sensors)]}
    for finding in result.findings:
        cases.setdefault(finding.subject, []).append(finding)
    failing, robot = ("error", "warning") if strict else ("error",), quoteattr(result.robot)
    failed = sum(any(finding.severity in failing for finding in findings) for findings in cases.values())
    counts = f'tests="{len(cases)}" failures="{failed}"'
    lines = ['<?xml version="1.0" encoding="UTF-8"?>', f"<testsuites {counts}>", f"  <testsuite name={robot} {counts}>"]
    for name, findings in cases.items():
        lines.append(f"    <testcase classname={robot} name={quoteattr(masked(name))}>")
        for finding in findings:
            text = escape(masked("\n".join([finding.message, *finding.evidence, finding.help]), keep="\n"))
            if finding.severity in failing:
                message = quoteattr(masked(finding.message))
                lines.append(f'      <failure message={message} type="{finding.rule}">{text}</failure>')
            else:
                lines.append(f"      <system-out>{finding.severity}[{finding.rule}]: {text}</system-out>")
        lines.append("    </testcase>")
    return "\n".join([*lines, "  </testsuite>", "</testsuites>", ""])
