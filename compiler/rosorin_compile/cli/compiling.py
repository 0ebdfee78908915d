"""Compiling what is asked for: a description with its arguments and meshes, proven before anything is done with it."""

from __future__ import annotations

import os
from collections.abc import Callable, Collection, Sequence, Sized
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

from rosorin_compile.source.console import Console
from rosorin_compile.source.diagnostics import TRUSTED
from rosorin_compile.source.project import Description, shown, stdin_of
from rosorin_compile.source.wording import counted, listed

from .given import Given
from .usage import FINE, PROBLEMS

if TYPE_CHECKING:
    from rosorin_compile.formats.mesh_files import Searched
    from rosorin_compile.model import Output
    from rosorin_compile.output.pipeline import Compiled
    from rosorin_compile.source.diagnostics import Diagnostic
    from rosorin_compile.source.tree import Map

    from .run import Run


def compile_one(
    given: Given,
    description: Description,
    console: Console,
    meshes: bool = False,
    wanted: Sequence[str] = (),
) -> Compiled:
    """Return what becomes of one description; a file of arguments that is no good is a problem like others.

    What has to be said before anything is run is printed on the console. ``meshes`` says that mesh files are looked
    for; without that each is taken to be where the artifacts look. ``wanted`` are the only outputs that are made.
    """
    from rosorin_compile.output.pipeline import Compiled, compile_robot
    from rosorin_compile.source.load import LoadError

    try:
        arguments = given.values()
    except LoadError as problem:
        return Compiled(None, (), [problem.diagnostic], ())
    search = partial(search_meshes, given, description) if meshes else None
    tell = warn_before(given, console)
    compiled = compile_robot(description.path, arguments, tell, given.packages, search, wanted)
    console.tell_read(read_by(given, compiled))
    return compiled


def compile_proven(given: Given, description: Description, console: Console, wanted: Sequence[str] = ()) -> Compiled:
    """Return what becomes of one description, its meshes found, without artifacts if they say another thing than it."""
    compiled = compile_one(given, description, console, meshes=True, wanted=wanted)
    return compiled.proven()  # no command writes, copies or compares what has not been


def warn_before(given: Given, console: Console) -> Callable[[Diagnostic], None]:
    """Return what takes a word of warning before something is run: it is counted alone where that is trusted."""
    if not given.trust:
        return console.ahead
    return lambda warning: console.ahead(replace(warning, numbers=TRUSTED))


def search_meshes(given: Given, description: Description, tree: Map, outputs: Sequence[Output]) -> Searched:
    """Look for the meshes of a robot, and read those that belong to its artifacts."""
    from rosorin_compile.formats.mesh_files import Places, search
    from rosorin_compile.output.mesh_copies import brought

    places = Places(description.path, description.outputs, given.packages, os.environ)
    return brought(search(tree, outputs, places), description.outputs)


def read_by(given: Given, compiled: Compiled) -> list[Path]:
    """Return the files that a run has read: what it was compiled of, and the files of arguments."""
    return [path for path in dict.fromkeys([*compiled.files_read, *given.files]) if stdin_of(path) is None]


def folders_looked_in(compiled: Compiled, made: Sequence[Path]) -> list[Path]:
    """Return the folders in which files would appear that were looked for, as a build tool can depend on them.

    It takes a missing file for one that has to be made. Folders outside of the project, and those in which this run
    writes, change for other reasons.
    """
    projects = Description.at(compiled.inputs[0]).projects if compiled.missing else ()
    written = {path.absolute().parent for path in made}
    found: dict[Path, None] = {}
    for path in compiled.missing:
        folder = next(one for one in path.absolute().parents if one.is_dir())
        if folder not in written and any(map(folder.resolve().is_relative_to, projects)):
            found[Path(shown(folder))] = None
    return list(found)


def tell_build(
    run: Run, target: str, inputs: Sequence[Path], made: Sequence[Path] = (), newer: Sequence[Path] = ()
) -> int:
    """Write the depfile that is asked for, and make the files ``newer`` than it; return the exit code.

    ``inputs`` are what the target is made of, ``made`` the artifacts.
    """
    from rosorin_compile.output import OutputError

    from .depfile import touch, write_depfile

    try:
        write_depfile(Path(run.options.depfile), target, inputs, made)
        touch(newer)
    except OutputError as problem:
        run.console.show([problem.diagnostic])
        return PROBLEMS
    return FINE


def nothing_written(console: Console, name: str, diagnostics: Sequence[Diagnostic]) -> int:
    """Say how many problems keep a robot from being compiled; a robot without outputs has none."""
    errors = sum(diagnostic.severity == "error" for diagnostic in diagnostics)
    if not errors:
        console.say(f"{name}: nothing to emit; say under outputs: what you want")
        return FINE
    console.warn(f"{name}: {counted(errors, 'error')}, nothing written")
    return PROBLEMS


def count(artifacts: Sized, beside: Collection[str] = ()) -> str:
    """Return the number of artifacts in words, and that of the meshes and textures with them, by their names."""
    return listed([counted(len(artifacts), "artifact"), *counted_files(beside)])


def counted_files(names: Collection[str]) -> list[str]:
    """Return how many meshes and textures there are, each in words; what there is none of is left out."""
    textures = sum(name.lower().endswith(".png") for name in names)
    counts = {"mesh file": len(names) - textures, "texture": textures}
    return [counted(number, word) for word, number in counts.items() if number]
