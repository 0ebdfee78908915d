"""What a change of the description does to the artifacts is said by meaning, in exact words."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
import yaml

from support.comparing import block, described, meaning
from support.paths import data_text

CHANGES = yaml.safe_load(data_text("cases/compare_changes.yaml"))


@pytest.mark.slow
@pytest.mark.parametrize("change", CHANGES, ids=lambda change: change["id"])
def test_a_change_of_the_description_is_named(change: dict[str, Any], tmp_path: Path) -> None:
    comparison = described(tmp_path, (change["file"], change["old"], change["new"]))
    assert meaning(comparison) == change["said"]
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
