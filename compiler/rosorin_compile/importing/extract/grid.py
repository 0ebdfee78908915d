"""The grid of a height map, and how points of a surface get to its cells.

Coordinates here are in cells: u along x and v along y, both 0 at the corner of the grid; z stays in metres. Cell (i, j)
covers u from i to i + 1 and v from j to j + 1.

A point on the line between cells belongs to each of them that its triangle reaches into. A wall that stands exactly on
a line reaches into none: it belongs to the cell behind it, which its normal tells. So a box that ends on a line of the
grid does not fill the cells beside it, on none of its four sides, and yet no wall is lost.

``Samples`` of a surface are a lattice on each triangle, edges included; the highest point of a triangle in a cell can
be calculated too.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from functools import lru_cache
from typing import TYPE_CHECKING

from rosorin_compile.model.mesh_triangles import ExtractProblem
from rosorin_compile.source.rule_registry import Heading, Rule

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
        Heading.MESHES,
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
            raise ExtractProblem.of("height-map-grid", f"a cell of {self.cell:g} m is none", "such as --cell 10mm")
        if min(self.cells) < 1 or self.cells[0] * self.cells[1] > MAX_CELLS:
            message = f"{self.cells[0]:,} x {self.cells[1]:,} cells are none, or more than {MAX_CELLS:,}"
            raise ExtractProblem.of("height-map-grid", message, "use a larger --cell, or a smaller grid: --cells 30x23")

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


# Into how many pieces an edge is divided: the next of these.
DIVISIONS = (1, 2, 3, 4, 6, 8, 12, 16, 24, 32)
MORE_DIVISIONS = (*DIVISIONS, 48, 64, 96, 128, 192)
# Points that are held in memory at once.
MOST_POINTS = 300_000


def divisions_needed(triangles: Floats, spacing: float, steps: tuple[int, ...] = DIVISIONS) -> Ints:
    """Return for each triangle (n, 3, 3) which of ``steps`` divides its edges enough; len(steps): none."""
    import numpy as np

    which: Ints = np.searchsorted(steps, longest_edge(triangles) / spacing * (1 - 1e-12))
    return which


def samples(triangles: Floats, which: Ints, steps: tuple[int, ...] = DIVISIONS) -> Iterator[tuple[Ints, Ints, Floats]]:
    """Yield samples of triangles (n, 3, 3) that are divided as ``which`` (n,) says, in arrays of bounded length.

    Each time: which triangles (k,), for each point its position in that list (m,), and the points (m, 3). Triangles for
    which no step is enough are left out.
    """
    import numpy as np

    for index, divisions in enumerate(steps):
        (alike,) = (which == index).nonzero()
        weights = lattice(divisions)
        at_once = max(1, MOST_POINTS // len(weights))
        for start in range(0, len(alike), at_once):
            some = alike[start : start + at_once]
            corners = triangles if len(some) == len(triangles) else triangles[some]
            points = corners if divisions == 1 else np.matmul(weights, corners)
            yield some, np.repeat(np.arange(len(some)), len(weights)), points.reshape(-1, 3)


def longest_edge(triangles: Floats) -> Floats:
    """Return the length of the longest edge of each triangle (n,)."""
    import numpy as np

    longest = np.zeros(len(triangles))
    for first, second in ((0, 1), (1, 2), (2, 0)):
        edge = triangles[:, second] - triangles[:, first]
        np.maximum(longest, np.einsum("ij,ij->i", edge, edge), out=longest)
    return np.sqrt(longest)


@lru_cache(maxsize=32)
def lattice(divisions: int) -> Floats:
    """Return the weights (m, 3) of the corners for each point of the lattice on a triangle."""
    import numpy as np

    shares = [(a, b, divisions - a - b) for a in range(divisions + 1) for b in range(divisions + 1 - a)]
    weights: Floats = np.array(shares, dtype=np.float64) / divisions
    return weights


def put_exactly(surface: Surface, triangles: Floats) -> None:
    """Raise the cells of a surface to the highest points of triangles (n, 3, 3), x and y in cells."""
    import numpy as np

    owner = np.repeat(np.arange(len(triangles)), 3)
    surface.put(triangles, owner, triangles.reshape(-1, 3))
    for first, second in ((0, 1), (1, 2), (2, 0)):
        for axis in range(2):
            for owner, points in _crossings(triangles, first, second, axis, surface.cells[axis]):
                surface.put(triangles, owner, points)
    for owner, points in over_corners(triangles, surface.cells):
        surface.put(triangles, owner, points)


def _crossings(triangles: Floats, first: int, second: int, axis: int, lines: int) -> Iterator[tuple[Ints, Floats]]:
    """Yield where one edge of each triangle crosses the lines 0..lines of one axis: owners (m,) and points (m, 3)."""
    import numpy as np

    a, b = triangles[:, first], triangles[:, second]
    low = np.clip(np.ceil(np.minimum(a[:, axis], b[:, axis])), 0, lines + 1)
    high = np.clip(np.floor(np.maximum(a[:, axis], b[:, axis])), -1, lines)
    for owner, step in _ranges((high - low + 1).clip(0).astype(np.int64)):
        line = low[owner] + step
        start, end = a[owner], b[owner]
        length = end[:, axis] - start[:, axis]
        share = np.where(length == 0, 0.0, (line - start[:, axis]) / np.where(length == 0, 1.0, length))
        points = start + share[:, None].clip(0, 1) * (end - start)
        points[:, axis] = line
        yield owner, points


def over_corners(triangles: Floats, cells: tuple[int, int]) -> Iterator[tuple[Ints, Floats]]:
    """Yield the points of triangles over the corners of cells: owners (m,) and points (m, 3)."""
    import numpy as np

    low = np.ceil(triangles[:, :, :2].min(axis=1)).clip(0)
    high = np.minimum(np.floor(triangles[:, :, :2].max(axis=1)), cells)
    across = (high - low + 1).clip(0).astype(np.int64)
    for owner, step in _ranges(across[:, 0] * across[:, 1]):
        width = across[owner, 1]
        corner = low[owner] + np.stack([step // width, step % width], axis=1)
        inside, points = over(triangles[owner], corner)
        yield owner[inside], points[inside]


def over(triangles: Floats, at: Floats) -> tuple[NDArray[np.bool_], Floats]:
    """Return for triangles (m, 3, 3) and places (m, 2) whether the place is below or above it, and the point (m, 3).

    Upright triangles are over no place.
    """
    import numpy as np

    a, b, c = triangles[:, 0], triangles[:, 1], triangles[:, 2]
    (p, q), (r, s) = (b - a)[:, :2].T, (c - a)[:, :2].T
    x, y = (at - a[:, :2]).T
    area = p * s - q * r
    flat = np.abs(area) > 1e-12 * (np.hypot(p, q) * np.hypot(r, s))
    safe = np.where(flat, area, 1.0)
    second, third = (x * s - y * r) / safe, (y * p - x * q) / safe
    weights = np.stack([1 - second - third, second, third], axis=1)
    inside = flat & (weights >= -1e-12).all(axis=1)
    weights = weights.clip(0, 1)
    weights /= weights.sum(axis=1, keepdims=True).clip(0.5)
    height = (weights * triangles[:, :, 2]).sum(axis=1)
    return inside, np.stack([at[:, 0], at[:, 1], height], axis=1)


def _ranges(counts: Ints) -> Iterator[tuple[Ints, Ints]]:
    """Yield for counts (n,) all pairs of an index and a step below its count, in arrays of bounded length."""
    import numpy as np

    (some,) = counts.nonzero()
    if not len(some):
        return
    ends = np.cumsum(counts[some])
    for start in range(0, int(ends[-1]), MOST_POINTS):
        number = np.arange(start, min(start + MOST_POINTS, int(ends[-1])))
        which = np.searchsorted(ends, number, side="right")
        yield some[which], number - (ends[which] - counts[some[which]])
