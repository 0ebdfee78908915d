"""A part may say what drives the robot: joints get the names that they have outside, mirrored wheels the other side."""

from __future__ import annotations

from pathlib import Path

import pytest

from rosorin_compile.model import Robot
from rosorin_compile.model.drive import Twist, drive_kinematics
from support.robots import compiled_text, sound

WHEEL = (
    "{inertial: {mass: 0.2, of: collision}, collision: [{cylinder: {radius: 5 cm, length: 2 cm}, rpy: [90 deg, 0, 0]}]}"
)
HEAD = f"""\
robot: courier
outputs: {{urdf: {{file: courier.urdf}}}}
parts:
  two_wheels:
    params: {{track: {{type: length, default: 30 cm}}}}
    links:
      base: {{inertial: {{mass: 5, of: collision}}, collision: [{{box: {{size: [0.4, 0.2, 0.06]}}}}]}}
      left_wheel: {WHEEL}
      right_wheel: {WHEEL}
    joints:
      hold: {{type: fixed, parent: mount, child: base, xyz: [0, 0, 5 cm]}}
      left: {{type: continuous, parent: base, child: left_wheel, xyz: [0, "${{track / 2}}", 0], axis: [0, 1, 0]}}
      right: {{type: continuous, parent: base, child: right_wheel, xyz: [0, "${{-track / 2}}", 0], axis: [0, 1, 0]}}
    drive:
      differential: {{left: [left], right: [right]}}
      frame: base
  four_wheels:
    links:
      "${{end}}_${{side}}_wheel": {{for: {{end: [front, rear], side: [left, right]}}, value: {WHEEL}}}
    joints:
      "${{end}}_${{side}}":
        for: {{"end, x": [[front, 0.2], [rear, -0.2]], "side, y": [[left, 0.15], [right, -0.15]]}}
        type: continuous
        parent: mount
        child: ${{end}}_${{side}}_wheel
        xyz: ["${{x}}", "${{y}}", 0.05]
        axis: [0, 1, 0]
    drive:
      mecanum: {{front_left: front_left, front_right: front_right, rear_left: rear_left, rear_right: rear_right}}
  courier:
    use: {{mobile: {{part: two_wheels, parent: mount, prefix: mb_, with: {{track: 40 cm}}}}}}
links: {{footprint: {{inertial: {{mass: 1, of: [{{box: {{size: [0.1, 0.1, 0.1]}}}}]}}}}}}
"""


def used(folder: Path, use: str) -> Robot:
    return sound(compiled_text(folder, f"{HEAD}use: {{{use}}}\n"))[0]


@pytest.mark.parametrize(
    ("use", "prefix"),
    [
        ("mobile: {part: two_wheels, parent: footprint, with: {track: 40 cm}}", "mobile_"),
        ('mobile: {part: two_wheels, parent: footprint, prefix: "", with: {track: 40 cm}}', ""),
        ("a: {part: courier, parent: footprint}", "a_mb_"),
    ],
)
def test_the_joints_of_a_drive_have_the_prefix_of_its_part(tmp_path: Path, use: str, prefix: str) -> None:
    robot = used(tmp_path, use)
    assert robot.drive is not None
    assert dict(robot.drive.joints) == {"left": (f"{prefix}left",), "right": (f"{prefix}right",)}
    assert robot.drive.frame == f"{prefix}base"
    speeds = drive_kinematics(robot).speeds(Twist(wz=1.0))
    assert speeds == pytest.approx({f"{prefix}left": -0.2 / 0.05, f"{prefix}right": 0.2 / 0.05})


@pytest.mark.parametrize(
    ("mirror", "swapped"), [("y", {"left": "right", "right": "left"}), ("x", {"front": "rear", "rear": "front"})]
)
def test_a_mirrored_drive_has_its_wheels_on_the_other_side(
    tmp_path: Path, mirror: str, swapped: dict[str, str]
) -> None:
    robot = used(tmp_path, f"m: {{part: four_wheels, parent: footprint, mirror: {mirror}}}")
    assert robot.drive is not None
    for role, (joint,) in robot.drive.joints.items():
        words = joint.removeprefix("m_").split("_")
        assert role == "_".join(swapped.get(word, word) for word in words)
        x, y, _ = robot.joint[joint].origin.xyz
        assert (x > 0, y > 0) == (role.startswith("front"), role.endswith("left"))
