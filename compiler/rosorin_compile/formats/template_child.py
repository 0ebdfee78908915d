"""The child process that renders a template of a user, with limits for CPU time, memory and output.

The parent sends one pickled request on standard input. The child answers with one JSON object on standard output: the
text or the reason why there is none, and the files that were read or looked for.
"""

from __future__ import annotations

import json
import os
import pickle
import signal
import sys
from pathlib import Path
from typing import Any

from rosorin_compile.source import files

from .templating import MAX_SECONDS, OUT_OF_TIME, Templates, explain_failure

MAX_MEMORY = 700_000_000  # bytes beyond what the interpreter and the robot take
MAX_OUTPUT = 50_000_000  # characters


def main() -> None:
    """Render the template that standard input requests, and write the answer to standard output."""
    folder, first, name, values = pickle.load(sys.stdin.buffer)  # noqa: S301 - written by the parent
    with files.recording() as inputs:
        templates = Templates(folder, first=first)
        try:
            _limit()
            text = templates.sandbox.get_template(name).render(values)
            if len(text) > MAX_OUTPUT:
                raise ValueError(f"its text has more than {MAX_OUTPUT:,} characters")
            answer: dict[str, Any] = {"text": text}
        except (Exception, _OutOfTime) as problem:  # a filter of Jinja raises whatever it likes
            rule, message, template, line = explain_failure(problem, name)
            answer = {"rule": rule, "message": message, "template": template, "line": line}
    places = (*templates.homes, *([files.resolve(folder)] if folder else []))
    read = sorted(os.fspath(file) for file in inputs if any(map(file.is_relative_to, places)))
    sys.stdout.buffer.write(json.dumps({**answer, "inputs": read}).encode())


class _OutOfTime(BaseException):
    """The soft limit of CPU time is reached; not an Exception, which Jinja may catch."""


def _limit() -> None:
    """Limit CPU time and memory of this process to what is used so far and the budget of one rendering."""
    try:
        import resource
    except ImportError:  # Windows; the parent reports it
        return

    def stop(*_: object) -> None:
        raise _OutOfTime(OUT_OF_TIME)

    signal.signal(signal.SIGXCPU, stop)
    usage = resource.getrusage(resource.RUSAGE_SELF)
    seconds = int(usage.ru_utime + usage.ru_stime) + MAX_SECONDS
    _lower(resource.RLIMIT_CPU, seconds, seconds + 1)  # a long operation in C sees only the hard limit
    try:
        pages = int(Path("/proc/self/statm").read_text().split()[0])
        used = pages * resource.getpagesize()
    except (OSError, ValueError):  # not Linux
        used = 300_000_000
    _lower(resource.RLIMIT_AS, used + MAX_MEMORY, used + MAX_MEMORY)


def _lower(kind: int, soft: int, hard: int) -> None:
    """Set a limit, but never above the one that already holds."""
    import resource

    _, allowed = resource.getrlimit(kind)
    most = hard if allowed == resource.RLIM_INFINITY else min(hard, allowed)
    resource.setrlimit(kind, (min(soft, most), most))
