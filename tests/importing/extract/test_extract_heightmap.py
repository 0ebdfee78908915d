"""Height maps of surfaces that are known, and of any triangles against slow ways to say the same."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rosorin_compile.importing.extract.height_map import Grid, GridOptions, cut_above, make_height_map, surface_heights
from support.meshes import box, clipped_heights, quad, random_points

CELL = 0.01
NOISE = 3e-7  # m: of a height; the lines between cells have a width
GRID = Grid((0.0, 0.0), CELL, (20, 10))


def same(heights: np.ndarray, wanted: np.ndarray) -> None:
    """Hold heights against others: body at the same cells, as high to the last digits."""
    assert ((heights > 0) == (wanted > 0)).all()
    np.testing.assert_allclose(heights, wanted, rtol=0, atol=NOISE)


RAMP = quad((0, 0, 0), (0.2, 0, 0.1), (0.2, 0.1, 0.1), (0, 0.1, 0))


def test_box_on_the_lines_of_the_grid_fills_its_cells_and_no_others() -> None:
    heights = surface_heights(box((0.02, 0.03, 0), (0.15, 0.08, 0.06)), GRID)
    wanted = np.zeros(GRID.cells)
    wanted[2:15, 3:8] = 0.06
    same(heights, wanted)


def test_ramp_is_exact_at_the_upper_end_of_each_cell() -> None:
    heights = surface_heights(RAMP, GRID)
    wanted = np.outer(0.5 * CELL * np.arange(1, 21), np.ones(10))
    np.testing.assert_allclose(heights, wanted, rtol=0, atol=NOISE)


@settings(max_examples=30, deadline=None)
@given(st.floats(-1, 1), st.floats(-1, 1))
def test_tilted_plane_is_exact_at_the_highest_corner_of_each_cell(a: float, b: float) -> None:
    at = [(x, y, 1 + a * x + b * y) for x, y in ((-0.1, -0.1), (0.3, -0.1), (0.3, 0.2), (-0.1, 0.2))]
    heights = surface_heights(quad(*at), GRID)
    i, j = np.meshgrid(np.arange(20), np.arange(10), indexing="ij")
    corners = [1 + a * CELL * (i + k) + b * CELL * (j + m) for k in (0, 1) for m in (0, 1)]
    np.testing.assert_allclose(heights, np.max(corners, axis=0), rtol=0, atol=NOISE)


@pytest.mark.parametrize("width", [1e-9, 1e-6, 1e-4])
def test_needle_is_in_every_cell_that_it_passes(width: float) -> None:
    needle = np.array([[(0.003, 0.004, 0.02), (0.183, 0.094, 0.12), (0.183 - width, 0.094 + width, 0.12)]])
    heights = surface_heights(needle, GRID)
    slow = np.where(np.isfinite(found := clipped_heights(needle, GRID)), found, 0)
    np.testing.assert_allclose(heights, slow, rtol=0, atol=NOISE)


def coordinates(low: float, high: float) -> st.SearchStrategy[float]:
    return st.floats(low, high) | st.integers(0, 40).map(lambda n: low + (high - low) * n / 40)


TRIANGLES = st.lists(
    st.tuples(*[st.tuples(coordinates(-0.01, 0.06), coordinates(-0.01, 0.05), coordinates(0.001, 0.08))] * 3),
    min_size=1,
    max_size=4,
).map(np.array)
SMALL = Grid((0.0, 0.0), CELL, (5, 4))


@settings(max_examples=150, deadline=None)
@given(TRIANGLES)
def test_exact_heights_are_those_of_cut_triangles(triangles: np.ndarray) -> None:
    """Cells that a triangle only touches may be left out, by at most the width of a line: 1e-5 cells."""
    heights = surface_heights(triangles, SMALL)
    assert (heights <= inner_heights(triangles, SMALL, -3e-5 * CELL) + 1e-9).all()
    assert (heights >= inner_heights(triangles, SMALL, 3e-5 * CELL) - 1e-9).all()


def steepest(triangles: np.ndarray) -> float:
    """Return a bound for how far a height may jump within the width of a line: all the way on upright triangles."""
    normal = np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])
    flat = np.hypot(normal[:, 0], normal[:, 1])
    up = np.abs(normal[:, 2])
    return float(np.where(up > 1e-6 * flat, flat / np.where(up > 0, up, 1), 1e9).max()) if len(triangles) else 0.0


def inner_heights(triangles: np.ndarray, grid: Grid, by: float) -> np.ndarray:
    """Return the highest point over the inner part of each cell, or a little beyond it if ``by`` is below zero."""
    heights = np.zeros(grid.cells)
    for i in range(grid.cells[0]):
        for j in range(grid.cells[1]):
            origin = (grid.origin[0] + i * grid.cell + by, grid.origin[1] + j * grid.cell + by)
            heights[i, j] = max(0.0, clipped_heights(triangles, Grid(origin, grid.cell - 2 * by, (1, 1)))[0, 0])
    return heights


@settings(max_examples=60, deadline=None)
@given(TRIANGLES, st.floats(0.002, 0.08))
def test_below_cuts_at_the_height(triangles: np.ndarray, limit: float) -> None:
    kept = cut_above(triangles, limit)
    assert not len(kept) or kept[:, :, 2].max() <= limit
    points = random_points(triangles, 200, 7)
    points = points[points[:, 2] < limit - 1e-6]
    heights, all_heights = surface_heights(kept, SMALL), surface_heights(triangles, SMALL)
    for x, y, z in points:
        i, j = math.floor(x / CELL), math.floor(y / CELL)
        inside = all(1e-4 < value / CELL % 1 < 1 - 1e-4 for value in (x, y))
        if 0 <= i < 5 and 0 <= j < 4 and inside:
            assert heights[i, j] >= z - 1e-9
    assert (heights <= all_heights + steepest(triangles) * 3e-5 * CELL + 1e-9).all()


def test_the_bottom_is_the_lowest_point_of_a_body() -> None:
    body = np.concatenate([box((0.0, 0.0, 0.02), (0.099, 0.1, 0.06)), box((0.1, 0.0, 0.03), (0.2, 0.1, 0.09))])
    made, _ = make_height_map(body, GridOptions(0.05, (0.0, 0.0), (5, 2), bottom=True), "base_link")
    assert made.heights == ((0.06, 0.06), (0.06, 0.06), (0.09, 0.09), (0.09, 0.09), (0.0, 0.0))
    assert made.bottom == 0.02
