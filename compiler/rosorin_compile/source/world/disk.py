"""The disk and the environment as the system has them: what is behind the door, and nothing is noted here.

Tests put another one in its place (``behind``): a world of values.
"""

from __future__ import annotations

import errno
import os
import stat
import sys
import time
from typing import TYPE_CHECKING, BinaryIO

from .. import system

if TYPE_CHECKING:
    from collections.abc import Mapping

FILE, FOLDER, OTHER, ABSENT = "file", "folder", "other", ""
# What the system says of a name that nothing has, or can have.
ABSENCES = (errno.ENOENT, errno.ENOTDIR, errno.ENAMETOOLONG)
_CLOCK_REALTIME_COARSE = 5  # linux/time.h; Python has no name for it


class Status:
    """What the system says of a file: its kind, size, mode, owner, and what tells it from the same one changed."""

    __slots__ = ("changed", "kind", "mode", "own", "signature", "size")

    def __init__(self, kind: str, size: int, mode: int, own: bool, changed: int, signature: str) -> None:
        self.kind = kind
        self.size = size
        self.mode = mode
        self.own = own  # this user's, or root's
        self.changed = changed  # ns
        self.signature = signature


def status_of(found: os.stat_result) -> Status:
    """Return what the system said of a file."""
    how = found.st_mode
    kind = FILE if stat.S_ISREG(how) else FOLDER if stat.S_ISDIR(how) else OTHER
    told = (found.st_dev, found.st_ino, found.st_size, found.st_mtime_ns, found.st_ctime_ns)
    own = found.st_uid == 0 or system.is_own(found)
    return Status(kind, found.st_size, how, own, found.st_ctime_ns, " ".join(map(str, told)))


class Disk:
    """The system itself. All raise OSError as it does, ENOENT for a name that no file can have."""

    def status(self, path: str) -> Status:
        """Return what there is at a path, links followed."""
        try:
            return status_of(os.stat(path))
        except ValueError as problem:
            raise _no_name(path, problem) from None

    def read(self, path: str, most: int = -1) -> tuple[bytes, Status, Status]:
        """Return what is in a regular file, at most so many bytes, and its status before and after it was read."""
        with self.stream(path) as opened:
            before = status_of(os.fstat(opened.fileno()))
            data = opened.read(most)
            return data, before, status_of(os.fstat(opened.fileno()))

    def stream(self, path: str) -> BinaryIO:
        """Return an open regular file; a pipe is not waited for."""
        try:
            handle = os.open(path, os.O_RDONLY | system.NO_WAIT | system.AS_BYTES | getattr(os, "O_CLOEXEC", 0))
        except ValueError as problem:
            raise _no_name(path, problem) from None
        try:
            how = os.fstat(handle).st_mode
            if stat.S_ISDIR(how):
                raise IsADirectoryError(errno.EISDIR, os.strerror(errno.EISDIR), path)
            if not stat.S_ISREG(how):
                raise OSError(errno.EINVAL, "No regular file", path)
            return open(handle, "rb")
        except BaseException:
            os.close(handle)
            raise

    def names(self, folder: str) -> dict[str, str]:
        """Return the kinds of what is in a folder, links followed, by name, sorted."""
        found = {}
        try:
            with os.scandir(folder) as entries:
                for entry in entries:
                    found[entry.name] = _kind_of(entry)
        except ValueError as problem:
            raise _no_name(folder, problem) from None
        return {name: found[name] for name in sorted(found)}

    def link(self, path: str) -> str:
        """Return where a link leads, as it is written; "" for what is no link."""
        try:
            return os.readlink(path)
        except ValueError as problem:
            raise _no_name(path, problem) from None
        except OSError as problem:
            if problem.errno == errno.EINVAL:
                return ""
            raise

    def real(self, path: str) -> str:
        """Return a path without links, as far as there is one."""
        try:
            return os.path.realpath(path)
        except ValueError:
            return os.path.abspath(path)

    def here(self) -> str:
        """Return the folder of the process."""
        return os.getcwd()

    def environment(self) -> Mapping[str, str]:
        """Return the variables of the environment."""
        return os.environ

    def package(self, name: str) -> tuple[str, ...]:
        """Return the folders of an installed package of Python, or the file of a module; () for none."""
        from importlib.util import find_spec

        try:
            spec = find_spec(name)
        except (ImportError, ValueError, AttributeError):
            return ()
        if spec is None:
            return ()
        return tuple(spec.submodule_search_locations or ()) or (spec.origin or name,)

    def now(self) -> int:
        """Return the time (ns), by the clock from which the system takes the times of files."""
        return time.clock_gettime_ns(_CLOCK_REALTIME_COARSE) if sys.platform == "linux" else time.time_ns()


def _kind_of(entry: os.DirEntry[str]) -> str:
    try:
        return (
            FILE if entry.is_file() else FOLDER if entry.is_dir() else OTHER if os.path.exists(entry.path) else ABSENT
        )
    except OSError:  # links that lead round, or where nobody may look
        return ABSENT


def _no_name(path: str, problem: ValueError) -> FileNotFoundError:
    """Return what is raised for a name that no file can have, in the words of Python."""
    return FileNotFoundError(errno.ENOENT, str(problem), path)


_behind = [Disk()]


def disk() -> Disk:
    """Return what is behind the door."""
    return _behind[-1]


class behind:  # noqa: N801 - it is used as a function
    """Have another disk behind the door for a while."""

    def __init__(self, other: Disk) -> None:
        self.other = other

    def __enter__(self) -> None:
        _behind.append(self.other)

    def __exit__(self, *_: object) -> None:
        _behind.remove(self.other)
