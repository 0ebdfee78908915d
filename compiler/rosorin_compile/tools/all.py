"""rosorin-compile all: compile each robot and write its artifacts."""

from __future__ import annotations

import argparse
import os
import sys
from collections.abc import Collection, Mapping
from typing import TYPE_CHECKING

from ..diagnostics.console import colour
from ..diagnostics.registry import WRITING, Rule
from ..diagnostics.wording import counted
from ..project import Description
from .shared import (
    FINE,
    PROBLEMS,
    Run,
    compile_one,
    count,
    for_each,
    format_options,
    found_meshes,
    is_searched,
    mesh_files,
    nothing_written,
    output_options,
    robot_options,
)

if TYPE_CHECKING:
    from ..output import Written

RULES = (
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
        "packages": [os.environ.get(name, "") for name in ("ROS_PACKAGE_PATH", "AMENT_PREFIX_PATH")],
        "shown": [str(description.path), str(description.outputs), colour()],
    }
    remembered = stamp.recall(key, description.outputs) if run.console.for_people else None
    if remembered is not None:
        said, summary = remembered
        sys.stderr.write(said)
        run.console.say(f"{summary}, unchanged")
        return FINE
    begun, ran = stamp.now(), run.console.ran
    compiled = compile_one(run.given, description, run.console, meshes=True)
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
    # What a xacro says depends on more than its files, and so does which file a mesh is.
    if not written.kept and run.console.ran == ran and not is_searched(compiled):
        inputs = [*compiled.inputs, *run.given.files, *(found.file for found in found_meshes(compiled))]
        files |= meshes
        stamp.remember(key, inputs, files, description.outputs, [said, summary], begun=begun)
    return FINE


def _write(run: Run, description: Description, files: Mapping[str, str | bytes]) -> Written | None:
    from ..diagnostics import NOTE, Diagnostic
    from ..output import OutputError, write_set

    try:
        written = write_set(description.outputs, files, run.options.prune)
    except OutputError as problem:
        run.console.show([problem.diagnostic])
        return None
    for name in written.kept:
        message = f"{description.outputs}/{name} is no artifact of this robot; it is kept"
        run.console.show([Diagnostic("not-an-artifact", NOTE, message, help="all --prune removes it")])
    return written


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
