"""Compiling what is asked for: a description with its arguments and meshes, proven before anything is done with it."""

from __future__ import annotations

from collections.abc import Callable, Collection, Sequence, Sized
from pathlib import Path
from typing import TYPE_CHECKING

from rosorin_compile.source.console import Console
from rosorin_compile.source.project import Description, stdin_of
from rosorin_compile.source.wording import counted, listed

from .given import Given
from .usage import FINE, PROBLEMS

if TYPE_CHECKING:
    from rosorin_compile.output.pipeline import Compiled
    from rosorin_compile.source.diagnostics import Diagnostic

    from .run import Run


def compile_proven(given: Given, description: Description, console: Console, wanted: Sequence[str] = ()) -> Compiled:
    """Compile a description with its meshes and read its artifacts back; print the files that were read."""
    request = given.request(description, console)
    compiled = request.compile(wanted)
    console.tell_read(request.inputs(compiled))
    return compiled


def warn_before(given: Given, console: Console) -> Callable[[Diagnostic], None]:
    """Return the receiver of warnings before code is executed."""
    return (lambda _: None) if given.trust else console.ahead


def read_by(given: Given, compiled: Compiled) -> list[Path]:
    """Return the files that a run has read: what it was compiled of, and the files of arguments."""
    return [path for path in dict.fromkeys([*compiled.inputs, *given.files]) if stdin_of(path) is None]


def tell_build(
    run: Run, target: str, inputs: Sequence[Path], made: Sequence[Path] = (), newer: Sequence[Path] = ()
) -> int:
    """Write the depfile that is asked for, and make the files ``newer`` than it; return the exit code.

    ``inputs`` are what the target is made of, ``made`` the artifacts.
    """
    from rosorin_compile.output import OutputError
    from rosorin_compile.output.one_file import touch, write_depfile

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
