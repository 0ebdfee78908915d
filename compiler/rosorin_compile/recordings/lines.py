"""Lines: a verdict as people read it: the edges in a table, the sensors, then the findings and one last line."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

from rosorin_compile.source.diagnostics import ERROR, NOTE, WARNING, and_more, counted, printable

from .arrays import SECOND
from .expected import Expected
from .findings import rate_text, seconds
from .judge import Verdict, outcome
from .judge_edges import age_text
from .judge_tree import best_way
from .pace import Pace
from .recording import FrameRow, Recording
from .series import Series

_HEAD = ("edge", "by", "topic", "seen", "rate", "largest gap", "age, oldest", "value")
_SENSOR_HEAD = ("topic", "frame", "seen", "rate", "placed in", "at its stamp", "tree behind, most")
_NONE = "-"
MAX_ROWS = 200
NO_TIME = 0.5e-3  # s; what is less ahead is how exactly a clock is read
# Errors that say nothing against the robot: there was too little to compare.
_NOTHING = {
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
    """Return the edges and the stamped messages as tables."""
    recording = verdict.recording
    rows = list(_edges(recording))
    lines = _columns([_HEAD, *rows[:MAX_ROWS]]) if rows else []
    if len(rows) > MAX_ROWS:
        lines.append(f"...{and_more(len(rows) - MAX_ROWS, 'edges')}; --format json has them all")
    sensors = list(_sensors(recording))
    if sensors:
        lines += ["", *_columns([_SENSOR_HEAD, *sensors[:MAX_ROWS]])]
    if recording.asked:
        head = ("tf2_echo", "line", "value")
        asked = [
            (f"{answer.source} -> {answer.target}", str(answer.line), outcome(recording, answer))
            for answer in recording.asked[:MAX_ROWS]
        ]
        lines += ([""] if lines else []) + _columns([head, *asked])
    return lines


def summary(verdict: Verdict, name: str, strict: bool) -> str:
    """Return the last line: what was looked at, and what came out."""
    recording = verdict.recording
    parts = []
    if recording.messages:
        parts.append(counted(recording.messages, "message"))
    if recording.timed and recording.start is not None and recording.end > recording.start:
        parts.append(f"{(recording.end - recording.start) / SECOND:.1f} s")
    edges = len(recording.into) or len(recording.rows)
    parts += [counted(edges, "edge")] if edges else []
    parts += [f"{counted(len(recording.asked), 'answer')} of tf2_echo"] if recording.asked else []
    seen = f" ({', '.join(parts)})" if parts else ""
    counts = [(verdict.count(ERROR), "error"), (verdict.count(WARNING), "warning"), (verdict.count(NOTE), "note")]
    problems = ", ".join(counted(number, word) for number, word in counts if number)
    failing = {finding.rule for finding in verdict.findings if finding.severity == ERROR}
    if failing and failing <= _NOTHING:
        return f"{name}: could not be compared: {problems}{seen}"
    if verdict.fails(strict):
        return f"{name}: the robot that ran is not the one that is described: {problems}{seen}"
    return f"{name}: as described{f', {problems}' if problems else ''}{seen}"


def _edges(recording: Recording) -> Iterator[Sequence[str]]:
    into, rows = recording.into, {row.child: row for row in recording.rows}
    told = set()
    for edge in best_way(recording).present:
        told.add(edge.child)
        if edge.child in into:
            for series in into[edge.child]:
                yield _series_row(recording, series, edge)
        elif edge.child in rows:
            yield _frame_row(recording, rows[edge.child], edge)
        elif recording.whole:
            yield (edge.name, edge.publisher.name, _NONE, "never", *[_NONE] * 3, "missing")
    for child, of_child in into.items():
        if child not in told:
            for series in of_child:
                yield _series_row(recording, series, None)
    for row in recording.rows:
        if row.child not in told:
            yield _frame_row(recording, row, None)


def _series_row(recording: Recording, series: Series, edge: Expected | None) -> Sequence[str]:
    pace = series.pace
    gap, age = _NONE, _NONE
    if not series.still and recording.timed:
        gap = seconds(pace.gap.seconds) if pace.count > 1 else _NONE
        age = _age(pace, recording)
    rate = _NONE if series.still or math.isnan(pace.rate) else rate_text(pace.rate)
    by = _publishers(recording, edge)
    return (series.name, by, series.topic, f"{pace.count:,}", rate, gap, age, value_text(series))


def _age(pace: Pace, recording: Recording) -> str:
    """Return the mean age of an edge, or how far it is dated ahead, and the oldest that its newest stamp was."""
    if pace.zeros == pace.count:
        return "no stamp"
    mean = pace.mean_age
    if pace.other_clock:
        return f"{seconds(abs(mean))} {'behind' if mean > 0 else 'ahead'}: another clock"
    oldest = seconds(max(0.0, pace.oldest_until(recording.end).seconds))
    return f"{seconds(-mean)} ahead, {oldest}" if mean < -NO_TIME else f"{age_text(mean)}, {oldest}"


def _publishers(recording: Recording, edge: Expected | None) -> str:
    """Return who may publish an edge: of several nodes that take turns, a recording does not say which it was."""
    if edge is None:
        return "?"
    same = recording.description.by_child[edge.child]
    known = recording.description.options.modes
    return edge.publisher.name if known else " or ".join(dict.fromkeys(other.publisher.name for other in same))


def value_text(series: Series) -> str:
    """Return in a few words how the value of an edge compares with the description."""
    values = series.values
    if series.edge is None:
        return "not described"
    if series.edge.parent != series.parent:
        return "wrong parent"
    if values.bad == series.pace.count:
        return "no rotation"
    if values.wrong:
        return "wrong" if values.wrong == values.compared else f"wrong in {values.wrong:,} of {values.compared:,}"
    if values.by_state and series.edge.moving:
        return f"as described, {values.by_state:,} by joint state"
    if values.compared:
        return "as described" if not series.edge.moving else "as its joint can be"
    return "known to its publisher alone"


def _frame_row(recording: Recording, row: FrameRow, edge: Expected | None) -> Sequence[str]:
    by = _publishers(recording, edge)
    rate = _NONE if row.still else rate_text(row.rate)
    age = _NONE if row.age is None or row.still else age_text(row.age)
    if row.age is not None and row.age < -NO_TIME and not row.still:
        age = f"{seconds(-row.age)} ahead"
    value = "not described"
    if edge is not None:
        value = "parent as described" if edge.parent == row.parent else "wrong parent"
    topic = "/tf_static" if row.still else "/tf"
    return (f"{row.parent} -> {row.child}", by, topic, "yes", rate, _NONE, age, value)


def _sensors(recording: Recording) -> Iterator[Sequence[str]]:
    states = recording.joints.pace
    if states.count:
        yield ("/joint_states", _NONE, f"{states.count:,}", rate_text(states.rate), *[_NONE] * 3)
    for log in recording.sensors.values():
        for use in log.frames.values():
            start = (log.topic, use.frame or '""', f"{use.pace.count:,}", rate_text(use.pace.rate))
            lookups = [one for one in use.lookups.values() if one.asked and one.target != use.frame]
            if not lookups:
                yield (*start, *[_NONE] * 3)
            for one in lookups:
                answered = one.asked - one.failed
                lag = _NONE if not one.failed else f"{seconds(one.mean_lag)}, {seconds(one.lag_most)}"
                yield (*start, one.target, f"{answered:,} of {one.asked:,}", lag)


def _columns(rows: Sequence[Sequence[str]]) -> list[str]:
    rows = [[printable(cell, keep="\t") for cell in row] for row in rows]
    widths = [max(len(row[at]) for row in rows) for at in range(len(rows[0]))]
    return ["  ".join(f"{cell:<{width}}" for cell, width in zip(row, widths, strict=True)).rstrip() for row in rows]
