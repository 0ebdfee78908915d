"""rosorin-compile init: create a new description, which compiles as it is, with the schema for editors."""

from collections.abc import Iterator
from pathlib import Path

import click

from rosorin_compile.importing.new_robot import DEFAULT, TEMPLATES, NewRobot, check_free, init
from rosorin_compile.source.diagnostics import error

from .command import argument, command, option
from .console import PROBLEMS
from .run import Run

_TEMPLATE = f"one of {', '.join(TEMPLATES)}; default: {DEFAULT}"


@command("init", exits="0 written, 1 the folder cannot be written")
@argument("name", metavar="NAME", help="name of the robot: letters, digits and underscores")
@argument("template", default=DEFAULT, type=click.Choice([*TEMPLATES]), metavar="[TEMPLATE]", help=_TEMPLATE)
@option("-o", "--output FOLDER", default=".", help="folder of the project")
def run_init(run: Run) -> int:
    """Write a new description, and print the next step."""
    try:
        check_free(run.name, Path(run.output))
        new = init(run.name, run.template, run.output)
    except OSError as problem:
        message = f"cannot write in {run.output}: {problem.strerror or problem}"
        run.console.show([error("output-folder", message, None, "name another folder")])
        return PROBLEMS
    return run.give(new, lambda: "\n".join(_lines(run, new)))


def _lines(run: Run, new: NewRobot) -> Iterator[str]:
    yield f"{new.description} written: {TEMPLATES[new.template].what}"
    if new.schema_written:
        yield f"{new.schema} written: completion and help in editors"
    elif new.schema_outdated:
        yield f"{new.schema} is of another version; to renew it: rosorin-compile schema > {new.schema}"
    where = "" if Path(run.output).samefile(".") else f"cd {run.output} && "
    yield f"next: {where}rosorin-compile all {run.name}, and rosorin-compile view {run.name} to see it"
