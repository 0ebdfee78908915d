"""Watch: knowing that one of the files that a description was made from is not as it was when it was read.

``Said`` knows what a run before has said already.
"""

from __future__ import annotations

import time
from collections import Counter
from collections.abc import Callable, Iterable
from pathlib import Path

from ..diagnostics import ERROR, Diagnostic, has_errors

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


class Said:
    """What has been said of a robot, so that it is not said again at each save."""

    def __init__(self) -> None:
        self.known: Counter[tuple[str, ...]] = Counter()

    def new(self, diagnostics: Iterable[Diagnostic]) -> list[Diagnostic]:
        """Return the diagnostics that the run before did not have, and remember all of them.

        One whose line has only moved is the same. An error hides what is asked after it: what was said of that is not
        forgotten before a run without errors.
        """
        told = list(diagnostics)
        left, new = self.known.copy(), []
        for one in told:
            key = _same(one)
            if left[key]:
                left[key] -= 1
            else:
                new.append(one)
        hidden = Counter({key: n for key, n in left.items() if key[0] != ERROR}) if has_errors(told) else Counter()
        self.known = Counter(map(_same, told)) + hidden
        return new


def _same(one: Diagnostic) -> tuple[str, ...]:
    """Return what is the same of a diagnostic as long as nobody touches its line."""
    place = (one.span.source.path, one.span.source.line(one.span.line).strip()) if one.span else ()
    return (one.severity, one.rule, one.message, *place)
