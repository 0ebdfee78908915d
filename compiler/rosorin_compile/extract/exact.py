"""The highest point of a triangle in each cell, exactly.

A triangle is flat, so its highest point over a square is a corner of the piece that the square cuts out of it: a corner
of the triangle, a point where an edge crosses a line of the grid, or a point of the triangle over a corner of cells.
These three kinds are all there is to look at.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

from .grid import Surface
from .sampling import MOST_POINTS

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    Floats = NDArray[np.float64]
    Ints = NDArray[np.int64]


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
