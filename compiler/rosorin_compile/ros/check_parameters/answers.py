"""What check parameters answers as JSON: the types of its result, of which the schema is made.

Nothing imports this module at run time.
"""

from __future__ import annotations

from typing import Annotated, Any, TypedDict


class CheckedParameters(TypedDict):
    """What came of one robot, against which parameter files were held."""

    robot: str
    file: Annotated[str, "its first file"]
    fine: Annotated[bool, "whether there is no error; the exit code is 0 then"]


class ParametersOfRobots(TypedDict):
    """What came of the robot that was asked for; the diagnostics say what is wrong in which file."""

    robots: list[CheckedParameters]


ANSWERS: dict[str, Any] = {"check parameters": ParametersOfRobots}
