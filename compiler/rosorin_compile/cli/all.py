"""rosorin-compile all: compile each robot and write its artifacts."""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from rosorin_compile.language.arguments import UNKNOWN
from rosorin_compile.source.diagnostics import RequestError, has_errors
from rosorin_compile.source.project import Description

from . import command as cli
from .answer import FINE, PROBLEMS, USAGE
from .depfile import check_depfile, write_depfile
from .run import Run, count, counted_files, for_each, nothing_written, refuse_stdin

if TYPE_CHECKING:
    from rosorin_compile.results import Written


@cli.command("all", exits="0 written or unchanged, 1 a robot has errors or, with --dry-run, an artifact would change")
@cli.robots_argument()
@cli.dry_run_option
@cli.flag("--prune", help="delete files in the output folder that are not artifacts")
@cli.hook_option("; exit with 1 if a file was written")
@cli.texts(
    "--only", type=cli.PATH, metavar="OUTPUT", help="write only this output and its meshes; repeatable", offers="output"
)
@cli.output_folder_option
@cli.depfile_options("default: the first artifact, or that of the first --only")
@cli.notes_option
@cli.fail_on_option
def run(options: cli.Options) -> int:
    """Compile each robot and write its artifacts."""
    refuse_stdin(options.words, "name a file, or print one artifact: rosorin-compile print - OUTPUT")
    if options.only and (options.prune or options.dry_run):
        other = "--prune" if options.prune else "--dry-run"
        raise RequestError(f"--only does not go with {other}, which is about all artifacts of a robot")
    if options.depfile is not None and options.dry_run:
        raise RequestError("--depfile does not go with --dry-run, which writes nothing")
    check_depfile(options)
    if options.dry_run:
        from .check import check_robot

        return for_each(options, check_robot)
    return for_each(options, _write)


def _write(run: Run, description: Description) -> int:
    """Compile one robot and write its artifacts."""
    from rosorin_compile import api

    options, console, name = run.options, run.console, description.name
    request = run.request(description)
    result = api.write(request, prune=options.prune, only=options.only)
    compiled = result.compiled
    console.tell_read(request.inputs(compiled))
    kept = [one for one in result.diagnostics if one.rule == "not-an-artifact"]
    console.show([one for one in result.diagnostics if one not in kept])
    console.show(kept, listed=True)  # check fails for these
    if not compiled.artifacts:
        unknown = any(one.rule == UNKNOWN for one in compiled.diagnostics)
        return max(nothing_written(console, name, compiled.diagnostics), USAGE if unknown else FINE)
    failed = has_errors(result.diagnostics)
    if failed and not (result.written or result.unchanged):
        return PROBLEMS
    names = {"written": result.written, "unchanged": result.unchanged, "removed": result.removed}
    run.add_to_result({"folder": str(result.folder), **{key: list(files) for key, files in names.items()}})
    files = [artifact.file for artifact in compiled.artifacts]
    meshes = [file for file in (*result.written, *result.unchanged) if file not in files]
    console.say(f"{name}: {count(files, meshes)} in {result.folder}, {_changes(result, meshes)}")
    if options.depfile is not None:
        # A mesh that was read in the folder of the artifacts is an input, too, and keeps its time.
        read = {os.path.realpath(file) for file in request.inputs(compiled)}
        made = [description.outputs / file for file in (*files, *meshes)]
        newer = [file for file in made if os.path.realpath(file) not in read]
        watched = request.watched(compiled, [*made, Path(options.depfile)])
        code = write_depfile(run, options.depfile_target or str(made[0]), watched, made, newer)
        return PROBLEMS if failed else code
    return PROBLEMS if failed or (options.hook and (result.written or result.removed)) else FINE


def _changes(result: Written, meshes: Sequence[str]) -> str:
    """Return in words what writing a set of artifacts changed; meshes are counted."""
    if not result.written and not result.removed:
        return "unchanged"
    names = [name for name in result.written if name not in meshes]
    names += counted_files([name for name in result.written if name in meshes])
    parts = [f"written: {', '.join(names)}"] if names else []
    parts += [f"removed: {', '.join(result.removed)}"] if result.removed else []
    return "; ".join(parts)
