"""Notice changes of the input files of a robot."""

from __future__ import annotations

import hashlib
import os
import time
from collections.abc import Callable, Iterable
from pathlib import Path

INTERVAL = 0.3  # seconds between two checks
SETTLE = 0.05  # seconds without a change after which an editor has finished saving
_MAX_SETTLING = 20  # checks, after which files that keep changing are read as they are

_State = tuple[object, ...]  # what identifies a version of a file, and its content


class WatchedFiles:
    """The files and folders from which a robot was compiled, without those in the folder of its artifacts."""

    def __init__(self, artifacts: Path | None = None) -> None:
        self._artifacts = artifacts and Path(os.path.abspath(artifacts))
        self._states: dict[Path, _State] = {}

    def compile(self, function: Callable[[], Iterable[Path]]) -> None:
        """Call ``function`` and watch the paths that it returns. What changes in the meantime counts as changed."""
        start = time.time_ns() - 20_000_000  # the time of a file may be that of the last tick of the system's clock
        self._update()
        before, self._states = self._states, {}
        for path in {Path(os.path.abspath(path)) for path in function()}:
            if self._artifacts is None or not path.is_relative_to(self._artifacts):
                state = before.get(path) or _state(path)
                self._states[path] = ("changed",) if path not in before and _is_newer(path, start) else state

    def changed(self) -> bool:
        """Return True if a file has another content, is missing, or is no longer missing."""
        return any(_state(path, known)[-1] != known[-1] for path, known in self._states.items())

    def settle(self, sleep: Callable[[float], None] = time.sleep) -> None:
        """Wait until the files stop changing, at most a second."""
        for _ in range(_MAX_SETTLING):
            self._update()
            sleep(SETTLE)
            if not self.changed():
                return

    def _update(self) -> None:
        self._states = {path: _state(path, known) for path, known in self._states.items()}


def _state(path: Path, known: _State = ()) -> _State:
    try:
        status = path.stat()
        version = (status.st_ino, status.st_size, status.st_mtime_ns, status.st_ctime_ns)
        if known[:-1] == version:
            return known
        content = sorted(path.iterdir()) if path.is_dir() else hashlib.sha256(path.read_bytes()).hexdigest()
        return (*version, content)
    except OSError as problem:
        return (problem.errno,)


def _is_newer(path: Path, start: int) -> bool:
    try:
        status = path.stat()
        return max(status.st_mtime_ns, status.st_ctime_ns) >= start
    except OSError:
        return False
