"""rosorin-compile simulate: the robot in MuJoCo: it rests, holds its poses, drives, and sweeps its joints."""

from __future__ import annotations

import argparse
from collections import Counter
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from rosorin_compile.mujoco.simulate.judging import LIMITS, Judge
from rosorin_compile.source.diagnostics import (
    Console,
    Diagnostic,
    Heading,
    Progress,
    Rule,
    arrange,
    counted,
    error,
    has_errors,
    listed,
    pip_install,
)
from rosorin_compile.source.installing import is_installed
from rosorin_compile.source.project import Description

from .answer import give_result
from .run import Run
from .usage import FINE, PROBLEMS, WrongUsage

if TYPE_CHECKING:
    from rosorin_compile.mujoco.simulate.trials import Trials
    from rosorin_compile.mujoco.simulate.world import World
    from rosorin_compile.rules.case import Case

    from .given import Given
    from .parser import Parser

RULES = (
    Rule(
        "simulation-refused",
        "The robot cannot be simulated: MuJoCo does not load it, or its MJCF cannot be written.",
        "As the message says; `check` names the place.",
        Heading.SIMULATION,
    ),
)

_HOW = "rosorin-compile simulate ROBOT"
_LEAST_SECONDS, _MOST_SECONDS = 0.5, 600.0


def options(command: Parser) -> None:
    """Add what this command takes."""
    command.add_robot()
    command.add_argument(
        "--base",
        choices=("fixed", "free"),
        help="fix the base to the world, or put the robot on a floor; default: free if it has a drive",
    )
    command.add_argument(
        "--seconds", type=float, default=2.0, metavar="NUMBER", help="time to hold each pose; default: 2"
    )
    said = ", ".join(f"{name} {one.value:g}{f' {one.unit}' if one.unit else ''}" for name, one in LIMITS.items())
    command.add_argument(
        "--limit",
        action="append",
        default=[],
        metavar="NAME=NUMBER",
        dest="limits",
        help=f"override a limit; defaults: {said}",
    )
    command.add_argument("--no-timing", action="store_true", help="leave out the run time, which differs between runs")
    command.add_argument("--html", type="path", metavar="FILE", help="write a page with plots")
    command.add_result()
    command.add_given()


def run(options: argparse.Namespace) -> int:
    """Simulate a robot, and say how it behaves."""
    limits = _limits(options.limits)
    if not _LEAST_SECONDS <= options.seconds <= _MOST_SECONDS:
        raise WrongUsage(f"--seconds takes {_LEAST_SECONDS:g} to {_MOST_SECONDS:g}")
    lacking = [name for name in ("mujoco", "numpy") if not is_installed(name)]
    if lacking:
        raise WrongUsage(f"simulate needs what is not installed ({listed(lacking)}): {pip_install('simulate')}")
    run, description = Run.alone(options, "one robot is simulated at a time", _HOW)
    case = run.understood(description)
    if case is None:
        return PROBLEMS
    return _simulate(run, case, description, limits)


def _limits(texts: Sequence[str]) -> dict[str, float]:
    """Return the limits, those of the command line in place of the usual ones. Raises WrongUsage."""
    from rosorin_compile.source.diagnostics import did_you_mean

    made = {name: one.value for name, one in LIMITS.items()}
    for text in texts:
        name, equals, value = text.partition("=")
        if name not in made:
            raise WrongUsage(f'there is no limit "{name}"; {did_you_mean(name, made)}')
        try:
            made[name] = float(value)
        except ValueError:
            made[name] = -1.0
        if not equals or not 0 <= made[name] < float("inf"):
            raise WrongUsage(f"--limit takes a number that is not negative: --limit {name}={LIMITS[name].value:g}")
    return made


def _simulate(run: Run, case: Case, description: Description, limits: dict[str, float]) -> int:
    """Go through the trials, and tell what came of them."""
    from rosorin_compile.mujoco.simulate.trials import all_trials
    from rosorin_compile.mujoco.simulate.world import FIXED, FREE, Refused, quiet

    options, console = run.options, run.console
    base = options.base or (FREE if case.robot.sections["drive"] else FIXED)
    with quiet() as mujoco:
        try:
            world = _world(mujoco, case, description, run.given, base)
        except Refused as problem:
            message = f"{case.robot.name} cannot be simulated: {problem}"
            console.show([*problem.diagnostics, error("simulation-refused", message, None, "check names the place")])
            return PROBLEMS
        trials = all_trials(world, options.seconds, lambda done, total: Progress.step("simulating", done, total))
        found = arrange(case.settled(Judge(case, world, limits).all(trials), "simulation"))
    _tell(world, trials, found, limits, options, console)
    if options.html is not None and not _written(world, trials, found, Path(options.html), case, console):
        return PROBLEMS
    return PROBLEMS if any(one.severity != "note" for one in found) else FINE


def _world(mujoco: object, case: Case, description: Description, given: Given, base: str) -> World:
    """Return the robot in MuJoCo. Raises Refused."""
    from rosorin_compile.formats import FORMATS
    from rosorin_compile.formats.templating import Templates
    from rosorin_compile.mujoco.simulate.world import Refused, World, simulated

    Progress.step("building the model")
    robot = case.robot
    formats = [one.name for one in FORMATS.values() if one.proving.refusal is not None and one.write is not None]
    output = next((one for one in robot.outputs if one.backend in formats), None)
    meshes = given.search_meshes(description, case.tree, robot.outputs)
    if has_errors(meshes.diagnostics):
        raise Refused("a mesh cannot be used", meshes.diagnostics)
    robot = meshes.told_to(robot)
    text = simulated(robot, output, Templates(description.path.parent), base)
    folder = (description.outputs / (output.file if output else "")).parent if output else description.outputs
    return World(mujoco, robot, text, base, folder, meshes.files)


def _tell(
    world: World,
    trials: Trials,
    found: Sequence[Diagnostic],
    limits: dict[str, float],
    options: argparse.Namespace,
    console: Console,
) -> None:
    """Print what came of the trials."""
    from rosorin_compile.mujoco.simulate import report

    timing = not options.no_timing
    if options.format != "text":
        console.show(found)
        give_result(options, report.as_json(world, trials, limits, timing), str)
        return
    name = world.robot.name
    print(f"{name}: {report.about(world)}\n")
    print(report.text(report.tables(world, trials)))
    if timing:
        print(report.speed_line(world))
    print()
    console.show(found)
    severities = Counter(one.severity for one in found)
    counts = listed(counted(severities[one], one) for one in ("error", "warning", "note") if severities[one])
    console.say(f"{name}: {report.summary(trials)} simulated: {counts or 'nothing to say'}")


def _written(
    world: World, trials: Trials, found: Sequence[Diagnostic], file: Path, case: Case, console: Console
) -> bool:
    """Write the page; say whether that was possible."""
    from rosorin_compile.mujoco.simulate.report import page
    from rosorin_compile.output import OutputError, write_file

    inputs = {Path(span.source.path) for span in case.tree.value_spans.values()}
    try:
        write_file(file, page(world, trials, found).encode(), sorted(inputs))
    except OutputError as problem:
        console.show([problem.diagnostic])
        return False
    console.say(f"{world.robot.name}: curves in {file}")
    return True
