"""Render the result of a simulation as tables of text, and as one self-contained page with plots."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

from rosorin_compile.formats.templating import Templates
from rosorin_compile.source.diagnostics import counted

from .world import FREE

if TYPE_CHECKING:
    from .scenarios import Curve, Stop
    from .simulation import Simulated

# A palette for colour-blind people (Okabe and Ito, 2008).
_COLOURS = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#8c8c8c")
_LEFT, _RIGHT, _TOP, _BOTTOM = 50.0, 335.0, 10.0, 150.0
_POINTS = 300  # of a curve: more than a figure has columns


class Table(NamedTuple):
    """A title, and rows of cells; the first row of several is the head."""

    title: str
    rows: list[tuple[str, ...]]


def tables(result: Simulated) -> list[Table]:
    """Return the results of the scenarios."""
    return [table for table in (_poses(result), _drive(result), _ranges(result), _energy(result)) if table.rows]


def _poses(result: Simulated) -> Table:
    is_free = result.base == FREE
    head = ("pose", "largest error", "joint", "touches")
    rows: list[tuple[str, ...]] = [(*head, "drift", "stands on") if is_free else head]
    for held in result.poses:
        if held.broken is not None:
            rows.append((held.pose, _broke(held.broken)))
            continue
        worst = held.worst
        error = (f"{worst[1]:.4f} {result.units[worst[0]]}", worst[0]) if worst else ("-", "no actuator holds one")
        row = (held.pose, *error, _names([" - ".join(touch.links) for touch in held.touches]))
        rows.append((*row, f"{1000 * held.drift:.1f} mm", _names(held.stands_on)) if is_free else row)
    return Table("poses", rows)


def _drive(result: Simulated) -> Table:
    rows: list[tuple[str, ...]] = []
    for driven in result.drive:
        if driven.broken is not None:
            rows.append((driven.command, _broke(driven.broken)))
            continue
        parts = list(zip(driven.asked, driven.measured, ("m/s", "m/s", "rad/s"), strict=True))
        commanded = ", ".join(f"{part:.3f} {unit}" for part, _, unit in parts if part)
        measured = ", ".join(f"{value:.3f} {unit}" for part, value, unit in parts if part)
        errors = (f"{driven.off:.1%}", f"{driven.cross:.3f}", f"{1000 * driven.ripple:.2f} mm")
        rows.append((driven.command, commanded, measured, *errors))
    return Table("drive", [("command", "asked", "measured", "off", "cross", "ripple"), *rows] if rows else [])


def _ranges(result: Simulated) -> Table:
    rows: list[tuple[str, ...]] = []
    for swept in result.ranges:
        if swept.broken is not None:
            rows.append((swept.joint, _broke(swept.broken)))
            continue
        unit = result.units[swept.joint]
        ends = [text for end in swept.ends for text in (f"{end.asked:.3f}", f"{end.error:.4f}")]
        touches = [
            f"{' - '.join(end.first_touch.links)} from {end.touch_position:.2f} {unit}"
            for end in swept.ends
            if end.first_touch
        ]
        rows.append((f"{swept.joint} ({unit})", *ends, ", ".join(touches) or "-"))
    return Table("ranges", [("joint", "lower", "error", "upper", "error", "touches"), *rows] if rows else [])


def _energy(result: Simulated) -> Table:
    swung = result.energy
    if swung is None:
        return Table("energy", [])
    change = f"{swung.change:.1%}" if swung.change >= 0.0005 else "less than 0.1%"
    text = _broke(swung.broken) if swung.broken else f"it changes by {change} in half a second"
    return Table("energy", [(f"energy without damping, friction and actuators: {text}",)])


def _broke(stop: Stop) -> str:
    return f"broke after {stop.time:.3g} s"


def _names(names: Sequence[str]) -> str:
    if len(names) <= 2:
        return ", ".join(names) or "-"
    return f"{names[0]}, {names[1]} and {len(names) - 2} more"


def text(result: Simulated) -> str:
    """Return the tables as lines, with aligned columns."""
    blocks = []
    for _, rows in tables(result):
        widths = [max(len(row[i]) for row in rows if i < len(row)) for i in range(max(map(len, rows)))]
        lines = ("  ".join(cell.ljust(width) for cell, width in zip(row, widths, strict=False)) for row in rows)
        blocks.append("\n".join(line.rstrip() for line in lines))
    return "\n\n".join(blocks)


def about(result: Simulated) -> str:
    """Return one line about the engine, the base and the time step."""
    base = "on a floor" if result.base == FREE else "its base held"
    return f"simulated in MuJoCo {result.mujoco}, {base}, in steps of {1000 * result.timestep:g} ms"


def summary(result: Simulated) -> str:
    """Return the number of scenarios of each kind."""
    counts = {"pose": len(result.poses), "drive command": len(result.drive), "range": len(result.ranges)}
    return ", ".join(counted(count, word) for word, count in counts.items() if count)


def page(result: Simulated) -> str:
    """Return a page of HTML with the tables, the diagnostics and plots. It refers to no other file."""
    findings = [{"severity": one.severity, "rule": one.rule, "message": one.message} for one in result.diagnostics]
    kinds = (
        ("poses: error of the joints, height of the base", [(one.pose, one.curves) for one in result.poses]),
        ("drive: velocity and height of the base", [(one.command, one.curves) for one in result.drive]),
        ("ranges: position of the joint", [(one.joint, one.curves) for one in result.ranges]),
        ("energy", [("without damping", result.energy.curves)] if result.energy else []),
    )
    groups = [(title, [one for name, curves in each for one in _figures(name, curves)]) for title, each in kinds]
    values = {
        "name": result.robot,
        "about": about(result),
        "findings": findings,
        "tables": tables(result),
        "groups": [(title, figures) for title, figures in groups if figures],
    }
    return Templates().own("mujoco/simulation.html.jinja", values)


def _figures(title: str, curves: Sequence[Curve]) -> Iterator[dict[str, Any]]:
    """Yield one figure for the curves of each unit that change most; the height of the base has its own."""
    kinds: dict[tuple[str, bool], list[Curve]] = {}
    for curve in curves:
        kinds.setdefault((curve.unit, curve.name == "height"), []).append(curve)
    for (unit, is_height), group in kinds.items():
        shown = sorted(group, key=lambda curve: min(curve.values) - max(curve.values))[: len(_COLOURS)]
        yield _figure(f"{title}, height" if is_height else title, unit, shown)


def _figure(title: str, unit: str, curves: Sequence[Curve]) -> dict[str, Any]:
    low, high = min(min(c.values) for c in curves), max(max(c.values) for c in curves)
    middle, end = (low + high) / 2, curves[0].times[-1]
    half = max((high - low) / 2, 1e-6, 1e-3 * abs(middle))
    lines = []
    for curve, colour in zip(curves, _COLOURS, strict=False):
        points = []
        for time, value in list(zip(curve.times, curve.values, strict=True))[:: max(1, len(curve.times) // _POINTS)]:
            share = (value - (middle - half)) / (2 * half)
            points.append(f"{_LEFT + (_RIGHT - _LEFT) * time / end:.1f},{_BOTTOM - (_BOTTOM - _TOP) * share:.1f}")
        lines.append({"name": curve.name, "colour": colour, "points": " ".join(points)})
    ends = {"low": f"{middle - half:.2g}", "high": f"{middle + half:.2g}", "end": f"{end:.3g}"}
    return {"title": title, "unit": unit, "lines": lines, **ends}
