"""Hardware blocks of ros2_control in a URDF: in the words of Humble and in those of Jazzy, where they are asked for.

The blocks of tests/data/control stand beside the robot, by distribution.
"""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from rosorin_compile.formats.compiled import compile_robot
from rosorin_compile.source.diagnostics import ERROR, has_errors
from support.paths import DATA

ROBOT = DATA / "control" / "gripper.yaml"


def texts(path: Path, distribution: str) -> dict[str, str]:
    made = compile_robot(path, {"distribution": distribution})
    assert not has_errors(made.diagnostics), [one.message for one in made.diagnostics if one.severity == ERROR]
    return {artifact.file: artifact.text for artifact in made.artifacts}


def blocks(text: str) -> str:
    return "".join(re.findall(r" *<ros2_control.*?</ros2_control>\n", text, re.DOTALL))


@pytest.mark.parametrize("distribution", ["humble", "jazzy"])
def test_the_block(distribution: str) -> None:
    text = texts(ROBOT, distribution)["gripper.urdf"]
    assert blocks(text) == (ROBOT.parent / f"{distribution}.xml").read_text("utf-8")


def test_later_distributions_have_the_block_of_jazzy() -> None:
    assert texts(ROBOT, "rolling")["gripper.urdf"] == texts(ROBOT, "jazzy")["gripper.urdf"]


def test_a_urdf_that_does_not_ask_has_none() -> None:
    assert "ros2_control" not in texts(ROBOT, "jazzy")["plain.urdf"]


def test_the_robot_is_the_same_with_the_block() -> None:
    with_block = texts(ROBOT, "jazzy")
    assert with_block["gripper.urdf"].replace(blocks(with_block["gripper.urdf"]), "") == with_block["plain.urdf"]


def test_what_only_jazzy_reads_is_an_attribute_there(tmp_path: Path) -> None:
    path = tmp_path / "robot.yaml"
    text = ROBOT.read_text("utf-8").replace(
        "pose: open\n", "pose: open\n    rate: 50\n    async: true\n    group: tools\n"
    )
    path.write_text(text, "utf-8")
    assert (
        '<ros2_control name="hand" type="system" rw_rate="50" is_async="true">' in texts(path, "jazzy")["gripper.urdf"]
    )
    assert '<ros2_control name="hand" type="system">' in texts(path, "humble")["gripper.urdf"]


def test_names_in_a_part_have_its_prefix(tmp_path: Path) -> None:
    (tmp_path / "hand.yaml").write_text(
        """parts:
  hand:
    links: {finger: {}}
    joints:
      grip:
        {type: prismatic, parent: mount, child: finger, axis: [0, 1, 0],
          limit: {lower: 0, upper: 0.04, effort: 20, velocity: 0.1}}
    poses: {open: {positions: {grip: 0.03}}}
    control:
      hand:
        plugin: mock_components/GenericSystem
        pose: open
        joints: {grip: {command: position, state: position}}
        gpio: {lamp: {state: temperature}}
""",
        "utf-8",
    )
    path = tmp_path / "robot.yaml"
    path.write_text(
        """robot: two
args: {distribution: {type: text, default: jazzy}}
include: [hand.yaml]
links: {base_link: {}}
use:
  left: {part: hand, parent: base_link, prefix: left_}
  right: {part: hand, parent: base_link, prefix: right_, xyz: [0, 1, 0]}
outputs: {urdf: {file: two.urdf, control: jazzy}}
""",
        "utf-8",
    )
    text = texts(path, "jazzy")["two.urdf"]
    names = re.findall(r'<(?:ros2_control|gpio) name="(\w+)"', text)
    assert names == ["left_hand", "left_lamp", "right_hand", "right_lamp"]
    assert re.findall(r'<joint name="(\w+)">', blocks(text)) == ["left_grip", "right_grip"]
    assert text.count('<param name="initial_value">0.03</param>') == 2
