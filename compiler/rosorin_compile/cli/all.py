"""rosorin-compile all: compile each robot and write its artifacts."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from rosorin_compile.source import files
from rosorin_compile.source.project import Description
from rosorin_compile.source.rule_registry import WRITING, Rule

from .answer import tell_of_robot
from .robots import check_depfile, no_stdin
from .run import Run, for_each
from .usage import FINE, PROBLEMS, USAGE, WrongUsage

if TYPE_CHECKING:
    import argparse

    from rosorin_compile.output import WriteResult
    from rosorin_compile.output.pipeline import Compiled
    from rosorin_compile.source.diagnostics import Diagnostic

    from .parser import Parser

RULES = (
    Rule(
        "not-an-artifact",
        "A note: a file in the outputs folder is no artifact; it is kept.",
        "`rosorin-compile all --prune` removes it.",
        WRITING,
    ),
)


def options(command: Parser) -> None:
    """Add what this command takes."""
    command.add_robots()
    command.add_argument("-n", "--dry-run", action="store_true", help="write nothing; print what would change")
    command.add_argument(
        "--prune", action="store_true", help="delete files in the output folder that are not artifacts"
    )
    command.add_hook("; exit with 1 if a file was written")
    command.add_argument(
        "--only",
        action="append",
        default=[],
        type="path",
        metavar="OUTPUT",
        help="write only this output and its meshes; repeatable",
    )
    command.add_output()
    command.add_depfile("default: the first artifact, or that of the first --only")
    command.add_notes()
    command.add_messages()


def run(options: argparse.Namespace) -> int:
    """Compile each robot and write its artifacts."""
    _check_options(options)
    each = _write_one
    if options.dry_run:
        from .check import check_one as each
    return for_each(options, each)


def _check_options(options: argparse.Namespace) -> None:
    """Raise WrongUsage for options that do not go together."""
    no_stdin(options.words, "name a file, or print one artifact: rosorin-compile print - OUTPUT")
    if options.only and (options.prune or options.dry_run):
        other = "--prune" if options.prune else "--dry-run"
        raise WrongUsage(f"--only does not go with {other}, which is about all artifacts of a robot")
    if options.depfile is not None and options.dry_run:
        raise WrongUsage("--depfile does not go with --dry-run, which writes nothing")
    check_depfile(options)


def _write_one(run: Run, description: Description) -> int:
    """Compile one robot and write its artifacts, or those that are asked for."""
    return (_write_some if run.options.only else _write_all)(run, description)


def _write_all(run: Run, description: Description) -> int:
    """Compile one robot and write its artifacts."""
    from .compiling import compile_proven, count, nothing_written

    compiled = compile_proven(run.given, description, run.console)
    run.console.show(compiled.diagnostics)
    if not compiled.artifacts:
        return nothing_written(run.console, description.name, compiled.diagnostics)
    files: dict[str, str | bytes] = {artifact.file: artifact.text for artifact in compiled.artifacts}
    meshes = compiled.mesh_files
    names = [*files, *meshes]
    written = _write(run, description, {**meshes, **files})
    if written is None:
        return PROBLEMS
    summary = f"{description.name}: {count(files, meshes)} in {description.outputs}"
    run.console.say(f"{summary}, {what_changed(written, meshes)}")
    return _ended(run, written, _tell_build(run, description, names, compiled))


def _ended(run: Run, written: WriteResult, code: int) -> int:
    """Return the exit code of a run that wrote something, or nothing: a hook fails where it had to change files."""
    changed = bool(written.written or written.removed)
    return PROBLEMS if run.options.hook and changed else code


def _write_some(run: Run, description: Description) -> int:
    """Compile a robot and write the artifacts that are asked for."""
    from rosorin_compile.language.wanted import UNKNOWN

    from .compiling import compile_proven, count, nothing_written

    compiled = compile_proven(run.given, description, run.console, run.options.only)
    run.console.show(compiled.diagnostics)
    if not compiled.artifacts:
        unknown = any(one.rule == UNKNOWN for one in compiled.diagnostics)
        return max(nothing_written(run.console, description.name, compiled.diagnostics), USAGE if unknown else FINE)
    files: dict[str, str | bytes] = {artifact.file: artifact.text for artifact in compiled.artifacts}
    meshes = _belonging(compiled)
    written = _write(run, description, {**meshes, **files})
    if written is None:
        return PROBLEMS
    summary = f"{description.name}: {count(files, meshes)} in {description.outputs}"
    run.console.say(f"{summary}, {what_changed(written, meshes)}")
    return _ended(run, written, _tell_build(run, description, [*files, *meshes], compiled))


def _belonging(compiled: Compiled) -> dict[str, bytes]:
    """Return the mesh files that belong to the artifacts that were made, of those of all."""
    from rosorin_compile.formats.mesh_files import opened_by

    robot, searched = compiled.robot, compiled.meshes
    if robot is None or searched is None:
        return {}
    made = {artifact.output for artifact in compiled.artifacts}
    outputs = [output for output in robot.outputs if output.name in made]
    names = {opened_by(output, found.named.name) for found in searched.found for output in outputs}
    return {name: data for name, data in searched.files.items() if name in names}


def _tell_build(run: Run, description: Description, names: Sequence[str], compiled: Compiled) -> int:
    """Write the depfile, if one is asked for; the artifacts, the first of ``names`` the first, get newer than it.

    A mesh that was read where it stands, in the folder of the artifacts, is an input, too, and keeps its time.
    """
    if run.options.depfile is None:
        return FINE
    from .compiling import folders_looked_in, read_by, tell_build

    inputs = read_by(run.given, compiled)
    read = {files.resolve(file) for file in inputs}
    made = [description.outputs / name for name in names]
    newer = [file for file in made if files.resolve(file) not in read]
    return tell_build(
        run,
        run.options.depfile_target or str(made[0]),
        [*inputs, *folders_looked_in(compiled, [*made, Path(run.options.depfile)])],
        made,
        newer,
    )


def _write(run: Run, description: Description, files: Mapping[str, str | bytes]) -> WriteResult | None:
    from rosorin_compile.output import OutputError, write_artifacts

    try:
        written = write_artifacts(description.outputs, files, run.options.prune, complete=not run.options.only)
    except OutputError as problem:
        run.console.show([problem.diagnostic])
        return None
    _tell(run, description, written)
    run.console.show(written.diagnostics(description.outputs))
    for note in left_alone(description.outputs, written) if not run.options.only else ():
        run.console.show([note], listed=True)  # check fails for it
    return written


def left_alone(folder: Path, written: WriteResult) -> list[Diagnostic]:
    """Return what there is to say of files in the folder of a robot that are none of its artifacts."""
    from rosorin_compile.source.diagnostics import NOTE, Diagnostic

    help = "all --prune removes it"
    return [
        Diagnostic("not-an-artifact", NOTE, f"{folder}/{name} is no artifact of this robot; it is kept", help=help)
        for name in written.kept
    ]


def _tell(run: Run, description: Description, written: WriteResult) -> None:
    """Add what was written to the answer."""
    names = {"written": list(written.written), "unchanged": list(written.unchanged), "removed": list(written.removed)}
    tell_of_robot(run.options, {"folder": str(description.outputs), **names})


def what_changed(written: WriteResult, meshes: Collection[str] = ()) -> str:
    """Return in words what writing a set of artifacts did; ``meshes`` of it are counted."""
    from .compiling import counted_files

    if not written.written and not written.removed:
        return "unchanged"
    names = [name for name in written.written if name not in meshes]
    names += counted_files([name for name in written.written if name in meshes])
    parts = [f"written: {', '.join(names)}"] if names else []
    parts += [f"removed: {', '.join(written.removed)}"] if written.removed else []
    return "; ".join(parts)
