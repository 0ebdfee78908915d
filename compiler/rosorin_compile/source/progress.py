"""Progress: what is being done and how far it is, once that takes longer than a while.

Whoever does something that may take long says so with ``Progress.step``; that costs next to nothing, and nothing is
shown unless the command line asked for it with ``show``: for a person at a terminal, on whose last line it stands until
something else is printed.
"""

from __future__ import annotations

import os
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from typing import ClassVar, TextIO

from .wording import printable

AFTER = 2.0  # seconds
_EVERY = 0.1
_WIDTH = 30
_COLUMNS = 80


class _Line:
    """The last line of a terminal."""

    def __init__(self, stream: TextIO, clock: Callable[[], float]) -> None:
        self.stream, self.clock = stream, clock
        self.about = ""
        self.begin()

    def begin(self) -> None:
        """Begin anew: nothing is shown for a while."""
        self.due = self.next = self.clock() + AFTER
        self.text, self.shown = "", False

    def step(self, what: str, done: int, total: int, counted: bool, more: str = "") -> None:
        """Show a step when it is time; the first one of its kind at once, since none may follow for long."""
        now = self.clock()
        fresh = what != self.text
        self.text = what
        if now < (self.due if fresh else self.next):
            return
        self.next = now + _EVERY
        text = self._said(what, done, total, counted)
        if total:
            share = min(1.0, done / total)  # a recording may hold more than it says
            full = int(_WIDTH * share)
            text += f" [{'#' * full}{'.' * (_WIDTH - full)}] {int(100 * share):3d}%"
        text += printable(more)
        self.shown = True
        self._write(f"\r{_cut(text, self._columns() - 1)}\x1b[K")

    def _said(self, what: str, done: int, total: int, counted: bool) -> str:
        text = " ".join(filter(None, [printable(self.about), printable(what)]))
        if counted and (done or total):
            text += f" {done:,}" + (f" of {total:,}" if total else "")
        return text

    def wipe(self) -> None:
        """Wipe the line off."""
        if self.shown:
            self.shown = False
            self._write("\r\x1b[K")

    def _write(self, text: str) -> None:
        with suppress(OSError, ValueError):  # no run fails because nobody can see how far it is
            self.stream.write(text)
            self.stream.flush()

    def _columns(self) -> int:
        try:
            return os.get_terminal_size(self.stream.fileno()).columns or _COLUMNS
        except (OSError, ValueError, AttributeError):
            return _COLUMNS


class Progress:
    """What takes long in this process: there is one line on which it is shown, and whoever does something says so.

    ``AFTER`` is after how long (s) it is shown.
    """

    AFTER = AFTER
    _line: ClassVar[_Line | None] = None

    @classmethod
    def show(cls, stream: TextIO, clock: Callable[[], float] | None = None) -> None:
        """Show from now on what takes long, on a stream that is a terminal; ``clock`` gives seconds."""
        cls._line = _Line(stream, clock or (lambda: time.monotonic()))

    @classmethod
    def hide(cls) -> None:
        """Wipe the line off, and show nothing any more."""
        cls.wipe()
        cls._line = None

    @classmethod
    def begin(cls) -> None:
        """Begin anew: what takes long is counted from here, as by ``watch`` for each change."""
        if cls._line is not None:
            cls._line.wipe()
            cls._line.begin()

    @classmethod
    def about(cls, what: str) -> None:
        """Say which of several things the steps are about from now on, such as the name of a robot."""
        if cls._line is not None:
            cls._line.about = what

    @classmethod
    def step(cls, what: str, done: int = 0, total: int = 0, counted: bool = True, more: str = "") -> None:
        """Say what is being done now, and that ``done`` of ``total`` (0: nobody knows) are; not ``counted``: a share.

        ``more`` stands behind it, such as a rate.
        """
        if cls._line is not None:
            cls._line.step(what, done, total, counted, more)

    @classmethod
    @contextmanager
    def within(cls) -> Iterator[None]:
        """Show nothing of the steps within a step that is shown already."""
        line, cls._line = cls._line, None
        try:
            yield
        finally:
            cls._line = line

    @classmethod
    def part(cls, what: str, index: int, count: int) -> Callable[[float], None]:
        """Return what is told the share (0 to 1) that is done of one part of several."""
        return lambda share: cls.step(what, int(1000 * (index + share)), 1000 * count, counted=False)

    @classmethod
    def wipe(cls) -> None:
        """Wipe the line off, before something else is printed."""
        if cls._line is not None:
            cls._line.wipe()


def _cut(text: str, columns: int) -> str:
    """Return as much of a text as fits on a line; a letter that is no ASCII may be two columns wide."""
    width = 0
    for index, letter in enumerate(text):
        width += 1 if letter.isascii() else 2
        if width > columns:
            return text[:index]
    return text
