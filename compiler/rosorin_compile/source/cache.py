"""Cache results with a robot, and locate the user's cache folder (XDG, or ``ROSORIN_COMPILE_CACHE``; off: no cache)."""

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
    """Decorate a function whose first argument is a robot: cache its results in the robot object."""

    @wraps(work)
    def cached(robot: Any, *arguments: Any, **named: Any) -> Any:
        key = (work.__module__, work.__qualname__, arguments, *named.items())
        if key not in robot.worked_out:
            robot.worked_out[key] = work(robot, *arguments, **named)
        return robot.worked_out[key]

    return cast("Function", cached)


def cache_folder(name: str) -> Path | None:
    """Return a subfolder of the user's cache, or None if the cache is disabled, or writable by other users."""
    chosen = os.environ.get("ROSORIN_COMPILE_CACHE", "")
    base = Path(os.environ.get("XDG_CACHE_HOME", ""))
    if not base.is_absolute():  # the XDG specification ignores relative paths; with HOME="", "~" would be "/"
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
    """Return why the cache is not used, and the fix, or None; each reason is returned only once."""
    return _refused.pop() if _refused else None


def _open_to_others(folder: Path) -> tuple[str, str] | None:
    """Return why other users could change a cache folder, and the fix, or None if they cannot. Raises OSError."""
    real = folder.resolve(strict=True)
    links = [place for place in (folder, *folder.parents) if place.is_symlink()]
    for place in (*links, *reversed((real, *real.parents))):
        status = place.lstat()
        if status.st_uid not in (0, os.geteuid()):
            return f"{label(place)} belongs to another user", _ELSEWHERE
        is_sticky = status.st_mode & stat.S_ISVTX and place not in (real, real.parent)  # such as /tmp, which is safe
        if place not in links and status.st_mode & 0o022 and not is_sticky:
            return f"{label(place)} can be written by others", f"chmod go-w {label(place)}; or {_ELSEWHERE}"
    return None
