"""The console: diagnostics go to the person at once, or to a program as one document at the end.

``Console`` is what a command talks to; ``Progress`` shows a bar on the terminal for what takes longer than a second.
"""

from __future__ import annotations

import os
import sys
import time
from collections.abc import Callable, Sequence

from . import TRUSTED, Diagnostic
from .wording import and_more

# More than a person reads; a program gets all.
MAX_SHOWN = 200


class Console:
    """Prints what a run has to say, in one of the forms of ``report``."""

    def __init__(self, form: str) -> None:
        self.form = form
        self.collected: list[Diagnostic] = []
        self.ran = 0

    @property
    def for_people(self) -> bool:
        """Whether the output is text; otherwise standard output is one document for a program."""
        return self.form == "text"

    def show(self, diagnostics: Sequence[Diagnostic]) -> str:
        """Print diagnostics, or keep them for the end; return what was printed."""
        if not self.for_people:
            self.collected += diagnostics
            return ""
        from . import report

        text = report.text(diagnostics[:MAX_SHOWN], colour())
        if len(diagnostics) > MAX_SHOWN:
            text += f"...{and_more(len(diagnostics) - MAX_SHOWN)}; --format json lists them all\n"
        sys.stderr.write(text)
        return text

    def ahead(self, diagnostic: Diagnostic) -> None:
        """Print what has to be said before anything is run, and count it: what was run may do else the next time."""
        self.ran += 1
        if diagnostic.numbers != TRUSTED:
            self.show([diagnostic])

    def say(self, line: str) -> None:
        """Print a line about the run as a whole."""
        print(line, file=sys.stdout if self.for_people else sys.stderr)

    def warn(self, line: str) -> None:
        """Print a line about what keeps a run from its end."""
        sys.stderr.write(f"{line}\n")

    def finish(self) -> None:
        """Print the document of a run that is read by a program."""
        if not self.for_people:
            from . import report

            sys.stdout.write(report.FORMATS[self.form](self.collected))


def colour() -> bool:
    """Whether diagnostics are printed in colour: to a terminal, unless NO_COLOR is set (https://no-color.org)."""
    return sys.stderr.isatty() and "NO_COLOR" not in os.environ


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
