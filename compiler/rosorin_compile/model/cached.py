"""Cache the results of functions of a robot with the robot."""

from __future__ import annotations

from collections.abc import Callable
from functools import update_wrapper
from typing import TYPE_CHECKING, Concatenate, ParamSpec, TypeVar

if TYPE_CHECKING:
    from .robot import Robot

Given = ParamSpec("Given")
Made = TypeVar("Made")


def of_robot(work: Callable[Concatenate[Robot, Given], Made]) -> Callable[Concatenate[Robot, Given], Made]:
    """Cache the results of a function of a robot with the robot."""

    def cached(robot: Robot, /, *given: Given.args, **named: Given.kwargs) -> Made:
        key = (work.__module__, work.__qualname__, given, *named.items())
        if key not in robot.worked_out:
            robot.worked_out[key] = work(robot, *given, **named)
        made: Made = robot.worked_out[key]
        return made

    update_wrapper(cached, work)
    return cached
