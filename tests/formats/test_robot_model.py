"""The driver's model: one line, the fields that its reader knows, full precision, and nothing left out in silence."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import jsonschema
import pytest

from rosorin_compile.compare.walk import walk
from rosorin_compile.formats import robot_model
from rosorin_compile.formats.templating import Templates
from rosorin_compile.model import Box, Cylinder, HeightMap, Inertial, Joint, Limit, Link, Output, Pose, Robot, Shape
from rosorin_compile.model.joint import Mimic
from rosorin_compile.model.link import Source
from rosorin_compile.model.servos import ServoGroup
from rosorin_compile.source.diagnostics import Diagnostic
from support.reading import leaves_of
from support.schemas import schema

SCHEMA = schema("robot_model")
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


def emit(robot: Robot, options: Mapping[str, Any] | None = None) -> tuple[dict[str, Any], list[Diagnostic]]:
    """Return the model that a robot gets, valid by its schema, and what is said about it."""
    text, diagnostics = robot_model.write(
        robot, Output("robot_model", "robot_model", "m.json", options or {}), Templates()
    )
    assert text.count("\n") == 1
    assert text.endswith("\n")
    assert "-0.0," not in text
    assert "-0.0]" not in text
    model = json.loads(text)
    jsonschema.validate(model, SCHEMA)
    return model, diagnostics


def said(robot: Robot, options: Mapping[str, Any] | None = None) -> list[str]:
    """Return the rules and messages of what is said about the model of a robot."""
    return [f"{d.rule}: {d.message}" for d in emit(robot, options)[1]]


def with_collision(name: str, *shapes: Shape) -> Robot:
    links = tuple(replace(link, collision=shapes) if link.name == name else link for link in TESTER.links)
    return replace(TESTER, links=links)


def test_everything_in_its_place() -> None:
    model, diagnostics = emit(TESTER)
    assert diagnostics == []
    assert list(model) == ["source", "pulse_to_rad", "joints", "boxes", "chassis_heightmap"]
    assert model["source"] == "measured by hand"
    pulses = {"joints": ["shoulder"], "rad_per_pulse": 0.0041887902047863905, "zero": 500, "flipped": True}
    assert model["pulse_to_rad"] == pulses
    assert list(model["joints"]) == ["floor_joint", "shoulder", "eye_joint", "rail_joint", "wheel_joint"]
    shoulder = model["joints"]["shoulder"]
    assert list(shoulder) == ["type", "parent", "child", "xyz", "rpy", "axis", "limit"]
    assert shoulder["xyz"] == [0.1, 0.2, 1 / 3]
    assert (shoulder["axis"], shoulder["limit"]) == ([0.0, 1.0, 0.0], [-1.0, 2.0])
    eye = model["joints"]["eye_joint"]
    assert (eye["axis"], eye["limit"], eye["rpy"]) == ([0.0, 0.0, 0.0], None, [0.0, 0.0, math.pi])
    assert model["joints"]["rail_joint"]["limit"] == [0.0, 0.5]
    assert model["joints"]["wheel_joint"]["limit"] is None


def test_boxes_are_along_the_axes_of_their_link() -> None:
    boxes = emit(TESTER)[0]["boxes"]
    assert list(boxes) == ["upper", "eye"]
    assert boxes["upper"] == {"min": [-0.1, -0.2, -0.3], "max": [0.1, 0.2, 0.4]}
    assert boxes["eye"] == {"min": [0.8, -0.1, -0.3], "max": [1.2, 0.1, 0.4]}


def test_a_height_map_stands_in_its_frame_and_says_what_is_missing() -> None:
    found = emit(TESTER)[0]["chassis_heightmap"]
    assert list(found) == ["frame", "origin_xy", "cell", "method", "stand_in", "z"]
    assert found == {
        "frame": "floor",
        "origin_xy": [-0.5, -0.25],
        "cell": 0.5,
        "method": "by hand",
        "stand_in": "the mesh is missing",
        "z": [[0.1, 0.0], [0.2, 0.3]],
    }
    known = with_collision("floor", Shape(MAP))
    assert "stand_in" not in emit(known)[0]["chassis_heightmap"]
    assert "chassis_heightmap" not in emit(with_collision("floor"))[0]


def test_numbers_are_floats_also_where_whole_numbers_were_written() -> None:
    whole = replace(TESTER.joints[1], origin=Pose((1, 2, 3)), axis=(0, 0, 1), limit=Limit(-1, 1, 1, 1))  # type: ignore[arg-type]
    text = robot_model.write(replace(TESTER, joints=(whole,)), Output("m", "robot_model", "m"), Templates())[0]
    assert '"xyz": [1.0, 2.0, 3.0], "rpy": [0.0, 0.0, 0.0], "axis": [0.0, 0.0, 1.0], "limit": [-1.0, 1.0]' in text


def test_joints_are_chosen_and_ordered_and_links_renamed() -> None:
    options = {"joints": ["eye_joint", "shoulder"], "rename": {"eye": "camera", "base": "body"}, "source": "elsewhere"}
    model, diagnostics = emit(TESTER, options)
    assert diagnostics == []
    assert model["source"] == "elsewhere"
    assert list(model["joints"]) == ["eye_joint", "shoulder"]
    assert (model["joints"]["eye_joint"]["parent"], model["joints"]["eye_joint"]["child"]) == ("upper", "camera")
    assert model["joints"]["shoulder"]["parent"] == "body"
    assert list(model["boxes"]) == ["camera", "upper"]
    assert "chassis_heightmap" not in model


def test_the_height_map_is_renamed_too() -> None:
    assert emit(TESTER, {"rename": {"floor": "ground"}})[0]["chassis_heightmap"]["frame"] == "ground"


def test_a_robot_of_one_link() -> None:
    model, diagnostics = emit(Robot("block", (Link("block", collision=(Shape(BOX),)),), ()))
    assert diagnostics == []
    assert model == {
        "source": "",
        "joints": {},
        "boxes": {"block": {"min": [-0.1, -0.2, -0.3], "max": [0.1, 0.2, 0.4]}},
    }


def test_one_of_several_servo_groups_is_named() -> None:
    other = replace(SERVOS, name="hand", zero_pulse=400)
    two = replace(TESTER, servos=(SERVOS, other))
    assert said(two) == ["robot-model-servos: pulse_to_rad has room for one servo group, the robot has arm, hand"]
    model, diagnostics = emit(two, {"servos": "hand"})
    assert diagnostics == []
    assert model["pulse_to_rad"]["zero"] == 400
    assert "pulse_to_rad" not in emit(replace(TESTER, servos=()))[0]


def test_unknown_names_are_errors() -> None:
    options = {"joints": ["sholder"], "rename": {"ey": "x"}, "servos": "leg"}
    _, diagnostics = emit(TESTER, options)
    assert {d.severity for d in diagnostics} == {"error"}
    words = [("sholder", "shoulder"), ("ey", "eye"), ("leg", "arm")]
    for found, (word, meant) in zip(diagnostics, words, strict=True):
        assert f'"{word}"' in found.message
        assert meant in found.worded().help


def test_two_links_never_share_a_name() -> None:
    assert said(TESTER, {"rename": {"eye": "upper"}}) == [
        'robot-model-same-name: links upper and eye would both be called "upper" in this artifact'
    ]


LEFT_OUT = "robot-model-cannot-say: the collision of link {} is not in robot_model: {}"
ONE_BOX = "the format has room for one box along the axes"


@pytest.mark.parametrize(
    ("link", "shapes", "message"),
    [
        ("upper", [Shape(Cylinder(0.1, 0.2))], f"a cylinder: {ONE_BOX}"),
        ("upper", [Shape(BOX), Shape(BOX)], f"2 shapes: {ONE_BOX}"),
        ("upper", [Shape(BOX, Pose(rpy=(0.1, 0.0, 0.0)))], f"a box that is turned: {ONE_BOX}"),
        ("floor", [Shape(MAP, Pose((0.0, 0.0, 0.1)))], "a height map that is not in the frame of its link"),
        ("floor", [Shape(MAP), Shape(MAP)], "a second height map: the format has room for one"),
    ],
)
def test_what_the_format_cannot_say_is_said(link: str, shapes: list[Shape], message: str) -> None:
    changed = with_collision(link, *shapes)
    assert said(changed) == [LEFT_OUT.format(link, message)]
    assert link not in emit(changed)[0]["boxes"]


def test_a_mimic_is_said() -> None:
    joints = [replace(j, mimic=Mimic("shoulder")) if j.name == "rail_joint" else j for j in TESTER.joints]
    follower = replace(TESTER, joints=tuple(joints))
    assert said(follower) == [
        "robot-model-cannot-say: robot_model has no word for mimic: "
        "joint rail_joint is written as if it moved by itself"
    ]
    assert said(follower, {"joints": ["shoulder"]}) == []


def test_reading_gives_back_every_number() -> None:
    output = Output("m", "robot_model", "m", {"rename": {"eye": "camera"}})
    text = robot_model.write(TESTER, output, Templates())[0]
    assert walk(robot_model.view(TESTER, output), robot_model.read(text)) == []
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
