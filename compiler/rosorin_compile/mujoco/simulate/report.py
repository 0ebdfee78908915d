"""Render the result of a simulation as tables of text, and as one self-contained page with plots."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, Any

from rosorin_compile.formats.templating import Templates
from rosorin_compile.source.diagnostics import counted

from .world import FREE, Touch

if TYPE_CHECKING:
    from .simulation import Simulated
    from .trials import Curve, Driven, PoseTrial, Swept

_FEW = 2

# A palette that people tell apart who see colours otherwise (Okabe and Ito, 2008).
_COLOURS = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#8c8c8c")
_LEFT, _RIGHT, _TOP, _BOTTOM = 50.0, 335.0, 10.0, 150.0
_POINTS = 300  # of a curve: more than a figure has columns
_MOST_CURVES = 7  # in one figure: those that move most


def tables(result: Simulated) -> list[tuple[str, ...] | str]:
    """Return the results of the trials: rows of columns, a title before each table as a text."""
    made: list[tuple[str, ...] | str] = ["poses"]
    free = result.base == FREE
    head = ("pose", "largest error", "joint", "touches")
    made.append((*head, "drift", "stands on") if free else head)
    made += [_pose(result, held, free) for held in result.poses]
    if result.drive:
        made += ["drive", ("command", "asked", "measured", "off", "cross", "ripple")]
        made += list(map(_drive, result.drive))
    if result.ranges:
        made += ["ranges", ("joint", "lower", "error", "upper", "error", "touches")]
        made += [_sweep(result, swept) for swept in result.ranges]
    if result.energy is not None:
        swung = result.energy
        said = (
            f"broke after {swung.broken.time:.3g} s"
            if swung.broken
            else f"it changes by {_percent(swung.change)} in half a second"
        )
        made += ["energy", (f"energy without damping, friction and actuators: {said}",)]
    return made


def _percent(share: float) -> str:
    return f"{share:.1%}" if share >= 0.0005 else "less than 0.1%"


def _pose(result: Simulated, held: PoseTrial, free: bool) -> tuple[str, ...]:
    if held.broken is not None:
        return (held.pose, f"broke after {held.broken.time:.3g} s")
    worst = held.worst
    said = (f"{worst[1]:.4f} {result.units[worst[0]]}", worst[0]) if worst else ("-", "no actuator holds one")
    row = (held.pose, *said, _touches(held.touches))
    if not free:
        return row
    return (*row, f"{1000 * held.drift:.1f} mm", _named(held.stands_on))


def _named(names: Sequence[str]) -> str:
    more = len(names) - _FEW
    return f"{', '.join(names[:_FEW])}{f' and {more} more' if more > 0 else ''}" if names else "-"


def _touches(touches: Sequence[Touch]) -> str:
    return _named([" - ".join(one.links) for one in touches])


def _drive(driven: Driven) -> tuple[str, ...]:
    if driven.broken is not None:
        return (driven.command, f"broke after {driven.broken.time:.3g} s")
    return (
        driven.command,
        _parts(driven.asked, driven.asked),
        _parts(driven.asked, driven.measured),
        f"{driven.off:.1%}",
        f"{driven.cross:.3f}",
        f"{1000 * driven.ripple:.2f} mm",
    )


def _parts(asked: Sequence[float], values: Sequence[float]) -> str:
    units = ("m/s", "m/s", "rad/s")
    return ", ".join(f"{v:.3f} {unit}" for a, v, unit in zip(asked, values, units, strict=True) if a)


def _sweep(result: Simulated, swept: Swept) -> tuple[str, ...]:
    if swept.broken is not None:
        return (swept.joint, f"broke after {swept.broken.time:.3g} s")
    unit = result.units[swept.joint]
    ends = [text for end in swept.ends for text in (f"{end.asked:.3f}", f"{end.error:.4f}")]
    met = [
        f"{' - '.join(end.first_touch.links)} from {end.touch_position:.2f} {unit}"
        for end in swept.ends
        if end.first_touch
    ]
    return (f"{swept.joint} ({unit})", *ends, ", ".join(met) or "-")


def _titled(rows: Sequence[tuple[str, ...] | str]) -> list[tuple[str, list[tuple[str, ...]]]]:
    """Return tables with their titles."""
    made: list[tuple[str, list[tuple[str, ...]]]] = []
    for row in rows:
        if isinstance(row, str):
            made.append((row, []))
        else:
            made[-1][1].append(row)
    return made


def text(rows: Sequence[tuple[str, ...] | str]) -> str:
    """Return tables as lines: columns of one width in each table."""
    lines: list[str] = []
    for _title, table in _titled(rows):
        if lines:
            lines.append("")
        widths = [max(len(row[i]) for row in table if i < len(row)) for i in range(max(map(len, table)))]
        for row in table:
            cells = (f"{cell:<{width}}" for cell, width in zip(row, widths, strict=False))
            lines.append("  ".join(cells).rstrip())
    return "\n".join(lines)


def about(result: Simulated) -> str:
    """Return one line about the engine, the base and the time step."""
    base = "on a floor" if result.base == FREE else "its base held"
    return f"simulated in MuJoCo {result.mujoco}, {base}, in steps of {1000 * result.timestep:g} ms"


def summary(result: Simulated) -> str:
    """Return the number of trials of each kind."""
    parts: Iterator[str] = (
        counted(count, word)
        for count, word in (
            (len(result.poses), "pose"),
            (len(result.drive), "drive command"),
            (len(result.ranges), "range"),
        )
        if count
    )
    return ", ".join(parts)


def page(result: Simulated) -> str:
    """Return a page of HTML with the tables, the diagnostics and plots. It refers to no other file."""
    found = result.diagnostics
    values = {
        "name": result.robot,
        "about": about(result),
        "findings": [{"severity": one.severity, "rule": one.rule, "message": one.message} for one in found],
        "tables": _titled(tables(result)),
        "groups": list(_groups(result)),
    }
    return Templates().own("mujoco/simulation.html.jinja", values)


def _groups(result: Simulated) -> Iterator[tuple[str, list[dict[str, Any]]]]:
    """Yield the figures of each kind of trial."""
    kinds = (
        ("poses: error of the joints, height of the base", [(one.pose, one.curves) for one in result.poses]),
        ("drive: velocity and height of the base", [(one.command, one.curves) for one in result.drive]),
        ("ranges: position of the joint", [(one.joint, one.curves) for one in result.ranges]),
        ("energy", [("without damping", result.energy.curves)] if result.energy else []),
    )
    for title, trial in kinds:
        figures = [figure for name, curves in trial for figure in _figures(name, curves)]
        if figures:
            yield title, figures


def _figures(title: str, curves: Sequence[Curve]) -> Iterator[dict[str, Any]]:
    """Yield one figure for the curves of each unit; the curve of the height gets its own."""
    kinds: dict[tuple[str, bool], list[Curve]] = {}
    for curve in curves:
        if curve.times:
            kinds.setdefault((curve.unit, curve.name == "height"), []).append(curve)
    for (unit, is_height), group in kinds.items():
        shown = sorted(group, key=lambda curve: min(curve.values) - max(curve.values))[:_MOST_CURVES]
        yield _figure(f"{title}, height" if is_height else title, unit, shown)


def _figure(title: str, unit: str, curves: Sequence[Curve]) -> dict[str, Any]:
    low, high = min(min(c.values) for c in curves), max(max(c.values) for c in curves)
    middle, end = (low + high) / 2, curves[0].times[-1]
    half = max((high - low) / 2, 1e-6, 1e-3 * abs(middle))
    low, high = middle - half, middle + half

    def point(time: float, value: float) -> str:
        x = _LEFT + (_RIGHT - _LEFT) * time / end
        return f"{x:.1f},{_BOTTOM - (_BOTTOM - _TOP) * (value - low) / (high - low):.1f}"

    lines = []
    for index, curve in enumerate(curves):
        step = max(1, len(curve.times) // _POINTS)
        pairs = list(zip(curve.times, curve.values, strict=True))[::step]
        points = " ".join(point(*pair) for pair in pairs)
        lines.append({"name": curve.name, "colour": _COLOURS[index % len(_COLOURS)], "points": points})
    return {
        "title": title,
        "unit": unit,
        "low": f"{low:.2g}",
        "high": f"{high:.2g}",
        "end": f"{end:.3g}",
        "lines": lines,
    }
