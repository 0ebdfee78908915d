"""The wheel on each Python that ROS has: every command of every day, and on all the same bytes.

``.ci/full pythons`` builds the wheel once and installs it on each interpreter that is here, pyenv's or one of PATH; one
that is not here is skipped, and named. Then it tries the oldest packages that the extras take, and those that
distributions bring along: Ubuntu 22.04's on Python 3.10, and this machine's own where it is Debian or Ubuntu.
"""

import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from support.paths import OUTPUTS, ROOT

VERSIONS = ("3.10", "3.11", "3.12", "3.13", "3.14")  # Humble and JetPack 6, Debian 12, Jazzy, and what comes
ARM = """\
<mujoco model="arm"><worldbody><body name="base" pos="0 0 0.1"><geom name="box" type="box" size=".1 .1 .1" mass="1"/>
<body name="link" pos="0 0 .1"><joint name="hinge" type="hinge" axis="0 1 0" range="-1 1" damping=".1"/>
<geom name="bar" type="capsule" fromto="0 0 0 0 0 .3" size=".02" density="500"/></body></body></worldbody>
<actuator><position name="servo" joint="hinge" kp="10" ctrlrange="-1 1"/></actuator></mujoco>
"""
COMMANDS = (
    "all rosorin ur5e -q",
    "check rosorin -q",
    "print rosorin urdf -q -o printed.urdf",
    "diff descriptions/rosorin printed.urdf",
    "sweep rosorin --over bases.csv -o bases -j 2 -q",
    "import printed.urdf -o of_urdf",
    "import robot.xacro --trust -o of_xacro",
)
OF_MUJOCO = ("simulate ur5e", "check physics ur5e -q", "collisions rosorin")
OF_IMPORT = ("import arm.xml -o of_mjcf",)
EVERY_DAY = ("all rosorin ur5e -q", "print rosorin urdf -q -o printed.urdf", "check rosorin -q")
# What Ubuntu 22.04 has as python3-jsonschema, python3-yaml, ...; pip builds PyYAML 5.4.1 with an older Cython.
UBUNTU = ("jsonschema==3.2.0", "attrs==21.2.0", "pyrsistent==0.18.1", "six==1.16.0", "setuptools==59.6.0")
UBUNTU += ("click==8.0.3", "jinja2==3.0.3", "markupsafe==2.0.1", "numpy==1.21.5", "wheel==0.37.1", "cython<3")
SYSTEM = "/usr/bin/python3"


def interpreter(version: str) -> str | None:
    root = Path(os.environ.get("PYENV_ROOT", Path.home() / ".pyenv"))
    found = sorted(root.glob(f"versions/{version}.*/bin/python"), key=lambda path: len(path.parts[-3]))
    for one in [*map(str, reversed(found)), shutil.which(f"python{version}")]:
        asked = one and subprocess.run([one, "-V"], capture_output=True, text=True, check=False)
        if asked and asked.stdout.startswith(f"Python {version}."):  # a shim of pyenv may lead nowhere
            return one
    return None


def bounds(extra: str) -> list[str]:
    (line,) = re.findall(rf"^{extra} = \[(.*)\]$", (ROOT / "pyproject.toml").read_text("utf-8"), re.MULTILINE)
    return re.findall(r'"([^"]+)"', line.replace(">=", "=="))


def files(folder: Path) -> dict[str, bytes]:
    found = sorted(path for path in folder.rglob("*") if path.is_file())
    return {path.relative_to(folder).as_posix(): path.read_bytes() for path in found}


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
    install = [folder / "venv/bin/python", "-m", "pip", "install", "--quiet"]
    subprocess.run([*install, "--upgrade", "pip"], check=True)  # that of Python 3.10 searches for versions without end
    subprocess.run([*install, *packages], check=True)
    return folder / "venv/bin/rosorin-compile"


def project(folder: Path) -> Path:
    made = folder / "project"
    shutil.copytree(ROOT / "descriptions", made / "descriptions")
    shutil.copytree(ROOT / "examples" / "ur5e", made / "descriptions" / "ur5e")
    shutil.copy(ROOT / "examples" / "turtlebot3_burger" / "xacro" / "robot.xacro", made)
    (made / "bases.csv").write_text("name,base\nheld,fixed\nloose,free\n")
    (made / "arm.xml").write_text(ARM)
    return made


def run(tool: Path, place: Path, *commands: str) -> str:
    """Run commands, each of which succeeds, in a project; return what they print."""
    said = ""
    for words in commands:
        code, printed = ran(tool, place, words)
        assert code == 0, f"{words}: exit code {code}\n{printed[-2000:]}"
        said += printed
    return said


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
    everything = version in (VERSIONS[0], "3.13")  # the ones between run what needs no engine
    run(tool, place, *COMMANDS, *(("simulate rosorin", *OF_MUJOCO, *OF_IMPORT) if everything else ()))
    assert files(place / "outputs" / "rosorin") == files(OUTPUTS)


@pytest.mark.tier("pythons")
def test_the_oldest_mujoco_does_everything_and_an_older_one_is_named(wheel: Path, tmp_path: Path) -> None:
    tool = installed("3.10", tmp_path, str(wheel), *bounds("physics"))
    place = project(tmp_path)
    run(tool, place, "all rosorin ur5e -q", "check rosorin", "simulate rosorin", *OF_MUJOCO, *OF_IMPORT)
    subprocess.run([tool.parent / "python", "-m", "pip", "install", "--quiet", "mujoco==3.3.7"], check=True)
    assert "warning[engine-refuses]" in run(tool, place, "check rosorin")
    for words in ("simulate rosorin", "import arm.xml -o again"):
        code, said = ran(tool, place, words)
        assert code == 1
        assert "MuJoCo 3.3.7 is too old for it, MuJoCo 4 may know it" in said
        assert "Traceback" not in said


OLDEST = ("click==8.0.0", "jinja2==3.0.0", "jsonschema==3.2.0")


@pytest.mark.tier("pythons")
def test_the_oldest_packages_import(wheel: Path, tmp_path: Path) -> None:
    tool, place = installed("3.10", tmp_path, str(wheel), *bounds("import"), *OLDEST), project(tmp_path)
    run(tool, place, *COMMANDS, "simulate rosorin", *OF_MUJOCO, *OF_IMPORT)
    assert files(place / "outputs" / "rosorin") == files(OUTPUTS)


@pytest.mark.tier("pythons")
def test_the_packages_of_ubuntu_22_04_are_enough(wheel: Path, tmp_path: Path) -> None:
    tool, place = installed("3.10", tmp_path, *UBUNTU), project(tmp_path)
    pip = [tmp_path / "venv/bin/python", "-m", "pip", "install", "--quiet"]
    subprocess.run([*pip, "--no-build-isolation", "pyyaml==5.4.1"], check=True)
    subprocess.run([*pip, "--no-deps", wheel], check=True)
    run(tool, place, *EVERY_DAY)
    assert files(place / "outputs" / "rosorin") == files(OUTPUTS)


@pytest.mark.tier("pythons")
def test_the_packages_of_this_distribution_are_enough(tmp_path: Path) -> None:
    asked = "import click, jinja2, jsonschema, setuptools, venv, wheel, yaml"
    if subprocess.run([SYSTEM, "-c", asked], capture_output=True, check=False).returncode:
        pytest.skip(f"{SYSTEM} has not all packages: {asked}")
    subprocess.run(["git", "clone", "--quiet", ROOT, tmp_path / "clone"], check=True)
    subprocess.run([SYSTEM, "-m", "venv", "--system-site-packages", "--without-pip", tmp_path / "venv"], check=True)
    own = tmp_path / "venv/bin/python"
    command = [sys.executable, "-m", "pip", "--python", own, "install", "--quiet", "--no-deps", "--no-build-isolation"]
    subprocess.run([*command, tmp_path / "clone"], check=True)
    place = project(tmp_path)
    run(tmp_path / "venv/bin/rosorin-compile", place, *EVERY_DAY)
    assert files(place / "outputs" / "rosorin") == files(OUTPUTS)


@pytest.mark.tier("pythons")
@pytest.mark.parametrize("version", ["3.2.0", "4.17.3"])
def test_each_jsonschema_tells_every_mistake_in_the_same_words(version: str, tmp_path: Path) -> None:
    pip = [sys.executable, "-m", "pip", "install", "--quiet", "--target", tmp_path, f"jsonschema=={version}"]
    subprocess.run(pip, check=True)
    words = [sys.executable, "-m", "pytest", "-p", "no:cacheprovider", "-m", "not slow", "tests/whole/test_bad.py"]
    environment = {**os.environ, "PYTHONPATH": str(tmp_path)}
    done = subprocess.run(words, cwd=ROOT, env=environment, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout[-3000:]
