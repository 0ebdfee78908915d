"""What a change of the description does to the artifacts is said by meaning, in exact words."""

from __future__ import annotations

from pathlib import Path

import pytest

from support.comparing import block, described, meaning

ALL = "urdf, urdf_sim, mjcf, static_tf, static_tf_json, robot_model, frames"

CHANGES = [
    pytest.param(
        ("arm.yaml", "0.00074282, 0.08513]", "0.00074282, 0.08613]"),
        ["link3 moved 1.0 mm in link2: origin z 0.08513 -> 0.08613 m: urdf, urdf_sim, mjcf, robot_model, frames"],
        id="origin",
    ),
    pytest.param(
        ("arm.yaml", "lower: -2.09", "lower: -1.57"),
        [
            f"joint{n} limit lower -2.09 -> -1.57 rad (+29.8 deg): urdf, urdf_sim, mjcf, robot_model"
            for n in range(1, 6)
        ],
        id="limit",
    ),
    pytest.param(
        ("arm.yaml", "mass: 0.0136322197327749", "mass: 0.015"),
        ["link2 mass 0.0136322 -> 0.015 kg (+1.4 g): urdf_sim, mjcf"],
        id="mass",
    ),
    pytest.param(
        ("arm.yaml", "ixx: 3.65656868148961e-06", "ixx: 3.65656869e-06"),
        [
            "link2 inertia ixx 3.6565686815e-06 -> 3.65656869e-06 kg*m^2"
            " (by 2.3e-07 % of the largest moment): urdf_sim, mjcf"
        ],
        id="tiny",
    ),
    pytest.param(
        ("arm.yaml", "max: [0.02398, 0.02399, 0.03955]", "max: [0.02398, 0.02399, 0.04]"),
        ["link1 collision: box max z 0.03955 -> 0.04 m (+0.45 mm): urdf, urdf_sim, mjcf, robot_model"],
        id="box",
    ),
    pytest.param(
        ("arm.yaml", "axis: [0, 0, -1]", "axis: [0, 0, 1]"),
        ["joint5 counts the other way round: axis 0 0 -1 -> 0 0 1: urdf, urdf_sim, mjcf, robot_model"],
        id="axis",
    ),
    pytest.param(  # the MJCF alone has it, as damping of the joint
        ("simulation.yaml", "kp: 20, damping: 1,", "kp: 20, damping: 2,"),
        [
            f"{name} damping 1 -> 2 N*m*s/rad (+100.0 %): mjcf"
            for name in (*(f"joint{n}" for n in range(1, 6)), "r_joint")
        ],
        id="drive",
    ),
    pytest.param(
        ("lidar_and_imu.yaml", "7.5552e-05, 0.106748]", "7.5552e-05, 0.116748]"),
        [
            "laser moved 10.0 mm in base_link: origin z 0.106748 -> 0.116748 m"
            f" (and therefore the shapes of base_link): {ALL}",
            "contact pairs: 1 new (laser - link1): mjcf",
        ],
        id="lidar-mount",
    ),
    pytest.param(
        ("lidar_and_imu.yaml", "180 deg", "170 deg"),
        [
            "laser turned 10.0 deg in base_link: yaw 3.14159 -> 2.96706 rad"
            f" (and therefore the shapes of base_link): {ALL}"
        ],
        id="lidar-turned",
    ),
    pytest.param(
        ("lidar_and_imu.yaml", "max: [0.02695, 0.02684, 0]", "max: [0.02695, 0.02684, 0.01]"),
        [
            "laser collision: box max z 0 -> 0.01 m"
            " (+10.0 mm; and therefore the shapes of base_link): urdf, urdf_sim, mjcf, robot_model"
        ],
        id="lidar-box",
    ),
    pytest.param(
        ("gripper.yaml", "rpy: [-3.1416, -1.5681, 3.1416]", "rpy: [-3.1, -1.5681, 3.1416]"),
        ["gripper_link turned 2.4 deg in link5: roll -3.1416 -> -3.1 rad: urdf, urdf_sim, mjcf, robot_model, frames"],
        id="angle-as-written",
    ),
    pytest.param(
        ("gripper.yaml", "rpy: [-0.0038422, 1.5647, -0.012569]", "rpy: [-0.0038422, 1.5, -0.012569]"),
        ["r_link turned 3.7 deg in gripper_link: pitch 1.5647 -> 1.5 rad: urdf_sim, mjcf, frames"],
        id="angle-of-quaternion",
    ),
    pytest.param(
        ("lidar_and_imu.yaml", "tf_base_laser", "tf_laser"),
        ["laser: published by tf_base_laser -> tf_laser: static_tf, static_tf_json, frames"],
        id="publisher",
    ),
    pytest.param(
        ("poses.yaml", "joint2: 981", "joint2: 980"),
        ["pose tuck: joint2 -2.01481 -> -2.01062 rad (+0.24 deg): mjcf, frames"],
        id="pose",
    ),
    pytest.param(
        ("poses.yaml", "poses:\n", "poses:\n  home: {positions: {joint1: 0}}\n"),
        ["new: pose home: frames"],
        id="new-pose",
    ),
    pytest.param(
        ("chassis.yaml", "[0.061, 0.061, 0.061, 0.094", "[0.091, 0.062, 0.061, 0.094"),
        [
            "base_footprint height map: 2 cells changed, by up to 30.0 mm"
            " (and therefore the shapes of base_footprint, base_link): urdf, urdf_sim, mjcf, robot_model"
        ],
        id="height-map",
    ),
    pytest.param(
        ("chassis.yaml", "[0.061, 0.061, 0.061, 0.094", "[0.062, 0.061, 0.061, 0.094"),
        ["base_footprint height map: 1 cell changed, by 1.0 mm: robot_model"],
        id="height-within-a-step",
    ),
    pytest.param(
        ("chassis.yaml", "step: 10 mm", "step: 5 mm"),
        [
            "base_footprint collision: 35 -> 39 shapes, 28 of them changed, up to 180.0 mm"
            " (and therefore the shapes of base_link): urdf, urdf_sim, mjcf"
        ],
        id="height-step",
    ),
    pytest.param(
        ("chassis.yaml", "xyz: [0, 0, 0.025]", "xyz: [0, 0, 0.026]"),
        [
            "base_footprint moved 1.0 mm in the world of MuJoCo: origin z -5.5639e-05 -> -0.00105564 m: mjcf",
            "base_link moved 1.0 mm in base_footprint: origin z 0.025 -> 0.026 m"
            " (and therefore the shapes of base_link): urdf, urdf_sim, mjcf, robot_model, frames",
        ],
        id="mount-of-the-chassis",
    ),
    pytest.param(
        ("camera.yaml", "parent: link4", "parent: link5"),
        [
            "camera_link0 parent link4 -> link5: urdf, urdf_sim, mjcf, robot_model, frames",
            "contact pairs: 6 removed"
            " (camera_link - gripper_link, camera_link - link3, camera_link - link5, 3 more): mjcf",
        ],
        id="parent",
    ),
    pytest.param(
        ("robot.yaml", "default: free", "default: fixed"),
        [
            # On its wheels: three spheres of a roller do not quite reach the ideal wheel between them.
            "base_footprint moved 0.056 mm in the world of MuJoCo: origin z -5.5639e-05 -> 0 m: mjcf",
            "base_footprint base: removed, was free: mjcf",
        ],
        id="base",
    ),
]


@pytest.mark.slow
@pytest.mark.parametrize(("edit", "said"), CHANGES)
def test_a_change_of_the_description_is_named(edit: tuple[str, str, str], said: list[str], tmp_path: Path) -> None:
    comparison = described(tmp_path, edit)
    assert meaning(comparison) == said
    assert not comparison.same


def test_several_changes_are_sorted_by_the_tree(tmp_path: Path) -> None:
    comparison = described(
        tmp_path,
        ("poses.yaml", "joint5: 499", "joint5: 500"),
        ("arm.yaml", "0.085147]", "0.085]"),
        ("lidar_and_imu.yaml", "mass: 0.0222221884545253", "mass: 0.03"),
        ("arm.yaml", "mass: 0.010597277181335", "mass: 0.02"),
    )
    assert meaning(comparison) == [
        "link1 mass 0.0105973 -> 0.02 kg (+9.4 g): urdf_sim, mjcf",
        "link4 moved 0.15 mm in link3: origin z 0.085147 -> 0.085 m: urdf, urdf_sim, mjcf, robot_model, frames",
        "laser mass 0.0222222 -> 0.03 kg (+7.8 g): urdf_sim, mjcf",
        "pose tuck: joint5 0.00418879 -> 0 rad (-0.24 deg): mjcf, frames",
    ]


def test_a_new_range_finder_is_one_line(tmp_path: Path) -> None:
    sensor = """sensors:
  rear:
    type: range_finder
    parent: base_link
    frame: rear_range
    xyz: [-0.14, 0, 0.05]
    publisher: {static_transform_publisher: tf_base_rear}
"""
    comparison = described(tmp_path, ("lidar_and_imu.yaml", "sensors:\n", sensor))
    new = "new: frame rear_range (on base_link, published by tf_base_rear): mjcf, static_tf, static_tf_json, frames"
    assert meaning(comparison) == [new]


def test_a_second_camera_is_two_frames(tmp_path: Path) -> None:
    sensor = """sensors:
  wrist:
    type: camera
    parent: gripper_link
    frame: wrist_camera
    xyz: [0.01, 0, 0.03]
    optical: {frame: wrist_optical}
"""
    comparison = described(tmp_path, ("camera.yaml", "sensors:\n", sensor))
    assert meaning(comparison) == [
        f"new: frame {frame} (on {parent}, published by robot_state_publisher): urdf, mjcf, frames"
        for frame, parent in (("wrist_camera", "gripper_link"), ("wrist_optical", "wrist_camera"))
    ]


def test_a_renamed_joint_is_one_line(tmp_path: Path) -> None:
    edits = [
        ("camera.yaml", "joint: camera_joint", "joint: camera_mount"),
        ("robot.yaml", "camera_joint, lidar_joint", "camera_mount, lidar_joint"),
    ]
    said = "joint camera_joint renamed to camera_mount: urdf, urdf_sim, robot_model"
    assert meaning(described(tmp_path, *edits)) == [said]


def test_a_removed_joint_is_one_line_however_many_numbers_it_had(tmp_path: Path) -> None:
    assert meaning(described(tmp_path, ("gripper.yaml", block("gripper.yaml", "r_out"), ""))) == [
        "removed: link r_out_link (revolute on r_in_link, r_out_joint, published by nobody): urdf_sim, mjcf, frames"
    ]


def test_a_joint_that_moves_now_is_one_line(tmp_path: Path) -> None:
    moving = "type: revolute\n    axis: [0, 0, 1]\n    limit: {lower: -1, upper: 1, effort: 1, velocity: 1}"
    said = meaning(described(tmp_path, ("camera.yaml", "type: fixed", moving)))
    assert said[:2] == [
        "camera_link0: topic /tf_static -> /tf: frames",
        "camera_connect_joint type fixed -> revolute: urdf, urdf_sim, mjcf, robot_model",
    ]
    assert {" ".join(line.split()[:2]).rstrip(":") for line in said[2:]} <= {
        "contact pair",
        "contact pairs",
        "excluded contacts",
    }


def test_a_frame_that_another_node_publishes_now_changes_places(tmp_path: Path) -> None:
    publisher = "    publisher: {static_transform_publisher: tf_base_laser}\n"
    assert meaning(described(tmp_path, ("lidar_and_imu.yaml", publisher, ""))) == [
        "new: link laser (on base_link, published by robot_state_publisher; and therefore the shapes of base_link):"
        " urdf",
        "removed: frame laser (on base_link, published by tf_base_laser): static_tf, static_tf_json",
        "laser: published by tf_base_laser -> robot_state_publisher: frames",
    ]


def test_inertials_that_an_artifact_gets_are_a_line_a_link(tmp_path: Path) -> None:
    comparison = described(tmp_path, ("robot.yaml", "elements: [collision]", "elements: [collision, inertial]"))
    assert meaning(comparison)[:2] == ["base_link mass: new, 1.11294 kg: urdf", "link1 mass: new, 0.0105973 kg: urdf"]
    assert len(comparison.changes) == 9
