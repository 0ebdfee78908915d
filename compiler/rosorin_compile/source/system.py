"""Replace functions that Windows lacks, such as file locks, and find installed Python packages."""

import errno
import os
import re
import shlex
from contextlib import suppress

AS_FOLDER, NO_WAIT = getattr(os, "O_DIRECTORY", 0), getattr(os, "O_NONBLOCK", 0)
AS_BYTES = getattr(os, "O_BINARY", 0)  # without this flag, Windows converts line ends
HAS_FORK, HAS_OWNERS = hasattr(os, "fork"), hasattr(os, "geteuid")
HAS_FOLDER_HANDLES = AS_FOLDER != 0  # False on Windows, which cannot open folders or rename open files

NO_LIMITS = "this system sets no limits to a process (resource): a file that asks for too much memory is not stopped"
_missed: dict[str, None] = {}


def is_own(status: os.stat_result) -> bool:
    """Return True if the current user owns a file, or if files have no owners (Windows)."""
    return not HAS_OWNERS or status.st_uid == os.geteuid()


def cores() -> int:
    """Return the number of CPU cores that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def needs(module: str, without: str) -> None:
    """Try to import a Python module; if it is missing, store the message ``without`` for ``take_missing``."""
    try:
        __import__(module)
    except ImportError:
        _missed[without] = None


def take_missing() -> list[str]:
    """Return and clear the messages that ``needs`` has stored."""
    messages = [*_missed]
    _missed.clear()
    return messages


def lock(handle: int, shared: bool = False, wait: bool = True) -> None:
    """Lock an open file until it is closed. Raises BlockingIOError if ``wait`` is False and the file is locked."""
    try:
        import fcntl
    except ImportError:
        raise OSError(errno.ENOLCK, os.strerror(errno.ENOLCK)) from None
    fcntl.flock(handle, (fcntl.LOCK_SH if shared else fcntl.LOCK_EX) | (0 if wait else fcntl.LOCK_NB))


def link(source: str | os.PathLike[str], target: str | os.PathLike[str]) -> None:
    """Create a hard link, even to a symlink. Raises OSError, with ENOTSUP if the system has no hard links."""
    try:
        os.link(source, target, follow_symlinks=False)
    except (AttributeError, NotImplementedError):
        raise OSError(errno.ENOTSUP, os.strerror(errno.ENOTSUP)) from None


def pip_install(extra: str) -> str:
    """Return the command that installs an extra; it lists the required packages, as this package is not on PyPI."""
    from importlib.metadata import PackageNotFoundError, requires

    of_extra = re.compile(rf"""\s*(?:;|\band)\s*extra\s*==\s*["']{extra}["']\s*$""")
    try:
        words = [of_extra.sub("", word) for word in requires("rosorin-compile") or () if of_extra.search(word)]
    except PackageNotFoundError:  # the package is not installed, but runs from a checkout
        words = [f"path/to/rosorin-compile[{extra}]"]
    return f"pip install {' '.join(map(shlex.quote, words))}"


def package_folders(name: str) -> list[str]:
    """Return the folders of a package, or the file of a module, without importing it; [] if it is not installed."""
    from importlib.util import find_spec

    with suppress(ImportError, ValueError, AttributeError):
        if (spec := find_spec(name)) is not None:
            return list(spec.submodule_search_locations or ()) or [spec.origin or name]
    return []


def is_installed(name: str) -> bool:
    """Return True if a Python package or module is installed. It is not imported."""
    return bool(package_folders(name))
