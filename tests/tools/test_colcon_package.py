"""The repository as a ROS package: package.xml, and a colcon workspace that contains a clone."""

import re
import shutil
import subprocess
from pathlib import Path

import pytest
from catkin_pkg.package import Package, parse_package_string

from support.cmake import GENERATORS, WORKSPACE, environment
from support.colcon import AMENT_CMAKE, AMENT_PACKAGE, COLCON
from support.commands import edit
from support.paths import OUTPUTS, ROOT
from support.snapshot import network, snapshot

# What rosdep calls packages of PyPI: https://github.com/ros/rosdistro/blob/master/rosdep/python.yaml
ROSDEP = {
    "click": "python3-click",
    "jinja2": "python3-jinja2",
    "jsonschema": "python3-jsonschema",
    "pyyaml": "python3-yaml",
}


def requirements() -> set[str]:
    (line,) = re.findall(r"^dependencies = \[(.*)\]$", (ROOT / "pyproject.toml").read_text("utf-8"), re.MULTILINE)
    return set(re.findall(r'"([\w-]+)', line))


def manifest() -> Package:
    warnings: list[str] = []
    package = parse_package_string((ROOT / "package.xml").read_text("utf-8"), warnings=warnings)
    package.validate()
    assert warnings == []
    return package


def test_package_xml_has_the_requirements_as_rosdep_keys() -> None:
    package = manifest()
    assert (package.package_format, package.name, package.licenses) == (3, "rosorin_compile", ["Apache-2.0"])
    assert [export.content for export in package.exports if export.tagname == "build_type"] == ["ament_python"]
    assert {ROSDEP[name] for name in requirements()} <= {depend.name for depend in package.exec_depends}


@pytest.fixture
def workspace(tmp_path: Path) -> Path:
    """A workspace with a clone of the repository, and the requirements for the Python of colcon in ``site``."""
    if not COLCON:
        pytest.skip("colcon is not here: pip install colcon-common-extensions")
    network()
    folder = tmp_path / "a workspace"
    snapshot(folder / "src" / "rosorin-compile")
    pip = [Path(COLCON).with_name("python"), "-m", "pip", "install", "--quiet", "--target", folder / "site"]
    subprocess.run([*pip, *requirements()], check=True)
    if AMENT_PACKAGE.is_dir():  # ament_cmake runs it with the same Python
        (folder / "site" / "ament_package").symlink_to(AMENT_PACKAGE)
    return folder


def run(workspace: Path, *words: str | Path) -> str:
    setup = workspace / "install" / "local_setup.sh"
    env = {**environment(workspace), "COLCON_HOME": str(workspace / "home"), "PYTHONPATH": str(workspace / "site")}
    env["PATH"] = f"{Path(COLCON).parent}:/usr/bin:/bin"
    script = f'[ ! -e "{setup}" ] || . "{setup}"; exec "$@"'
    done = subprocess.run(
        ["bash", "-c", script, "-", *words],
        cwd=workspace,
        env=env,
        text=True,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        check=False,
    )
    assert done.returncode == 0, done.stdout
    return done.stdout


@pytest.mark.tier("builds")
@pytest.mark.slow
@pytest.mark.parametrize("options", [(), ("--symlink-install",)], ids=["copies", "links"])
def test_colcon_builds_the_tool(workspace: Path, options: tuple[str, ...]) -> None:
    assert run(workspace, COLCON, "list", "--names-only") == "rosorin_compile\n"
    printed = run(workspace, COLCON, "build", "--event-handlers", "console_cohesion+", *options)
    assert "1 package finished" in printed
    assert "doesn't explicitly install" not in printed  # the marker and package.xml, which colcon adds with a warning
    installed = workspace / "install" / "rosorin_compile"
    assert (installed / "share/ament_index/resource_index/packages/rosorin_compile").is_file()
    assert (installed / "share/rosorin_compile/package.xml").is_file()
    assert run(workspace, "which", "rosorin-compile") == f"{installed}/bin/rosorin-compile\n"

    shutil.copytree(ROOT / "descriptions", workspace / "descriptions")
    run(workspace, "rosorin-compile", "all", "rosorin")
    made = {path.name: path.read_bytes() for path in (workspace / "outputs/rosorin").iterdir() if path.is_file()}
    assert made == {path.name: path.read_bytes() for path in OUTPUTS.iterdir() if path.is_file()}
    clone = workspace / "src" / "rosorin-compile"
    assert subprocess.check_output(["git", "status", "--porcelain"], cwd=clone, text=True) == ""


@pytest.mark.tier("builds")
@pytest.mark.slow
@pytest.mark.skipif(not AMENT_CMAKE.is_file() or not GENERATORS, reason="no ament-cmake")
def test_a_package_compiles_its_robot_with_the_tool_of_the_workspace(workspace: Path) -> None:
    """As docs/builds.md describes: a link to the CMake package in the clone, and a build dependency on the tool."""
    source = workspace / "src"
    (source / "rosorin_compile_cmake").symlink_to("rosorin-compile/ament/rosorin_compile_cmake")
    cart = shutil.copytree(WORKSPACE / "src" / "cart_description", source / "cart_description")
    line = "<build_depend>rosorin_compile_cmake</build_depend>"
    edit(cart / "package.xml", line, f"{line}<build_depend>rosorin_compile</build_depend>")
    assert "3 packages finished" in run(workspace, COLCON, "build")
    urdf = workspace / "install/cart_description/share/cart_description/urdf/cart.urdf"
    assert 'size="0.5 0.3 0.1"' in urdf.read_text("utf-8")
