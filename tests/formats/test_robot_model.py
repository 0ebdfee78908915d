"""The driver's model: one line, the fields that its reader knows, full precision, and nothing left out in silence."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest

from rosorin_compile.compare.walk import compare_leaves, leaves
from rosorin_compile.formats import robot_model
from rosorin_compile.formats.templating import Templates
from rosorin_compile.model import Box, HeightMap, Inertial, Joint, Limit, Link, Output, Pose, Robot, Shape
from rosorin_compile.model.link import Source
from rosorin_compile.model.servos import ServoGroup
from support.reading import leaves_of

BOX = Box((-0.1, -0.2, -0.3), (0.1, 0.2, 0.4))
MAP = HeightMap((-0.5, -0.25), 0.5, ((0.1, 0.0), (0.2, 0.3)), 0.1, "by hand")
SERVOS = ServoGroup("arm", ("shoulder",), math.radians(0.24), 500, True, (0, 1000))
TESTER = Robot(
    "tester",
    (
        Link("floor", collision=(Shape(MAP, stand_in="the mesh is missing"),)),
        Link("base"),
        Link("upper", Inertial(1.0, Pose(), 1.0, 1.0, 1.0), collision=(Shape(BOX),)),
        Link("eye", collision=(Shape(BOX, Pose((1.0, 0.0, -0.0), (0.0, 0.0, math.pi / 2))),)),
        Link("rail"),
        Link("wheel"),
    ),
    (
        Joint("floor_joint", "fixed", "floor", "base", Pose((0.0, -0.0, 0.1))),
        Joint("shoulder", "revolute", "base", "upper", Pose((0.1, 0.2, 1 / 3)), (0.0, 1.0, -0.0), Limit(-1, 2, 3, 4)),
        Joint("eye_joint", "fixed", "upper", "eye", Pose(rpy=(0.0, 0.0, math.pi)), axis=(1.0, 0.0, 0.0)),
        Joint("rail_joint", "prismatic", "base", "rail", limit=Limit(0.0, 0.5, 1.0, 1.0)),
        Joint("wheel_joint", "continuous", "base", "wheel", limit=Limit(effort=1.0, velocity=1.0)),
    ),
    servos=(SERVOS,),
    source=Source("measured", "measured by hand"),
)


def test_numbers_are_floats_also_where_whole_numbers_were_written() -> None:
    whole = replace(TESTER.joints[1], origin=Pose((1, 2, 3)), axis=(0, 0, 1), limit=Limit(-1, 1, 1, 1))  # type: ignore[arg-type]
    text = robot_model.write(replace(TESTER, joints=(whole,)), Output("m", "robot_model", "m"), Templates())[0]
    assert '"xyz": [1.0, 2.0, 3.0], "rpy": [0.0, 0.0, 0.0], "axis": [0.0, 0.0, 1.0], "limit": [-1.0, 1.0]' in text


def test_reading_gives_back_every_number() -> None:
    output = Output("m", "robot_model", "m", {"rename": {"eye": "camera"}})
    text = robot_model.write(TESTER, output, Templates())[0]
    assert compare_leaves(leaves(robot_model.view(TESTER, output)), leaves(robot_model.read(text))) == []
    found = leaves_of("robot_model", text)
    assert found["frame", "camera", "origin"].rpy[2] == math.pi
    assert found["joint", "shoulder", "limit upper"] == 2.0
    assert found["joint", "shoulder", "axis"] == (0.0, 1.0, 0.0)
    assert found["height map", "floor", "heights"][1][0] == 0.2
    assert found["height map", "floor", "stand_in"] == "the mesh is missing"
    assert {name for kind, name, _ in found if kind == "servo"} == {"pulse_to_rad"}


GOOD = robot_model.write(TESTER, Output("m", "robot_model", "m"), Templates())[0]
DAMAGED = {
    "cut off": GOOD[:-20],
    "a list": "[]",
    "a number": "1",
    "no joints": GOOD.replace('"joints": {"floor', '"joint": {"floor'),
    "two numbers": GOOD.replace("[0.1, 0.2, 0.3333333333333333]", "[0.1, 0.2]"),
    "two numbers of an axis": GOOD.replace("[0.0, 1.0, 0.0]", "[0.0, 1.0]"),
    "four numbers of an axis": GOOD.replace("[0.0, 1.0, 0.0]", "[0.0, 1.0, 0.0, 0.0]"),
    "one limit": GOOD.replace("[-1.0, 2.0]", "[-1.0]"),
    "text for a number": GOOD.replace("0.3333333333333333", '"high"'),
    "deep": "[" * 100000,
}


@pytest.mark.parametrize("text", DAMAGED.values(), ids=DAMAGED)
def test_a_damaged_model_is_a_value_error(text: str) -> None:
    assert text != GOOD
    with pytest.raises(ValueError):  # noqa: PT011 - the kind is the promise
        robot_model.read(text)


@pytest.mark.parametrize("number", ["0.3333333333333333", "0.4]", "0.3]"])
def test_an_endless_number_is_refused(number: str) -> None:
    """JSON has no word for it, but 1e999 is read as one; no comparison would come to an end with it."""
    text = GOOD.replace(number, f"1e999{number.lstrip('.0123456789')}", 1)
    assert text != GOOD
    with pytest.raises(ValueError, match="finite"):
        robot_model.read(text)
