"""Packages that start more than the publishers: controllers, MoveIt, navigation."""

import xml.etree.ElementTree as ET
from pathlib import Path

import pytest
import yaml

from rosorin_compile.cli.main import main
from support.launch import Started, read
from support.packages import written
from support.paths import ROOT, data_text

NAME = "rosorin_description"


def nodes_of(package: Path, file: str, name: str = NAME, **given: str) -> list[Started]:
    return read(package / "launch" / file, {name: package}, **given).nodes


def spawned(nodes: list[Started]) -> list[str]:
    return [node.arguments[0] for node in nodes if node.executable == "spawner"]


def test_controllers_are_started_with_the_hardware_of_their_own_urdf(tmp_path: Path) -> None:
    package = written(tmp_path, "--control")
    nodes = nodes_of(package, "control.launch.py", use_sim_time="true")
    hardware, manager, *spawners = nodes
    assert "<ros2_control" in hardware.parameters["robot_description"]
    assert "front_left_wheel_joint" in hardware.parameters["robot_description"]
    # Its frames are published by nobody: those of the robot come from the URDF without wheels.
    assert {old for old, _ in hardware.remaps} == {"robot_description", "/tf", "/tf_static"}
    assert not {new for _, new in hardware.remaps} & {"robot_description", "/tf", "/tf_static"}
    assert manager.executable == "ros2_control_node"
    assert manager.remaps == [("robot_description", "control_description")]
    assert [Path(file).name for file in manager.files] == ["controllers.yaml"]
    assert spawned(spawners) == [
        "joint_state_broadcaster",
        "arm_controller",
        "gripper_controller",
        "mecanum_drive_controller",
    ]
    assert all(node.parameters.get("use_sim_time", True) is True for node in nodes)


def test_moveit_is_started_with_what_it_wants(tmp_path: Path) -> None:
    package = written(tmp_path, "--control", "--moveit")
    (node,) = nodes_of(package, "moveit.launch.py")
    assert (node.package, node.executable) == ("moveit_ros_move_group", "move_group")
    links = {one.get("name") for one in ET.fromstring(node.parameters["robot_description"]).iter("link")}
    semantic = ET.fromstring(node.parameters["robot_description_semantic"])
    assert {one.get("tip_link") for one in semantic.iter("chain")} <= links
    assert list(node.parameters["robot_description_kinematics"]) == ["arm"]
    limits = node.parameters["robot_description_planning"]["joint_limits"]
    assert {name: one["max_velocity"] for name, one in limits.items()} == {f"joint{i}": 1.0 for i in range(1, 6)}
    moved = node.parameters["moveit_simple_controller_manager"]
    assert moved["controller_names"] == ["arm_controller"]
    assert moved["arm_controller"]["joints"] == [f"joint{i}" for i in range(1, 6)]


GRIPPER = data_text("robots/package_bringup_gripper.yaml")


def hand(folder: Path, distribution: str, kind: str = "position_gripper") -> Path:
    (folder / "hand.yaml").write_text(GRIPPER.replace("DISTRIBUTION", distribution).replace("KIND", kind), "utf-8")
    words = ["--control", "--moveit"]
    assert main(["package", str(folder / "hand.yaml"), "-o", str(folder / "hand"), *words]) == 0
    return folder / "hand"


def test_moveit_is_in_the_namespace_of_the_controllers(tmp_path: Path) -> None:
    """It finds them, and the joint states, by names without one."""
    text = GRIPPER.replace("DISTRIBUTION}", 'jazzy, namespace: "left"}').replace("KIND", "position_gripper")
    (tmp_path / "hand.yaml").write_text(text.replace('jazzy, namespace: "left"', "jazzy", 1), "utf-8")
    words = ["--control", "--moveit", "-q"]
    assert main(["package", str(tmp_path / "hand.yaml"), "-o", str(tmp_path / "hand"), *words]) == 0
    nodes = nodes_of(tmp_path / "hand", "bringup.launch.py", "hand_description")
    assert {"move_group", "spawner"} < {node.executable for node in nodes}
    assert {node.namespace for node in nodes} == {"left"}


@pytest.mark.parametrize("distribution", ["humble", "jazzy"])
def test_a_controller_is_started_inactive(tmp_path: Path, distribution: str) -> None:
    nodes = nodes_of(hand(tmp_path, distribution), "control.launch.py", "hand_description")
    inactive = {node.arguments[0]: "--inactive" in node.arguments for node in nodes if node.executable == "spawner"}
    assert inactive == {"states": False, "gripper": False, "direct": True}


def test_moveit_has_a_limit_of_acceleration_where_it_plans_nothing_without(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    found = {}
    for distribution in ("humble", "jazzy", "kilted"):
        (node,) = nodes_of(hand(tmp_path, distribution), "moveit.launch.py", "hand_description")
        found[distribution] = node.parameters["robot_description_planning"]["joint_limits"]["grip"]
        told = "note[package-acceleration]: config/joint_limits.yaml has assumed" in capsys.readouterr().err
        text = (tmp_path / "hand/config/joint_limits.yaml").read_text("utf-8")
        assert (told, "stand-in" in text) == ((False, False) if distribution == "humble" else (True, True))
    velocity = {"has_velocity_limits": True, "max_velocity": 0.1}
    assert found["humble"] == {**velocity, "has_acceleration_limits": False}
    stand_in = {**velocity, "has_acceleration_limits": True, "max_acceleration": 1.0}
    assert found["jazzy"] == found["kilted"] == stand_in


@pytest.mark.parametrize(
    ("kind", "action"), [("position_gripper", "GripperCommand"), ("parallel_gripper", "ParallelGripperCommand")]
)
def test_moveit_asks_a_gripper_in_its_own_words(tmp_path: Path, kind: str, action: str) -> None:
    (node,) = nodes_of(hand(tmp_path, "jazzy", kind), "moveit.launch.py", "hand_description")
    asked = node.parameters["moveit_simple_controller_manager"]
    assert asked["controller_names"] == ["gripper"]
    assert (asked["gripper"]["type"], asked["gripper"]["action_ns"]) == (action, "gripper_cmd")
    assert asked["gripper"]["joints"] == ["grip"]


@pytest.mark.parametrize(
    ("word", "said"),
    [
        ("control", "--control is for the controller_manager with its controllers: no output has the hardware"),
        ("moveit", "--moveit is for MoveIt's move_group: no output has an SRDF"),
        ("nav2", "--nav2 is for Nav2, localisation and the filter of odometry: no output has their parameters"),
    ],
)
def test_what_no_output_is_for_is_not_started(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], word: str, said: str
) -> None:
    robot = ROOT / "examples/unitree_a1"
    assert main(["package", str(robot), "-o", str(tmp_path / "a1"), f"--{word}"]) == 1
    assert f"error[package-start]: {said}" in capsys.readouterr().err
    assert not (tmp_path / "a1").exists()


def nav2_bringup(folder: Path) -> Path:
    bringup = folder / "nav2_bringup"
    for file, text in yaml.safe_load(data_text("nav2_bringup_arguments.yaml")).items():
        (bringup / file).parent.mkdir(parents=True, exist_ok=True)
        (bringup / file).write_text(text, "utf-8")
    return bringup


def test_navigation_is_tuned_by_nav2_and_sized_by_the_description(tmp_path: Path) -> None:
    bringup = nav2_bringup(tmp_path)
    package = tmp_path / "burger"
    robot = ROOT / "examples/turtlebot3_burger"
    assert main(["package", str(robot), "-o", str(package), "--nav2", "--name", "burger", "-q"]) == 0
    shares = {"burger": package, "nav2_bringup": bringup}
    nodes = read(package / "launch/navigation.launch.py", shares, map="/maps/here.yaml", use_sim_time="true").nodes
    filtering, navigating = nodes
    assert (filtering.package, filtering.executable, filtering.name) == (
        "robot_localization",
        "ekf_node",
        "ekf_filter_node",
    )
    assert [Path(file).name for file in filtering.files] == ["ekf.yaml"]
    slam, where, sim_time, file = navigating.arguments
    assert (slam, where, sim_time) == ("False", "/maps/here.yaml", "true")
    merged = yaml.safe_load(Path(file).read_text("utf-8"))
    own = yaml.safe_load((package / "config/nav2.yaml").read_text("utf-8"))
    costmap = merged["local_costmap"]["local_costmap"]["ros__parameters"]
    assert costmap["update_frequency"] == 5.0
    assert merged["controller_server"]["ros__parameters"] == {
        "controller_frequency": 20.0,
        "odom_topic": "diff_drive_controller/odom",
        "enable_stamped_cmd_vel": True,
    }
    assert costmap["robot_base_frame"] == "base_footprint"
    assert costmap["footprint"] == own["local_costmap"]["local_costmap"]["ros__parameters"]["footprint"]
    needs = {element.text for element in ET.parse(package / "package.xml").iter("exec_depend")}
    assert {"nav2_bringup", "robot_localization"} <= needs


@pytest.mark.parametrize("control", [True, False])
def test_the_filter_listens_to_the_controller_that_is_started(tmp_path: Path, control: bool) -> None:
    package = written(tmp_path, "--nav2", *(["--control"] if control else []))
    shares = {NAME: package, "nav2_bringup": nav2_bringup(tmp_path)}
    ekf = read(package / "launch/navigation.launch.py", shares).nodes[0]
    assert ekf.package == "robot_localization"
    assert ekf.remaps == ([("odom_raw", "/mecanum_drive_controller/odometry")] if control else [])
