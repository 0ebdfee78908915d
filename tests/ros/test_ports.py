"""The topics between the nodes of a package: closed, or reported with what happens on the robot."""

from __future__ import annotations

import json
import xml.etree.ElementTree as ET
from pathlib import Path
from typing import Any

import pytest
import yaml

from rosorin_compile.cli.main import main
from rosorin_compile.ros.parameter_files import nodes_of
from support.paths import ROOT, data_text

CART = data_text("robots/cart_with_nav2.yaml")
WITHOUT_POSITION = [
    (
        f"{side}_joint: {{command: velocity, state: [position, velocity]}}",
        f"{side}_joint: {{command: velocity, state: velocity}}",
    )
    for side in ("left", "right")
]


def write(folder: Path, *changes: tuple[str, str], distribution: str = "jazzy") -> Path:
    text = CART
    for old, new in changes:
        assert text.count(old) == 1, old
        text = text.replace(old, new)
    path = folder / "robot.yaml"
    path.write_text(text.replace("DISTRIBUTION", distribution), "utf-8")
    return path


def package(folder: Path, *changes: tuple[str, str], distribution: str = "jazzy", code: int = 0) -> Path:
    robot = write(folder, *changes, distribution=distribution)
    words = ["package", str(robot), "-o", str(folder / "made"), "--control", "--nav2", "-q"]
    assert main(words) == code
    return folder / "made"


def parameters(made: Path, file: str) -> dict[str, dict[str, Any]]:
    return nodes_of((made / "config" / file).read_text("utf-8"))


@pytest.mark.parametrize("distribution", ["humble", "jazzy", "kilted"])
def test_a_whole_robot_has_no_open_ends(tmp_path: Path, capsys: pytest.CaptureFixture[str], distribution: str) -> None:
    control = "humble" if distribution == "humble" else "jazzy"
    package(tmp_path, ("control: jazzy", f"control: {control}"), distribution=distribution)
    assert "package-open" not in capsys.readouterr().err


def test_the_topic_of_a_lidar_reaches_every_reader(tmp_path: Path) -> None:
    made = package(tmp_path, ("{scan: {sensor: lidar, topic: /scan}}", "{front: {sensor: lidar, topic: /front/scan}}"))
    nodes = parameters(made, "nav2.yaml")
    assert nodes["amcl"]["scan_topic"] == "/front/scan"
    monitor = nodes["collision_monitor"]
    assert (monitor["observation_sources"], monitor["front.type"]) == (["front"], "scan")
    assert monitor["front.topic"] == "/front/scan"
    for name, layer in (("local_costmap", "voxel_layer"), ("global_costmap", "obstacle_layer")):
        costmap = nodes[f"{name}/{name}"]
        assert costmap[f"{layer}.front.topic"] == "/front/scan"
        assert costmap[f"{layer}.front.marking"] is costmap[f"{layer}.front.clearing"] is True
        assert costmap[f"{layer}.front.raytrace_max_range"] > costmap[f"{layer}.front.obstacle_max_range"]
    launch = (made / "launch/navigation.launch.py").read_text("utf-8")
    assert "'scan_topic': '/front/scan'" in launch  # slam_toolbox, where it is started by hand


def test_points_of_depth_leave_the_floor_free(tmp_path: Path) -> None:
    lidar = "  lidar: {type: lidar_2d, parent: base_link, frame: laser, xyz: [10 cm, 0, 12 cm]}\n"
    camera = "  camera: {type: depth_camera, parent: base_link, frame: camera_link, xyz: [10 cm, 0, 15 cm]}\n"
    sources = "sources: {scan: {sensor: lidar, topic: /scan}, depth: {sensor: camera, topic: /camera/points}}"
    made = package(tmp_path, (lidar, lidar + camera), ("sources: {scan: {sensor: lidar, topic: /scan}}", sources))
    costmap = parameters(made, "nav2.yaml")["local_costmap/local_costmap"]
    assert costmap["voxel_layer.scan.min_obstacle_height"] == 0.0
    assert costmap["voxel_layer.depth.min_obstacle_height"] == 0.05
    assert costmap["voxel_layer.depth.clearing"] is True
    assert "is a stand-in" in (made / "config/nav2.yaml").read_text("utf-8")


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ([("base/odom}", "odom}")], "ekf_filter_node reads Odometry on /odom, and base publishes on /base/odom"),
        ([("imu_broadcaster/imu", "imu/data")], "ekf_filter_node reads Imu on /imu/data, and imu_broadcaster"),
        (
            [
                ("  lidar: {type: lidar_2d, parent: base_link, frame: laser, xyz: [10 cm, 0, 12 cm]}\n", ""),
                (", sources: {scan: {sensor: lidar, topic: /scan}}", ""),
            ],
            "read LaserScan on /scan, and the robot has no sensor for that",
        ),
        (
            [("mock_components/GenericSystem", "gz_ros2_control/GazeboSimSystem")],
            'only Gazebo loads the plugin gz_ros2_control/GazeboSimSystem of hardware block "motors"',
        ),
        (
            [
                (
                    "{type: diff_drive}",
                    "{type: diff_drive, params: {qos_overrides./base/odom.publisher.reliability: best_effort}}",
                )
            ],
            "ekf_filter_node needs reliable messages on /base/odom and gets none: base sends them as best effort",
        ),
    ],
)
def test_what_would_not_work_is_refused(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], changes: list[tuple[str, str]], message: str
) -> None:
    made = package(tmp_path, *changes, code=1)
    assert message in capsys.readouterr().err
    assert not made.exists()


def test_another_message_of_velocities_is_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Nav2 of Humble sends Twist, and a controller of Jazzy takes TwistStamped."""
    change = ("nav2: {file: nav2.yaml, distribution: DISTRIBUTION", "nav2: {file: nav2.yaml, distribution: humble")
    package(tmp_path, change, code=1)
    assert "base reads TwistStamped on /cmd_vel, and behavior_server publishes Twist there" in capsys.readouterr().err


def test_an_odometry_of_somebody_else_is_a_note(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    inputs = "odom0: {topic: base/odom}, odom1: {topic: camera/odom}, pose0: {topic: mocap, uses: [x, y]}"
    robot = write(tmp_path, ("odom0: {topic: base/odom}", inputs))
    words = ["package", str(robot), "-o", str(tmp_path / "made"), "--control", "--nav2"]
    assert main(words) == 0
    said = capsys.readouterr().err
    assert (
        "note[package-external]: ekf_filter_node reads Odometry on /camera/odom, which no node of the package" in said
    )
    assert "ekf_filter_node reads PoseWithCovarianceStamped on /mocap, which no node of the package" in said
    assert "until one of its inputs speaks" not in said


def test_interfaces_that_the_hardware_lacks(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    made = package(tmp_path, *WITHOUT_POSITION)
    assert parameters(made, "controllers.yaml")["base"]["position_feedback"] is False
    capsys.readouterr()
    arm = "  arm: {type: joint_trajectory, params: {joints: [fork_joint], command_interfaces: [position], "
    arm += "state_interfaces: [position, velocity]}}\n"
    robot = write(
        tmp_path,
        ("fork_joint: {type: fixed", "fork_joint: {type: continuous"),
        (
            "    sensors: {imu: {}}",
            "      fork_joint: {command: position, state: position}\n    sensors: {imu: {state: [orientation.x]}}",
        ),
        ("  jsb: {", f"{arm}  jsb: {{"),
    )
    main(["all", str(robot), "-o", str(tmp_path / "out")])
    said = capsys.readouterr().err
    assert 'error[controller-interface]: controller "arm" reads the velocity of "fork_joint", which' in said
    assert 'controller "imu_broadcaster" reads "imu/orientation.y", "imu/orientation.z", "imu/orientation.w"' in said


@pytest.mark.parametrize(
    ("changes", "why"),
    [
        ([("fork_joint: {type: fixed", "fork_joint: {type: continuous")], '"fork_joint", which no hardware block has'),
        (WITHOUT_POSITION, '"left_joint", which hardware block "motors" does not measure'),
        (
            [("{type: joint_state_", "{params: {joints: [left_joint], interfaces: [position]}, type: joint_state_")],
            '"right_joint", which "params" of controller "jsb" exclude',
        ),
    ],
)
def test_a_joint_that_nobody_measures(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], changes: list[tuple[str, str]], why: str
) -> None:
    robot = write(tmp_path, *changes)
    main(["all", str(robot), "-o", str(tmp_path / "out")])
    said = capsys.readouterr().err
    assert f"warning[controllers-joint-states]: no node publishes the position of joint {why}" in said
    assert main(["frames", str(robot)]) == 0
    assert "no joint state contains its position" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("words", "cause"),
    [
        ("params: {use_local_topics: true}", "jsb publishes on /jsb/joint_states"),
        ("inactive: true", "jsb is started inactive"),
    ],
)
def test_joint_states_of_a_broadcaster_that_is_there(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], words: str, cause: str
) -> None:
    write(tmp_path, ("{type: joint_state_broadcaster}", f"{{type: joint_state_broadcaster, {words}}}"))
    robot = ["package", str(tmp_path / "robot.yaml"), "-o", str(tmp_path / "made"), "--control", "--nav2"]
    assert main(robot) == 0
    assert f"robot_state_publisher reads JointState on /joint_states, and {cause}" in capsys.readouterr().err


def test_kilted_has_no_switches_of_limits(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = tmp_path / "c.yaml"
    limits = {"linear": {"x": {"has_velocity_limits": True}}, "left_wheel_names": ["left_joint"]}
    limits |= {"right_wheel_names": ["right_joint"]}
    manager = {"ros__parameters": {"base": {"type": "diff_drive_controller/DiffDriveController"}}}
    file.write_text(yaml.safe_dump({"controller_manager": manager, "base": {"ros__parameters": limits}}), "utf-8")
    found = {}
    for distribution in ("jazzy", "kilted"):
        main(["check", "parameters", str(write(tmp_path)), str(file), "--distribution", distribution])
        shown = capsys.readouterr()
        found[distribution] = 'has no parameter "linear.x.has_velocity_limits"' in shown.out + shown.err
    assert found == {"jazzy": False, "kilted": True}


def test_the_graph(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    robot = write(tmp_path, ("base/odom}", "odom}"))
    assert main(["graph", str(robot), "--format", "json"]) == 1
    found = json.loads(capsys.readouterr().out)
    topics = {one["topic"]: one for one in found["result"]["topics"]} if "result" in found else {}
    assert not topics or topics["/odom"]["published_by"] == []
    assert main(["graph", str(robot), "-o", str(tmp_path / "graph.svg")]) == 1
    drawn = ET.parse(tmp_path / "graph.svg")
    texts = {one.text for one in drawn.iter("{http://www.w3.org/2000/svg}text")}
    assert {"/odom (Odometry)", "ekf_filter_node", "driver of lidar"} <= texts


def test_the_readme_has_the_first_drive(tmp_path: Path) -> None:
    text = (package(tmp_path) / "README.md").read_text("utf-8")
    assert "-p stamped:=true -r cmd_vel:=/cmd_vel" in text
    assert "bringup.launch.py slam:=False map:=" in text
    assert "For ROS 2\nJazzy" in text
    assert "driver of lidar: `LaserScan` on `/scan`" in text
    inputs = "imu0: {topic: imu_broadcaster/imu}, imu1: {topic: camera/imu}"
    (tmp_path / "more").mkdir()
    more = package(tmp_path / "more", ("imu0: {topic: imu_broadcaster/imu}", inputs))
    assert "another driver: `Imu` on `/camera/imu`" in (more / "README.md").read_text("utf-8")


def test_moveit_publishes_the_srdf(tmp_path: Path) -> None:
    made = tmp_path / "arm"
    assert main(["package", str(ROOT / "examples/porter"), "-o", str(made), "--control", "--moveit", "-q"]) == 0
    assert "'publish_robot_description_semantic': True" in (made / "launch/moveit.launch.py").read_text("utf-8")
    view = yaml.safe_load((made / "rviz/moveit.rviz").read_text("utf-8"))
    classes = [one["Class"] for one in view["Visualization Manager"]["Displays"]]
    assert "moveit_rviz_plugin/MotionPlanning" in classes


SOURCES, MAP = "sources: {scan: {sensor: lidar, topic: /scan}}", "  - {parent: map, child: odom, publisher: amcl}\n"


def test_a_relative_topic_reaches_the_costmaps(tmp_path: Path) -> None:
    made = package(tmp_path, (SOURCES, "sources: {front: {sensor: lidar, topic: front/scan}}"),
                   ("controllers.yaml, ", "controllers.yaml, namespace: left, "),
                   ("base/odom", "left/base/odom"), ("{topic: imu_b", "{topic: left/imu_b"))  # fmt: skip
    assert "description.launch.py namespace:=left\n" in (made / "README.md").read_text("utf-8")
    assert parameters(made, "nav2.yaml")["local_costmap/local_costmap"]["voxel_layer.front.topic"] == "/front/scan"
    assert "/front/scan" in (made / "rviz/r.rviz").read_text("utf-8")


def test_amcl_reads_the_source_named_scan(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    rear = "  rear: {type: lidar_2d, parent: base_link, frame: rear_laser}\n  imu:"
    named = "sources: {scan: {sensor: lidar, topic: /front}, rear: {sensor: rear, topic: /rear}}"
    robot = write(tmp_path, ("  imu:", rear), (SOURCES, named.replace("scan:", "front:")))
    assert main(["graph", str(robot)]) == 0
    assert named in capsys.readouterr().err
    nodes = parameters(package(tmp_path, ("  imu:", rear), (SOURCES, named)), "nav2.yaml")
    assert nodes["amcl"]["scan_topic"] == "/front"


@pytest.mark.parametrize(
    ("changes", "offered", "silent"),
    [
        ([], {"True", "False"}, False),
        ([(", amcl: {package: nav2_amcl}", ""), (MAP, "")], {"True", "False"}, False),
        ([("amcl: {package: nav2_amcl}", "slam_toolbox: {}"), ("publisher: amcl", "publisher: slam_toolbox")],
         {"True"}, False),
        ([("amcl: {package: nav2_amcl}", "base: {}"), ("print, publisher: ekf_filter_node", "print, publisher: base"),
          ("publisher: amcl", "publisher: ekf_filter_node")],
         {"True", "False"}, True),
    ],
)  # fmt: skip
def test_one_node_publishes_the_map_frame(
    tmp_path: Path, changes: list[tuple[str, str]], offered: set[str], silent: bool
) -> None:
    made = package(tmp_path, *changes)
    launch = (made / "launch/navigation.launch.py").read_text("utf-8")
    assert f"choices={sorted(offered, reverse=True)}" in launch
    assert ("'transform_publish_period': 0.0" in launch) == silent
    assert {word for word in ("True", "False") if f"slam:={word}" in (made / "README.md").read_text("utf-8")} == offered


def test_mppi_knows_that_a_car_cannot_turn_in_place(tmp_path: Path) -> None:
    text = (ROOT / "examples/ackermann_car/robot.yaml").read_text("utf-8")
    text += "  nav2: {file: nav2.yaml}\npublishers: {base: {package: ackermann_steering_controller}}\n"
    text += "edges: [{parent: odom, child: base_footprint, publisher: base}]\n"
    (tmp_path / "robot.yaml").write_text(text, "utf-8")
    assert main(["all", str(tmp_path / "robot.yaml"), "-o", str(tmp_path / "out"), "-q"]) == 0
    server = nodes_of((tmp_path / "out/nav2.yaml").read_text("utf-8"))["controller_server"]
    assert server["FollowPath.motion_model"] == "Ackermann"
    assert server["FollowPath.AckermannConstraints.min_turning_r"] == pytest.approx(0.461, abs=0.002)  # m
