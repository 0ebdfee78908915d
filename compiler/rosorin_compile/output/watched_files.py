"""Detect changes in the files that were read to compile a robot."""

import os
import time
from collections.abc import Callable
from pathlib import Path

from rosorin_compile.source.files import Version, record_reads, version

INTERVAL = 0.3  # seconds between two checks
SETTLE = 0.05  # seconds without a change after which an editor has probably saved all files
_CLOCK_STEP = 20_000_000  # ns by which the times of files may lag behind the clock
_PATIENCE = 20  # maximum number of checks while files keep changing


class WatchedFiles:
    """The files that were read to compile a robot, with their versions, except files in the folder ``artifacts``."""

    def __init__(self, artifacts: Path | None = None) -> None:
        self.artifacts = None if artifacts is None else os.path.abspath(artifacts)
        self.versions: dict[str, Version] = {}
        self.is_outdated = False

    def has_changed(self) -> bool:
        """Return True if a file was changed, removed or created since the last call to ``read``."""
        return self.is_outdated or any(version(path) != before for path, before in self.versions.items())

    def settle(self, sleep: Callable[[float], None] = time.sleep) -> None:
        """Wait until the files stop changing, but at most one second."""
        before = [*map(version, self.versions)]
        for _ in range(_PATIENCE):
            sleep(SETTLE)
            after = [*map(version, self.versions)]
            if after == before:
                return
            before = after

    def read(self, used: Callable[[], object]) -> None:
        """Call ``used``, and watch every file that it reads or looks for."""
        begun = time.time_ns() - _CLOCK_STEP
        with record_reads() as paths:
            used()
        own, read = self.artifacts, {os.path.abspath(path): before for path, before in paths.items()}
        self.versions = {p: v for p, v in read.items() if own is None or not f"{p}{os.sep}".startswith(own + os.sep)}
        self.is_outdated = any(max(before[2:], default=0) > begun for before in self.versions.values())
