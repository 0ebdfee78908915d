"""rosorin-compile sweep: compile one description for a list of variants, each to a separate folder."""

from rosorin_compile.source.diagnostics import and_more, count_of
from rosorin_compile.variants.sweep import MAX_FAILED, write_sweep

from .command import PATH, command, flag, option, robot_argument, robot_options
from .console import FINE, PROBLEMS
from .run import Run

_OVER = "variants: a CSV file with a row for each, a YAML list, or a folder with a file of arguments for each"
_AS = "with a folder: argument to set to the content of each file, or to its path if it is a text"


@command("sweep", exits="0 all variants written or unchanged, 1 a variant has errors or cannot be written")
@robot_argument
@option("--over LIST", type=PATH, required=True, help=_OVER)
@option("-o", "--output FOLDER", required=True, help="a folder per variant")
@option("-j", "--jobs NUMBER", type=int, help="number of processes; default: one per core")
@option("--as ARGUMENT", "whole", default="", help=_AS)
@option("--dask ADDRESS", default="", help="address of a Dask scheduler, such as tcp://HOST:8786")
@flag("--prune", help="delete variants that are no longer in the list")
@robot_options
def run_sweep(run: Run) -> int:
    """Compile the variants of a list; return the exit code."""
    description = run.only_robot(stdin=False)
    console, code = run.console, PROBLEMS
    console.begin(description.name)
    try:
        result = write_sweep(
            run.request(description),
            run.over,
            run.output,
            **run.pick("jobs whole dask prune"),
            report=lambda diagnostic: console.show([diagnostic]),
        )
    except KeyboardInterrupt as stop:
        if stop.args:
            console.warn(f"stopped: {stop.args[0]}; the same command continues from there")
        raise
    if result.complete:
        if result.removed:
            shown = ", ".join(result.removed[:5]) + and_more(len(result.removed[5:]))
            console.say(f"{count_of(len(result.removed), 'variant')} removed: {shown}")
        if result.error > MAX_FAILED:
            console.warn(f"{result.error - MAX_FAILED} more variants with errors: see sweep.json")
        for status, count in (("made", result.made), ("unchanged", result.unchanged), ("errors", result.error)):
            console.say(f"{status:<9} {count:>10,}")
        run.give(result)
        code = PROBLEMS if result.error else FINE
    elif not result.made + result.unchanged + result.error:
        console.warn(f"{run.over}: {count_of(len(result.diagnostics), 'error')}, nothing written")
    console.end(code != FINE)
    return code
