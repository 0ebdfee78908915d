"""The child process that renders the templates of users, with limits for CPU time, memory and output.

The parent sends one pickled request on standard input. The child answers with one JSON object on standard output: the
text or the reason why there is none, and the files that were read or looked for.
"""

from __future__ import annotations

import json
import os
import pickle
import signal
import subprocess
import sys
from collections.abc import Mapping
from pathlib import Path
from typing import Any, NamedTuple

from rosorin_compile.source import files, system
from rosorin_compile.source.cache import cache_folder

CPU_SECONDS = 5
WALL_SECONDS = 60  # a child on a busy machine waits for its turn
MEMORY = 700_000_000  # bytes beyond what the interpreter and the robot take
MAX_OUTPUT = 50_000_000  # characters

# Started by -c: -m would look for modules in the working folder first, which may belong to a stranger.
_START = f"import sys, json; sys.path[:] = json.loads(sys.argv[1]); from {__name__} import main; main()"
_TIME = f"it takes more than {CPU_SECONDS} s of CPU time"


class Rendered(NamedTuple):
    """The answer of the child: ``text``, or the rule, message, template and line of a failure.

    ``inputs`` are the files that were read or looked for.
    """

    text: str = ""
    rule: str = ""
    message: str = ""
    template: str = ""
    line: int = 0
    inputs: tuple[str, ...] = ()


def render(folder: Path | None, first: Path | None, name: str, values: Mapping[str, Any]) -> Rendered:
    """Render a template in a child process. Returns a failure if it exceeds a limit."""
    system.needs("resource", system.NO_LIMITS)
    cache_folder("templates")  # the child caches there; only this process can report that it is open to others
    path = json.dumps([os.path.abspath(entry) for entry in sys.path if entry])
    command = [sys.executable, "-c", _START, path]
    request = pickle.dumps((folder, first, name, dict(values)))
    # numpy reserves memory for each thread of its libraries.
    environment = {**os.environ, "OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1"}
    try:
        done = subprocess.run(  # noqa: S603 - this Python, and arguments that no shell reads
            command, input=request, capture_output=True, timeout=WALL_SECONDS, env=environment, check=False
        )
    except subprocess.TimeoutExpired:
        return Rendered(rule="template-failed", message=f"it did not end within {WALL_SECONDS} s", template=name)
    if done.returncode in (-getattr(signal, "SIGXCPU", 0), -getattr(signal, "SIGKILL", 0)):
        return Rendered(rule="template-failed", message=_TIME, template=name)
    if done.returncode:
        last = done.stderr.decode("utf-8", "replace").strip().rpartition("\n")[2] or f"exit code {done.returncode}"
        return Rendered(rule="template-failed", message=f"the process that renders it ended: {last}", template=name)
    answer = json.loads(done.stdout)
    return Rendered(**{**answer, "inputs": tuple(answer["inputs"])})


def main() -> None:
    """Render the template that standard input requests, and write the answer to standard output."""
    from .templating import Templates, explain_failure

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
        raise _OutOfTime(_TIME)

    signal.signal(signal.SIGXCPU, stop)
    usage = resource.getrusage(resource.RUSAGE_SELF)
    seconds = int(usage.ru_utime + usage.ru_stime) + CPU_SECONDS
    _lower(resource.RLIMIT_CPU, seconds, seconds + 1)  # a long operation in C sees only the hard limit
    try:
        pages = int(Path("/proc/self/statm").read_text().split()[0])
        used = pages * resource.getpagesize()
    except (OSError, ValueError):  # not Linux
        used = 300_000_000
    _lower(resource.RLIMIT_AS, used + MEMORY, used + MEMORY)


def _lower(kind: int, soft: int, hard: int) -> None:
    """Set a limit, but never above the one that already holds."""
    import resource

    _, allowed = resource.getrlimit(kind)
    most = hard if allowed == resource.RLIM_INFINITY else min(hard, allowed)
    resource.setrlimit(kind, (min(soft, most), most))
