"""The types of the results of package, deploy and check deployed, from which their schemas are made.

Nothing imports this module at run time.
"""

from __future__ import annotations

from typing import Annotated, Any, TypedDict

from .deploy import Deployed
from .write import WrittenPackage


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
