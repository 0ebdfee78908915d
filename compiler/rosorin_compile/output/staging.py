"""Replace files and folders in one step: the new one is prepared in a hidden folder, and then takes the place.

A process that has a hidden folder holds the lock on its parent. Without that it is killed, and the folder is removed.
"""

from __future__ import annotations

import errno
import os
import re
import shutil
import sys
from collections.abc import Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager, nullcontext, suppress
from pathlib import Path

from rosorin_compile.source import system

STAGING_NAME = re.compile(r"\.rosorin-compile-[0-9a-f]{16}")
# The errors of systems that cannot exchange two paths; EPERM comes from containers that filter system calls.
_CANNOT_EXCHANGE = {errno.EINVAL, errno.ENOSYS, errno.ENOTSUP, errno.EOPNOTSUPP, errno.EPERM, errno.EXDEV}


def entries_below(folder: str | Path, prefix: str = "") -> Iterator[tuple[str, os.DirEntry[str]]]:
    """Yield the relative POSIX name and the entry of all files and folders below a folder, links not followed."""
    with os.scandir(folder) as entries:
        for entry in entries:
            yield prefix + entry.name, entry
            if entry.is_dir(follow_symlinks=False):
                yield from entries_below(entry.path, f"{prefix}{entry.name}/")


@contextmanager
def lock(folder: Path, shared: bool = False, tidy: bool = False) -> Iterator[None]:
    """Hold the lock on a folder, if there is one; with ``tidy``, remove what killed processes left. Raises OSError."""
    with ExitStack() as stack:
        with suppress(PermissionError) if shared or not system.HAS_FOLDER_HANDLES else nullcontext():
            handle = os.open(folder, os.O_RDONLY | system.AS_FOLDER)
            stack.callback(os.close, handle)
            with suppress(OSError):
                system.lock(handle, shared=shared)
                for path in list(folder.iterdir()) if tidy else ():
                    if STAGING_NAME.fullmatch(path.name) and not path.is_symlink() and system.is_own(path.lstat()):
                        _discard(path)
        yield


@contextmanager
def staging_folder(parent: Path) -> Iterator[Path]:
    """Make a hidden folder in ``parent``, whose lock is held; it is removed at the end. Raises OSError."""
    stage = parent / f".rosorin-compile-{os.urandom(8).hex()}"
    try:
        stage.mkdir(0o700)
        yield stage
    finally:
        _discard(stage)


def _discard(stage: Path) -> None:
    """Remove a hidden folder."""
    with suppress(OSError):
        for place, folders, _ in os.walk(stage):
            for path in (Path(place, name) for name in folders):
                if not path.is_symlink():
                    path.chmod(0o700)
        shutil.rmtree(stage) if stage.is_dir() else stage.unlink()


def write_synced(path: Path, data: bytes, model: Path) -> None:
    """Write a new file with the permissions of ``model``, if that exists, and flush it to the disk. Raises OSError."""
    path.parent.mkdir(parents=True, exist_ok=True)
    with path.open("xb") as file:
        file.write(data)
    sync(path)
    with suppress(OSError):
        shutil.copymode(model, path)


def sync(path: Path) -> None:
    """Flush a file or folder to the disk. Not all file systems can flush folders."""
    with suppress(OSError) if path.is_dir() else nullcontext(), ExitStack() as stack:
        handle = os.open(path, os.O_RDONLY if path.is_dir() else os.O_RDWR)
        stack.callback(os.close, handle)
        os.fsync(handle)


def write_files(folder: Path, files: Mapping[str, bytes], durable: bool = True) -> None:
    """Write new files below a folder, and with ``durable`` flush them and all folders to the disk. Raises OSError."""
    for name, data in files.items():
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        with (folder / name).open("xb") as file:
            file.write(data)
    if durable:
        folders = [name for name, entry in entries_below(folder) if entry.is_dir(follow_symlinks=False)]
        for name in (*files, *folders, ""):
            sync(folder / name)


def link_or_copy(source: Path, target: Path) -> None:
    """Give a file a second name, or copy it where that is not possible; a missing file is ignored. Raises OSError."""
    try:
        system.link(source, target)
    except FileNotFoundError:
        pass
    except OSError as problem:
        # EXDEV: something is mounted there, so the folder cannot be replaced. A special file cannot be copied.
        if problem.errno == errno.EXDEV or not (source.is_symlink() or source.is_file()):
            raise
        shutil.copy2(source, target, follow_symlinks=False)


def put_in_place(new: Path, folder: Path, stage: Path, fresh: Sequence[str], gone: Sequence[str] = ()) -> None:
    """Put the folder ``new``, which is in ``stage``, in the place of ``folder``. Raises OSError.

    ``fresh`` are the new files in it, and ``gone`` the entries of the old folder that it does not have: these are
    replaced one by one where folders cannot be exchanged.
    """
    if not os.path.lexists(folder):
        new.rename(folder)
        return
    try:
        exchange(new, folder)
    except OSError as problem:
        if problem.errno not in _CANNOT_EXCHANGE:
            raise
        replace_files(new, folder, stage / "undo", fresh, gone)


def replace_files(new: Path, folder: Path, undo: Path, fresh: Sequence[str], gone: Sequence[str] = ()) -> None:
    """Move files from ``new`` to ``folder`` in their order, and remove those ``gone``. Undo that and raise OSError."""
    started: list[tuple[Path, Path, bool]] = []
    try:
        for name in (*gone, *fresh):
            target, backup = folder / name, undo / name
            if name in fresh or not target.is_dir() or target.is_symlink():
                target.parent.mkdir(parents=True, exist_ok=True)
                backup.parent.mkdir(parents=True, exist_ok=True)
                if exists := os.path.lexists(target):
                    link_or_copy(target, backup)
                started.append((target, backup, exists))
                (new / name).replace(target) if name in fresh else target.unlink()
    except BaseException:
        for target, backup, exists in reversed(started):
            with suppress(OSError):
                backup.replace(target) if exists else target.unlink()
        raise
    for name in reversed(gone):
        with suppress(OSError):  # a file, or a folder into which somebody put one just now
            (folder / name).rmdir()


def exchange(first: Path, second: Path) -> None:
    """Exchange two paths in one step. Raises OSError, with ENOSYS where the C library has no such call."""
    try:
        import ctypes

        libc, names, flag = ctypes.CDLL(None, use_errno=True), (os.fsencode(first), os.fsencode(second)), 2
        if sys.platform == "darwin":
            failed = libc.renamex_np(*names, ctypes.c_uint(flag))  # RENAME_SWAP of sys/stdio.h
        else:  # AT_FDCWD of linux/fcntl.h, RENAME_EXCHANGE of linux/fs.h
            failed = libc.renameat2(-100, names[0], -100, names[1], ctypes.c_uint(flag))
        code = ctypes.get_errno() if failed else 0
    except (ImportError, TypeError, AttributeError):
        code = errno.ENOSYS
    if code:
        raise OSError(code, os.strerror(code), str(first), None, str(second))
