"""The user's cache: files between runs that only the user can change. Everything works without them."""

from __future__ import annotations

import errno
import json
import os
import stat
from collections.abc import Collection, Iterator
from hashlib import blake2b
from pathlib import Path

from . import system
from .bounded import json_of
from .files import shown

MAX_KEPT = 400  # files of a folder of the cache; when there are more, the older half is deleted

_ELSEWHERE = "ROSORIN_COMPILE_CACHE names another folder (off: no cache)"
_refused: list[tuple[str, str]] = []


def digest(data: bytes) -> str:
    """Return a short text that differs for different data."""
    return blake2b(data, digest_size=32).hexdigest()


def cache_folder(name: str) -> Path | None:
    """Return the folder for one kind of cached files, which only the user can change; None without such a place.

    ``ROSORIN_COMPILE_CACHE`` names another place; ``off`` turns caching off. Otherwise the XDG base directory
    specification holds. Cached templates are run: a folder that anybody else but root could change or replace is not
    used, and ``cache_refused`` returns the reason. Where files have no owner, there is no cache.
    """
    top = _cache_top() if system.HAS_OWNERS else None
    if top is None:
        return None
    folder = top / name
    try:
        for place in (*reversed(folder.parents), folder):
            if not os.path.lexists(place):
                place.mkdir(0o700, exist_ok=True)
        reason, way_out = _open_to_others(folder)
    except (OSError, ValueError):
        return None
    if reason:
        refused = (f"{reason}: nothing is kept in the cache {top}", way_out)
        if refused not in _refused:
            _refused.append(refused)
        return None
    return folder.resolve() if os.access(folder, os.W_OK) else None


def cache_refused() -> tuple[str, str] | None:
    """Return once why there is no cache though there could be one, and the way out."""
    first = _refused[0] if _refused else None
    _refused.clear()
    return first


def _cache_top() -> Path | None:
    """Return the folder of the cache, absolute; None if there is to be none, or no place for one."""
    chosen = os.environ.get("ROSORIN_COMPILE_CACHE", "")
    if chosen:
        return None if chosen == "off" else Path(os.path.abspath(chosen))
    base = os.environ.get("XDG_CACHE_HOME", "")
    if not Path(base).is_absolute():  # an empty one is none, and a relative one does not count by XDG
        # An empty HOME would be the root of the disk.
        base = os.path.expanduser("~/.cache") if os.environ.get("HOME", "~") else ""
    return Path(base, "rosorin-compile") if Path(base).is_absolute() else None


def _open_to_others(folder: Path) -> tuple[str, str]:
    """Return who else could change what is in a folder of the cache, and the way out; empty if only root can.

    In a folder above others may write if it is sticky, as /tmp is: what stands there is its owner's. Raises OSError.
    """
    for place in _way(folder, 40):
        status = place.lstat()
        open_mode = not stat.S_ISLNK(status.st_mode) and status.st_mode & 0o022 and not status.st_mode & stat.S_ISVTX
        if status.st_uid not in (0, os.geteuid()) or open_mode:
            return _reason(place, not open_mode)
    for place in (folder.parent, folder):
        status = place.stat()
        if not system.is_own(status) or status.st_mode & 0o022:
            return _reason(place, not system.is_own(status))
    return "", ""


def _reason(place: Path, foreign: bool) -> tuple[str, str]:
    named = shown(place)
    if foreign:
        return f"{named} belongs to another user", _ELSEWHERE
    return f"{named} can be written by others", f"chmod go-w {named}; or {_ELSEWHERE}"


def _way(path: Path, links: int) -> Iterator[Path]:
    """Yield each folder on the way to an absolute path, and of each link that it leads through too. Raises OSError."""
    for place in (*reversed(path.parents), path):
        yield place
        if place.is_symlink():
            if not links:
                raise OSError(errno.ELOOP, os.strerror(errno.ELOOP), os.fspath(place))
            yield from _way(Path(os.path.abspath(place.parent / place.readlink())), links - 1)


def recalled(file: str | os.PathLike[str]) -> bytes | None:
    """Return what was kept in a file of the cache; None without one, or if it is damaged in whatever way."""
    try:
        handle = os.open(file, os.O_RDONLY | system.NO_LINK | system.NO_WAIT)
        with os.fdopen(handle, "rb") as opened:
            status = os.fstat(handle)
            if not stat.S_ISREG(status.st_mode) or not system.is_own(status) or status.st_mode & 0o022:
                return None
            kept, _, data = opened.read().partition(b"\n")
    except OSError:
        return None
    return data if digest(data).encode() == kept else None


def keep(file: str | os.PathLike[str], data: bytes) -> None:
    """Keep something in a file of the cache, for the user alone. A failure is silent: the next run does without."""
    folder = Path(file).parent
    new = folder / f".{os.urandom(8).hex()}"
    try:
        _forget_some(folder)
        handle = os.open(new, os.O_WRONLY | os.O_CREAT | os.O_EXCL | system.NO_LINK, 0o600)
        try:
            with os.fdopen(handle, "wb") as opened:
                opened.write(digest(data).encode() + b"\n" + data)
            new.replace(file)
        except BaseException:
            new.unlink()
            raise
    except OSError:
        pass


def _forget_some(folder: Path) -> None:
    """Delete the older half of the files when there are many."""
    kept = sorted((path.lstat().st_mtime_ns, path) for path in folder.iterdir())
    for _, path in kept[: len(kept) // 2] if len(kept) > MAX_KEPT else ():
        path.unlink(missing_ok=True)


def remember(path: Path, files: Collection[str] = (), complete: bool = True) -> None:
    """Store the names of the artifacts in a folder, or that the file ``path`` is an artifact, in the user's cache.

    Without ``complete``, ``files`` are added to the names that are stored, if there are any.
    """
    record, known = _record(path), remembered(path)
    names = set(files) if complete else set(files) | (known or set())
    if record is not None and known != names and (complete or known is not None):
        keep(record, json.dumps(sorted(names)).encode())


def remembered(path: Path) -> set[str] | None:
    """Return the names that ``remember`` stored, or None."""
    record = _record(path)
    try:
        names = json_of((recalled(record) if record else None) or b"null")
    except ValueError:
        return None
    return {str(name) for name in names} if isinstance(names, list) else None


def _record(path: Path) -> Path | None:
    folder = cache_folder("outputs")
    return folder and folder / f"{digest(os.fsencode(os.path.abspath(path)))}.json"
