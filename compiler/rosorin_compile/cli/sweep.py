"""rosorin-compile sweep: compile one description for a list of variants, each into a folder of its own."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING

from rosorin_compile import api
from rosorin_compile.source.diagnostics import Console, and_more, counted
from rosorin_compile.variants.writing import MAX_FAILED

from .answer import give_result
from .run import Run
from .usage import FINE, PROBLEMS

if TYPE_CHECKING:
    from rosorin_compile.variants.writing import WrittenVariants

    from .parser import Parser


def options(command: Parser) -> None:
    """Add the options of the command."""
    over = "variants: a CSV file with a row for each, a YAML list, or a folder with a file of arguments for each"
    whole = "with a folder: argument to set to the content of each file, or to its path if it is a text"
    command.add_robot()
    command.add_argument("--over", required=True, type="path", metavar="LIST", completes="FILE", help=over)
    command.add_argument("-o", "--output", required=True, type="path", metavar="FOLDER", help="a folder per variant")
    command.add_argument("-j", "--jobs", type=int, metavar="NUMBER", help="number of processes; default: one per core")
    command.add_argument("--as", default="", dest="whole", metavar="ARGUMENT", help=whole)
    command.add_argument("--dask", metavar="ADDRESS", help="address of a Dask scheduler, such as tcp://HOST:8786")
    command.add_argument("--prune", action="store_true", help="delete variants that are no longer in the list")
    command.add_messages()
    command.add_given()


def run(options: argparse.Namespace) -> int:
    """Compile the variants of a list; return the exit code."""
    how = "rosorin-compile sweep ROBOT --over FILE -o FOLDER"
    run, description = Run.alone(options, "a sweep is of one robot", how, "name a file")
    console, code = run.console, PROBLEMS
    console.begin(description.name)
    try:
        result = api.write_sweep(
            run.request(description),
            options.over,
            options.output,
            jobs=options.jobs,
            whole=options.whole,
            dask=options.dask or "",
            prune=options.prune,
            report=lambda diagnostic: console.show([diagnostic]),
        )
    except KeyboardInterrupt as stop:
        if stop.args:
            console.warn(f"stopped: {stop.args[0]}; the same command continues from there")
        raise
    if result.complete:
        _show(result, console)
        give_result(options, result, str)
        code = PROBLEMS if result.error else FINE
    elif not result.made + result.unchanged + result.error:
        console.warn(f"{options.over}: {counted(len(result.diagnostics), 'error')}, nothing written")
    console.end(code != FINE)
    console.finish()
    return code


def _show(result: WrittenVariants, console: Console) -> None:
    if result.removed:
        shown = ", ".join(result.removed[:5]) + and_more(len(result.removed[5:]))
        console.say(f"{counted(len(result.removed), 'variant')} removed: {shown}")
    if result.error > MAX_FAILED:
        console.warn(f"{result.error - MAX_FAILED} more variants with errors: see sweep.json")
    for status, count in (("made", result.made), ("unchanged", result.unchanged), ("errors", result.error)):
        console.say(f"{status:<9} {count:>10,}")
