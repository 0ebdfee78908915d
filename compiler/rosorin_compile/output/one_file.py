"""One file: an artifact for whoever names its place, and the depfile that tells a build tool what it was made of.

It is prepared beside its place and renamed: after a kill at any moment the old or the new one stands there. A file that
this tool did not write is not replaced.
"""

from __future__ import annotations

import os
import re
import stat
from collections.abc import Callable, Iterable, Sequence
from contextlib import suppress
from pathlib import Path

from rosorin_compile.source import files
from rosorin_compile.source.rule_registry import WRITING, Rule

from . import OutputError, cleared
from .ours import wrote
from .staging import staged_file, tidy, write_staged

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


_DEPFILE = re.compile(rb"\S[^\n]*:(?: \\\n  \S[^\n]*)*\n")


def write_file(
    path: Path, data: bytes, inputs: Iterable[Path] = (), ours: Callable[[Path], bool] | None = wrote
) -> None:
    """Make ``data`` the content of a file, in one step; folders above it are made.

    An equal file gets the time of now. What is no regular file, such as a pipe, is written into; a link stays. Raises
    OutputError, also where the file is one of ``inputs``, or not one of ``ours``: it does not say that we wrote it.
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
        if place.parent.is_dir():
            with suppress(OSError):
                tidy(place.parent)
        if status is not None and status.st_size == len(data) and place.read_bytes() == data:
            with suppress(OSError):  # somebody else's file that we may read alone is as it should be
                os.utime(place)
                return
        elif status is not None and ours is not None and not ours(place):
            message = f"this tool did not write {path}: it is not replaced"
            raise OutputError("output-not-ours", message, "name another file, or move it away")
        place.parent.mkdir(parents=True, exist_ok=True)
        _replace(place, data, status)
    except OSError as problem:
        raise OutputError.of(problem, path, "write", "output file") from None


def replace_text(path: Path, text: str, rule: str) -> None:
    """Put a new text into a file: after a kill at any moment it holds the old or the new one.

    A link stays a link, and permissions stay as they are. Raises OutputError, whose diagnostic is of ``rule``.
    """
    target = files.resolve(path)
    if files.exists(target) and not files.is_file(target):  # a device would be gone
        raise OutputError(rule, f"cannot write {path}: it is no regular file", "name another file")
    try:
        target.parent.mkdir(parents=True, exist_ok=True)
        with cleared(target.parent), staged_file(target.parent) as (stage, handle):
            mode = target.stat().st_mode & 0o7777 if files.exists(target) else None
            write_staged(stage, handle, text.encode("utf-8"), mode, sync=True)
            stage.replace(target)
    except (OSError, ValueError) as problem:
        reason = getattr(problem, "strerror", None) or str(problem)
        help = "check the name and the permissions"
        raise OutputError(rule, f"cannot write {path}: {reason}", help) from None


def touch(files: Iterable[Path]) -> None:
    """Give files the time of now, so that they are newer than what they are made of. Raises OutputError."""
    for file in files:
        try:
            os.utime(file)
        except OSError as problem:
            raise OutputError.of(problem, file, "write", "output file") from None


def write_depfile(path: Path, target: str, inputs: Sequence[Path], made: Iterable[Path]) -> None:
    """Write what a target was made of, as Make and Ninja read it: one rule with one target.

    ``made`` are the artifacts. Raises OutputError, also where the depfile would be one of them, or of the inputs.
    """
    names = [escaped(name) for name in (target, *dict.fromkeys(map(str, inputs)))]
    text = " \\\n  ".join([f"{names[0]}:", *names[1:]]) + "\n"
    if any(os.path.realpath(path) == os.path.realpath(file) for file in (*inputs, *made)):
        raise OutputError("output-is-input", f"{path} is what the depfile would tell of", "name another file")
    write_file(path, os.fsencode(text), ours=_is_depfile)


def _is_depfile(path: Path) -> bool:
    """Say whether a file is a depfile as it is written here, which has no comment that could say so."""
    data = path.read_bytes()
    return not data.strip() or _DEPFILE.fullmatch(data) is not None


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
    with staged_file(place.parent) as (new, handle):
        write_staged(new, handle, data, None if before is None else stat.S_IMODE(before.st_mode))
        new.replace(place)
