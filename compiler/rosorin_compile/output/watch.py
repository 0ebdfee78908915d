"""Watch: knowing that one of the files that a description was made from is not as it was when it was read."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable
from pathlib import Path

INTERVAL = 0.3  # seconds between two looks
SETTLE = 0.05  # seconds in which nothing may change any more: an editor is done with saving by then
_PATIENCE = 20  # looks at files that keep changing, until they are read as they are

Mark = tuple[int, int, int] | None


def mark(path: Path) -> Mark:
    """Return what tells a file from its next version: times, size, identity; None if there is none."""
    try:
        status = path.stat()
    except (OSError, ValueError):
        return None
    return (status.st_mtime_ns, status.st_size, status.st_ino)


class Inputs:
    """The files that one description was made from, each with its mark from before it was read."""

    def __init__(self) -> None:
        self.marks: dict[Path, Mark] = {}

    def changed(self) -> bool:
        """Say whether any of the files is not as it was."""
        return any(mark(path) != known for path, known in self.marks.items())

    def settle(self, sleep: Callable[[float], None] = time.sleep) -> None:
        """Wait until the files stop changing, for a second at most."""
        before = self._now(self.marks)
        for _ in range(_PATIENCE):
            sleep(SETTLE)
            after = self._now(self.marks)
            if after == before:
                return
            before = after

    def read(self, used: Callable[[], Iterable[Path]]) -> None:
        """Take down the files that ``used`` says it has read, as they were before it did.

        A file that was not known before has no mark from then. If it has changed since the reading began, nobody knows
        which version was read: it counts as changed, and is read once more.
        """
        begun = time.time_ns()
        before = self._now(self.marks)
        paths = list(dict.fromkeys(used()))
        now = time.time_ns()
        for path in paths:
            if path not in before:
                seen = mark(path)
                doubtful = seen is not None and begun <= seen[0] <= now
                before[path] = None if doubtful else seen
        self.marks = {path: before[path] for path in paths}

    @staticmethod
    def _now(paths: Iterable[Path]) -> dict[Path, Mark]:
        return {path: mark(path) for path in paths}
