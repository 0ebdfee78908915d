"""``sweep --ninja``: real Ninja makes what the sweep makes, and of that only what is old."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from collections.abc import Mapping
from pathlib import Path

import pytest

from rosorin_compile.cli import main
from rosorin_compile_fleet.sweep.ninja import escaped, shell
from support.commands import Shown, ask, edit, touch, write_files

ROBOT = """\
robot: mast
args: {height: {type: length, default: 30 cm}, label: {type: text, default: ""}, offset: {default: [0, 0]}}
include: [head.yaml]
links: {base_link: {}}
outputs: {urdf: {file: mast.urdf}, frames: {file: frames.md}}
"""
HEAD = """\
links: {head: {collision: [{sphere: {radius: 10 cm}}]}}
joints: {neck: {type: fixed, parent: base_link, child: head, xyz: ["${offset[0]}", "${offset[1]}", "${height}"]}}
"""
LIST = "the list of variants"
FILES = {
    "descriptions/mast/robot.yaml": ROBOT,
    "descriptions/mast/head.yaml": HEAD,
    "fleet.csv": "name,height,label\nr1,31 cm,\nr2,0.32,a $HOME b:c\nr 3,33 cm,'\n",
    "cal/r1.yaml": "height: 31 cm\n",
    "cal/r2.yaml": "height: 32 cm\noffset: [1 mm, 0.002]\n",
    "list.yaml": 'r1: {height: 31 cm, offset: [1 mm, 0.002], label: "0007"}\nr2: {label: no}\nr3:\n',
}
NINJA = shutil.which("ninja")
needs_ninja = pytest.mark.skipif(NINJA is None, reason="no ninja")


@pytest.fixture
def masts(home: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    folder = home / "my ro$bots"
    write_files(folder, FILES)
    monkeypatch.chdir(folder)
    monkeypatch.setenv("PATH", f"{Path(sys.executable).parent}:{os.environ['PATH']}")
    monkeypatch.setattr(sys, "argv", [str(Path(sys.executable).parent / "rosorin-compile")])
    return folder


def ninja(*words: str, code: int = 0) -> list[str]:
    """Run Ninja, and return what it did, sorted: the variants that it made; nothing if there was no work."""
    env = {**os.environ, "NINJA_STATUS": "did "}
    done = subprocess.run([str(NINJA), *words], env=env, capture_output=True, text=True, check=False)
    assert done.returncode == code, done.stdout + done.stderr
    lines = done.stdout.splitlines()
    did = sorted(line.removeprefix("did ").removeprefix("robot ") for line in lines if line.startswith("did "))
    assert not did or "ninja: no work to do." not in lines or did == [LIST]
    return did


def artifacts(folder: Path) -> Mapping[str, bytes]:
    found = (path for path in folder.rglob("*") if path.is_file())
    return {
        path.relative_to(folder).as_posix(): path.read_bytes()
        for path in found
        if not path.relative_to(folder).parts[0].startswith(".") and path.name != "sweep.json"
    }


@pytest.mark.landing("builds", "cal-names1")
@pytest.mark.slow
@needs_ninja
@pytest.mark.parametrize(("over", "names"), [("fleet.csv", ["r 3", "r1", "r2"]), ("cal", ["r1", "r2"])])
def test_ninja_makes_what_the_sweep_makes(masts: Path, over: str, names: list[str]) -> None:
    assert main(["sweep", "--over", over, "-o", "made", "--ninja", "build.ninja"]) == 0
    assert not (masts / "made").exists()
    assert ninja() == names
    assert ninja() == []
    assert main(["sweep", "--over", over, "-o", "swept", "-q"]) == 0
    assert artifacts(masts / "made") == artifacts(masts / "swept")
    assert len(artifacts(masts / "made")) == 2 * len(names)


@pytest.mark.tier("builds")
@pytest.mark.slow
@needs_ninja
def test_a_list_in_yaml(masts: Path) -> None:
    assert main(["sweep", "--over", "list.yaml", "-o", "made", "--ninja", "build.ninja"]) == 0
    assert ninja() == ["r1", "r2", "r3"]
    assert main(["sweep", "--over", "list.yaml", "-o", "swept", "-q"]) == 0
    assert artifacts(masts / "made") == artifacts(masts / "swept")
    assert b'xyz="0.001 0.002 0.31"' in (masts / "made/r1/mast.urdf").read_bytes()
    edit(masts / "list.yaml", "31 cm", "41 cm")
    assert ninja() == ["r1", LIST]
    assert ninja() == []


@pytest.mark.slow
@needs_ninja
def test_only_what_is_old_is_made_anew(masts: Path) -> None:
    assert main(["sweep", "--over", "cal", "-o", "made", "--ninja", "build.ninja"]) == 0
    ninja()
    edit(masts / "cal/r2.yaml", "32 cm", "35 cm")
    assert ninja() == ["r2"]
    assert b"0.35" in (masts / "made/r2/mast.urdf").read_bytes()
    edit(masts / "descriptions/mast/head.yaml", "10 cm", "11 cm")  # which only the depfile names
    assert ninja() == ["r1", "r2"]
    (masts / "cal/r3.yaml").write_text("height: 40 cm\n", "utf-8")
    assert ninja() == ["r3", LIST]
    assert ninja() == []
    (masts / "cal/r1.yaml").write_text("hight: 40 cm\n", "utf-8")
    assert ninja("-k", "0", code=1) == ["r1"]
    (masts / "cal/r1.yaml").write_text("height: 40 cm\n", "utf-8")
    assert ninja() == ["r1"]


@pytest.mark.tier("builds")
@pytest.mark.slow
@needs_ninja
def test_a_row_that_is_changed_is_one_robot(masts: Path) -> None:
    assert main(["sweep", "--over", "fleet.csv", "-o", "made", "--ninja", "build.ninja"]) == 0
    ninja()
    edit(masts / "fleet.csv", "31 cm", "36 cm")
    assert ninja() == ["r1", LIST]
    assert ninja() == []


@pytest.mark.tier("builds")
@pytest.mark.slow
@needs_ninja
def test_a_build_file_in_a_folder_of_its_own(masts: Path) -> None:
    words = ["sweep", "mast", "--over", "fleet.csv", "-o", "build/made", "--ninja", "build/build.ninja"]
    (masts / "all.yaml").write_text("offset: [1 mm, 2 mm]\n", "utf-8")
    assert main([*words, "--args", "all.yaml", "-a", "height=1 m"]) == 0
    assert ninja("-C", "build") == ["r 3", "r1", "r2"]
    assert ninja("-C", "build") == []
    assert b'xyz="0.001 0.002 0.31"' in (masts / "build/made/r1/mast.urdf").read_bytes()  # the row goes before -a
    touch(masts / "fleet.csv")
    assert ninja("-C", "build") == [LIST]


def test_the_file_is_the_same_each_time(masts: Path, capsys: Shown) -> None:
    words = ["sweep", "--over", "cal", "-o", "made", "--ninja", "build.ninja"]
    assert "build.ninja: 2 variants for ninja" in ask(capsys, *words)
    once = (masts / "build.ninja").read_bytes()
    ask(capsys, *words)
    assert (masts / "build.ninja").read_bytes() == once
    assert str(masts).encode() not in once.replace(sys.executable.encode(), b"")


def test_escapes() -> None:
    assert escaped("a b:c$d") == "a$ b$:c$$d"
    assert shell(["-a", "label=a $HOME b:c"]) == "-a 'label=a $$HOME b:c'"


@pytest.mark.parametrize(
    ("words", "code", "message"),
    [
        (["--over", "fleet.csv", "-j", "2"], 2, "it does not go with -j"),
        (["--over", "fleet.csv", "--prune"], 2, "it does not go with --prune"),
        (["--over", "fleet.csv", "--dask", "tcp://x:1"], 2, "it does not go with --dask"),
        (["--over", "nothing.csv"], 1, "nothing.csv"),
        (["--over", "bad.csv"], 1, 'the description has no argument "hight"'),
    ],
)
def test_what_cannot_be(masts: Path, capsys: Shown, words: list[str], code: int, message: str) -> None:
    (masts / "bad.csv").write_text("name,hight\nr1,3 cm\n", "utf-8")
    assert message in ask(capsys, "sweep", "-o", "made", "--ninja", "build.ninja", *words, code=code)
    assert not (masts / "build.ninja").exists()


def test_a_name_with_a_line_break(masts: Path, capsys: Shown) -> None:
    (masts / "cal").rename(masts / "c\nal")
    said = ask(capsys, "sweep", "--over", "c\nal", "-o", "made", "--ninja", "build.ninja", code=1)
    assert "error[ninja-name]" in said


def test_a_file_of_a_folder_that_is_none(masts: Path, capsys: Shown) -> None:
    (masts / "cal/r2.yaml").write_text("[1, 2]\n", "utf-8")
    said = ask(capsys, "sweep", "--over", "cal", "-o", "made", "--ninja", "build.ninja", code=1)
    assert "r2: cal/r2.yaml is no table of values" in said
