"""Ending a command before each of its calls that changes a file: within this process, or from outside (strace)."""

from __future__ import annotations

import os
import re
import shutil
import signal
import subprocess
import sys
from collections import Counter
from collections.abc import Callable
from functools import cache
from itertools import count
from pathlib import Path
from typing import NamedTuple

CHANGES = (
    "rename renameat renameat2 link linkat symlink symlinkat unlink unlinkat mkdir mkdirat rmdir ftruncate truncate"
)
CALLS = (*CHANGES.split(), "open", "openat", "creat", "write", "pwrite64")
_LINE = re.compile(r"(\d+) +(\w+)\((.*)")
_KILLED = 137


class Call(NamedTuple):
    """A call to the system: its name, and the how manieth of that name it is."""

    name: str
    number: int


def die_at(step: int) -> None:
    """Let this process kill itself at the given one of its calls that touch the disk."""
    steps = count(1)

    def heard(event: str, _: object) -> None:
        if event.startswith(("os.", "open", "fcntl.", "shutil.")) and next(steps) == step:
            os.kill(os.getpid(), signal.SIGKILL)

    sys.addaudithook(heard)


def ended_at(step: int, run: Callable[[], object]) -> int:
    """Run something in a process that kills itself at a step; return its exit code."""
    child = os.fork()
    if not child:
        try:
            die_at(step)
            run()
            os._exit(0)
        finally:
            os._exit(1)
    return os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])


def at_each_step(run: Callable[[], object], after: Callable[[], object], each: int = 1) -> int:
    """Kill a run at its first call, at its second and so on, each time with a look ``after``; return how many.

    With ``each`` of 5 it is killed at its first call, at its sixth and so on.
    """
    step, code = 1 - each, 1
    while code:
        step += each
        code = ended_at(step, run)
        assert code in (0, -signal.SIGKILL)
        after()
    return step


@cache
def missing() -> str:
    """Return why nothing can be ended here; empty if it can."""
    if shutil.which("strace") is None:
        return "strace is not installed"
    done = subprocess.run(["strace", "-o", os.devnull, "true"], capture_output=True, check=False)
    return "" if done.returncode == 0 else "this system lets nobody trace"


def calls(home: Path, folder: Path, words: list[str]) -> list[Call]:
    """Run a command; return its calls that change something in a folder, in their order."""
    log = home.parent / "strace.log"
    _run(home, words, "-y", "-o", str(log), "-e", f"trace={_known()}")
    counts: Counter[str] = Counter()
    found, first = [], ""
    for line in log.read_text("utf-8", "replace").splitlines():
        match = _LINE.match(line)
        if match is None or (first and match[1] != first):
            continue
        first = match[1]
        counts[match[2]] += 1
        opens = match[2] in ("open", "openat")
        here = str(folder) in match[3] or re.match(r'"[^/]', match[3])
        if here and not (opens and "O_WRONLY" not in match[3] and "O_RDWR" not in match[3]):
            found.append(Call(match[2], counts[match[2]]))
    return found


def killed(home: Path, words: list[str], call: Call) -> bool:
    """Run a command that is ended before a call; say whether it came to that."""
    how = ["-o", os.devnull, "-e", f"trace={call.name}", "-e", f"inject={call.name}:signal=KILL:when={call.number}"]
    return _run(home, words, *how) in (_KILLED, -9)


@cache
def _known() -> str:
    """Return the calls that this machine has a word for: some have neither open nor rename."""

    def knows(name: str) -> bool:
        words = ["strace", "-o", os.devnull, "-e", f"trace={name}", "true"]
        return subprocess.run(words, capture_output=True, check=False).returncode == 0

    return ",".join(filter(knows, CALLS))


def _run(home: Path, words: list[str], *how: str) -> int:
    core = min(os.sched_getaffinity(0))
    command = ["strace", "-f", *how, sys.executable, "-m", "rosorin_compile", *words]
    environment = {**os.environ, "ROSORIN_COMPILE_CACHE": "off", "PYTHONHASHSEED": "0", "PYTHONDONTWRITEBYTECODE": "1"}
    return subprocess.run(
        command,
        cwd=home,
        env=environment,
        capture_output=True,
        timeout=100,
        check=False,
        preexec_fn=lambda: os.sched_setaffinity(0, {core}),
    ).returncode
