"""rosorin-compile check physics: look for what cannot be, by an engine and by meshes."""

from __future__ import annotations

import argparse
from collections import Counter
from dataclasses import asdict
from typing import TYPE_CHECKING

from rosorin_compile.mujoco.physics.checking import Looked, lacking, look
from rosorin_compile.source.diagnostics import counted, has_errors, listed
from rosorin_compile.source.project import Description

from .run import Run, for_each
from .usage import FINE, PROBLEMS, WrongUsage

if TYPE_CHECKING:
    from .parser import Parser


def options(command: Parser) -> None:
    """Add what this check takes."""
    command.add_check_options(hook=True)


def run(options: argparse.Namespace) -> int:
    """Check the physics of each robot."""
    _check_installed()
    return for_each(options, _answered)


def _check_installed() -> None:
    missing = lacking()
    if missing:
        raise WrongUsage(f"check physics needs what is not installed: pip install {missing}")


def _answered(run: Run, description: Description) -> int:
    looked = _check(run, description)
    run.tell_of_robot({"looked_at": looked and asdict(looked.at)})
    return _code(looked)


def _check(run: Run, description: Description) -> Looked | None:
    case = run.understood(description)
    if case is None:
        return None
    looked = look(case, description, run.given.packages)
    run.console.show(looked.diagnostics)
    severities = Counter(diagnostic.severity for diagnostic in looked.diagnostics)
    found = listed(counted(severities[one], one) for one in ("error", "warning", "note") if severities[one])
    run.console.say(f"{description.name}: physics of {looked.at}: {found or 'nothing to say'}")
    return looked


def _code(looked: Looked | None) -> int:
    return PROBLEMS if looked is None or has_errors(looked.diagnostics) else FINE
