"""The boxes of a height map: every form fills the same space, that of the rounded cells, and no part of it twice."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rosorin_compile.model import Box, HeightMap, Pose, Shape
from rosorin_compile.model.bounds import Bounds, bounds_of
from rosorin_compile.model.shape import GROUNDED, MERGED, ROWS

STEP = 0.05
CELL = 0.1


@st.composite
def grids(draw: st.DrawFn) -> HeightMap:
    count, across = draw(st.integers(1, 7)), draw(st.integers(1, 7))
    heights = st.sampled_from((0.0, 0.11, 0.15, 0.16, 0.3))
    rows = tuple(tuple(draw(heights) for _ in range(across)) for _ in range(count))
    lows = st.sampled_from((0.0, 0.05, 0.07, 0.1, 0.15, 0.15 - 1e-9, 0.2, 0.3))
    cells = tuple(tuple(draw(lows) for _ in range(across)) for _ in range(count))
    return HeightMap((-0.3, 0.2), CELL, rows, STEP, "", draw(st.sampled_from((0.0, 0.04, cells))))


def cells_of(grid: HeightMap, boxes: tuple[Box, ...]) -> dict[tuple[int, int], tuple[float, float]]:
    """Return from where to where boxes reach in each cell; none may be there twice."""
    found: dict[tuple[int, int], tuple[float, float]] = {}
    for box in boxes:
        i, k = (round((x - grid.origin[0]) / grid.cell) for x in (box.lower[0], box.upper[0]))
        j, m = (round((y - grid.origin[1]) / grid.cell) for y in (box.lower[1], box.upper[1]))
        for cell in ((x, y) for x in range(i, k) for y in range(j, m)):
            assert cell not in found
            found[cell] = (box.lower[2], box.upper[2])
    return found


def meant(grid: HeightMap, form: str) -> dict[tuple[int, int], tuple[float, float]]:
    made = {}
    for i, row in enumerate(grid.heights):
        for j, height in enumerate(row):
            low = grid.bottom_of(i, j) if form != GROUNDED else 0.0
            if isinstance(grid.bottom, tuple) and form != GROUNDED:
                low = math.floor(low / STEP + 1e-6) * STEP
            well = form != GROUNDED and grid.bottom_of(i, j) >= height - 1e-8
            if height and not well:
                made[i, j] = (pytest.approx(low), pytest.approx(math.ceil(height / STEP - 1e-6) * STEP))
    return made


@given(grids(), st.sampled_from((ROWS, MERGED, GROUNDED)))
def test_each_form_fills_every_cell_once(grid: HeightMap, form: str) -> None:
    boxes = grid.boxes(form)
    assert cells_of(grid, boxes) == meant(grid, form)
    assert all(a < b for box in boxes for a, b in zip(box.lower, box.upper, strict=True))


def test_equal_cells_are_one_box_and_a_hole_is_none() -> None:
    same = HeightMap((0.0, 0.0), CELL, ((0.2,) * 5,) * 4, STEP)
    assert same.boxes(MERGED) == (Box((0.0, 0.0, 0.0), (4 * CELL, 5 * CELL, 0.2)),)
    ring = HeightMap((0.0, 0.0), CELL, ((0.2, 0.2, 0.2), (0.2, 0.0, 0.2), (0.2, 0.2, 0.2)), STEP)
    assert len(ring.boxes(MERGED)) == 4
    assert HeightMap((0.0, 0.0), CELL, ((0.0,),), STEP).boxes(MERGED) == ()
    assert bounds_of([Shape(same)]) == Bounds((0.0, 0.0, 0.0), (4 * CELL, 5 * CELL, 0.2))


def test_a_cell_that_would_begin_at_its_top_is_a_well() -> None:
    grid = HeightMap((0.0, 0.0), 1.0, ((0.5, 0.5, 0.9), (0.5, 0.5, 0.5)), 0.1, "", ((0.1, 0.5, 0.9), (0.1, 0.1, 0.6)))
    assert [height > grid.bottom_of(0, j) for j, height in enumerate(grid.heights[0])] == [True, False, False]
    assert grid.boxes(ROWS) == (Box((0, 0, 0.1), (1, 1, 0.5)), Box((1, 0, 0.1), (2, 2, 0.5)))
    assert len(grid.boxes(GROUNDED)) == 3  # which knows of no bottom
    assert bounds_of([Shape(grid)]) == Bounds((0, 0, 0.1), (2, 3, 0.5))


def test_what_is_drawn_stands_on_zero() -> None:
    grid = HeightMap((0.0, 0.0), 1.0, ((0.5, 0.0), (0.7, 0.7)), 0.1, "", 0.2)
    (lifted,) = Shape(grid, Pose((1.0, 0.0, 0.0), (math.pi / 2, 0.0, 0.0))).drawn_shapes()
    assert lifted.pose.xyz == pytest.approx((1.0, -0.2, 0.0))
    assert lifted.geometry.heights == ((pytest.approx(0.3), 0.0), (pytest.approx(0.5), pytest.approx(0.5)))
    assert not lifted.geometry.bottom
    wells = HeightMap((0.0, 0.0), 1.0, ((0.5, 0.5),), 0.1, "", ((0.0, 0.3),))
    assert [piece.geometry.lower[2] for piece in Shape(wells).drawn_shapes()] == [0.0, pytest.approx(0.3)]
    assert Shape(Box((0, 0, 0), (1, 1, 1))).drawn_shapes() == (Shape(Box((0, 0, 0), (1, 1, 1))),)
