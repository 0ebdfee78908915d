"""The user's cache: files that only the user can change, kept between runs; all works without them."""

from __future__ import annotations

import errno
import os
import stat
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path

from . import shown

_ELSEWHERE = "ROSORIN_COMPILE_CACHE names another folder (off: no cache)"
_refused: list[tuple[str, str]] = []


def cache_folder(name: str) -> Path | None:
    """Return the folder for one kind of cached files, which only the user can change; None if there is no such place.

    ``ROSORIN_COMPILE_CACHE`` names another place; ``off`` turns caching off. Otherwise the XDG base directory
    specification holds. What is cached is run (templates) and believed (stamps): a folder that anybody else but root
    could change, or put another one in the place of, is none; ``cache_refused`` says so.
    """
    top = _cache_top()
    if top is None:
        return None
    folder = top / name
    try:
        for place in (*reversed(folder.parents), folder):
            if not os.path.lexists(place):
                with suppress(FileExistsError):  # another run was quicker
                    place.mkdir(mode=0o700)
        open_to, way_out = _open_to_others(folder)
    except (OSError, ValueError):
        return None
    if open_to:
        _refused.append((f"{open_to}: nothing is kept in the cache {top}", way_out))
        return None
    return Path(os.path.realpath(folder)) if os.access(folder, os.W_OK) else None


def cache_refused() -> tuple[str, str] | None:
    """Return why there is no cache though there could be one, and the way out; once."""
    first = _refused[0] if _refused else None
    _refused.clear()
    return first


def _cache_top() -> Path | None:
    """Return the folder of the cache, absolute; None if there is to be none, or no place for one."""
    chosen = os.environ.get("ROSORIN_COMPILE_CACHE", "")
    if chosen:
        return None if chosen == "off" else Path(os.path.abspath(chosen))
    base = os.environ.get("XDG_CACHE_HOME", "")
    if not os.path.isabs(base):  # noqa: PTH117 - an empty one is none, and a relative one does not count by XDG
        # It stays as it is for a user without a home; an empty HOME would be the root of the disk.
        base = os.path.expanduser("~/.cache") if os.environ.get("HOME", "~") else ""
    return Path(base, "rosorin-compile") if os.path.isabs(base) else None  # noqa: PTH117


def _open_to_others(folder: Path) -> tuple[str, str]:
    """Return who else could change what is in a folder of the cache, and the way out; empty if only root can.

    In a folder above others may write if it is sticky, as /tmp is: what stands there is its owner's. Raises OSError.
    """
    for place in _way(folder, 40):
        status = place.lstat()
        open_mode = not stat.S_ISLNK(status.st_mode) and status.st_mode & 0o022 and not status.st_mode & stat.S_ISVTX
        if status.st_uid not in (0, os.geteuid()) or open_mode:
            return _told(place, not open_mode)
    for place in (folder.parent, folder):
        status = place.stat()
        if status.st_uid != os.geteuid() or status.st_mode & 0o022:
            return _told(place, status.st_uid != os.geteuid())
    return "", ""


def _told(place: Path, foreign: bool) -> tuple[str, str]:
    if foreign:
        return f"{shown(place)} belongs to another user", _ELSEWHERE
    return f"{shown(place)} can be written by others", f"chmod go-w {shown(place)}; or {_ELSEWHERE}"


def _way(path: Path, links: int) -> Iterator[Path]:
    """Yield each folder on the way to an absolute path, and of each link that it leads through too. Raises OSError."""
    for place in (*reversed(path.parents), path):
        yield place
        if place.is_symlink():
            if not links:
                raise OSError(errno.ELOOP, os.strerror(errno.ELOOP), str(place))
            target = os.path.join(place.parent, os.readlink(place))  # noqa: PTH115
            yield from _way(Path(os.path.abspath(target)), links - 1)


def recalled(file: Path) -> bytes | None:
    """Return what was kept in a file of the cache; None if there is none, or it is damaged in whatever way."""
    import hashlib

    try:
        handle = os.open(file, os.O_RDONLY | os.O_NOFOLLOW | os.O_NONBLOCK)
        with os.fdopen(handle, "rb") as opened:
            status = os.fstat(handle)
            if not stat.S_ISREG(status.st_mode) or status.st_uid != os.geteuid() or status.st_mode & 0o022:
                return None
            digest, _, data = opened.read().partition(b"\n")
    except OSError:
        return None
    return data if hashlib.sha256(data).hexdigest().encode() == digest else None


def keep(file: Path, data: bytes) -> None:
    """Keep something in a file of the cache, for the user alone. A failure is silent: the next run does without."""
    import hashlib

    new = file.with_name(f".{os.urandom(8).hex()}")
    with suppress(OSError):
        _forget_some(file.parent)
        try:
            handle = os.open(new, os.O_WRONLY | os.O_CREAT | os.O_EXCL | os.O_NOFOLLOW, 0o600)
            with os.fdopen(handle, "wb") as opened:
                opened.write(hashlib.sha256(data).hexdigest().encode() + b"\n" + data)
            new.replace(file)
        finally:
            new.unlink(missing_ok=True)


MAX_KEPT = 400  # files of a folder of the cache; when there are more, the older half goes


def _forget_some(folder: Path) -> None:
    """Remove the older half of the files when there are many, with what killed runs left between them."""
    with os.scandir(folder) as entries:
        kept = sorted((entry.stat(follow_symlinks=False).st_mtime_ns, entry.name) for entry in entries)
    if len(kept) > MAX_KEPT:
        for _, name in kept[: len(kept) // 2]:
            with suppress(OSError):
                (folder / name).unlink()
