"""Height maps: the top of a mesh as one height for each cell of a grid.

Each triangle's surface is sampled (see ``grid``), by default a third of a cell apart. A cell's height is the highest
sample in it. It is never above the surface; how far it may be below is said in docs/meshes.md. A triangle
with an edge longer than 32 spacings is not sampled: its highest points are calculated, which costs less then.

``height_map`` makes the heights; ``Wanted`` says of which surface and on which grid, and ``make_map`` takes both
together.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import TYPE_CHECKING

from rosorin_compile.model import HeightMap
from rosorin_compile.model.mesh_triangles import ExtractProblem
from rosorin_compile.source.diagnostics import NOTE, WARNING, Diagnostic
from rosorin_compile.source.numbers import exact
from rosorin_compile.source.progress import Progress
from rosorin_compile.source.rule_registry import Heading, Rule

from .grid import DIVISIONS, Grid, Surface, divisions_needed, put_exactly, samples
from .meshes import bounds
from .turning import down, up

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    Floats = NDArray[np.float64]

RULES = (
    Rule(
        "height-map-empty",
        "A mesh has no surface above z = 0 over the grid.",
        "Correct `--xyz`, `--rpy`, `--scale` or `--origin`.",
        Heading.MESHES,
    ),
    Rule("height-map-outside", "A warning: a mesh reaches beyond the grid.", "A larger grid.", Heading.MESHES),
    Rule(
        "height-map-below",
        "A note: a mesh reaches below z = 0, where a height map begins.",
        "Is `--xyz` right?",
        Heading.MESHES,
    ),
)


Told = Callable[[int, int], None]

CHUNK = 50_000


def height_map(
    triangles: Floats,
    grid: Grid,
    spacing: float | None = None,
    exact: bool = False,
    progress: Told = lambda _done, _all: None,
) -> Floats:
    """Return the height of the surface of triangles (n, 3, 3) in metres over each cell, (nx, ny); 0 where is none.

    ``spacing`` is the largest distance of neighbouring samples in metres, by default a third of a cell; with ``exact``
    nothing is sampled. Surface below z = 0 is none. ``progress`` is told how many of all triangles are done.
    """
    import numpy as np

    surface = Surface(grid.cells)
    step = grid.cell / 3 if spacing is None else spacing
    for start in range(0, len(triangles), CHUNK):
        chunk = _that_matter(triangles[start : start + CHUNK], grid)
        moved = grid.in_cells(chunk)
        if exact:
            put_exactly(surface, moved)
        else:
            _sample(surface, chunk, moved, step)
        progress(min(start + CHUNK, len(triangles)), len(triangles))
    heights: Floats = np.where(surface.heights > 0, surface.heights, 0.0).reshape(grid.cells)
    return heights


def below(triangles: Floats, limit: float) -> Floats:
    """Return the part of the surface of triangles (n, 3, 3) that is not above z = ``limit``, as triangles."""
    import numpy as np

    above = triangles[:, :, 2] > limit
    count = above.sum(axis=1)
    pieces = [triangles[count == 0]]
    for many in (1, 2):
        cut = triangles[count == many]
        # Turn the corners so that the one that differs from the others comes first.
        odd = np.argmax((cut[:, :, 2] > limit) == (many == 1), axis=1)
        order = (odd[:, None] + np.arange(3)) % 3
        a, b, c = np.take_along_axis(cut, order[:, :, None], axis=1).transpose(1, 0, 2)
        on_b, on_c = _at_height(a, b, limit), _at_height(a, c, limit)
        if many == 2:
            pieces.append(np.stack([a, on_b, on_c], axis=1))
        else:
            pieces += [np.stack([on_b, b, c], axis=1), np.stack([on_b, c, on_c], axis=1)]
    return np.concatenate(pieces)


def _at_height(start: Floats, end: Floats, height: float) -> Floats:
    """Return the points (n, 3) between two others where z is ``height``."""
    rise = end[:, 2] - start[:, 2]
    points: Floats = start + ((height - start[:, 2]) / rise)[:, None] * (end - start)
    points[:, 2] = height
    return points


def _that_matter(triangles: Floats, grid: Grid) -> Floats:
    """Return the triangles that are over the grid and reach above z = 0."""
    x, y, z = triangles[:, :, 0], triangles[:, :, 1], triangles[:, :, 2]
    keep = (z[:, 0] > 0) | (z[:, 1] > 0) | (z[:, 2] > 0)
    for axis, corner in enumerate((x, y)):
        low = grid.origin[axis] - 0.001 * grid.cell
        high = grid.origin[axis] + (grid.cells[axis] + 0.001) * grid.cell
        inside = (corner >= low) & (corner <= high)
        if not inside.all():
            keep &= (corner.max(axis=1) >= low) & (corner.min(axis=1) <= high)
    return triangles if keep.all() else triangles[keep]


def _sample(surface: Surface, metres: Floats, moved: Floats, spacing: float) -> None:
    """Raise the cells to samples of triangles, given in metres and with x and y in cells, (n, 3, 3) both."""
    which = divisions_needed(metres, spacing)
    for some, owner, points in samples(moved, which):
        surface.put(moved if len(some) == len(moved) else moved[some], owner, points)
    put_exactly(surface, moved[which == len(DIVISIONS)])


def rounded_up(heights: Floats, digits: int) -> Floats:
    """Return heights (nx, ny) rounded up to a number of decimals; what is there at all is not rounded to nothing."""
    import numpy as np

    made = [
        [max(up(height, digits), 10.0**-digits) if height > 0 else 0.0 for height in row] for row in heights.tolist()
    ]
    return np.array(made)


def grid_around(lower: Floats, upper: Floats, cell: float, digits: int) -> Grid:
    """Return the smallest grid of cells around a mesh whose first corner has a number of decimals."""
    origin = [down(value, digits) for value in (float(lower[0]), float(lower[1]))]
    cells = [max(1, math.ceil((float(upper[axis]) - origin[axis]) / cell - 0.001)) for axis in range(2)]
    return Grid((origin[0], origin[1]), cell, (cells[0], cells[1]))


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
    bottom: bool = False


def make_map(triangles: Floats, wanted: Wanted, frame: str) -> tuple[HeightMap, list[Diagnostic]]:
    """Return the height map of triangles (n, 3, 3) in a frame, and what there is to say. Raises ExtractProblem."""
    _check(wanted)
    if wanted.below is not None:
        triangles = below(triangles, wanted.below)
        if not len(triangles):
            message = f"nothing of the mesh is below {wanted.below:g} m in {frame}"
            raise ExtractProblem.of("height-map-empty", message, "correct --below, --xyz or --scale")
    lower, upper = bounds(triangles)
    grid = _grid(wanted, lower, upper)
    heights = height_map(triangles, grid, wanted.spacing, wanted.exact, partial(Progress.step, "sampling"))
    if not heights.any():
        message = f"the mesh has no surface above z = 0 of {frame} over the grid"
        raise ExtractProblem.of("height-map-empty", message, "correct --xyz, --rpy, --scale or --origin")
    rows = tuple(map(tuple, rounded_up(heights, wanted.digits).tolist()))
    made = HeightMap(grid.origin, grid.cell, rows, wanted.step or grid.cell, _method(wanted))
    if wanted.bottom:
        made = replace(made, bottom=_bottoms(triangles, grid, wanted, made.heights))
    return made, _remarks(lower, upper, grid, frame)


def _bottoms(
    triangles: Floats, grid: Grid, wanted: Wanted, heights: Sequence[Sequence[float]]
) -> float | tuple[tuple[float, ...], ...]:
    """Return where the body begins in each cell, or in all (m): the height of the surface, turned upside down."""
    ceiling = float(triangles[:, :, 2].max()) + 1.0  # so that no surface is at zero
    flipped = triangles.copy()
    flipped[:, :, 2] = ceiling - flipped[:, :, 2]
    depths = height_map(flipped, grid, wanted.spacing, wanted.exact, partial(Progress.step, "sampling")).tolist()
    least = 10.0**-wanted.digits  # the thickness of a sheet
    rows = tuple(
        tuple(
            max(0.0, down(min(ceiling - depth, height - least), wanted.digits)) if height > 0 else 0.0
            for depth, height in zip(line, row, strict=True)
        )
        for line, row in zip(depths, heights, strict=True)
    )
    some = {low for lows, row in zip(rows, heights, strict=True) for low, top in zip(lows, row, strict=True) if top > 0}
    return some.pop() if len(some) == 1 else rows


def _check(wanted: Wanted) -> None:
    spacing = wanted.spacing
    if spacing is not None and not 0 < spacing <= wanted.cell / 3 * (1 + 1e-9):
        message = f"samples {spacing:g} m apart are too far for cells of {wanted.cell:g} m"
        raise ExtractProblem.of("height-map-grid", message, "at most a third of a cell, and above zero")


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
