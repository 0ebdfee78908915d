"""``extract heightmap``: which grid, which surface, and what there is to say about the map that comes of it."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

from ..diagnostic import NOTE, WARNING, Diagnostic
from ..formatting import exact
from ..model import HeightMap
from ..progress import Progress
from ..registry import MESHES, Rule
from .grid import Grid
from .heightmap import below, grid_around, height_map, rounded_up
from .meshes import bounds
from .problems import fail

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    Floats = NDArray[np.float64]

RULES = (
    Rule(
        "height-map-empty",
        "A mesh has no surface above z = 0 over the grid.",
        "Correct `--xyz`, `--rpy`, `--scale` or `--origin`.",
        MESHES,
    ),
    Rule("height-map-outside", "A warning: a mesh reaches beyond the grid.", "A larger grid.", MESHES),
    Rule(
        "height-map-below",
        "A note: a mesh reaches below z = 0, where a height map begins.",
        "Is `--xyz` right?",
        MESHES,
    ),
)

# The surface may reach this far beyond the grid, or below z = 0, before that is said, in metres.
_NOISE = 1e-6


@dataclass(frozen=True)
class Wanted:
    """What is asked for: lengths in metres; None is found from the mesh, ``step`` None is a cell."""

    cell: float
    origin: tuple[float, float] | None = None
    cells: tuple[int, int] | None = None
    spacing: float | None = None
    exact: bool = False
    below: float | None = None
    digits: int = 4
    step: float | None = None


def make_map(triangles: Floats, wanted: Wanted, frame: str) -> tuple[HeightMap, list[Diagnostic]]:
    """Return the height map of triangles (n, 3, 3) in a frame, and what there is to say. Raises ExtractProblem."""
    _check(wanted)
    if wanted.below is not None:
        triangles = below(triangles, wanted.below)
        if not len(triangles):
            message = f"nothing of the mesh is below {wanted.below:g} m in {frame}"
            raise fail("height-map-empty", message, "correct --below, --xyz or --scale")
    lower, upper = bounds(triangles)
    grid = _grid(wanted, lower, upper)
    progress = Progress("sampling")
    try:
        heights = height_map(triangles, grid, wanted.spacing, wanted.exact, progress)
    finally:
        progress.end()
    if not heights.any():
        message = f"the mesh has no surface above z = 0 of {frame} over the grid"
        raise fail("height-map-empty", message, "correct --xyz, --rpy, --scale or --origin")
    rows = tuple(map(tuple, rounded_up(heights, wanted.digits).tolist()))
    made = HeightMap(grid.origin, grid.cell, rows, wanted.step or grid.cell, _method(wanted))
    return made, _remarks(lower, upper, grid, frame)


def _check(wanted: Wanted) -> None:
    spacing = wanted.spacing
    if spacing is not None and not 0 < spacing <= wanted.cell / 3 * (1 + 1e-9):
        message = f"samples {spacing:g} m apart are too far for cells of {wanted.cell:g} m"
        raise fail("height-map-grid", message, "at most a third of a cell, and above zero")


def _grid(wanted: Wanted, lower: Floats, upper: Floats) -> Grid:
    if not wanted.cell > 0 or math.isinf(wanted.cell):
        return Grid((0.0, 0.0), wanted.cell, (1, 1))  # which says what is wrong
    around = grid_around(lower, upper, wanted.cell, 5)
    origin = around.origin if wanted.origin is None else wanted.origin
    if wanted.cells is not None:
        return Grid(origin, wanted.cell, wanted.cells)
    reach = [max(1, math.ceil((float(upper[axis]) - origin[axis]) / wanted.cell - 0.001)) for axis in range(2)]
    return Grid(origin, wanted.cell, (reach[0], reach[1]))


def _method(wanted: Wanted) -> str:
    """Return how the heights were found, for those who read the map."""
    method = "triangle surface sampling, spacing <= cell/3"
    if wanted.exact:
        method = "highest point of each triangle in each cell"
    elif wanted.spacing is not None:
        method = f"triangle surface sampling, spacing <= {exact(wanted.spacing)} m"
    return method if wanted.below is None else f"{method}; nothing above {exact(wanted.below)} m"


def _remarks(lower: Floats, upper: Floats, grid: Grid, frame: str) -> list[Diagnostic]:
    """Return warnings for what of a mesh is not over the grid, and a note for what is below it."""
    remarks = []
    beyond = []
    for axis, letter in enumerate("xy"):
        end = grid.origin[axis] + grid.cells[axis] * grid.cell
        for side, distance in (("low", grid.origin[axis] - float(lower[axis])), ("high", float(upper[axis]) - end)):
            if distance > max(_NOISE, 1e-3 * grid.cell):
                beyond.append(f"{distance * 1000:.1f} mm at {side} {letter}")
    if beyond:
        help = "a larger grid carries it: --origin and --cells, or leave both out"
        message = f"the mesh reaches beyond the grid: {', '.join(beyond)}"
        remarks.append(Diagnostic("height-map-outside", WARNING, message, None, (), help))
    if lower[2] < -_NOISE:
        message = f"the mesh reaches {-float(lower[2]) * 1000:.1f} mm below z = 0 of {frame}, where a height map begins"
        remarks.append(Diagnostic("height-map-below", NOTE, message, None, (), "is --xyz right?"))
    return remarks


def summary(made: HeightMap) -> str:
    """Return a height map in one line."""
    heights = [height for row in made.heights for height in row]
    some = [height for height in heights if height > 0]
    size = f"{len(made.heights)} x {len(made.heights[0])} cells of {made.cell * 1000:g} mm"
    at = f"from x {made.origin[0]:g}, y {made.origin[1]:g}"
    return f"{size} {at}; {len(some)} of {len(heights)} have a height, {min(some):g} to {max(some):g} m"
