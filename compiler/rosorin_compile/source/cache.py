"""Cache results in ``Robot`` objects, and locate the user's cache folder (``ROSORIN_COMPILE_CACHE``)."""

import os
import stat
from collections.abc import Callable
from functools import wraps
from pathlib import Path
from typing import Any, TypeVar, cast

from . import system
from .files import label

Function = TypeVar("Function", bound=Callable[..., Any])

_ELSEWHERE = "ROSORIN_COMPILE_CACHE names another folder (off: no cache)"
_refused: list[tuple[str, str]] = []


def of_robot(work: Function) -> Function:
    """Cache the results of the decorated function in the ``Robot`` that is its first argument."""

    @wraps(work)
    def cached(robot: Any, *arguments: Any, **named: Any) -> Any:
        key = (work.__module__, work.__qualname__, arguments, *named.items())
        if key not in robot.worked_out:
            robot.worked_out[key] = work(robot, *arguments, **named)
        return robot.worked_out[key]

    return cast("Function", cached)


def cache_folder(name: str) -> Path | None:
    """Create and return a subfolder of the user's cache folder, or None if the cache is disabled or unsafe to use."""
    chosen = os.environ.get("ROSORIN_COMPILE_CACHE", "")
    base = Path(os.environ.get("XDG_CACHE_HOME", ""))
    if not base.is_absolute():  # according to the XDG specification, a relative XDG_CACHE_HOME is invalid
        # If HOME is empty, expanduser() would return "/.cache".
        base = Path("~/.cache").expanduser() if os.environ.get("HOME", "~") else Path()
    top = Path(os.path.abspath(chosen)) if chosen else base / "rosorin-compile"
    if chosen == "off" or not system.HAS_OWNERS or not top.is_absolute():
        return None
    folder = top / name
    try:
        for place in (top, folder):
            place.mkdir(0o700, parents=True, exist_ok=True)
        if (reason := _open_to_others(folder)) is not None:
            _refused[:] = [(f"{reason[0]}: nothing is kept in the cache {top}", reason[1])]
            return None
    except (OSError, ValueError, RuntimeError):
        return None
    return folder.resolve() if os.access(folder, os.W_OK) else None


def cache_refused() -> tuple[str, str] | None:
    """Return (reason, fix) once for each unsafe folder that ``cache_folder`` rejected, and then None."""
    return _refused.pop() if _refused else None


def _open_to_others(folder: Path) -> tuple[str, str] | None:
    real = folder.resolve(strict=True)
    links = [place for place in (folder, *folder.parents) if place.is_symlink()]
    for place in (*links, *reversed((real, *real.parents))):
        status = place.lstat()
        if status.st_uid not in (0, os.geteuid()):
            return f"{label(place)} belongs to another user", _ELSEWHERE
        # In a sticky folder such as /tmp, other users cannot rename or delete the cache folder.
        is_sticky = status.st_mode & stat.S_ISVTX and place not in (real, real.parent)
        if place not in links and status.st_mode & 0o022 and not is_sticky:
            return f"{label(place)} can be written by others", f"chmod go-w {label(place)}; or {_ELSEWHERE}"
    return None
