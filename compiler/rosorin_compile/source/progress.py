"""Show a progress line in the terminal if a command takes longer than two seconds."""

import os
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from typing import ClassVar, TextIO

from .wording import printable

_DELAY, _INTERVAL = 2.0, 0.1  # seconds until the line appears, and between updates
_WIDTH = 30  # width of the bar in characters


class Progress:
    """The progress line of this process. Nothing is printed until ``show`` is called."""

    _stream: ClassVar[TextIO | None] = None
    _topic = _kind = ""
    _due = _next = 0.0  # monotonic times (s) of the first output, and of the next update
    _is_shown = False

    @classmethod
    def show(cls, stream: TextIO) -> None:
        cls._stream, cls._topic = stream, ""
        cls.begin()

    @classmethod
    def hide(cls) -> None:
        cls.wipe()
        cls._stream = None

    @classmethod
    def begin(cls) -> None:
        """Hide the line and restart the two-second delay, for example when ``watch`` compiles again."""
        cls.wipe()
        cls._due, cls._next, cls._kind = time.monotonic() + _DELAY, 0.0, ""

    @classmethod
    def set_topic(cls, topic: str) -> None:
        cls._topic = topic

    @classmethod
    def step(cls, what: str, done: int = 0, total: int = 0, counted: bool = True) -> None:
        """Show the activity ``what``, and a progress bar for ``done`` of ``total`` steps.

        If ``total`` is 0, the number of steps is unknown. If ``counted`` is False, the bar is shown without numbers.
        """
        if cls._stream is None:
            return
        now, is_new, cls._kind = time.monotonic(), what != cls._kind, what
        if now < cls._due or (now < cls._next and not is_new):
            return
        cls._next = now + _INTERVAL
        text = printable(f"{cls._topic} {what}".strip())
        text += f" {done:,}" if counted and (done or total) else ""
        if total:
            share = min(1.0, done / total)  # a rosbag may have more messages than its metadata declare
            text += f" of {total:,}" if counted else ""
            text += f" [{'#' * int(_WIDTH * share):.<{_WIDTH}}] {int(100 * share):3d}%"
        columns = 80
        with suppress(OSError, ValueError, AttributeError):
            columns = os.get_terminal_size(cls._stream.fileno()).columns or columns
        while len(text) + sum(not letter.isascii() for letter in text) >= columns:  # non-ASCII may need two columns
            text = text[:-1]
        cls._write(f"\r{text}\x1b[K", True)

    @classmethod
    @contextmanager
    def hide_steps(cls) -> Iterator[None]:
        """Hide the steps of the ``with`` block, because the caller reports the block as a single step."""
        stream, cls._stream = cls._stream, None
        try:
            yield
        finally:
            cls._stream = stream

    @classmethod
    def wipe(cls) -> None:
        if cls._is_shown:
            cls._write("\r\x1b[K", False)

    @classmethod
    def _write(cls, text: str, shown: bool) -> None:
        cls._is_shown = shown
        with suppress(OSError, ValueError, AttributeError):  # never fail a run because of progress output
            cls._stream.write(text)  # type: ignore[union-attr]
            cls._stream.flush()  # type: ignore[union-attr]
