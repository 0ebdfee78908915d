"""Height maps: the top of a mesh as one height for each cell of a grid.

Each triangle's surface is sampled (see ``sampling``), by default a third of a cell apart. A cell's height is the
highest sample in it. It is never above the surface; how far it may be below is said in docs/numbers-from-meshes.md.

A triangle with an edge longer than 32 spacings is not sampled: its highest points are calculated (see ``exact``), which
costs less then.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import TYPE_CHECKING

from .exact import put_exactly
from .grid import Grid, Surface
from .sampling import DIVISIONS, divisions_needed, samples
from .turning import down, up

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    Floats = NDArray[np.float64]

Progress = Callable[[int, int], None]

CHUNK = 50_000


def height_map(
    triangles: Floats,
    grid: Grid,
    spacing: float | None = None,
    exact: bool = False,
    progress: Progress = lambda _done, _all: None,
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
