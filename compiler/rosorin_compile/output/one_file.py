"""One file: an artifact for whoever names its place, and the depfile that tells a build tool what it was made of."""

from __future__ import annotations

import os
import re
import stat
from collections.abc import Iterable, Sequence
from contextlib import suppress
from pathlib import Path

from ..diagnostics.registry import WRITING, Rule
from . import OutputError, explained
from .staging import STAGE

RULES = (
    Rule(
        "output-is-input",
        "A file would be written over one that it is made of.",
        "Name another file.",
        WRITING,
    ),
    Rule(
        "depfile-name",
        "A file that was read, or the target, has a name that no depfile can hold: one with a line break.",
        "Rename it.",
        WRITING,
    ),
)


def write_file(path: Path, data: bytes, inputs: Iterable[Path] = ()) -> None:
    """Make ``data`` the content of a file, in one step; folders above it are made.

    An equal file gets the time of now. What is no regular file, such as a pipe, is written into; a link stays. Raises
    OutputError, also where the file is one of ``inputs``.
    """
    try:
        status = _status(path)
        if status is not None and stat.S_ISDIR(status.st_mode):
            raise OutputError("output-folder", f"{path} is a folder", "name a file")
        if status is not None and any(_is_same(status, file) for file in inputs):
            message = f"{path} is one of the files that it would be made of"
            raise OutputError("output-is-input", message, "name another file")
        if status is not None and not stat.S_ISREG(status.st_mode):
            with path.open("wb") as file:
                file.write(data)
            return
        place = Path(os.path.realpath(path))
        if status is not None and status.st_size == len(data) and place.read_bytes() == data:
            with suppress(OSError):  # somebody else's file that we may read alone is as it should be
                os.utime(place)
                return
        place.parent.mkdir(parents=True, exist_ok=True)
        _replace(place, data, status)
    except OSError as problem:
        raise explained(problem, path, "write", "output file") from None


def touch(files: Iterable[Path]) -> None:
    """Give files the time of now, so that they are newer than what they are made of. Raises OutputError."""
    for file in files:
        try:
            os.utime(file)
        except OSError as problem:
            raise explained(problem, file, "write", "output file") from None


def write_depfile(path: Path, target: str, inputs: Sequence[Path], made: Iterable[Path]) -> None:
    """Write what a target was made of, as Make and Ninja read it: one rule with one target.

    ``made`` are the artifacts. Raises OutputError, also where the depfile would be one of them, or of the inputs.
    """
    names = [escaped(name) for name in (target, *dict.fromkeys(map(str, inputs)))]
    text = " \\\n  ".join([f"{names[0]}:", *names[1:]]) + "\n"
    if any(os.path.realpath(path) == os.path.realpath(file) for file in (*inputs, *made)):
        raise OutputError("output-is-input", f"{path} is what the depfile would tell of", "name another file")
    write_file(path, os.fsencode(text))


def escaped(name: str) -> str:
    r"""Return the name of a file as it stands in a depfile. Raises OutputError for one that cannot.

    As GCC does it: a backslash is an ordinary letter, but before a space, where each of them is doubled.

    >>> print(escaped("my robot/$x#1.yaml"))
    my\ robot/$$x\#1.yaml
    """
    if re.search(r"[\n\r\0]", name):
        help = "a depfile has no way to write it: give the file another name"
        raise OutputError("depfile-name", f"the name of {name} has a line break", help)
    name = re.sub(r"(\\*)([ \t])", r"\1\1\\\2", name)
    return re.sub("[#:]", r"\\\g<0>", name).replace("$", "$$")


def _status(path: Path) -> os.stat_result | None:
    try:
        return path.stat()
    except FileNotFoundError:
        return None
    except ValueError:
        raise OutputError("output-failed", f"no file can be called {path}", "name another one") from None


def _is_same(status: os.stat_result, file: Path) -> bool:
    try:
        return os.path.samestat(status, file.stat())
    except OSError:
        return False


def _replace(place: Path, data: bytes, before: os.stat_result | None) -> None:
    """Put a new file in the place of another one; it keeps its permissions. Raises OSError."""
    new = place.parent / (STAGE + os.urandom(8).hex())
    try:
        handle = os.open(new, os.O_WRONLY | os.O_CREAT | os.O_EXCL | os.O_NOFOLLOW, 0o666)
        with os.fdopen(handle, "wb") as file:
            file.write(data)
            if before is not None:
                with suppress(OSError):
                    os.fchmod(handle, stat.S_IMODE(before.st_mode))
        new.replace(place)
    finally:
        new.unlink(missing_ok=True)
