"""rosorin-compile pulses: turn servo pulses into joint angles and back."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from rosorin_compile.source.numbers import exact, fixed
from rosorin_compile.source.project import Description

from .answer import give_result
from .command import Options, command, option
from .options import pose_option, robot_options, words_argument
from .robots import one
from .run import Run, assignments
from .usage import FINE, PROBLEMS, WrongUsage

if TYPE_CHECKING:
    from rosorin_compile.model import Joint, Robot
    from rosorin_compile.results import JointPulse, ModelComparison, Pulses
    from rosorin_compile.source.console import Console


_HOW = "rosorin-compile pulses ROBOT ..."
_HEADS = ("joint", "pulse", "position", "degrees", "asked for", "off by")
_SERVO_HEADS = ("joint", "servos", "pulses", "positions", "degrees", "limits", "pulses within limits")


@command("pulses", exits="0 printed, 1 errors, no such pulse or, with --strict, a position beyond a limit")
@words_argument(
    "[ROBOT] [JOINT=VALUE ...]",
    "pulse as an integer, or position with a unit (30deg); default: print the calibration",
    offers=("robot", "joint="),
)
@option("--radians", is_flag=True, help="read numbers without a unit as radians or metres")
@option("--degrees", is_flag=True, help="read numbers without a unit as degrees or metres", excludes=("radians",))
@pose_option("convert all joints of a named pose")
@option("--strict", is_flag=True, help="treat positions beyond a limit as errors")
@option("--model", metavar="FILE", help="check that a robot_model.json gives the same positions for every pulse")
@robot_options
def run(options: Options) -> int:
    """Print pulses and the positions that they set."""
    from rosorin_compile import api
    from rosorin_compile.model.servos import NoModel, NoPulse
    from rosorin_compile.source.diagnostics import has_errors

    run = Run.of(options)
    words, console = run.words, run.console
    values = [word for word in words if "=" in word]
    names = [word for word in words if "=" not in word]
    if len(names) > 1:
        raise WrongUsage(f'one robot at a time, and JOINT=VALUE: "{names[1]}" is neither; {_HOW}')
    description = _named("".join(names))
    unit = "deg" if options.degrees else "rad" if options.radians else ""
    try:
        found = api.pulses(
            run.request(description),
            assignments(values, "JOINT=VALUE"),
            pose=options.pose,
            unit=unit,
            model=options.model,
            strict=options.strict,
        )
    except (NoPulse, NoModel) as problem:
        console.warn(f"{options.model}: {problem}" if isinstance(problem, NoModel) else f"rosorin-compile: {problem}")
        return PROBLEMS
    if found.without_servo:
        without = ", ".join(found.without_servo)
        console.warn(f'without a servo, and not shown, of the pose "{options.pose}": {without}')
    console.show(found.diagnostics)
    robot = found.robot
    if robot is None:
        run.no_robot(description)
    if robot is None or has_errors(found.diagnostics):
        return PROBLEMS
    if found.model is not None:
        return _compared(found.model, found, options, console)
    give_result(options, found, lambda: "\n".join(_rows(found.joints) if found.joints else _calibration(robot)))
    return FINE


def _named(name: str) -> Description:
    """Return the requested robot. Raises WrongUsage, which explains how to write a number without a joint."""
    try:
        return one(name, _HOW)
    except WrongUsage as problem:
        if not name.lstrip("+-.")[:1].isdecimal():
            raise
        raise WrongUsage(f"{problem}; if it is a pulse or a position, write JOINT={name}") from None


def _rows(joints: Sequence[JointPulse]) -> list[str]:
    heads = _HEADS if any(row.asked is not None for row in joints) else _HEADS[:4]
    return _table(heads, map(_cells, joints))


def _cells(row: JointPulse) -> tuple[str, ...]:
    degrees = "" if row.degrees is None else fixed(row.degrees, 6)
    cells = (row.joint, str(row.pulse), f"{exact(row.position)} {row.unit}", degrees)
    if row.asked is None or row.off is None:
        return (*cells, "", "")
    off = f"{row.off:+.3g} {row.unit}" if row.off else f"0 {row.unit}"
    return (*cells, f"{exact(row.asked)} {row.unit}", off)


def _calibration(robot: Robot) -> list[str]:
    """Return the servo groups: the formula of each, and what every joint can be sent."""
    from rosorin_compile.model.servos import travel, within
    from rosorin_compile.rules.pulses import servos

    lines, rows = [], []
    for group in servos(robot):
        difference = f"{group.zero_pulse} - pulse" if group.flipped else f"pulse - {group.zero_pulse}"
        lines.append(f"{group.name}: position = ({difference}) * {exact(group.rad_per_pulse)}")
        first, last = group.pulse_range
        for name in group.joints:
            joint, ends = robot.joint[name], travel(group)
            limit = joint.limit if joint.moves and joint.type != "continuous" else None
            inside = within(group, limit)
            bounds = "none" if limit is None else f"{_bound(limit.lower)} to {_bound(limit.upper)} {_unit(joint)}"
            degrees = " to ".join(_degrees(joint, end) for end in ends)
            told = f"{ends[0]:.6g} to {ends[1]:.6g} {_unit(joint)}"
            few = "none" if inside is None else f"{inside[0]} to {inside[1]}"
            rows.append((name, group.name, f"{first} to {last}", told, degrees, bounds, few))
    return [*lines, *_table(_SERVO_HEADS, rows)]


def _bound(value: float | None) -> str:
    return "?" if value is None else f"{value:.6g}"


def _unit(joint: Joint) -> str:
    return "m" if joint.type == "prismatic" else "rad"


def _degrees(joint: Joint, position: float) -> str:
    return "" if joint.type == "prismatic" else fixed(math.degrees(position), 6)


def _table(heads: tuple[str, ...], rows: Any) -> list[str]:
    cells = [heads, *(row[: len(heads)] for row in rows)]
    widths = [max(map(len, column)) for column in zip(*cells, strict=True)]
    return ["  ".join(cell.ljust(width) for cell, width in zip(row, widths, strict=True)).rstrip() for row in cells]


def _compared(model: ModelComparison, found: Pulses, options: Options, console: Console) -> int:
    """Print the differences of a driver's model."""
    for line in model.differences:
        console.warn(f"{model.file}: {line}")
    same = f"{model.file}: {model.pulses:,} pulses of {model.joints} joints give the very positions described"
    give_result(options, found, lambda: "" if model.differences or options.quiet else same)
    return PROBLEMS if model.differences else FINE
