"""rosorin-compile check deployed: compare what robots are compiled to with the copies in a folder."""

from contextlib import suppress
from pathlib import Path

from rosorin_compile.ros.package.checking import check_deployed
from rosorin_compile.source.diagnostics import RequestError, error
from rosorin_compile.source.project import Description

from .command import Options, check, check_options, full_option
from .console import FINE, PROBLEMS
from .markdown import blocks
from .run import Run, for_each

_USAGE = "ROBOT FOLDER"


@check("deployed", exits="0 no differences, 1 differences or errors")
@check_options("[ROBOT] FOLDER", "the robot, required if there are several, and a package, install space or folder")
@full_option
def run(options: Options) -> int:
    """Compare the copies in a folder with what robots are compiled to."""
    names = Run.of(options).words
    if not names:
        raise RequestError(f"there is no folder to look into: rosorin-compile check deployed {_USAGE}")
    folder = names[-1]
    with suppress(PermissionError):  # reported as an error of the robot
        if not Path(folder).is_dir():
            raise RequestError(f'there is no folder "{folder}"')

    def check_robot(run: Run, description: Description) -> int:
        result = check_deployed(run.request(description), folder, full=options.full)
        console = run.console
        console.print_read(result.inputs)
        if result.differing:
            help = "run rosorin-compile deploy to write them again"
            compared, others = result.compared()
            tables = blocks(compared.changes, compared.texts, others)
            found = error("deployed-differs", "\n".join(result.lines), None, help)
            console.differ("not as deployed", result.lines, found, lambda: tables)
        failed = run.show(result)
        if not result.robot:
            run.nothing_written(description, result.diagnostics)
            return PROBLEMS
        total = len(result.same) + len(result.differing)
        console.say(f"{description.name}: {len(result.same)} of {total} copies in {folder} as compiled")
        return PROBLEMS if result.differing or failed else FINE

    return for_each(options, check_robot, _USAGE, names[:-1])
