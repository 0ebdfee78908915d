"""Watch: knowing that what a description was made from is not as it was when it was read.

``Said`` knows what a run before has said already.
"""

from __future__ import annotations

import os
import time
from collections import Counter
from collections.abc import Callable, Iterable
from pathlib import Path

from rosorin_compile.source.diagnostics import ERROR, Diagnostic, has_errors
from rosorin_compile.source.world import Notes, memory, noting

INTERVAL = 0.3  # seconds between two looks
SETTLE = 0.05  # seconds in which nothing may change any more: an editor is done with saving by then
_PATIENCE = 20  # looks at files that keep changing, until they are read as they are


class Inputs:
    """What one robot was made from: what was asked for it, but of its own artifacts, and what was answered."""

    def __init__(self, artifacts: Path | None = None) -> None:
        self.artifacts = None if artifacts is None else os.path.abspath(artifacts)
        self.notes = Notes()

    def changed(self) -> bool:
        """Say whether any of it would be answered otherwise."""
        return not memory.holds(self.notes)

    def settle(self, sleep: Callable[[float], None] = time.sleep) -> None:
        """Wait until the files stop changing, for a second at most."""
        before = memory.answers_now(self.notes)
        for _ in range(_PATIENCE):
            sleep(SETTLE)
            after = memory.answers_now(self.notes)
            if after == before:
                return
            before = after

    def read(self, used: Callable[[], object]) -> None:
        """Take down what ``used`` asks; what has changed in the meantime is read once more."""
        with noting() as notes:
            used()
        own = self.artifacts
        if own is not None:
            inside = own + os.sep
            notes.answers = {q: a for q, a in notes.answers.items() if q[1] != own and not q[1].startswith(inside)}
        self.notes = notes


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
