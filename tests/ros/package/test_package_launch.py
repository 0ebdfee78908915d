"""The three launch files of a package: they start the same nodes, with the numbers of the description."""

import xml.etree.ElementTree as ET
from pathlib import Path

import pytest
import yaml
from hypothesis import given, settings
from hypothesis import strategies as st

from rosorin_compile.cli.main import main
from rosorin_compile.formats import static_tf
from rosorin_compile.formats.static_tf import STATES
from rosorin_compile.model import Link, Output, Pose, Robot
from support.launch import Failed, command_line, read
from support.packages import EXAMPLES, FORMS, clean, describe, made, static, written
from support.paths import data_text
from support.robots import compiled

ODD = ["a|b", "x\\y", "weiß", "🤖", "{{x}}", "{%x%}", "$(x)", "#x", "coding:latin-1", "%s", "--x", "`a`", "\\", "a b"]
ODD += ["$$"]


def test_every_node_that_runs_on_a_robot_is_a_dependency(tmp_path: Path) -> None:
    package = written(tmp_path)
    needs = {element.text for element in ET.parse(package / "package.xml").iter("exec_depend")}
    screen = {"joint_state_publisher": "true", "joint_state_publisher_gui": "true", "rviz": "true"}
    for form in FORMS:
        path, shares = package / f"launch/description.launch.{form}", {"rosorin_description": package}
        assert {node.package for node in read(path, shares).nodes} <= needs
        nodes = read(path, shares, **screen).nodes
        assert [node.package for node in nodes[-3:]] == [*list(screen)[:2], "rviz2"]
        assert len(nodes) == 6
    assert not needs & {*screen, "rviz2"}  # they have a screen
    said = (package / "README.md").read_text("utf-8")
    assert "sudo apt install ros-$ROS_DISTRO-rviz2 ros-$ROS_DISTRO-joint-state-publisher-gui" in said


@pytest.mark.parametrize("form", FORMS)
def test_two_robots_of_one_package_share_no_name(tmp_path: Path, form: str) -> None:
    package = written(tmp_path)
    path, shares = package / f"launch/description.launch.{form}", {"rosorin_description": package}
    alone = read(path, shares, rviz="true", joint_state_publisher="true").nodes
    robots = []
    for side in ("left", "right"):
        given = {"namespace": side, "frame_prefix": f"{side}/", "rviz": "true", "joint_state_publisher": "true"}
        robots.append(read(path, shares, **given).nodes)
        assert [node.namespace for node in robots[-1]] == [side] * len(alone)
        for node, one in zip(robots[-1], alone, strict=True):
            assert (node.package, node.executable, node.name) == (one.package, one.executable, one.name)
        assert robots[-1][0].parameters == {**alone[0].parameters, "frame_prefix": f"{side}/"}
        frames = [command_line(node.arguments)[:2] for node in robots[-1] if node.package == "tf2_ros"]
        assert frames == [(f"{side}/base_link", f"{side}/laser"), (f"{side}/base_link", f"{side}/imu_link")]
        assert robots[-1][-1].arguments[2:] == ["-f", f"{side}/base_link"]
    names = [(node.namespace, node.name) for node in (*robots[0], *robots[1])]
    assert len(set(names)) == len(names)
    view = yaml.safe_load((package / "rviz/rosorin.rviz").read_text("utf-8"))
    model = next(one for one in view["Visualization Manager"]["Displays"] if one["Name"] == "RobotModel")
    assert model["Description Topic"]["Value"] == "robot_description"  # no "/": it is in the namespace


@pytest.mark.parametrize("form", FORMS)
def test_a_launch_file_starts_what_the_description_says(tmp_path: Path, form: str) -> None:
    package = written(tmp_path)
    launch = read(package / f"launch/description.launch.{form}", {"rosorin_description": package})
    publisher, *statics = launch.nodes
    urdf = (package / "urdf/rosorin.urdf").read_text("utf-8")
    assert publisher.parameters == {"robot_description": urdf, "frame_prefix": "", "use_sim_time": False}
    assert publisher.namespace == ""
    assert (publisher.package, publisher.executable) == ("robot_state_publisher", "robot_state_publisher")
    robot = compiled().robot
    assert robot is not None
    wanted = [(t.name, list(t.arguments)) for t in static_tf.static_transforms(robot)[0]]
    assert [(node.name, node.arguments) for node in statics] == wanted
    assert {(node.package, node.executable) for node in statics} == {("tf2_ros", "static_transform_publisher")}


@pytest.mark.parametrize("chosen", ["use_sim_time", "joint_state_publisher", "joint_state_publisher_gui", "rviz"])
def test_the_three_forms_do_the_same(tmp_path: Path, chosen: str) -> None:
    package = written(tmp_path)
    shares = {"rosorin_description": package}
    first, *others = (read(package / f"launch/description.launch.{form}", shares, **{chosen: "true"}) for form in FORMS)
    assert all(other == first for other in others)
    assert chosen == "use_sim_time" or first.nodes[-1].name.startswith(chosen)
    assert first.nodes[0].parameters["use_sim_time"] is (chosen == "use_sim_time")
    if chosen == "rviz":
        assert first.nodes[-1].arguments == ["-d", str(package / "rviz/rosorin.rviz"), "-f", "base_link"]


@settings(max_examples=60, deadline=None)
@given(data=st.data())
def test_odd_names_come_through_in_all_forms(tmp_path_factory: pytest.TempPathFactory, data: st.DataObject) -> None:
    number = st.floats(-10, 10)
    child, parent, node, name = (data.draw(st.permutations(ODD))[0] for _ in range(4))
    if child == parent:
        parent = "base_link"
    pose = Pose(data.draw(st.tuples(number, number, number)), data.draw(st.tuples(number, number, number)))
    joint = static("j", parent, child, pose, node)
    robot = Robot(name, (Link(parent), Link(child)), (joint,), outputs=(Output("urdf", "urdf", "robot.urdf"),))
    package = made(tmp_path_factory.mktemp("odd"), robot)
    wanted = list(static_tf.static_transforms(robot)[0][0].arguments)
    for form in FORMS:
        found = read(package / f"launch/description.launch.{form}", {"made": package}).nodes[1]
        assert (found.name, found.arguments) == (node, wanted)
    view = yaml.safe_load(next((package / "rviz").iterdir()).read_text("utf-8"))
    assert view["Visualization Manager"]["Global Options"]["Fixed Frame"] == parent


@pytest.mark.parametrize("folder", EXAMPLES, ids=lambda folder: folder.name)
def test_the_examples(tmp_path: Path, folder: Path) -> None:
    assert main(["package", str(folder), "-o", str(tmp_path / "package"), "--name", "made"]) == 0
    launches = [
        read(tmp_path / f"package/launch/description.launch.{f}", {"made": tmp_path / "package"}) for f in FORMS
    ]
    assert launches[0] == launches[1] == launches[2]


TURNS = data_text("robots/package_launch_turns.yaml")


@pytest.mark.slow
@pytest.mark.parametrize("slam", ["true", "True", "false", "False"])
@pytest.mark.parametrize("rviz", ["true", "false"])
def test_publishers_that_take_turns(tmp_path: Path, slam: str, rviz: str) -> None:
    path = describe(tmp_path, TURNS)
    package = tmp_path / "package"
    assert main(["package", str(path), "-o", str(package), "--name", "made"]) == 0
    wanted = "tf_mast" if slam in ("true", "True") and rviz == "false" else "tf_other"
    for form in FORMS:
        launch = read(package / f"launch/description.launch.{form}", {"made": package}, slam=slam, mode_rviz=rviz)
        assert [node.name for node in launch.nodes[1:]] == [wanted]
        assert launch.arguments["slam"] == ("false", "the robot is run in the mode slam", STATES)
        assert set(launch.arguments) > {"rviz", "mode_rviz"}
    assert main(["check", "deployed", str(path), str(package)]) == 0


@pytest.mark.parametrize("state", ["1", "on", "TRUE", "", "no"])
def test_the_three_forms_refuse_the_same_states(tmp_path: Path, state: str) -> None:
    package = tmp_path / "package"
    assert main(["package", str(describe(tmp_path, TURNS)), "-o", str(package), "--name", "made"]) == 0
    for form in FORMS:
        with pytest.raises(Failed, match=f"provided value '{state}' is not valid"):
            read(package / f"launch/description.launch.{form}", {"made": package}, slam=state)


def test_python_of_launch_files_is_clean(tmp_path: Path) -> None:
    package = tmp_path / "package"
    assert main(["package", str(describe(tmp_path, TURNS)), "-o", str(package), "--name", "made"]) == 0
    clean(*(package / "launch").glob("*.py"))
    clean(*(written(tmp_path) / "launch").glob("*.py"))
