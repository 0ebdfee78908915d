"""``--depfile``: every file that was read, in the words of Make and Ninja, which then do no more than they have to."""

import os
import re
import shutil
import subprocess
import sys
import time
from pathlib import Path

import pytest

from rosorin_compile.cli.run import escape
from rosorin_compile.output.atomic_files import OutputError
from support.projects import foreign, meshes, packaged, rosorin_alone, ur5e

# Notes each file that is opened for reading, in every process of Python that is started.
HOOK = """\
import os, sys
_log = os.open(os.environ["OPENED"], os.O_WRONLY | os.O_APPEND | os.O_CREAT)
def _note(event, given):
    if event == "open" and isinstance(given[0], (str, bytes)):
        if not (given[2] or 0) & (os.O_WRONLY | os.O_RDWR | os.O_DIRECTORY):
            os.write(_log, os.fsencode(os.path.realpath(given[0])) + b"\\n")
sys.addaudithook(_note)
"""


def names_in(depfile: Path) -> list[str]:
    """Return the names in a depfile without anything to escape; the target is the first."""
    target, _, rest = depfile.read_text("utf-8").partition(":")
    return [target, *rest.replace("\\\n", " ").split()]


def opened_by(folder: Path, *words: str) -> set[str]:
    hook = folder / "hook"
    hook.mkdir()
    (hook / "sitecustomize.py").write_text(HOOK)
    log = hook / "opened"
    environment = {"OPENED": str(log), "PYTHONPATH": str(hook), "PYTHONDONTWRITEBYTECODE": "1"}
    environment |= {"ROSORIN_COMPILE_CACHE": "off"}
    command = [sys.executable, "-m", "rosorin_compile", *words]
    done = subprocess.run(command, env={**os.environ, **environment}, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    here = Path.cwd().resolve()
    opened = {Path(os.fsdecode(line)) for line in log.read_bytes().splitlines()}
    return {str(path.relative_to(here)) for path in opened if path.is_relative_to(here) and path.is_file()}


CASES = {
    "reference": (rosorin_alone, ["all"]),
    "reference-one": (rosorin_alone, ["print", "mjcf", "-o", "made.xml"]),
    "example": (ur5e, ["all", "--only", "urdf"]),
    "xacro-in-a-package": (packaged, ["all", "r", "-q"]),
    "foreign": (foreign, ["all"]),
    "meshes": (meshes, ["all", "--args", "cal.yaml", "--package", "p=p"]),
    "meshes-print": (meshes, ["print", "r", "mjcf", "--args", "cal.yaml", "--package", "p=p", "-o", "a.xml"]),
    "a-page": (meshes, ["print", "r", "page", "--package", "p=p", "-o", "a.html"]),
    "a-template": (meshes, ["print", "r", "note", "-o", "a.txt"]),
    "a-xacro-alone": (meshes, ["print", "descriptions/r/x/v.xacro", "urdf", "-o", "a.urdf"]),
}
NAMING = "package.xml"


@pytest.mark.parametrize("case", CASES)
def test_every_file_that_was_opened_stands_in_the_depfile(
    case: str, home: Path, tmp_path_factory: pytest.TempPathFactory
) -> None:
    make, words = CASES[case]
    make()
    opened = opened_by(tmp_path_factory.mktemp("hook"), *words, "--depfile", "made.d")
    target, *inputs = names_in(home / "made.d")
    assert Path(target).is_file()
    listed = {os.path.relpath(os.path.realpath(name), home.resolve()) for name in inputs}
    assert len(opened) > 1 or "alone" in case
    written = {name for name in opened if name.startswith("outputs/")}
    assert {name for name in opened - written if Path(name).name != NAMING} - listed == set()
    assert all(Path(name).exists() for name in inputs)


@pytest.mark.parametrize("name", [" a  b", "$HOME", "a # b", "x\\ y", "x\\\\ y", "é", "c:\\d", "[1]"])
def test_a_name_is_escaped_as_ninja_and_make_take_it(name: str, home: Path) -> None:
    """Both read the name back: a file that is there is one that they can stat, and its absence is told by its name."""
    (home / name).write_text("")
    (home / "made.d").write_text(f"made: {escape(name)}\n")
    (home / "build.ninja").write_text(
        "rule r\n  command = cp made.d made2.d; touch made\n  depfile = made2.d\nbuild made: r\n"
    )
    run("ninja")
    assert "no work to do" in run("ninja")
    touched(home / name)
    assert "no work to do" not in run("ninja")
    assert "no work to do" in run("ninja")
    (home / "Makefile").write_text("made:\n\ttouch made\ninclude made.d\n")
    assert "'made' is up to date" in run("make", "made")
    touched(home / name)
    assert "touch made" in run("make", "made")


@pytest.mark.parametrize("name", ["a b", "$HOME", "#1", "x\\ y", "a:b"])
def test_a_target_is_escaped_as_ninja_takes_it(name: str, home: Path) -> None:
    (home / "read").write_text("")
    (home / "made.d").write_text(f"{escape(name)}: read\n")
    target = re.sub("[$: ]", r"$\g<0>", name)
    rule = "rule r\n  command = cp made.d made2.d; touch $out\n  depfile = made2.d\n  deps = gcc\n"
    (home / "build.ninja").write_text(f"{rule}build {target}: r\n")
    run("ninja")
    assert "no work to do" in run("ninja")
    touched(home / "read")
    assert "no work to do" not in run("ninja")
    assert "no work to do" in run("ninja")


def test_a_name_that_no_depfile_can_hold() -> None:
    with pytest.raises(OutputError, match="has a line break"):
        escape("a\nb")


def run(*words: str, code: int = 0) -> str:
    program = shutil.which(words[0], path=f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}")
    if program is None:
        pytest.skip(f"{words[0]} is not installed")
    done = subprocess.run([program, *words[1:]], capture_output=True, text=True, check=False)
    assert done.returncode == code, done.stdout + done.stderr
    return done.stdout


def touched(path: Path) -> None:
    time.sleep(0.02)
    os.utime(path)
    time.sleep(0.02)
