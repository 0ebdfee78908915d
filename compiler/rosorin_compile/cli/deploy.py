"""rosorin-compile deploy: write the artifacts into a ROS 2 package that exists."""

from rosorin_compile import api
from rosorin_compile.source.diagnostics import NOTE, Diagnostic

from . import command as cli
from .console import PROBLEMS
from .run import Run


@cli.command("deploy", exits="0 written or unchanged, 1 errors or, with --dry-run, a file would change")
@cli.robot_argument
@cli.option("-o", "--output FOLDER", required=True, help="existing package or folder")
@cli.repeatable(
    "--map OUTPUT=PLACE",
    "places",
    help="path of an output in FOLDER, such as urdf=urdf/robot.urdf, or none to skip it; stored in FOLDER",
    offers="output=",
)
@cli.dry_run_option
@cli.full_option
@cli.robot_options
def run(options: cli.Options) -> int:
    """Deploy the artifacts of a robot, and print the changes."""
    run, description = Run.alone(options, stdin=False)
    console = run.console
    console.begin(description.name)
    result = api.deploy(run.request(description), options.output, **options.pick("places dry_run full"))
    console.print_read(result.inputs)
    failed = run.show(result)
    if not result.robot:
        run.nothing_written(description, result.diagnostics)
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
    code = run.give(result)
    return PROBLEMS if failed or (options.dry_run and same < total) else code
