"""Boxes that fill the same space are no difference, however a height map was cut; any other space is."""

from __future__ import annotations

from pathlib import Path

import pytest

from support.comparing import compared
from support.paths import data_text
from support.robots import compiled_text

ROBOT = data_text("robots/same_space_robot.yaml")


@pytest.fixture
def made(tmp_path: Path) -> Path:
    for artifact in compiled_text(tmp_path, ROBOT.format(bottom="20 mm")).artifacts:
        (tmp_path / artifact.file).write_text(artifact.text, "utf-8")
    return tmp_path


@pytest.mark.slow
@pytest.mark.parametrize(("one", "other"), [("robot.yaml", "b.urdf"), ("a.urdf", "b.urdf"), ("a.urdf", "a.xml")])
def test_a_map_cut_otherwise_is_the_same_robot_and_said(made: Path, one: str, other: str) -> None:
    found = compared(made / one, made / other)
    assert found["differences"] == []
    assert "collision boxes are cut otherwise, and fill the same space: base" in found["notes"]


def test_a_map_down_to_the_ground_is_another_one_unless_an_output_asks_for_it(made: Path) -> None:
    found = compared(made / "robot.yaml", made / "c.urdf")
    assert found["differences"] == []
    assert "the boxes of the height map of base reach down to z = 0 on one side" in found["notes"]
    other = made / "other.yaml"
    other.write_text(ROBOT.format(bottom="20 mm").replace("grounded}", "rows}"), "utf-8")
    found = compared(other, made / "c.urdf")["differences"]
    assert [one["text"] for one in found] == ["base collision: box min z 0.02 -> 0 m (-20.0 mm)"] * 3


def test_another_bottom_is_told(made: Path) -> None:
    other = made / "other.yaml"
    for bottom, said in (
        ("30 mm", "base height map bottom 0.02 -> 0.03 m (+10.0 mm)"),
        ("[[0.02, 0.02], [0.02, 0.05]]", "base height map bottom 0.02 -> 0.02 0.02 0.02 0.05"),
    ):
        other.write_text(ROBOT.format(bottom=bottom), "utf-8")
        assert [item["text"] for item in compared(made / "robot.yaml", other)["differences"]] == [said]
