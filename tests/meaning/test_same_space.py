"""Boxes that fill the same space are no difference, however a height map was cut; any other space is."""

from __future__ import annotations

import random
from dataclasses import replace
from pathlib import Path

import pytest

from rosorin_compile.compare.solids import same_space, solid_of
from rosorin_compile.model import Box, HeightMap, Shape, Sphere
from rosorin_compile.model.shape import GROUNDED, MERGED, ROWS
from support.comparing import compared
from support.robots import compiled_text

GRID = HeightMap((-0.3, 0.1), 0.07, ((0.1, 0.2, 0.2), (0.2, 0.2, 0.2), (0.0, 0.2, 0.3)), 0.1, "", 0.05)


def solids(grid: HeightMap, form: str) -> list:
    return [solid_of(Shape(box)) for box in grid.boxes(form)]


def test_forms_of_one_map_fill_the_same_space() -> None:
    assert same_space(solids(GRID, ROWS), solids(GRID, MERGED), 0.0)
    assert not same_space(solids(GRID, ROWS), solids(GRID, GROUNDED), 0.0)


def test_one_cell_or_a_millimetre_less_is_another_space() -> None:
    chance = random.Random(3)  # noqa: S311
    boxes = solids(GRID, MERGED)
    assert not same_space(solids(GRID, ROWS), boxes[1:], 0.0)
    for _ in range(50):
        which, axis = chance.randrange(len(boxes)), chance.randrange(3)
        box = GRID.boxes(MERGED)[which]
        upper = tuple(side - 0.001 * (axis == index) for index, side in enumerate(box.upper))
        moved = [*boxes[:which], solid_of(Shape(replace(box, upper=upper))), *boxes[which + 1 :]]
        assert not same_space(solids(GRID, ROWS), moved, 0.0)


def test_gaps_above_each_other_count_and_touching_boxes_are_one() -> None:
    def tower(*layers: tuple[float, float]) -> list:
        return [solid_of(Shape(Box((0, 0, low), (1, 1, high)))) for low, high in layers]

    assert same_space(tower((0, 1)), tower((0, 0.4), (0.4, 1)), 0.0)
    assert same_space(tower((0, 1)), tower((0, 0.7), (0.3, 1)), 0.0)
    assert not same_space(tower((0, 1)), tower((0, 0.4), (0.5, 1)), 0.0)


def test_what_is_no_box_along_the_axes_is_not_judged() -> None:
    ball = [solid_of(Shape(Sphere(1.0)))]
    assert not same_space(ball, ball, 0.0)
    assert not same_space(solids(GRID, ROWS), [], 0.0)


ROBOT = """robot: cart
links:
  base:
    collision:
      - height_map: {{origin: [0, 0], cell: 0.1, step: 0.05, bottom: {bottom}, heights: [[0.1, 0.2], [0.2, 0.2]]}}
outputs:
  urdf: {{file: a.urdf}}
  merged: {{backend: urdf, file: b.urdf, height_maps: merged}}
  grounded: {{backend: urdf, file: c.urdf, height_maps: grounded}}
  mjcf: {{file: a.xml}}
"""


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
