"""Replace files and folders in one step: the new one is prepared in a hidden folder, and then takes the place.

A process that has a hidden folder holds the lock on its parent. Without that it is killed, and the folder is removed.
"""

from __future__ import annotations

import errno
import os
import re
import shutil
import stat
import sys
from collections.abc import Collection, Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager, nullcontext, suppress
from pathlib import Path

from rosorin_compile.source import system

STAGING_NAME = re.compile(r"\.rosorin-compile-[0-9a-f]{16}")
# The errors of systems that cannot exchange two paths; EPERM comes from containers that filter system calls.
_CANNOT_EXCHANGE = {errno.EINVAL, errno.ENOSYS, errno.ENOTSUP, errno.EOPNOTSUPP, errno.EPERM, errno.EXDEV}

Entries = dict[str, os.stat_result]  # of a folder: relative POSIX name -> status, symbolic links not followed, sorted


def entries_below(folder: str | Path, prefix: str = "") -> Iterator[tuple[str, os.DirEntry[str]]]:
    """Yield the relative POSIX name and the entry of all files and folders below a folder, links not followed."""
    with os.scandir(folder) as entries:
        for entry in entries:
            yield prefix + entry.name, entry
            if entry.is_dir(follow_symlinks=False):
                yield from entries_below(entry.path, f"{prefix}{entry.name}/")


@contextmanager
def locked(folder: Path, shared: bool = False, tidy: bool = False) -> Iterator[None]:
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
    """Remove a hidden folder, after bringing back an output folder that is only there."""
    with suppress(OSError):
        for old in (stage / "old").glob("*"):
            if not os.path.lexists(stage.parent / old.name):
                old.rename(stage.parent / old.name)
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
    _sync(path)
    with suppress(OSError):
        shutil.copymode(model, path)


def _sync(path: Path) -> None:
    """Flush a file or folder to the disk. Not all file systems can flush folders."""
    with suppress(OSError) if path.is_dir() else nullcontext(), ExitStack() as stack:
        handle = os.open(path, os.O_RDONLY if path.is_dir() else os.O_RDWR)
        stack.callback(os.close, handle)
        os.fsync(handle)


def replace_folder(
    folder: Path,
    stage: Path,
    fresh: Mapping[str, bytes],
    seen: Entries | None = None,
    kept: Collection[str] = (),
    durable: bool = True,
) -> None:
    """Replace ``folder`` by one with the ``fresh`` files and, of what was ``seen`` in it, what is ``kept``.

    ``stage`` is an empty folder on the same file system. With ``durable`` all is flushed to the disk before it takes
    its place. Raises OSError, and then the old folder is unchanged.
    """
    new, seen = stage / "new", seen or {}
    new.mkdir()
    for name in (name for name in seen if name in kept):
        if stat.S_ISDIR(seen[name].st_mode):
            (new / name).mkdir()
        else:
            _link_or_copy(folder / name, new / name)
    for name, data in fresh.items():
        (new / name).parent.mkdir(parents=True, exist_ok=True)
        with (new / name).open("xb") as file:
            file.write(data)
    below = {name: entry.is_dir(follow_symlinks=False) for name, entry in entries_below(new)}
    for name in (*(name for name, is_folder in below.items() if is_folder or name in fresh), "") if durable else ():
        _sync(new / name)
    for name in (*(name for name in reversed(seen) if below.get(name)), ""):
        with suppress(OSError, AttributeError):  # Windows has no chown
            status = (folder / name).stat()
            os.chown(new / name, status.st_uid, status.st_gid)
        with suppress(FileNotFoundError):
            shutil.copymode(folder / name, new / name)
    old = _put_in_place(new, folder, stage, list(fresh), [n for n in seen if n not in kept and n not in fresh])
    if durable:
        _sync(folder.parent)
    # What somebody saved in the old folder in the meantime is moved to the new one.
    for name, entry in list(entries_below(old)) if old else ():
        if not entry.is_dir(follow_symlinks=False) and name not in fresh:
            now, before = entry.stat(follow_symlinks=False), seen.get(name)
            if before is None or (now.st_ino, now.st_mtime_ns) != (before.st_ino, before.st_mtime_ns):
                (folder / name).parent.mkdir(parents=True, exist_ok=True)
                Path(entry.path).replace(folder / name)


def _link_or_copy(source: Path, target: Path) -> None:
    try:
        system.link(source, target)
    except FileNotFoundError:
        pass  # it was removed in the meantime
    except OSError as problem:
        # EXDEV: something is mounted there, so the folder cannot be replaced. A special file cannot be copied.
        if problem.errno == errno.EXDEV or not (source.is_symlink() or source.is_file()):
            raise
        shutil.copy2(source, target, follow_symlinks=False)


def _put_in_place(new: Path, folder: Path, stage: Path, fresh: list[str], gone: list[str]) -> Path | None:
    """Put ``new`` in the place of ``folder`` and return the new place of the old folder, or None. Raises OSError."""
    if not os.path.lexists(folder):
        new.rename(folder)
        return None
    try:
        exchange(new, folder)
        return new
    except OSError as problem:
        if problem.errno not in _CANNOT_EXCHANGE:
            raise
    # A process that is killed between these two renames leaves no folder: the next one brings the old one back.
    old = stage / "old" / folder.name
    old.parent.mkdir()
    try:
        folder.rename(old)
    except OSError as problem:
        if problem.errno != errno.EXDEV:
            raise
        replace_files(new, folder, stage / "undo", fresh, gone)  # the folder is of the image of a container
        return None
    new.rename(folder)
    return old


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
                    _link_or_copy(target, backup)
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
