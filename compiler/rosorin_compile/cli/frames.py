"""rosorin-compile frames, graph, explain, args, tf and pulses: frames and joints, and where they are defined."""

import csv
import io
import math
import os
import shutil
import sys
from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path

from rosorin_compile import api
from rosorin_compile.joint_values import JointPulse, pulses
from rosorin_compile.language.arguments import Argument
from rosorin_compile.model import Robot
from rosorin_compile.model.frame_tree import lines, publishers, rows, way
from rosorin_compile.model.servos import pulses_within, travel
from rosorin_compile.output.atomic_files import may_replace, write_file
from rosorin_compile.source.diagnostics import ERROR, RequestError, UnknownName, has_errors
from rosorin_compile.source.numbers import exact, to_fixed
from rosorin_compile.source.project import Description, NoDescription, all_here
from rosorin_compile.transforms import FrameTransform, NotPublished, Transforms, transform
from rosorin_compile.viewer.frames import BOLD, Frames, Look, frames, table, tree

from . import command as cli
from .console import FINE, PROBLEMS, paint
from .console import table as aligned
from .run import Run, find_robots, pair, take_stdin, warn_of_no_robots


@cli.command("frames", exits="0 shown or written, 1 the robot has errors")
@cli.robot_argument
@cli.option("--frame FRAME", help="show only the path to a frame", offers="frame", excludes="publisher output")
@cli.option("--publisher NODE", help='show only edges of a publisher; "nobody": those without one', excludes="output")
@cli.mode_option("one tree each for on and off")
@cli.option("-o", "--output FILE.svg", help="write a drawing: FILE.svg; FOLDER/: one file per tree")
@cli.force_option
@cli.flag("--ascii", help="draw the tree with ASCII characters")
@cli.robot_options
def run_frames(run: Run) -> int:
    """Show the tree of frames of one robot."""
    found = frames(run.request(run.only_robot()), **run.pick("frame publisher output force modes"))
    failed, robot = run.show(found), found.robot
    if failed or robot is None:
        return PROBLEMS
    if found.files:
        return run.give(found, lambda: "\n".join(f"{robot.name}: {path}" for path in found.files))
    return run.give(found, lambda: _text(robot, found, run), lambda text: paint(f"{text}\n", sys.stdout))


def _text(robot: Robot, found: Frames, run: Run) -> str:
    on_terminal, is_ascii = sys.stdout.isatty(), True
    with suppress(UnicodeEncodeError, LookupError):  # use ASCII if the stream cannot encode the lines of the tree
        is_ascii = run.ascii or not "└├│─╌".encode(sys.stdout.encoding or "utf-8")
    colours = publishers(rows(robot)) if on_terminal and not os.environ.get("NO_COLOR") else ()
    style = Look(is_ascii, colours, shutil.get_terminal_size().columns if on_terminal else 0)
    if run.publisher is not None:
        edges = dict.fromkeys(row for one in found.situations for row in one.rows if row.publisher == run.publisher)
        return "\n".join(table([*edges], style)) if edges else f"{run.publisher} publishes nothing here"
    labels: dict[str, list[str]] = {}  # {printed tree: combinations of modes with this tree}
    for situation in found.situations:
        shown = lines(situation.rows, robot.frames)
        shown = shown if run.frame is None else way(shown, run.frame)
        drawn = "\n".join(tree(shown, style)) if shown else f"{run.frame} is not there"
        labels.setdefault(drawn, []).append(situation.when)
    if len(labels) == 1 < len(found.situations):  # all modes have the same tree: print it without a heading
        return next(iter(labels))
    headed = ((style.paint(", or ".join(names), BOLD), drawn) for drawn, names in labels.items())
    return "\n\n".join(f"{head}\n{drawn}" if head else drawn for head, drawn in headed)


@cli.command("graph", exits="0 shown or written, 1 errors (a topic of a driver outside the package is a note)")
@cli.robot_argument
@cli.option("-o", "--output FILE.svg", help="write a drawing")
@cli.force_option
@cli.robot_options
def run_graph(run: Run) -> int:
    """Show the ROS nodes of a robot, the topics between them, and topics that no node publishes."""
    from rosorin_compile.ros.graph import graph

    found = graph(run.request(run.only_robot()))
    failed = run.show(found)
    if not found.robot:
        return PROBLEMS
    if run.output is not None:
        write_file(Path(run.output), found.svg().encode(), (), None if run.force else may_replace)
    run.give(found, found.text if run.output is None else lambda: f"{found.robot}: {run.output}")
    return PROBLEMS if failed else FINE


@cli.command("explain", exits="0 printed, 1 the description has errors")
@cli.words_argument(
    "[ROBOT] NAME ...",
    "the robot, and names of frames, links, joints, sensors, parts, arguments, named values or numbers (z, mass)",
    required=True,
    offers=("robot", "thing"),
)
@cli.option("--pose POSE", default="", help="also print the frames in a named pose", offers="pose")
@cli.robot_options
def run_explain(run: Run) -> int:
    """Explain the poses of frames of a robot; the first word can be the name of the robot."""
    take_stdin(run.words)
    description, names = None, run.words
    if len(names) > 1:
        try:
            description, names = Description.find(names[:1])[0], names[1:]
        except NoDescription:
            if not all_here():
                raise
    description = description or run.find_robot("", f"ROBOT {' '.join(names)}")
    try:
        found = api.explain(run.request(description), names, pose=run.pose)
    except UnknownName as problem:
        raise RequestError(f"{description.name}: {problem}") from None
    if has_errors(found.diagnostics):
        run.console.show([one for one in found.diagnostics if one.severity == ERROR])
        return PROBLEMS
    return run.give(found.answers, lambda: str(found))


@cli.command("args", exits="0 listed, 1 an invalid argument")
@cli.robots_argument()
def run_args(run: Run) -> int:
    """List the arguments of each robot with their values, and validate the values."""
    results = [api.arguments(run.request(description)) for description in find_robots(run, run.words)]
    for result in results:
        run.show(result)
    if not run.words:
        warn_of_no_robots(run.console)
    valid = [result for result in results if not result.diagnostics]
    run.give(valid, lambda: "\n".join(line for one in valid for line in _argument_table(one.robot, one.arguments)))
    return FINE if len(valid) == len(results) else PROBLEMS


def _argument_table(name: str, arguments: Sequence[Argument]) -> list[str]:
    if not arguments:
        return [f"{name} has no arguments"]
    rows = [("name", "type", "allowed", "default", "set to", "where", "help")]
    for one in arguments:
        place = f"{one.span.source.path}:{one.span.line}:{one.span.column}"
        default = "(required)" if one.required else one.default
        rows.append((one.name, one.type, ", ".join(one.allowed), default, one.value, place, one.help))
    used = [column for column in zip(*rows, strict=True) if any(column[1:])]
    return [f"{name}:", *(f"  {line}" for line in aligned(list(zip(*used, strict=True))))]


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
    """Print the pose of one frame relative to another."""
    picked = run.pick("pose joints pulses sweeps modes strict")
    if not 0 <= run.digits <= _MAX_DIGITS:
        raise RequestError(f"--digits takes 0 to {_MAX_DIGITS}")
    description, (source, target) = run.robot_before(2, "ROBOT SOURCE TARGET")
    try:
        found = transform(run.request(description), source, target, **picked)
    except NotPublished as problem:
        return run.console.fail(str(problem), PROBLEMS)
    run.console.show(found.diagnostics)
    if not found.transforms:
        return PROBLEMS
    return run.give(found.transforms if found.swept else found.transforms[0], lambda: _transforms(found, run))


def _transforms(found: Transforms, run: Run) -> str:
    """Format transforms as tf2_echo does, or as CSV with the positions of swept joints before each pose."""
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
        blocks += tf2_echo_lines(state, run.digits, run.distro)
    return "\n".join(blocks)


def tf2_echo_lines(found: FrameTransform, digits: int, distro: str) -> list[str]:
    """Format a transform at time 0 as lines, like tf2_echo (``tf2_ros/src/tf2_echo.cpp``)."""
    forms = {
        "Translation:": found.translation,
        f"Rotation: in Quaternion{' (xyzw)' * (distro != 'humble')}": found.quaternion,
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
    """Print servo pulses and the resulting joint positions."""
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
    if failed or robot is None:
        return PROBLEMS
    return run.give(found, lambda: "\n".join(_pulses(found.joints) if found.joints else _calibration(robot)))


def _pulses(joints: Sequence[JointPulse]) -> list[str]:
    rows: list[Sequence[str]] = [("joint", "pulse", "position", "degrees", "requested", "difference")]
    for joint in joints:
        degrees = "" if joint.degrees is None else to_fixed(joint.degrees, 6)
        requested = "" if joint.requested is None else f"{exact(joint.requested)} {joint.unit}"
        difference = f"{joint.difference:+.3g} {joint.unit}" if joint.difference else f"0 {joint.unit}"
        position = f"{exact(joint.position)} {joint.unit}"
        rows.append((joint.joint, str(joint.pulse), position, degrees, requested, requested and difference))
    return aligned([row[: 6 if any(row[4] for row in rows[1:]) else 4] for row in rows])


def _calibration(robot: Robot) -> list[str]:
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
    return [*lines, *aligned(rows)]
