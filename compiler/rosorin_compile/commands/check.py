"""rosorin-compile check: compile each robot and compare with what is committed."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

from ..project import Description
from ..registry import PACKAGES, WRITING, Rule
from .shared import (
    FINE,
    PROBLEMS,
    Run,
    WrongUsage,
    compile_one,
    count,
    for_each,
    format_options,
    given_arguments,
    nothing_written,
    output_options,
    robot_options,
)
from .single import one

if TYPE_CHECKING:
    from ..packaging.checking import Checked

RULES = (
    Rule(
        "outputs-differ",
        "The committed artifacts are not those of the description (in the forms for programs).",
        "`rosorin-compile all`, if that is what you meant.",
        WRITING,
    ),
    Rule(
        "deployed-differs",
        "A copy is not the compiled one (in the forms for programs).",
        "`rosorin-compile deploy`",
        PACKAGES,
    ),
)


def options(command: argparse.ArgumentParser) -> None:
    """Add what this command takes."""
    robot_options(command)
    command.add_argument(
        "--deployed", metavar="FOLDER", help="compare with the copies in a package, an install space or any folder"
    )
    command.add_argument(
        "--every-argument",
        action="store_true",
        help="compile with every combination of the arguments that have a list of values; nothing is compared",
    )
    command.add_argument("--full", action="store_true", help="show text differences in full")
    output_options(command)
    format_options(command)


def run(options: argparse.Namespace) -> int:
    """Compile each robot and compare with what is committed."""
    if options.every_argument:
        if options.deployed is not None:
            raise WrongUsage("--every-argument and --deployed do not go together")
        from .every_argument import check_every

        return for_each(options, check_every)
    if options.deployed is None:
        return for_each(options, check_one)
    if not Path(options.deployed).is_dir():
        raise WrongUsage(f'there is no folder "{options.deployed}"')
    names = given_arguments(options, options.words)[1]
    if not names:
        one("", "rosorin-compile check ROBOT --deployed FOLDER")
    return for_each(options, _check_deployed)


def check_one(run: Run, description: Description) -> int:
    """Compile one robot in memory and compare with its outputs folder."""
    from ..compare import agreement, compare, lines
    from ..diagnostic import error, has_errors
    from ..output import OutputError, read_set

    compiled = compile_one(run.given, description, run.console)
    run.console.show(compiled.diagnostics)
    if compiled.robot is None or has_errors(compiled.diagnostics):
        return nothing_written(run.console, description.name, compiled.diagnostics)
    try:
        committed = read_set(description.outputs)
    except OutputError as problem:
        run.console.show([problem.diagnostic])
        return PROBLEMS
    disagreements = agreement(compiled.robot, compiled.artifacts)
    run.console.show(disagreements)
    comparison = compare(compiled.robot, compiled.artifacts, committed)
    differences = lines(comparison, full=getattr(run.options, "full", False))
    if run.console.for_people:
        for line in differences:
            print(line)
    elif differences:
        help = "rosorin-compile all writes them anew"
        run.console.show([error("outputs-differ", "\n".join(differences), None, help)])
    if not comparison.same or disagreements:
        return PROBLEMS
    run.console.say(f"{description.name}: {count(compiled.artifacts)} as committed in {description.outputs}")
    return FINE


def _check_deployed(run: Run, description: Description) -> int:
    """Compile one robot in memory and compare with the copies that are deployed in a folder."""
    from ..diagnostic import error, has_errors
    from ..load import LoadError
    from ..packaging import mapping
    from ..packaging.checking import check
    from ..packaging.finding import files_below

    compiled = compile_one(run.given, description, run.console)
    run.console.show(compiled.diagnostics)
    if compiled.robot is None or has_errors(compiled.diagnostics):
        return nothing_written(run.console, description.name, compiled.diagnostics)
    folder = Path(run.options.deployed)
    try:
        files = files_below(folder, skip_built=False)
        told = mapping.read(folder, compiled.robot.name)
        checked = check(compiled.robot, compiled.artifacts, folder, files, told, run.options.full)
    except LoadError as problem:
        run.console.show([problem.diagnostic])
        return PROBLEMS
    except OSError as problem:
        message = f"cannot read {folder}: {problem.strerror or problem}"
        run.console.show([error("deploy-unreadable", message, None, "name another folder")])
        return PROBLEMS
    return _said(run, description, checked)


def _said(run: Run, description: Description, checked: Checked) -> int:
    """Say what became of a comparison with copies, and return the exit code."""
    from ..diagnostic import error, has_errors

    if run.console.for_people:
        for line in checked.lines:
            print(line)
    elif checked.differing:
        help = "rosorin-compile deploy writes them anew"
        run.console.show([error("deployed-differs", "\n".join(checked.lines), None, help)])
    run.console.show(checked.diagnostics)
    total = len(checked.same) + len(checked.differing)
    run.console.say(f"{description.name}: {len(checked.same)} of {total} copies in {run.options.deployed} as compiled")
    return PROBLEMS if checked.differing or has_errors(checked.diagnostics) else FINE
