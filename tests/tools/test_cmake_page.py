"""docs/builds.md at work: its project in CMake, its build.ninja and its Makefile."""

import os
import re
import shutil
import subprocess
from pathlib import Path

import pytest

from support.cmake import PROGRAM, environment, ran
from support.commands import edit, touch
from support.pages import play
from support.paths import DOCS

PAGE = DOCS / "builds.md"
pytestmark = pytest.mark.slow


@pytest.fixture
def lamp(tmp_path: Path) -> Path:
    play(PAGE, tmp_path)
    return tmp_path


def run(lamp: Path, command: str, fails: bool = False) -> str:
    env = {**environment(lamp), "PATH": f"{PROGRAM.parent}:{os.environ['PATH']}"}
    words = ["bash", "-euc", command]
    done = subprocess.run(
        words, cwd=lamp, env=env, text=True, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, check=False
    )
    assert bool(done.returncode) == fails, done.stdout
    return done.stdout


def removed(lamp: Path) -> None:
    (lamp / "descriptions/lamp/shade.yaml").unlink()
    edit(lamp / "descriptions/lamp/robot.yaml", "include: [shade.yaml]\n", "")


@pytest.mark.skipif(not (shutil.which("cmake") and shutil.which("ninja")), reason="no cmake with ninja")
def test_cmake(lamp: Path) -> None:
    command = re.search(r"^cmake -B build .*", PAGE.read_text("utf-8"), re.MULTILINE)
    assert command
    assert ran(run(lamp, command[0])) == ["golden lamp", "lamp"]
    assert (lamp / "there/share/lamp/lamp.urdf").read_bytes() == (lamp / "outputs/lamp/lamp.urdf").read_bytes()
    assert ran(run(lamp, command[0])) == []


@pytest.mark.tier("builds")
@pytest.mark.skipif(not shutil.which("ninja"), reason="no ninja")
def test_ninja(lamp: Path) -> None:
    shade = lamp / "descriptions/lamp/shade.yaml"
    assert "[2/2]" in run(lamp, "ninja")
    assert "no work to do" in run(lamp, "ninja")
    touch(shade)
    assert "[2/2]" in run(lamp, "ninja")
    assert "no work to do" in run(lamp, "ninja")
    touch(lamp / "outputs/lamp/lamp.urdf")
    assert "[1/1]" in run(lamp, "ninja")
    edit(lamp / "descriptions/lamp/robot.yaml", "30 cm", "40 cm")
    assert "shade moved 100.0 mm" in run(lamp, "ninja", fails=True)
    assert "shade moved 100.0 mm" in run(lamp, "ninja", fails=True)
    run(lamp, "rosorin-compile all && ninja")
    assert "no work to do" in run(lamp, "ninja")
    removed(lamp)
    run(lamp, "rosorin-compile all && ninja")
    assert "no work to do" in run(lamp, "ninja")
    assert "shade" not in (lamp / "built/lamp/lamp.urdf").read_text()


@pytest.mark.skipif(not shutil.which("make"), reason="no make")
def test_make(lamp: Path) -> None:
    assert "rosorin-compile all" in run(lamp, "make")
    assert "up to date" in run(lamp, "make")
    touch(lamp / "descriptions/lamp/shade.yaml")
    assert "rosorin-compile all" in run(lamp, "make")
    assert "up to date" in run(lamp, "make")
    removed(lamp)
    assert "rosorin-compile all" in run(lamp, "make")
    assert "up to date" in run(lamp, "make")
    assert "shade" not in (lamp / "built/lamp/lamp.urdf").read_text()
