"""Show progress in one line at the end of a terminal, two seconds after the command line called ``Progress.show``."""

from __future__ import annotations

import os
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from typing import ClassVar, TextIO

from .wording import printable

_DELAY, _INTERVAL = 2.0, 0.1  # seconds before the line is shown, and between two changes of it
_WIDTH = 30  # of the bar


class Progress:
    """The progress line of this process."""

    _stream: ClassVar[TextIO | None] = None
    _topic = _kind = ""
    _due = _next = 0.0  # when the first step is shown, and when the next one of the same kind
    _is_shown = False

    @classmethod
    def show(cls, stream: TextIO) -> None:
        """Show progress from now on, on a stream that is a terminal."""
        cls._stream, cls._topic = stream, ""
        cls.begin()

    @classmethod
    def hide(cls) -> None:
        cls.wipe()
        cls._stream = None

    @classmethod
    def begin(cls) -> None:
        """Restart the delay, as ``watch`` does for each change."""
        cls.wipe()
        cls._due, cls._next, cls._kind = time.monotonic() + _DELAY, 0.0, ""

    @classmethod
    def set_topic(cls, topic: str) -> None:
        """Begin the line with a topic from now on, such as the name of a robot."""
        cls._topic = topic

    @classmethod
    def step(cls, what: str, done: int = 0, total: int = 0, counted: bool = True) -> None:
        """Show that ``done`` of ``total`` (0 if unknown) steps are done; if not ``counted``, without the numbers."""
        if cls._stream is None:
            return
        now, is_new, cls._kind = time.monotonic(), what != cls._kind, what
        if now < cls._due or (now < cls._next and not is_new):
            return
        cls._next = now + _INTERVAL
        text = printable(f"{cls._topic} {what}".strip())
        text += f" {done:,}" if counted and (done or total) else ""
        if total:
            share = min(1.0, done / total)  # a recording may contain more than it declares
            text += f" of {total:,}" if counted else ""
            text += f" [{'#' * int(_WIDTH * share):.<{_WIDTH}}] {int(100 * share):3d}%"
        columns = 80
        with suppress(OSError, ValueError, AttributeError):
            columns = os.get_terminal_size(cls._stream.fileno()).columns or columns
        while len(text) + sum(not letter.isascii() for letter in text) >= columns:  # those may be two columns wide
            text = text[:-1]
        cls._write(f"\r{text}\x1b[K", True)

    @classmethod
    @contextmanager
    def hide_steps(cls) -> Iterator[None]:
        """Show no steps in the block, which is a step itself."""
        stream, cls._stream = cls._stream, None
        try:
            yield
        finally:
            cls._stream = stream

    @classmethod
    def wipe(cls) -> None:
        """Erase the line, before something else is printed."""
        if cls._is_shown:
            cls._write("\r\x1b[K", False)

    @classmethod
    def _write(cls, text: str, shown: bool) -> None:
        cls._is_shown = shown
        with suppress(OSError, ValueError, AttributeError):  # a run does not fail because nothing can be shown
            cls._stream.write(text)  # type: ignore[union-attr]
            cls._stream.flush()  # type: ignore[union-attr]
