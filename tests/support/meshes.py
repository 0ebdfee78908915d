"""Meshes with a known surface, and slow ways to find its height that share no code with the product."""

import math
from itertools import pairwise

import numpy as np

from rosorin_compile.importing.extract.height_map import Grid

Point = tuple[float, ...]


def box(lower: Point, upper: Point) -> np.ndarray:
    """Return the 12 triangles of a box, counter-clockwise seen from outside."""
    corners = np.array([[(lower, upper)[i >> a & 1][a] for a in range(3)] for i in range(8)], dtype=float)
    quads = [(0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5)]
    return corners[[face for a, b, c, d in quads for face in ((a, b, c), (a, c, d))]]


def quad(a: Point, b: Point, c: Point, d: Point) -> np.ndarray:
    return np.array([[a, b, c], [a, c, d]], dtype=float)


def clipped_heights(triangles: np.ndarray, grid: Grid) -> np.ndarray:
    """Return the highest point over each closed cell, by cutting each triangle with each cell; -inf where is none.

    The algorithm of Sutherland and Hodgman (1974), in plain Python.
    """
    nx, ny = grid.cells
    heights = np.full(grid.cells, -np.inf)
    for triangle in triangles.tolist():
        for i in range(nx):
            for j in range(ny):
                x, y = grid.origin[0] + i * grid.cell, grid.origin[1] + j * grid.cell
                piece = triangle
                for axis, sign, limit in ((0, 1, x), (0, -1, x + grid.cell), (1, 1, y), (1, -1, y + grid.cell)):
                    piece = _cut(piece, axis, sign, limit)
                if piece:
                    heights[i, j] = max(heights[i, j], *(p[2] for p in piece), -math.inf)
    return heights


def _cut(piece: list[list[float]], axis: int, sign: int, limit: float) -> list[list[float]]:
    kept = []
    for a, b in pairwise([*piece[-1:], *piece]):
        inside_a, inside_b = sign * (a[axis] - limit) >= 0, sign * (b[axis] - limit) >= 0
        if inside_a != inside_b:
            t = (limit - a[axis]) / (b[axis] - a[axis])
            kept.append([p + t * (q - p) for p, q in zip(a, b, strict=True)])
        if inside_b:
            kept.append(b)
    return kept


def random_points(triangles: np.ndarray, count: int, seed: int) -> np.ndarray:
    """Return points (count, 3) on triangles, each on one of them by chance."""
    generator = np.random.default_rng(seed)
    weights = generator.dirichlet((1, 1, 1), count)
    return np.einsum("ij,ijk->ik", weights, triangles[generator.integers(len(triangles), size=count)])
