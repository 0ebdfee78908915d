"""rosorin-compile simulate: test a robot in MuJoCo."""

from __future__ import annotations

import argparse
from collections import Counter
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from rosorin_compile import api
from rosorin_compile.mujoco.simulate.judging import LIMITS
from rosorin_compile.source.diagnostics import Console, counted, listed

from .answer import give_result
from .run import Run
from .usage import FINE, PROBLEMS

if TYPE_CHECKING:
    from rosorin_compile.mujoco.simulate.simulation import Simulated

    from .parser import Parser

_HOW = "rosorin-compile simulate ROBOT"


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
    """Simulate a robot and print its behaviour."""
    limits = _limits(options.limits)
    run, description = Run.alone(options, "one robot is simulated at a time", _HOW)
    result = api.simulate(
        run.request(description),
        base=options.base,
        seconds=options.seconds,
        limits=limits,
        timing=not options.no_timing,
    )
    if not result.poses:
        run.console.show(result.diagnostics)
        run.console.warn(f"{result.robot}: nothing simulated")
        return PROBLEMS
    _show(result, options, run.console)
    if options.html is not None and not _write_page(result, Path(options.html), run.console):
        return PROBLEMS
    return PROBLEMS if any(one.severity != "note" for one in result.diagnostics) else FINE


def _limits(texts: Sequence[str]) -> dict[str, float]:
    """Return the limits of the command line by name. Raises RequestError."""
    limits = {}
    for text in texts:
        name, _, value = text.partition("=")
        try:
            limits[name] = float(value)
        except ValueError:
            limits[name] = -1.0  # refused with the message for any unusable number
    return limits


def _show(result: Simulated, options: argparse.Namespace, console: Console) -> None:
    from rosorin_compile.mujoco.simulate import report

    if options.format != "text":
        console.show(result.diagnostics)
        give_result(options, result, str)
        return
    print(f"{result.robot}: {report.about(result)}\n")
    print(report.text(report.tables(result)))
    if result.timing is not None:
        steps, speed = result.timing.steps_per_cpu_second, result.timing.times_real_time
        print(f"speed   {steps:,.0f} steps a CPU second, {speed:,.1f} times real time")
    print()
    console.show(result.diagnostics)
    severities = Counter(one.severity for one in result.diagnostics)
    counts = listed(counted(severities[one], one) for one in ("error", "warning", "note") if severities[one])
    console.say(f"{result.robot}: {report.summary(result)} simulated: {counts or 'nothing to say'}")


def _write_page(result: Simulated, file: Path, console: Console) -> bool:
    """Write the page; return False if that is not possible."""
    from rosorin_compile.output import OutputError
    from rosorin_compile.output.one_file import write_file

    try:
        write_file(file, result.page().encode(), sorted(result.inputs))
    except OutputError as problem:
        console.show([problem.diagnostic])
        return False
    console.say(f"{result.robot}: curves in {file}")
    return True
