"""Draw rates and gaps over time as SVG, one row per edge. The same recording gives the same bytes."""

from __future__ import annotations

import itertools
from xml.sax.saxutils import escape

import numpy as np

from rosorin_compile.source.wording import masked

from .findings import rate_text, seconds
from .recording import Recording
from .series import SECOND, SLICES, Pace, Times, slice_width

_MAX_ROWS = 80
_SHORT = SECOND // 2  # shorter pauses are not drawn as gaps
_LABEL, _PLOT, _RIGHT, _ROW, _TOP = 350, 720, 150, 26, 46
_LETTERS = 46
_STYLE = (  # readable on white and on black
    "text{font:12px ui-monospace,Menlo,Consolas,monospace;fill:#24292f}"
    ".t{font-weight:600}.m{fill:#6e7781}.axis{stroke:#8c959f;stroke-width:1}"
    ".bar{fill:#4493f8}.gap{fill:#e5534b}.rest{fill:#8c959f;opacity:.25}"
    "@media (prefers-color-scheme:dark){text{fill:#e6edf3}.m{fill:#9198a1}}"
)


def as_svg(recording: Recording) -> str:
    """Return the picture of a recording. Raises ValueError if it has no times of arrival."""
    rows = _rows(recording)
    if not recording.timed or not rows:
        raise ValueError("a picture needs a recording that says when messages were received")
    span = max(recording.end - recording.start, 1)
    width = slice_width(span)
    slices = min(SLICES, int(-(-span // width)))
    height, total = _TOP + _ROW * len(rows) + 40, _LABEL + _PLOT + _RIGHT
    title = f"{recording.description.robot.name}: {recording.messages:,} messages in {span / SECOND:.1f} s"
    size, label = f'width="{total}" height="{height}" viewBox="0 0 {total} {height}"', _escaped(title)
    parts = [f'<svg xmlns="http://www.w3.org/2000/svg" {size} role="img" aria-label="{label}">']
    parts += [f"<style>{_STYLE}</style>", _text(8, 20, title, "t")]
    parts += [_text(_LABEL, 38, "messages a second; red: none for much longer than usual", "m")]
    parts += [_text(_LABEL + _PLOT + 10, 38, "rate, largest gap", "m")]
    for number, (label, pace, moves) in enumerate(rows):
        base = _TOP + _ROW * (number + 1) - 5
        shown = label if len(label) <= _LETTERS else f"{label[: _LETTERS - 3]}..."
        note = f"{rate_text(pace.rate)}, {seconds(pace.gap.seconds)}"
        counts = np.bincount(pace.slices(width), minlength=SLICES)[:slices]
        parts += [_text(8, base - 3, shown), f'<rect class="rest" x="{_LABEL}" y="{base}" width="{_PLOT}" height="1"/>']
        parts += [_bars(counts, base), *(_gaps(counts, pace, width, base) if moves else [])]
        note = note if moves and pace.count > 1 else f"{pace.count} in all"
        parts.append(_text(_LABEL + _PLOT + 10, base - 3, note, "m"))
    bottom = _TOP + _ROW * len(rows) + 4
    parts.append(f'<path class="axis" d="M{_LABEL} {bottom}h{_PLOT}"/>')
    for part in range(5):
        x, tick = _LABEL + _PLOT * part // 4, f"{span / SECOND * part / 4:.1f} s"
        parts += [f'<path class="axis" d="M{x} {bottom}v5"/>', _text(x - 14, bottom + 20, tick, "m")]
    return "\n".join([*parts, "</svg>", ""])


def _escaped(text: str) -> str:
    return escape(masked(text, keep="\t\n"), {'"': "&quot;"})


def _text(x: int, y: int, text: str, style: str = "") -> str:
    return f'<text{f" class={chr(34)}{style}{chr(34)}" if style else ""} x="{x}" y="{y}">{_escaped(text)}</text>'


def _rows(recording: Recording) -> list[tuple[str, Pace, bool]]:
    """Return label and pace of each row, and whether its pauses are gaps: those of a static edge are not."""
    rows = [(series.name, series.pace, True) for series in recording.series.values() if not series.static]
    rows += [("/joint_states", recording.joints.pace, True)] if recording.joints.pace.count else []
    rows += [(f"{use.topic} {use.frame}", use.pace, True) for use in recording.uses]
    rows += [(f"{series.name} (static)", series.pace, False) for series in recording.series.values() if series.static]
    return rows[:_MAX_ROWS]


def _bars(counts: Times, base: int) -> str:
    step, highest = _PLOT / len(counts), max(int(counts.max()), 1)
    path = []
    for at in np.flatnonzero(counts):
        tall = max(1.0, round(float(counts[at]) / highest * (_ROW - 8), 1))
        path.append(f"M{_LABEL + at * step:.1f} {base}v-{tall:g}h{step:.1f}v{tall:g}z")
    return f'<path class="bar" d="{"".join(path)}"/>'


def _gaps(counts: Times, pace: Pace, width: int, base: int) -> list[str]:
    """Return the pauses that are longer than three usual steps."""
    usual, step = (pace.last - pace.first) / max(1, pace.count - 1), _PLOT / len(counts)
    edges = np.concatenate(([-1], np.flatnonzero(counts), [len(counts)]))
    parts = []
    for before, after in itertools.pairwise(edges):
        empty = after - before - 1
        if empty * width > max(3 * usual, _SHORT):
            x = _LABEL + (before + 1) * step
            parts.append(f'<rect class="gap" x="{x:.1f}" y="{base - 6}" width="{empty * step:.1f}" height="6"/>')
    return parts
