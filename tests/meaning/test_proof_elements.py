"""What two spellings of elements say: the same, or what is lost and what is new, in words."""

from __future__ import annotations

import pytest

from rosorin_compile.formats.gazebo_elements import element_differences

SENSOR = '<gazebo reference="eye"><sensor name="s" type="camera"><camera>{}</camera></sensor></gazebo>'
LIDAR = '<gazebo reference="l"><sensor name="s" type="gpu_lidar">{}<topic>scan</topic></sensor></gazebo>'
MU = "<gazebo reference='a'><mu1>{}</mu1></gazebo>"


@pytest.mark.parametrize(
    ("one", "other", "said"),
    [
        (MU.format("0.2"), MU.format(" 0.20"), []),
        (
            MU.format("0.2"),
            MU.format("0.3"),
            ['<mu1> of <gazebo reference="a"> is lost', '<mu1> of <gazebo reference="a"> is new'],
        ),
        ("<gazebo><static>1</static></gazebo>", "", ["<static> of <gazebo> is lost"]),
        ("", "<link_extra a='1'/>", ['<link_extra a="1.0"/> is new']),
        (SENSOR.format("<a>-0.0</a>"), SENSOR.format("<a>0</a>"), []),
        # Zero is taken by default in the frame of the link, not in another one.
        (LIDAR.format("<pose>0 0 0 0 0 0</pose>"), LIDAR.format(""), []),
        (
            LIDAR.format("<pose relative_to='eye'>0 0 0 0 0 0</pose>"),
            LIDAR.format(""),
            ['<sensor> of <gazebo reference="l"> is lost', '<sensor> of <gazebo reference="l"> is new'],
        ),
        ("<gazebo><sensor/></gazebo>", "", ["<sensor> of <gazebo> is lost"]),
        ("<ros2_control name='c' type='system'/>", "", ['<ros2_control name="c"> is lost']),
        # A lidar has two names, which do not stand at one place of the alphabet.
        (
            LIDAR.format("<ray><scan/></ray><pose>1 0 0 0 0 0</pose>"),
            LIDAR.format("<pose>1 0 0 0 0 0</pose><lidar><scan/></lidar>"),
            [],
        ),
        # What has another name may stand before or behind, what has the same one may not.
        (SENSOR.format("<a>1</a><b>2</b>"), SENSOR.format("<b>2</b><a>1</a>"), []),
        (
            SENSOR.format("<a>2</a><a>1</a>"),
            SENSOR.format("<a>1</a><a>2</a>"),
            ['<sensor> of <gazebo reference="eye"> is lost', '<sensor> of <gazebo reference="eye"> is new'],
        ),
    ],
)
def test_what_elements_say(one: str, other: str, said: list[str]) -> None:
    assert element_differences([one], [other]) == said
