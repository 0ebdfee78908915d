"""The user's cache: files that only the user can change, kept between runs; all works without them.

A command that has nothing to do asks it before anything else is imported: it gets by with what Python has loaded.
"""

from __future__ import annotations

import errno
import os
import stat
from typing import TYPE_CHECKING

from . import system

if TYPE_CHECKING:
    from collections.abc import Collection, Iterator
    from pathlib import Path

try:
    from _blake2 import blake2b  # hashlib imports OpenSSL for the same
except ImportError:
    from hashlib import blake2b

_ELSEWHERE = "ROSORIN_COMPILE_CACHE names another folder (off: no cache)"
_refused: list[tuple[str, str]] = []


def digest(data: bytes) -> str:
    """Return what tells data from all other."""
    made: str = blake2b(data, digest_size=32).hexdigest()
    return made


def sha256(data: bytes) -> str:
    """Return what tells data from all other, as other programs print it."""
    try:
        from _sha256 import sha256  # type: ignore[import-not-found]
    except ImportError:  # later Pythons have it in _sha2
        from hashlib import sha256
    made: str = sha256(data).hexdigest()
    return made


def cache_folder(name: str) -> Path | None:
    """Return the folder for one kind of cached files, as ``private_folder``; None if there is no such place."""
    from pathlib import Path

    folder = private_folder(name)
    return Path(folder) if folder else None


def private_folder(name: str) -> str:
    """Return the folder for one kind of cached files, which only the user can change; "" if there is no such place.

    ``ROSORIN_COMPILE_CACHE`` names another place; ``off`` turns caching off. Otherwise the XDG base directory
    specification holds. What is cached is run (templates) and believed (stamps): a folder that anybody else but root
    could change, or put another one in the place of, is none; ``cache_refused`` says so. Where files have no owner,
    nobody can know, and nothing is kept.
    """
    top = _cache_top() if system.HAS_OWNERS else ""
    if not top:
        return ""
    folder = os.path.join(top, name)
    try:
        for place in _above(folder):
            if not os.path.lexists(place):
                try:
                    os.mkdir(place, 0o700)
                except FileExistsError:  # another run was quicker
                    pass
        open_to, way_out = _open_to_others(folder)
    except (OSError, ValueError):
        return ""
    if open_to:
        told = (f"{open_to}: nothing is kept in the cache {top}", way_out)
        if told not in _refused:
            _refused.append(told)
        return ""
    return os.path.realpath(folder) if os.access(folder, os.W_OK) else ""


def cache_refused() -> tuple[str, str] | None:
    """Return why there is no cache though there could be one, and the way out; once."""
    first = _refused[0] if _refused else None
    _refused.clear()
    return first


def _cache_top() -> str:
    """Return the folder of the cache, absolute; "" if there is to be none, or no place for one."""
    chosen = os.environ.get("ROSORIN_COMPILE_CACHE", "")
    if chosen:
        return "" if chosen == "off" else os.path.abspath(chosen)
    base = os.environ.get("XDG_CACHE_HOME", "")
    if not os.path.isabs(base):  # an empty one is none, and a relative one does not count by XDG
        # It stays as it is for a user without a home; an empty HOME would be the root of the disk.
        base = os.path.expanduser("~/.cache") if os.environ.get("HOME", "~") else ""
    return os.path.join(base, "rosorin-compile") if os.path.isabs(base) else ""


def _open_to_others(folder: str) -> tuple[str, str]:
    """Return who else could change what is in a folder of the cache, and the way out; empty if only root can.

    In a folder above others may write if it is sticky, as /tmp is: what stands there is its owner's. Raises OSError.
    """
    for place in _way(folder, 40):
        status = os.lstat(place)
        open_mode = not stat.S_ISLNK(status.st_mode) and status.st_mode & 0o022 and not status.st_mode & stat.S_ISVTX
        if status.st_uid not in (0, os.geteuid()) or open_mode:
            return _told(place, not open_mode)
    for place in (os.path.dirname(folder), folder):
        status = os.stat(place)
        if not system.is_own(status) or status.st_mode & 0o022:
            return _told(place, not system.is_own(status))
    return "", ""


def _told(place: str, foreign: bool) -> tuple[str, str]:
    named = shown(place)
    if foreign:
        return f"{named} belongs to another user", _ELSEWHERE
    return f"{named} can be written by others", f"chmod go-w {named}; or {_ELSEWHERE}"


def shown(path: str | os.PathLike[str]) -> str:
    """Return a path as a person would name it: relative to here if it is below."""
    path = os.fspath(path)
    try:
        here = os.path.relpath(path)
    except (OSError, ValueError):  # the folder of this process is gone, or on another drive
        return path
    return path if here.startswith("..") and os.path.isabs(path) else here


def _above(path: str) -> list[str]:
    """Return each folder on the way to an absolute path, and that path."""
    places = [path]
    while (above := os.path.dirname(places[-1])) != places[-1]:
        places.append(above)
    return places[::-1]


def _way(path: str, links: int) -> Iterator[str]:
    """Yield each folder on the way to an absolute path, and of each link that it leads through too. Raises OSError."""
    for place in _above(path):
        yield place
        if os.path.islink(place):
            if not links:
                raise OSError(errno.ELOOP, os.strerror(errno.ELOOP), place)
            target = os.path.join(os.path.dirname(place), os.readlink(place))
            yield from _way(os.path.abspath(target), links - 1)


def recalled(file: str | os.PathLike[str]) -> bytes | None:
    """Return what was kept in a file of the cache; None if there is none, or it is damaged in whatever way."""
    try:
        handle = os.open(file, os.O_RDONLY | system.NO_LINK | system.NO_WAIT)
        with open(handle, "rb") as opened:
            status = os.fstat(handle)
            if not stat.S_ISREG(status.st_mode) or not system.is_own(status) or status.st_mode & 0o022:
                return None
            kept, _, data = opened.read().partition(b"\n")
    except OSError:
        return None
    return data if digest(data).encode() == kept else None


def keep(file: str | os.PathLike[str], data: bytes) -> None:
    """Keep something in a file of the cache, for the user alone. A failure is silent: the next run does without."""
    folder = os.path.dirname(file)
    new = os.path.join(folder, f".{os.urandom(8).hex()}")
    try:
        _forget_some(folder)
        handle = os.open(new, os.O_WRONLY | os.O_CREAT | os.O_EXCL | system.NO_LINK, 0o600)
        try:
            with open(handle, "wb") as opened:
                opened.write(digest(data).encode() + b"\n" + data)
            os.replace(new, file)
        except BaseException:
            os.unlink(new)
            raise
    except OSError:
        pass


MAX_KEPT = 400  # files of a folder of the cache; when there are more, the older half goes


def _forget_some(folder: str) -> None:
    """Remove the older half of the files when there are many, with what killed runs left between them."""
    with os.scandir(folder) as entries:
        kept = sorted((entry.stat(follow_symlinks=False).st_mtime_ns, entry.name) for entry in entries)
    if len(kept) > MAX_KEPT:
        for _, name in kept[: len(kept) // 2]:
            try:
                os.unlink(os.path.join(folder, name))
            except OSError:
                pass


def remember(path: Path, files: Collection[str] = (), complete: bool = True) -> None:
    """Store the names of the artifacts in a folder, or that the file ``path`` is an artifact, in the user's cache.

    Without ``complete``, ``files`` are added to the names that are stored, if there are any.
    """
    record, known = _record(path), remembered(path)
    import json

    names = set(files) if complete else set(files) | (known or set())
    if record is not None and known != names and (complete or known is not None):
        keep(record, json.dumps(sorted(names)).encode())


def remembered(path: Path) -> set[str] | None:
    """Return the names that ``remember`` stored, or None."""
    from .bounded import json_of

    record = _record(path)
    try:
        names = json_of((recalled(record) if record else None) or b"null")
    except ValueError:
        return None
    return {str(name) for name in names} if isinstance(names, list) else None


def _record(path: Path) -> Path | None:
    folder = cache_folder("outputs")
    return folder and folder / f"{sha256(os.fsencode(os.path.abspath(path)))}.json"
