"""Call xacro and the compiler in the same way, as docs/from-xacro.md compares them, for the same robot.

The package is that of the page.
"""

import os
import shlex
import shutil
import subprocess
import sys
import xml.etree.ElementTree as ElementTree
from itertools import product
from pathlib import Path

import pytest

from support.commands import write_files
from support.pages import blocks
from support.paths import DOCS
from support.round_trip import differences

pytest.importorskip("xacro")
pytestmark = pytest.mark.slow  # each call is a process

PAGE = DOCS / "from-xacro.md"
XACRO = f"{shlex.quote(sys.executable)} -c 'import xacro; xacro.main()' "
OURS = f"{shlex.quote(sys.executable)} -m rosorin_compile print "
# What ament_index_python does, by AMENT_PREFIX_PATH (ament/ament_index, packages.py).
AMENT = """\
import os
class PackageNotFoundError(KeyError): pass
def get_package_share_directory(name):
    for prefix in os.environ.get("AMENT_PREFIX_PATH", "").split(os.pathsep):
        if prefix and os.path.isfile(f"{prefix}/share/ament_index/resource_index/packages/{name}"):
            return f"{prefix}/share/{name}"
    raise PackageNotFoundError(name)
"""


class CommandFailed(Exception):
    """The SubstitutionFailure of launch."""


def command(*pieces: str | Path) -> str:
    """Return what launch's Command returns: the pieces joined, split by shlex, run without a shell.

    By default (``on_stderr='fail'``) anything on standard error is a failure, as an exit code is.
    Sources: ros2/launch, launch/substitutions/command.py, on Humble and Jazzy.
    """
    line = "".join(shlex.quote(str(piece)) if isinstance(piece, Path) else piece for piece in pieces)
    ran = subprocess.run(shlex.split(line), check=False, capture_output=True, text=True)
    if ran.returncode != 0 or ran.stderr:
        raise CommandFailed(f"exit code {ran.returncode}: {ran.stderr}")
    return ran.stdout


@pytest.fixture
def rover(home: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The source folder of the package of the page, before its launch file changes; AMENT_PREFIX_PATH leads to it."""
    folder, share = home / "src" / "rover_description", home / "install" / "share"
    marked = [block for block in blocks(PAGE.read_text("utf-8")) if block.mark[0] == "file"]
    write_files(folder, {block.mark[1]: "\n".join(block.lines) + "\n" for block in marked})
    write_files(share, {"ament_index/resource_index/packages/rover_description": ""})
    (share / "rover_description").symlink_to(folder, target_is_directory=True)
    files = {"ament_index_python/__init__.py": "", "ament_index_python/packages.py": AMENT}
    write_files(home / "python", files)
    monkeypatch.setenv("PYTHONPATH", os.pathsep.join([str(home / "python"), *sys.path]))
    monkeypatch.setenv("AMENT_PREFIX_PATH", str(home / "install"))
    monkeypatch.setenv("ROS_PACKAGE_PATH", "")
    return folder


def same(theirs: str, ours: str) -> None:
    assert differences(theirs.encode(), ours.encode(), tolerance=1e-12, any_axes=True) == []
    assert ours.endswith("</robot>\n")


MAIN = "urdf/rover.urdf.xacro"
YAML = "descriptions/rover/robot.yaml"


@pytest.mark.landing("outside", "true-false")
@pytest.mark.parametrize(("lidar", "sim"), list(product(("true", "false"), repeat=2)))
def test_the_package_of_the_page_is_the_same_robot(rover: Path, lidar: str, sim: str) -> None:
    words = f" lidar:={lidar} sim:={sim}"
    theirs, ours = command(XACRO, rover / MAIN, words), command(OURS, rover / YAML, " urdf", words)
    same(theirs, ours)
    assert ("laser" in ours) == (lidar == "true")
    assert ("gz_ros2_control" in ours) == (sim == "true")
    same(theirs, command(OURS, "--trust ", rover / MAIN, " urdf", words))


def test_command_in_a_launch_file(home: Path, rover: Path) -> None:
    spaced = shutil.copytree(rover, home / "a folder" / "rover description")
    same(command(XACRO, spaced / MAIN), command(OURS, spaced / YAML, " urdf"))
    (rover / "urdf/wheel.xacro").unlink()
    (rover / "descriptions/rover/wheel.yaml").unlink()
    with pytest.raises(CommandFailed, match=r"exit code 2"):
        command(XACRO, rover / MAIN)
    with pytest.raises(CommandFailed, match=r"exit code 1: .*robot.yaml:8:\d+: error\[file-unreadable\]"):
        command(OURS, rover / YAML, " urdf")


LABELLED = """\
<robot name="labelled" xmlns:xacro="http://www.ros.org/wiki/xacro">
  <xacro:arg name="label" default="none"/><xacro:arg name="height" default="0.5"/>
  <link name="base"><visual><geometry><sphere radius="$(arg height)"/></geometry></visual></link>
  <gazebo>$(arg label)</gazebo>
</robot>
"""
LABELLED_HERE = """\
robot: labelled
args: {label: {type: text, default: none}, height: {type: length, default: 0.5}}
links: {base: {visual: [{sphere: {radius: "${height}"}}]}}
urdf_elements: ["<gazebo>${label}</gazebo>"]
outputs: {urdf: {file: labelled.urdf}}
"""
VALUES = ["front scan", "it's", 'say "here"', "a=b", "back\\slash", "ünï", "007", "true", "1e3", "a;b|c*d?~$HOME"]
VALUES += ["--flag"]


@pytest.mark.landing("outside", 'say "here"', "007", "a;b|c*d?~$HOME")
@pytest.mark.parametrize("value", VALUES)
def test_arguments_from_a_launch_file(home: Path, value: str) -> None:
    write_files(home, {"labelled.xacro": LABELLED, "robot.yaml": LABELLED_HERE})
    words = f" {shlex.quote(f'label:={value}')} height:=0.25"
    ours = command(OURS, "robot.yaml urdf", words)
    same(command(XACRO, "labelled.xacro", words), ours)
    assert ElementTree.fromstring(ours).findtext("gazebo") == value
    same(command(XACRO, "labelled.xacro height:="), command(OURS, "robot.yaml urdf height:="))


def test_find_with_ros_and_without(home: Path, rover: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The package is found by the prefix alone: its files are elsewhere, and nothing there names it."""
    elsewhere = home / "elsewhere"
    elsewhere.mkdir()
    for name in (MAIN, YAML, *(f"descriptions/rover/{name}.yaml" for name in ("materials", "wheel", "control"))):
        shutil.copy(rover / name, elsewhere)
    theirs = command(XACRO, elsewhere / "rover.urdf.xacro")
    same(theirs, command(OURS, elsewhere / "robot.yaml", " urdf"))
    monkeypatch.setenv("AMENT_PREFIX_PATH", "")
    for line in ((XACRO, elsewhere / "rover.urdf.xacro"), (OURS, elsewhere / "robot.yaml", " urdf")):
        with pytest.raises(CommandFailed, match="rover_description"):
            command(*line)
    shutil.rmtree(home / "python" / "ament_index_python")
    same(theirs, command(OURS, rover / YAML, " urdf"))
    moved = rover.rename(home / "unpacked")
    (moved / "package.xml").unlink()
    same(theirs, command(OURS, moved / YAML, f" urdf --package rover_description={moved}"))
