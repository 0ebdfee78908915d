"""The grid of a height map, and how points of a surface get to its cells.

Coordinates here are in cells: u along x and v along y, both 0 at the corner of the grid; z stays in metres. Cell (i, j)
covers u from i to i + 1 and v from j to j + 1.

A point on the line between cells belongs to each of them that its triangle reaches into. A wall that stands exactly on
a line reaches into none: it belongs to the cell behind it, which its normal tells. So a box that ends on a line of the
grid does not fill the cells beside it, on none of its four sides, and yet no wall is lost.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

from ..registry import MESHES, Rule
from .problems import fail

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    Floats = NDArray[np.float64]
    Ints = NDArray[np.int64]

RULES = (
    Rule(
        "height-map-grid",
        "A grid cannot be: no cell, more than a million of them, samples that are too far apart.",
        "A larger `--cell`, or fewer `--cells`.",
        MESHES,
    ),
)

MAX_CELLS = 1_000_000
# Half the width of a line between cells, in cells: coordinates of an STL are rounded to 24 bits.
LINE = 1e-5


@dataclass(frozen=True)
class Grid:
    """``cells`` squares of edge ``cell`` along x and y, the first with its lower corner at ``origin`` (metres)."""

    origin: tuple[float, float]
    cell: float
    cells: tuple[int, int]

    def __post_init__(self) -> None:
        """Raise ExtractProblem for a grid that cannot be."""
        if not (self.cell > 0 and math.isfinite(self.cell)):
            raise fail("height-map-grid", f"a cell of {self.cell:g} m is none", "such as --cell 10mm")
        if min(self.cells) < 1 or self.cells[0] * self.cells[1] > MAX_CELLS:
            message = f"{self.cells[0]:,} x {self.cells[1]:,} cells are none, or more than {MAX_CELLS:,}"
            raise fail("height-map-grid", message, "use a larger --cell, or a smaller grid: --cells 30x23")

    def in_cells(self, triangles: Floats) -> Floats:
        """Return triangles (n, 3, 3) in metres with x and y in cells."""
        import numpy as np

        moved = np.empty_like(triangles)
        for axis in range(2):
            np.subtract(triangles[:, :, axis], self.origin[axis], out=moved[:, :, axis])
            moved[:, :, axis] /= self.cell
        moved[:, :, 2] = triangles[:, :, 2]
        return moved


class Surface:
    """The highest point that was seen in each cell; -inf where there was none."""

    def __init__(self, cells: tuple[int, int]) -> None:
        import numpy as np

        self.cells = cells
        self.heights = np.full(cells[0] * cells[1], -np.inf)

    def put(self, triangles: Floats, owner: Ints, points: Floats) -> None:
        """Raise cells to points (m, 3) of the surface; point k lies on ``triangles[owner[k]]``."""
        import numpy as np

        u, v, z = points[:, 0], points[:, 1], points[:, 2]
        i, j = np.floor(u - LINE), np.floor(v - LINE)
        on_line = (np.floor(u + LINE) != i) | (np.floor(v + LINE) != j)
        if on_line.any():
            (where,) = on_line.nonzero()
            self._put_on_line(triangles[owner[where]], points[where])
            off = ~on_line
            i, j, z = i[off], j[off], z[off]
        self._raise(i, j, z)

    def _raise(self, i: Floats, j: Floats, z: Floats) -> None:
        import numpy as np

        inside = (i >= 0) & (i < self.cells[0]) & (j >= 0) & (j < self.cells[1])
        if not inside.all():
            i, j, z = i[inside], j[inside], z[inside]
        np.maximum.at(self.heights, (i * self.cells[1] + j).astype(np.int64), z)

    def _put_on_line(self, triangles: Floats, points: Floats) -> None:
        """Raise the cells to both sides of a line that the triangle of a point (m of both) reaches into."""
        import numpy as np

        u, v, z = points[:, 0], points[:, 1], points[:, 2]
        settled = np.zeros(len(points), dtype=bool)
        sides = [(np.floor(u + a * LINE), np.floor(v + b * LINE)) for a in (-1, 1) for b in (-1, 1)]
        for i, j in sides:
            here = reaches_into(triangles, i, j)
            settled |= here
            self._raise(i[here], j[here], z[here])
        if not settled.all():
            left = ~settled
            behind = points[left, :2] + 2 * LINE * _inward(triangles[left], points[left])
            self._raise(np.floor(behind[:, 0]), np.floor(behind[:, 1]), z[left])


def reaches_into(triangles: Floats, i: Floats, j: Floats) -> NDArray[np.bool_]:
    """Say for each triangle (m, 3, 3) whether seen from above it reaches into the inside of cell (i, j), both (m,).

    The theorem of the separating axis: two convex shapes are apart if and only if they are along x, along y, or along a
    normal of one of the edges of the triangle.
    """
    import numpy as np

    u, v = triangles[:, :, 0], triangles[:, :, 1]
    half = 0.5 - LINE
    apart = np.zeros(len(triangles), dtype=bool)
    for corner, low in ((u, i), (v, j)):
        apart |= (corner.max(axis=1) <= low + LINE) | (corner.min(axis=1) >= low + 1 - LINE)
    du, dv = u - (i + 0.5)[:, None], v - (j + 0.5)[:, None]
    for first, second in ((0, 1), (1, 2), (2, 0)):
        normal_u, normal_v = dv[:, second] - dv[:, first], du[:, first] - du[:, second]
        along = normal_u[:, None] * du + normal_v[:, None] * dv
        reach = half * (np.abs(normal_u) + np.abs(normal_v))
        apart |= (along.min(axis=1) > reach) | (along.max(axis=1) < -reach)
    return ~apart


def _inward(triangles: Floats, points: Floats) -> Floats:
    """Return the signs (m, 2) of x and y of the way into the body: against the normal, or to the middle."""
    import numpy as np

    a, b, c = triangles[:, 0], triangles[:, 1], triangles[:, 2]
    normal = np.cross(b - a, c - a)[:, :2]
    against = np.abs(normal) > 1e-6 * np.abs(normal).max(axis=1, keepdims=True)
    middle = triangles.mean(axis=1)[:, :2] - points[:, :2]
    signs: Floats = np.where(against, -np.sign(normal), np.where(np.abs(middle) > LINE, np.sign(middle), 0.0))
    return signs
