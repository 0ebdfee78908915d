"""The wheel on each Python that ROS has: every command of every day, and on all the same bytes.

``.ci/full pythons`` builds the wheel once and installs it on each interpreter that is here, pyenv's or one of PATH; one
that is not here is skipped, and named. Then it tries the oldest packages that the extras take.
"""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from support.paths import OUTPUTS, ROOT
from support.upgrade import files

VERSIONS = ("3.10", "3.11", "3.12", "3.13", "3.14")  # Humble and JetPack 6, Debian 12, Jazzy, and what comes
ARTIFACTS = 16
ARM = """\
<mujoco model="arm"><worldbody><body name="base" pos="0 0 0.1"><geom name="box" type="box" size=".1 .1 .1" mass="1"/>
<body name="link" pos="0 0 .1"><joint name="hinge" type="hinge" axis="0 1 0" range="-1 1" damping=".1"/>
<geom name="bar" type="capsule" fromto="0 0 0 0 0 .3" size=".02" density="500"/></body></body></worldbody>
<actuator><position name="servo" joint="hinge" kp="10" ctrlrange="-1 1"/></actuator></mujoco>
"""
COMMANDS = (
    "all rosorin ur5e -q",
    "check rosorin -q",
    "print urdf rosorin -q -o printed.urdf",
    "diff descriptions/rosorin printed.urdf",
    "sweep rosorin --over bases.csv -o bases -j 2 -q",
    "import printed.urdf -o of_urdf",
    "import robot.xacro --trust -o of_xacro",
)
OF_MUJOCO = ("simulate ur5e", "check ur5e --physics -q", "collisions rosorin")
OF_IMPORT = ("import arm.xml -o of_mjcf",)


def interpreter(version: str) -> str | None:
    """Return the newest Python of a version that is here."""
    root = Path(os.environ.get("PYENV_ROOT", Path.home() / ".pyenv"))
    found = sorted(root.glob(f"versions/{version}.*/bin/python"), key=lambda path: len(path.parts[-3]))
    for one in [*map(str, reversed(found)), shutil.which(f"python{version}")]:
        asked = one and subprocess.run([one, "-V"], capture_output=True, text=True, check=False)
        if asked and asked.stdout.startswith(f"Python {version}."):  # a shim of pyenv may lead nowhere
            return one
    return None


def bounds(extra: str) -> list[str]:
    """Return the oldest packages that an extra takes, as pip is asked for them."""
    (line,) = re.findall(rf"^{extra} = \[(.*)\]$", (ROOT / "pyproject.toml").read_text("utf-8"), re.MULTILINE)
    return re.findall(r'"([^"]+)"', line.replace(">=", "=="))


def test_interpreters_and_bounds_are_found() -> None:
    here = ".".join(map(str, sys.version_info[:2]))
    assert interpreter("2.999") is None
    assert here not in VERSIONS or interpreter(here) is None or Path(interpreter(here) or "").exists()
    assert [one.partition("==")[0] for one in bounds("simulate")] == ["mujoco", "numpy"]


@pytest.fixture(scope="module")
def wheel(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("wheel")
    subprocess.run(["git", "clone", "--quiet", ROOT, folder / "clone"], check=True)
    command = [sys.executable, "-m", "pip", "wheel", "--quiet", "--no-deps", "-w", folder, folder / "clone"]
    subprocess.run(command, check=True)
    (made,) = folder.glob("*.whl")
    return made


def installed(version: str, folder: Path, *packages: str) -> Path:
    """Return the command, installed on a Python; skip where that is not here."""
    python = interpreter(version)
    if python is None:
        pytest.skip(f"no Python {version} is here")
    subprocess.run([python, "-m", "venv", folder / "venv"], check=True)
    subprocess.run([folder / "venv/bin/python", "-m", "pip", "install", "--quiet", *packages], check=True)
    return folder / "venv/bin/rosorin-compile"


def project(folder: Path) -> Path:
    made = folder / "project"
    shutil.copytree(ROOT / "descriptions", made / "descriptions")
    shutil.copytree(ROOT / "examples" / "ur5e", made / "descriptions" / "ur5e")
    shutil.copy(ROOT / "examples" / "turtlebot3_burger" / "xacro" / "robot.xacro", made)
    (made / "bases.csv").write_text("name,base\nheld,fixed\nloose,free\n")
    (made / "arm.xml").write_text(ARM)
    return made


def ran(tool: Path, place: Path, words: str) -> tuple[int, str]:
    environment = {**os.environ, "ROSORIN_COMPILE_CACHE": str(place / "cache")}
    done = subprocess.run(
        [tool, *words.split()], cwd=place, env=environment, capture_output=True, text=True, check=False
    )
    return done.returncode, done.stdout + done.stderr


@pytest.mark.tier("pythons")
@pytest.mark.parametrize("version", VERSIONS)
def test_every_command_runs_and_the_bytes_are_the_same(version: str, wheel: Path, tmp_path: Path) -> None:
    tool = installed(version, tmp_path, f"{wheel}[import,physics,simulate]")
    place = project(tmp_path)
    for words in (*COMMANDS, "simulate rosorin", *OF_MUJOCO, *OF_IMPORT):
        code, said = ran(tool, place, words)
        assert code == 0, f"{words}: exit code {code}\n{said[-2000:]}"
    made = files(place / "outputs" / "rosorin")
    assert len(made) == ARTIFACTS
    assert made == files(OUTPUTS)


@pytest.mark.tier("pythons")
def test_the_oldest_mujoco_simulates_and_what_it_cannot_is_told(wheel: Path, tmp_path: Path) -> None:
    tool = installed("3.10", tmp_path, str(wheel), *bounds("physics"))
    place = project(tmp_path)
    for words in ("all rosorin ur5e -q", "check rosorin", *OF_MUJOCO):
        code, said = ran(tool, place, words)
        assert code == 0, f"{words}: exit code {code}\n{said[-2000:]}"
        assert words != "check rosorin" or "warning[engine-refuses]" in said
    for words in ("simulate rosorin", *OF_IMPORT):  # a camera, and what an import asks for
        code, said = ran(tool, place, words)
        assert code == 1
        assert re.search(r"MuJoCo 3\.3\.\d+ is too old for it, MuJoCo 4 may know it", said), said
        assert "Traceback" not in said


@pytest.mark.tier("pythons")
def test_the_oldest_packages_import(wheel: Path, tmp_path: Path) -> None:
    tool = installed("3.10", tmp_path, str(wheel), *bounds("import"), "jinja2==3.0.0", "jsonschema-rs==0.60.0")
    place = project(tmp_path)
    for words in (*COMMANDS, "simulate rosorin", *OF_MUJOCO, *OF_IMPORT):
        code, said = ran(tool, place, words)
        assert code == 0, f"{words}: exit code {code}\n{said[-2000:]}"
    assert files(place / "outputs" / "rosorin") == files(OUTPUTS)
