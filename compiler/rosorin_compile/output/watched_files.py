"""Notice changes of the files from which a robot was compiled."""

from __future__ import annotations

import os
import time
from collections.abc import Callable
from pathlib import Path

from rosorin_compile.source.files import Version, recording, version

INTERVAL = 0.3  # seconds between two looks
SETTLE = 0.05  # seconds without a change after which an editor is taken to have saved everything
_CLOCK_STEP = 20_000_000  # ns: the times of files may be that much behind the clock
_PATIENCE = 20  # looks at files that keep changing before they are read anyway


class WatchedFiles:
    """The files from which one robot was made, except its own ``artifacts``, with their versions at that time."""

    def __init__(self, artifacts: Path | None = None) -> None:
        self.artifacts = None if artifacts is None else os.path.abspath(artifacts)
        self.versions: dict[str, Version] = {}
        self.is_outdated = False

    def has_changed(self) -> bool:
        """Return True if a file was written, removed or created since it was read or looked for."""
        return self.is_outdated or any(version(path) != before for path, before in self.versions.items())

    def settle(self, sleep: Callable[[float], None] = time.sleep) -> None:
        """Wait until the files stop changing, for a second at most."""
        before = [*map(version, self.versions)]
        for _ in range(_PATIENCE):
            sleep(SETTLE)
            after = [*map(version, self.versions)]
            if after == before:
                return
            before = after

    def read(self, used: Callable[[], object]) -> None:
        """Record which files ``used`` reads or looks for; what changes meanwhile is read once more."""
        begun = time.time_ns() - _CLOCK_STEP
        with recording() as paths:
            used()
        own, read = self.artifacts, {os.path.abspath(path): before for path, before in paths.items()}
        self.versions = {p: v for p, v in read.items() if own is None or not f"{p}{os.sep}".startswith(own + os.sep)}
        self.is_outdated = any(max(before[2:], default=0) > begun for before in self.versions.values())
