"""rosorin-compile tf and pulses: poses of frames in the format of tf2_echo, and pulses of servos as positions."""

import csv
import io
import math
from collections.abc import Sequence

from rosorin_compile.joint_values import JointPulse, pulses
from rosorin_compile.model import Robot
from rosorin_compile.model.servos import pulses_within, travel
from rosorin_compile.source.diagnostics import RequestError
from rosorin_compile.source.numbers import exact, to_fixed
from rosorin_compile.transforms import FrameTransform, NotPublished, Transforms, transform

from . import command as cli
from .console import PROBLEMS, table
from .run import Run, pair

_ORDERS = {"humble": "", "jazzy": " (xyzw)"}  # of the quaternion, as tf2_echo prints it
_CSV = ("x", "y", "z", "roll", "pitch", "yaw", "qx", "qy", "qz", "qw")
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
@cli.flag("--csv", help="print one line per set of joint positions: all digits, in m and rad", excludes="format")
@cli.option("--distro humble|jazzy", default="humble", help="ROS distribution whose tf2_echo format is used")
@cli.option("--digits N", default=3, help="decimals")  # std::cout.precision(3) in tf2_echo
@cli.robot_options
def run_tf(run: Run) -> int:
    """Print the pose of a frame in another."""
    picked = run.pick("pose joints pulses sweeps modes strict")
    if not 0 <= run.digits <= _MAX_DIGITS:
        raise RequestError(f"--digits takes 0 to {_MAX_DIGITS}")
    description, (source, target) = run.robot_before(2, "ROBOT SOURCE TARGET")
    try:
        found = transform(run.request(description), source, target, **picked)
    except NotPublished as problem:
        return run.console.fail(str(problem), PROBLEMS)
    run.console.show(found.diagnostics)
    if found.robot is None:
        return run.no_robot(description)
    if not found.transforms:
        return PROBLEMS
    return run.give(found.transforms if found.swept else found.transforms[0], lambda: _text(found, run))


def _text(found: Transforms, run: Run) -> str:
    """Return blocks as of tf2_echo, or CSV with the positions of the joints that are varied, then the pose."""
    if run.csv:
        text = io.StringIO()
        writer = csv.writer(text, lineterminator="\n")
        writer.writerow([*found.swept, *_CSV])
        for one in found.transforms:
            numbers = [one.positions[joint] for joint in found.swept]
            writer.writerow(map(float, [*numbers, *one.translation, *one.rpy, *one.quaternion]))  # type: ignore[arg-type]
        return text.getvalue().removesuffix("\n")
    blocks = []
    for state in found.transforms:
        if found.swept:
            blocks.append(f"# {', '.join(f'{joint} = {state.positions[joint]:.6g}' for joint in found.swept)}")
        blocks += _echo(state, run.digits, run.distro)
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


@cli.command("pulses", exits="0 printed, 1 errors, no such pulse or, with --strict, a position beyond a limit")
@cli.words_argument(
    "[ROBOT] [JOINT=VALUE ...]",
    "pulse as an integer, or position with a unit (30deg); default: print the calibration",
    offers=("robot", "joint="),
)
@cli.flag("--radians", help="read numbers without a unit as radians or metres")
@cli.flag("--degrees", help="read numbers without a unit as degrees or metres", excludes="radians")
@cli.option("--pose POSE", default="", help="convert all joints of a named pose", offers="pose")
@cli.strict_option
@cli.robot_options
def run_pulses(run: Run) -> int:
    """Print pulses and the positions that they set."""
    names = [word for word in run.words if "=" not in word]
    if len(names) > 1:
        raise RequestError(f'one robot at a time, and JOINT=VALUE: "{names[1]}" is neither')
    description = run.find_robot("".join(names), "ROBOT ...")
    values = dict(pair(word, "JOINT=VALUE") for word in run.words if "=" in word)
    unit = "deg" if run.degrees else "rad" if run.radians else ""
    found = pulses(run.request(description), values, **run.pick("pose strict"), unit=unit)
    if found.without_servo:
        without = ", ".join(found.without_servo)
        run.console.warn(f'without a servo, and not shown, of the pose "{run.pose}": {without}')
    failed, robot = run.show(found), found.robot
    if robot is None:
        return run.no_robot(description)
    if failed:
        return PROBLEMS
    return run.give(found, lambda: "\n".join(_pulses(found.joints) if found.joints else _calibration(robot)))


def _pulses(joints: Sequence[JointPulse]) -> list[str]:
    rows: list[Sequence[str]] = [("joint", "pulse", "position", "degrees", "requested", "difference")]
    for joint in joints:
        degrees = "" if joint.degrees is None else to_fixed(joint.degrees, 6)
        requested = difference = ""
        if joint.requested is not None and joint.difference is not None:
            requested = f"{exact(joint.requested)} {joint.unit}"
            difference = f"{f'{joint.difference:+.3g}' if joint.difference else '0'} {joint.unit}"
        position = f"{exact(joint.position)} {joint.unit}"
        rows.append((joint.joint, str(joint.pulse), position, degrees, requested, difference))
    columns = 6 if any(row[4] for row in rows[1:]) else 4
    return table([row[:columns] for row in rows])


def _calibration(robot: Robot) -> list[str]:
    """Return the servo groups: the formula of each, and the valid pulses of each joint."""
    lines = []
    rows = [("joint", "servos", "pulses", "positions", "degrees", "limits", "pulses within limits")]
    for group in robot.servos:
        difference = f"{group.zero_pulse} - pulse" if group.flipped else f"pulse - {group.zero_pulse}"
        lines.append(f"{group.name}: position = ({difference}) * {exact(group.rad_per_pulse)}")
        first, last = group.pulse_range
        for name in group.joints:
            joint, ends, bounds = robot.joint[name], travel(group), "none"
            limit = joint.limit if joint.moves and joint.type != "continuous" else None
            if limit is not None:
                lower, upper = ("?" if value is None else f"{value:.6g}" for value in (limit.lower, limit.upper))
                bounds = f"{lower} to {upper} {joint.unit}"
            degrees = "" if joint.type == "prismatic" else " to ".join(to_fixed(math.degrees(end), 6) for end in ends)
            positions = f"{ends[0]:.6g} to {ends[1]:.6g} {joint.unit}"
            inside = pulses_within(group, limit)
            within = "none" if inside is None else f"{inside[0]} to {inside[1]}"
            rows.append((name, group.name, f"{first} to {last}", positions, degrees, bounds, within))
    return [*lines, *table(rows)]
