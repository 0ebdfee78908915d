"""``name:=`` without a value, which launch files pass: an empty text, or not given."""

from __future__ import annotations

from pathlib import Path

import pytest

from rosorin_compile.formats.compiled import compile_robot
from rosorin_compile.source.diagnostics import text

ROBOT = """\
robot: r
args:
  prefix: {type: text, default: left_}
  lidar: {type: boolean, default: true}
  height: {type: length, default: 20 cm}
  kind: {default: a}
  mass: {type: mass}
links: {"${prefix}base_${kind}_${lidar}_${height * 100}_${mass}": {}}
outputs: {urdf: {file: r.urdf}}
"""


@pytest.fixture
def robot(tmp_path: Path) -> Path:
    (tmp_path / "robot.yaml").write_text(ROBOT, "utf-8")
    return tmp_path / "robot.yaml"


def test_an_empty_text_is_one_and_anything_else_is_not_given(robot: Path) -> None:
    made = compile_robot(robot, {"prefix": "", "lidar": "", "height": "", "kind": "", "mass": "1"})
    assert made.robot is not None, text(made.diagnostics)
    assert [link.name for link in made.robot.links] == ["base_a_true_20_1"]


def test_what_has_no_default_is_missing(robot: Path) -> None:
    found = compile_robot(robot, {"mass": ""}).diagnostics
    assert [one.rule for one in found] == ["missing-argument"]


def test_a_name_that_is_no_argument_is_told_all_the_same(robot: Path) -> None:
    found = compile_robot(robot, {"mass": "1", "hight": ""}).diagnostics
    assert [one.rule for one in found] == ["unknown-argument"]
