"""The prefix of a foreign robot, in elements of XML that are kept as they are."""

from __future__ import annotations

from collections import Counter

import pytest

from rosorin_compile.frontend.expand.prefixing import _Renamer


@pytest.mark.parametrize(
    "made",
    [
        '<ros2_control name="l_board"/>',
        '<ros2_control name="l_b"><gpio name="l_io"/></ros2_control>',
        '<ros2_control name="l_b"><sensor name="l_s"/></ros2_control>',
        '<transmission name="l_t"><actuator name="l_m"/></transmission>',
        '<gazebo reference="l_arm"><sensor name="s"/></gazebo>',
        '<gazebo><material name="l_grey"/></gazebo>',
        '<gazebo><material name="arm"/></gazebo>',
        "<gazebo><link>l_arm</link></gazebo>",
        "<gazebo><link>arm_2</link></gazebo>",
        "<gazebo><topicName>arm</topicName></gazebo>",
        '<gazebo topic="arm" link="l_arm"/>',
        '<joint name="l_arm"><param name="arm">l_arm</param></joint>',
        '<a link="grey"/>',
    ],
)
def test_names_of_the_robot_get_the_prefix_and_nothing_else(made: str) -> None:
    changed: Counter[str] = Counter()
    assert _Renamer("l_", {"arm"}, {"grey"}, changed).elements(made.replace("l_", "")) == made
    assert changed.total() == made.count("l_")
