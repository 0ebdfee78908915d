"""extract factory: all numbers of a package that is like those that makers of robots deliver."""

import json
import shutil
from pathlib import Path

import pytest
import yaml

from rosorin_compile.cli.main import main
from rosorin_compile.formats.compilation import compile_robot
from rosorin_compile.source.diagnostics import text as report
from support.paths import DATA

pytestmark = pytest.mark.slow

FACTORY = DATA / "factory_package"
MAP = ["--heightmap-link", "base_link", "--frame", "base_footprint", "--cell", "1cm"]
JOINTS = ["base_joint", "lidar_joint", "joint1", "joint2", "gripper_joint", "camera_joint"]

Said = pytest.CaptureFixture[str]


@pytest.fixture
def package(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    for name in ("ROS_PACKAGE_PATH", "AMENT_PREFIX_PATH"):
        monkeypatch.delenv(name, raising=False)
    shutil.copytree(FACTORY, tmp_path / "nano")
    return Path("nano")


def read(file: str) -> dict:
    return yaml.safe_load(Path(file).read_text("utf-8"))


def test_everything_that_is_there_is_taken_and_what_is_missing_is_listed(package: Path, capsys: Said) -> None:
    assert main(["extract", "factory", str(package), "-o", "numbers", *MAP]) == 0
    said = capsys.readouterr()
    assert said.out.splitlines() == [
        f"joints (6): {', '.join(JOINTS)}",
        "boxes (5): camera_link, gripper_link, lidar_frame, link1, link2",
        "height map in base_footprint: 24 x 16 cells of 10 mm from x -0.12, y -0.08; "
        "384 of 384 have a height, 0.085 to 0.205 m",
        "written: numbers/boxes.yaml, numbers/heightmap.yaml, numbers/joints.yaml",
    ]
    first, *_ = said.err.splitlines()
    assert first.startswith("nano/urdf/nano.urdf.xacro:2:2: warning[xacro-runs-code]:")
    assert [line for line in said.err.splitlines() if "mesh-missing" in line] == [
        "nano/urdf/arm.urdf.xacro:21:35: warning[mesh-missing]: "
        "visual of link2: there is no file package://nano_description/meshes/cover.stl"
    ]


def test_a_turntable_of_several_turns_compiles(package: Path) -> None:
    """What is more than a full turn says that it is radians, as the rules ask of it."""
    arm = package / "urdf" / "arm.urdf.xacro"
    arm.write_text(arm.read_text("utf-8").replace('lower="-2.09" upper="2.09"', 'lower="-7" upper="7.00"'), "utf-8")
    assert main(["extract", "factory", str(package), "-o", "numbers"]) == 0
    assert "limit: {lower: -7 rad, upper: 7.00 rad, " in Path("numbers/joints.yaml").read_text("utf-8")
    Path("numbers/robot.yaml").write_text("robot: nano\ninclude: [joints.yaml, boxes.yaml]\n", "utf-8")
    made = compile_robot(Path("numbers/robot.yaml"))
    assert made.robot is not None, report(made.diagnostics)


def test_the_numbers_are_those_of_the_package_and_compile(package: Path) -> None:
    assert main(["extract", "factory", str(package), "-o", "numbers", *MAP]) == 0
    text = Path("numbers/joints.yaml").read_text()
    assert list(read("numbers/joints.yaml")["joints"]) == JOINTS
    assert "    axis: [-5.4513e-05, -0.0087266, -0.99996]\n" in text
    assert "limit: {lower: -2.09, upper: 2.09, effort: 1000, velocity: 10}\n" in text
    links = read("numbers/boxes.yaml")["links"]
    boxes = {name: link["collision"][0]["box"] for name, link in links.items() if link}
    assert boxes == {
        "camera_link": {"min": [-0.02, -0.03, -0.01], "max": [0, 0.03, 0.01]},
        "gripper_link": {"min": [-0.003, -0.0319, -0.04235], "max": [0.04798, 0.02372, 0.01099]},
        "lidar_frame": {"min": [-0.03, -0.03, 0], "max": [0.03, 0.03, 0.04]},
        "link1": {"min": [-0.02398, -0.02395, -0.00371], "max": [0.02398, 0.02399, 0.03955]},
        "link2": {"min": [-0.01398, -0.03852, -0.00875], "max": [0.01414, 0.00189, 0.09534]},
    }
    (entry,) = read("numbers/heightmap.yaml")["links"]["base_footprint"]["collision"]
    heights = entry["height_map"]["heights"]
    assert (len(heights), len(heights[0])) == (24, 16)
    for i, row in enumerate(heights):
        for j, height in enumerate(row):
            wanted = 0.085  # the deck: 60 mm above base_link, which is 25 mm above the floor
            if i < 5 and 3 <= j < 13:
                wanted = 0.205
            if 18 <= i < 23 and 4 <= j < 12:
                wanted = 0.125 - 0.008 * (i - 18)  # highest at the rear of each cell
            assert height == pytest.approx(wanted, abs=1e-9), (i, j)
    assert entry["source"] == {"status": "calculated", "note": "top of base_link.stl"}
    top = "robot: nano\ninclude: [joints.yaml, boxes.yaml, heightmap.yaml]\n"
    top += "outputs: {urdf: {file: nano.urdf}, robot_model: {file: robot_model.json}}\n"
    Path("numbers/robot.yaml").write_text(top)
    compiled = compile_robot(Path("numbers/robot.yaml"))
    assert compiled.robot is not None, report(compiled.diagnostics)
    (model,) = (json.loads(artifact.text) for artifact in compiled.artifacts if artifact.file.endswith(".json"))
    assert (list(model["joints"]), sorted(model["boxes"])) == (JOINTS, sorted(boxes))
    assert model["chassis_heightmap"]["frame"] == "base_footprint"


def test_link_of_the_height_map_without_a_mesh(package: Path, capsys: Said) -> None:
    (package / "meshes" / "base_link.stl").unlink()
    assert main(["extract", "factory", str(package), "-o", "numbers", *MAP]) == 1
    said = capsys.readouterr()
    assert "error[height-map-empty]: base_link has no mesh that can be read: no height map" in said.err
    assert "nano/urdf/nano.urdf.xacro:16:25: warning[mesh-missing]: visual of base_link: there is no file" in said.err
    assert "written: numbers/boxes.yaml, numbers/joints.yaml" in said.out


def test_broken_mesh_is_a_warning_where_it_is_named(package: Path, capsys: Said) -> None:
    (package / "meshes" / "gripper_link.glb").write_bytes(b"glTF")
    assert main(["extract", "factory", str(package), "-o", "numbers"]) == 0
    said = capsys.readouterr()
    assert (
        "nano/urdf/common.xacro:7:35: warning[mesh-unreadable]: nano/meshes/gripper_link.glb is not a mesh" in said.err
    )
    assert 'nano/urdf/nano.urdf.xacro:25:6: when expanding the macro "mounted"' in said.err
    assert "boxes (5): base_link, camera_link, lidar_frame, link1, link2" in said.out


URDF = """<?xml version="1.0"?>
<robot name="plain">
  <link name="base">
    <collision><geometry><mesh filename="{address}"/></geometry></collision>
    <visual><geometry><mesh filename="nowhere.stl"/></geometry></visual>
  </link>
</robot>
"""


@pytest.mark.parametrize("address", ["file://{here}/nano/meshes/link1.obj", "../meshes/link1.obj"])
def test_plain_urdf_and_other_addresses(package: Path, capsys: Said, address: str) -> None:
    for path in (package / "urdf").iterdir():
        path.unlink()
    (package / "urdf" / "plain.urdf").write_text(URDF.format(address=address.format(here=Path.cwd())))
    assert main(["extract", "factory", str(package), "-o", "numbers"]) == 0
    said = capsys.readouterr()
    assert said.out.splitlines()[:2] == ["joints (0): none", "boxes (1): base"]
    assert said.err == ""
    assert main(["extract", "factory", str(package), "-o", "numbers", "--from", "visual"]) == 0
    assert "nano/urdf/plain.urdf:5:39: warning[mesh-missing]: visual of base: there is no file nowhere.stl" in (
        capsys.readouterr().err
    )


def test_several_robots(package: Path, capsys: Said) -> None:
    (package / "urdf" / "plain.urdf").write_text(URDF.format(address="../meshes/link1.obj"))
    assert main(["extract", "factory", str(package), "-o", "numbers"]) == 1
    said = capsys.readouterr().err
    assert said.splitlines() == [
        "error[factory-robot]: nano has 2 files of robots: urdf/nano.urdf.xacro, urdf/plain.urdf",
        "    select one with --robot FILE",
    ]
    assert not Path("numbers").exists()
    assert main(["extract", "factory", str(package), "-o", "numbers", "--robot", "urdf/plain.urdf"]) == 0
    assert main(["extract", "factory", str(package), "-o", "numbers", "--robot", "urdf/plane.urdf"]) == 2
    assert capsys.readouterr().err.endswith(
        'rosorin-compile: nano has no file "urdf/plane.urdf"; did you mean "urdf/plain.urdf"?\n'
    )


CHOOSING = """<robot xmlns:xacro="http://www.ros.org/wiki/xacro"NAME>
  <xacro:arg name="tracks" default="false"/>
  <xacro:property name="machine" value="$(env MACHINE_TYPE)"/>
  <xacro:if value="${machine == 'mecanum'}"><xacro:include filename="MECANUM"/></xacro:if>
  <xacro:if value="${machine == 'acker' and not $(arg tracks)}"><xacro:include filename="acker.xacro"/></xacro:if>
</robot>
"""


@pytest.mark.parametrize(
    ("name", "mecanum"), [("", "mecanum.xacro"), (' name="any"', "$(find nano_description)/urdf/${machine}.xacro")]
)
def test_a_file_that_chooses_the_robot_is_named(package: Path, capsys: Said, name: str, mecanum: str) -> None:
    (package / "urdf" / "entry.xacro").write_text(CHOOSING.replace("NAME", name).replace("MECANUM", mecanum))
    for robot in ("mecanum", "acker", "spare"):
        (package / "urdf" / f"{robot}.xacro").write_text(f'<robot name="{robot}"><link name="base"/></robot>')
    assert main(["extract", "factory", str(package), "-o", "numbers"]) == 1
    chooses = "chooses by the environment variable MACHINE_TYPE (mecanum, acker) and the argument tracks"
    assert f"urdf/entry.xacro {chooses}" in capsys.readouterr().err
    assert main(["extract", "factory", str(package), "-o", "numbers", "--robot", "urdf/entry.xacro"]) == 1
    assert f"urdf/entry.xacro {chooses}" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("words", "code", "message"),
    [
        (["nothing"], 2, "rosorin-compile: nothing is not a folder; name the folder of a description package"),
        (["nano/meshes"], 1, "error[factory-robot]: nano/meshes has no file of a robot"),
        (
            ["nano", "--heightmap-link", "base_lnk"],
            2,
            'rosorin-compile: the robot has no link "base_lnk"; did you mean',
        ),
    ],
)
def test_what_cannot_be(package: Path, capsys: Said, words: list[str], code: int, message: str) -> None:
    assert package.is_dir()
    assert main(["extract", "factory", *words, "-o", "numbers"]) == code
    assert message in capsys.readouterr().err
    assert not Path("numbers").exists()


def test_what_joints_have_all_the_same_is_accepted(package: Path, capsys: Said) -> None:
    """An axis that is not of unit length and an inertia that cannot be: the first is that of a joint, and stays."""
    arm = package / "urdf" / "arm.urdf.xacro"
    inertial = '<inertial><mass value="0"/><inertia ixx="0" ixy="0" ixz="0" iyy="0" iyz="0" izz="0"/></inertial>'
    text = arm.read_text().replace('<axis xyz="0 0.99996 -0.0087265"/>', '<axis xyz="0 2 0"/>')
    arm.write_text(text.replace('<link name="link2">', f'<link name="link2">{inertial}'))
    assert main(["extract", "factory", str(package), "-o", "numbers", *MAP]) == 0
    assert "mass-not-positive" not in capsys.readouterr().err
    joints = read("numbers/joints.yaml")
    assert joints["joints"]["joint2"]["axis"] == [0, 2, 0]
    assert [(entry["rule"], entry["of"]) for entry in joints["accept"]] == [("axis-not-unit", ["joint2"])]
    Path("numbers/robot.yaml").write_text("robot: n\ninclude: [joints.yaml, boxes.yaml, heightmap.yaml]\n")
    compiled = compile_robot(Path("numbers/robot.yaml"))
    assert compiled.robot is not None
    assert not [d for d in compiled.diagnostics if d.severity == "warning"]
