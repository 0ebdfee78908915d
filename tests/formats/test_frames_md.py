"""frames.md: every edge once, its numbers as they are, in a table that holds whatever the names are."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rosorin_compile.compare.precision import exact, printed_precision
from rosorin_compile.compare.walk import compare_leaves, leaves
from rosorin_compile.formats import frames
from rosorin_compile.formats.templating import Templates
from rosorin_compile.model import (
    STATIC_TRANSFORM_PUBLISHER,
    Box,
    Edge,
    HeightMap,
    Joint,
    Limit,
    Link,
    Output,
    Pose,
    Publisher,
    Robot,
    Shape,
)
from rosorin_compile.model.joint import NODE, UNPUBLISHED
from rosorin_compile.model.link import Source
from rosorin_compile.model.robot import JointPose
from support.reading import leaves_of

EKF = Publisher(NODE, "ekf", "robot_localization", "publish_tf: true")
CAMERA = Publisher(NODE, "camera_driver")
STAND_IN = Source("stand_in", "nobody measured | it")
TESTER = Robot(
    "tester",
    (
        *map(Link, ("base", "arm", "slide", "claw", "depth_optical")),
        Link("laser", collision=(Shape(Box((0, 0, 0), (1, 1, 1)), name="housing", stand_in="no drawing"),)),
        Link("floor", collision=(Shape(HeightMap((0, 0), 1, ((1,),), 1), stand_in="no mesh"),)),
    ),
    (
        Joint(
            "floor_joint", "fixed", "floor", "base", Pose((0, 0, 0.1)), publisher=Publisher(UNPUBLISHED, about="odom")
        ),
        Joint(
            "arm_joint", "revolute", "base", "arm", Pose((0.1, -0.2, 7.5e-05), (0, 0, math.pi / 2)), limit=Limit(-1, 1)
        ),
        Joint("slide_joint", "prismatic", "arm", "slide", limit=Limit(0, 1), source=STAND_IN),
        Joint("claw_joint", "revolute", "arm", "claw", publisher=Publisher(UNPUBLISHED)),
        Joint(
            "laser_joint",
            "fixed",
            "base",
            "laser",
            Pose((1 / 3, 0, 0), (-0.0, 0, math.pi)),
            publisher=Publisher(STATIC_TRANSFORM_PUBLISHER, "tf_laser"),
            source=STAND_IN,
        ),
        Joint("optical_joint", "fixed", "laser", "depth_optical", Pose(rpy=(-3.1416, -1.5, 3.1416))),
    ),
    edges=(
        Edge("odom", "base", EKF, moving=True),
        Edge("map", "odom", Publisher(NODE, "slam_toolbox"), moving=True, when="slam"),
        Edge("map", "odom", Publisher(NODE, "amcl"), moving=True, when="not slam"),
        Edge("depth_optical", "rgb", CAMERA, moving=False, pose=Pose((0.015, 0, 0))),
        Edge("rgb", "lost", Publisher(UNPUBLISHED), moving=False),
    ),
    poses=(JointPose("tuck", {"arm_joint": 0.4, "slide_joint": 0.25}, {"arm_joint": 600}, source=Source("measured")),),
    modes=("slam",),
    source=Source("factory", "the maker", "2026-01-02"),
)


def emit(robot: Robot, number_format: str = "exact") -> str:
    output = Output("frames", "frames", "frames.md", {"number_format": number_format})
    text, diagnostics = frames.write(robot, output, Templates())
    assert diagnostics == []
    return text


def test_reading_gives_back_the_rows() -> None:
    for number_format in ("exact", "six"):
        output = Output("frames", "frames", "frames.md", {"number_format": number_format})
        text = emit(TESTER, number_format)
        found = leaves(frames.view(TESTER, output)), leaves(frames.read(text))
        assert compare_leaves(*found, (exact, printed_precision(text))) == []
    found = leaves_of("frames", emit(TESTER))
    origin = found["frame", "laser", "origin"]
    assert origin == Pose((1 / 3, *origin.xyz[1:]), (0, 0, math.pi))
    assert found["frame", "base below odom", "publisher"] == "ekf"
    assert found["frame", "odom when not slam", "publisher"] == "amcl"
    assert ("frame", "odom when slam", "origin") not in found
    assert found["pose", "tuck", "slide_joint"] == 0.25


names = st.from_regex(r"[^\s<>&\"'/\x00-\x1f\ud800-\udfff]{1,10}", fullmatch=True).filter(lambda n: not n.isspace())


@given(names, names, names, st.tuples(*[st.floats(-10, 10)] * 3), st.text(max_size=20))
@settings(max_examples=300, deadline=None)
def test_any_name_survives_the_table(
    parent: str, child: str, node: str, xyz: tuple[float, float, float], note: str
) -> None:
    joint = Joint("j", "fixed", parent, child + "2", Pose(xyz), publisher=Publisher(NODE, node), source=STAND_IN)
    joint = replace(joint, source=Source("stand_in", note))
    robot = Robot(parent, (Link(parent), Link(child + "2")), (joint,), poses=(JointPose(node, {"j": xyz[0]}),))
    text = emit(robot)
    assert frames.read(text) == frames.view(robot, Output("frames", "frames", "frames.md"))


@pytest.mark.parametrize("text", ["", "# Frames\n", "| parent |\n", emit(TESTER).replace("1.5707963267948966", "x")])
def test_a_damaged_list_is_a_value_error(text: str) -> None:
    with pytest.raises(ValueError):  # noqa: PT011 - the kind is the promise
        frames.read(text)
