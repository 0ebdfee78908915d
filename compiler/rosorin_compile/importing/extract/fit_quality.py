"""Measure how well a shape fits a mesh: its overhang, how far it sticks out, how much of the mesh it encloses."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

from rosorin_compile.model import Box, Capsule, Cylinder, Shape

from .shapes import Fit, in_frame

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    Floats = NDArray[np.float64]

_FINENESS = 50  # samples of the mesh surface along the diagonal of the mesh
_NEIGHBOURS = 12  # nearest samples whose triangles are tried for the distance of a point
_TOLERANCE = 2e-7  # m: a point this far outside a shape is on its surface
_SURFACE_STEPS = 50  # samples of the shape surface along its diagonal


class FitQuality(NamedTuple):
    """How well a shape fits. Volumes in m^3, distances in metres, fractions from 0 to 1.

    ``overhang`` is the volume of the shape outside the mesh, None for an open mesh. ``sticks_out`` is the largest
    distance of a point of the shape from the mesh. ``overlap`` is the fraction of the mesh that the shape encloses.
    """

    volume: float
    overhang: float | None
    sticks_out: float
    overlap: float


class FitGauge:
    """Measures shapes around one mesh of triangles (n, 3, 3)."""

    def __init__(self, triangles: Floats) -> None:
        import numpy as np
        from scipy.spatial import cKDTree  # type: ignore[import-untyped,unused-ignore]
        from trimesh.remesh import subdivide_to_size

        self.volume = _closed_volume(triangles)
        # Tiny edges become exactly zero: trimesh divides by the square of any other.
        self.triangles = np.round(triangles, 9)
        points = self.triangles.reshape(-1, 3)
        spacing = float(np.linalg.norm(np.ptp(points, axis=0))) / _FINENESS or 1.0
        faces = np.arange(len(points)).reshape(-1, 3)
        corners, pieces, self.owner = subdivide_to_size(points, faces, spacing, max_iter=30, return_index=True)
        pieces = corners[pieces]
        self.samples = pieces.mean(axis=1)
        self.areas = np.linalg.norm(np.cross(pieces[:, 1] - pieces[:, 0], pieces[:, 2] - pieces[:, 0]), axis=1)
        self.tree = cKDTree(self.samples)

    def measure(self, fit: Fit) -> FitQuality:
        """Measure how well a shape fits the mesh."""
        import numpy as np

        inside = np.any([_contains(piece, self.samples) for piece in fit.pieces], axis=0)
        total = float(self.areas.sum())
        overlap = float(self.areas[inside].sum()) / total if total > 0 and not inside.all() else 1.0
        overhang = None if self.volume is None else max(0.0, fit.volume - self.volume)
        return FitQuality(fit.volume, overhang, self._sticks_out(fit), overlap)

    def _sticks_out(self, fit: Fit) -> float:
        """Return the largest distance from the shape's surface to the mesh, among the triangles nearby."""
        import numpy as np
        from trimesh.triangles import closest_point

        points = _visible_surface(fit)
        _, near = self.tree.query(points, k=min(_NEIGHBOURS, len(self.samples)))
        distances = [
            np.linalg.norm(closest_point(self.triangles[self.owner[column]], points) - points, axis=1)
            for column in near.reshape(len(points), -1).T
        ]
        return float(np.min(distances, axis=0).max())


def _closed_volume(triangles: Floats) -> float | None:
    """Return the volume in m^3 of a closed mesh, or None. Where its bodies overlap, the overlap counts twice.

    A mesh is closed if each edge is used equally often in both directions. Unlike ``Trimesh.is_watertight``, this
    accepts bodies that touch and share edges.
    """
    import numpy as np
    import trimesh

    mesh = trimesh.Trimesh(triangles.reshape(-1, 3), np.arange(len(triangles) * 3).reshape(-1, 3), process=True)
    start, end = mesh.faces.ravel(), np.roll(mesh.faces, -1, axis=1).ravel()
    _, edge = np.unique(np.minimum(start, end) * (3 * len(triangles)) + np.maximum(start, end), return_inverse=True)
    is_closed = not np.bincount(edge.ravel(), np.sign(end - start)).any()
    a, b, c = (triangles - triangles.mean(axis=(0, 1))).transpose(1, 0, 2)
    return abs(float(np.einsum("ij,ij->", a, np.cross(b, c)))) / 6 or None if is_closed else None


def _contains(shape: Shape, points: Floats) -> NDArray[np.bool_]:
    """Return which points (m, 3) are inside a shape or on its surface."""
    import numpy as np

    local, geometry = in_frame(points, shape.pose), shape.geometry
    if isinstance(geometry, Box):
        beyond = np.maximum(np.array(geometry.lower) - local, local - np.array(geometry.upper)).max(axis=1)
    else:
        assert isinstance(geometry, Cylinder | Capsule)  # noqa: S101 - fits have no other shape
        radial, axial = np.hypot(local[:, 0], local[:, 1]), abs(local[:, 2]) - geometry.length / 2
        if isinstance(geometry, Cylinder):
            beyond = np.maximum(radial - geometry.radius, axial)
        else:
            beyond = np.hypot(radial, axial.clip(0)) - geometry.radius
    contained: NDArray[np.bool_] = beyond <= _TOLERANCE
    return contained


def _visible_surface(fit: Fit) -> Floats:
    """Return points (m, 3) on the surface of a shape, without those where its pieces touch."""
    import numpy as np

    visible = []
    for piece in fit.pieces:
        local = _surface_points(piece)
        middle = local.mean(axis=0)
        outside = middle + (local - middle) * (1 + 1e-6 / np.abs(local - middle).max(axis=1, keepdims=True))
        points, beyond = (
            some @ np.array(piece.pose.transform().rows).T + np.array(piece.pose.xyz) for some in (local, outside)
        )
        hidden = np.zeros(len(points), dtype=bool)
        for other in fit.pieces:
            if other is not piece:
                hidden |= _contains(other, beyond)
        visible.append(points[~hidden])
    return np.concatenate(visible)


def _surface_points(shape: Shape) -> Floats:
    """Return points (m, 3) on the surface of a shape, corners and edges included, in the shape's frame."""
    from trimesh import creation
    from trimesh.remesh import subdivide_to_size

    geometry = shape.geometry
    if isinstance(geometry, Box):
        mesh = creation.box(bounds=(geometry.lower, geometry.upper))
    elif isinstance(geometry, Cylinder):
        mesh = creation.cylinder(geometry.radius, geometry.length, sections=72)
    else:
        assert isinstance(geometry, Capsule)  # noqa: S101 - fits have no other shape
        mesh = creation.capsule(geometry.length, geometry.radius, count=(72, 25))
    points, _ = subdivide_to_size(mesh.vertices, mesh.faces, mesh.scale / _SURFACE_STEPS, max_iter=30)
    surface: Floats = points
    return surface
