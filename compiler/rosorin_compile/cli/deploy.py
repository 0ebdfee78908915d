"""rosorin-compile deploy: write the artifacts into a ROS 2 package that exists."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rosorin_compile.source.diagnostics import NOTE, Diagnostic, has_errors

from . import complete
from .answer import give_result
from .command import Options, command, option
from .options import PATH, robot_argument, robot_options
from .run import Run, nothing_written
from .usage import FINE, PROBLEMS, WrongUsage

if TYPE_CHECKING:
    from rosorin_compile.ros.package.deploy import Deployed


_HOW = "rosorin-compile deploy ROBOT -o FOLDER"


@command("deploy", exits="0 written or unchanged, 1 errors or, with --dry-run, a file would change")
@robot_argument
@option("-o", "--output", type=PATH, metavar="FOLDER", help="existing package or folder")
@option(
    "--map",
    multiple=True,
    metavar="OUTPUT=PLACE",
    help="path of an output in FOLDER, or none to skip it; stored in FOLDER",
    shell_complete=complete.of("output="),
)
@option("--install", type=PATH, metavar="FOLDER", help="install space; default: the one of the workspace, if any")
@option("-n", "--dry-run", is_flag=True, help="write nothing; print what would change")
@option("--full", is_flag=True, help="print differences of texts in full")
@robot_options
def run(options: Options) -> int:
    """Deploy the artifacts of a robot, and print what became of them."""
    from rosorin_compile.api import deploy

    if options.output is None:
        raise WrongUsage(f"deploy into which folder? {_HOW}")
    run, description = Run.alone(options, "one robot is deployed at a time", _HOW, "name a file")
    console = run.console
    console.begin(description.name)
    result = deploy(
        run.request(description),
        options.output,
        places=_places(options.map),
        install=options.install,
        dry_run=options.dry_run,
        full=options.full,
    )
    console.tell_read(result.inputs)
    console.show(result.diagnostics)
    if not result.robot:
        nothing_written(run.console, description.name, result.diagnostics)
    elif console.for_people:
        for line in result.changes:
            print(line)
    elif result.changes:
        console.show([Diagnostic("deploy-changes", NOTE, "\n".join(result.changes))])
    if result.robot:
        console.say(_summary(result))
        give_result(options, result, str)
    console.finish()
    changes = options.dry_run and not all(copy.same for copy in result.copies)
    return PROBLEMS if changes or has_errors(result.diagnostics) or not result.robot else FINE


def _summary(result: Deployed) -> str:
    """Return how many files are written, in a line."""
    same, total = sum(copy.same for copy in result.copies), len(result.copies)
    changed = f"{result.robot}: {total - same} of {total} files in {result.folder}"
    if not result.written:
        return f"{changed} would be written"
    every = f"all {same} files" if same > 1 else "the one file" if same else "no file"
    return f"{changed} written" if same < total else f"{result.robot}: {every} as compiled"


def _places(texts: list[str]) -> dict[str, str]:
    """Return the places of outputs. Raises WrongUsage."""
    found = {}
    for text in texts:
        output, equals, place = text.partition("=")
        if not equals or not place:
            raise WrongUsage(f'"{text}" is not OUTPUT=PLACE, such as urdf=urdf/robot.urdf')
        found[output] = place
    return found
