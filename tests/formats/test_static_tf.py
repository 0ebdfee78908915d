"""The launch file and its arguments as data: run with stand-ins for launch, read by the rules of the node."""

from __future__ import annotations

import ast
import json
import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import jsonschema
import pytest

from rosorin_compile.formats import static_tf
from rosorin_compile.formats.templating import Templates
from rosorin_compile.model import (
    ROBOT_STATE_PUBLISHER,
    STATIC_TRANSFORM_PUBLISHER,
    Joint,
    Limit,
    Link,
    Output,
    Pose,
    Publisher,
    Robot,
)
from rosorin_compile.model.link import Source
from support.launch import command_line, run
from support.packages import clean
from support.schemas import schema

SCHEMA = schema("static_tf")
OUTPUT = Output("static_tf", "static_tf", "static_tf.launch.py")
URDF = Output("urdf", "urdf", "robot.urdf")
LASER = Pose((0.048156, 7.5552e-05, 0.106748), (0.0, 0.0, math.pi))
TILTED = Pose((-0.027258, -5.6404e-05, 0.048046), (0.0, -0.0087266, 1.5707))
# What the schema of descriptions lets pass as a name, and more than one format might trip over.
ODD_NAMES = ["a|b", "x\\y", "weiß", "🤖", "{{x}}", "{%x%}", "$(x)", "#x", "coding:latin-1", "%s", "--x", "`a`", "\\"]


def static(name: str, parent: str, child: str, pose: Pose, node: str, **more: Any) -> Joint:
    return Joint(name, "fixed", parent, child, pose, publisher=Publisher(STATIC_TRANSFORM_PUBLISHER, node), **more)


def robot(*joints: Joint, outputs: tuple[Output, ...] = (URDF,), name: str = "tester") -> Robot:
    frames = dict.fromkeys(frame for joint in joints for frame in (joint.parent, joint.child))
    return Robot(name, tuple(map(Link, frames)) or (Link("base_link"),), joints, outputs=outputs)


TWO = robot(
    static("lidar_joint", "base_link", "laser", LASER, "tf_base_laser", source=Source("factory", "a\nnote", "2026")),
    static("imu_joint", "base_link", "imu_link", TILTED, "tf_base_imu"),
    Joint("arm_joint", "revolute", "base_link", "arm", limit=Limit(-1, 1, 1, 1)),
)


def launch(made: Robot, output: Output = OUTPUT) -> str:
    text, diagnostics = static_tf.write(made, output, Templates())
    assert diagnostics == []
    return text


def nodes_of(made: Robot) -> list[dict[str, Any]]:
    """Return the nodes that the list of arguments names."""
    document = json.loads(static_tf.write_list(made, OUTPUT, Templates())[0])
    jsonschema.validate(document, SCHEMA)
    return list(document["static_transform_publisher"])


def test_the_launch_file_starts_what_it_says(tmp_path: Path) -> None:
    urdf = '<?xml version="1.0"?>\n<!-- a: comment: that is no YAML -->\n<robot name="é"/>\n'
    (tmp_path / "robot.urdf").write_text(urdf, "utf-8")
    publisher, *nodes = run(launch(TWO), tmp_path / "static_tf.launch.py")
    assert (publisher.package, publisher.executable, publisher.name) == (ROBOT_STATE_PUBLISHER,) * 3
    assert publisher.parameters == {"robot_description": urdf, "frame_prefix": ""}
    assert [node.name for node in nodes] == ["tf_base_laser", "tf_base_imu"]
    assert {(node.package, node.executable) for node in nodes} == {("tf2_ros", "static_transform_publisher")}
    assert all(isinstance(argument, str) for node in nodes for argument in node.arguments)
    assert [(n.name, n.arguments) for n in nodes] == [(n["name"], n["arguments"]) for n in nodes_of(TWO)]


def test_the_urdf_is_found_in_the_same_set_or_where_the_argument_says(tmp_path: Path) -> None:
    for folder in ("urdf", "launch"):
        (tmp_path / folder).mkdir()
    (tmp_path / "urdf" / "it's.urdf").write_text("<robot name='here'/>")
    (tmp_path / "other.urdf").write_text("<robot name='other'/>")
    made = replace(TWO, outputs=(replace(URDF, file="urdf/it's.urdf"),))
    text = launch(made, replace(OUTPUT, file="launch/static_tf.launch.py"))
    path = tmp_path / "launch" / "static_tf.launch.py"
    parameter = "robot_description"
    assert run(text, path)[0].parameters[parameter] == "<robot name='here'/>"
    chosen = run(text, path, urdf_file=str(tmp_path / "other.urdf"))
    assert chosen[0].parameters[parameter] == "<robot name='other'/>"


def test_a_urdf_from_a_template_counts_where_there_is_no_other() -> None:
    own = Output("aaa", "template", "own.urdf", {"template": "own.urdf.jinja"})
    assert "'own.urdf'" in launch(replace(TWO, outputs=(own,)))
    assert "'robot.urdf'" in launch(replace(TWO, outputs=(own, URDF)))


def test_without_a_urdf_nobody_publishes_the_joints() -> None:
    text, diagnostics = static_tf.write(replace(TWO, outputs=()), OUTPUT, Templates())
    assert [d.rule for d in diagnostics] == ["static-tf-no-urdf"]
    assert [node.name for node in run(text, Path("x.launch.py"))] == ["tf_base_laser", "tf_base_imu"]
    for unused in ("pathlib", "OpaqueFunction", "ParameterValue", ROBOT_STATE_PUBLISHER):
        assert unused not in text


def test_what_moves_is_not_static() -> None:
    turning = replace(static("j", "base_link", "arm", LASER, "tf_arm"), type="revolute")
    for write in (static_tf.write, static_tf.write_list):
        text, diagnostics = write(robot(turning), OUTPUT, Templates())
        assert [(d.rule, d.severity) for d in diagnostics] == [("static-tf-moves", "error")]
        assert "joint j is revolute" in diagnostics[0].message
        assert "tf_arm" not in text


LONG = Source("factory", "a long note about where the numbers come from, " * 10)
SHAPES_OF_FILE = [
    TWO,
    replace(TWO, outputs=()),
    robot(outputs=()),
    robot(*(replace(joint, source=LONG) for joint in TWO.joints)),
]


def test_the_launch_file_is_clean_python(tmp_path: Path) -> None:
    for number, made in enumerate(SHAPES_OF_FILE):
        text = static_tf.write(made, OUTPUT, Templates())[0]
        ast.parse(text, feature_version=(3, 10))
        assert text.endswith("    ])\n")
        assert all(len(line) <= 99 and line == line.rstrip() for line in text.splitlines())
        (tmp_path / f"made{number}.launch.py").write_text(text, "utf-8")
    clean(*tmp_path.glob("*.py"))


@pytest.mark.parametrize("given", [{}, {"namespace": "left"}, {"frame_prefix": "left/"}])
def test_namespace_and_prefix_reach_every_node(tmp_path: Path, given: dict[str, str]) -> None:
    (tmp_path / "robot.urdf").write_text("<robot/>")
    nodes = run(launch(TWO), tmp_path / "static_tf.launch.py", **given)
    prefix = given.get("frame_prefix", "")
    assert {node.namespace for node in nodes} == {given.get("namespace", "")}
    assert nodes[0].parameters["frame_prefix"] == prefix
    frames = [command_line(node.arguments)[:2] for node in nodes[1:]]
    assert frames == [(f"{prefix}base_link", f"{prefix}{child}") for child in ("laser", "imu_link")]


def test_another_default_of_the_prefix_is_another_meaning() -> None:
    text = launch(TWO)
    moved = text.replace(
        "'frame_prefix',\n            default_value=''", "'frame_prefix',\n            default_value='x/'"
    )
    assert moved != text
    assert [edge.child for edge in static_tf.read(moved).frames] == ["x/laser", "x/imu_link"]
    with pytest.raises(ValueError, match="nor a launch argument"):
        static_tf.read(text.replace("frame_prefix = LaunchConfiguration", "frame_prefix = Unknown"))


@pytest.mark.parametrize("name", ODD_NAMES)
def test_any_legal_name(name: str, tmp_path: Path) -> None:
    made = robot(static("j", name, f"{name}2", LASER, name, source=Source("factory", name)), name=name)
    (tmp_path / "robot.urdf").write_text("<robot/>")
    path = tmp_path / "odd.launch.py"
    path.write_text(launch(made), "utf-8")
    compile(path.read_bytes(), str(path), "exec")  # bytes: a comment must not be taken for the encoding
    node = run(launch(made), path)[1]
    assert node.name == name
    parent, child, _ = command_line(node.arguments)
    assert (parent, child) == (name, f"{name}2")
    (edge,) = static_tf.read(launch(made)).frames
    assert (edge.child, edge.publisher.name) == (child, name)


def test_what_is_read_is_what_a_launch_file_is_meant_to_contain() -> None:
    first, second = static_tf.read(launch(TWO)).frames
    assert (first.parent, first.child, first.publisher.name) == ("base_link", "laser", "tf_base_laser")
    assert first.pose is not None
    assert first.pose.xyz[1] == 7.56e-05
    assert second.pose is not None
    assert second.pose.rpy[2] == 1.5707
    assert static_tf.view(TWO, OUTPUT) == static_tf.read(launch(TWO))


def test_reading_runs_nothing(tmp_path: Path) -> None:
    mark = tmp_path / "mark"
    text = f"open({str(mark)!r}, 'w')\n" + launch(TWO)
    assert len(static_tf.read(text).frames) == 2
    assert not mark.exists()


GOOD = launch(TWO)
GOOD_JSON = static_tf.write_list(TWO, OUTPUT, Templates())[0]
DAMAGED = {
    "cut off": GOOD[:-20],
    "zero byte": "\0" + GOOD,
    "deep": "(" * 100000,
    "no name": GOOD.replace("name='tf_base_laser',", ""),
    "no arguments": GOOD.replace("arguments=[", "argument=["),
    "a flag of ours is missing": GOOD.replace("'--yaw', '3.14159265',", ""),
    "a flag is unknown": GOOD.replace("--yaw", "--jaw"),
    "an odd number of arguments": GOOD.replace("'3.14159265',", ""),
    "not a number": GOOD.replace("3.14159265", "3.14159265abc"),
    "not finite": GOOD.replace("3.14159265", "nan"),
    "not literal": GOOD.replace("'3.14159265'", "str(pi)"),
    "not text": GOOD.replace("'3.14159265'", "3.14159265"),
    "unhashable": GOOD.replace("name='tf_base_laser'", "name={[]: 1}"),
    "name is a number": GOOD.replace("name='tf_base_laser'", "name=1"),
}
DAMAGED_JSON = {
    "cut off": GOOD_JSON[:-20],
    "empty": "",
    "a list": "[]",
    "no list": '{"static_transform_publisher": 1}',
    "no name": GOOD_JSON.replace('"name"', '"nam"'),
    "not finite": GOOD_JSON.replace("3.14159265", "inf"),
    "deep": "[" * 100000,
}


@pytest.mark.parametrize("text", DAMAGED.values(), ids=DAMAGED)
def test_a_damaged_launch_file_is_a_value_error(text: str) -> None:
    with pytest.raises(ValueError):  # noqa: PT011 - the kind is the promise
        static_tf.read(text)


@pytest.mark.parametrize("text", DAMAGED_JSON.values(), ids=DAMAGED_JSON)
def test_a_damaged_list_is_a_value_error(text: str) -> None:
    with pytest.raises(ValueError):  # noqa: PT011
        static_tf.read_list(text)


@pytest.mark.parametrize(
    ("text", "robot"),
    [
        (GOOD_JSON, "tester"),
        ('{"robot": "tester"}', ""),
        ('{"robot": ["tester"], "static_transform_publisher": []}', ""),
        ('["robot", "static_transform_publisher"]', ""),
        ("1", ""),
        (GOOD_JSON[:-20], ""),
    ],
)
def test_only_a_list_of_ours_is_said_to_be_of_a_robot(tmp_path: Path, text: str, robot: str) -> None:
    """Another JSON that names the robot is not ours to take away."""
    (tmp_path / "static_tf.json").write_text(text, "utf-8")
    assert static_tf.robot_of(tmp_path / "static_tf.json") == robot
