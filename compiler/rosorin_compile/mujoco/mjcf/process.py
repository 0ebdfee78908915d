"""Run MuJoCo in a child process: read a file, load a generated MJCF, and compare an imported MJCF with its source.

MuJoCo is native code, and some files make it crash, hang or use all memory. In a child process, such a file only
causes an error message. Starting the process takes 20 ms, and loading MuJoCo 300 ms.
"""

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
from rosorin_compile.formats.imported_robot import ImportedRobot, Proof
from rosorin_compile.source import files, system
from rosorin_compile.source.diagnostics import phrase
from rosorin_compile.source.system import is_installed, pip_install

from . import FILE

SECONDS = 60  # CPU time limit, which the child process enforces
_PATIENCE = 5  # ratio of the wall-clock limit to the CPU limit, because the process may wait for files

_TOP = str(files.resolve(__file__).parents[3])  # the folder that contains the package
# Use -c, because -m would import modules from the working directory, which may be untrusted.
_START = (
    "import sys; sys.path[:] = [p for p in sys.path if p] + [sys.argv[1]];"
    "from rosorin_compile.mujoco.mjcf import engine;"
    "engine.main(sys.argv[2], sys.argv[3], sys.argv[4], int(sys.argv[5]))"
)


_GONE = r".*: is not in ours$"
# Patterns of expected differences ("KIND FIELD: TEXT"), by a phrase in the import message that explains them.
LISTED = {
    "of the world: the scene": rf"(geom|mesh|hfield|site|camera) {_GONE}|geom user"
    r"|contact : body world and .* may touch only in the source$",
    "becomes the link": r"\w+ name:",
    'is called "': r"\w+ name:",
    "no range limit": r"joint (range|limited):",
    " of the free joint ": r"joint (?!name)",
    " of the joint ": r"joint (?!name)",
    " of a geom ": r"geom (?!name|contype|conaffinity)",
    " of the body ": r"body (gravcomp|mocapid|sleep|user):",
    " of the actuator ": r"actuator (?!name)",
    "its control is not where it was": r"order |key ",
    "sensor data is in another order": r"order sensor",
    " of a key ": r"key ",
    "move a little otherwise": r"motion ",
    "the setting ": r"option ",
}
_LISTS = ("import-cannot-carry", "import-ignored", "import-changed", "import-stand-in")


class Answer(NamedTuple):
    """The result of loading an MJCF: the compiled model as JSON (``facts``), or an error message (``refusal``).

    ``own`` is true if the error is not from MuJoCo, ``missing`` if a Python package is not installed.
    """

    facts: dict[str, Any] | None
    warnings: tuple[str, ...] = ()
    refusal: str = ""
    help: str = ""
    own: bool = False
    missing: bool = False


def ask(path: Path, seconds: int = SECONDS) -> Answer:
    """Load an MJCF in a child process with a limit on its CPU time, and return the compiled model or the error."""
    system.needs("resource", system.NO_LIMITS)
    answer = _in_child("read", {"path": str(files.resolve(path))}, seconds)
    if isinstance(answer, Answer):
        return answer
    warnings = tuple(answer.pop("warnings"))
    if "refused" in answer:
        refused = answer["refused"].replace(f"{files.resolve(path).parent}{os.sep}", "")
        return Answer(None, warnings, refused, "correct it: MuJoCo does not load the file")
    return Answer(answer, warnings)


def refusal(text: str, folder: Path, seconds: int = SECONDS) -> Refusal:
    """Load a generated MJCF with MuJoCo and return the error, if any; paths in the MJCF are relative to ``folder``.

    An MJCF without meshes or textures is loaded in this process, because only foreign files can crash MuJoCo.
    """
    from xml.sax.saxutils import unescape

    names = re.findall(FILE, text)
    for file in (folder / unescape(name, {"&quot;": '"'}) for name in names):
        files.record(file, files.version(file))
    if not is_installed("mujoco"):
        return Refusal(missing="MuJoCo")
    if names:
        answer = _in_child("load", {"text": text, "folder": str(files.resolve(folder))}, seconds)
    else:
        answer = import_module(".engine", __package__).load(text, str(folder))
    if isinstance(answer, Answer):
        return Refusal(answer.refusal)
    reason, outdated = " ".join(answer[0].split()).removeprefix("Error: "), answer[1]
    named = re.search(r"Element name '([^']+)'", reason)  # MuJoCo only names the mesh, so add its file
    mesh = named and re.search(rf'<mesh\b[^<>]*\bname="{re.escape(named[1])}"[^<>]*\bfile="([^"]*)"', text)
    reason = f"{mesh[1]}: {reason}" if mesh and mesh[1] not in reason else reason
    return Refusal(reason.replace(f"{files.resolve(folder)}{os.sep}", ""), outdated)


def prove(imported: ImportedRobot, text: str, meshes: Mapping[str, str], seconds: int = SECONDS) -> Proof:
    """Compare an imported MJCF with ``text``, the MJCF generated from it; ``meshes`` maps file names to paths."""
    request = {"path": str(files.resolve(imported.files[0])), "text": text, "files": {**meshes}}
    answer = _in_child("prove", {**request, "names": imported.names}, seconds)
    if isinstance(answer, Answer):
        return Proof(unknown=answer.refusal)
    if "refused" in answer:
        return Proof({"loading": [f"MuJoCo does not load the MJCF that it becomes: {answer['refused']}"]})
    wrong, known = dict[str, list[str]](), dict[str, list[str]]()
    messages = [one.message for one in imported.diagnostics if one.rule in _LISTS]
    patterns = [pattern for words, pattern in LISTED.items() if any(words in message for message in messages)]
    for kind, field, text in answer["differences"]:
        is_listed = any(re.match(pattern, f"{kind} {field}: {text}") for pattern in patterns)
        (known if is_listed else wrong).setdefault(f"{kind} {field}".strip(), []).append(text)
    if wrong:
        return Proof(wrong, known)
    but = f"except for what is listed above ({phrase(list(known))})" if known else "in every field but its appearance"
    motion = f"; frames and accelerations {answer['motion']}" if "motion" in answer else ""
    return Proof(wrong, known, f"MuJoCo's model of the MJCF is that of the source, {but}{motion}")


def _in_child(job: str, request: Mapping[str, Any], seconds: int) -> Any:
    """Run a job of ``engine`` in a child process and return its result, or an Answer if the process failed."""
    with tempfile.TemporaryDirectory(prefix="rosorin-compile-") as folder:
        file, answer = Path(folder, "request.json"), Path(folder, "answer.json")
        file.write_text(json.dumps(request), encoding="utf-8")
        command = [sys.executable, "-c", _START, _TOP, job, str(file), str(answer), str(seconds)]
        message = f"MuJoCo did not come to an end with the file in {seconds} s"
        endless = Answer(None, (), message, "make the model smaller", True)
        try:
            done = _run(command, folder, seconds)
        except subprocess.TimeoutExpired:
            return endless
        if answer.exists():
            return json.loads(answer.read_text("utf-8"))
    if done.returncode == -getattr(signal, "SIGXCPU", 0) < 0:
        return endless
    last = done.stderr.decode("utf-8", "replace").strip().rpartition("\n")[2]
    if absent := re.match(r"ModuleNotFoundError: No module named '(\w+)", last):
        what = "MuJoCo, which reads MJCF," if absent[1] == "mujoco" else f"the package {absent[1]}, which MuJoCo needs,"
        return Answer(None, (), f"{what} is not installed", pip_install("import"), True, True)
    message = f"MuJoCo gave up on the file: {last or f'exit code {done.returncode}'}"
    message = f"MuJoCo crashed on the file (signal {-done.returncode})" if done.returncode < 0 else message
    return Answer(None, (), message, "a file that MuJoCo cannot take is not imported; try it in MuJoCo itself", True)


def _run(command: list[str], folder: str, seconds: int) -> subprocess.CompletedProcess[bytes]:
    environment, most = {key: value for key, value in os.environ.items() if key != "MUJOCO_GL"}, _PATIENCE * seconds
    return subprocess.run(command, cwd=folder, capture_output=True, timeout=most, env=environment)  # noqa: S603
