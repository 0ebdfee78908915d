"""What each format reads of an artifact that has everything in it: the facts, their units, and how well they are known.

What is not read back is not compared, either: ``check`` and ``diff`` would not see it change.
"""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from rosorin_compile.formats import FORMATS, Value
from support.paths import DATA

HERE = DATA / "facts"
READ = {"robot.urdf": "urdf", "robot.sdf": "sdf", "robot.xml": "mjcf", "robot.srdf": "srdf"}


def said(value: Value) -> str:
    """Return a value with its unit, and its tolerance to two digits."""
    if isinstance(value.value, str):
        return value.value
    tolerance = f"+- {value.tolerance:.2g}" if value.tolerance else ""
    number = round(value.value, 12) + 0.0  # what rounding leaves of a zero differs from machine to machine
    return " ".join(filter(None, [f"{number:.6g}", value.unit, tolerance]))


def lines(path: Path) -> list[str]:
    """Return the facts of an artifact, a line each."""
    read = FORMATS[READ[path.name]].facts
    assert read is not None
    facts = read(path.read_text("utf-8"))
    return [f"{fact.kind} {fact.name}: {fact.quantity}: {said(value)}" for fact, value in facts.items()]


@pytest.mark.parametrize("name", READ)
def test_all_that_an_artifact_says_is_read(name: str) -> None:
    assert sorted(lines(HERE / name)) == sorted((HERE / f"{name}.txt").read_text("utf-8").splitlines())


@pytest.mark.parametrize(
    ("name", "old", "new", "told"),
    [
        ("robot.sdf", "<model ", "<other ", "mismatched tag"),
        ("robot.sdf", ' name="r"', "", "<model> has no name"),
        ("robot.sdf", "<mass>2</mass>", "", "<inertial> has no <mass>"),
        ("robot.sdf", "<mass>2</mass>", "<mass>2 3</mass>", "<mass> of <inertial>: 1 numbers are needed"),
        ("robot.sdf", "<ixx>1</ixx>", "<ixx>nan</ixx>", "not a number: nan"),
        ("robot.sdf", "0.1 0.2 0.3 0 0 0.5", "0.1 0.2 0.3", "<pose> of <inertial>: 6 numbers are needed"),
        ("robot.sdf", "<box>", "<sphere/><box>", "collision 1 of link base has not one geometry"),
        ("robot.sdf", "<geometry><box>", "<geometry/><geometry><box>", "collision 1 of link base has not one geometry"),
        ("robot.sdf", "<multiplier>2</multiplier>", "", "<mimic> has no <multiplier>"),
        ("robot.urdf", "<mass value=", "<mass of=", "<mass> has no value"),
        ("robot.urdf", '<child link="hand"/>', "", "<joint> has no <child>"),
        ("robot.urdf", '<child link="hand"/>', '<child link="nobody"/>', "the child of joint wrist is no link"),
        ("robot.urdf", 'ixx="1"', 'ixx="inf"', "not a number: inf"),
        ("robot.urdf", '"0.01 0.02 0.03"', '"0.01 0.02"', '<origin xyz="0.01 0.02">: 3 numbers are needed'),
        ("robot.urdf", "<box ", "<sphere/><box ", "collision 1 of link base has 2 geometries"),
        ("robot.urdf", "<box ", "<ellipsoid ", "URDF has no <ellipsoid>"),
        ("robot.srdf", ' type="planar"', "", "<virtual_joint> has no type"),
        ("robot.srdf", ' link2="mast"', "", "<disable_collisions> has no link2"),
        ("robot.xml", '"box" size="0.1', '"box" size="1 0.1', "3 numbers are needed"),
        ("robot.xml", 'mesh="big"', 'mesh="small"', "there is no mesh small"),
    ],
)
def test_what_is_damaged_is_a_value_error(name: str, old: str, new: str, told: str) -> None:
    text, read = (HERE / name).read_text("utf-8"), FORMATS[READ[name]].facts
    assert read is not None
    assert old in text
    with pytest.raises(ValueError, match=re.escape(told)):
        read(text.replace(old, new, 1))


@pytest.mark.parametrize(
    ("format", "text", "told"),
    [
        ("sdf", "<sdf/>", "there is no <model>"),
        ("sdf", "<robot/>", "the root element is robot, not sdf"),
        (
            "sdf",
            '<sdf><model name="r"><link name="a"><inertial><mass>1</mass></inertial></link></model></sdf>',
            "the inertial of link a has no <inertia>",
        ),
        ("urdf", "<sdf/>", "the root element is sdf, not robot"),
        ("srdf", "<sdf/>", "the root element is sdf, not robot"),
        ("mjcf", "<mujoco/>", "there is no <worldbody>"),
    ],
)
def test_what_lacks_its_frame_is_a_value_error(format: str, text: str, told: str) -> None:
    read = FORMATS[format].facts
    assert read is not None
    with pytest.raises(ValueError, match=re.escape(told)):
        read(text)
