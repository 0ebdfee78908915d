"""The same command again: if nothing has changed since it was run, what it said is said again.

Asked before the command line is read, so that such a run takes little more than starting Python. What is kept in the
user's cache is the line, where it was called, with which environment, and what the run depended on: the tool and the
folders that Python imports from, the folders where descriptions are looked for, the files that were read, and the
artifacts. A run that depends on more (packages, a terminal, a depfile) is not kept. Whatever is odd means that the run
is made; ``output.stamp`` then knows it robot by robot.
"""

from __future__ import annotations

import os
import sys
import time
from typing import TYPE_CHECKING

from .cache import digest, keep, private_folder, recalled

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping, Sequence

COMMANDS = ("all", "print")
_PASSING = ("_", "SHLVL", "OLDPWD")  # variables that tell nothing of a run
_CLOCK_REALTIME_COARSE = 5  # linux/time.h; Python has no name for it
OUT, ERR, RAW = "1", "2", "r"  # what was said: lines on standard output and error; an artifact
_TOOL, _CODE, _FOLDER, _READ, _MADE, _HELD = "t", "c", "d", "i", "o", "f"
_END, _PART = "\0", "\x1f"  # none of them is in a text that is kept

_called: list[tuple[list[str], int]] = []  # the words of this process, and when it began
_marked: dict[str, str] = {}  # what ``mark`` said of folders


def now() -> int:
    """Return the time in nanoseconds, by the clock from which the system takes the times of files."""
    if sys.platform == "linux":
        return time.clock_gettime_ns(_CLOCK_REALTIME_COARSE)
    return time.time_ns()


def said_again(words: Sequence[str]) -> bool:
    """Say what a command line said the last time, if a run would only do the same again; else note when it began."""
    if not words or words[0] not in COMMANDS or sys.stdout is None or sys.stderr is None:
        return False
    _called[:] = [(list(words), now())]
    try:
        file = _file(words)
        kept = recalled(file) if file else None
        said = _still_true(kept.decode()) if kept is not None else None
        for kind, text in said or ():
            stream = sys.stderr if kind == ERR else sys.stdout
            stream.buffer.write(text.encode("utf-8" if kind == RAW else stream.encoding, "backslashreplace"))
            stream.flush()
    except Exception:  # a record that is damaged in whatever way is none; a run says what is wrong with a pipe
        return False
    return said is not None


def remember(
    inputs: Mapping[str, str],
    outputs: Mapping[str, Mapping[str, str]],
    lookups: Iterable[str | os.PathLike[str]],
    said: Sequence[tuple[str, str]],
    tool: Iterable[str],
) -> None:
    """Keep what this process said, if it was begun for one line: ``said_again`` will say it.

    ``inputs`` are the digests of the files that were read, by name ("" for one that is to be read now), ``outputs``
    those of the artifacts, by folder. ``lookups`` are the folders in which descriptions were looked for, ``tool`` those
    of the tool itself: of the first one, of its modules, what was loaded counts alone. A failure is silent.
    """
    if not _called:
        return
    words, begun = _called[0]
    try:
        file = _file(words)
        read = {os.path.abspath(name): content for name, content in sorted(inputs.items())}
        rows = list(_rows(read, outputs, [*sys.path, *map(os.path.abspath, lookups)], begun))
        modules, *data = tool
        code = loaded(modules)
        rows += [[_CODE, name, _state(_CODE, name)] for name in sorted(code)]
        rows += [[_FOLDER, folder, _state(_FOLDER, folder)] for folder in sorted({*map(os.path.dirname, code)})]
        rows += [[_TOOL, folder, _state(_TOOL, folder)] for folder in data]
        if file and not any(_END in text or _PART in text for _, text in said):
            rows += [list(one) for one in said]
            keep(file, _END.join(_PART.join(row) for row in rows).encode())
    except (OSError, ValueError):
        return


def _file(words: Sequence[str]) -> str:
    """Return the file that keeps a command line; "" without a cache."""
    folder = private_folder("runs")
    environment = sorted(f"{name}={value}" for name, value in os.environ.items() if name not in _PASSING)
    seen = [str(sys.stdout.isatty()), str(sys.stderr.isatty()), sys.stdout.encoding, sys.stderr.encoding]
    key = [sys.version, __file__, os.getcwd(), *words, _END, *environment, _END, *seen]
    return os.path.join(folder, digest(_END.join(key).encode("utf-8", "surrogateescape"))) if folder else ""


def _still_true(kept: str) -> list[tuple[str, str]] | None:
    """Return what was said, if everything is as it was; else None. Raises OSError, ValueError."""
    said = []
    held: dict[str, dict[str, str]] = {}
    for row in kept.split(_END):
        kind, name, *more = row.split(_PART)
        if kind in (OUT, ERR, RAW):
            said.append((kind, name))
        elif kind == _MADE:
            folder = held[name] = {}
        elif kind == _HELD:
            folder[name] = more[0]
        elif more[0] != _state(kind, name):
            return None
    return said if all(contents(folder) == files for folder, files in held.items()) else None


def _rows(
    inputs: Mapping[str, str], outputs: Mapping[str, Mapping[str, str]], folders: Iterable[str], begun: int
) -> Iterable[list[str]]:
    """Yield what a run depends on, and how that is. Raises ValueError if it may have changed meanwhile."""
    for folder in folders:
        yield [_FOLDER, folder, _state(_FOLDER, folder)]
    for name, content in inputs.items():
        if changed(name) >= begun:
            raise ValueError("nobody knows which of its contents was read")
        yield [_READ, name, content or _state(_READ, name)]
    for folder, held in outputs.items():
        yield [_MADE, os.path.abspath(folder)]
        yield from ([_HELD, name, content] for name, content in held.items())


def _state(kind: str, name: str) -> str:
    """Return how a thing is that a run depends on. Raises OSError."""
    if kind == _TOOL:
        return mark(name)
    if kind == _READ:
        with open(name, "rb") as opened:
            return digest(opened.read())
    try:
        status = os.stat(name or ".")
    except OSError:
        return ""
    return f"{status.st_mtime_ns} {status.st_size}" if kind == _CODE else str(status.st_mtime_ns)


def loaded(folder: str) -> set[str]:
    """Return the files of the modules below a folder that this process has loaded."""
    files = (getattr(module, "__file__", None) for module in tuple(sys.modules.values()))
    return {file for file in files if file and file.startswith(folder + os.sep)}


def mark(folder: str) -> str:
    """Return what tells the files of the tool in a folder from others; a process for one line works it out once."""
    if not _called or folder not in _marked:
        _marked[folder] = digest("\n".join(_marks(folder)).encode("utf-8", "surrogateescape"))
    return _marked[folder]


def _marks(folder: str) -> list[str]:
    """Return the name, size and time of each file below a folder; this is most of what looking takes."""
    found = []
    folders = [(folder, "")]
    while folders:
        path, prefix = folders.pop()
        with os.scandir(path) as entries:
            for entry in entries:
                if not entry.is_dir():
                    status = entry.stat()
                    found.append(f"{prefix}{entry.name} {status.st_size} {status.st_mtime_ns}")
                elif entry.name != "__pycache__":
                    folders.append((entry.path, f"{prefix}{entry.name}/"))
    return sorted(found)


def contents(folder: str) -> dict[str, str]:
    """Return the digest of each file below a folder by its relative name; "" for what is none. Raises OSError."""
    found: dict[str, str] = {}
    folders = [(os.fspath(folder), "")]
    while folders:
        path, prefix = folders.pop()
        with os.scandir(path) as entries:
            for entry in entries:
                if entry.is_dir(follow_symlinks=False):
                    folders.append((entry.path, f"{prefix}{entry.name}/"))
                elif entry.is_file(follow_symlinks=False):
                    with open(entry.path, "rb") as opened:
                        found[prefix + entry.name] = digest(opened.read())
                else:
                    found[prefix + entry.name] = ""
    return found


def changed(name: str) -> int:
    """Return when a file was changed last (ns). Raises OSError."""
    status = os.stat(name)
    return max(status.st_mtime_ns, status.st_ctime_ns)
