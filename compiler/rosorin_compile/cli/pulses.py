"""rosorin-compile pulses: turn servo pulses into joint angles and back."""

from __future__ import annotations

import argparse
import math
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from rosorin_compile.source import files
from rosorin_compile.source.project import Description

from .answer import give_result
from .robots import one
from .run import Run
from .understanding import RobotCase, understood
from .usage import FINE, PROBLEMS, WrongUsage

if TYPE_CHECKING:
    from rosorin_compile.model import Joint, Robot
    from rosorin_compile.model.servos import ServoGroup
    from rosorin_compile.source.console import Console

    from .parser import Parser

_HOW = "rosorin-compile pulses ROBOT ..."
_HEADS = ("joint", "pulse", "position", "degrees", "asked for", "off by")
_SERVO_HEADS = ("joint", "servos", "pulses", "positions", "degrees", "limits", "pulses within limits")


class Row(NamedTuple):
    """A joint: its pulse and the position that it gives; ``asked`` is the position that the pulse is nearest to."""

    joint: Joint
    group: ServoGroup
    pulse: int
    position: float
    asked: float | None = None


def options(command: Parser) -> None:
    """Add what this command takes."""
    command.add_argument(
        "words",
        nargs="*",
        metavar="[ROBOT] JOINT=VALUE",
        completes="[ROBOT] SERVO=VALUE ...",
        help="pulse as an integer, or position with a unit (30deg); default: print the calibration",
    )
    plain = command.add_mutually_exclusive_group()
    plain.add_argument("--radians", action="store_true", help="read numbers without a unit as radians or metres")
    plain.add_argument("--degrees", action="store_true", help="read numbers without a unit as degrees or metres")
    command.add_argument("--pose", default="", metavar="POSE", help="convert all joints of a named pose")
    command.add_argument("--strict", action="store_true", help="treat positions beyond a limit as errors")
    command.add_argument(
        "--model", metavar="FILE", help="check that a robot_model.json gives the same positions for every pulse"
    )
    command.add_result()
    command.add_given()


def run(options: argparse.Namespace) -> int:
    """Print pulses and the positions that they give."""
    run = Run.of(options)
    words, console = run.words, run.console
    values = [word for word in words if "=" in word]
    names = [word for word in words if "=" not in word]
    if len(names) > 1:
        raise WrongUsage(f'one robot at a time, and JOINT=VALUE: "{names[1]}" is neither; {_HOW}')
    known = understood(run.given, _named("".join(names)), console)
    if known is None:
        return PROBLEMS
    if not _servos(known.robot):
        raise WrongUsage(f'the robot "{known.robot.name}" has no servos')
    if options.model is not None:
        return _same_model(known.robot, options, console)
    from rosorin_compile.language.sections.servos.pulses import NoPulse, NoServo

    from .joint_states import NoState

    try:
        rows = _rows(known.robot, options, values)
    except (NoState, NoServo) as problem:
        raise WrongUsage(str(problem.args[0])) from None
    except NoPulse as problem:
        console.warn(f"rosorin-compile: {problem}")
        return PROBLEMS
    return _show(known, rows, options, console)


def _named(name: str) -> Description:
    """Return the robot that is meant. Raises WrongUsage, which says how a number is written that has no joint."""
    try:
        return one(name, _HOW)
    except WrongUsage as problem:
        if not name.lstrip("+-.")[:1].isdecimal():
            raise
        raise WrongUsage(f"{problem}; if it is a pulse or a position, write JOINT={name}") from None


def _rows(robot: Robot, options: argparse.Namespace, values: list[str]) -> list[Row]:
    """Return what is asked for, a joint once, in the order of the words. Raises NoState, NoServo, NoPulse."""
    from .joint_states import NoState, pose_of, split

    made: dict[str, Row] = {}
    if options.pose:
        positions = pose_of(robot, options.pose)
        pulses = next(pose.pulses for pose in robot.poses if pose.name == options.pose)
        for name in (name for group in _servos(robot) for name in group.joints if name in positions):
            made[name] = _of_pulse(robot, name, pulses[name]) if name in pulses else _of(robot, name, positions[name])
        if not made:
            raise NoState(f'no joint of the pose "{options.pose}" has a servo')
    for word in values:
        name, text = split(word, "JOINT=VALUE")
        made[name] = _of_text(robot, name, text, options)
    return list(made.values())


def _of_text(robot: Robot, name: str, text: str, options: argparse.Namespace) -> Row:
    from rosorin_compile.language.sections.servos.pulses import servo_of

    from .joint_states import position, whole

    servo_of(robot, name)
    joint = robot.joint[name]
    if not _is_number(text):
        return _of(robot, name, position(joint, text))
    if options.degrees and joint.type != "prismatic":
        return _of(robot, name, position(joint, f"{text} deg"))
    if options.radians or options.degrees:
        return _of(robot, name, position(joint, text))
    return _of_pulse(robot, name, whole(text))


def _is_number(text: str) -> bool:
    try:
        float(text)
    except ValueError:
        return False
    return True


def _of_pulse(robot: Robot, name: str, pulse: int) -> Row:
    from rosorin_compile.language.sections.servos.pulses import position_of, servo_of

    group = servo_of(robot, name)
    return Row(robot.joint[name], group, pulse, position_of(group, pulse, name))


def _of(robot: Robot, name: str, asked: float) -> Row:
    from rosorin_compile.language.sections.servos.pulses import nearest, servo_of

    group = servo_of(robot, name)
    found = nearest(group, asked, name)
    return Row(robot.joint[name], group, found.pulse, found.position, asked)


def _show(known: RobotCase, rows: list[Row], options: argparse.Namespace, console: Console) -> int:
    """Print the rows, or the calibration where nothing is asked; say what is beyond a limit."""
    from rosorin_compile.source.diagnostics import ERROR, WARNING

    from .joint_states import beyond, beyond_limit

    state = {row.joint.name: row.position for row in rows}
    found = list(beyond(known.robot, state))
    if options.pose:
        served = {name for group in _servos(known.robot) for name in group.joints}
        pose = next(pose for pose in known.robot.poses if pose.name == options.pose)
        without = [name for name in pose.positions if name not in served]
        if without:
            console.warn(f'without a servo, and not shown, of the pose "{options.pose}": {", ".join(without)}')
    console.show([beyond_limit(known, one_beyond, ERROR if options.strict else WARNING) for one_beyond in found])
    if found and options.strict:
        return PROBLEMS
    servos = [_servo_object(group) for group in _servos(known.robot)]
    made = {"servos": servos, "joints": [_object(row) for row in rows]}
    heads = _HEADS if any(row.asked is not None for row in rows) else _HEADS[:4]
    give_result(
        options,
        made,
        lambda: "\n".join(_table(heads, map(_cells, rows)) if rows else _calibration(known.robot)),
    )
    return FINE


def _cells(row: Row) -> tuple[str, ...]:
    from rosorin_compile.source.numbers import exact

    unit = _unit(row.joint)
    cells = (row.joint.name, str(row.pulse), f"{exact(row.position)} {unit}", _degrees(row.joint, row.position))
    if row.asked is None:
        return (*cells, "", "")
    off = row.position - row.asked
    return (*cells, f"{exact(row.asked)} {unit}", f"{off:+.3g} {unit}" if off else f"0 {unit}")


def _servos(robot: Robot) -> tuple[ServoGroup, ...]:
    from rosorin_compile.language.sections.servos import SERVOS

    return robot.sections[SERVOS]


def _calibration(robot: Robot) -> list[str]:
    """Return the servo groups: the formula of each, and what every joint can be sent."""
    from rosorin_compile.language.sections.servos.pulses import travel, within
    from rosorin_compile.source.numbers import exact

    lines, rows = [], []
    for group in _servos(robot):
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
    from rosorin_compile.source.numbers import fixed

    return "" if joint.type == "prismatic" else fixed(math.degrees(position), 6)


def _table(heads: tuple[str, ...], rows: Any) -> list[str]:
    cells = [heads, *(row[: len(heads)] for row in rows)]
    widths = [max(map(len, column)) for column in zip(*cells, strict=True)]
    return ["  ".join(cell.ljust(width) for cell, width in zip(row, widths, strict=True)).rstrip() for row in cells]


def _object(row: Row) -> dict[str, Any]:
    from rosorin_compile.language.sections.servos.pulses import within

    slides = row.joint.type == "prismatic"
    return {
        "joint": row.joint.name,
        "servos": row.group.name,
        "pulse": row.pulse,
        "position": row.position,
        "unit": _unit(row.joint),
        "degrees": None if slides else math.degrees(row.position),
        "asked": row.asked,
        "off": None if row.asked is None else row.position - row.asked,
        "pulses_within_limits": within(row.group, row.joint.limit),
    }


def _servo_object(group: ServoGroup) -> dict[str, Any]:
    return {
        "name": group.name,
        "joints": list(group.joints),
        "rad_per_pulse": group.rad_per_pulse,
        "zero": group.zero_pulse,
        "flipped": group.flipped,
        "pulse_range": list(group.pulse_range),
    }


def _same_model(robot: Robot, options: argparse.Namespace, console: Console) -> int:
    """Say whether the driver's model gives the positions that the description gives, pulse by pulse."""
    from rosorin_compile.language.sections.servos.pulses import NoModel, against_model

    name = options.model
    path = Path(name)
    if not files.is_file(path):
        raise WrongUsage.no_file(path)
    try:
        compared = against_model(robot, files.read_bytes(path))
    except NoModel as problem:
        console.warn(f"{name}: {problem}")
        return PROBLEMS
    servos = [_servo_object(group) for group in _servos(robot)]
    made = {"servos": servos, "joints": [], "model": {"file": name, "differences": list(compared.differences)}}
    for line in compared.differences:
        console.warn(f"{name}: {line}")
    same = f"{name}: {compared.pulses:,} pulses of {compared.joints} joints give the very positions described"
    give_result(options, made, lambda: "" if compared.differences or options.quiet else same)
    return PROBLEMS if compared.differences else FINE
