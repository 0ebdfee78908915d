"""rosorin-compile check: compile each robot and compare with what is committed."""

from __future__ import annotations

import argparse

from ..project import Description
from .shared import (
    FINE,
    PROBLEMS,
    Run,
    compile_one,
    count,
    for_each,
    format_options,
    nothing_written,
    output_options,
    robot_options,
)


def options(command: argparse.ArgumentParser) -> None:
    """Add what this command takes."""
    robot_options(command)
    output_options(command)
    format_options(command)
    command.add_argument("--full", action="store_true", help="show text differences in full")


def run(options: argparse.Namespace) -> int:
    """Compile each robot and compare with what is committed."""
    return for_each(options, check_one)


def check_one(run: Run, description: Description) -> int:
    """Compile one robot in memory and compare with its outputs folder."""
    from ..compare import agreement, compare, lines
    from ..diagnostic import error, has_errors
    from ..output import OutputError, read_set

    compiled = compile_one(run.given, description)
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
