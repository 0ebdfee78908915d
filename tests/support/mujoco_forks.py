"""MuJoCo in processes of its own that need not load it first: each is a fork of one that has loaded it.

The tool asks MuJoCo in a new process each time, which takes half a second until MuJoCo is there. What such a process
does otherwise, a fork does, too: its folder, environment, limits, end and words are its own. What a test changes about
the call (another program, less time) is called as ever.
"""

from __future__ import annotations

import atexit
import json
import os
import subprocess
import sys
import traceback
from contextlib import suppress
from functools import cache
from importlib.util import find_spec
from pathlib import Path
from typing import Any, NoReturn

import pytest

from rosorin_compile_mujoco.mjcf import process
from support.paths import COMPILER, TESTS

PROGRAMS = (process._START, process._START_LOAD, process._START_PROVE)
LOADED = (
    "mujoco",
    "numpy",
    *(f"rosorin_compile_mujoco.mjcf.{name}" for name in ("engine", "matched", "moves", "compared")),
)


def fork_mujoco(patch: pytest.MonkeyPatch) -> None:
    """Let the tool ask forks in place of new processes for the rest of this process."""
    if find_spec("mujoco") is None:
        return
    start, new_process = process._run, subprocess.run

    def run(command: list[str], folder: str, seconds: int) -> subprocess.CompletedProcess[bytes]:
        python, _, program, *words = command
        same = python == sys.executable and program in PROGRAMS and seconds == process.SECONDS
        if not same or process.subprocess.run is not new_process:
            return start(command, folder, seconds)
        job = {"program": program, "words": words, "folder": folder, "environment": process._environment()}
        code, errors = _ask(job)
        return subprocess.CompletedProcess(command, code, b"", errors)

    patch.setattr(process, "_run", run)


def _ask(job: dict[str, Any]) -> tuple[int, bytes]:
    errors = Path(job["folder"], ".errors")
    waiting = _waiting()
    assert waiting.stdin is not None
    assert waiting.stdout is not None
    waiting.stdin.write(json.dumps(job) + "\n")
    waiting.stdin.flush()
    code = int(waiting.stdout.readline())
    said = errors.read_bytes()
    errors.unlink()
    return code, said


@cache
def _waiting() -> subprocess.Popen[str]:
    command = [sys.executable, "-c", "from support.mujoco_forks import serve; serve()"]
    environment = {**os.environ, "PYTHONPATH": f"{TESTS}{os.pathsep}{COMPILER}"}
    environment.pop("MUJOCO_GL", None)
    process = subprocess.Popen(command, env=environment, text=True, stdin=subprocess.PIPE, stdout=subprocess.PIPE)
    atexit.register(process.communicate)  # it ends with its input
    return process


def serve() -> None:
    """Do what is asked on standard input, a fork each, and answer with its exit code."""
    for name in LOADED:
        __import__(name)
    for line in sys.stdin:
        child = os.fork()
        if not child:
            _do(json.loads(line))
        sys.stdout.write(f"{os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])}\n")
        sys.stdout.flush()


def _do(job: dict[str, Any]) -> NoReturn:
    """Become the process that the tool would have started, and end as it does."""
    code = 1
    try:
        os.chdir(job["folder"])
        os.environ.clear()
        os.environ.update(job["environment"])
        errors = os.open(Path(job["folder"], ".errors"), os.O_WRONLY | os.O_CREAT, 0o600)
        nothing = os.open(os.devnull, os.O_RDWR)
        for stream, opened in enumerate((nothing, nothing, errors)):
            os.dup2(opened, stream)
        sys.argv = ["-c", *job["words"]]
        exec(job["program"], {})  # noqa: S102 - a program of the tool
        code = 0
    except BaseException:
        traceback.print_exc()
    finally:
        with suppress(Exception):
            sys.stderr.flush()
        os._exit(code)
