"""rosorin-compile pulses: convert servo pulses to joint positions and back."""

import math
from collections.abc import Sequence

from rosorin_compile.joint_values import JointPulse, pulses
from rosorin_compile.model import Robot
from rosorin_compile.source.diagnostics import RequestError
from rosorin_compile.source.numbers import exact, to_fixed

from .command import Options, command, flag, option, pair, robot_options, strict_option, words_argument
from .console import PROBLEMS, table
from .run import Run

_HEADS = ("joint", "pulse", "position", "degrees", "asked for", "off by")
_SERVO_HEADS = ("joint", "servos", "pulses", "positions", "degrees", "limits", "pulses within limits")


@command("pulses", exits="0 printed, 1 errors, no such pulse or, with --strict, a position beyond a limit")
@words_argument(
    "[ROBOT] [JOINT=VALUE ...]",
    "pulse as an integer, or position with a unit (30deg); default: print the calibration",
    offers=("robot", "joint="),
)
@flag("--radians", help="read numbers without a unit as radians or metres")
@flag("--degrees", help="read numbers without a unit as degrees or metres", excludes="radians")
@option("--pose POSE", default="", help="convert all joints of a named pose", offers="pose")
@strict_option
@robot_options
def run(options: Options) -> int:
    """Print pulses and the positions that they set."""
    from rosorin_compile.model.servos import NoPulse

    run = Run.from_options(options)
    console = run.console
    names = [word for word in run.words if "=" not in word]
    if len(names) > 1:
        raise RequestError(f'one robot at a time, and JOINT=VALUE: "{names[1]}" is neither')
    try:
        description = run.find_robot("".join(names), "ROBOT ...")
    except RequestError as problem:
        if not names or not names[0].lstrip("+-.")[:1].isdecimal():
            raise
        raise RequestError(f"{problem}; if it is a pulse or a position, write JOINT={names[0]}") from None
    values = dict(pair(word, "JOINT=VALUE") for word in run.words if "=" in word)
    unit = "deg" if options.degrees else "rad" if options.radians else ""
    try:
        found = pulses(run.request(description), values, **options.pick("pose strict"), unit=unit)
    except NoPulse as problem:
        console.warn(f"rosorin-compile: {problem}")
        return PROBLEMS
    if found.without_servo:
        without = ", ".join(found.without_servo)
        console.warn(f'without a servo, and not shown, of the pose "{options.pose}": {without}')
    failed, robot = run.show(found), found.robot
    if robot is None:
        return run.no_robot(description)
    if failed:
        return PROBLEMS
    return run.give(found, lambda: "\n".join(_pulses(found.joints) if found.joints else _calibration(robot)))


def _pulses(joints: Sequence[JointPulse]) -> list[str]:
    columns = len(_HEADS) if any(joint.asked is not None for joint in joints) else 4
    rows: list[Sequence[str]] = [_HEADS[:columns]]
    for joint in joints:
        degrees = "" if joint.degrees is None else to_fixed(joint.degrees, 6)
        cells = [joint.joint, str(joint.pulse), f"{exact(joint.position)} {joint.unit}", degrees, "", ""]
        if joint.asked is not None and joint.off is not None:
            off = f"{joint.off:+.3g}" if joint.off else "0"
            cells[4:] = f"{exact(joint.asked)} {joint.unit}", f"{off} {joint.unit}"
        rows.append(cells[:columns])
    return table(rows)


def _calibration(robot: Robot) -> list[str]:
    """Return the servo groups: the formula of each, and the valid pulses of each joint."""
    from rosorin_compile.model.servos import pulses_within, travel

    lines, rows = [], [_SERVO_HEADS]
    for group in robot.servos:
        difference = f"{group.zero_pulse} - pulse" if group.flipped else f"pulse - {group.zero_pulse}"
        lines.append(f"{group.name}: position = ({difference}) * {exact(group.rad_per_pulse)}")
        first, last = group.pulse_range
        for name in group.joints:
            joint, ends = robot.joint[name], travel(group)
            limit = joint.limit if joint.moves and joint.type != "continuous" else None
            inside, bounds, slides = pulses_within(group, limit), "none", joint.type == "prismatic"
            if limit is not None:
                lower, upper = ("?" if value is None else f"{value:.6g}" for value in (limit.lower, limit.upper))
                bounds = f"{lower} to {upper} {joint.unit}"
            degrees = " to ".join("" if slides else to_fixed(math.degrees(end), 6) for end in ends)
            positions = f"{ends[0]:.6g} to {ends[1]:.6g} {joint.unit}"
            pulses = "none" if inside is None else f"{inside[0]} to {inside[1]}"
            rows.append((name, group.name, f"{first} to {last}", positions, degrees, bounds, pulses))
    return [*lines, *table(rows)]
