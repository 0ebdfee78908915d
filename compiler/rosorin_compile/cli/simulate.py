"""rosorin-compile simulate: test a robot in MuJoCo."""

from __future__ import annotations

from collections.abc import Sequence

from rosorin_compile import api
from rosorin_compile.mujoco.simulate.simulation import LIMITS, about, summary, tables

from .answer import FINE, PROBLEMS
from .command import Options, choice, command, flag, option, robot_argument, robot_options, texts
from .run import Run, severities

_LIMITS = ", ".join(f"{name} {one.value:g}{f' {one.unit}' if one.unit else ''}" for name, one in LIMITS.items())


@command("simulate", exits="0 within the limits, 1 errors or a result beyond a limit")
@robot_argument
@choice(
    "--base",
    ("fixed", "free"),
    help="fix the base to the world, or put the robot on a floor; default: free if it has a drive",
)
@option("--seconds", type=float, default=2.0, metavar="NUMBER", help="time to hold each pose; default: 2")
@texts("--limit", "limits", metavar="NAME=NUMBER", help=f"override a limit; defaults: {_LIMITS}")
@flag("--no-timing", help="leave out the run time, which differs between runs")
@robot_options
def run(options: Options) -> int:
    """Simulate a robot and print its behaviour."""
    limits = _limits(options.limits)
    run, description = Run.alone(options, "one robot is simulated at a time", "rosorin-compile simulate ROBOT")
    console, request = run.console, run.request(description)
    timing = not options.no_timing
    result = api.simulate(request, base=options.base, seconds=options.seconds, limits=limits, timing=timing)
    name = result.robot
    if not result.poses:
        console.show(result.diagnostics)
        console.warn(f"{name}: nothing simulated")
        return PROBLEMS
    if options.format != "text":
        console.show(result.diagnostics)
        run.give(result)
    else:
        print(f"{name}: {about(result)}\n")
        print(tables(result))
        if result.timing is not None:
            steps, speed = result.timing.steps_per_cpu_second, result.timing.times_real_time
            print(f"speed   {steps:,.0f} steps a CPU second, {speed:,.1f} times real time")
        print()
        console.show(result.diagnostics)
        console.say(f"{name}: {summary(result)} simulated: {severities(result.diagnostics)}")
    return PROBLEMS if any(one.severity != "note" for one in result.diagnostics) else FINE


def _limits(texts: Sequence[str]) -> dict[str, float]:
    """Return the limits of the command line by name."""
    limits = {}
    for text in texts:
        name, _, value = text.partition("=")
        try:
            limits[name] = float(value)
        except ValueError:
            limits[name] = -1.0  # refused with the message for any unusable number
    return limits
