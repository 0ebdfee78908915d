"""Modes on the command line: --mode slam, --mode "not slam", --mode slam=on, --mode slam=off."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from .parser import Options
from .shared import WrongUsage

if TYPE_CHECKING:
    from ..model import Robot

_STATES = {"on": True, "off": False}


def mode_option(command: Options, unnamed: str) -> None:
    """Add the option that says how modes are; ``unnamed`` says what those are that are not named."""
    command.add_argument(
        "--mode",
        action="append",
        default=[],
        metavar="NAME",
        dest="modes",
        help=f'a mode that is on, or off: slam, "not slam", slam=off; others: {unnamed}',
    )


def mode_states(robot: Robot, texts: Sequence[str]) -> dict[str, bool]:
    """Return the modes that the command line names, and whether they are on. Raises WrongUsage."""
    found: dict[str, bool] = {}
    for text in texts:
        name, equals, state = text.partition("=")
        words = name.split()
        negated = len(words) == 2 and words[0] == "not"
        name = words[-1] if negated else name.strip()
        if name not in robot.modes:
            from ..diagnostic import did_you_mean

            known = did_you_mean(name, robot.modes) or "it has none"
            raise WrongUsage(f'{robot.name} has no mode "{name}"; {known}')
        if (equals and state not in _STATES) or (equals and negated):
            raise WrongUsage(f'"{text}" is not a mode: write {name}, "not {name}", {name}=on or {name}=off')
        on = _STATES[state] if equals else not negated
        if found.setdefault(name, on) != on:
            raise WrongUsage(f'the mode "{name}" cannot be on and off')
    return found
