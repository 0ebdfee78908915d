"""Read files, and record every path that was read or looked for as a dependency of the compiled robot."""

import errno
import os
import stat
from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from pathlib import Path
from typing import BinaryIO

from . import system

AnyPath = str | os.PathLike[str]
Version = tuple[int, ...]  # (inode, size, mtime, ctime) of a file, in bytes and ns; (inode,) of a folder; () if missing
_ABSENT = (errno.ENOENT, errno.ENOTDIR, errno.ENAMETOOLONG, errno.ELOOP)
_recorders: ContextVar[tuple[dict[Path, Version], ...]] = ContextVar("recorders", default=())


@contextmanager
def record_reads() -> Iterator[dict[Path, Version]]:
    """Yield a dict to which each path that is read or looked up in the ``with`` block is added, with its version."""
    paths: dict[Path, Version] = {}
    token = _recorders.set((*_recorders.get(), paths))
    try:
        yield paths
    finally:
        _recorders.reset(token)


def record(path: AnyPath, version: Version) -> None:
    """Add a path to the dicts of all active ``record_reads`` blocks; ``version`` is () if the path does not exist."""
    for recorder in _recorders.get():
        recorder[Path(path)] = version


def version(path: AnyPath | int) -> Version:
    """Return (inode, size, times) of a path or file descriptor, or () if it does not exist or is inaccessible."""
    try:
        status = os.fstat(path) if isinstance(path, int) else Path(path).stat()
    except (OSError, ValueError):
        return ()
    numbers = (status.st_ino, status.st_size, status.st_mtime_ns, status.st_ctime_ns)
    return numbers[:1] if stat.S_ISDIR(status.st_mode) else numbers


def read_bytes(path: AnyPath, most: int = -1) -> bytes:
    """Read a regular file, at most ``most`` bytes (-1: all). Raises OSError, also for a pipe or device."""
    with open_binary(path) as opened:
        return opened.read(most)


def read_text(path: AnyPath, encoding: str = "utf-8", errors: str = "strict") -> str:
    """Read a text file, and convert all line ends to line feeds. Raises OSError or UnicodeDecodeError."""
    return read_bytes(path).decode(encoding, errors).replace("\r\n", "\n").replace("\r", "\n")


def open_binary(path: AnyPath) -> BinaryIO:
    """Open a regular file for reading. Raises OSError, also for a pipe, on which opening could block."""
    try:
        handle = os.open(path, os.O_RDONLY | system.NO_WAIT | system.AS_BYTES | getattr(os, "O_CLOEXEC", 0))
    except ValueError as problem:  # the path contains a NUL character
        raise FileNotFoundError(errno.ENOENT, str(problem), os.fspath(path)) from None
    except OSError:
        record(path, version(path))
        raise
    record(path, version(handle))
    mode = os.fstat(handle).st_mode
    if stat.S_ISREG(mode):
        return os.fdopen(handle, "rb")
    os.close(handle)
    reason = (errno.EISDIR, "Is a directory") if stat.S_ISDIR(mode) else (errno.EINVAL, "not a regular file")
    raise OSError(*reason, os.fspath(path))


def exists(path: AnyPath) -> bool:
    """Return True if a path exists, False for a dangling symlink. Raises OSError if the path is inaccessible."""
    return _mode(path) != 0


def is_file(path: AnyPath) -> bool:
    """Return True for a regular file or a symlink to one. Raises OSError if the path is inaccessible."""
    return stat.S_ISREG(_mode(path))


def is_folder(path: AnyPath) -> bool:
    """Return True for a folder or a symlink to one. Raises OSError if the path is inaccessible."""
    return stat.S_ISDIR(_mode(path))


def is_special(path: AnyPath) -> bool:
    """Return True for a pipe, device or other special file. Raises OSError if the path is inaccessible."""
    mode = _mode(path)
    return mode != 0 and not stat.S_ISREG(mode) and not stat.S_ISDIR(mode)


def _mode(path: AnyPath) -> int:
    try:
        return Path(path).stat().st_mode
    except ValueError:  # the path contains a NUL character
        return 0
    except OSError as problem:
        if problem.errno not in _ABSENT:
            raise
    record(path, ())
    return 0


def resolve(path: AnyPath) -> Path:
    """Return the absolute path with all symlinks resolved; the path need not exist."""
    try:
        return Path(os.path.realpath(path))
    except ValueError:  # the path contains a NUL character
        return Path(os.path.abspath(path))


def label(path: AnyPath) -> str:
    """Shorten a path for messages: relative to the current folder if the path is inside it, else unchanged."""
    try:
        here = os.path.relpath(path)
    except (OSError, ValueError):  # the current folder was deleted, or is on another drive
        return os.fspath(path)
    return os.fspath(path) if here.startswith("..") and Path(path).is_absolute() else here
