"""rosorin-compile tf: say where one frame sits in another, as tf2_echo does."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from typing import TYPE_CHECKING, NamedTuple

from rosorin_compile.source.console import Console
from rosorin_compile.source.progress import Progress
from rosorin_compile.source.project import Description
from rosorin_compile.source.rule_registry import ASKING, Rule
from rosorin_compile.source.wording import listed

from .answer import give_result
from .robots import one
from .run import Run
from .understanding import RobotCase, mode_states, understood
from .usage import FINE, PROBLEMS, WrongUsage

if TYPE_CHECKING:
    from rosorin_compile.model import Edge, Robot
    from rosorin_compile.model.kinematics.graph import NoWay
    from rosorin_compile.model.kinematics.lookup import Answer
    from rosorin_compile.model.kinematics.quaternions import Position
    from rosorin_compile.source.console import Console
    from rosorin_compile.source.diagnostics import Diagnostic

    from .parser import Parser

RULES = (
    Rule(
        "transform-not-known",
        "On the way between two frames there is a transform whose numbers another node alone knows, or one that "
        "depends on the mode; or the frames are in trees that do not meet.",
        "Ask the running robot; give the edge `xyz` and `rpy`; `--mode NAME`.",
        ASKING,
    ),
    Rule(
        "transform-unpublished",
        "A note: nobody publishes a transform of the way.",
        "The answer is that of the description; tf2 has none there.",
        ASKING,
    ),
    Rule(
        "transform-sometimes",
        "A note: a transform of the way is published in some modes only.",
        "`--mode NAME` asks about one of them.",
        ASKING,
    ),
)

_HOW = "rosorin-compile tf ROBOT SOURCE TARGET"
_MOST_DIGITS = 17
# Options that may come several times: option, destination, form, help.
_STATE = (
    ("--pulse", "pulses", "JOINT=PULSE", "pulse sent to the servo; overrides --pose"),
    ("--joint", "joints", "JOINT=VALUE", "position, such as 30deg, 5cm or 1,2,30deg; overrides --pose and --pulse"),
    ("--sweep", "sweeps", "JOINT=FROM:TO:COUNT", "use COUNT positions in turn; repeatable: all combinations"),
)


class Asked(NamedTuple):
    """The states of the joints that are asked for, and the joints that differ in them, with their units."""

    states: list[dict[str, Position]]
    swept: dict[str, str]


def options(command: Parser) -> None:
    """Add what this command takes."""
    command.add_argument(
        "words",
        nargs="*",
        metavar="[ROBOT] SOURCE TARGET",
        completes="[ROBOT] FRAME FRAME",
        help="the robot, required if there are several, and the frames: prints the pose of TARGET in SOURCE",
    )
    state = command.add_argument_group("joint positions (default: zero)")
    state.add_argument("--pose", default="", metavar="POSE", help="named pose of the description")
    for option, dest, form, help in _STATE:
        state.add_argument(option, action="append", default=[], metavar=form, dest=dest, help=help)
    state.add_argument("--strict", action="store_true", help="treat positions beyond a limit as errors")
    command.add_modes("off; without --mode all are on")
    answer = command.add_mutually_exclusive_group()
    command.add_result_form(answer)
    answer.add_argument(
        "--table", action="store_true", help="print one line per state: x y z in m, roll pitch yaw in degrees"
    )
    answer.add_argument("--csv", action="store_true", help="print one line per state: all digits, in m and rad")
    command.add_argument(
        "--distro",
        choices=("humble", "jazzy"),
        default="humble",
        help="ROS distribution whose tf2_echo format is used; default: humble",
    )
    command.add_argument("--digits", type=int, metavar="N", help="decimals; default: 3")
    command.add_quiet()
    command.add_given()


def run(options: argparse.Namespace) -> int:
    """Print where a frame sits in another."""
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
    known = understood(run.given, _robot("".join(robot)), console)
    if known is None:
        return PROBLEMS
    from rosorin_compile.model.servos import NoPulse

    try:
        asked = _asked(known, options)
    except NoPulse as problem:
        console.warn(f"rosorin-compile: {problem}")
        return PROBLEMS
    code = _limits(known, asked, options.strict, console)
    return code or _answer(known, source, target, asked, options, console)


def _robot(name: str) -> Description:
    """Return the robot that is asked for. Raises WrongUsage, which says where it stands."""
    try:
        return one(name, _HOW)
    except WrongUsage as problem:
        raise WrongUsage(f"{problem}; {_HOW}" if name else str(problem)) from None


def _asked(known: RobotCase, options: argparse.Namespace) -> Asked:
    """Return the states that the options ask for. Raises WrongUsage, NoPulse."""
    from rosorin_compile.model.servos import NoServo

    from .joint_states import NoState, given, states, sweep_of

    try:
        start = given(known.robot, options.pose, options.joints, options.pulses)
        sweeps = [sweep_of(known.robot, text) for text in options.sweeps]
        slides = {sweep.joint: known.robot.joint[sweep.joint].type == "prismatic" for sweep in sweeps}
        return Asked(list(states(start, sweeps)), {name: "m" if slide else "rad" for name, slide in slides.items()})
    except (NoState, NoServo) as problem:
        raise WrongUsage(str(problem.args[0])) from None


def _limits(known: RobotCase, asked: Asked, strict: bool, console: Console) -> int:
    """Say which positions are beyond a limit, each joint and side once; PROBLEMS if they are refused."""
    from rosorin_compile.source.diagnostics import ERROR, WARNING

    from .joint_states import beyond, beyond_limit

    found: dict[tuple[str, str], Diagnostic] = {}
    for state in asked.states:
        for one_beyond in beyond(known.robot, state):
            key = (one_beyond.joint.name, one_beyond.side)
            if key not in found:
                found[key] = beyond_limit(known, one_beyond, ERROR if strict else WARNING)
    console.show(list(found.values()))
    return PROBLEMS if found and strict else FINE


def _answer(
    known: RobotCase, source: str, target: str, asked: Asked, options: argparse.Namespace, console: Console
) -> int:
    """Print the answer for each state."""
    from rosorin_compile.model.kinematics.graph import Graph, NoWay
    from rosorin_compile.model.kinematics.lookup import lookup

    every, graph = Graph(known.robot), Graph(_in_modes(known, options.modes))
    for frame in (source, target):
        if frame not in every.moves:
            from rosorin_compile.source.diagnostics import did_you_mean

            raise WrongUsage(f'there is no frame "{frame}"; {did_you_mean(frame, every.frames)}')
        if frame not in graph.moves:
            console.warn(f'rosorin-compile: in these modes nobody publishes the frame "{frame}"')
            return PROBLEMS
    try:
        answers = []
        for number, state in enumerate(asked.states):
            Progress.step("looking up", number, len(asked.states))
            answers.append(lookup(graph, source, target, state))
    except NoWay as problem:
        console.show([_no_way(known, problem)])
        return PROBLEMS
    console.show(_remarks(known, answers[0]))
    from .tf_echo import as_json

    made = [as_json(answer, state) for answer, state in zip(answers, asked.states, strict=True)]
    give_result(options, made if asked.swept else made[0], lambda: _form(answers, asked, options))
    return FINE


def _form(answers: Sequence[Answer], asked: Asked, options: argparse.Namespace) -> str:
    """Return the answers in the form for people that is asked for."""
    from . import tf_echo as echo

    digits = echo.DIGITS if options.digits is None else options.digits
    if options.csv:
        return echo.csv(list(asked.swept), asked.states, answers)
    if options.table:
        return echo.table(asked.swept, asked.states, answers, digits)
    blocks = []
    for answer, state in zip(answers, asked.states, strict=True):
        head = [f"# {', '.join(f'{joint} = {state[joint]:.6g}' for joint in asked.swept)}"] if asked.swept else []
        blocks.append("\n".join([*head, *echo.text(answer, digits, options.distro)]))
    return "\n".join(blocks)


def _in_modes(known: RobotCase, modes: list[str]) -> Robot:
    """Return the robot with the edges of some modes only; of all if none are named. Raises WrongUsage."""
    from dataclasses import replace

    from rosorin_compile.rules import conditions

    robot = known.robot
    if not modes:
        return robot
    combination = {**dict.fromkeys(robot.modes, False), **mode_states(robot, modes)}
    return replace(robot, edges=tuple(edge for edge in robot.edges if conditions.holds(edge.when, combination)))


def _no_way(known: RobotCase, problem: NoWay) -> Diagnostic:
    """Return why the description has no answer: which edges are missing, who publishes them, and when."""
    from rosorin_compile.source.diagnostics import error

    from .tf_echo import who

    source, target = problem.source, problem.target
    if not problem.missing:
        help = "declare the transform that joins them under edges, with who publishes it"
        return error("transform-not-known", f"{source} and {target} are in trees that do not meet", None, help)
    related = []
    for step in problem.missing:
        for edge in step.edges:
            words = "a pose of its own" if edge.pose is not None else "known to that node alone"
            said = f"{edge.parent} -> {edge.child}: {who(edge.publisher)} publishes it {_when(edge.when)}, {words}"
            related.append(known.case.related(said, ("edges", edge_index(known.robot, edge))))
    edges = listed(f"{step.parent} -> {step.child}" for step in problem.missing)
    message = f"the description has no numbers for {edges}, on the way from {source} to {target}"
    help = f"ask the running robot, ros2 run tf2_ros tf2_echo {source} {target}; or give the edge xyz and rpy"
    if all(edge.pose is not None for step in problem.missing for edge in step.edges):
        message = f"{edges}, on the way from {source} to {target}, depends on the mode"
        help = "say which mode is on: --mode NAME"
    first = problem.missing[0].edges[0]
    path = ("edges", edge_index(known.robot, first))
    return known.case.problem("transform-not-known", message, path, help, related=related)


def _when(when: str) -> str:
    return f"when {when}" if when else "always"


def _remarks(known: RobotCase, answer: Answer) -> list[Diagnostic]:
    """Return notes on transforms of the way that the running robot has only sometimes, or not at all."""
    from rosorin_compile.source.diagnostics import NOTE

    notes = []
    for move in answer.way:
        step = move.step
        path: tuple[str | int, ...]
        if step.joint is not None:
            path = known.case.joint(step.joint)
        else:
            path = ("edges", edge_index(known.robot, step.edges[0]))
        if not step.publishers:
            why = step.joint.publisher.about if step.joint is not None else ""
            said = f"nobody publishes {step.parent} -> {step.child}{f': {why}' if why else ''}"
            help = "the answer is that of the description; tf2 on the robot may have none, or another one"
            notes.append(known.case.problem("transform-unpublished", said, path, help, severity=NOTE))
        elif all(when for _, when in step.publishers):
            whens = " or ".join(dict.fromkeys(when for _, when in step.publishers))
            said = f"{step.parent} -> {step.child} is published when {whens}"
            notes.append(known.case.problem("transform-sometimes", said, path, "", severity=NOTE))
    return notes


def edge_index(robot: Robot, edge: Edge) -> int:
    """Return the place of an edge in the list of the description."""
    return next(index for index, one in enumerate(robot.edges) if one is edge)
