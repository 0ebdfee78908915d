"""How well a shape fits: how much of it is outside the mesh, how far it sticks out, how much of the mesh it holds.

``Ruler`` measures a shape; what is inside of the mesh is told by ``Solid``, which looks along upright lines.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, NamedTuple

from rosorin_compile.model import Box, Capsule, Cylinder, Shape

from .fits import Fit
from .grid import MORE_DIVISIONS, divisions_needed, over_corners, samples
from .meshes import bounds
from .turning import seen_from

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    Floats = NDArray[np.float64]
    Ints = NDArray[np.int64]


# The surface of a mesh is sampled at its diagonal divided by this.
FINENESS = 150
# Sampled triangles that are looked at for the distance of a point, nearest sample first.
NEIGHBOURS = 12
# A point this far outside of a shape is on it, in metres: rounding of its numbers forgives half of that.
_ON = 2e-7
# Corners of a triangle that are closer are one, in metres: the square of a tiny edge is no divisor.
_ONE_CORNER = 1e-9


class Measured(NamedTuple):
    """How well a shape fits. Volumes in m^3, distances in metres, shares from 0 to 1.

    ``overhang`` is the volume of the shape outside the mesh, None if the mesh is not closed and has no inside;
    ``sticks_out`` the largest distance of a point of the shape from the mesh; ``overlap`` the share of the mesh inside
    the shape: of its volume, or of its surface if it is not closed.
    """

    volume: float
    overhang: float | None
    sticks_out: float
    overlap: float


class Ruler:
    """Measures shapes against one mesh of triangles (n, 3, 3)."""

    def __init__(self, triangles: Floats) -> None:
        import numpy as np
        from scipy.spatial import cKDTree  # type: ignore[import-untyped,unused-ignore]

        self.triangles = _without_needles(triangles)
        self.solid: Solid | None = solid(triangles) if closed(triangles) else None
        lower, upper = bounds(triangles)
        spacing = float(np.linalg.norm(upper - lower)) / FINENESS or 1.0
        self.owner, self.points = _sampled(triangles, spacing)
        self.tree = cKDTree(self.points)

    def measure(self, fit: Fit) -> Measured:
        """Return how well a shape fits."""
        if self.solid is None:
            overlap = self._surface_inside(fit)
            return Measured(fit.volume, None, self._sticks_out(fit), overlap)
        overlap = _volume_inside(self.solid, fit)
        overhang = max(0.0, fit.volume - overlap * self.solid.volume)
        return Measured(fit.volume, overhang, self._sticks_out(fit), overlap)

    def _sticks_out(self, fit: Fit) -> float:
        """Return the largest distance from points of the shape's surface to the mesh.

        The distance of a point is that to the nearest of the triangles of its nearest samples.
        """
        import numpy as np
        import trimesh

        closest: Any = trimesh.triangles.closest_point
        points = _surface(fit)
        _, near = self.tree.query(points, k=min(NEIGHBOURS, len(self.points)))
        near = near.reshape(len(points), -1)
        best = np.full(len(points), np.inf)
        for column in near.T:
            there = closest(self.triangles[self.owner[column]], points)
            best = np.minimum(best, np.linalg.norm(there - points, axis=1))
        return float(best.max())

    def _surface_inside(self, fit: Fit) -> float:
        """Return the share of the surface inside a shape: that of the samples of each triangle, weighted by area."""
        import numpy as np

        inside = np.zeros(len(self.points), dtype=bool)
        for piece in fit.pieces:
            inside |= _holds(piece, self.points)
        count = np.bincount(self.owner, minlength=len(self.triangles))
        held = np.bincount(self.owner, inside, minlength=len(self.triangles))
        edges = self.triangles[:, 1:] - self.triangles[:, :1]
        area = np.linalg.norm(np.cross(edges[:, 0], edges[:, 1]), axis=1)
        known = count > 0
        total = float(area[known].sum())
        return float((area[known] * held[known] / count[known]).sum()) / total if total > 0 else 1.0


def _without_needles(triangles: Floats) -> Floats:
    """Return triangles (n, 3, 3) whose first two corners are one where hardly anything is between them.

    trimesh divides by the square of that edge unless it is exactly zero.
    """
    import numpy as np

    first, second = triangles[:, 0], triangles[:, 1]
    needle = np.abs(second - first).max(axis=1) < _ONE_CORNER
    if not needle.any():
        return triangles
    made: Floats = triangles.copy()
    made[needle, 1] = first[needle]
    return made


def _sampled(triangles: Floats, spacing: float) -> tuple[Ints, Floats]:
    """Return samples of a mesh: for each its triangle (m,) and the point (m, 3); at most one in a cube of the spacing.

    The cubes only thin out triangles that are smaller than the spacing: a corner stands in many of them.
    """
    import numpy as np

    which = divisions_needed(triangles, spacing, MORE_DIVISIONS)
    batches = [(some[owner], points) for some, owner, points in samples(triangles, which, MORE_DIVISIONS)]
    owner, points = np.concatenate([a for a, _ in batches]), np.concatenate([b for _, b in batches])
    if len(points) < 500_000:
        return owner, points
    cubes = np.floor((points - points.min(axis=0)) / spacing * 2).astype(np.int64)
    number = (cubes[:, 0] * 4096 + cubes[:, 1]) * 4096 + cubes[:, 2]
    _, first = np.unique(number, return_index=True)
    first.sort()
    return owner[first], points[first]


def _volume_inside(inside: Solid, fit: Fit) -> float:
    """Return the share of a solid's volume inside a shape, by the pieces of the upright lines in both."""
    import numpy as np

    total = float((inside.high - inside.low).sum())
    held = 0.0
    for piece in fit.pieces:
        low, high = _along_lines(piece, inside.at)
        shared = np.minimum(inside.high, high + _ON) - np.maximum(inside.low, low - _ON)
        held += float(shared.clip(0, inside.high - inside.low).sum())
    return min(1.0, held / total) if total > 0 else 1.0


def _along_lines(shape: Shape, at: Floats) -> tuple[Floats, Floats]:
    """Return from where to where upright lines at places (m, 2) are inside a shape; low above high if they miss it."""
    import numpy as np

    start = seen_from(np.column_stack([at, np.zeros(len(at))]), shape.pose)
    way = seen_from(np.array([[shape.pose.xyz[0], shape.pose.xyz[1], shape.pose.xyz[2] + 1.0]]), shape.pose)[0]
    geometry = shape.geometry
    if isinstance(geometry, Box):
        return _between_planes(start, way, geometry.lower, geometry.upper)
    if isinstance(geometry, Cylinder):
        flat = _between_planes(
            start, way, (-math.inf, -math.inf, -geometry.length / 2), (math.inf, math.inf, geometry.length / 2)
        )
        return _both(flat, _in_ball(start, way, geometry.radius, 2))
    if not isinstance(geometry, Capsule):
        raise TypeError(f"no shape around a mesh: {geometry!r}")
    half = geometry.length / 2
    flat = _between_planes(start, way, (-math.inf, -math.inf, -half), (math.inf, math.inf, half))
    low, high = _both(flat, _in_ball(start, way, geometry.radius, 2))
    missed = low > high
    low, high = np.where(missed, np.inf, low), np.where(missed, -np.inf, high)
    for end in (-half, half):
        a, b = _in_ball(start - np.array([0, 0, end]), way, geometry.radius, 3)
        low, high = np.where(a <= b, np.minimum(low, a), low), np.where(a <= b, np.maximum(high, b), high)
    return low, high


def _between_planes(
    start: Floats, way: Floats, lower: tuple[float, ...], upper: tuple[float, ...]
) -> tuple[Floats, Floats]:
    """Return where lines from points (m, 3) along ``way`` are between planes across x, y and z."""
    import numpy as np

    low, high = np.full(len(start), -np.inf), np.full(len(start), np.inf)
    for axis in range(3):
        if math.isinf(lower[axis]):
            continue
        if abs(way[axis]) < 1e-12:
            outside = (start[:, axis] < lower[axis] - _ON) | (start[:, axis] > upper[axis] + _ON)
            high = np.where(outside, -np.inf, high)
            continue
        first, second = (lower[axis] - start[:, axis]) / way[axis], (upper[axis] - start[:, axis]) / way[axis]
        low, high = np.maximum(low, np.minimum(first, second)), np.minimum(high, np.maximum(first, second))
    return low, high


def _in_ball(start: Floats, way: Floats, radius: float, axes: int) -> tuple[Floats, Floats]:
    """Return where lines are within a radius of the origin, seen along x, y (2 axes: a tube) or x, y, z (a ball)."""
    import numpy as np

    a = float((way[:axes] ** 2).sum())
    b = start[:, :axes] @ way[:axes]
    c = (start[:, :axes] ** 2).sum(axis=1) - (radius + _ON) ** 2
    if a < 1e-20:  # along the tube
        return np.where(c <= 0, -np.inf, np.inf), np.where(c <= 0, np.inf, -np.inf)
    root = b * b - a * c
    width = np.sqrt(np.maximum(root, 0))
    return np.where(root >= 0, (-b - width) / a, np.inf), np.where(root >= 0, (-b + width) / a, -np.inf)


def _both(first: tuple[Floats, Floats], second: tuple[Floats, Floats]) -> tuple[Floats, Floats]:
    import numpy as np

    return np.maximum(first[0], second[0]), np.minimum(first[1], second[1])


def _holds(shape: Shape, points: Floats) -> NDArray[np.bool_]:
    """Say which points (m, 3) are inside a shape or on it."""
    import numpy as np

    seen = seen_from(points, shape.pose)
    geometry = shape.geometry
    if isinstance(geometry, Box):
        beyond = np.maximum(np.array(geometry.lower) - seen, seen - np.array(geometry.upper)).max(axis=1)
    elif isinstance(geometry, Cylinder):
        far, along = np.hypot(seen[:, 0], seen[:, 1]), abs(seen[:, 2])
        beyond = np.maximum(far - geometry.radius, along - geometry.length / 2)
    elif isinstance(geometry, Capsule):
        along = (abs(seen[:, 2]) - geometry.length / 2).clip(0)
        beyond = np.hypot(np.hypot(seen[:, 0], seen[:, 1]), along) - geometry.radius
    else:
        raise TypeError(f"no shape around a mesh: {geometry!r}")
    held: NDArray[np.bool_] = beyond <= _ON
    return held


def _surface(fit: Fit) -> Floats:
    """Return points (m, 3) on the surface of a shape, corners and edges included; not where its pieces meet."""
    import numpy as np

    visible = []
    for piece in fit.pieces:
        points, outward = _surface_of(piece)
        rotation = np.array(piece.pose.transform().rows)
        points, outward = points @ rotation.T + np.array(piece.pose.xyz), outward @ rotation.T
        outside = np.ones(len(points), dtype=bool)
        for other in fit.pieces:
            if other is not piece:
                outside &= ~_holds(other, points + 1e-6 * outward)
        visible.append(points[outside])
    return np.concatenate(visible)


def _surface_of(shape: Shape) -> tuple[Floats, Floats]:
    """Return points on the surface of a shape and where its outside is, both (m, 3), in the frame of the shape."""
    import numpy as np

    geometry = shape.geometry
    if isinstance(geometry, Box):
        return _faces(geometry)
    if not isinstance(geometry, Cylinder | Capsule):
        raise TypeError(f"no shape around a mesh: {geometry!r}")
    angles = np.linspace(0, 2 * np.pi, 73)[:-1]
    radius, half = geometry.radius, geometry.length / 2
    profile = [(radius, z) for z in np.linspace(-half, half, 25).tolist()]
    for end in (-1, 1):
        for share in np.linspace(0, 1, 13).tolist():
            tilt = share * math.pi / 2
            bulge = (radius * math.cos(tilt), end * (half + radius * math.sin(tilt)))
            profile.append((radius * share, end * half) if isinstance(geometry, Cylinder) else bulge)
    far, height = np.array(profile).T
    points = np.stack(
        [np.outer(far, np.cos(angles)), np.outer(far, np.sin(angles)), np.outer(height, np.ones(len(angles)))], axis=-1
    ).reshape(-1, 3)
    return points, points / np.linalg.norm(points, axis=1, keepdims=True).clip(1e-12)


def _faces(box: Box) -> tuple[Floats, Floats]:
    """Return points on the six faces of a box and their normals, both (m, 3)."""
    import numpy as np

    steps = np.linspace(0, 1, 25)
    first, second = (grid.ravel() for grid in np.meshgrid(steps, steps, indexing="ij"))
    points, normals = [], []
    for axis in range(3):
        for side in (0.0, 1.0):
            shares = np.insert(np.column_stack([first, second]), axis, side, axis=1)
            points.append(np.array(box.lower) + shares * np.array(box.size))
            normals.append(np.tile(np.eye(3)[axis] * (2 * side - 1), (len(first), 1)))
    return np.concatenate(points), np.concatenate(normals)


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
