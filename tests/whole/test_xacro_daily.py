"""Call xacro and the compiler in the same way, as docs/from-xacro.md compares them, for the same robot.

The package is that of the page.
"""

import re
import shlex
import shutil
import sys
import xml.etree.ElementTree as ElementTree
from itertools import product
from pathlib import Path
from types import ModuleType

import pytest

from support.pages import blocks, edit
from support.round_trip import differences
from support.xacro_life import PAGE, CommandFailed, Machine, package

pytest.importorskip("xacro")
pytestmark = pytest.mark.slow  # each call is a process


@pytest.fixture
def machine(tmp_path: Path) -> Machine:
    return Machine(tmp_path)


@pytest.fixture
def rover(machine: Machine) -> Path:
    """Return the source folder of the package of the page; it is installed, and found by AMENT_PREFIX_PATH."""
    folder = package(machine.folder / "src" / "rover_description")
    machine.install(folder)
    return folder


XACRO = "urdf/rover.urdf.xacro"
YAML = "descriptions/rover/robot.yaml"


def same(theirs: str, ours: str) -> None:
    assert differences(theirs.encode(), ours.encode(), tolerance=1e-12, any_axes=True) == []
    assert "<link " in ours


def quoted(path: Path) -> str:
    return shlex.quote(str(path))


@pytest.mark.landing("outside", "true-false")
@pytest.mark.parametrize(("lidar", "sim"), list(product(("true", "false"), repeat=2)))
def test_the_package_of_the_page_is_the_same_robot(machine: Machine, rover: Path, lidar: str, sim: str) -> None:
    words = [f"lidar:={lidar}", f"sim:={sim}"]
    theirs = machine.run("xacro", str(rover / XACRO), *words)
    ours = machine.run("rosorin-compile", "print", str(rover / YAML), "urdf", *words)
    assert (theirs.returncode, ours.returncode) == (0, 0), theirs.stderr + ours.stderr
    same(theirs.stdout, ours.stdout)
    assert ("laser" in ours.stdout) == (lidar == "true")
    assert ("gz_ros2_control" in ours.stdout) == (sim == "true")


def test_a_xacro_is_printed_as_it_is(machine: Machine, rover: Path) -> None:
    theirs = machine.command("xacro ", quoted(rover / XACRO), " lidar:=false")
    ours = machine.command("rosorin-compile print --trust ", quoted(rover / XACRO), " urdf", " lidar:=false")
    same(theirs, ours)


def test_command_in_a_launch_file(machine: Machine, rover: Path) -> None:
    spaced = rover.parent.parent / "a folder" / "rover description"
    shutil.copytree(rover, spaced)
    for folder in (rover, spaced):
        theirs = machine.command("xacro ", quoted(folder / XACRO))
        ours = machine.command("rosorin-compile print ", quoted(folder / YAML), " urdf")
        same(theirs, ours)
        assert ours.endswith("</robot>\n")
    (rover / YAML).write_text((rover / YAML).read_text("utf-8").replace("left_wheel", "lef_wheel"), "utf-8")
    (rover / "urdf/wheel.xacro").unlink()
    (rover / "descriptions/rover/wheel.yaml").unlink()
    with pytest.raises(CommandFailed, match=r"exit code 2"):
        machine.command("xacro ", quoted(rover / XACRO))
    with pytest.raises(CommandFailed, match=r"exit code 1: .*robot.yaml:8:\d+: error\[file-unreadable\]"):
        machine.command("rosorin-compile print ", quoted(rover / YAML), " urdf")


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


def labelled(folder: Path) -> tuple[Path, Path]:
    (folder / "labelled.xacro").write_text(LABELLED, "utf-8")
    (folder / "robot.yaml").write_text(LABELLED_HERE, "utf-8")
    return folder / "labelled.xacro", folder / "robot.yaml"


def label(urdf: str) -> str | None:
    element = ElementTree.fromstring(urdf).find("gazebo")
    assert element is not None
    return element.text


@pytest.mark.landing("outside", 'say "here"', "007", "a;b|c*d?~$HOME")
@pytest.mark.parametrize("value", VALUES)
def test_arguments_from_a_launch_file(machine: Machine, value: str) -> None:
    theirs, ours = labelled(machine.folder)
    words = f" {shlex.quote(f'label:={value}')} height:=0.25"
    there = machine.command("xacro ", quoted(theirs), words)
    here = machine.command("rosorin-compile print ", quoted(ours), " urdf", words)
    same(there, here)
    assert label(here) == value


def test_an_argument_that_is_empty(machine: Machine) -> None:
    theirs, ours = labelled(machine.folder)
    same(
        machine.command("xacro ", quoted(theirs), " height:="),
        machine.command("rosorin-compile print ", quoted(ours), " urdf", " height:="),
    )
    assert label(machine.command("xacro ", quoted(theirs), " label:=")) == "none"
    assert label(machine.command("rosorin-compile print ", quoted(ours), " urdf", " label:=")) is None


def test_find_with_ros(machine: Machine, rover: Path) -> None:
    """The package is found by the prefix alone: its files stand somewhere else, and nothing there names it."""
    elsewhere = machine.folder / "elsewhere"
    elsewhere.mkdir()
    for name in (XACRO, YAML):
        (elsewhere / Path(name).name).write_text((rover / name).read_text("utf-8"), "utf-8")
    for name in ("materials", "wheel", "control"):
        shutil.copy(rover / f"descriptions/rover/{name}.yaml", elsewhere)
    same(
        machine.command("xacro ", quoted(elsewhere / "rover.urdf.xacro")),
        machine.command("rosorin-compile print ", quoted(elsewhere / "robot.yaml"), " urdf"),
    )
    machine.environment["AMENT_PREFIX_PATH"] = ""
    for call in ("xacro rover.urdf.xacro", "rosorin-compile print robot.yaml urdf"):
        ran = machine.shell(f"cd elsewhere && {call}")
        assert ran.returncode != 0
        assert "rover_description" in ran.stderr


def test_find_without_ros(machine: Machine, rover: Path) -> None:
    theirs = machine.command("xacro ", quoted(rover / XACRO))
    machine.environment["AMENT_PREFIX_PATH"] = ""
    shutil.rmtree(machine.folder / "python" / "ament_index_python")
    assert machine.run("xacro", str(rover / XACRO)).returncode == 2
    same(theirs, machine.command("rosorin-compile print ", quoted(rover / YAML), " urdf"))
    moved = rover.rename(machine.folder / "unpacked")
    (moved / "package.xml").unlink()
    option = f" --package rover_description={moved}"
    same(theirs, machine.command("rosorin-compile print ", quoted(moved / YAML), " urdf", option))


@pytest.mark.usefixtures("rover")
def test_one_macro_file_for_robots_of_two_packages(machine: Machine) -> None:
    """A second package includes the wheel of the first."""
    other = machine.folder / "src" / "tug_description"
    (other / "descriptions/tug").mkdir(parents=True)
    (other / "package.xml").write_text('<package format="3"><name>tug_description</name></package>', "utf-8")
    (other / "tug.xacro").write_text(
        '<robot name="tug" xmlns:xacro="http://www.ros.org/wiki/xacro">\n'
        '<xacro:include filename="$(find rover_description)/urdf/materials.xacro"/>\n'
        '<xacro:include filename="$(find rover_description)/urdf/wheel.xacro"/>\n'
        '<xacro:property name="size" value="${xacro.dotify(dict(radius=0.2, width=0.05, mass=1))}"/>\n'
        '<link name="frame"/><xacro:wheel prefix="front_" parent="frame" y="0.3" size="${size}"/></robot>\n',
        "utf-8",
    )
    (other / "descriptions/tug/robot.yaml").write_text(
        "robot: tug\n"
        "include:\n"
        "  - package://rover_description/descriptions/rover/materials.yaml\n"
        "  - package://rover_description/descriptions/rover/wheel.yaml\n"
        "let: {size: {radius: 20 cm, width: 5 cm, mass: 1 kg}}\n"
        "links: {frame: {}}\n"
        'use: {front: {part: wheel, parent: frame, xyz: [0, 0.3, 0], with: {size: "${size}"}}}\n'
        "outputs: {urdf: {file: tug.urdf}}\n",
        "utf-8",
    )
    theirs = machine.command("xacro ", quoted(other / "tug.xacro"))
    same(theirs, machine.command("rosorin-compile print ", quoted(other / "descriptions/tug"), " urdf"))


@pytest.mark.skipif(shutil.which("check_urdf") is None, reason="liburdfdom-tools")
def test_check_urdf_from_a_pipe(machine: Machine, rover: Path) -> None:
    theirs = machine.shell(f"xacro {quoted(rover / XACRO)} | check_urdf /dev/stdin")
    ours = machine.shell(f"rosorin-compile print {quoted(rover / YAML)} urdf | check_urdf /dev/stdin")
    assert (theirs.returncode, ours.returncode) == (0, 0), theirs.stderr + ours.stderr
    assert tree(ours.stdout) == tree(theirs.stdout)
    assert len(tree(ours.stdout)) == 5


def tree(said: str) -> list[str]:
    return sorted(re.sub(r"\(\d+\)", "", line) for line in said.splitlines() if "child" in line or "root Link" in line)


def test_the_launch_file_of_the_page(machine: Machine, rover: Path) -> None:
    """Before and after its change it hands the same robot to robot_state_publisher, with the argument of the launch."""
    path = rover / "launch/rover.launch.py"
    before = launched(machine, path, lidar="false")
    change(rover)
    after = launched(machine, path, lidar="false")
    assert (before[0], after[0]) == ("xacro", "rosorin-compile")
    same(before[1], after[1])
    assert "laser" not in after[1]
    assert "laser" in launched(machine, path, lidar="true")[1]


def launched(machine: Machine, path: Path, **given: str) -> tuple[str, str]:
    """Return the program that the Command of a launch file calls, and the robot_description that comes of it.

    The file is run with stand-ins for what it uses of launch; a share folder is where ament's index has it.
    """
    share = machine.folder / "install/rover_description/share/rover_description"
    words: list[str] = []

    def command(pieces: list[str]) -> str:
        words.extend(shlex.split("".join(pieces)))
        return machine.command(*pieces)

    def node(package: str, executable: str, parameters: list[dict[str, str]]) -> str:
        assert (package, executable) == ("robot_state_publisher", "robot_state_publisher")
        return parameters[0]["robot_description"]

    def typed(value: str, value_type: type) -> str:
        assert value_type is str
        return value

    stand_ins: dict[str, dict[str, object]] = {
        "launch": {"LaunchDescription": list},
        "launch.actions": {"DeclareLaunchArgument": lambda name, default_value: (name, default_value)},
        "launch.substitutions": {
            "Command": command,
            "LaunchConfiguration": given.__getitem__,
            "PathJoinSubstitution": "/".join,
        },
        "launch_ros": {},
        "launch_ros.actions": {"Node": node},
        "launch_ros.parameter_descriptions": {"ParameterValue": typed},
        "launch_ros.substitutions": {"FindPackageShare": {"rover_description": str(share)}.__getitem__},
    }
    with pytest.MonkeyPatch.context() as patch:
        for name, what in stand_ins.items():
            module = ModuleType(name)
            module.__dict__.update(what)
            patch.setitem(sys.modules, name, module)
        scope: dict[str, object] = {}
        exec(compile(path.read_text("utf-8"), str(path), "exec"), scope)  # noqa: S102 - the page's
        *_, described = scope["generate_launch_description"]()  # type: ignore[operator]
    return words[0], described


def change(folder: Path) -> None:
    for block in blocks(PAGE.read_text("utf-8")):
        if block.mark[0] == "edit":
            edit(folder / block.mark[1], block.lines)
