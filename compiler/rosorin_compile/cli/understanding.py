"""A robot without errors, to be asked about: what its description says, or a robot in another format in its place.

``mode_states`` reads modes as the command line has them: --mode slam, "not slam", slam=on, slam=off.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, NamedTuple

from rosorin_compile.source.console import Console
from rosorin_compile.source.project import Description

from .given import Given
from .usage import WrongUsage

if TYPE_CHECKING:
    from rosorin_compile.model import Robot
    from rosorin_compile.rules.case import Case

_STATES = {"on": True, "off": False}


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


def mode_states(robot: Robot, texts: Sequence[str]) -> dict[str, bool]:
    """Return the modes that the command line names, and whether they are on. Raises WrongUsage."""
    found: dict[str, bool] = {}
    for text in texts:
        name, equals, state = text.partition("=")
        words = name.split()
        negated = len(words) == 2 and words[0] == "not"
        name = words[-1] if negated else name.strip()
        if name not in robot.modes:
            from rosorin_compile.source.diagnostics import did_you_mean

            known = did_you_mean(name, robot.modes) or "it has none"
            raise WrongUsage(f'{robot.name} has no mode "{name}"; {known}')
        if (equals and state not in _STATES) or (equals and negated):
            raise WrongUsage(f'"{text}" is not a mode: write {name}, "not {name}", {name}=on or {name}=off')
        on = _STATES[state] if equals else not negated
        if found.setdefault(name, on) != on:
            raise WrongUsage(f'the mode "{name}" cannot be on and off')
    return found
