"""Report: what came of the trials as tables for people, as JSON for programs, and as a page with curves.

The page is one file that asks for no other. It is the same for the same robot: nothing in it is of the computer.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

from rosorin_compile.formats.templating import Templates
from rosorin_compile.source.diagnostics import Diagnostic, counted

from .judging import LIMITS
from .trials import Curve, Driven, PoseTrial, Swept, Trials
from .world import FREE, Touch, World

_FEW = 2

# A palette that people tell apart who see colours otherwise (Okabe and Ito, 2008).
_COLOURS = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#8c8c8c")
_LEFT, _RIGHT, _TOP, _BOTTOM = 50.0, 335.0, 10.0, 150.0
_POINTS = 300  # of a curve: more than a figure has columns
_MOST_CURVES = 7  # in one figure: those that move most


def tables(world: World, trials: Trials) -> list[tuple[str, ...] | str]:
    """Return what came of the trials: rows of columns, a title before each table as a text."""
    made: list[tuple[str, ...] | str] = ["poses"]
    free = world.base == FREE
    head = ("pose", "largest error", "joint", "touches")
    made.append((*head, "drift", "stands on") if free else head)
    made += [_pose(world, held, free) for held in trials.poses]
    if trials.drives:
        made += ["drive", ("command", "asked", "measured", "off", "cross", "ripple")]
        made += list(map(_drive, trials.drives))
    if trials.sweeps:
        made += ["ranges", ("joint", "lower", "error", "upper", "error", "touches")]
        made += [_sweep(world, swept) for swept in trials.sweeps]
    if trials.swung is not None:
        swung = trials.swung
        said = (
            f"broke after {swung.broken.time:.3g} s"
            if swung.broken
            else f"it changes by {_percent(swung.change)} in half a second"
        )
        made += ["energy", (f"energy without damping, friction and actuators: {said}",)]
    return made


def _percent(share: float) -> str:
    return f"{share:.1%}" if share >= 0.0005 else "less than 0.1%"


def _unit(world: World, joint: str) -> str:
    return "m" if world.robot.joint[joint].type == "prismatic" else "rad"


def _pose(world: World, held: PoseTrial, free: bool) -> tuple[str, ...]:
    if held.broken is not None:
        return (held.pose, f"broke after {held.broken.time:.3g} s")
    worst = held.worst
    said = (f"{worst[1]:.4f} {_unit(world, worst[0])}", worst[0]) if worst else ("-", "no actuator holds one")
    row = (held.pose, *said, _touches(held.touches))
    if not free:
        return row
    return (*row, f"{1000 * held.drift:.1f} mm", _named(held.stands_on))


def _named(names: Sequence[str]) -> str:
    more = len(names) - _FEW
    return f"{', '.join(names[:_FEW])}{f' and {more} more' if more > 0 else ''}" if names else "-"


def _touches(touches: Sequence[Touch]) -> str:
    return _named([f"{one.one} - {one.other}" for one in touches])


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


def _sweep(world: World, swept: Swept) -> tuple[str, ...]:
    if swept.broken is not None:
        return (swept.joint, f"broke after {swept.broken.time:.3g} s")
    unit = _unit(world, swept.joint)
    ends = [text for end in swept.ends for text in (f"{end.asked:.3f}", f"{end.error:.4f}")]
    met = [f"{end.first.one} - {end.first.other} from {end.begins:.2f} {unit}" for end in swept.ends if end.first]
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


def speed_line(world: World) -> str:
    """Return how fast it was: steps a second of computing, and how many times faster than the world."""
    steps = world.steps / world.cpu if world.cpu else 0.0
    return f"speed   {steps:,.0f} steps a CPU second, {steps * world.model.opt.timestep:,.1f} times real time"


def about(world: World) -> str:
    """Return what was simulated, and how."""
    stands = "on a floor" if world.base == FREE else "its base held"
    step = f"{1000 * world.model.opt.timestep:g} ms"
    return f"simulated in MuJoCo {world.mujoco.__version__}, {stands}, in steps of {step}"


def as_json(world: World, trials: Trials, limits: dict[str, float], timing: bool) -> dict[str, Any]:
    """Return what came of the trials as plain values: SI units, names as in the description."""
    made: dict[str, Any] = {
        "robot": world.robot.name,
        "mujoco": world.mujoco.__version__,
        "base": world.base,
        "timestep": float(world.model.opt.timestep),
        "limits": {name: {"value": limits[name], "unit": one.unit} for name, one in LIMITS.items()},
        "poses": [_held_json(held) for held in trials.poses],
        "drive": [_driven_json(driven) for driven in trials.drives],
        "own_servos": list(world.own),
        "ranges": [_swept_json(swept) for swept in trials.sweeps],
    }
    if trials.swung is not None:
        swung = trials.swung
        made["energy"] = {"change": swung.change, "kinetic": swung.kinetic, "broken": _stop(swung.broken)}
    if timing:
        steps = world.steps / world.cpu if world.cpu else 0.0
        made["timing"] = {
            "steps_per_cpu_second": steps,
            "times_real_time": steps * float(world.model.opt.timestep),
        }
    return made


def _stop(stop: Any) -> dict[str, Any] | None:
    return None if stop is None else {"why": stop.why, "time": stop.time}


def _pairs(touches: Sequence[Touch]) -> list[dict[str, Any]]:
    return [{"links": [one.one, one.other], "depth": one.depth} for one in touches]


def _held_json(held: PoseTrial) -> dict[str, Any]:
    return {
        "pose": held.pose,
        "errors": held.errors,
        "swings": held.swings,
        "drift": held.drift,
        "turned": held.turned,
        "leans": held.leans,
        "ripple": held.ripple,
        "touches": _pairs(held.touches),
        "stands_on": held.stands_on,
        "broken": _stop(held.broken),
    }


def _driven_json(driven: Driven) -> dict[str, Any]:
    return {
        "command": driven.command,
        "asked": driven.asked._asdict(),
        "measured": driven.measured._asdict(),
        "off": driven.off if driven.broken is None else None,
        "cross": driven.cross if driven.broken is None else None,
        "ripple": driven.ripple,
        "scale": driven.scale,
        "broken": _stop(driven.broken),
    }


def _swept_json(swept: Swept) -> dict[str, Any]:
    return {
        "joint": swept.joint,
        "ends": [
            {
                "asked": end.asked,
                "error": end.error,
                "touches": _pairs(end.touches),
                "first_touch": {"position": end.begins, **_pairs([end.first])[0]} if end.first else None,
            }
            for end in swept.ends
        ],
        "broken": _stop(swept.broken),
    }


def summary(trials: Trials) -> str:
    """Return what was tried, counted."""
    parts: Iterator[str] = (
        counted(count, word)
        for count, word in (
            (len(trials.poses), "pose"),
            (len(trials.drives), "drive command"),
            (len(trials.sweeps), "range"),
        )
        if count
    )
    return ", ".join(parts)


def page(world: World, trials: Trials, found: Sequence[Diagnostic]) -> str:
    """Return the page."""
    values = {
        "name": world.robot.name,
        "about": about(world),
        "findings": [{"severity": one.severity, "rule": one.rule, "message": one.message} for one in found],
        "tables": _titled(tables(world, trials)),
        "groups": list(_groups(trials)),
    }
    return Templates().own("mujoco/simulation.html.jinja", values)


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
