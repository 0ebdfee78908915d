"""System: what not every system has, in one place: whose a file is, locks, and how a file or folder is opened.

Windows has none of what POSIX says of them. There a file is taken to be this user's, runs go on without a lock, as they
do on a network drive that has none, and a folder is known by its path alone.
"""

from __future__ import annotations

import errno
import os

# How ``os.open`` is asked; what a system does not know is not asked for.
AS_FOLDER = getattr(os, "O_DIRECTORY", 0)
NO_LINK = getattr(os, "O_NOFOLLOW", 0)
NO_WAIT = getattr(os, "O_NONBLOCK", 0)
AS_BYTES = getattr(os, "O_BINARY", 0)  # else Windows makes two characters of the end of a line

HAS_FORK = hasattr(os, "fork")
HAS_OWNERS = hasattr(os, "geteuid")
HAS_FOLDER_HANDLES = AS_FOLDER != 0  # and what is open can be moved: Windows has neither

NO_LIMITS = "this system sets no limits to a process (resource): a file that asks for too much memory is not stopped"
_missed: list[str] = []


def is_own(status: os.stat_result) -> bool:
    """Say whether a file is this user's; where files have no owner, it is."""
    return not HAS_OWNERS or status.st_uid == os.geteuid()


def cores() -> int:
    """Return how many cores this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def needs(module: str, without: str) -> None:
    """Note what goes on without a module of Python that this system may not have; ``missed`` tells it."""
    try:
        __import__(module)
    except ImportError:
        if without not in _missed:
            _missed.append(without)


def missed() -> list[str]:
    """Return what a run had to do without; once."""
    told = _missed.copy()
    _missed.clear()
    return told


def lock(handle: int, shared: bool = False, wait: bool = True) -> None:
    """Hold the lock on an open file or folder until it is closed.

    Raises OSError: BlockingIOError for one that another process holds, ENOLCK where there are none.
    """
    try:
        import fcntl
    except ImportError:
        raise OSError(errno.ENOLCK, os.strerror(errno.ENOLCK)) from None
    how = fcntl.LOCK_SH if shared else fcntl.LOCK_EX
    fcntl.flock(handle, how if wait else how | fcntl.LOCK_NB)


def link(source: str | os.PathLike[str], target: str | os.PathLike[str]) -> None:
    """Let a file stand under a second name; of a link, the link itself. Raises OSError, ENOTSUP where none can be."""
    try:
        os.link(source, target, follow_symlinks=False)
    except (AttributeError, NotImplementedError):
        raise OSError(errno.ENOTSUP, os.strerror(errno.ENOTSUP)) from None
