"""Picture: rates and gaps over time as SVG, one row an edge. The same recording gives the same bytes."""

from __future__ import annotations

from xml.sax.saxutils import escape

import numpy as np

from rosorin_compile.source.diagnostics import masked

from .arrays import SECOND
from .findings import rate_text, seconds
from .judge import Verdict
from .pace import BINS, Pace
from .recording import Recording

MAX_ROWS = 80
SHORT = SECOND // 2  # what is shorter is no gap to look at, whatever the rate
_LABEL, _PLOT, _RIGHT, _ROW, _TOP = 350, 720, 150, 26, 46
_LETTERS = 46
# Colours that read on white and on black; dark mode turns the texts.
_STYLE = (
    "text{font:12px ui-monospace,Menlo,Consolas,monospace;fill:#24292f}"
    ".t{font-weight:600}.m{fill:#6e7781}.axis{stroke:#8c959f;stroke-width:1}"
    ".bar{fill:#4493f8}.gap{fill:#e5534b}.rest{fill:#8c959f;opacity:.25}"
    "@media (prefers-color-scheme:dark){text{fill:#e6edf3}.m{fill:#9198a1}}"
)


def as_svg(verdict: Verdict) -> str:
    """Return the picture of a recording. Raises ValueError if there is nothing with a time in it."""
    recording = verdict.recording
    rows = _rows(recording)
    if not recording.timed or not rows or recording.start is None:
        raise ValueError("a picture needs a recording that says when messages were received")
    span = max(recording.end - recording.start, 1)
    width = max(pace.bins.width for _, pace, _ in rows)
    while width * BINS < span:
        width *= 2
    slices = min(BINS, int(-(-span // width)))
    height = _TOP + _ROW * len(rows) + 40
    total = _LABEL + _PLOT + _RIGHT
    title = f"{verdict.description.robot.name}: {recording.messages:,} messages in {span / SECOND:.1f} s"
    parts = [
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{total}" height="{height}" viewBox="0 0 {total} {height}" '
        f'role="img" aria-label="{_text(title)}">',
        f"<style>{_STYLE}</style>",
        f'<text class="t" x="8" y="20">{_text(title)}</text>',
        f'<text class="m" x="{_LABEL}" y="38">messages a second; red: none for much longer than usual</text>',
        f'<text class="m" x="{_LABEL + _PLOT + 10}" y="38">rate, largest gap</text>',
    ]
    for number, (label, pace, late) in enumerate(rows):
        parts += _row(label, pace, late, _TOP + _ROW * number, width, slices)
    parts += _axis(_TOP + _ROW * len(rows), span)
    return "\n".join([*parts, "</svg>", ""])


def _text(text: str) -> str:
    return escape(masked(text, keep="\t\n"), {'"': "&quot;"})


def _rows(recording: Recording) -> list[tuple[str, Pace, bool]]:
    """Return what is drawn: label, pace, and whether a gap in it is one (an edge on /tf_static has none)."""
    moving = [series for series in recording.series.values() if not series.still]
    still = [series for series in recording.series.values() if series.still]
    rows = [(series.name, series.pace, True) for series in moving]
    if recording.joints.pace.count:
        rows.append(("/joint_states", recording.joints.pace, True))
    for log in recording.sensors.values():
        several = len(log.frames) > 1
        rows += [(f"{log.topic} {use.frame}" if several else log.topic, use.pace, True) for use in log.frames.values()]
    rows += [(f"{series.name} (static)", series.pace, False) for series in still]
    return rows[:MAX_ROWS]


def _row(label: str, pace: Pace, late: bool, top: int, width: int, slices: int) -> list[str]:
    counts = pace.bins.at_width(width)[:slices]
    highest = max(float(counts.max()), 1.0)
    step = _PLOT / slices
    base = top + _ROW - 5
    shown = label if len(label) <= _LETTERS else f"{label[: _LETTERS - 3]}..."
    parts = [f'<text x="8" y="{base - 3}">{_text(shown)}</text>']
    parts.append(f'<rect class="rest" x="{_LABEL}" y="{base}" width="{_PLOT}" height="1"/>')
    path = []
    for at in np.flatnonzero(counts):
        tall = max(1.0, round(float(counts[at]) / highest * (_ROW - 8), 1))
        path.append(f"M{_LABEL + at * step:.1f} {base}v-{tall:g}h{step:.1f}v{tall:g}z")
    parts.append(f'<path class="bar" d="{"".join(path)}"/>')
    if late:
        parts += _gaps(counts, pace, width, step, base)
    note = f"{rate_text(pace.rate)}, {seconds(pace.gap.seconds)}" if late and pace.count > 1 else f"{pace.count} in all"
    parts.append(f'<text class="m" x="{_LABEL + _PLOT + 10}" y="{base - 3}">{_text(note)}</text>')
    return parts


def _gaps(counts: np.ndarray, pace: Pace, width: int, step: float, base: int) -> list[str]:
    """Return the times without a message that are longer than three usual steps, and not short."""
    usual = (pace.last - pace.first) / max(1, pace.count - 1)
    parts, begin = [], -1
    for at in range(len(counts) + 1):
        empty = at < len(counts) and counts[at] == 0
        if empty and begin < 0:
            begin = at
        elif not empty and begin >= 0:
            if (at - begin) * width > max(3 * usual, SHORT):
                x, wide = _LABEL + begin * step, (at - begin) * step
                parts.append(f'<rect class="gap" x="{x:.1f}" y="{base - 6}" width="{wide:.1f}" height="6"/>')
            begin = -1
    return parts


def _axis(top: int, span: int) -> list[str]:
    parts = [f'<path class="axis" d="M{_LABEL} {top + 4}h{_PLOT}"/>']
    for part in range(5):
        x = _LABEL + _PLOT * part / 4
        parts.append(f'<path class="axis" d="M{x:g} {top + 4}v5"/>')
        parts.append(f'<text class="m" x="{x - 14:g}" y="{top + 24}">{span / SECOND * part / 4:.1f} s</text>')
    return parts
