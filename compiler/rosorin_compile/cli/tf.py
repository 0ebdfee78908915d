"""rosorin-compile tf: print the pose of one frame in another, in the format of tf2_echo."""

import csv
import io
from typing import Any

from rosorin_compile.source.diagnostics import RequestError
from rosorin_compile.transforms import FrameTransform, NotPublished, Transforms, transform

from . import command as cli
from .console import PROBLEMS, table
from .run import Run, refuse_positions

_ORDERS = {"humble": "", "jazzy": " (xyzw)"}  # of the quaternion, as tf2_echo prints it
_COLUMNS = ("x", "y", "z", "roll", "pitch", "yaw")
_MAX_DIGITS = 17
_SWEEP = "use COUNT positions in turn; repeatable: all combinations"


@cli.command("tf", exits="0 printed, 1 errors, no transform or, with --strict, a position beyond a limit")
@cli.words_argument(
    "[ROBOT] SOURCE TARGET",
    "the robot, required if there are several, and the frames: prints the pose of TARGET in SOURCE",
    offers=("robot", "frame"),
)
@cli.position_options(
    cli.repeatable("--sweep JOINT=FROM:TO:COUNT", "sweeps", help=_SWEEP, offers="joint="),
    cli.strict_option,
    overrides="--pose and --pulse",
)
@cli.mode_option("off; without --mode all are on")
@cli.flag("--table", help="print one line per state: x y z in m, roll pitch yaw in degrees", excludes="format csv")
@cli.flag("--csv", help="print one line per state: all digits, in m and rad", excludes="format")
@cli.option("--distro humble|jazzy", default="humble", help="ROS distribution whose tf2_echo format is used")
@cli.option("--digits N", default=3, help="decimals")  # std::cout.precision(3) in tf2_echo
@cli.robot_options
def run(options: cli.Options) -> int:
    """Print the pose of a frame in another."""
    from rosorin_compile.model.servos import NoPulse

    refuse_positions(options.words)
    run, picked = Run.from_options(options), options.pick("pose joints pulses sweeps modes strict")
    if not 0 <= options.digits <= _MAX_DIGITS:
        raise RequestError(f"--digits takes 0 to {_MAX_DIGITS}")
    description, (source, target) = run.robot_before(2, "ROBOT SOURCE TARGET")
    try:
        found = transform(run.request(description), source, target, **picked)
    except (NoPulse, NotPublished) as problem:
        run.console.warn(f"rosorin-compile: {problem}")
        return PROBLEMS
    run.console.show(found.diagnostics)
    if found.robot is None:
        return run.no_robot(description)
    if not found.transforms:
        return PROBLEMS
    return run.give(found.transforms if found.swept else found.transforms[0], lambda: _text(found, options))


def _text(found: Transforms, options: cli.Options) -> str:
    if options.table or options.csv:
        return _rows(found, None if options.csv else options.digits)
    blocks = []
    for state in found.transforms:
        if found.swept:
            positions = (f"{joint} = {state.positions[joint]:.6g}" for joint in found.swept)
            blocks.append(f"# {', '.join(positions)}")
        blocks += _echo(state, options.digits, options.distro)
    return "\n".join(blocks)


def _echo(found: FrameTransform, digits: int, distro: str) -> list[str]:
    """Return what tf2_echo prints (ROS 2 Humble, ``tf2_ros/src/tf2_echo.cpp``); the time is that of static transforms.

    Newer distributions print the order of the quaternion.
    """
    forms = {
        "Translation:": found.translation,
        f"Rotation: in Quaternion{_ORDERS[distro]}": found.quaternion,
        "Rotation: in RPY (radian)": found.rpy,
        "Rotation: in RPY (degree)": found.rpy_degrees,
    }
    lines = [f"- {form} [{', '.join(f'{one:.{digits}f}' for one in numbers)}]" for form, numbers in forms.items()]
    matrix = ("".join(f" {value:{3 + digits}.{digits}f}" for value in row) for row in found.matrix)  # std::setw(6)
    return ["At time 0.0", *lines, "- Matrix:", *matrix]


def _rows(found: Transforms, digits: int | None) -> str:
    """Return one line per state: the positions of the joints that are varied, then the pose.

    With ``digits`` as an aligned table, angles of the pose in degrees; else as CSV with numbers in full and radians.
    """
    units = {**found.swept, **dict.fromkeys(_COLUMNS[:3], "m"), **dict.fromkeys(_COLUMNS[3:], "deg")}
    rows: list[list[Any]] = [[f"{name} ({unit})" for name, unit in units.items()]]
    if digits is None:
        rows = [[*found.swept, *_COLUMNS, "qx", "qy", "qz", "qw"]]
    for one in found.transforms:
        angles = (*one.rpy, *one.quaternion) if digits is None else one.rpy_degrees
        numbers = (*(one.positions[joint] for joint in found.swept), *one.translation, *angles)
        rows.append([float(number) if digits is None else f"{number:.{digits}f}" for number in numbers])
    if digits is not None:
        return "\n".join(table(rows, str.rjust))
    text = io.StringIO()
    csv.writer(text, lineterminator="\n").writerows(rows)
    return text.getvalue().removesuffix("\n")
