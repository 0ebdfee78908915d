"""Print progress on the last line of a terminal, starting two seconds after ``Progress.show`` or ``begin``."""

import os
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from typing import ClassVar, TextIO

from .wording import printable

_DELAY, _INTERVAL = 2.0, 0.1  # seconds before the line is printed, and between updates
_WIDTH = 30  # characters of the progress bar


class Progress:
    """The progress line of this process."""

    _stream: ClassVar[TextIO | None] = None
    _topic = _kind = ""
    _due = _next = 0.0  # monotonic times (s): of the first output, and of the next update for the same activity
    _is_shown = False

    @classmethod
    def show(cls, stream: TextIO) -> None:
        """Start to print progress to a terminal."""
        cls._stream, cls._topic = stream, ""
        cls.begin()

    @classmethod
    def hide(cls) -> None:
        cls.wipe()
        cls._stream = None

    @classmethod
    def begin(cls) -> None:
        """Restart the delay before the first output, as ``watch`` does for each change of a file."""
        cls.wipe()
        cls._due, cls._next, cls._kind = time.monotonic() + _DELAY, 0.0, ""

    @classmethod
    def set_topic(cls, topic: str) -> None:
        """Prefix the line with a topic, such as the name of a robot."""
        cls._topic = topic

    @classmethod
    def step(cls, what: str, done: int = 0, total: int = 0, counted: bool = True) -> None:
        """Print that ``done`` of ``total`` steps (0 if unknown) are done, or only the bar if ``counted`` is False."""
        if cls._stream is None:
            return
        now, is_new, cls._kind = time.monotonic(), what != cls._kind, what
        if now < cls._due or (now < cls._next and not is_new):
            return
        cls._next = now + _INTERVAL
        text = printable(f"{cls._topic} {what}".strip())
        text += f" {done:,}" if counted and (done or total) else ""
        if total:
            share = min(1.0, done / total)  # a recording may have more messages than its header declares
            text += f" of {total:,}" if counted else ""
            text += f" [{'#' * int(_WIDTH * share):.<{_WIDTH}}] {int(100 * share):3d}%"
        columns = 80
        with suppress(OSError, ValueError, AttributeError):
            columns = os.get_terminal_size(cls._stream.fileno()).columns or columns
        while len(text) + sum(not letter.isascii() for letter in text) >= columns:  # non-ASCII letters may be wide
            text = text[:-1]
        cls._write(f"\r{text}\x1b[K", True)

    @classmethod
    @contextmanager
    def hide_steps(cls) -> Iterator[None]:
        """Suspend progress in the block, which is a single step of the caller."""
        stream, cls._stream = cls._stream, None
        try:
            yield
        finally:
            cls._stream = stream

    @classmethod
    def wipe(cls) -> None:
        """Erase the progress line before other output is printed."""
        if cls._is_shown:
            cls._write("\r\x1b[K", False)

    @classmethod
    def _write(cls, text: str, shown: bool) -> None:
        cls._is_shown = shown
        with suppress(OSError, ValueError, AttributeError):  # never fail a run because of progress output
            cls._stream.write(text)  # type: ignore[union-attr]
            cls._stream.flush()  # type: ignore[union-attr]
