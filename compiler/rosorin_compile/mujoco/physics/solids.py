"""Solids: the collision shapes of links as convex bodies, meshes as their hulls, and points that fill them."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import product
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from rosorin_compile.model import Box, Capsule, Cylinder, Ellipsoid, Mesh, Shape, Transform
from rosorin_compile.model.mesh_triangles import TriangleMesh
from rosorin_compile.rules.case import Case
from rosorin_compile.source.diagnostics import Diagnostic
from rosorin_compile.source.progress import Progress

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    Floats = NDArray[np.float64]

SAMPLES = 600  # points that fill a link
_ON_SURFACE = 4_000  # points on the surface of a mesh
_SMALLEST = 1e-6  # m: a smaller shape is a point


class MeshShape(NamedTuple):
    """A shape with a mesh: its link, "collision" or "visual", and its number there."""

    link: str
    purpose: str
    number: int
    mesh: Mesh


Meshes = Mapping[Mesh, Any]  # those that could be read, as ``trimesh.Trimesh`` in metres, with equal corners merged


def mesh_shapes(case: Case) -> Iterator[MeshShape]:
    """Yield the shapes with meshes, in the order of the description."""
    for link, purpose in product(case.robot.links, ("collision", "visual")):
        for number, shape in enumerate(getattr(link, purpose)):
            if isinstance(shape.geometry, Mesh):
                yield MeshShape(link.name, purpose, number, shape.geometry)


def read_meshes(case: Case, shapes: Sequence[MeshShape], files: Mapping[str, Path]) -> tuple[Meshes, list[Diagnostic]]:
    """Read the meshes of shapes; return them with a warning for each that cannot be read."""
    import numpy as np
    import trimesh

    meshes: dict[Mesh, Any] = {}
    problems: dict[Mesh, Diagnostic] = {}
    for number, shape in enumerate(shapes):
        Progress.step("reading meshes", number, len(shapes))
        if shape.mesh not in meshes and shape.mesh not in problems:
            found = TriangleMesh.of_shape(case, shape[:3], files)
            if isinstance(found, Diagnostic):
                problems[shape.mesh] = found
            else:
                corners = found.triangles.reshape(-1, 3)
                mesh = trimesh.Trimesh(corners, np.arange(len(corners)).reshape(-1, 3), process=False)
                mesh.merge_vertices()
                meshes[shape.mesh] = mesh
    return meshes, list(problems.values())


@dataclass(frozen=True, eq=False)
class Solid:
    """A collision shape: its number in ``link.collision``, its place in the link, and its ``trimesh.Trimesh``, if any.

    A primitive is a polyhedron where points are concerned, and itself in MuJoCo.
    """

    link: str
    number: int
    shape: Shape
    place: Transform
    mesh: Any = None

    @property
    def size(self) -> list[float]:
        """The sizes of the geom of a primitive in MuJoCo."""
        geometry: Any = self.shape.geometry
        if isinstance(geometry, Box):
            return [side / 2 for side in geometry.size]
        if isinstance(geometry, Ellipsoid):
            return list(geometry.radii)
        is_long = isinstance(geometry, (Cylinder, Capsule))
        return [geometry.radius, geometry.length / 2 if is_long else geometry.radius, geometry.radius]

    @cached_property
    def hull(self) -> Any:
        """The convex hull as a ``trimesh.Trimesh`` in the frame of the shape, or None for a flat mesh."""
        import trimesh
        from scipy.spatial import QhullError  # type: ignore[import-untyped,unused-ignore]

        geometry: Any = self.shape.geometry
        if isinstance(geometry, Mesh):
            try:
                return self.mesh.convex_hull
            except (QhullError, ValueError):
                return None
        if isinstance(geometry, Box):
            return trimesh.creation.box(geometry.size)
        if isinstance(geometry, Cylinder):
            return trimesh.creation.cylinder(geometry.radius, geometry.length)
        if isinstance(geometry, Capsule):
            return trimesh.creation.capsule(geometry.length, geometry.radius)
        return trimesh.creation.icosphere(3).apply_scale(self.size)

    @property
    def is_body(self) -> bool:
        """Whether it has a volume."""
        if isinstance(self.shape.geometry, Mesh):
            return self.mesh is not None and self.hull is not None and self.hull.volume >= _SMALLEST**3
        return all(math.isfinite(size) and size > _SMALLEST for size in self.size)

    def in_link(self, points: Floats) -> Floats:
        """Transform points (n, 3) from the frame of the shape to that of its link."""
        import numpy as np

        placed: Floats = points @ np.array(self.place.rows).T + np.array(self.place.xyz)
        return placed

    def contains(self, points: Floats, exact: bool = False) -> Any:
        """Return which points (n, 3) in the frame of the link are inside; ``exact``: in the mesh, not in its hull."""
        import numpy as np

        local = (points - np.array(self.place.xyz)) @ np.array(self.place.rows)
        return _winding(self.mesh.triangles, local) > 0.5 if exact and self.mesh is not None else self._in_hull(local)

    def _in_hull(self, points: Floats) -> Any:
        normals = self.hull.face_normals
        return (points @ normals.T <= (normals * self.hull.triangles[:, 0]).sum(axis=1)).all(axis=1)

    def sample(self, count: int, generator: Any) -> Floats:
        """Return at most ``count`` random points (n, 3) inside the solid in the frame of its link."""
        lower, upper = self.hull.bounds
        points = lower + generator.random((4 * count, 3)) * (upper - lower)
        return self.in_link(points[self._in_hull(points)][:count])

    def surface(self) -> Floats:
        """Return points (n, 3) on the mesh in the frame of its link; of a primitive, points that fill it."""
        import numpy as np

        if self.mesh is None:
            return self.sample(SAMPLES, np.random.default_rng(2))
        points = np.concatenate([self.mesh.triangles_center, self.mesh.triangles.reshape(-1, 3)])
        return self.in_link(points[:: 1 + len(points) // _ON_SURFACE])


def solids_of(shapes: Sequence[Shape], link: str, meshes: Meshes) -> list[Solid]:
    """Return the shapes of a link that have a volume, in its frame."""
    solids = []
    for number, shape in enumerate(shapes):
        for piece in shape.solids():
            mesh = meshes.get(piece.geometry) if isinstance(piece.geometry, Mesh) else None
            solids.append(Solid(link, number, piece, piece.origin().transform(), mesh))
    return [solid for solid in solids if solid.is_body]


def _winding(triangles: Floats, points: Floats) -> Floats:
    """Return how often a surface of triangles (m, 3, 3) winds around points (n, 3): 1 inside a closed one, 0 outside.

    The sum of the solid angles (A. Van Oosterom, J. Strackee, 1983); a surface with holes gives something between
    (A. Jacobson, L. Kavan, O. Sorkine-Hornung, "Robust inside-outside segmentation using generalized winding numbers",
    2013). One that is inside out winds the other way, which counts the same.
    """
    import numpy as np

    numbers = np.zeros(len(points))
    for index, point in enumerate(points):
        a, b, c = (triangles[:, corner] - point for corner in range(3))
        x, y, z = (np.linalg.norm(side, axis=1) for side in (a, b, c))
        over = np.einsum("ij,ij->i", a, np.cross(b, c))
        under = x * y * z + (a * b).sum(1) * z + (b * c).sum(1) * x + (c * a).sum(1) * y
        numbers[index] = abs(float(np.arctan2(over, under).sum())) / (2 * math.pi)
    return numbers
