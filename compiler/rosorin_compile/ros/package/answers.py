"""What package, deploy and check deployed answer as JSON: the types of results, of which the schemas are made.

Nothing imports this module at run time.
"""

from __future__ import annotations

from typing import Annotated, Any, TypedDict


class WrittenPackage(TypedDict):
    """A ROS 2 package."""

    package: str
    folder: str
    files: Annotated[list[str], "all files of it, as seen from the folder"]
    written: Annotated[list[str], "those that are new or others than before"]


class DeployedCopy(TypedDict):
    """An artifact in a folder."""

    file: Annotated[str, "as seen from the folder"]
    output: Annotated[str, "its name under `outputs`"]
    same: Annotated[bool, "whether it was there as it is compiled before the run"]


class Deployed(TypedDict):
    """The artifacts of a robot in a folder."""

    robot: str
    folder: str
    written: Annotated[bool, "false with `--dry-run`"]
    copies: list[DeployedCopy]


class _CopiesDiffer(TypedDict, total=False):
    differences: Annotated[list[str], "what differs, in the lines that people read"]


class CheckedCopies(_CopiesDiffer):
    """What came of one robot, with which copies of its artifacts were compared."""

    robot: str
    file: Annotated[str, "its first file"]
    fine: Annotated[bool, "whether all copies are as compiled; the exit code is 0 then"]


class CopiesOfRobots(TypedDict):
    """What came of the robot that was asked for."""

    robots: list[CheckedCopies]


ANSWERS: dict[str, Any] = {"check deployed": CopiesOfRobots, "deploy": Deployed, "package": WrittenPackage}
