"""rosorin-compile simulate: test a robot in MuJoCo."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import click

from rosorin_compile import api
from rosorin_compile.mujoco.simulate.judging import LIMITS
from rosorin_compile.source.console import Console
from rosorin_compile.source.diagnostics import counted, listed

from .answer import give_result
from .command import Options, command, option
from .options import PATH, robot_argument, robot_options
from .run import Run
from .usage import FINE, PROBLEMS

if TYPE_CHECKING:
    from rosorin_compile.mujoco.simulate.simulation import Simulated


_HOW = "rosorin-compile simulate ROBOT"


_LIMITS = ", ".join(f"{name} {one.value:g}{f' {one.unit}' if one.unit else ''}" for name, one in LIMITS.items())


@command("simulate", exits="0 within the limits, 1 errors or a result beyond a limit")
@robot_argument
@option(
    "--base",
    type=click.Choice(("fixed", "free")),
    help="fix the base to the world, or put the robot on a floor; default: free if it has a drive",
)
@option("--seconds", type=float, default=2.0, metavar="NUMBER", help="time to hold each pose; default: 2")
@option("--limit", "limits", multiple=True, metavar="NAME=NUMBER", help=f"override a limit; defaults: {_LIMITS}")
@option("--no-timing", is_flag=True, help="leave out the run time, which differs between runs")
@option("--html", type=PATH, metavar="FILE", help="write a page with plots")
@robot_options
def run(options: Options) -> int:
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


def _show(result: Simulated, options: Options, console: Console) -> None:
    from rosorin_compile.mujoco.simulate import report

    if options.format != "text":
        console.show(result.diagnostics)
        give_result(options, result, str)
        return
    print(f"{result.robot}: {report.about(result)}\n")
    print(report.text(result))
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
    from rosorin_compile.output import OutputError, write_file

    try:
        write_file(file, result.page().encode(), sorted(result.inputs))
    except OutputError as problem:
        console.show([problem.diagnostic])
        return False
    console.say(f"{result.robot}: curves in {file}")
    return True
