"""Child processes of the tool that need not import first: each is a fork of a process that has done so.

The tool asks MuJoCo, and expands a xacro, in a new process each time; most of what that does is to import. What such a
process does otherwise, a fork does, too: its folder, environment, limits, end and words are its own. What a test
changes about the call (another program, less time, another path of modules) is called as ever.
"""

from __future__ import annotations

import atexit
import json
import os
import subprocess
import sys
import traceback
from collections.abc import Mapping, Sequence
from contextlib import suppress
from functools import cache
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path
from tempfile import TemporaryDirectory
from types import SimpleNamespace
from typing import Any, NoReturn

import pytest

from rosorin_compile.importing.xacro import expand
from rosorin_compile.mujoco.mjcf import process
from support.paths import COMPILER, TESTS

MJCF = "rosorin_compile.mujoco.mjcf"
CHILD = ("engine", "compiled_model", "compare_models", "accelerations")
MUJOCO = ("mujoco", "numpy", *(f"{MJCF}.{name}" for name in CHILD))
XACRO = ("xacro", "yaml", "rosorin_compile.importing.xacro.child")
OF_MUJOCO = process._START
OF_XACRO = expand._CHILD
SECONDS, XACRO_SECONDS = process.SECONDS, expand.MAX_SECONDS
Done = subprocess.CompletedProcess[bytes]


def preload(patch: pytest.MonkeyPatch) -> None:
    """Let the tool ask forks in place of new processes for the rest of this process."""
    if find_spec("mujoco") is not None:
        patch.setattr(process, "_run", _mujoco(process._run))
    if find_spec("xacro") is not None:
        run = _xacro(subprocess.run, os.environ.get("PYTHONPATH"))
        patch.setattr(expand, "subprocess", SimpleNamespace(run=run, TimeoutExpired=subprocess.TimeoutExpired))


def _mujoco(start: Any) -> Any:
    new_process = subprocess.run

    def run(command: list[str], folder: str, seconds: int) -> Done:
        python, _, program, *words = command
        same = python == sys.executable and program == OF_MUJOCO and seconds == SECONDS
        if not same or subprocess.run is not new_process:
            return start(command, folder, seconds)
        code, _, errors = _ask(MUJOCO, program, words, folder, process._environment())
        return subprocess.CompletedProcess(command, code, b"", errors)

    return run


def _xacro(start: Any, path: str | None) -> Any:
    def run(command: list[str], *, env: Mapping[str, str], **options: Any) -> Done:
        given: bytes = options["input"]
        whole = json.loads(given)["seconds"] == XACRO_SECONDS
        if command != [sys.executable, "-c", OF_XACRO] or not whole or env.get("PYTHONPATH") != path:
            return start(command, env=env, **options)
        return subprocess.CompletedProcess(command, *_ask(XACRO, OF_XACRO, [], os.getcwd(), env, given))

    return run


def _ask(
    modules: tuple[str, ...],
    program: str,
    words: Sequence[str],
    folder: str,
    environment: Mapping[str, str],
    given: bytes = b"",
) -> tuple[int, bytes, bytes]:
    """Return the exit code of a program, and what it says on both streams."""
    with TemporaryDirectory() as here:
        Path(here, "given").write_bytes(given)
        job = {"program": program, "words": list(words), "folder": folder, "environment": dict(environment)}
        waiting = _waiting(modules)
        assert waiting.stdin is not None
        assert waiting.stdout is not None
        waiting.stdin.write(json.dumps({**job, "streams": here}) + "\n")
        waiting.stdin.flush()
        code = int(waiting.stdout.readline())
        return code, Path(here, "output").read_bytes(), Path(here, "errors").read_bytes()


@cache
def _waiting(modules: tuple[str, ...]) -> subprocess.Popen[str]:
    command = [sys.executable, "-c", "from support.preloaded import serve; serve()", *modules]
    environment = {**os.environ, "PYTHONPATH": f"{TESTS}{os.pathsep}{COMPILER}", "PYTHONHASHSEED": "0"}
    environment.pop("MUJOCO_GL", None)
    process = subprocess.Popen(command, env=environment, text=True, stdin=subprocess.PIPE, stdout=subprocess.PIPE)
    atexit.register(process.communicate)  # it ends with its input
    return process


def serve() -> None:
    """Import what is named, and do what is asked on standard input, a fork each; answer with its exit code."""
    for name in sys.argv[1:]:
        import_module(name)
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
        os.environ.clear()
        os.environ.update(job["environment"])
        for stream, name in enumerate(("given", "output", "errors")):
            opened = os.open(Path(job["streams"], name), os.O_RDWR | os.O_CREAT, 0o600)
            os.dup2(opened, stream)
            os.close(opened)
        os.chdir(job["folder"])
        sys.argv = ["-c", *job["words"]]
        sys.stdin = open(0, encoding="utf-8", closefd=False)  # noqa: SIM115 - a new one has read nothing ahead
        exec(job["program"], {"__name__": "__main__"})  # noqa: S102 - a program of the tool
        code = 0
    except SystemExit as stopped:
        code = stopped.code if isinstance(stopped.code, int) else int(stopped.code is not None)
    except BaseException:
        traceback.print_exc()
    finally:
        with suppress(Exception):
            sys.stdout.flush()
            sys.stderr.flush()
        os._exit(code)
