"""Preparing a new output folder beside the old one, and clearing away what is left of the old.

A run works in a folder of its own beside the output folder. Nobody else may look into it, so nobody can lead us
elsewhere with a symbolic link. A run that was killed leaves that folder behind; the next one that writes beside it
removes it. Which run lives still is told by a lock on the folder: the system takes it from a process that ends.

``swap`` lets two folders change places in one step, where the C library has a call for it.
"""

from __future__ import annotations

import errno
import os
import stat
import sys
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager, suppress
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from rosorin_compile.source import system

if TYPE_CHECKING:
    import ctypes


STAGE = ".rosorin-compile-"  # and 16 hexadecimal digits
_NEW = "new"
_ASIDE = "old"
_NO_HANDLE = -1  # of a folder, where a system has none

# What is in a folder: relative POSIX name -> status, links not followed; folders before what they hold.
There = dict[str, os.stat_result]


def is_stage(name: str) -> bool:
    """Say whether a file name is one that we give to the folder of a run."""
    digits = name.removeprefix(STAGE)
    return name.startswith(STAGE) and len(digits) == 16 and all(digit in "0123456789abcdef" for digit in digits)


def tidy(parent: Path) -> None:
    """Repair and remove what killed runs left in ``parent``; what a living run holds stays. Raises OSError."""
    with os.scandir(parent) as entries:
        stale = [entry for entry in entries if is_stage(entry.name)]
    for entry in stale:
        with suppress(FileNotFoundError):
            # What is another user's is not ours to remove, and could be a trap.
            if system.is_own(entry.stat(follow_symlinks=False)):
                _remove_left(parent / entry.name, entry.is_dir(follow_symlinks=False))


def _remove_left(path: Path, is_folder: bool) -> None:
    """Remove a file or folder of a run, unless that run lives, or nobody can know."""
    with suppress(OSError):
        handle = os.open(path, os.O_RDONLY | system.NO_LINK | system.NO_WAIT)
        try:
            system.lock(handle, wait=False)
            if is_folder:
                discard(path)
            elif stat.S_ISREG(os.fstat(handle).st_mode):
                path.unlink()
        finally:
            os.close(handle)


@contextmanager
def staged(parent: Path) -> Iterator[Path]:
    """Make the folder of a run in ``parent``, which is discarded in the end. Raises OSError."""
    with _held(parent, _new_folder) as (stage, _):
        try:
            yield stage
        finally:
            discard(stage)


class Stage:
    """The folder of a run beside what it is to replace: what is prepared in it is put into its place in one step.

    ``path`` is where it stands. All of it raises OSError.
    """

    def __init__(self, path: Path) -> None:
        self.path = path

    @classmethod
    @contextmanager
    def within(cls, parent: Path) -> Iterator[Stage]:
        """Make one in ``parent``, which is discarded in the end."""
        with staged(parent) as path:
            yield cls(path)

    @staticmethod
    def tidy(parent: Path) -> None:
        """Repair and remove what killed runs left in ``parent``; what a living run holds stays."""
        tidy(parent)

    @staticmethod
    def below(folder: Path) -> Iterator[tuple[str, os.DirEntry[str]]]:
        """Yield the relative POSIX name and the entry of all that is below a folder, in no order, links as links."""
        return below(folder)

    def carry(self, source: Path, name: str) -> None:
        """Let a file stand under a name here, too: the same file where links can be made, else a copy."""
        (self.path / name).parent.mkdir(parents=True, exist_ok=True)
        carry(source, self.path / name)

    def put(self, name: str, folder: Path, fresh: list[str], gone: list[str]) -> None:
        """Put the folder ``name`` that was made here into the place of ``folder``; if it fails, that is as before.

        ``fresh`` are its files that are new or differ, ``gone`` those of the old folder that are to go.
        """
        put(self.path / name, folder, self.path / _ASIDE, Change(fresh, gone))


@contextmanager
def staged_file(parent: Path) -> Iterator[tuple[Path, int]]:
    """Make the file of a run in ``parent``, gone in the end; yield it, and a handle to write. Raises OSError."""
    with _held(parent, _new_file) as (new, handle):
        try:
            yield new, handle
        finally:
            new.unlink(missing_ok=True)


def write_staged(new: Path, handle: int, data: bytes, mode: int | None = None, sync: bool = False) -> None:
    """Write the file of a run, with the permissions of another one, and to the disk with ``sync``. Raises OSError."""
    with open(handle, "wb", closefd=not system.HAS_FOLDER_HANDLES) as file:  # Windows moves no file that is open
        file.write(data)
        if sync:
            file.flush()
            os.fsync(handle)
    if mode is None:
        return
    with suppress(OSError):
        if hasattr(os, "fchmod"):
            os.fchmod(handle, mode)
        else:
            new.chmod(mode)


@contextmanager
def _held(parent: Path, make: Callable[[Path], int | None]) -> Iterator[tuple[Path, int]]:
    """Make something under a name of a run, and hold the lock on it; yield both."""
    while True:
        path = parent / (STAGE + os.urandom(8).hex())
        handle = make(path)
        if handle is None:
            continue
        try:
            with suppress(OSError, ValueError):  # some network drives have no locks, and Windows no such handle
                system.lock(handle)
            if os.path.lexists(path):  # else another run has tidied it away before it was held
                yield path, handle
                return
        finally:
            with suppress(OSError):  # it may be closed by now
                os.close(handle)


def _new_folder(path: Path) -> int | None:
    path.mkdir(mode=0o700)
    if not system.HAS_FOLDER_HANDLES:
        return _NO_HANDLE
    with suppress(FileNotFoundError):  # another run has tidied it away
        return os.open(path, os.O_RDONLY | system.AS_FOLDER | system.NO_LINK)
    return None


def _new_file(path: Path) -> int:
    return os.open(path, os.O_WRONLY | os.O_CREAT | os.O_EXCL | system.NO_LINK | system.AS_BYTES, 0o666)


def replace(folder: Path, fresh: Mapping[str, bytes], carried: There, seen: There) -> None:
    """Replace ``folder`` by one that holds the ``fresh`` files and of those ``seen`` in it only the ``carried``.

    Raises OSError, and then the old folder stands as before.
    """
    gone = [name for name in seen if name not in carried and name not in fresh]
    with staged(folder.parent) as stage:
        new = stage / _NEW
        _fill(new, folder, fresh, carried)
        old = put(new, folder, stage / _ASIDE, Change(list(fresh), gone))
        _sync_folder(folder.parent)
        if old is not None:
            _rescue(old, folder, fresh, seen)


def _fill(new: Path, folder: Path, fresh: Mapping[str, bytes], carried: There) -> None:
    """Make the folder ``new`` and bring it to the disk, so that it is whole even after a power failure."""
    new.mkdir()
    folders = {new: folder}
    for name, status in carried.items():
        if stat.S_ISDIR(status.st_mode):
            (new / name).mkdir()
            folders[new / name] = folder / name
        else:
            carry(folder / name, new / name)
    for name, data in fresh.items():
        (new / name).parent.mkdir(parents=True, exist_ok=True)
        _write(new / name, data)
    # Syncing after all was written lets the file system do most of the work at once.
    for name, entry in below(new):
        if name in fresh:
            _sync(new / name)
        elif entry.is_dir(follow_symlinks=False):
            _sync_folder(new / name)
    _sync_folder(new)
    for path, model in reversed(folders.items()):
        with suppress(FileNotFoundError):
            _make_like(path, model)


def _write(path: Path, data: bytes) -> None:
    handle = os.open(path, os.O_WRONLY | os.O_CREAT | os.O_EXCL | system.NO_LINK | system.AS_BYTES, 0o666)
    try:
        rest = memoryview(data)
        while rest:
            rest = rest[os.write(handle, rest) :]
    finally:
        os.close(handle)


def _sync(path: Path, how: int = os.O_RDWR) -> None:  # Windows brings nothing to the disk that is only read
    handle = os.open(path, how)
    try:
        os.fsync(handle)
    finally:
        os.close(handle)


def _sync_folder(path: Path) -> None:
    """Bring the names in a folder to the disk, where the file system can be asked for that; not all can."""
    with suppress(OSError):
        _sync(path, os.O_RDONLY)


def _make_like(path: Path, model: Path) -> None:
    """Give a new folder the owner and the permissions of the old one."""
    wanted, got = model.stat(), path.stat()
    if (wanted.st_uid, wanted.st_gid) != (got.st_uid, got.st_gid):
        with suppress(PermissionError):
            os.chown(path, wanted.st_uid, wanted.st_gid)
    path.chmod(stat.S_IMODE(wanted.st_mode))


def carry(source: Path, target: Path) -> None:
    """Let a file stand in the new folder too: the same file where links can be made, else a copy. Raises OSError."""
    try:
        system.link(source, target)
    except OSError as problem:
        if isinstance(problem, FileNotFoundError):
            return  # somebody removed it just now
        # EXDEV: something is mounted there, so that the old folder must stay as it is. A special file has no copy.
        if problem.errno == errno.EXDEV or not (source.is_symlink() or source.is_file()):
            raise
        import shutil

        shutil.copy2(source, target, follow_symlinks=False)


def _rescue(old: Path, folder: Path, fresh: Mapping[str, bytes], seen: There) -> None:
    """Bring over what somebody else saved in the old folder while the new one was being made."""
    for name, entry in list(below(old)):
        if entry.is_dir(follow_symlinks=False) or name in fresh:
            continue
        now, before = entry.stat(follow_symlinks=False), seen.get(name)
        if before is None or (now.st_ino, now.st_mtime_ns) != (before.st_ino, before.st_mtime_ns):
            (folder / name).parent.mkdir(parents=True, exist_ok=True)
            (old / name).replace(folder / name)


def discard(stage: Path) -> None:
    """Remove the folder of a run, after bringing back what only it holds. What cannot be removed stays."""
    with suppress(OSError):
        recover(stage / _ASIDE, stage.parent)
        if not system.HAS_FOLDER_HANDLES:
            import shutil

            shutil.rmtree(stage)
            return
        parent = os.open(stage.parent, os.O_RDONLY | system.AS_FOLDER)
        try:
            _remove(stage.name, parent)
        finally:
            os.close(parent)


def _remove(name: str, parent: int) -> None:
    """Remove a folder and all in it, never through a link nor into another file system. Raises OSError."""
    handle = os.open(name, os.O_RDONLY | system.AS_FOLDER | system.NO_LINK, dir_fd=parent)
    try:
        if os.fstat(handle).st_dev != os.fstat(parent).st_dev:
            raise OSError(errno.EXDEV, os.strerror(errno.EXDEV), name)
        os.fchmod(handle, 0o700)
        with os.scandir(handle) as entries:
            children = [(entry.name, entry.is_dir(follow_symlinks=False)) for entry in entries]
        for child, is_folder in children:
            if is_folder:
                _remove(child, handle)
            else:
                os.unlink(child, dir_fd=handle)
    finally:
        os.close(handle)
    os.rmdir(name, dir_fd=parent)


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

        library = ctypes.CDLL(None, use_errno=True)
    except (ImportError, TypeError):  # a Python that was built without it; Windows has no library of that kind
        raise OSError(errno.ENOSYS, os.strerror(errno.ENOSYS)) from None
    call = _system_call(library)
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
    system.link(target, kept)
    source.replace(target)
    return partial(kept.replace, target)


def _is_folder(path: Path) -> bool:
    return path.is_dir() and not path.is_symlink()
