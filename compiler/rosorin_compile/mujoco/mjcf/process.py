"""MuJoCo asked in a process of its own, and its answer or its refusal brought back.

MuJoCo is native code that was written for files of friends: some files make it crash, hang or ask for all memory. In a
process of its own that ends with a message. It costs a start of Python, 20 ms beside the 300 ms that MuJoCo itself
takes to be loaded, and this process never loads it.
"""

from __future__ import annotations

import json
import os
import re
import signal
import subprocess
import sys
import tempfile
from collections.abc import Mapping
from importlib import import_module
from pathlib import Path
from typing import Any, NamedTuple

from rosorin_compile.formats.format import Refusal
from rosorin_compile.source import files, system
from rosorin_compile.source.installing import is_installed, pip_install

SECONDS = 60  # of calculating, which the child counts itself
_PATIENCE = 5  # so many times as long may one take that waits: for files, or for others on a busy machine

_ABSENT = re.compile(r"ModuleNotFoundError: No module named '(\w+)")

_TOP = str(files.resolve(__file__).parents[2])  # the folder in which the package is

# Run by -c: -m would look for modules in the working folder first, which may be foreign.
_START = (
    "import sys; sys.path[:] = [p for p in sys.path if p] + [sys.argv[1]];"
    "from rosorin_compile.mujoco.mjcf import engine;"
    "engine.main(sys.argv[2], sys.argv[3], int(sys.argv[4]))"
)
_START_LOAD = _START.replace("engine.main(", "engine.main_load(").replace("]))", "]), sys.argv[5])")
_START_PROVE = _START.replace("engine.main(", "engine.main_prove(").replace("]))", "]), sys.argv[5])")


class Answer(NamedTuple):
    """What MuJoCo made of a file (None after a refusal), what it warned of, and why it refused.

    ``own`` says that the words of the refusal are ours, not MuJoCo's, and ``missing`` that MuJoCo is not installed.
    """

    facts: dict[str, Any] | None
    warnings: tuple[str, ...] = ()
    refusal: str = ""
    help: str = ""
    own: bool = False
    missing: bool = False


def ask(path: Path, seconds: int = SECONDS) -> Answer:
    """Return what MuJoCo makes of the MJCF at ``path``. Never raises for what is in the file."""
    system.needs("resource", system.NO_LIMITS)
    with tempfile.TemporaryDirectory(prefix="rosorin-compile-") as folder:
        answer = Path(folder, "answer.json")
        command = [sys.executable, "-c", _START, _TOP, str(files.resolve(path)), str(answer), str(seconds)]
        try:
            done = _run(command, folder, seconds)
        except subprocess.TimeoutExpired:
            return Answer(None, (), _endless(seconds), "make the model smaller", True)
        said = _answer(answer)
    if said is None:
        return _fallen(done, seconds)
    made = json.loads(said)
    told = tuple(made.pop("warnings"))
    if "refused" in made:
        return Answer(None, told, _without_folder(made["refused"], path), "correct it: MuJoCo does not load the file")
    return Answer(made, told)


def refusal(text: str, folder: Path, by_itself: bool, seconds: int = SECONDS) -> Refusal:
    """Return why MuJoCo does not load an MJCF that is in ``folder``, or that it is not installed.

    A text of ours ``by_itself`` is loaded here; the meshes of others may do to a process what they like.
    """
    if not is_installed("mujoco"):
        return Refusal(missing="MuJoCo")
    if by_itself:
        from . import engine

        reason, outdated = engine.load(import_module("mujoco"), text, str(folder))
        return Refusal(_reason(reason, text), outdated)
    with tempfile.TemporaryDirectory(prefix="rosorin-compile-") as own:
        model, answer = Path(own, "model.xml"), Path(own, "answer")
        model.write_text(text, encoding="utf-8")
        command = [sys.executable, "-c", _START_LOAD, _TOP, str(model), str(answer), str(seconds)]
        try:
            done = _run([*command, str(files.resolve(folder))], own, seconds)
        except subprocess.TimeoutExpired:
            return Refusal(_endless(seconds))
        said = _answer(answer)
    if said is None:
        return Refusal(_fallen(done, seconds).refusal)
    reason, outdated = json.loads(said)
    return Refusal(_reason(reason, text).replace(f"{files.resolve(folder)}{os.sep}", ""), outdated)


def _answer(path: Path) -> str | None:
    """Return what the child process answered; None if it did not."""
    return path.read_text("utf-8") if path.exists() else None


def prove(path: Path, asked: Mapping[str, Any], seconds: int = SECONDS) -> dict[str, Any] | str:
    """Return how the MJCF at ``path`` differs from ours (see ``engine.proof``), or why MuJoCo did not say."""
    with tempfile.TemporaryDirectory(prefix="rosorin-compile-") as own:
        request, answer = Path(own, "request.json"), Path(own, "answer.json")
        request.write_text(json.dumps(asked), encoding="utf-8")
        command = [sys.executable, "-c", _START_PROVE, _TOP, str(files.resolve(path)), str(answer), str(seconds)]
        try:
            done = _run([*command, str(request)], own, seconds)
        except subprocess.TimeoutExpired:
            return _endless(seconds)
        said = _answer(answer)
    if said is None:
        return _fallen(done, seconds).refusal
    made: dict[str, Any] = json.loads(said)
    return made


def _reason(refused: str, text: str) -> str:
    """Return the words of MuJoCo in one line, without the heading of all its errors, and with the file of a mesh."""
    reason = " ".join(refused.split()).removeprefix("Error: ")
    named = re.search(r"Element name '([^']+)'", reason)
    mesh = named and re.search(rf'<mesh\b[^<>]*\bname="{re.escape(named[1])}"[^<>]*\bfile="([^"]*)"', text)
    return f"{mesh[1]}: {reason}" if mesh and mesh[1] not in reason else reason


def _run(command: list[str], folder: str, seconds: int) -> subprocess.CompletedProcess[bytes]:
    """Run a child; MuJoCo writes a log into the working folder, and that should be nobody's."""
    return subprocess.run(  # noqa: S603 - this Python, and arguments that no shell reads
        command, cwd=folder, capture_output=True, timeout=_PATIENCE * seconds, env=_environment()
    )


def _endless(seconds: int) -> str:
    return f"MuJoCo did not come to an end with the file in {seconds} s"


def _environment() -> dict[str, str]:
    """Return the environment without what makes MuJoCo look for a screen."""
    return {key: value for key, value in os.environ.items() if key != "MUJOCO_GL"}


def _fallen(done: subprocess.CompletedProcess[bytes], seconds: int) -> Answer:
    if done.returncode == -getattr(signal, "SIGXCPU", 0) < 0:
        return Answer(None, (), _endless(seconds), "make the model smaller", True)
    lines = done.stderr.decode("utf-8", "replace").strip().splitlines()
    last = lines[-1] if lines else ""
    absent = _ABSENT.match(last)
    if absent:
        is_it = absent[1] == "mujoco"
        what = "MuJoCo, which reads MJCF," if is_it else f"the package {absent[1]}, which MuJoCo needs,"
        message = f"{what} is not installed"
        return Answer(None, (), message, pip_install("import"), True, True)
    if done.returncode < 0:
        message = f"MuJoCo crashed on the file (signal {-done.returncode})"
    else:
        message = f"MuJoCo gave up on the file: {last or f'exit code {done.returncode}'}"
    return Answer(None, (), message, "a file that MuJoCo cannot take is not imported; try it in MuJoCo itself", True)


def _without_folder(text: str, path: Path) -> str:
    """Return a message that does not tell where the file lies on this machine."""
    return text.replace(f"{files.resolve(path).parent}{os.sep}", "")
