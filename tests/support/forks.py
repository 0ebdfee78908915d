"""Command lines in processes of their own that need not import the tool first: each is a fork of one that has done so.

A process with plug-ins has to be a new one, since what it has loaded stays loaded. Most of what such a process does is
to import the tool, and that is the same each time. So one process imports what the first command lines needed (modules
of the tool and of Python, nothing from ``PYTHONPATH``), parses the sources that declare rules, waits, and forks.

    python -c "from support.forks import serve; serve()" PATH...

reads a line of JSON for each command line, ``words``, ``folder``, ``environment``, ``output`` (a file), and answers
with its exit code; PATH... is what stands on the path of modules beside ``PYTHONPATH``.
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
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, NoReturn

from support.paths import TESTS

_LEARNING = 12  # command lines after which there is nothing new to import


def run(words: Sequence[str], folder: Path, environment: Mapping[str, str]) -> tuple[int, str]:
    """Run ``rosorin-compile`` in a folder; return its exit code, and what it prints on both streams."""
    with TemporaryDirectory() as here:
        output = Path(here, "output")
        job = {"words": list(words), "folder": str(folder), "environment": dict(environment), "output": str(output)}
        waiting = _waiting()
        assert waiting.stdin is not None
        assert waiting.stdout is not None
        waiting.stdin.write(json.dumps(job) + "\n")
        waiting.stdin.flush()
        code = int(waiting.stdout.readline())
        return code, output.read_text("utf-8")


@cache
def _waiting() -> subprocess.Popen[str]:
    own = [path for path in sys.path if path and not Path(path).is_relative_to(TESTS)]
    command = [sys.executable, "-c", "from support.forks import serve; serve()", *own]
    environment = {**os.environ, "PYTHONPATH": str(TESTS)}
    process = subprocess.Popen(
        command, env=environment, text=True, stdin=subprocess.PIPE, stdout=subprocess.PIPE, cwd=TESTS
    )
    atexit.register(process.communicate)  # it ends with its input
    return process


def serve() -> None:
    """Do what is asked on standard input, a fork each."""
    own = sys.argv[1:]
    _parse_rules()
    for number, line in enumerate(sys.stdin):
        job = json.loads(line)
        learned = Path(f"{job['output']}.modules")
        child = os.fork()
        if not child:
            _do(job, own, learned)
        code = os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])
        if number < _LEARNING and learned.exists():
            for name in json.loads(learned.read_text("utf-8")):
                with suppress(Exception):
                    import_module(name)
        sys.stdout.write(f"{code}\n")
        sys.stdout.flush()


def _parse_rules() -> None:
    """Let what the sources of the tool declare be known: of an equal text it is the same."""
    from rosorin_compile.source import rule_registry as registry

    declared = cache(registry.declared_in)
    registry.declared_in = lambda source: list(declared(source))
    for _, text in registry._declaring():
        registry.declared_in(text)


def _do(job: Mapping[str, Any], own: Sequence[str], learned: Path) -> NoReturn:
    """Become the process of a command line, and end as it does."""
    code = 1
    try:
        _settle(job, own)
        code = _code(job["words"])
        atexit._run_exitfuncs()
        learned.write_text(json.dumps(_of_the_tool(job)), "utf-8")
    except BaseException:
        traceback.print_exc()
    finally:
        with suppress(Exception):
            sys.stdout.flush()
            sys.stderr.flush()
        os._exit(code)


def _settle(job: Mapping[str, Any], own: Sequence[str]) -> None:
    """Take the folder, the environment, the path of modules and the streams of a command line."""
    from rosorin_compile import formats

    formats._names.cache_clear()  # a module may have looked at the formats, without those of plug-ins
    given = job["environment"]
    os.chdir(job["folder"])
    os.environ.clear()
    os.environ.update(given)
    sys.path[:] = [job["folder"], *filter(None, given.get("PYTHONPATH", "").split(os.pathsep)), *own]
    sys.dont_write_bytecode = bool(given.get("PYTHONDONTWRITEBYTECODE"))
    for stream, flags in ((0, os.O_RDONLY), (1, os.O_WRONLY | os.O_CREAT | os.O_APPEND)):
        opened = os.open(os.devnull if stream == 0 else job["output"], flags, 0o600)
        os.dup2(opened, stream)
        os.close(opened)
    os.dup2(1, 2)


def _code(words: Sequence[str]) -> int:
    """Return the exit code of a command line."""
    from rosorin_compile import __main__ as program

    sys.argv = [str(program.__file__), *words]
    try:
        return program.program()
    except SystemExit as stopped:
        return stopped.code if isinstance(stopped.code, int) else int(stopped.code is not None)


def _of_the_tool(job: Mapping[str, Any]) -> list[str]:
    """Return the modules that this process has now, in the order of their import, but for those of plug-ins."""
    of_others = tuple(filter(None, [job["folder"], *job["environment"].get("PYTHONPATH", "").split(os.pathsep)]))
    return [
        name
        for name, module in sys.modules.items()
        if name.partition(".")[0] not in ("__main__", "support")
        and not str(getattr(module, "__file__", None) or "").startswith(of_others)
    ]
