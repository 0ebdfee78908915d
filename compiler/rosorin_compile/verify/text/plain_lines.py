"""Plain lines: a text without what terminals, loggers and mail programs put around its lines."""

from __future__ import annotations

import re

# Colours and other controls, and titles of windows, of a terminal (ECMA-48, 5.4 and 8.3.89).
_CONTROL = re.compile(r"\x1b(?:\[[0-?]*[ -/]*[@-~]|\][^\x07\x1b]*(?:\x07|\x1b\\)|[@-Z\\^_=>()][0-9A-B]?)")
_TIME = r"\d{1,2}:\d\d:\d\d(?:[.,]\d+)?Z?"
# What stands before every line: a time (script, ts, logs), a border of tmux, a quotation.
_FRONT = (
    re.compile(rf"\[?(?:\d{{4}}-\d\d-\d\d[T ]|[A-Z][a-z]{{2}} +\d{{1,2}} )?{_TIME}\]? ?"),
    re.compile(r"\[?\d{6,}\.\d+\]? "),
    re.compile(r"[│|] ?"),
    re.compile(r"> ?"),
)
_NEARLY_ALL = 0.9


def plain_lines(text: str) -> list[str]:
    r"""Return the lines of a pasted text, without colours and without what stands before nearly every one of them.

    >>> plain_lines("\x1b[32m> At time 0.0\x1b[0m\r\n> - Matrix:")
    ['At time 0.0', '- Matrix:']
    """
    lines = [_CONTROL.sub("", line) for line in text.splitlines()]
    written = [line for line in lines if line.strip()]
    for front in _FRONT:
        if written and sum(bool(front.match(line)) for line in written) >= _NEARLY_ALL * len(written):
            return [front.sub("", line, count=1) if front.match(line) else line for line in lines]
    return lines
