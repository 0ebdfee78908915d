"""Cache the results of functions of a robot with the robot."""

from __future__ import annotations

from collections.abc import Callable
from functools import wraps
from typing import TYPE_CHECKING, Any, Concatenate, ParamSpec, TypeVar

if TYPE_CHECKING:
    from .robot import Robot

Arguments = ParamSpec("Arguments")
Result = TypeVar("Result")


def of_robot(work: Callable[Concatenate[Robot, Arguments], Result]) -> Callable[Concatenate[Robot, Arguments], Result]:
    """Cache the results of a function of a robot with the robot."""

    @wraps(work)
    def cached(robot: Robot, /, *arguments: Arguments.args, **named: Arguments.kwargs) -> Any:
        key = (work.__module__, work.__qualname__, arguments, *named.items())
        if key not in robot.worked_out:
            robot.worked_out[key] = work(robot, *arguments, **named)
        return robot.worked_out[key]

    return cached
