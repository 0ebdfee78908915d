"""rosorin-compile check deployed: compare what robots are compiled to with the copies in a folder."""

from __future__ import annotations

import argparse
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

from rosorin_compile.ros.package import naming
from rosorin_compile.ros.package.carrying import described
from rosorin_compile.ros.package.checking import Checked, check
from rosorin_compile.ros.package.finding import files_below
from rosorin_compile.source.diagnostics import Heading, error, has_errors
from rosorin_compile.source.load import LoadError
from rosorin_compile.source.project import Description
from rosorin_compile.source.rule_registry import Rule

from .run import Run, for_each
from .usage import FINE, PROBLEMS, WrongUsage

if TYPE_CHECKING:
    from .parser import Parser


RULES = (
    Rule(
        "deployed-differs",
        "A copy is not the compiled one (in the forms for programs).",
        "`rosorin-compile deploy`",
        Heading.PACKAGES,
    ),
)

_HOW = "rosorin-compile check deployed ROBOT FOLDER"


def options(command: Parser) -> None:
    """Add what this check takes."""
    command.add_check_options(
        "ROBOT FOLDER", "the robot, required if there are several, and a package, install space or folder"
    )
    command.add_argument("--full", action="store_true", help="print differences of texts in full")


def run(options: argparse.Namespace) -> int:
    """Compare the copies in a folder with what robots are compiled to."""
    names = Run.of(options).words
    if not names:
        raise WrongUsage(f"there is no folder to look into: {_HOW}")
    folder = names[-1]
    options.words = [word for word in options.words if word != folder] + names[:-1].count(folder) * [folder]
    try:
        next(Path(folder).iterdir(), None)
    except (FileNotFoundError, NotADirectoryError):
        raise WrongUsage(f'there is no folder "{folder}"') from None
    except PermissionError:
        pass  # and that is told of the robot
    return for_each(options, partial(_check, folder=Path(folder)), alone=_HOW)


def _check(run: Run, description: Description, folder: Path) -> int:
    """Compare the copies of one robot with what it is compiled to."""
    compiled = run.compiled(description)
    if compiled is None or compiled.robot is None:
        return PROBLEMS
    try:
        files = files_below(folder, skip_built=False)
        told = naming.read(folder, compiled.robot.name)
        checked = check(
            compiled.robot,
            compiled.artifacts,
            folder,
            files,
            told,
            run.options.full,
            lambda options: described(compiled, description, run.given, options)[0],
        )
    except LoadError as problem:
        run.console.show([problem.diagnostic])
        return PROBLEMS
    except OSError as problem:
        message = f"cannot read {folder}: {problem.strerror or problem}"
        run.console.show([error("deploy-unreadable", message, None, "name another folder")])
        return PROBLEMS
    return _said(run, description, checked, folder)


def _said(run: Run, description: Description, checked: Checked, folder: Path) -> int:
    """Say what became of a comparison with copies, and return the exit code."""
    if checked.differing:
        help = "rosorin-compile deploy writes them anew"
        told = error("deployed-differs", "\n".join(checked.lines), None, help)
        compared, others = checked.compared()
        run.console.differ("not as deployed", checked.lines, told, lambda: compared.blocks(others))
    run.console.show(checked.diagnostics)
    total = len(checked.same) + len(checked.differing)
    run.console.say(f"{description.name}: {len(checked.same)} of {total} copies in {folder} as compiled")
    return PROBLEMS if checked.differing or has_errors(checked.diagnostics) else FINE
