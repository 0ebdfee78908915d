"""rosorin-compile all: compile each robot and write its artifacts."""

import os

from rosorin_compile import api
from rosorin_compile.language.arguments import UNKNOWN
from rosorin_compile.source.diagnostics import has_errors
from rosorin_compile.source.project import Description

from . import command as cli
from .console import FINE, PROBLEMS, USAGE
from .run import Run, count, counted_files, for_each, refuse_stdin, write_depfile

_ONLY = "write only this output and its meshes; repeatable"


@cli.command("all", exits="0 written or unchanged, 1 a robot has errors or, with --dry-run, an artifact would change")
@cli.robots_argument()
@cli.dry_run_option
@cli.flag("--prune", help="delete files in the output folder that are not artifacts")
@cli.hook_option("; exit with 1 if a file was written")
@cli.repeatable("--only OUTPUT", type=cli.PATH, help=_ONLY, offers="output", excludes="prune dry_run")
@cli.output_folder_option
@cli.depfile_options("default: the first artifact, or that of the first --only")
@cli.notes_option
@cli.fail_on_option
def run_all(run: Run) -> int:
    """Compile each robot and write its artifacts."""
    refuse_stdin(run.words, "name a file, or print one artifact: rosorin-compile print - OUTPUT")
    if run.dry_run:
        from .check import check_robot

        return for_each(run, check_robot)
    return for_each(run, _write)


def _write(run: Run, description: Description) -> int:
    console, request = run.console, run.request(description)
    result = api.write(request, prune=run.prune, only=run.only)
    compiled = result.compiled
    inputs = request.inputs(compiled)
    console.print_read(inputs)
    for is_kept in (False, True):  # ``check`` fails for files that are not artifacts
        console.show([d for d in result.diagnostics if (d.rule == "not-an-artifact") == is_kept], listed=is_kept)
    if not compiled.artifacts:
        unknown = any(one.rule == UNKNOWN for one in compiled.diagnostics)
        return max(run.nothing_written(description, compiled.diagnostics), USAGE if unknown else FINE)
    failed = has_errors(result.diagnostics)
    if failed and not (result.written or result.unchanged):
        return PROBLEMS
    console.robots[-1] |= {name: getattr(result, name) for name in ("folder", "written", "unchanged", "removed")}
    files = [artifact.file for artifact in compiled.artifacts]
    meshes = [file for file in (*result.written, *result.unchanged) if file not in files]
    written = [name for name in result.written if name in files]
    written += counted_files([name for name in result.written if name in meshes])
    changes = {"written": written, "removed": result.removed}
    done = "; ".join(f"{word}: {', '.join(names)}" for word, names in changes.items() if names) or "unchanged"
    console.say(f"{description.name}: {count(files, meshes)} in {result.folder}, {done}")
    if run.depfile is not None:
        # A mesh in the folder of the artifacts is also an input if it was read: do not touch it.
        read = {os.path.realpath(file) for file in inputs}
        made = [description.outputs / file for file in (*files, *meshes)]
        newer = [file for file in made if os.path.realpath(file) not in read]
        write_depfile(run, run.depfile_target or str(made[0]), compiled, inputs, made, newer)
    return PROBLEMS if failed or (run.hook and (result.written or result.removed)) else FINE
