"""Telling: what came of the trials as tables for people, and as JSON for programs."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

from ...diagnostics.wording import counted
from .judging import LIMITS
from .trials import Driven, Held, Swept, Trials
from .world import FREE, Touch, World

_FEW = 2


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


def _pose(world: World, held: Held, free: bool) -> tuple[str, ...]:
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


def text(rows: Sequence[tuple[str, ...] | str]) -> str:
    """Return tables as lines: columns of one width in each table."""
    lines: list[str] = []
    tables: list[tuple[str, list[tuple[str, ...]]]] = []
    for row in rows:
        if isinstance(row, str):
            tables.append((row, []))
        else:
            tables[-1][1].append(row)
    for _title, table in tables:
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


def _held_json(held: Held) -> dict[str, Any]:
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
