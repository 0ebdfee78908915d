"""Macros of vendors called from a description: xacro itself expands the same calls, and yourdfpy reads both robots.

``data/macros`` has reductions of the packages of four vendors, a cell that calls their macros from YAML, and a xacro
that makes the same calls.
"""

import json
import re
import shutil
import sys
import xml.etree.ElementTree as ET
from pathlib import Path
from types import ModuleType

import pytest
from jsonschema import Draft7Validator

from rosorin_compile.cli.main import main
from rosorin_compile.formats.compilation import compile_robot
from rosorin_compile.source.diagnostics import ERROR, WARNING
from support.commands import write_files
from support.paths import DATA
from support.robots import compiled, texts
from support.round_trip import yourdfpy

MACROS = DATA / "macros"
CELL = MACROS / "descriptions/cell/robot.yaml"
NAMESPACE = 'xmlns:xacro="http://www.ros.org/wiki/xacro"'


@pytest.fixture(autouse=True)
def packages(monkeypatch):
    monkeypatch.setenv("ROS_PACKAGE_PATH", str(MACROS / "ros"))
    monkeypatch.setenv("ROSORIN_COMPILE_TRUST", "1")


def expanded(path: Path, monkeypatch: pytest.MonkeyPatch) -> str:
    """Return what xacro makes of a file whose packages are those of the vendors."""
    import xacro

    ament, packages = ModuleType("ament_index_python"), ModuleType("ament_index_python.packages")
    packages.get_package_share_directory = lambda name: str(MACROS / "ros" / name)  # type: ignore[attr-defined]
    monkeypatch.setitem(sys.modules, "ament_index_python", ament)
    monkeypatch.setitem(sys.modules, "ament_index_python.packages", packages)
    return xacro.process_file(str(path)).toxml()


def test_the_macros_of_four_vendors_make_what_xacro_makes_of_the_same_calls(tmp_path, monkeypatch):
    theirs, ours = tmp_path / "theirs.urdf", tmp_path / "ours.urdf"
    theirs.write_text(expanded(MACROS / "cell.urdf.xacro", monkeypatch), "utf-8")
    text = CELL.read_text("utf-8")
    text = re.sub(
        r"(?s)  - file: \S+_d435.urdf.xacro\n    macro: sensor_d435\n    with: {name: wrist.*?(?=links:)", "", text
    )
    write_files(tmp_path, {"descriptions/cell/robot.yaml": re.sub("sensors: .*\n", "", text)})
    ours.write_text(texts(compiled(tmp_path / "descriptions/cell/robot.yaml"))["cell.urdf"], "utf-8")
    assert yourdfpy(theirs, ours)[0] == []
    assert main(["diff", str(theirs), str(ours)]) == 0


def test_mujoco_loads_the_cell_and_frames_of_a_macro_carry_sensors(tmp_path, monkeypatch):
    mujoco = pytest.importorskip("mujoco")
    shutil.copytree(MACROS, tmp_path, dirs_exist_ok=True)
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("ROS_PACKAGE_PATH", str(tmp_path / "ros"))
    assert main(["all", "cell"]) == 0
    model = mujoco.MjModel.from_xml_path("outputs/cell/cell.xml")
    names = {model.joint(index).name for index in range(model.njnt)}
    assert {"left_elbow_joint", "right_elbow_joint", "robotiq_85_right_knuckle_joint", "gen3_joint_2"} <= names
    robot = compiled(CELL).robot
    assert robot is not None
    assert robot.joint["beam_joint"].parent == "front_color_frame"
    assert robot.joint["cell_wrist_joint"].parent == "right_tool0"


def test_all_files_that_xacro_reads_are_inputs_and_no_artifact_names_a_folder_of_this_machine():
    made = compiled(CELL)
    names = {path.name for path in made.inputs}
    assert {"ur_macro.xacro", "ur_common.xacro", "joint_limits.yaml", "visual_parameters.yaml"} <= names
    assert {"_d435.urdf.xacro", "_materials.urdf.xacro", "gen3_macro.xacro", "2f_85.ros2_control.xacro"} <= names
    assert not any(str(MACROS) in artifact.text for artifact in made.artifacts)


def test_editors_know_the_macros_and_their_parameters(monkeypatch, capsys):
    monkeypatch.chdir(MACROS)
    monkeypatch.setattr("rosorin_compile.formats.compilation.read_robot", None)  # xacro is not run
    assert main(["schema", "--macros"]) == 0
    schema = json.loads(capsys.readouterr().out)
    checker = Draft7Validator(schema)
    file = "package://realsense2_description/urdf/_d435.urdf.xacro"
    for entry, is_valid in (
        ({"macro": "sensor_d435", "with": {"name": "a", "origin": "<origin/>"}}, True),
        ({"macro": "usb_plug", "with": {"name": "a"}}, True),  # of a file that it includes
        ({"macro": "sensor_d455"}, False),
        ({"macro": "sensor_d435", "with": {"nam": "a"}}, False),
    ):
        assert checker.is_valid({"robot": "r", "include": [{"file": file, **entry}]}) == is_valid
    keys = [
        one["then"]["properties"]["with"]["properties"]
        for one in schema["properties"]["include"]["items"]["allOf"]
        if one["if"]["properties"].get("macro") == {"const": "ur_robot"}
    ]
    assert keys[0]["name"] == {"description": "Required."}
    assert keys[0]["robot_ip"] == {"description": "Default: 0.0.0.0"}
    assert "dict(shoulder_pan_joint=0.0,elbow_joint=0.0)" in keys[0]["initial_positions"]["description"]


def test_a_schema_with_macros_is_of_the_same_version(tmp_path, monkeypatch, capsys):
    shutil.copytree(MACROS, tmp_path, dirs_exist_ok=True)
    monkeypatch.chdir(tmp_path)
    assert main(["init", "first"]) == 0
    capsys.readouterr()
    assert main(["schema", "--macros"]) == 0
    schema = Path("descriptions/.schema/rosorin-compile.schema.json")
    schema.write_text(capsys.readouterr().out, "utf-8")
    for name, is_older in (("second", False), ("third", True)):
        assert main(["init", name]) == 0
        assert ("is of another version" in capsys.readouterr().out) == is_older
        schema.write_text(schema.read_text("utf-8").replace("draft-07", "draft-06"), "utf-8")


def robot(folder: Path, macro: str, entry: str) -> tuple[dict[str, str], list[str]]:
    """Return the artifacts of a robot that calls a macro, and the rules of its errors and warnings."""
    write_files(folder, {
        "v.xacro": f"<robot {NAMESPACE}>{macro}</robot>",
        "robot.yaml": f"robot: r\ninclude:\n  - {{file: v.xacro, macro: m, {entry}}}\nlinks: {{base: {{}}}}\n"
        "outputs: {urdf: {file: r.urdf}}\n",
    })  # fmt: skip
    made = compile_robot(folder / "robot.yaml")
    return texts(made), [one.rule for one in made.diagnostics if one.severity in (ERROR, WARNING)]


JOINT = '<joint name="j" type="fixed"><parent link="{}"/><child link="l"/>{}</joint>'
LINK = '<link name="l"/>'


@pytest.mark.parametrize(
    ("params", "body", "entry", "pose"),
    [
        # A macro that only defines links is attached as an included robot is.
        ("", LINK, "parent: base, xyz: [1, 0, 0]", "1 0 0"),
        # One that names its parent otherwise, or takes its pose as texts.
        ("connected_to:='' xyz:='0 0 0' rpy:='0 0 0'",
         LINK + JOINT.format("${connected_to}", '<origin xyz="${xyz}" rpy="${rpy}"/>'),
         "parent: base, xyz: [2, 0, 0], rpy: [0, 0, 0]", "2 0 0"),
        ("parent_link xyz rpy", LINK + JOINT.format("${parent_link}", '<origin xyz="${xyz}" rpy="${rpy}"/>'),
         "parent: base", "0 0 0"),
        # One whose parent is a link of the description without a parameter.
        ("*origin", LINK + JOINT.format("base", '<xacro:insert_block name="origin"/>'), "xyz: [3, 0, 0]", "3 0 0"),
        ("parent **inner", LINK + JOINT.format("${parent}", '<xacro:insert_block name="inner"/>'),
         "parent: base, with: {inner: '<origin xyz=\"4 0 0\"/>'}", "4 0 0"),
        ("parent **inner", LINK + JOINT.format("${parent}", '<xacro:insert_block name="inner"/>'),
         "parent: base, with: {inner: '<inner><origin xyz=\"4 0 0\"/></inner>'}", "4 0 0"),
        ("parent x:=^|5", LINK + JOINT.format("${parent}", '<origin xyz="${x} 0 0"/>'), "parent: base", "5 0 0"),
        # As xacro.load_yaml makes it, with attributes.
        ("parent at", LINK + JOINT.format("${parent}", '<origin xyz="${at[1].x} 0 0"/>'),
         "parent: base, with: {at: [1, {x: 600 cm}]}", "6 0 0"),
    ],
)  # fmt: skip
def test_forms_of_parameters(tmp_path, params, body, entry, pose):
    files, rules = robot(tmp_path, f'<xacro:macro name="m" params="{params}">{body}</xacro:macro>', entry)
    assert rules == []
    (joint,) = ET.fromstring(files["r.urdf"]).findall("joint")
    assert (joint.find("parent").get("link"), joint.find("child").get("link")) == ("base", "l")
    assert joint.find("origin").get("xyz") == pose


def test_arguments_of_the_file_are_args(tmp_path):
    body = LINK + JOINT.format("${parent}", '<origin xyz="$(arg x) 0 0"/>')
    macro = f'<xacro:arg name="x" default="1"/><xacro:macro name="m" params="parent">{body}</xacro:macro>'
    files, rules = robot(tmp_path, macro, "parent: base, args: {x: 7}")
    assert rules == []
    assert 'xyz="7 0 0"' in files["r.urdf"]


def test_a_robot_that_the_file_makes_itself_is_left_out(tmp_path):
    """Its materials stay; of two definitions of a macro, xacro takes the one of the condition."""
    macro = f'<xacro:macro name="m" params="x parent y">{LINK}{JOINT.format("${parent}", "")}</xacro:macro>'
    macro = f'<xacro:if value="0">{macro}</xacro:if><xacro:if value="1">{macro.replace(" y", " z:=1")}</xacro:if>'
    outside = '<link name="k"/><gazebo reference="k"/><material name="red"><color rgba="1 0 0 1"/></material>'
    files, rules = robot(tmp_path, macro + outside, "parent: base, with: {x: 1}")
    assert rules == []
    urdf = ET.fromstring(files["r.urdf"])
    assert [(one.tag, one.get("name")) for one in urdf] == [
        ("material", "red"), ("link", "base"), ("link", "l"), ("joint", "j"),
    ]  # fmt: skip


def test_values_of_a_description_are_not_run_by_xacro(tmp_path):
    """The trust in the file of a vendor is none in the description that calls its macro."""
    body = LINK + '<gazebo reference="l"><a>${text} ${list[0]} ${list[1]}</a></gazebo>'
    entry = """with: {text: "${'$'}{1+1} ${'$'}(arg x)", list: ["${'$'}{1+1}", "'}"]}, parent: base"""
    files, _ = robot(tmp_path, f'<xacro:macro name="m" params="text list">{body}</xacro:macro>', entry)
    assert "<a>${1+1} $(arg x) ${1+1} '}</a>" in files["r.urdf"]


def test_the_publisher_of_an_include_is_that_of_the_joint_on_its_parent(tmp_path):
    macro = f'<xacro:macro name="m" params="parent">{LINK}{JOINT.format("${parent}", "")}</xacro:macro>'
    robot(tmp_path, macro, "parent: base, publisher: {none: calibrated}")
    made = compile_robot(tmp_path / "robot.yaml")
    assert made.robot is not None
    assert made.robot.joint["j"].publisher.about == "calibrated"


def test_the_root_of_a_file_of_macros_may_have_any_name(tmp_path):
    """Vendors write <root> where xacro takes the content alone."""
    write_files(tmp_path, {
        "v.xacro": f'<root {NAMESPACE}><xacro:macro name="m" params="">{LINK}</xacro:macro></root>',
        "robot.yaml": "robot: r\ninclude: [{file: v.xacro, macro: m}]\n",
    })  # fmt: skip
    made = compile_robot(tmp_path / "robot.yaml")
    assert made.robot is not None
    assert [link.name for link in made.robot.links] == ["l"]


def test_the_error_for_a_file_of_macros_names_the_call(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    file = MACROS / "ros/realsense2_description/urdf/_d435.urdf.xacro"
    assert main(["import", str(file)]) == 1
    message = capsys.readouterr().err
    assert "error[no-links]" in message
    assert "include: [{file: _d435.urdf.xacro, macro: sensor_d435, parent: LINK}]" in message
