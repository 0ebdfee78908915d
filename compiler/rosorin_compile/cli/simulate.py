"""rosorin-compile simulate: test a robot in MuJoCo."""

from contextlib import suppress

from rosorin_compile.mujoco.simulate.simulation import LIMITS, about, simulate, summary, tables

from .command import Options, command, flag, option, repeatable, robot_argument, robot_options
from .console import FINE, PROBLEMS
from .run import Run, severities

_LIMITS = ", ".join(f"{name} {one.value:g}{f' {one.unit}' if one.unit else ''}" for name, one in LIMITS.items())


@command("simulate", exits="0 within the limits, 1 errors or a result beyond a limit")
@robot_argument
@option(
    "--base fixed|free", help="fix the base to the world, or put the robot on a floor; default: free if it has a drive"
)
@option("--seconds NUMBER", default=2.0, help="time to hold each pose; default: 2")
@repeatable("--limit NAME=NUMBER", "limits", help=f"override a limit; defaults: {_LIMITS}")
@flag("--no-timing", help="leave out the run time, which differs between runs")
@robot_options
def run(options: Options) -> int:
    """Simulate a robot and print its behaviour."""
    limits = {}
    for name, value in options.limits.items():
        limits[name] = -1.0  # refused with the message for any unusable number
        with suppress(ValueError):
            limits[name] = float(value)
    run, description = Run.alone(options)
    console, settings = run.console, options.pick("base seconds")
    result = simulate(run.request(description), **settings, limits=limits, timing=not options.no_timing)
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
