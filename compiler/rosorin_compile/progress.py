"""A bar on the terminal for what takes longer than a second."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable

_AFTER = 1.0  # seconds
_EVERY = 0.1
_WIDTH = 30


class Progress:
    """Shows on standard error how far something is, if that is a terminal and it takes long; leaves nothing behind."""

    def __init__(self, what: str) -> None:
        self.what = what
        self.begun = time.monotonic()
        self.next = self.begun + _AFTER
        self.shown = False

    def __call__(self, done: int, total: int) -> None:
        """Say that ``done`` of ``total`` are done."""
        now = time.monotonic()
        if now < self.next or not sys.stderr.isatty():
            return
        self.next = now + _EVERY
        self.shown = True
        share = min(1.0, done / max(total, 1))  # a recording may hold more than it says
        full = int(_WIDTH * share)
        bar = "#" * full + "." * (_WIDTH - full)
        sys.stderr.write(f"\r{self.what} [{bar}] {int(100 * share):3d}%")
        sys.stderr.flush()

    def part(self, index: int, count: int) -> Callable[[float], None]:
        """Return what is told the share (0 to 1) that is done of one part of several."""
        return lambda share: self(int(1000 * (index + share)), 1000 * count)

    def end(self) -> None:
        """Wipe the bar off."""
        if self.shown:
            sys.stderr.write("\r\x1b[K")
            sys.stderr.flush()
            self.shown = False
