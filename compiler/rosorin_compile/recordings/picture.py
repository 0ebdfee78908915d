"""Draw rates and gaps over time as SVG, one row per edge. The same recording gives the same bytes."""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from typing import Any

import numpy as np

from rosorin_compile.formats.templating import Templates
from rosorin_compile.source.wording import masked

from .findings import rate_text, seconds
from .recording import Recording
from .series import SECOND, SLICES, Pace, Times, slice_width

_MAX_ROWS = 80
_SHORT = SECOND // 2  # shorter pauses are not drawn as gaps
_LETTERS = 46


def as_svg(recording: Recording) -> str:
    """Return the picture of a recording. Raises ValueError if it has no times of arrival."""
    streams = _streams(recording)[:_MAX_ROWS]
    if not recording.timed or not streams:
        raise ValueError("a picture needs a recording that says when messages were received")
    span = max(recording.end - recording.start, 1)
    width = slice_width(span)
    slices = min(SLICES, -(-span // width))
    rows: list[dict[str, Any]] = []
    for label, pace, moves in streams:
        counts = np.bincount(pace.slices(width), minlength=SLICES)[:slices]
        note = f"{rate_text(pace.rate)}, {seconds(pace.gap.seconds)}"
        rows.append(
            {
                "label": masked(label if len(label) <= _LETTERS else f"{label[: _LETTERS - 3]}..."),
                "bars": [(at / slices, counts[at] / counts.max()) for at in np.flatnonzero(counts).tolist()],
                "gaps": list(_gaps(counts, pace, width)) if moves else [],
                "note": note if moves and pace.count > 1 else f"{pace.count} in all",
            }
        )
    title = f"{recording.description.robot.name}: {recording.messages:,} messages in {span / SECOND:.1f} s"
    values = {"title": masked(title), "rows": rows, "step": 1 / slices, "seconds": span / SECOND}
    return Templates.own("recordings/rates.svg.jinja", values)


def _streams(recording: Recording) -> list[tuple[str, Pace, bool]]:
    """Return label and pace of each row, and whether its pauses are gaps: those of a static edge are not."""
    rows = [(series.name, series.pace, True) for series in recording.series.values() if not series.static]
    rows += [("/joint_states", recording.joints.pace, True)] if recording.joints.pace.count else []
    rows += [(f"{use.topic} {use.frame}", use.pace, True) for use in recording.uses]
    rows += [(f"{series.name} (static)", series.pace, False) for series in recording.series.values() if series.static]
    return rows


def _gaps(counts: Times, pace: Pace, width: int) -> Iterator[tuple[float, float]]:
    """Yield start and length, as shares of the picture, of the pauses that are longer than three usual steps."""
    usual = (pace.last - pace.first) / max(1, pace.count - 1)
    edges = np.concatenate(([-1], np.flatnonzero(counts), [len(counts)]))
    for before, after in itertools.pairwise(edges.tolist()):
        if (after - before - 1) * width > max(3 * usual, _SHORT):
            yield (before + 1) / len(counts), (after - before - 1) / len(counts)
