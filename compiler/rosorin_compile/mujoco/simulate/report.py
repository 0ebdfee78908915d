"""Render the result of a simulation as tables of text."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from rosorin_compile.source.wording import counted, listed

from .world import FREE

if TYPE_CHECKING:
    from .simulation import Simulated


def text(result: Simulated) -> str:
    """Return the results of the scenarios as tables with aligned columns."""

    def row(name: str, trial: Any, *cells: str) -> tuple[str, ...]:
        return (name, f"broke {trial.broken.partition(':')[0]}") if trial.broken else (name, *cells)

    is_free = result.base == FREE
    poses = [("pose", "largest error", "joint", "touches", *(("drift", "stands on") if is_free else ()))]
    for held in result.poses:
        error = (f"{held.worst[1]:.4f} {result.units[held.worst[0]]}", held.worst[0]) if held.worst else ("-", "-")
        touches = listed([" - ".join(pair) for pair in held.touches], 2) or "-"
        floor = (f"{1000 * held.drift:.1f} mm", listed(held.stands_on, 2) or "-") if is_free else ()
        poses.append(row(held.pose, held, *error, touches, *floor))
    drive = [("command", "commanded", "measured", "off", "cross", "ripple")]
    for driven in result.drive:
        parts = zip(driven.commanded, driven.measured, ("m/s", "m/s", "rad/s"), strict=True)
        texts = [(f"{part:.3f} {unit}", f"{value:.3f} {unit}") for part, value, unit in parts if part]
        errors = (f"{driven.off:.1%}", f"{driven.cross:.3f}", f"{1000 * driven.ripple:.2f} mm")
        drive.append(row(driven.command, driven, *map(", ".join, zip(*texts, strict=True)), *errors))
    ranges = [("joint", "lower", "error", "upper", "error", "touches")]
    for swept in result.ranges:
        unit = result.units[swept.joint]
        ends = [text for end in swept.ends for text in (f"{end.target:.3f}", f"{end.error:.4f}")]
        touched = [end for end in swept.ends if end.first_touch]
        where = [f"{' - '.join(end.first_touch or ())} from {end.touch_position:.2f} {unit}" for end in touched]
        ranges.append(row(f"{swept.joint} ({unit})", swept, *ends, ", ".join(where) or "-"))
    blocks = []
    for rows in (poses, drive, ranges):
        widths = [max(len(cells[i]) for cells in rows if i < len(cells)) for i in range(len(rows[0]))]
        lines = ("  ".join(cell.ljust(width) for cell, width in zip(cells, widths, strict=False)) for cells in rows)
        blocks += ["\n".join(line.rstrip() for line in lines)] if len(rows) > 1 else []
    if swung := result.energy:
        change = f"{swung.change:.1%}" if swung.change >= 0.0005 else "less than 0.1%"
        _, change = row("", swung, f"it changes by {change} in half a second")
        blocks.append(f"energy without damping, friction and actuators: {change}")
    return "\n\n".join(blocks)


def about(result: Simulated) -> str:
    """Return one line about the engine, the base and the time step."""
    base = "on a floor" if result.base == FREE else "its base held"
    return f"simulated in MuJoCo {result.mujoco}, {base}, in steps of {1000 * result.timestep:g} ms"


def summary(result: Simulated) -> str:
    """Return the number of scenarios of each kind."""
    counts = {"pose": len(result.poses), "drive command": len(result.drive), "range": len(result.ranges)}
    return ", ".join(counted(count, word) for word, count in counts.items() if count)
