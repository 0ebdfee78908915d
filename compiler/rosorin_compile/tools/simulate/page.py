"""The page of a simulation: what was said, the tables, and curves over time; one file that asks for no other."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

from ...diagnostics import Diagnostic
from ...formats.templating import BUILTIN, Templates
from . import telling
from .trials import Curve, Trials
from .world import World

# A palette that people tell apart who see colours otherwise (Okabe and Ito, 2008).
_COLOURS = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#8c8c8c")
_LEFT, _RIGHT, _TOP, _BOTTOM = 50.0, 335.0, 10.0, 150.0
_POINTS = 300  # of a curve: more than a figure has columns
_MOST_CURVES = 7  # in one figure: those that move most


def page(world: World, trials: Trials, found: Sequence[Diagnostic]) -> str:
    """Return the page. It is the same for the same robot: it says nothing of how fast the computer was."""
    tables: list[tuple[str, list[tuple[str, ...]]]] = []
    for row in telling.tables(world, trials):
        if isinstance(row, str):
            tables.append((row, []))
        else:
            tables[-1][1].append(row)
    values = {
        "name": world.robot.name,
        "about": telling.about(world),
        "findings": [{"severity": one.severity, "rule": one.rule, "message": one.message} for one in found],
        "tables": tables,
        "groups": list(_groups(trials)),
    }
    return Templates().render(f"{BUILTIN}simulation.html.jinja", values)


def _groups(trials: Trials) -> Iterator[tuple[str, list[dict[str, Any]]]]:
    """Yield the figures of each kind of trial."""
    kinds = (
        ("poses: error of the joints, height of the base", [(one.pose, one.curves) for one in trials.poses]),
        ("drive: velocity and height of the base", [(one.command, one.curves) for one in trials.drives]),
        ("ranges: position of the joint", [(one.joint, one.curves) for one in trials.sweeps]),
        ("energy", [("without damping", trials.swung.curves)] if trials.swung else []),
    )
    for title, trial in kinds:
        figures = [figure for name, curves in trial for figure in _figures(name, curves)]
        if figures:
            yield title, figures


def _figures(title: str, curves: Sequence[Curve]) -> Iterator[dict[str, Any]]:
    """Yield a figure for each unit; height has one of its own."""
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
        "low": f"{low:.4g}",
        "high": f"{high:.4g}",
        "end": f"{end:.3g}",
        "lines": lines,
    }
