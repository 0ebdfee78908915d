"""rosorin-compile deploy: write the artifacts into a ROS 2 package that exists."""

from __future__ import annotations

from rosorin_compile.source.diagnostics import NOTE, Diagnostic, RequestError

from .answer import FINE, PROBLEMS
from .command import Options, command, dry_run_option, full_option, path_option, robot_argument, robot_options, texts
from .run import Run, assignments, nothing_written

_HOW = "rosorin-compile deploy ROBOT -o FOLDER"


@command("deploy", exits="0 written or unchanged, 1 errors or, with --dry-run, a file would change")
@robot_argument
@path_option("-o", "--output", metavar="FOLDER", help="existing package or folder")
@texts(
    "--map",
    metavar="OUTPUT=PLACE",
    help="path of an output in FOLDER, or none to skip it; stored in FOLDER",
    offers="output=",
)
@path_option("--install", metavar="FOLDER", help="install space; default: the one of the workspace, if any")
@dry_run_option
@full_option
@robot_options
def run(options: Options) -> int:
    """Deploy the artifacts of a robot, and print the changes."""
    from rosorin_compile import api

    if options.output is None:
        raise RequestError(f"deploy into which folder? {_HOW}")
    run, description = Run.alone(options, "one robot is deployed at a time", _HOW, "name a file")
    console = run.console
    console.begin(description.name)
    places = assignments(options.map, "OUTPUT=PLACE, such as urdf=urdf/robot.urdf")
    settings = options.pick("install dry_run full")
    result = api.deploy(run.request(description), options.output, places=places, **settings)
    console.tell_read(result.inputs)
    failed = run.show(result)
    if not result.robot:
        nothing_written(console, description.name, result.diagnostics)
        console.finish()
        return PROBLEMS
    if console.for_people:
        for line in result.changes:
            print(line)
    elif result.changes:
        console.show([Diagnostic("deploy-changes", NOTE, "\n".join(result.changes))])
    same, total = sum(copy.same for copy in result.copies), len(result.copies)
    changed = f"{total - same} of {total} files in {result.folder}"
    if not result.written:
        console.say(f"{result.robot}: {changed} would be written")
    elif same < total:
        console.say(f"{result.robot}: {changed} written")
    else:
        every = f"all {same} files" if same > 1 else "the one file" if same else "no file"
        console.say(f"{result.robot}: {every} as compiled")
    run.give(result)
    console.finish()
    return PROBLEMS if failed or (options.dry_run and same < total) else FINE
