"""The solid inside a mesh, seen along upright lines: where each of many lines is inside, and how much that is.

The lines stand on a square lattice, shifted along x and y by irrational parts of its step so that they miss edges and
corners of meshes that were drawn on round numbers. A line that meets an edge all the same is left out.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

from .exact import over_corners
from .meshes import bounds

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    Floats = NDArray[np.float64]

# Lines along the longer side of a mesh.
LINES = 200
_SHIFT = (math.sqrt(2) - 1, math.sqrt(3) - 1)


@dataclass(frozen=True)
class Solid:
    """``volume`` (m^3) of a closed mesh, and the pieces of upright lines inside it.

    ``at`` (m, 2) is where each piece's line stands; it is inside from ``low`` to ``high`` (m,).
    """

    volume: float
    at: Floats
    low: Floats
    high: Floats


def closed(triangles: Floats) -> bool:
    """Whether triangles (n, 3, 3) bound a solid: each edge is gone along as often one way as the other.

    So bodies that touch, and share edges, are closed as well.
    """
    import numpy as np
    import trimesh

    faces = np.arange(len(triangles) * 3).reshape(-1, 3)
    merged = trimesh.Trimesh(triangles.reshape(-1, 3), faces, process=True).faces
    start, end = merged.ravel(), np.roll(merged, -1, axis=1).ravel()
    _, edge = np.unique(np.minimum(start, end) * (3 * len(triangles)) + np.maximum(start, end), return_inverse=True)
    return not np.bincount(edge, np.sign(end - start)).any() and abs(_signed_volume(triangles)) > 0


def solid(triangles: Floats) -> Solid:
    """Return what is inside a closed mesh. Bodies that overlap count once."""
    import numpy as np

    signed = _signed_volume(triangles)
    lower, upper = bounds(triangles)
    step = float((upper - lower)[:2].max()) / LINES
    moved = triangles.copy()
    moved[:, :, :2] = (triangles[:, :, :2] - lower[:2]) / step - _SHIFT
    columns = (LINES + 1, LINES + 1)
    crossings = [(np.empty(0, dtype=np.int64), np.empty((0, 3))), *over_corners(moved, columns)]
    owner, point = np.concatenate([some for some, _ in crossings]), np.concatenate([some for _, some in crossings])
    enters = -np.sign(_upward(moved[owner])) * np.sign(signed)
    line = (point[:, 0] * (columns[1] + 1) + point[:, 1]).astype(np.int64)
    complete = np.bincount(line, enters)[line] == 0
    line, point, enters = line[complete], point[complete], enters[complete]
    order = np.lexsort((point[:, 2], line))
    line, point, depth = line[order], point[order], np.cumsum(enters[order])
    inside = (depth[:-1] > 0.5) & (line[:-1] == line[1:])
    low, high = point[:-1][inside, 2], point[1:][inside, 2]
    counted, weighted = float((high - low).sum()), float(((high - low) * depth[:-1][inside]).sum())
    volume = abs(signed) * (counted / weighted if weighted > 0 else 1.0)
    return Solid(volume, (point[:-1][inside, :2] + _SHIFT) * step + lower[:2], low, high)


def _signed_volume(triangles: Floats) -> float:
    """Return the volume by the divergence theorem; below zero if the mesh is inside out."""
    import numpy as np

    a, b, c = (triangles - triangles.mean(axis=(0, 1))).transpose(1, 0, 2)
    return float(np.einsum("ij,ij->", a, np.cross(b, c)) / 6)


def _upward(triangles: Floats) -> Floats:
    """Return twice the area of each triangle (n,) as seen from above; below zero if it looks down."""
    (p, q), (r, s) = (triangles[:, 1] - triangles[:, 0])[:, :2].T, (triangles[:, 2] - triangles[:, 0])[:, :2].T
    area: Floats = p * s - q * r
    return area
