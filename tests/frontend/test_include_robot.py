"""Another one's robot, included as it is: pinocchio, MuJoCo and xacro themselves say where its frames have to be."""

from __future__ import annotations

import hashlib
import json
import re
import shutil
import xml.etree.ElementTree as ET
from collections.abc import Mapping
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rosorin_compile.cli.main import main
from rosorin_compile.formats.compiled import compile_robot
from rosorin_compile.language.expand.included_robots import prefixed
from rosorin_compile.source.diagnostics import ERROR, WARNING, Source
from rosorin_compile.source.load import parse_yaml
from rosorin_compile.source.system import pip_install
from rosorin_compile.source.tree import Instance
from support.commands import write_files
from support.engines import pose
from support.paths import DATA
from support.robots import compiled, texts
from support.unrounded import compile_unrounded

pytestmark = pytest.mark.slow

CASES = DATA / "include_robot"
CELL, PACKAGED, SIMULATED = (CASES / "descriptions" / name for name in ("cell", "packaged", "simulated"))
ARM = CELL / "vendor" / "arm.urdf"
STATES = 50
SIDES = {"left": 1, "right": -1}


def frames(urdf: str, positions: Mapping[str, float]) -> dict[str, np.ndarray]:
    """Return the 4x4 pose of every link in the root of a URDF, by pinocchio; continuous joints have cos and sin."""
    import pinocchio as pin

    model = pin.buildModelFromXML(urdf, mimic=True)
    data, q = model.createData(), pin.neutral(model)
    for name, value in positions.items():
        joint = model.joints[model.getJointId(name)]
        q[joint.idx_q : joint.idx_q + joint.nq] = (np.cos(value), np.sin(value)) if joint.nq == 2 else value
    pin.framesForwardKinematics(model, data, q)
    return {f.name: data.oMf[i].homogeneous for i, f in enumerate(model.frames) if f.type == pin.FrameType.BODY}


@pytest.mark.parametrize("gap", [0.8, 1.3])
def test_two_arms_and_a_camera_stand_where_pinocchio_has_the_arm(gap):
    urdf = texts(compiled(CELL / "robot.yaml", {"gap": str(gap)}))["cell.urdf"]
    foreign = ARM.read_text("utf-8")
    random = np.random.default_rng(4)
    largest = 0.0
    for _ in range(STATES):
        states = {side: dict(zip(("shoulder", "elbow"), random.uniform(-2, 2, 2), strict=True)) for side in SIDES}
        found = frames(urdf, {f"{side}_{name}": at for side in SIDES for name, at in states[side].items()})
        for side, sign in SIDES.items():
            mount = pose([0.1, sign * gap / 2, 0.72], [0, 0, sign * np.radians(30)])
            arm = frames(foreign, states[side])
            assert len(arm) == 5
            for link, placed in arm.items():
                largest = max(largest, np.abs(found[f"{side}_{link}"] - mount @ placed).max())
            if side == "left":
                camera = mount @ arm["tool0"] @ pose([0, 0, 0.04], [0, 0, 0])
                largest = max(largest, np.abs(found["camera"] - camera).max())
    assert largest < 1e-9


def test_what_the_arm_has_is_there_twice_with_its_prefix():
    urdf = ET.fromstring(texts(compiled(CELL / "robot.yaml"))["cell.urdf"])
    foreign = ET.parse(ARM).getroot()
    for side in SIDES:
        for tag in ("link", "joint", "material", "transmission", "ros2_control"):
            wanted = [f"{side}_{element.get('name')}" for element in foreign.findall(tag)]
            assert wanted
            assert set(wanted) <= {element.get("name") for element in urdf.findall(tag)}
    assert len(urdf.findall("link")) == 2 * 5 + 3  # two arms, the table, the camera and its optical frame
    looks = urdf.find("link[@name='left_upper']/visual/material")
    assert looks is not None
    assert looks.get("name") == "left_grey"
    mimic = urdf.find("joint[@name='right_slide']/mimic")
    assert mimic is not None
    assert mimic.get("joint") == "right_shoulder"


def test_kept_elements_name_the_new_links_and_joints_and_nothing_else_changes():
    kept = (
        texts(compiled(CELL / "robot.yaml"))["cell.urdf"]
        .partition("<transmission")[2]
        .partition('<transmission name="right')[0]
    )
    told = ARM.read_text("utf-8").partition("<transmission")[2].rpartition("</robot>")[0]
    new = ["left_drive", "left_shoulder", "left_motor", "left_arm_hardware", "left_elbow", "left_wrench"]
    new += ["left_tool0", "left_tool0"]
    assert re.findall(r"left_\w+", kept) == new
    assert kept.replace("left_", "").split() == told.split()
    for same in ("<topicName>tool0</topicName>", 'filename="tool0"', 'plugin name="upper"', "fore::collision"):
        assert same in kept


def test_a_xacro_in_a_package_is_expanded_with_arguments(tmp_path):
    """As xacro itself expands it; its folder is found by its name, its values are SI numbers."""
    import xacro

    files = texts(compiled(PACKAGED / "robot.yaml"))
    argument = {"reach": "0.8"}
    macro = (CASES / "ros/arm_description/urdf/arm_macro.xacro").read_text("utf-8")
    (tmp_path / "arm_macro.xacro").write_text(macro, "utf-8")
    text = (CASES / "ros/arm_description/urdf/arm.urdf.xacro").read_text("utf-8")
    (tmp_path / "arm.xacro").write_text(text.replace("$(find arm_description)/urdf/", ""), "utf-8")
    expanded = xacro.process_file(str(tmp_path / "arm.xacro"), mappings=argument).toxml()
    for height in (0.0, 0.2, 0.45):
        alone = frames(expanded, {"lift": height})
        found = frames(files["packaged.urdf"], {"a_lift": height})
        assert np.abs(found["a_tool0"] - alone["tool0"]).max() < 1e-12
    assert "'--child-frame-id', [frame_prefix, 'a_base']" in files["static_tf.launch.py"]
    assert "${not_mine}" in files["packaged.urdf"]  # what stands in another one's file is no expression of ours


def test_what_a_xacro_runs_is_said_before_and_all_its_files_are_known():
    said = []
    made = compile_robot(PACKAGED / "robot.yaml", None, said.append)
    assert [d.rule for d in said] == ["xacro-runs-code"]
    assert [r.message for r in said[0].related] == ["included here", "included here"]
    assert not any(d.rule == "xacro-runs-code" for d in made.diagnostics)
    names = {path.name for path in made.inputs}
    assert names == {"robot.yaml", "arm.yaml", "arm.urdf.xacro", "arm_macro.xacro"}


def test_the_package_is_found_by_the_environment_of_ros(tmp_path, monkeypatch):
    (tmp_path / "robot.yaml").write_text(
        "robot: r\ninclude: [{file: urdf/arm.urdf.xacro, package: arm_description}]\noutputs: {urdf: {file: r.urdf}}\n"
    )
    monkeypatch.delenv("AMENT_PREFIX_PATH", raising=False)
    monkeypatch.setenv("ROS_PACKAGE_PATH", str(CASES / "ros"))
    by_path = texts(compiled(tmp_path / "robot.yaml"))
    share = tmp_path / "prefix" / "share"
    share.mkdir(parents=True)
    shutil.copytree(CASES / "ros/arm_description", share / "arm_description")
    monkeypatch.delenv("ROS_PACKAGE_PATH")
    monkeypatch.setenv("AMENT_PREFIX_PATH", str(tmp_path / "prefix"))
    assert texts(compiled(tmp_path / "robot.yaml")) == by_path


def test_legs_of_an_mjcf_move_as_mujoco_moves_the_leg():
    import mujoco

    whole = mujoco.MjModel.from_xml_string(texts(compiled(SIMULATED / "robot.yaml"))["robot.xml"])
    leg = mujoco.MjModel.from_xml_path(str(SIMULATED / "leg.xml"))
    random = np.random.default_rng(1)
    for _ in range(STATES):
        states = {side: random.uniform([-1, -2], [1, 0]) for side in SIDES}
        found = _moved(whole, {f"{s}_{n}": q for s in SIDES for n, q in zip(("swing", "knee"), states[s], strict=True)})
        for side, sign in SIDES.items():
            alone = _moved(leg, dict(zip(("swing", "knee"), states[side], strict=True)))
            mount = pose([0, 0.1 * sign, 0.5], [0, 0, 0]) @ np.linalg.inv(alone["hip"])
            for body, placed in alone.items():
                assert np.abs(found[f"{side}_{body}"] - mount @ placed).max() < 1e-9
    keys = {whole.key(index).name: whole.key(index).qpos.tolist() for index in range(whole.nkey)}
    assert keys == {"home": [0] * 4, "left_kneel": [0.5, -1.5, 0, 0], "right_kneel": [0, 0, 0.5, -1.5]}
    names = [whole.body(index).name for index in range(whole.nbody)]
    excluded = {(names[pair >> 16], names[pair & 0xFFFF]) for pair in whole.exclude_signature}
    assert {("left_hip", "left_shank"), ("right_hip", "right_shank")} <= excluded


def _moved(model, positions):
    import mujoco

    data = mujoco.MjData(model)
    for name, value in positions.items():
        data.joint(name).qpos[0] = value
    mujoco.mj_kinematics(model, data)
    found = {}
    for index in range(1, model.nbody):
        made = np.eye(4)
        made[:3, 3], made[:3, :3] = data.xpos[index], data.xmat[index].reshape(3, 3)
        found[model.body(index).name] = made
    return found


FOUR_LINES = """\
robot: my_arm
include: [arm.urdf]
sensors: {camera: {type: camera, parent: tool0, frame: camera, xyz: [0, 0, 4 cm]}}
outputs: {urdf: {file: my_arm.urdf}}
"""


def test_a_camera_on_a_bought_arm_needs_four_lines(tmp_path):
    assert len(FOUR_LINES.splitlines()) == 4
    (tmp_path / "robot.yaml").write_text(FOUR_LINES, "utf-8")
    shutil.copy(ARM, tmp_path)
    urdf = texts(compiled(tmp_path / "robot.yaml"))["my_arm.urdf"]
    positions = {"shoulder": 0.7, "elbow": -1.1}
    before, after = frames(ARM.read_text("utf-8"), positions), frames(urdf, positions)
    assert after.keys() - before.keys() == {"camera", "camera_optical"}
    assert max(np.abs(after[link] - before[link]).max() for link in before) < 1e-12
    assert np.abs(after["camera"] - before["tool0"] @ pose([0, 0, 0.04], [0, 0, 0])).max() < 1e-9
    assert (tmp_path / "arm.urdf").read_bytes() == ARM.read_bytes()


@pytest.mark.parametrize("ending", ["urdf", "URDF", "xml"])
def test_the_ending_says_that_it_is_a_robot_and_the_content_which_kind(tmp_path, ending):
    (tmp_path / "robot.yaml").write_text(FOUR_LINES.replace("arm.urdf", f"arm.{ending}", 1), "utf-8")
    shutil.copy(ARM, tmp_path / f"arm.{ending}")
    assert 'name="camera"' in texts(compiled(tmp_path / "robot.yaml"))["my_arm.urdf"]


def test_an_include_may_have_a_condition(tmp_path):
    shutil.copytree(CELL, tmp_path, dirs_exist_ok=True)
    text = (CELL / "robot.yaml").read_text("utf-8")
    text = text.replace("    prefix:", '    if: ${side == "left" or gap > 1}\n    prefix:')
    (tmp_path / "robot.yaml").write_text(text, "utf-8")
    one, two = (texts(compiled(tmp_path / "robot.yaml", {"gap": gap}))["cell.urdf"] for gap in ("0.9", "1.1"))
    assert "left_tool0" in one
    assert "right_tool0" not in one
    assert "right_tool0" in two


def test_a_description_refers_to_names_of_the_robot_everywhere(tmp_path):
    shutil.copytree(CELL, tmp_path, dirs_exist_ok=True)
    more = "poses:\n  up: {positions: {left_shoulder: 0.5}}\ndisabled_contacts:\n"
    more += "  - {links: [left_base, table], reason: they touch}\n"
    more += "use:\n  mark: {part: mark, parent: right_tool0}\nparts:\n  mark:\n    links: {tip: {}}\n"
    more += "    joints: {tip_joint: {type: fixed, parent: mount, child: tip}}\n"
    with (tmp_path / "robot.yaml").open("a") as file:
        file.write(more)
    made = compile_robot(tmp_path / "robot.yaml")
    assert [d for d in made.diagnostics if d.severity == ERROR] == []
    assert made.robot is not None
    assert [pose.name for pose in made.robot.poses] == ["up"]
    assert made.robot.joint["mark_tip_joint"].parent == "right_tool0"


def test_a_frame_of_the_world_with_a_prefix_is_none_any_more(tmp_path):
    """A robot that begins at map is accepted as it is; with a prefix there is nothing left to accept."""
    arm = ARM.read_text("utf-8").replace('"base"', '"map"')
    (tmp_path / "arm.urdf").write_text(arm, "utf-8")
    for entry in ("{file: arm.urdf, prefix: a_, parent: base_link}", "{file: arm.urdf, parent: base_link}"):
        text = f"robot: r\ninclude: [{entry}]\nlinks: {{base_link: {{}}}}\noutputs: {{urdf: {{file: r.urdf}}}}\n"
        (tmp_path / "robot.yaml").write_text(text, "utf-8")
        made = compile_robot(tmp_path / "robot.yaml")
        assert [d for d in made.diagnostics if d.severity in (ERROR, WARNING)] == []
        assert any(d.rule == "owns-world-frame" for d in made.diagnostics) == ("prefix" not in entry)


def test_lenient_takes_what_the_foreign_file_left_out(tmp_path):
    arm = ARM.read_text("utf-8").replace(' effort="40" velocity="2"', "")
    (tmp_path / "arm.urdf").write_text(arm, "utf-8")
    (tmp_path / "robot.yaml").write_text(FOUR_LINES, "utf-8")
    refused = [d for d in compile_robot(tmp_path / "robot.yaml").diagnostics if d.severity == ERROR]
    assert [d.rule for d in refused] == ["limit-incomplete"]
    assert "lenient: true takes it" in refused[0].help
    (tmp_path / "robot.yaml").write_text(FOUR_LINES.replace("[arm.urdf]", "[{file: arm.urdf, lenient: true}]"), "utf-8")
    assert "my_arm.urdf" in texts(compiled(tmp_path / "robot.yaml"))


XACRO = """\
<robot name="v" xmlns:xacro="http://www.ros.org/wiki/xacro">
  <xacro:arg name="size" default="b"/>
  <link name="$(arg size)"/>
</robot>
"""
NO_DEFAULT = XACRO.replace('  <xacro:arg name="size" default="b"/>', "")
LACKING = XACRO.replace("<link", '<xacro:include filename="$(find not_there_at_all)/more.xacro"/><link')


@pytest.mark.parametrize(
    ("args", "text", "rule", "line", "help"),
    [
        ("", NO_DEFAULT, "xacro-error", 3, "give it one: args: {size: VALUE}"),
        ("size: a", LACKING, "package-missing", 3, "say where it is: packages: {not_there_at_all: FOLDER}"),
        ("sise: a", XACRO, "unknown-argument", 1, 'did you mean "size"?'),
        ("size: a", "<robot>", "xml-syntax", 1, ""),
        ("size: a", XACRO.replace("robot", "svg"), "wrong-root", 1, "name the file of the robot"),
    ],
)
def test_mistakes_point_into_the_foreign_file_in_the_words_of_an_include(tmp_path, args, text, rule, line, help):
    (tmp_path / "v.xacro").write_text(text, "utf-8")
    (tmp_path / "robot.yaml").write_text(f"robot: r\ninclude: [{{file: v.xacro, args: {{{args}}}}}]\n", "utf-8")
    (found,) = [d for d in compile_robot(tmp_path / "robot.yaml").diagnostics if d.severity == ERROR]
    assert (found.rule, found.span.line, Path(found.span.source.path).name) == (rule, line, "v.xacro")
    assert help in found.help
    assert found.related[-1].message == "included here"
    assert found.related[-1].span.line == 2


def test_without_the_extra_the_message_says_what_to_install(monkeypatch):
    answer = {"absent": "xacro", "said": ""}
    monkeypatch.setattr("rosorin_compile.importing.xacro.expand._expand", lambda *_: answer)
    (found,) = [d for d in compile_robot(PACKAGED / "robot.yaml").diagnostics if d.severity == ERROR]
    assert found.rule == "extra-missing"
    assert found.help == pip_install("import")
    assert [r.message for r in found.related] == ["included here", "included here"]


@pytest.mark.parametrize("folder", [CELL, PACKAGED, SIMULATED], ids=lambda folder: folder.name)
def test_editors_know_the_include(folder):
    import yaml
    from jsonschema import Draft7Validator

    schema = json.loads((CASES.parents[2] / "schemas" / "authoring.schema.json").read_text("utf-8"))
    checker = Draft7Validator(schema)
    for path in folder.glob("*.yaml"):
        assert [error.message for error in checker.iter_errors(yaml.safe_load(path.read_text("utf-8")))] == []
    wrong = {"robot": "r", "include": [{"file": "arm.urdf", "prefx": "a_"}]}
    assert not checker.is_valid(wrong)


def test_explain_shows_the_file_and_line_of_the_foreign_robot(monkeypatch, capsys):
    monkeypatch.chdir(CASES)
    assert main(["explain", "cell", "right_upper"]) == 0
    said = capsys.readouterr().out
    line = 1 + ARM.read_text("utf-8").split('effort="40"')[0].count("\n")
    assert re.search(rf"limit effort +40 N\*m +descriptions/cell/vendor/arm.urdf:{line}:\d+ +40\n", said)
    assert "descriptions/cell/robot.yaml:6:5: included here" in said
    assert re.search(r"right_base_joint, fixed, published by .*\n +descriptions/cell/robot.yaml:9:13\n", said)


def test_trust_comes_from_the_person_who_runs_the_command(tmp_path, monkeypatch, capsys):
    monkeypatch.setenv("XDG_CONFIG_HOME", str(tmp_path / "config"))
    monkeypatch.chdir(tmp_path)
    text = '<robot name="post" xmlns:xacro="http://www.ros.org/wiki/xacro"><link name="post${1}"/></robot>'
    (tmp_path / "descriptions/cell").mkdir(parents=True)
    (tmp_path / "descriptions/cell/post.xacro").write_text(text, "utf-8")
    cell = tmp_path / "descriptions/cell/robot.yaml"
    cell.write_text(
        "robot: cell\ninclude:\n  - {file: post.xacro, trust: true}\noutputs: {urdf: {file: cell.urdf}}\n", "utf-8"
    )
    for command in ("all", "check"):
        assert main([command]) == 0
        said = capsys.readouterr().err
        assert "warning[xacro-runs-code]" in said
        assert "robot.yaml:3:31: warning[trust-ignored]" in said
    cell.write_text(cell.read_text("utf-8").replace(", trust: true", ""), "utf-8")
    assert main(["check", "--trust"]) == 0
    assert "xacro-runs-code" not in capsys.readouterr().err
    assert [one.rule for one in compile_robot(cell).diagnostics] == ["xacro-runs-code"]
    with monkeypatch.context() as trusting:
        trusting.setenv("ROSORIN_COMPILE_TRUST", "1")
        assert compile_robot(cell).diagnostics == []
    (tmp_path / "config/rosorin-compile").mkdir(parents=True)
    digest = hashlib.sha256(text.encode()).hexdigest()
    (tmp_path / "config/rosorin-compile/trusted").write_text(f"# my files\n{digest}  post.xacro\n", "utf-8")
    assert compile_robot(cell).diagnostics == []
    (tmp_path / "descriptions/cell/post.xacro").write_text(text + "<!-- changed -->", "utf-8")
    assert [one.rule for one in compile_robot(cell).diagnostics] == ["xacro-runs-code"]
    cell.write_text(cell.read_text("utf-8").replace("post.xacro", "post.xacro, trust: true"), "utf-8")
    cell.write_text(cell.read_text("utf-8").replace("true", "perhaps"), "utf-8")
    assert main(["all"]) == 1
    assert "include trust is true or false, not text" in capsys.readouterr().err


def test_all_check_and_the_stamp_know_the_foreign_file(tmp_path, monkeypatch, capsys):
    monkeypatch.setenv("ROSORIN_COMPILE_CACHE", str(tmp_path / "cache"))
    shutil.copytree(CASES, tmp_path, dirs_exist_ok=True)
    monkeypatch.chdir(tmp_path)
    assert main(["all", "packaged"]) == 0
    assert capsys.readouterr().err.count("xacro-runs-code") == 1
    assert main(["check", "packaged"]) == 0
    assert capsys.readouterr().err.count("xacro-runs-code") == 1
    assert main(["all", "packaged"]) == 0  # what code says may change without its files: it is run again, and said
    assert capsys.readouterr().err.count("xacro-runs-code") == 1
    macro = tmp_path / "ros/arm_description/urdf/arm_macro.xacro"
    macro.write_text(macro.read_text("utf-8").replace('upper="0.5"', 'upper="0.6"'), "utf-8")
    assert main(["check", "packaged"]) == 1
    assert main(["all", "packaged"]) == 0
    assert 'upper="0.6"' in (tmp_path / "outputs/packaged/packaged.urdf").read_text("utf-8")


def test_the_list_of_arguments_runs_nothing(monkeypatch, capsys):
    monkeypatch.chdir(CASES)
    monkeypatch.setattr("rosorin_compile.formats.reading.read_robot", None)
    assert main(["args", "cell"]) == 0
    assert "gap" in capsys.readouterr().out


def test_diff_says_that_a_xacro_is_run(monkeypatch, capsys):
    monkeypatch.chdir(CASES)
    assert main(["diff", "packaged", "packaged"]) == 0
    assert "xacro-runs-code" in capsys.readouterr().err


MESHED = """<robot name="v"><link name="a">
  <visual>
    <geometry><mesh filename="a/b.stl"/></geometry><material name="m"><texture filename="t.png"/></material>
  </visual>
  <collision><geometry><mesh filename="package://v/c.stl"/></geometry></collision>
  <collision><geometry><mesh filename="/opt/d.stl"/></geometry></collision>
  <collision><geometry><mesh filename="a/b.stl"/></geometry></collision>
</link></robot>"""


@pytest.mark.parametrize(
    ("before", "names"),
    [
        ("../vendor", ["../vendor/a/b.stl", "../vendor/t.png"]),
        ("package://v/", ["package://v/a/b.stl", "package://v/t.png"]),
    ],
)
def test_relative_meshes_get_the_folder_that_the_include_names(tmp_path, before, names):
    (tmp_path / "v.urdf").write_text(MESHED, "utf-8")
    text = f"robot: r\ninclude: [{{file: v.urdf, meshes: '{before}'}}]\noutputs: {{urdf: {{file: r.urdf}}}}\n"
    (tmp_path / "robot.yaml").write_text(text, "utf-8")
    made = compile_robot(tmp_path / "robot.yaml")
    assert [d for d in made.diagnostics if d.severity == WARNING] == []
    found = re.findall(r'filename="([^"]*)"', made.artifacts[0].text)
    assert found == [*names, "package://v/c.stl", "/opt/d.stl", names[0]]


def told(folder: Path) -> list[str]:
    return [f"{d.rule}: {d.message} ({d.help})" for d in compile_robot(folder / "robot.yaml").diagnostics]


@pytest.mark.parametrize("name", ["meshes/b.obj", "../meshes/b.obj", "package://arm/meshes/b.obj"])
def test_meshes_of_an_included_robot_are_found_from_its_file(home, capsys, name):
    solid = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n"
    place = "arm/urdf/meshes/b.obj" if name.startswith("meshes") else "arm/meshes/b.obj"
    geometry = f'<geometry><mesh filename="{name}"/></geometry>'
    robot = f'<robot name="v"><link name="v"><visual>{geometry}</visual></link></robot>'
    text = "robot: r\ninclude: [{file: ../../arm/urdf/v.urdf, prefix: left_}]\n"
    text += "outputs: {urdf: {file: r.urdf}, mjcf: {file: r.xml}}\n"
    write_files(home, {"arm/urdf/v.urdf": robot, place: solid, "descriptions/r/robot.yaml": text})
    assert main(["all"]) == 0
    said = capsys.readouterr().err
    assert "include-mesh-path" not in said
    assert "mesh-not-found" not in said
    assert (home / "outputs/r/meshes" / ("arm/meshes" if "://" in name else "") / "b.obj").is_file()
    assert str(home) not in (home / "outputs/r/r.urdf").read_text("utf-8")


def test_meshes_that_the_artifacts_do_not_find_are_told(tmp_path):
    (tmp_path / "v.urdf").write_text(MESHED, "utf-8")
    text = "robot: r\ninclude: [v.urdf]\noutputs: {urdf: {file: r.urdf}}\n"
    (tmp_path / "robot.yaml").write_text(text, "utf-8")
    assert told(tmp_path) == [
        "include-mesh-path: files of meshes or textures are named as seen from v.urdf, but readers look from the "
        "artifacts: a/b.stl and 1 more "
        "(say what to put before: meshes: FOLDER, as seen from the artifacts, or package://NAME)"
    ]


@pytest.mark.parametrize(
    ("entry", "message"),
    [
        (
            "file: v.urdf, prefix: 'a<'",
            'bad-name: no name can begin with "a<" (no markup, no quotes; spaces only within)',
        ),
        (
            "file: v.urdf, prefix: ' a'",
            'bad-name: no name can begin with " a" (no markup, no quotes; spaces only within)',
        ),
        ("package: v", "wrong-type: an include needs file, the name of a file (write include: [FILE.yaml])"),
        ("file: 3, package: v", "wrong-type: include file is text, not a number ()"),
    ],
)
def test_an_include_that_is_no_good_is_told_once(tmp_path, entry, message):
    (tmp_path / "v.urdf").write_text('<robot name="v"><link name="a"/><link name="b"/></robot>', "utf-8")
    (tmp_path / "robot.yaml").write_text(f"robot: r\ninclude: [{{{entry}}}]\n", "utf-8")
    assert told(tmp_path)[:1] == [message]
    assert sum("bad-name" in line for line in told(tmp_path)) <= 1


def test_a_folder_of_meshes_for_a_robot_without_any_is_told(tmp_path):
    (tmp_path / "v.urdf").write_text('<robot name="v"><link name="a"/></robot>', "utf-8")
    text = "robot: r\ninclude: [{file: v.urdf, meshes: m}]\noutputs: {urdf: {file: r.urdf}}\n"
    (tmp_path / "robot.yaml").write_text(text, "utf-8")
    assert told(tmp_path) == [
        "ignored-key: v.urdf names no mesh or texture by a relative path: nothing to put before (remove meshes)"
    ]


def test_an_included_mjcf_arm_keeps_its_meshes_in_mujoco(tmp_path):
    import mujoco

    folder = tmp_path / "descriptions" / "r"
    (folder / "assets").mkdir(parents=True)
    corners = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n"
    (folder / "assets" / "m.obj").write_text(corners, "utf-8")
    (folder / "arm.xml").write_text(
        '<mujoco><compiler meshdir="assets"/><asset><mesh name="m" file="m.obj"/></asset>'
        '<worldbody><body name="b"><geom type="mesh" mesh="m"/></body></worldbody></mujoco>',
        "utf-8",
    )
    include = "{file: arm.xml, parent: base, meshes: ../../descriptions/r}"
    text = f"robot: r\ninclude: [{include}]\nlinks: {{base: {{}}}}\noutputs: {{mjcf: {{file: r.xml}}}}\n"
    (folder / "robot.yaml").write_text(text, "utf-8")
    (artifact,) = compile_robot(folder / "robot.yaml").artifacts
    target = tmp_path / "outputs" / "r" / artifact.file
    target.parent.mkdir(parents=True)
    target.write_text(artifact.text, "utf-8")
    assert mujoco.MjModel.from_xml_path(str(target)).nmesh == 1


ELEMENT = st.sampled_from(["<a b='{0}'>{1}</a>", "<joint name='{0}'/>", "<t>\n {0} <!-- {1} --></t>", "<x>{0}<y/></x>"])
WORD = st.sampled_from(["tool0", "base", "tool", "xtool0", "lift", "&#116;ool0", "ö"])


@given(st.lists(st.tuples(ELEMENT, WORD, WORD), min_size=1, max_size=6))
def test_renaming_only_ever_puts_the_prefix_in(parts):
    """The elements stay what they are: without the prefix they are the same text, and only whole names have one."""
    text = "".join(form.format(one, other) for form, one, other in parts)
    names = {"tool0", "base", "lift"}
    tree = parse_yaml(
        Source("robot.yaml", json.dumps({"links": {name: {} for name in names}, "urdf_elements": [text]}))
    )
    (renamed,) = prefixed(tree, "PRE_", Instance("included", tree.span))[0]["urdf_elements"]
    assert renamed.replace("PRE_", "") == text
    assert set(re.findall(r"PRE_(\w+)", renamed)) <= names
    before, after = (ET.fromstring(f"<r>{t}</r>") for t in (text, renamed))
    for old, new in zip(before.iter(), after.iter(), strict=True):
        for key, value in old.attrib.items():
            plain = value in names and f"'{value}'" in text
            assert new.get(key) in ((f"PRE_{value}", value) if plain else (value,))


NAMES = st.lists(st.from_regex(r"[a-z][a-z0-9_]{0,6}", fullmatch=True), min_size=2, max_size=6, unique=True)
PREFIXES = st.from_regex(r"[a-z][a-z0-9_]{0,5}_", fullmatch=True)


@settings(max_examples=60, deadline=None)
@given(names=NAMES, prefix=PREFIXES, other=PREFIXES, xyz=st.tuples(*[st.floats(-3, 3)] * 3))
def test_any_chain_under_any_prefix_is_the_same_chain(tmp_path_factory, names, prefix, other, xyz):
    """With every name prefixed and the joint of the attachment taken away, the foreign file is there again."""
    folder = tmp_path_factory.mktemp("any")
    links = "".join(f'<link name="{name}"/>' for name in names)
    joints = "".join(
        f'<joint name="{child}" type="fixed"><origin xyz="{x} 0 0"/><parent link="{above}"/><child link="{child}"/>'
        f'</joint><gazebo reference="{child}"/>'
        for x, (above, child) in enumerate(pairwise(names))
    )
    (folder / "v.urdf").write_text(f'<robot name="v">{links}{joints}</robot>', "utf-8")
    entry = f"file: v.urdf, parent: BASE, joint: MOUNT, xyz: {list(xyz)}"
    both = f"[{{{entry}, prefix: A{prefix}}}, {{{entry.replace('MOUNT', 'MOUNT2')}, prefix: B{other}}}]"
    outputs = "outputs: {urdf: {file: r.urdf}}"
    (folder / "robot.yaml").write_text(f"robot: r\ninclude: {both}\nlinks: {{BASE: {{}}}}\n{outputs}\n", "utf-8")
    found = ET.fromstring(texts(compiled(folder / "robot.yaml", by=compile_unrounded))["r.urdf"])
    for before, joint in ((f"A{prefix}", "MOUNT"), (f"B{other}", "MOUNT2")):
        mount = found.find(f"joint[@name='{joint}']")
        assert mount.find("child").get("link") == before + names[0]
        assert tuple(map(float, mount.find("origin").get("xyz").split())) == xyz
        for x, (above, child) in enumerate(pairwise(names)):
            made = found.find(f"joint[@name='{before + child}']")
            assert (made.find("parent").get("link"), made.find("child").get("link")) == (before + above, before + child)
            assert float(made.find("origin").get("xyz").split()[0]) == x
            assert found.find(f"gazebo[@reference='{before + child}']") is not None
    assert len(found.findall("link")) == 1 + 2 * len(names)
