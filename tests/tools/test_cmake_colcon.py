"""rosorin_compile_add_robot in a workspace of colcon: one package includes the robot of another, and its files."""

import os
import shutil
import subprocess
import time
from pathlib import Path

import pytest

from support.cmake import GENERATORS, PROGRAM, WORKSPACE, environment, plainly, ran
from support.colcon import AMENT_CMAKE, AMENT_PACKAGE, COLCON, NEEDS_COLCON
from support.commands import edit, touch
from support.paths import ROOT

CMAKE_PACKAGE = ROOT / "ament" / "rosorin_compile_cmake"

pytestmark = [
    pytest.mark.slow,
    NEEDS_COLCON,
    pytest.mark.skipif(not AMENT_CMAKE.is_file() or not GENERATORS, reason="no ament-cmake"),
]
NINJA, MAKE = (GENERATORS[0], GENERATORS[-1]) if GENERATORS else ("", "")
BUILDS = pytest.mark.tier("builds")
ALL = ["arm", "bench", "cart", "cell", "golden arm", "left_arm"]
OF_ARM = ["arm", "bench", "cell", "golden arm", "left_arm"]


@pytest.fixture
def workspace(tmp_path: Path) -> Path:
    """A workspace with the three packages, the one that hands out the function, and the program on PATH."""
    folder = tmp_path / "a workspace"
    shutil.copytree(WORKSPACE, folder)
    shutil.copytree(CMAKE_PACKAGE, folder / "src" / "rosorin_compile_cmake")
    (folder / "bin").mkdir()
    (folder / "bin" / "rosorin-compile").symlink_to(PROGRAM)
    if AMENT_PACKAGE.is_dir():  # all that ament_cmake asks of Debian's Python
        (folder / "site").mkdir()
        (folder / "site" / "ament_package").symlink_to(AMENT_PACKAGE)
    return folder


def colcon(workspace: Path, generator: str, *options: str, fails: bool = False) -> str:
    env = {**environment(workspace), "COLCON_HOME": str(workspace / "home"), "PYTHONPATH": str(workspace / "site")}
    env["PATH"] = f"{workspace / 'bin'}:{Path(COLCON).parent}:/usr/bin:/bin"
    words = [COLCON, "build", "--event-handlers", "console_cohesion+", *options, "--cmake-args", "-G", generator]
    done = subprocess.run(
        words, cwd=workspace, env=env, text=True, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, check=False
    )
    assert bool(done.returncode) == fails, done.stdout
    return done.stdout


def next_second() -> None:
    """Wait for the next second: CMake installs files with the time of their source, to the second.

    Files get their time from a clock that is some milliseconds late, hence the tenth of a second.
    """
    time.sleep(1.1 - time.time() % 1)


def share(workspace: Path, package: str) -> Path:
    return workspace / "install" / package / "share" / package


@pytest.mark.tier("builds")
def test_a_workspace_is_built_once_and_what_is_touched_again(workspace: Path) -> None:
    """At a landing: with links, of which ``test_a_workspace`` has none, and those packages that the cell needs."""
    words = ("--symlink-install", "--packages-up-to", "cell_description")
    assert ran(colcon(workspace, MAKE, *words)) == OF_ARM
    urdf = share(workspace, "arm_description") / "urdf/arm.urdf"
    mesh = share(workspace, "arm_description") / "mjcf/meshes/arm_description/meshes/arm.stl"
    assert urdf.is_symlink()
    assert mesh.is_symlink()
    for file in ("urdf/arm.urdf", "mjcf/arm.xml", "mjcf/meshes/arm_description/meshes/arm.stl"):
        committed = workspace / "src/arm_description/outputs/arm" / file
        assert (share(workspace, "arm_description") / file).read_bytes() == committed.read_bytes()
    assert '"left_tool"' in (share(workspace, "cell_description") / "urdf/arm.urdf").read_text()
    touch(workspace / "src/arm_description/descriptions/arm/tool.yaml")
    assert ran(colcon(workspace, MAKE, *words)) == OF_ARM
    assert ran(colcon(workspace, MAKE, *words)) == []


@BUILDS
@pytest.mark.parametrize("generator", [MAKE, NINJA])
def test_a_workspace(workspace: Path, generator: str) -> None:
    arm = workspace / "src/arm_description/descriptions/arm"
    assert ran(colcon(workspace, generator)) == ALL
    assert ran(colcon(workspace, generator)) == []
    for file in ("urdf/arm.urdf", "mjcf/arm.xml", "mjcf/meshes/arm_description/meshes/arm.stl"):
        committed = workspace / "src/arm_description/outputs/arm" / file
        assert (share(workspace, "arm_description") / file).read_bytes() == committed.read_bytes()
    assert 'size="0.5 0.3 0.1"' in (share(workspace, "cart_description") / "urdf/cart.urdf").read_text()
    assert '"left_tool"' in (share(workspace, "cell_description") / "urdf/arm.urdf").read_text()
    cell = share(workspace, "cell_description") / "urdf/cell.urdf"
    assert 'name="arm_tool"' in cell.read_text()

    next_second()
    touch(arm / "tool.yaml")
    assert ran(colcon(workspace, generator)) == OF_ARM  # all is equal, and newer
    assert ran(colcon(workspace, generator)) == []

    next_second()
    edit(arm / "lower.yaml", "reach: 30 cm", "reach: 35 cm")
    assert "1 package failed" in colcon(workspace, generator, fails=True)  # the committed artifacts are those of before
    env = {**os.environ, "ROSORIN_COMPILE_CACHE": str(workspace / "cache")}
    subprocess.run([PROGRAM, "all", "arm"], cwd=workspace / "src/arm_description", env=env, check=True)
    assert set(ran(colcon(workspace, generator))) >= {"bench", "cell", "golden arm", "left_arm"}
    assert 'xyz="0 0 0.35"' in cell.read_text()
    assert 'xyz="0 0 0.35"' in (share(workspace, "cell_description") / "bench.urdf").read_text()
    assert ran(colcon(workspace, generator)) == []

    edit(workspace / "src/cart_description/descriptions/cart/robot.yaml", "30 cm", "31 cm")
    assert ran(colcon(workspace, generator)) == ["cart"]


@BUILDS
@pytest.mark.parametrize("generator", [NINJA])
def test_an_include_of_a_package_that_others_compile(workspace: Path, generator: str) -> None:
    arm = workspace / "src/arm_description/descriptions/arm"
    colcon(workspace, generator)
    next_second()
    (arm / "more.yaml").write_text('links: {"${prefix}more": {}}\n')
    joint = '"${prefix}more_joint": {type: fixed, parent: "${prefix}arm", child: "${prefix}more"}'
    edit(arm / "tool.yaml", "joints:\n", f"include: [more.yaml]\njoints:\n  {joint}\n")
    env = {**os.environ, "ROSORIN_COMPILE_CACHE": str(workspace / "cache")}
    subprocess.run([PROGRAM, "all", "arm"], cwd=workspace / "src/arm_description", env=env, check=True)
    assert ran(colcon(workspace, generator)) == OF_ARM
    assert ran(colcon(workspace, generator)) == []
    next_second()
    touch(arm / "more.yaml")
    assert ran(colcon(workspace, generator)) == OF_ARM
    touch(arm / "notes.txt.jinja")  # of an output that the others do not compile
    assert ran(colcon(workspace, generator)) == ["golden arm"]
    assert ran(colcon(workspace, generator)) == []


@BUILDS
@pytest.mark.parametrize("generator", [NINJA])
def test_a_clean_rebuild(workspace: Path, generator: str) -> None:
    colcon(workspace, generator)
    urdf = share(workspace, "arm_description") / "urdf/arm.urdf"
    before = urdf.read_bytes()
    assert ran(colcon(workspace, generator, "--cmake-clean-first", "--parallel-workers", "4")) == ALL
    shutil.rmtree(workspace / "build")
    shutil.rmtree(workspace / "install")
    assert ran(colcon(workspace, generator, "--packages-up-to", "cell_description")) == OF_ARM
    assert urdf.read_bytes() == before


@pytest.mark.tier("builds")
def test_the_program_is_not_installed(workspace: Path) -> None:
    (workspace / "bin" / "rosorin-compile").unlink()
    said = colcon(workspace, GENERATORS[0], "--packages-up-to", "cart_description", fails=True)
    message = "is not on PATH. Install it: pip install path/to/rosorin-compile (a clone of it, or a wheel) or say"
    assert f"The program rosorin-compile {message}" in plainly(said)


def test_the_program_is_too_old(workspace: Path) -> None:
    program = workspace / "bin" / "rosorin-compile"
    program.unlink()
    program.write_text("#!/bin/sh\necho 'there is no command cmake-dir' >&2\nexit 2\n")
    program.chmod(0o755)
    said = plainly(colcon(workspace, GENERATORS[0], "--packages-up-to", "cart_description", fails=True))
    assert "cmake-dir fails (2); is it an older one?" in said
    assert "there is no command cmake-dir" in said
