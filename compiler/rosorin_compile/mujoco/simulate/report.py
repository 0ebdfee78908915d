"""Render the result of a simulation as tables of text, and as one self-contained page with plots."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import groupby
from typing import TYPE_CHECKING, Any

from rosorin_compile.formats.templating import Templates
from rosorin_compile.source.diagnostics import counted, listed

from .world import FREE

if TYPE_CHECKING:
    from .scenarios import Curve
    from .simulation import Simulated

    Table = list[tuple[str, ...]]

# A palette for colour-blind people (Okabe and Ito, 2008).
_COLOURS = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#8c8c8c")
_LEFT, _RIGHT, _TOP, _BOTTOM = 50.0, 335.0, 10.0, 150.0
_POINTS = 300  # of a curve: more than a figure has columns


def tables(result: Simulated) -> dict[str, Table]:
    """Return the results of the scenarios by title, as rows of cells; the first of several rows is the head."""
    floor = ("drift", "stands on") if result.base == FREE else ()
    poses: Table = [("pose", "largest error", "joint", "touches", *floor)]
    for held in result.poses:
        error = (f"{held.worst[1]:.4f} {result.units[held.worst[0]]}", held.worst[0]) if held.worst else ("-", "-")
        touches = listed([" - ".join(touch.links) for touch in held.touches], 2) or "-"
        ground = (f"{1000 * held.drift:.1f} mm", listed(held.stands_on, 2) or "-") if floor else ()
        poses.append((held.pose, *_or_broken(held, (*error, touches, *ground))))
    drive: Table = [("command", "commanded", "measured", "off", "cross", "ripple")]
    for driven in result.drive:
        parts = zip(driven.commanded, driven.measured, ("m/s", "m/s", "rad/s"), strict=True)
        texts = [(f"{part:.3f} {unit}", f"{value:.3f} {unit}") for part, value, unit in parts if part]
        errors = (f"{driven.off:.1%}", f"{driven.cross:.3f}", f"{1000 * driven.ripple:.2f} mm")
        columns = [", ".join(column) for column in zip(*texts, strict=True)]
        drive.append((driven.command, *_or_broken(driven, (*columns, *errors))))
    ranges: Table = [("joint", "lower", "error", "upper", "error", "touches")]
    for swept in result.ranges:
        unit = result.units[swept.joint]
        ends = [text for end in swept.ends for text in (f"{end.target:.3f}", f"{end.error:.4f}")]
        touched = [end for end in swept.ends if end.first_touch]
        touches = ", ".join(
            f"{' - '.join(end.first_touch.links)} from {end.touch_position:.2f} {unit}"
            for end in touched
            if end.first_touch
        )
        ranges.append((f"{swept.joint} ({unit})", *_or_broken(swept, (*ends, touches or "-"))))
    found = {"poses": poses, "drive": drive, "ranges": ranges}
    found = {title: rows for title, rows in found.items() if len(rows) > 1}
    if result.energy is not None:
        change = f"{result.energy.change:.1%}" if result.energy.change >= 0.0005 else "less than 0.1%"
        (change,) = _or_broken(result.energy, (f"it changes by {change} in half a second",))
        found["energy"] = [(f"energy without damping, friction and actuators: {change}",)]
    return found


def _or_broken(result: Any, cells: tuple[str, ...]) -> tuple[str, ...]:
    return cells if result.broken is None else (f"broke after {result.broken.time:.3g} s",)


def text(result: Simulated) -> str:
    """Return the tables as lines, with aligned columns."""
    blocks = []
    for rows in tables(result).values():
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
        "findings": result.diagnostics,
        "tables": tables(result).items(),
        "groups": [(title, figures) for title, figures in groups if figures],
    }
    return Templates().own("mujoco/simulation.html.jinja", values)


def _figures(title: str, curves: Sequence[Curve]) -> Iterator[dict[str, Any]]:
    """Yield one figure for the curves of each unit that change most; the height of the base has its own."""

    def kind(curve: Curve) -> tuple[bool, str]:
        return curve.name == "height", curve.unit

    for (is_height, unit), group in groupby(sorted(curves, key=kind), kind):
        shown = sorted(group, key=lambda curve: min(curve.values) - max(curve.values))[: len(_COLOURS)]
        low, high = min(min(curve.values) for curve in shown), max(max(curve.values) for curve in shown)
        middle, end = (low + high) / 2, shown[0].times[-1]
        half = max((high - low) / 2, 1e-6, 1e-3 * abs(middle))
        lines = []
        for curve, colour in zip(shown, _COLOURS, strict=False):
            samples = list(zip(curve.times, curve.values, strict=True))[:: max(1, len(curve.times) // _POINTS)]
            x = (_LEFT + (_RIGHT - _LEFT) * time / end for time, _ in samples)
            y = (_BOTTOM - (_BOTTOM - _TOP) * (value - middle + half) / (2 * half) for _, value in samples)
            points = " ".join(f"{across:.1f},{down:.1f}" for across, down in zip(x, y, strict=True))
            lines.append({"name": curve.name, "colour": colour, "points": points})
        ends = {"low": f"{middle - half:.2g}", "high": f"{middle + half:.2g}", "end": f"{end:.3g}"}
        yield {"title": f"{title}, height" if is_height else title, "unit": unit, "lines": lines, **ends}
