"""Processes that need not import first: each is a fork of one that has imported what they all need.

Command lines run in a process of their own here (``run``): one with plug-ins has to, since what it has loaded stays
loaded. The tool itself asks MuJoCo, and expands a xacro, in a new process each time (``preload``). Most of what these
processes do is to import modules.

    python -c "from support.forks import serve; serve()" MODULE...

imports the modules and reads a line of JSON for each job; the answer is the exit code of the fork that does it. What a
fork has of its own are its folder, environment, words, limits, streams (files in a folder) and end.
"""

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

from support.paths import COMPILER, TESTS

MJCF = "rosorin_compile.mujoco.mjcf"
MUJOCO = ("mujoco", "numpy", f"{MJCF}.engine", f"{MJCF}.compare_models")
XACRO = ("xacro", "yaml", "rosorin_compile.importing.xacro.child")
TOOL = ("yaml", "jsonschema", "jinja2", "rosorin_compile.__main__", "rosorin_compile.api")
TOOL += tuple(f"rosorin_compile.cli.{name}" for name in ("artifacts", "check", "frames"))
COMMAND = """\
import atexit, json, os, sys
from rosorin_compile import __main__, formats
formats._names.cache_clear()  # a module may have looked at the formats, without those of plug-ins
paths = os.environ.get("PYTHONPATH", "").split(os.pathsep)
sys.path[:] = [os.getcwd(), *filter(None, paths), *json.loads(sys.argv.pop(1))]
sys.dont_write_bytecode = bool(os.environ.get("PYTHONDONTWRITEBYTECODE"))
sys.argv[0] = __main__.__file__
try:
    code = __main__.program()
except SystemExit as stopped:
    code = stopped.code
atexit._run_exitfuncs()
raise SystemExit(code)
"""


def run(words: Sequence[str], folder: Path, environment: Mapping[str, str]) -> tuple[int, str]:
    """Run ``rosorin-compile`` in a folder; return its exit code, and what it prints on both streams."""
    own = [path for path in sys.path if path and not Path(path).is_relative_to(TESTS)]
    code, output, _ = _ask(TOOL, COMMAND, [json.dumps(own), *words], str(folder), environment, together=True)
    return code, output.decode()


def preload(patch: pytest.MonkeyPatch) -> None:
    """Let the tool ask forks in place of new processes for the rest of this process.

    What a test changes about the call (another program, less time, another path of modules) is called as ever.
    """
    from rosorin_compile.importing.xacro import expand
    from rosorin_compile.mujoco.mjcf import process

    new_process, start, path = subprocess.run, process._run, os.environ.get("PYTHONPATH")
    seconds, xacro_seconds = process.SECONDS, expand.MAX_SECONDS

    def mujoco(command: list[str], folder: str, limit: int) -> subprocess.CompletedProcess[bytes]:
        python, _, program, *words = command
        same = python == sys.executable and program == process._START and limit == seconds
        if not same or subprocess.run is not new_process:
            return start(command, folder, limit)
        code, _, errors = _ask(
            MUJOCO, program, words, folder, {key: text for key, text in os.environ.items() if key != "MUJOCO_GL"}
        )
        return subprocess.CompletedProcess(command, code, b"", errors)

    def xacro(command: list[str], *, env: Mapping[str, str], **options: Any) -> subprocess.CompletedProcess[bytes]:
        whole = json.loads(options["input"])["seconds"] == xacro_seconds
        if command != [sys.executable, "-c", expand._CHILD] or not whole or env.get("PYTHONPATH") != path:
            return new_process(command, env=env, **options)
        answer = _ask(XACRO, expand._CHILD, [], os.getcwd(), env, options["input"])
        return subprocess.CompletedProcess(command, *answer)

    if find_spec("mujoco") is not None:
        patch.setattr(process, "_run", mujoco)
    if find_spec("xacro") is not None:
        patch.setattr(expand, "subprocess", SimpleNamespace(run=xacro, TimeoutExpired=subprocess.TimeoutExpired))


def _ask(
    modules: tuple[str, ...],
    program: str,
    words: Sequence[str],
    folder: str,
    environment: Mapping[str, str],
    given: bytes = b"",
    together: bool = False,
) -> tuple[int, bytes, bytes]:
    with TemporaryDirectory() as here:
        Path(here, "given").write_bytes(given)
        job = {"program": program, "words": list(words), "folder": folder, "environment": dict(environment)}
        waiting = _waiting(modules)
        assert waiting.stdin is not None
        assert waiting.stdout is not None
        waiting.stdin.write(json.dumps({**job, "streams": here, "together": together}) + "\n")
        waiting.stdin.flush()
        code = int(waiting.stdout.readline())
        return code, Path(here, "output").read_bytes(), Path(here, "errors").read_bytes()


@cache
def _waiting(modules: tuple[str, ...]) -> subprocess.Popen[str]:
    command = [sys.executable, "-c", "from support.forks import serve; serve()", *modules]
    environment = {**os.environ, "PYTHONPATH": f"{TESTS}{os.pathsep}{COMPILER}", "PYTHONHASHSEED": "0"}
    environment.pop("MUJOCO_GL", None)
    process = subprocess.Popen(command, env=environment, text=True, stdin=subprocess.PIPE, stdout=subprocess.PIPE)
    atexit.register(process.communicate)  # it ends with its input
    return process


def serve() -> None:
    """Import what is named, and do the jobs on standard input, a fork each; answer with its exit code."""
    for name in sys.argv[1:]:
        import_module(name)
    for line in sys.stdin:
        job = json.loads(line)
        child = os.fork()
        if not child:
            _do(job)
        code = os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])
        sys.stdout.write(f"{code}\n")
        sys.stdout.flush()


def _do(job: dict[str, Any]) -> NoReturn:
    code = 1
    try:
        os.environ.clear()
        os.environ.update(job["environment"])
        for stream, name in enumerate(("given", "output", "errors")):
            opened = os.open(Path(job["streams"], name), os.O_RDWR | os.O_CREAT | os.O_APPEND, 0o600)
            os.dup2(opened, stream)
            os.close(opened)
        if job["together"]:
            os.dup2(1, 2)
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
