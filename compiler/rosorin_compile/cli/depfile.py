"""Depfiles: what a target was made from, in the syntax of Make and Ninja (``--depfile``)."""

import os
import re
from collections.abc import Sequence
from pathlib import Path

from rosorin_compile.formats.compilation import Compiled
from rosorin_compile.output import OutputError, write_file
from rosorin_compile.source.files import label
from rosorin_compile.source.project import Description

from .console import FINE, PROBLEMS
from .run import Run

_DEPFILE = re.compile(rb"\S[^\n]*:(?: \\\n  \S[^\n]*)*\n")


def write_depfile(
    run: Run, target: str, inputs: Sequence[Path], made: Sequence[Path] = (), newer: Sequence[Path] = ()
) -> int:
    """Write the requested depfile, and make the files ``newer`` than it; return the exit code.

    ``inputs`` are what the target is made of, ``made`` the artifacts; the depfile must not be one of them.
    """
    path = Path(run.options.depfile)
    try:
        names = [escape(name) for name in (target, *dict.fromkeys(map(str, inputs)))]
        text = " \\\n  ".join([f"{names[0]}:", *names[1:]]) + "\n"
        if any(os.path.realpath(path) == os.path.realpath(file) for file in (*inputs, *made)):
            message = f"{path} is an input or an artifact in the depfile"
            raise OutputError("output-is-input", message, "name another file")
        write_file(path, os.fsencode(text), may_replace=_is_depfile)
        for file in newer:
            try:
                os.utime(file)
            except OSError as problem:
                raise OutputError.from_os_error(problem, file, "write", "output file") from None
    except OutputError as problem:
        run.console.show([problem.diagnostic])
        return PROBLEMS
    return FINE


def watched_paths(inputs: Sequence[Path], compiled: Compiled, made: Sequence[Path]) -> list[Path]:
    """Return what a build tool has to watch: the inputs, and the folders in which files were not found.

    The folders are listed instead of the missing files, because a build tool would try to make those. Folders outside
    of the project, and folders of the files that this run has ``made``, change for other reasons.
    """
    projects = Description.from_path(compiled.inputs[0]).projects if compiled.missing else ()
    written = {path.absolute().parent for path in made}
    folders: dict[Path, None] = {}
    for path in compiled.missing:
        folder = next(parent for parent in path.absolute().parents if parent.is_dir())
        if folder not in written and any(map(folder.resolve().is_relative_to, projects)):
            folders[Path(label(folder))] = None
    return [*inputs, *folders]


def _is_depfile(path: Path) -> bool:
    data = path.read_bytes()
    return not data.strip() or _DEPFILE.fullmatch(data) is not None


def escape(name: str) -> str:
    r"""Return the name of a file in the syntax of a depfile, as GCC writes it. Raises OutputError for a line break.

    >>> print(escape("my robot/$x#1.yaml"))
    my\ robot/$$x\#1.yaml
    """
    if re.search(r"[\n\r\0]", name):
        help = "a depfile has no way to write it: give the file another name"
        raise OutputError("depfile-name", f"the name of {name} has a line break", help)
    name = re.sub(r"(\\*)([ \t])", r"\1\1\\\2", name)
    return re.sub("[#:]", r"\\\g<0>", name).replace("$", "$$")
