"""Read files, and record the paths that were read or were missing: the dependencies of a compiled robot."""

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
Version = tuple[int, ...]  # inode, size and times (ns) of a file; only the inode of a folder; empty if missing
_ABSENT = (errno.ENOENT, errno.ENOTDIR, errno.ENAMETOOLONG, errno.ELOOP)
_recorders: ContextVar[tuple[dict[Path, Version], ...]] = ContextVar("recorders", default=())


@contextmanager
def record_reads() -> Iterator[dict[Path, Version]]:
    """Collect the version of each path that is read, or looked up and missing, in the block."""
    paths: dict[Path, Version] = {}
    token = _recorders.set((*_recorders.get(), paths))
    try:
        yield paths
    finally:
        _recorders.reset(token)


def record(path: AnyPath, version: Version) -> None:
    """Record that a version of a file was read, or with an empty version that the file was missing."""
    for recorder in _recorders.get():
        recorder[Path(path)] = version


def version(path: AnyPath | int) -> Version:
    """Return the version of a path or an open file; empty if it does not exist or cannot be accessed."""
    try:
        status = os.fstat(path) if isinstance(path, int) else Path(path).stat()
    except (OSError, ValueError):
        return ()
    numbers = (status.st_ino, status.st_size, status.st_mtime_ns, status.st_ctime_ns)
    return numbers[:1] if stat.S_ISDIR(status.st_mode) else numbers


def read_bytes(path: AnyPath, most: int = -1) -> bytes:
    """Return the content of a regular file, at most ``most`` bytes. Raises OSError, also for pipes and devices."""
    with open_binary(path) as opened:
        return opened.read(most)


def read_text(path: AnyPath, encoding: str = "utf-8", errors: str = "strict") -> str:
    """Return the text of a file; all line ends become a line feed. Raises OSError, UnicodeDecodeError."""
    return read_bytes(path).decode(encoding, errors).replace("\r\n", "\n").replace("\r", "\n")


def open_binary(path: AnyPath) -> BinaryIO:
    """Open a regular file for reading; do not block on a pipe. Raises OSError."""
    try:
        handle = os.open(path, os.O_RDONLY | system.NO_WAIT | system.AS_BYTES | getattr(os, "O_CLOEXEC", 0))
    except ValueError as problem:  # a NUL character in the name
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
    """Return True if the path exists, following links. Raises OSError if it cannot be accessed."""
    return _mode(path) != 0


def is_file(path: AnyPath) -> bool:
    """Return True for a regular file, following links. Raises OSError if it cannot be accessed."""
    return stat.S_ISREG(_mode(path))


def is_folder(path: AnyPath) -> bool:
    """Return True for a folder, following links."""
    return stat.S_ISDIR(_mode(path))


def is_special(path: AnyPath) -> bool:
    """Return True for a pipe, a device or another special file. Raises OSError if it cannot be accessed."""
    mode = _mode(path)
    return mode != 0 and not stat.S_ISREG(mode) and not stat.S_ISDIR(mode)


def _mode(path: AnyPath) -> int:
    """Return the mode of a path, or 0 if it does not exist; record a missing path. Raises OSError."""
    try:
        return Path(path).stat().st_mode
    except ValueError:  # a NUL character in the name
        return 0
    except OSError as problem:
        if problem.errno not in _ABSENT:
            raise
    record(path, ())
    return 0


def resolve(path: AnyPath) -> Path:
    """Return an absolute path with all links in its existing part resolved."""
    try:
        return Path(os.path.realpath(path))
    except ValueError:  # a NUL character in the name
        return Path(os.path.abspath(path))


def label(path: AnyPath) -> str:
    """Return a path for messages: relative to the current folder if it is below, else unchanged."""
    try:
        here = os.path.relpath(path)
    except (OSError, ValueError):  # the current folder was deleted, or is on another drive
        return os.fspath(path)
    return os.fspath(path) if here.startswith("..") and Path(path).is_absolute() else here
