"""List the balls of a robot, and check whether a parcel can hold them."""

from __future__ import annotations

import argparse

from rosorin_compile.cli.answer import give_result
from rosorin_compile.cli.parser import Parser
from rosorin_compile.cli.run import Run, for_each
from rosorin_compile.cli.usage import FINE, PROBLEMS
from rosorin_compile.source.project import Description

from .toy import ball


def options(command: Parser) -> None:
    """Add the arguments of the command."""
    command.add_robot()
    command.add_result()
    command.add_given()


def run(options: argparse.Namespace) -> int:
    """Print the balls of a robot; return the exit code."""
    run, description = Run.alone(options, "the balls of one robot are listed at a time", "rosorin-compile balls ROBOT")
    case = run.understood(description)
    if case is None:
        return PROBLEMS
    links = [link for link in case.robot.links if ball(link)]
    balls = [{"link": link.name, "radius": ball(link).radius, "mass": link.inertial.mass} for link in links]

    def text() -> str:
        lines = ("{link}, radius {radius:g} m, {mass:.3g} kg".format(**ball) for ball in balls)
        return "\n".join(f"{description.name}: {line}" for line in lines)

    give_result(options, balls, text)
    return FINE


def check_options(command: Parser) -> None:
    """Add the arguments of the check."""
    command.add_check_options()
    command.add_argument("--most", type=float, default=4.0, metavar="KG", help="maximum mass of a parcel; default: 4")


def check(options: argparse.Namespace) -> int:
    """Check the robots of the command line; return the exit code."""
    return for_each(options, weigh)


def weigh(run: Run, description: Description) -> int:
    """Check one robot; return the exit code."""
    case = run.understood(description)
    if case is None:
        return PROBLEMS
    balls = [link for link in case.robot.links if ball(link)]
    mass = sum(link.inertial.mass for link in balls)
    if mass > run.options.most:
        heaviest = max(balls, key=lambda link: link.inertial.mass)
        message = f"the balls weigh {mass:.3g} kg, more than the limit of {run.options.most:g} kg"
        place = case.link(heaviest.name, "inertial", "mass")
        run.console.show([case.problem("ball-too-heavy", message, place, "use smaller balls")])
        return PROBLEMS
    run.console.say(f"{description.name}: {mass:.3g} kg, within the limit")
    return FINE
