"""Render the result of a simulation as tables of text."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from rosorin_compile.source.diagnostics import counted, listed

from .world import FREE

if TYPE_CHECKING:
    from .simulation import Simulated

    Table = list[tuple[str, ...]]


def tables(result: Simulated) -> dict[str, Table]:
    """Return the results of the scenarios by title, as rows of cells; the first of several rows is the head."""
    floor = ("drift", "stands on") if result.base == FREE else ()
    poses: Table = [("pose", "largest error", "joint", "touches", *floor)]
    for held in result.poses:
        error = (f"{held.worst[1]:.4f} {result.units[held.worst[0]]}", held.worst[0]) if held.worst else ("-", "-")
        touches = listed([" - ".join(pair) for pair in held.touches], 2) or "-"
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
            f"{' - '.join(end.first_touch)} from {end.touch_position:.2f} {unit}" for end in touched if end.first_touch
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
    return (f"broke {result.broken.partition(':')[0]}",) if result.broken else cells


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
