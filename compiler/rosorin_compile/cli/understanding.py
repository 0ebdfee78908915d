"""The robot of a command that inspects one: of a description, or of a file in another format."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

from rosorin_compile.source.console import Console
from rosorin_compile.source.project import Description

from .given import Given

if TYPE_CHECKING:
    from rosorin_compile.model import Robot
    from rosorin_compile.rules.case import Case


class RobotCase(NamedTuple):
    """A robot without errors, and where it was written."""

    robot: Robot
    case: Case


def understood(given: Given, description: Description, console: Console) -> RobotCase | None:
    """Return the robot of a description; None, after saying what is wrong, of one with errors."""
    found = given.understand(description, console)
    case = found.case
    if case is None:
        console.show([diagnostic for diagnostic in found.diagnostics if diagnostic.severity == "error"])
        console.warn(f"{description.name}: a description with errors has no frames and joints to ask about")
        return None
    return RobotCase(case.robot, case)
