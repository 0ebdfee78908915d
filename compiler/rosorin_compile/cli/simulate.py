"""rosorin-compile simulate, check physics and collisions: commands that run a robot in MuJoCo."""

from collections import Counter
from contextlib import suppress
from pathlib import Path

from rosorin_compile import api
from rosorin_compile.model import DisabledCollision
from rosorin_compile.mujoco.collisions import FILE as COLLISIONS_FILE
from rosorin_compile.mujoco.physics import check_physics, require
from rosorin_compile.mujoco.simulation import LIMITS, about, simulate, summary, tables
from rosorin_compile.source.diagnostics import NOTE, count_of, phrase
from rosorin_compile.source.project import Description

from . import command as cli
from .console import FINE, PROBLEMS
from .run import Run, for_each, severities

_BASE = "fix the base to the world, or put the robot on a floor; default: free if it has a drive"
_LIMITS = ", ".join(f"{name} {one.value:g}{f' {one.unit}' if one.unit else ''}" for name, one in LIMITS.items())


@cli.command("simulate", exits="0 within the limits, 1 errors or a result beyond a limit")
@cli.robot_argument
@cli.option("--base fixed|free", help=_BASE)
@cli.option("--seconds NUMBER", default=2.0, help="time to hold each pose; default: 2")
@cli.repeatable("--limit NAME=NUMBER", "limits", help=f"override a limit; defaults: {_LIMITS}")
@cli.flag("--no-timing", help="leave out the run time, which differs between runs")
@cli.robot_options
def run_simulate(run: Run) -> int:
    """Simulate a robot and print its behaviour."""
    limits = dict.fromkeys(run.limits, -1.0)  # a negative number is reported as invalid
    for name, value in run.limits.items():
        with suppress(ValueError):
            limits[name] = float(value)
    request, settings = run.request(run.only_robot()), run.pick("base seconds")
    result = simulate(request, **settings, limits=limits, timing=not run.no_timing)
    name, is_text = result.robot, run.format == "text"
    if is_text and result.poses:
        print(f"{name}: {about(result)}\n\n{tables(result)}")
        if result.timing is not None:
            steps, speed = result.timing.steps_per_cpu_second, result.timing.times_real_time
            print(f"speed   {steps:,.0f} steps a CPU second, {speed:,.1f} times real time")
        print()
    run.console.show(result.diagnostics)
    if not result.poses:
        return PROBLEMS
    run.give(result)
    if is_text:
        run.console.say(f"{name}: {summary(result)} simulated: {severities(result.diagnostics)}")
    return PROBLEMS if any(one.severity != NOTE for one in result.diagnostics) else FINE


@cli.check("physics", exits="0 no errors, 1 errors")
@cli.check_options()
@cli.hook_option
def run_check_physics(run: Run) -> int:
    """Check the physics of each robot."""
    require("check physics")
    return for_each(run, _check_physics)


def _check_physics(run: Run, description: Description) -> int:
    result = check_physics(run.request(description))
    run.console.show(result.diagnostics)
    run.console.robots[-1]["looked_at"] = result.looked_at
    if not result.looked_at:
        return PROBLEMS
    run.console.say(f"{description.name}: physics of {result.looked_at}: {severities(result.diagnostics)}")
    return FINE if result.fine else PROBLEMS


@cli.command("collisions", exits="0 written or unchanged, 1 errors")
@cli.robot_argument
@cli.option("-o", "--output FILE", help=f"file to write; default: {COLLISIONS_FILE} next to the description")
@cli.flag("--force", help="compute again, even if the file is up to date")
@cli.robot_options
def run_collisions(run: Run) -> int:
    """Compute the collision matrix of a robot for MoveIt, and write it."""
    description = run.only_robot(stdin=False)
    console = run.console
    result = api.collisions(run.request(description), output=run.output, force=run.force)
    if run.show(result):
        return PROBLEMS
    if not result.written:
        console.say(f"{result.robot}: the collision matrix is that of {result.urdf}; --force computes it")
        return run.give(result)
    touching, wrong = ([" and ".join(pair) for pair in pairs] for pairs in (result.touching_hulls, result.contradicted))
    if touching:
        console.say(f"still checked: {phrase(touching, 3)}; their hulls touch, but their meshes do not")
    if wrong:
        console.warn(f"disabled_collisions says Never of {phrase(wrong, 3)}, which do collide")
    if result.kept:
        console.say(f"{count_of(result.kept, 'pair')} as before: the same shapes, and the same joints between")
    every = result.links * (result.links - 1) // 2
    counts = Counter(pair.reason for pair in result.pairs)
    reasons = phrase(f"{counts[reason]} {reason}" for reason in DisabledCollision.REASONS if counts[reason]) or "none"
    left = f"{every - len(result.pairs)} to check"
    console.say(f"{result.file}: {count_of(every, 'pair')} of links, need no check: {reasons}; {left}")
    console.say(f"tried: {count_of(result.states, 'random state')}, seed {result.seed}")
    included = "" if result.included else f"include: [{Path(result.file).name}] in {description.path}, then "
    console.say(f"next: {included}rosorin-compile all")
    return run.give(result)
