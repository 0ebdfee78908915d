"""Whether a robot stands free in a simulation: one that drives does, unless an output says otherwise."""

from __future__ import annotations

from rosorin_compile.model import Output, Robot

from . import DRIVE


def stands_free(robot: Robot, output: Output) -> bool:
    """Say whether the base is free to move in a simulation: as the output says, else that of a robot with a drive."""
    usual = "fixed" if robot.sections[DRIVE] is None else "free"
    return output.options.get("base", usual) == "free" and not robot.root_in_world.world
