"""Notice changes of the files from which a robot was compiled."""

from __future__ import annotations

import hashlib
import os
import time
from collections.abc import Callable
from pathlib import Path

from rosorin_compile.source.files import Version, read_bytes, recording, version

INTERVAL = 0.3  # seconds between two looks
SETTLE = 0.05  # seconds in which nothing may change any more: an editor is done with saving by then
_SMALL = 1_000_000  # bytes: a larger file is told by its times alone
_CLOCK_STEP = 20_000_000  # ns: the times of files may be that much behind the clock
_PATIENCE = 20  # looks at files that keep changing, until they are read as they are


class WatchedFiles:
    """The files that one robot was made from, but for its own artifacts, with the state in which they were."""

    def __init__(self, artifacts: Path | None = None) -> None:
        self.artifacts = None if artifacts is None else os.path.abspath(artifacts)
        self.states: list[State] = []
        self.is_outdated = False

    def changed(self) -> bool:
        """Whether a file has another content, has gone or has come since it was read or looked for."""
        return self.is_outdated or any(state.differs() for state in self.states)

    def settle(self, sleep: Callable[[float], None] = time.sleep) -> None:
        """Wait until the files stop changing, for a second at most."""
        before = [version(state.path) for state in self.states]
        for _ in range(_PATIENCE):
            sleep(SETTLE)
            after = [version(state.path) for state in self.states]
            if after == before:
                return
            before = after

    def read(self, used: Callable[[], object]) -> None:
        """Take down which files ``used`` reads or looks for; what changes meanwhile is read once more."""
        begun = time.time_ns() - _CLOCK_STEP
        with recording() as paths:
            used()
        own = self.artifacts
        read = {os.path.abspath(path): of for path, of in paths.items()}
        self.states = [State(path) for path in read if own is None or not _is_within(path, own)]
        self.is_outdated = any(
            state.version != read[state.path] or max(state.version[2:], default=0) > begun for state in self.states
        )


class State:
    """A file as it is now, there or not."""

    def __init__(self, path: str) -> None:
        self.path = path
        self.version = version(path)
        content = _content(path, self.version)
        self.content = content if version(path) == self.version else None  # that may be the content of the next one

    def differs(self) -> bool:
        """Whether the file is another one by now."""
        now = version(self.path)
        return now != self.version and _content(self.path, now) != self.content


def _content(path: str, now: Version) -> object:
    """Return what a file holds, in short; of what is large or no file, its version."""
    if len(now) < 2 or now[1] > _SMALL:
        return now
    try:
        return hashlib.sha256(read_bytes(path)).digest()
    except OSError:
        return ()


def _is_within(path: str, folder: str) -> bool:
    return path == folder or path.startswith(folder + os.sep)
