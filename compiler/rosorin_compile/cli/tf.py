"""rosorin-compile tf: say where one frame sits in another, as tf2_echo does."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING, Any

import click

from rosorin_compile.source.project import Description

from .answer import give_result
from .command import Options, command, option
from .options import POSITIONS, mode_option, position_options, robot_options, words_argument
from .robots import one
from .run import Run, assignments, mode_states
from .usage import FINE, PROBLEMS, WrongUsage

if TYPE_CHECKING:
    from rosorin_compile.results import FrameTransform, Transforms


DIGITS = 3  # std::cout.precision(3), std::ios::fixed
_WIDTH = 6  # std::setw(6)
_ORDERS = {"humble": "", "jazzy": " (xyzw)"}  # of the quaternion, as tf2_echo prints it
_COLUMNS = ("x", "y", "z", "roll", "pitch", "yaw")
_HOW = "rosorin-compile tf ROBOT SOURCE TARGET"
_MOST_DIGITS = 17


@command("tf", exits="0 printed, 1 errors, no transform or, with --strict, a position beyond a limit")
@words_argument(
    "[ROBOT] SOURCE TARGET",
    "the robot, required if there are several, and the frames: prints the pose of TARGET in SOURCE",
    offers=("robot", "frame"),
)
@position_options(sweep=True)
@option("--strict", is_flag=True, help="treat positions beyond a limit as errors", section=POSITIONS)
@mode_option("off; without --mode all are on")
@option(
    "--table",
    is_flag=True,
    help="print one line per state: x y z in m, roll pitch yaw in degrees",
    excludes=("format", "csv"),
)
@option("--csv", is_flag=True, help="print one line per state: all digits, in m and rad", excludes=("format",))
@option(
    "--distro",
    type=click.Choice(("humble", "jazzy")),
    default="humble",
    help="ROS distribution whose tf2_echo format is used; default: humble",
)
@option("--digits", type=int, metavar="N", help="decimals; default: 3")
@robot_options
def run(options: Options) -> int:
    """Print the pose of a frame in another."""
    from rosorin_compile import api
    from rosorin_compile.model.servos import NoPulse
    from rosorin_compile.rules.transform import NotPublished

    run = Run.of(options)
    words, console = run.words, run.console
    value = next((word for word in words if "=" in word), None)
    if value is not None:
        raise WrongUsage(f"write --joint {value} for a position, --pulse {value} for a pulse")
    if not 2 <= len(words) <= 3:
        raise WrongUsage(f"two frames are needed, and at most one robot: {_HOW}")
    if options.digits is not None and not 0 <= options.digits <= _MOST_DIGITS:
        raise WrongUsage(f"--digits takes 0 to {_MOST_DIGITS}")
    *robot, source, target = words
    description = _robot("".join(robot))
    request = run.request(description)
    try:
        found = api.transform(
            request,
            source,
            target,
            pose=options.pose,
            joints=assignments(options.joints, "JOINT=POSITION"),
            pulses=assignments(options.pulses, "JOINT=PULSE"),
            sweeps=assignments(options.sweeps, "JOINT=FROM:TO:COUNT"),
            modes=mode_states(options.modes),
            strict=options.strict,
        )
    except (NoPulse, NotPublished) as problem:
        console.warn(f"rosorin-compile: {problem}")
        return PROBLEMS
    console.show(found.diagnostics)
    if found.robot is None:
        run.no_robot(description)
    if not found.transforms:
        return PROBLEMS
    result = found.transforms if found.swept else found.transforms[0]
    give_result(options, result, lambda: _text(found, options))
    return FINE


def _robot(name: str) -> Description:
    """Return the requested robot. Raises WrongUsage with the usage of the command."""
    try:
        return one(name, _HOW)
    except WrongUsage as problem:
        raise WrongUsage(f"{problem}; {_HOW}" if name else str(problem)) from None


def _text(found: Transforms, options: Options) -> str:
    """Return the transforms in the requested form."""
    digits = DIGITS if options.digits is None else options.digits
    if options.csv:
        return _csv(found)
    if options.table:
        return _table(found, digits)
    blocks = []
    for one_of in found.transforms:
        head = [f"# {', '.join(f'{joint} = {one_of.positions[joint]:.6g}' for joint in found.swept)}"]
        blocks.append("\n".join([*(head if found.swept else []), *_echo(one_of, digits, options.distro)]))
    return "\n".join(blocks)


def _echo(found: FrameTransform, digits: int, distro: str) -> list[str]:
    """Return what tf2_echo prints (ROS 2 Humble, ``tf2_ros/src/tf2_echo.cpp``); the time is that of static transforms.

    Newer distributions print the order of the quaternion.
    """
    return [
        "At time 0.0",
        f"- Translation: {_vector(found.translation, digits)}",
        f"- Rotation: in Quaternion{_ORDERS[distro]} {_vector(found.quaternion, digits)}",
        f"- Rotation: in RPY (radian) {_vector(found.rpy, digits)}",
        f"- Rotation: in RPY (degree) {_vector(found.rpy_degrees, digits)}",
        "- Matrix:",
        *("".join(f" {value:{_WIDTH + digits - DIGITS}.{digits}f}" for value in row) for row in found.matrix),
    ]


def _vector(values: Iterable[float], digits: int) -> str:
    return f"[{', '.join(f'{value:.{digits}f}' for value in values)}]"


def _table(found: Transforms, digits: int) -> str:
    """Return one line a state: the joints that are varied, with their units, then x y z (m), roll pitch yaw (deg)."""
    units = {**found.swept, **dict.fromkeys(_COLUMNS[:3], "m"), **dict.fromkeys(_COLUMNS[3:], "deg")}
    rows = [[f"{name} ({unit})" for name, unit in units.items()]]
    for one_of in found.transforms:
        numbers = (*(one_of.positions[joint] for joint in found.swept), *one_of.translation, *one_of.rpy_degrees)
        rows.append([f"{number:.{digits}f}" for number in numbers])
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    return "\n".join("  ".join(cell.rjust(width) for cell, width in zip(row, widths, strict=True)) for row in rows)


def _csv(found: Transforms) -> str:
    """Return one line a state for a spreadsheet: numbers in full, x y z in metres, angles in radians."""
    heads = [*found.swept, *_COLUMNS, "qx", "qy", "qz", "qw"]
    lines = [",".join(f'"{head}"' if "," in head or '"' in head else head for head in heads)]
    for one_of in found.transforms:
        positions: list[Any] = [one_of.positions[joint] for joint in found.swept]
        numbers = (*positions, *one_of.translation, *one_of.rpy, *one_of.quaternion)
        lines.append(",".join(repr(float(number)) for number in numbers))
    return "\n".join(lines)
