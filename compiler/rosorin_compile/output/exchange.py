"""Putting one folder in the place of another.

There are three ways; which of them works depends on the file system, and the best one that works is taken.

1. Exchange: two names change places in one system call. At every moment a complete folder stands there.
2. Aside: the old folder is renamed away, then the new one takes its name. A reader may find no folder for the moment
   between the two calls; if the process is killed right there, ``recover`` brings the old folder back at the next run.
3. File by file: for a folder that cannot be renamed at all, which is what overlayfs says of a folder that came with the
   image of a container. Each file is replaced in one step, the set is not: a kill between two files leaves a mix of
   old and new files until the next run, which sees the difference and replaces the set again.
"""

from __future__ import annotations

import errno
import os
import sys
from collections.abc import Callable, Iterator
from contextlib import suppress
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

if TYPE_CHECKING:
    import ctypes

_AT_FDCWD = -100  # linux/fcntl.h: the path counts from the current folder
_RENAME_EXCHANGE = 2  # linux/fs.h
_RENAME_SWAP = 2  # sys/stdio.h of macOS

# What systems say that cannot exchange; EPERM comes from containers that filter system calls.
_CANNOT = {errno.EINVAL, errno.ENOSYS, errno.ENOTSUP, errno.EOPNOTSUPP, errno.EPERM, errno.EXDEV}


class Change(NamedTuple):
    """What is to change in a folder, by relative POSIX name: files that are new or differ, and what is to go."""

    fresh: list[str]
    gone: list[str]


def below(folder: Path | str, prefix: str = "") -> Iterator[tuple[str, os.DirEntry[str]]]:
    """Yield the relative POSIX name and the entry of all that is below a folder, in no order, links not followed."""
    with os.scandir(folder) as entries:
        for entry in entries:
            yield prefix + entry.name, entry
            if entry.is_dir(follow_symlinks=False):
                yield from below(entry.path, f"{prefix}{entry.name}/")


def put(new: Path, folder: Path, aside: Path, change: Change) -> Path | None:
    """Put the folder ``new`` in the place of ``folder``, by the best way that works here.

    ``aside`` does not exist yet and is where the old folder may go. All three are on one file system. Returns where the
    old folder is now; None if there was none, or if its files were replaced one by one as ``change`` says. Raises
    OSError, and then the old folder stands as before.
    """
    if not os.path.lexists(folder):
        new.rename(folder)
        return None
    try:
        swap(new, folder)
        return new
    except OSError as problem:
        if problem.errno not in _CANNOT:
            raise
    aside.mkdir()
    old = aside / folder.name
    try:
        folder.rename(old)
    except OSError as problem:
        if problem.errno != errno.EXDEV:
            raise
        _file_by_file(new, folder, aside, change)
        return None
    try:
        new.rename(folder)
    except BaseException:
        old.rename(folder)
        raise
    return old


def recover(aside: Path, parent: Path) -> None:
    """Bring back the folder that a killed run had renamed into ``aside`` (see ``put``). Raises OSError."""
    if not aside.is_dir():
        return
    for old in aside.iterdir():
        if old.is_dir() and not os.path.lexists(parent / old.name):
            old.rename(parent / old.name)


def swap(one: Path, other: Path) -> None:
    """Let two paths change places in one step. Raises OSError, with ENOSYS where the C library has no such call."""
    try:
        import ctypes
    except ImportError:  # a Python that was built without it
        raise OSError(errno.ENOSYS, os.strerror(errno.ENOSYS)) from None
    call = _system_call(ctypes.CDLL(None, use_errno=True))
    if call(os.fsencode(one), os.fsencode(other)) != 0:
        code = ctypes.get_errno()
        raise OSError(code, os.strerror(code), str(one), None, str(other))


def _system_call(libc: ctypes.CDLL) -> Callable[[bytes, bytes], Any]:
    """Return the function that exchanges two paths and answers 0, or else sets errno."""
    import ctypes

    if sys.platform == "darwin" and hasattr(libc, "renamex_np"):
        return lambda one, other: libc.renamex_np(one, other, ctypes.c_uint(_RENAME_SWAP))
    if sys.platform == "linux" and hasattr(libc, "renameat2"):
        return lambda one, other: libc.renameat2(_AT_FDCWD, one, _AT_FDCWD, other, ctypes.c_uint(_RENAME_EXCHANGE))
    raise OSError(errno.ENOSYS, os.strerror(errno.ENOSYS))


def _file_by_file(new: Path, folder: Path, aside: Path, change: Change) -> None:
    """Replace and remove files in ``folder`` as ``change`` says. Raises OSError after everything was put back."""
    undo: list[Callable[[], object]] = []
    try:
        for name in (name for name in change.gone if not _is_folder(folder / name)):
            source, target = folder / name, aside / str(len(undo))
            source.rename(target)
            undo.append(partial(target.rename, source))
        for name in change.fresh:
            source, target = new / name, folder / name
            for parent in reversed(target.relative_to(folder).parents):
                if not (folder / parent).is_dir():
                    (folder / parent).mkdir()
                    undo.append((folder / parent).rmdir)
            if os.path.lexists(target):
                undo.append(_one_file(source, target, aside / str(len(undo))))
            else:
                source.rename(target)
                undo.append(partial(target.rename, source))
    except BaseException:
        for step in reversed(undo):
            step()
        raise
    for name in reversed(change.gone):
        if _is_folder(folder / name):
            with suppress(OSError):  # somebody put something into it just now
                (folder / name).rmdir()


def _one_file(source: Path, target: Path, kept: Path) -> Callable[[], object]:
    """Put a file in the place of another in one step; return what puts it back. Raises OSError."""
    try:
        swap(source, target)
        return partial(swap, source, target)
    except OSError as problem:
        if problem.errno not in _CANNOT or _is_folder(target):
            raise
    os.link(target, kept, follow_symlinks=False)
    source.replace(target)
    return partial(kept.replace, target)


def _is_folder(path: Path) -> bool:
    return path.is_dir() and not path.is_symlink()
