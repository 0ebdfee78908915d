"""rosorin-compile all: compile each robot and write its artifacts."""

from __future__ import annotations

import argparse
import os
from collections.abc import Collection, Mapping
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

from ..diagnostics.console import colour
from ..diagnostics.registry import WRITING, Rule
from ..diagnostics.wording import counted
from ..project import MESH_FILE, PYTHON_PACKAGE, Description, Resolved, is_file, python_folder, resolved
from .shared import (
    FINE,
    PROBLEMS,
    Run,
    compile_proven,
    count,
    for_each,
    format_options,
    lacks_meshes,
    mesh_files,
    nothing_written,
    output_options,
    robot_options,
)

if TYPE_CHECKING:
    from ..diagnostics import Diagnostic
    from ..frontend.packages import Packages
    from ..output import Written

RULES = (
    Rule(
        "output-kept",
        "A warning: a file was replaced that the tool may not have written; it is kept under the name that is told.",
        "Remove what was kept, if nobody needs it.",
        WRITING,
    ),
    Rule(
        "not-an-artifact",
        "A note: a file in the outputs folder is no artifact; it is kept.",
        "`rosorin-compile all --prune` removes it.",
        WRITING,
    ),
)


def options(command: argparse.ArgumentParser) -> None:
    """Add what this command takes."""
    robot_options(command)
    command.add_argument("-n", "--dry-run", action="store_true", help="write nothing; say what would change")
    command.add_argument("--prune", action="store_true", help="remove what is no artifact from the outputs folder")
    output_options(command)
    format_options(command)


def run(options: argparse.Namespace) -> int:
    """Compile each robot and write its artifacts."""
    if options.dry_run:
        from .check import check_one

        return for_each(options, check_one)
    return for_each(options, _write_one)


def _write_one(run: Run, description: Description) -> int:
    """Compile one robot and write its artifacts, or see that nothing has changed since that was done last."""
    from ..output import stamp

    key = {
        "description": os.path.abspath(description.path),
        "outputs": os.path.abspath(description.outputs),
        "arguments": run.given.texts,
        "argument files": [os.path.abspath(file) for file in run.given.files],
        "folders": {name: os.path.abspath(folder) for name, folder in run.given.packages.items()},
        "shown": [str(description.path), str(description.outputs), colour(), run.console.quiet],
    }
    remembered = stamp.recall(key, description.outputs, partial(_leads, {})) if run.console.for_people else None
    match remembered:
        case [str(said), str(summary), int(stand_ins)]:
            run.console.again(said)
            run.console.stand_ins += stand_ins
            run.console.say(f"{summary}, unchanged")
            return FINE
    begun, ran, before = stamp.now(), run.console.ran, run.console.stand_ins
    compiled = compile_proven(run.given, description, run.console)
    said = run.console.show(compiled.diagnostics)
    if not compiled.artifacts:
        return nothing_written(run.console, description.name, compiled.diagnostics)
    files: dict[str, str | bytes] = {artifact.file: artifact.text for artifact in compiled.artifacts}
    meshes = mesh_files(compiled)
    written = _write(run, description, {**meshes, **files})
    if written is None:
        return PROBLEMS
    summary = f"{description.name}: {count(files, meshes)} in {description.outputs}"
    run.console.say(f"{summary}, {what_changed(written, meshes)}")
    # What a xacro says depends on more than its files, and what can be made of a mesh on what is installed.
    if not written.kept and run.console.ran == ran and not lacks_meshes(compiled):
        written_too = {description.outputs / name for name in meshes}  # what stands there already, and is its own copy
        inputs = [*(set(compiled.inputs) - written_too), *run.given.files]
        told = [said, summary, run.console.stand_ins - before]
        files |= meshes
        stamp.remember(key, inputs, files, description.outputs, told, begun=begun, resolved=compiled.resolved)
    return FINE


def _leads(finders: dict[str, Packages], asked: Resolved) -> str:
    """Return where the name of a package or a mesh file leads now; ``finders`` are kept from one to the next."""
    if asked.kind == PYTHON_PACKAGE:
        return resolved(asked.kind, asked.name, asked.by, python_folder(asked.name)).answer
    if asked.kind == MESH_FILE:
        return asked.name if is_file(Path(asked.name)) else ""
    from ..frontend.packages import Packages

    finder = finders.setdefault(asked.by, Packages({}, os.environ, Path(asked.by)))
    return resolved(asked.kind, asked.name, asked.by, finder.find(asked.name)).answer


def _write(run: Run, description: Description, files: Mapping[str, str | bytes]) -> Written | None:
    from ..diagnostics import NOTE, Diagnostic
    from ..output import OutputError, write_outputs

    try:
        written = write_outputs(description.outputs, files, run.options.prune)
    except OutputError as problem:
        run.console.show([problem.diagnostic])
        return None
    run.console.show(put_aside(description.outputs, written))
    for name in written.kept:
        message = f"{description.outputs}/{name} is no artifact of this robot; it is kept"
        run.console.show([Diagnostic("not-an-artifact", NOTE, message, help="all --prune removes it")])
    return written


def put_aside(folder: Path, written: Written) -> list[Diagnostic]:
    """Return what there is to say of files that somebody else may have written, and that were replaced."""
    from ..diagnostics import WARNING, Diagnostic

    help = "if nobody needs it, remove that file"
    return [
        Diagnostic("output-kept", WARNING, f"{folder}/{name} may be of somebody else; it is {kept} now", None, (), help)
        for name, kept in written.aside
    ]


def what_changed(written: Written, meshes: Collection[str] = ()) -> str:
    """Return in words what writing a set of artifacts did; ``meshes`` of it are counted."""
    if not written.written and not written.removed:
        return "unchanged"
    names = [name for name in written.written if name not in meshes]
    copied = len(written.written) - len(names)
    names += [counted(copied, "mesh file")] if copied else []
    parts = [f"written: {', '.join(names)}"] if names else []
    parts += [f"removed: {', '.join(written.removed)}"] if written.removed else []
    return "; ".join(parts)
