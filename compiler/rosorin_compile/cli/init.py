"""rosorin-compile init: start a new robot, which compiles as it is and has the editors' schema beside it."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

import click

from rosorin_compile.importing.new_robot import DEFAULT, TEMPLATES, check_free
from rosorin_compile.source.diagnostics import error

from .answer import answer_of, give_result
from .command import Options, argument, command, option
from .options import PATH
from .usage import FINE, PROBLEMS, WrongUsage

if TYPE_CHECKING:
    from rosorin_compile.importing.new_robot import NewRobot


@command("init", exits="0 written, 1 the folder cannot be written")
@argument("name", metavar="NAME", help="name of the robot: letters, digits and underscores")
@argument(
    "template",
    required=False,
    type=click.Choice([*TEMPLATES]),
    metavar="[TEMPLATE]",
    help=f"one of {', '.join(TEMPLATES)}; default: prompt in a terminal, else {DEFAULT}",
)
@option("-o", "--output", default=".", type=PATH, metavar="FOLDER", help="folder of the project; default: .")
def run(options: Options) -> int:
    """Write a new description, and print the next step."""
    from rosorin_compile import api

    for_people = options.format == "text"
    try:
        check_free(options.name, Path(options.output))
        template = options.template or (_ask() if for_people else DEFAULT)
        new = api.init(options.name, template, options.output)
    except OSError as problem:
        message = f"cannot write in {options.output}: {problem.strerror or problem}"
        if for_people:
            sys.stderr.write(f"{message}\n")
        else:
            answer_of(options).console().show([error("output-folder", message, None, "name another folder")])
        return PROBLEMS
    give_result(options, new, lambda: "\n".join(_lines(options, new)))
    return FINE


def _lines(options: Options, new: NewRobot) -> Iterator[str]:
    """Yield what was written, and the next step, as lines."""
    yield f"{new.description} written: {TEMPLATES[new.template].what}"
    if new.schema_written:
        yield f"{new.schema} written: completion and help in editors"
    elif new.schema_outdated:
        yield f"{new.schema} is of another version; to renew it: rosorin-compile schema > {new.schema}"
    where = "" if Path(options.output).samefile(".") else f"cd {options.output} && "
    yield f"next: {where}rosorin-compile all {options.name}, and rosorin-compile view {options.name} to see it"


def _ask() -> str:
    """Return the template that whoever sits at a terminal wants; without one the default. Raises WrongUsage."""
    if sys.stdin is None or not (sys.stdin.isatty() and sys.stdout.isatty()):
        return DEFAULT
    width = max(map(len, TEMPLATES))
    for name, template in TEMPLATES.items():
        print(f"  {name:{width}}  {template.what}")
    print(f"which one? [{DEFAULT}] ", end="", flush=True)
    answer = sys.stdin.readline().strip() or DEFAULT
    begun = [name for name in TEMPLATES if name.startswith(answer)]
    if len(begun) != 1:
        raise WrongUsage(f'there is no template "{answer}"; take one of {", ".join(TEMPLATES)}')
    return begun[0]
