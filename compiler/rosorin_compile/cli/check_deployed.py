"""rosorin-compile check deployed: compare what robots are compiled to with the copies in a folder."""

from __future__ import annotations

from contextlib import suppress
from functools import partial
from pathlib import Path

from rosorin_compile.compare.text_report import blocks
from rosorin_compile.source.diagnostics import error, has_errors
from rosorin_compile.source.project import Description

from .command import Options, check, option
from .options import check_options
from .run import Run, for_each, nothing_written
from .usage import FINE, PROBLEMS, WrongUsage

_HOW = "rosorin-compile check deployed ROBOT FOLDER"


@check("deployed", exits="0 no differences, 1 differences or errors")
@check_options("[ROBOT] FOLDER", "the robot, required if there are several, and a package, install space or folder")
@option("--full", is_flag=True, help="print differences of texts in full")
def run(options: Options) -> int:
    """Compare the copies in a folder with what robots are compiled to."""
    names = Run.of(options).words
    if not names:
        raise WrongUsage(f"there is no folder to look into: {_HOW}")
    folder = names[-1]
    options.words = [word for word in options.words if word != folder] + names[:-1].count(folder) * [folder]
    with suppress(PermissionError):  # reported as an error of the robot
        if not Path(folder).is_dir():
            raise WrongUsage(f'there is no folder "{folder}"')
    return for_each(options, partial(_check, folder=folder), alone=_HOW)


def _check(run: Run, description: Description, folder: str) -> int:
    """Compare the copies of one robot with what it is compiled to, and print how they differ."""
    from rosorin_compile.api import check_deployed

    result = check_deployed(run.request(description), folder, full=run.options.full)
    console = run.console
    console.tell_read(result.inputs)
    if result.differing:
        told = error("deployed-differs", "\n".join(result.lines), None, "rosorin-compile deploy writes them anew")
        compared, others = result.compared()
        table = blocks(compared.changes, compared.texts, others)
        console.differ("not as deployed", result.lines, told, lambda: table)
    console.show(result.diagnostics)
    if not result.robot:
        nothing_written(run.console, description.name, result.diagnostics)
        return PROBLEMS
    total = len(result.same) + len(result.differing)
    console.say(f"{description.name}: {len(result.same)} of {total} copies in {folder} as compiled")
    return PROBLEMS if result.differing or has_errors(result.diagnostics) else FINE
