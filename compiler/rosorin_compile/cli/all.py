"""rosorin-compile all: compile each robot and write its artifacts."""

from __future__ import annotations

import os
from collections.abc import Collection, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from rosorin_compile.language.wanted import UNKNOWN
from rosorin_compile.source.diagnostics import has_errors
from rosorin_compile.source.project import Description

from . import complete
from .command import Options, command, option
from .options import (
    PATH,
    depfile_options,
    fail_on_option,
    hook_option,
    notes_option,
    output_folder_option,
    robots_argument,
)
from .robots import check_depfile, no_stdin
from .run import Run, count, counted_files, for_each, nothing_written, write_depfile
from .usage import FINE, PROBLEMS, USAGE, WrongUsage

if TYPE_CHECKING:
    from rosorin_compile.formats.compiled import Compiled
    from rosorin_compile.request import Request
    from rosorin_compile.results import Written


@command("all", exits="0 written or unchanged, 1 a robot has errors or, with --dry-run, an artifact would change")
@robots_argument()
@option("-n", "--dry-run", is_flag=True, help="write nothing; print what would change")
@option("--prune", is_flag=True, help="delete files in the output folder that are not artifacts")
@hook_option("; exit with 1 if a file was written")
@option(
    "--only",
    multiple=True,
    type=PATH,
    metavar="OUTPUT",
    help="write only this output and its meshes; repeatable",
    shell_complete=complete.of("output"),
)
@output_folder_option
@depfile_options("default: the first artifact, or that of the first --only")
@notes_option
@fail_on_option
def run(options: Options) -> int:
    """Compile each robot and write its artifacts."""
    _check_options(options)
    each = _write_one
    if options.dry_run:
        from .check import check_one as each
    return for_each(options, each)


def _check_options(options: Options) -> None:
    """Raise WrongUsage for options that do not go together."""
    no_stdin(options.words, "name a file, or print one artifact: rosorin-compile print - OUTPUT")
    if options.only and (options.prune or options.dry_run):
        other = "--prune" if options.prune else "--dry-run"
        raise WrongUsage(f"--only does not go with {other}, which is about all artifacts of a robot")
    if options.depfile is not None and options.dry_run:
        raise WrongUsage("--depfile does not go with --dry-run, which writes nothing")
    check_depfile(options)


def _write_one(run: Run, description: Description) -> int:
    """Compile one robot and write its artifacts."""
    from rosorin_compile import api

    options, console, name = run.options, run.console, description.name
    request = run.request(description)
    done = api.write(request, prune=options.prune, only=options.only)
    compiled = done.compiled
    console.tell_read(request.inputs(compiled))
    foreign = [one for one in done.diagnostics if one.rule == "not-an-artifact"]
    console.show([one for one in done.diagnostics if one.rule != "not-an-artifact"])
    console.show(foreign, listed=True)  # check fails for these
    if not compiled.artifacts:
        unknown = any(one.rule == UNKNOWN for one in compiled.diagnostics)
        return max(nothing_written(console, name, compiled.diagnostics), USAGE if unknown else FINE)
    if has_errors(done.diagnostics):
        return PROBLEMS
    names = {"written": done.written, "unchanged": done.unchanged, "removed": done.removed}
    run.tell_of_robot({"folder": str(done.folder), **{key: list(files) for key, files in names.items()}})
    files = [artifact.file for artifact in compiled.artifacts]
    meshes = [file for file in (*done.written, *done.unchanged) if file not in files]
    console.say(f"{name}: {count(files, meshes)} in {done.folder}, {what_changed(done, meshes)}")
    code = _write_depfile(run, description, [*files, *meshes], request, compiled)
    # A hook fails where it had to change files.
    return PROBLEMS if options.hook and (done.written or done.removed) else code


def _write_depfile(
    run: Run, description: Description, names: Sequence[str], request: Request, compiled: Compiled
) -> int:
    """Write the requested depfile; the artifacts, the first of ``names`` the first, become newer than it.

    A mesh that was read in the folder of the artifacts is an input, too, and keeps its time.
    """
    if run.options.depfile is None:
        return FINE
    read = {os.path.realpath(file) for file in request.inputs(compiled)}
    made = [description.outputs / name for name in names]
    newer = [file for file in made if os.path.realpath(file) not in read]
    watched = request.watched(compiled, [*made, Path(run.options.depfile)])
    return write_depfile(run, run.options.depfile_target or str(made[0]), watched, made, newer)


def what_changed(written: Written, meshes: Collection[str] = ()) -> str:
    """Return in words what writing a set of artifacts did; ``meshes`` of it are counted."""
    if not written.written and not written.removed:
        return "unchanged"
    names = [name for name in written.written if name not in meshes]
    names += counted_files([name for name in written.written if name in meshes])
    parts = [f"written: {', '.join(names)}"] if names else []
    parts += [f"removed: {', '.join(written.removed)}"] if written.removed else []
    return "; ".join(parts)
