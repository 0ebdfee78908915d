"""The user's cache: compiled templates, and the names of the artifacts that this user has made.

It is in the user's cache folder (XDG base directory specification), or in that of ``ROSORIN_COMPILE_CACHE``; ``off``
turns it off. Everything works without it.
"""

from __future__ import annotations

import json
import os
import stat
from collections.abc import Collection
from contextlib import suppress
from hashlib import blake2b
from pathlib import Path

from . import system
from .bounded import json_of
from .files import shown

_ELSEWHERE = "ROSORIN_COMPILE_CACHE names another folder (off: no cache)"
_refused: list[tuple[str, str]] = []


def cache_folder(name: str) -> Path | None:
    """Return a folder of the user's cache; None without one, or if anybody else but root could change what is in it.

    Compiled templates are run. ``cache_refused`` returns why a folder is not used.
    """
    top = _top()
    if top is None:
        return None
    folder = top / name
    try:
        for place in (top, folder):
            place.mkdir(0o700, parents=True, exist_ok=True)
        reason = _open_to_others(folder)
    except (OSError, ValueError, RuntimeError):
        return None
    if reason is not None:
        refused = (f"{reason[0]}: nothing is kept in the cache {top}", reason[1])
        if refused not in _refused:
            _refused.append(refused)
        return None
    return folder.resolve() if os.access(folder, os.W_OK) else None


def cache_refused() -> tuple[str, str] | None:
    """Return once why there is no cache though there could be one, and the way out."""
    first = _refused[0] if _refused else None
    _refused.clear()
    return first


def _open_to_others(folder: Path) -> tuple[str, str] | None:
    """Return who else could change what is in a folder of the cache, and the way out; None if only root can.

    In a folder above the cache others may write if it is sticky, as /tmp is. Raises OSError.
    """
    real = folder.resolve(strict=True)
    links = [place for place in (folder, *folder.parents) if place.is_symlink()]
    folders = (real, *real.parents)
    for place in (*links, *reversed(folders)):
        status = place.lstat()
        if status.st_uid not in (0, os.geteuid()):
            return f"{shown(place)} belongs to another user", _ELSEWHERE
        is_sticky = bool(status.st_mode & stat.S_ISVTX) and place not in folders[:2]
        if place not in links and status.st_mode & 0o022 and not is_sticky:
            return f"{shown(place)} can be written by others", f"chmod go-w {shown(place)}; or {_ELSEWHERE}"
    return None


def remember(path: Path, files: Collection[str] = (), complete: bool = True) -> None:
    """Store the names of the artifacts in a folder, or that the file ``path`` is an artifact.

    Without ``complete``, ``files`` are added to the names that are stored, if there are any. A failure is silent.
    """
    record, known = _record(path), remembered(path)
    names = set(files) if complete else set(files) | (known or set())
    if record is None or known == names or not (complete or known is not None):
        return
    with suppress(OSError):
        record.parent.mkdir(0o700, parents=True, exist_ok=True)
        new = record.with_name(f".{os.urandom(8).hex()}")
        new.write_text(json.dumps(sorted(names)), "utf-8")
        new.replace(record)


def remembered(path: Path) -> set[str] | None:
    """Return the names that ``remember`` stored, or None; also if others may have changed them."""
    record = _record(path)
    try:
        if record is None or not all(_is_private(place) for place in (record.parent, record)):
            return None
        names = json_of(record.read_bytes())
    except (OSError, ValueError):
        return None
    return {str(name) for name in names} if isinstance(names, list) else None


def _is_private(path: Path) -> bool:
    status = path.lstat()
    return system.is_own(status) and not status.st_mode & 0o022


def _record(path: Path) -> Path | None:
    top = _top()
    name = blake2b(os.fsencode(os.path.abspath(path)), digest_size=32).hexdigest()
    return top / "outputs" / f"{name}.json" if top is not None else None


def _top() -> Path | None:
    """Return the folder of the cache, absolute; None if there is to be none, or files have no owner here."""
    chosen = os.environ.get("ROSORIN_COMPILE_CACHE", "")
    if chosen == "off" or not system.HAS_OWNERS:
        return None
    base = Path(os.environ.get("XDG_CACHE_HOME", ""))
    if not base.is_absolute():  # an empty HOME would be the root of the disk
        base = Path("~/.cache").expanduser() if os.environ.get("HOME", "~") else Path()
    top = Path(os.path.abspath(chosen)) if chosen else base / "rosorin-compile"
    return top if top.is_absolute() else None
