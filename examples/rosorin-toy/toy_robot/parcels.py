"""List the balls of a robot, and check whether a parcel can hold them."""

from __future__ import annotations

from rosorin_compile.extend import (
    FINE,
    PROBLEMS,
    Description,
    Run,
    check,
    check_options,
    command,
    for_each,
    option,
    robot_argument,
    robot_options,
)

from .toy import ball


@command("balls", group="inspect", help="list the balls of a robot", exits="0 listed, 1 the robot has errors")
@robot_argument
@robot_options
def balls(run: Run) -> int:
    """Print the balls of a robot; return the exit code."""
    description = run.only_robot()
    case = run.understood(description)
    if case is None:
        return PROBLEMS
    links = [link for link in case.robot.links if ball(link)]
    balls = [{"link": link.name, "radius": ball(link).radius, "mass": link.inertial.mass} for link in links]

    def text() -> str:
        lines = ("{link}, radius {radius:g} m, {mass:.3g} kg".format(**ball) for ball in balls)
        return "\n".join(f"{description.name}: {line}" for line in lines)

    return run.give(balls, text)


@check("parcel", help="check that the mass of all balls fits into a parcel")
@check_options()
@option("--most", type=float, default=4.0, metavar="KG", help="maximum mass of a parcel; default: 4")
def parcel(run: Run) -> int:
    """Check the robots of the command line; return the exit code."""
    return for_each(run, weigh)


def weigh(run: Run, description: Description) -> int:
    """Check one robot; return the exit code."""
    case = run.understood(description)
    if case is None:
        return PROBLEMS
    balls = [link for link in case.robot.links if ball(link)]
    mass = sum(link.inertial.mass for link in balls)
    if mass > run.most:
        heaviest = max(balls, key=lambda link: link.inertial.mass)
        message = f"the balls weigh {mass:.3g} kg, more than the limit of {run.most:g} kg"
        place = case.link(heaviest.name, "inertial", "mass")
        run.console.show([case.problem("ball-too-heavy", message, place, "use smaller balls")])
        return PROBLEMS
    run.console.say(f"{description.name}: {mass:.3g} kg, within the limit")
    return FINE
