"""Solids: the collision shapes of links as convex bodies, meshes as their hulls, and points that fill them."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import product
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from rosorin_compile.model import Box, Cylinder, Ellipsoid, Mesh, Shape, Sphere, Transform
from rosorin_compile.model.mesh_triangles import TriangleMesh
from rosorin_compile.rules.case import Case
from rosorin_compile.source.diagnostics import Diagnostic

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    Floats = NDArray[np.float64]
    Flags = NDArray[np.bool_]

PURPOSES = ("collision", "visual")
MOST_CORNERS = 250  # of a hull: more make collisions slow, and the hull not half a per cent larger
SAMPLES = 600  # points that fill a link
_ON_SURFACE = 4_000  # points on the surface of a mesh
_SMALLEST = 1e-6  # m: a smaller shape is a point


class Hull(NamedTuple):
    """A convex body: ``corners`` (n, 3) in metres and ``planes`` (m, 4), of which all are below zero inside."""

    corners: Floats
    planes: Floats
    volume: float

    @classmethod
    def around(cls, points: Floats) -> Hull | None:
        """Return the convex hull of points (n, 3), or None if they are in one plane."""
        from scipy.spatial import ConvexHull, QhullError  # type: ignore[import-untyped,unused-ignore]

        try:
            hull = ConvexHull(points)
        except (QhullError, ValueError):
            return None
        return cls(hull.points[hull.vertices], hull.equations, float(hull.volume))


@dataclass(frozen=True, eq=False)
class LoadedMesh:
    """A mesh file with its scale applied: ``triangles`` (n, 3, 3) in metres."""

    file: str
    triangles: Floats

    @cached_property
    def outline(self) -> Floats:
        """All corners (n, 3) of the convex hull; of a flat mesh all its corners."""
        corners: Floats = self.triangles.reshape(-1, 3)
        hull = Hull.around(corners)
        return corners if hull is None else hull.corners

    @cached_property
    def hull(self) -> Hull | None:
        """The convex hull with at most ``MOST_CORNERS`` corners, or None if the mesh is flat.

        Of more, these are the farthest in as many directions, on a spiral around the sphere.
        """
        import numpy as np

        corners = self.outline
        if len(corners) > MOST_CORNERS:
            steps = np.arange(MOST_CORNERS) + 0.5
            height, turn = 1 - 2 * steps / MOST_CORNERS, math.pi * (1 + math.sqrt(5)) * steps
            radius = np.sqrt(1 - height**2)
            directions = np.stack([radius * np.cos(turn), radius * np.sin(turn), height], axis=1)
            corners = corners[np.unique((directions @ corners.T).argmax(axis=1))]
        return Hull.around(corners)

    @cached_property
    def surface(self) -> Any:
        """A ``trimesh.Trimesh`` with equal corners merged."""
        import numpy as np
        import trimesh

        corners = self.triangles.reshape(-1, 3)
        surface = trimesh.Trimesh(corners, np.arange(len(corners)).reshape(-1, 3), process=False)
        surface.merge_vertices()
        return surface


class MeshShape(NamedTuple):
    """A shape with a mesh: its link, "collision" or "visual", and its number there."""

    link: str
    purpose: str
    number: int
    mesh: Mesh


Meshes = Mapping[Mesh, LoadedMesh]  # those that could be read


def mesh_shapes(case: Case) -> Iterator[MeshShape]:
    """Yield the shapes with meshes, in the order of the description."""
    for link, purpose in product(case.robot.links, PURPOSES):
        for number, shape in enumerate(getattr(link, purpose)):
            if isinstance(shape.geometry, Mesh):
                yield MeshShape(link.name, purpose, number, shape.geometry)


def read_meshes(
    case: Case, shapes: Sequence[MeshShape], files: Mapping[str, Path], tick: Callable[[], None] = lambda: None
) -> tuple[Meshes, list[Diagnostic]]:
    """Read the meshes of shapes; return them with a warning for each that cannot be read. Calls ``tick`` per shape."""
    meshes: dict[Mesh, LoadedMesh] = {}
    problems: dict[Mesh, Diagnostic] = {}
    for shape in shapes:
        if shape.mesh not in meshes and shape.mesh not in problems:
            found = TriangleMesh.of_shape(case, shape[:3], files)
            if isinstance(found, Diagnostic):
                problems[shape.mesh] = found
            else:
                meshes[shape.mesh] = LoadedMesh(shape.mesh.file, found.triangles)
        tick()
    return meshes, list(problems.values())


@dataclass(frozen=True, eq=False)
class Solid:
    """A collision shape: its number in ``link.collision``, its place in its body, and its mesh, which is not flat.

    ``type`` and ``size`` are those of MuJoCo's geom, ``half`` half the sides (m) of the box around a primitive.
    """

    link: str
    number: int
    shape: Shape
    place: Transform
    mesh: LoadedMesh | None = None

    @property
    def hull(self) -> Hull | None:
        """The hull of the mesh, or None for a primitive."""
        return self.mesh.hull if self.mesh else None

    @property
    def type(self) -> str:
        """The name of the type of the geom in MuJoCo."""
        return f"mjGEOM_{type(self.shape.geometry).__name__.upper()}"

    @property
    def size(self) -> list[float]:
        """The sizes of the geom of a primitive."""
        geometry: Any = self.shape.geometry
        if isinstance(geometry, Box):
            return [side / 2 for side in geometry.size]
        if isinstance(geometry, Ellipsoid):
            return list(geometry.radii)
        length = geometry.radius if isinstance(geometry, Sphere) else geometry.length / 2
        return [geometry.radius, length, geometry.radius]

    @property
    def half(self) -> list[float]:
        """Half the sides (m) of the box around a primitive."""
        if isinstance(self.shape.geometry, (Box, Ellipsoid, Sphere)):
            return self.size
        radius, length, _ = self.size
        return [radius, radius, length if isinstance(self.shape.geometry, Cylinder) else length + radius]

    @property
    def volume(self) -> float:
        """The volume in m^3, of a mesh that of its hull."""
        return self.hull.volume if self.hull else self.shape.volume

    def in_body(self, points: Floats) -> Floats:
        """Transform points (n, 3) from the frame of the shape to that of its body."""
        import numpy as np

        placed: Floats = points @ np.array(self.place.rows).T + np.array(self.place.xyz)
        return placed

    def contains(self, points: Floats, exact: bool = False) -> Flags:
        """Return which points (n, 3) in the frame of the body are inside; ``exact``: in the mesh, not in its hull."""
        import numpy as np

        local = (points - np.array(self.place.xyz)) @ np.array(self.place.rows)
        if exact and self.mesh is not None:
            return np.asarray(_winding(self.mesh.triangles, local) > 0.5)
        return self._contains(local)

    def _contains(self, points: Floats) -> Flags:
        import numpy as np

        if self.hull is not None:
            return np.asarray((points @ self.hull.planes[:, :3].T + self.hull.planes[:, 3] <= 0).all(axis=1))
        half = self.half
        if isinstance(self.shape.geometry, Box):
            return np.asarray((np.abs(points) <= half).all(axis=1))
        if isinstance(self.shape.geometry, (Sphere, Ellipsoid)):
            return np.asarray(((points / half) ** 2).sum(axis=1) <= 1)
        radius, across, along = half[0], (points[:, :2] ** 2).sum(axis=1), np.abs(points[:, 2])
        if isinstance(self.shape.geometry, Cylinder):
            return np.asarray((across <= radius**2) & (along <= half[2]))
        return np.asarray(across + np.maximum(along - half[2] + radius, 0) ** 2 <= radius**2)

    def corners(self) -> Floats:
        """Return corners (n, 3) around the solid in the frame of its body."""
        import numpy as np

        if self.mesh is not None:
            return self.in_body(self.hull.corners if self.hull else self.mesh.triangles.reshape(-1, 3))
        return self.in_body(np.array(list(product(*((-side, side) for side in self.half)))))

    def sample(self, count: int, generator: Any) -> Floats:
        """Return at most ``count`` random points (n, 3) inside the solid in the frame of its body."""
        import numpy as np

        upper = np.array(self.half) if self.hull is None else self.hull.corners.max(axis=0)
        lower = -upper if self.hull is None else self.hull.corners.min(axis=0)
        points = lower + generator.random((4 * count, 3)) * (upper - lower)
        return self.in_body(points[self._contains(points)][:count])

    def surface(self) -> Floats:
        """Return points (n, 3) on the mesh in the frame of its body; of a primitive, points that fill it."""
        import numpy as np

        if self.mesh is None:
            return self.sample(SAMPLES, np.random.default_rng(2))
        triangles = self.mesh.triangles
        points = np.concatenate([triangles.mean(axis=1), triangles.reshape(-1, 3)])
        return self.in_body(points[:: 1 + len(points) // _ON_SURFACE])


def solids_of(shapes: Sequence[Shape], link: str, place: Transform, meshes: Meshes) -> list[Solid]:
    """Return the shapes of a link that have a volume; ``place`` is the frame of the link in its body."""
    solids = []
    for number, shape in enumerate(shapes):
        for piece in shape.solids():
            mesh = meshes.get(piece.geometry) if isinstance(piece.geometry, Mesh) else None
            solid = Solid(link, number, piece, place.then(piece.origin().transform()), mesh)
            if isinstance(piece.geometry, Mesh):
                has_volume = solid.hull is not None and solid.volume >= _SMALLEST**3
            else:
                has_volume = all(math.isfinite(size) and size > _SMALLEST for size in solid.size)
            solids += [solid] if has_volume else []
    return solids


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
