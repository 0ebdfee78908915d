"""The meshes of a robot: found, read once, with their hulls. What cannot be read is told, and left out."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from rosorin_compile.model import Mesh, Shape
from rosorin_compile.model.mesh_triangles import TriangleMesh
from rosorin_compile.rules.case import Case
from rosorin_compile.source.diagnostics import Diagnostic

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    Floats = NDArray[np.float64]

PURPOSES = ("collision", "visual")
MOST_CORNERS = 250  # of a hull: more make it slow, and not half a per cent larger


class Hull(NamedTuple):
    """A convex body: its ``corners`` (n, 3) in metres, and ``planes`` (m, 4); inside is where all are below zero."""

    corners: Floats
    planes: Floats
    volume: float


@dataclass(frozen=True, eq=False)
class Loaded:
    """A mesh that was read: ``triangles`` (n, 3, 3) in metres, times its scale."""

    file: str
    triangles: Floats

    @cached_property
    def box(self) -> tuple[Floats, Floats]:
        """The lower and the upper corner (3,) in metres."""
        return self.triangles.min(axis=(0, 1)), self.triangles.max(axis=(0, 1))

    @property
    def longest(self) -> float:
        """The longest side of the box (m)."""
        lower, upper = self.box
        return float((upper - lower).max())

    @cached_property
    def hull(self) -> Hull | None:
        """The convex hull, of very many corners those that stand out most; None of a mesh that is flat."""
        from scipy.spatial import ConvexHull, QhullError  # type: ignore[import-untyped,unused-ignore]

        try:
            made = ConvexHull(self.outline)
            if len(made.vertices) > MOST_CORNERS:
                made = ConvexHull(_standing_out(made.points[made.vertices]))
        except (QhullError, ValueError):
            return None
        return Hull(made.points[made.vertices], made.equations, float(made.volume))

    @cached_property
    def outline(self) -> Floats:
        """The corners (n, 3) of the convex hull, all of them; those of a flat mesh itself."""
        from scipy.spatial import ConvexHull, QhullError

        corners: Floats = self.triangles.reshape(-1, 3)
        try:
            made = ConvexHull(corners)
        except (QhullError, ValueError):
            return corners
        whole: Floats = made.points[made.vertices]
        return whole

    @cached_property
    def surface(self) -> Any:
        """The mesh as trimesh has it, equal corners as one."""
        import numpy as np
        import trimesh

        corners = self.triangles.reshape(-1, 3)
        made = trimesh.Trimesh(corners, np.arange(len(corners)).reshape(-1, 3), process=False)
        made.merge_vertices()
        return made

    @property
    def is_closed(self) -> bool:
        """Whether the surface has an inside."""
        return bool(self.surface.is_watertight)


def _standing_out(corners: Floats) -> Floats:
    """Return of corners (n, 3) those that are farthest in one of many directions, which a spiral goes through."""
    import numpy as np

    steps = np.arange(MOST_CORNERS) + 0.5
    height = 1 - 2 * steps / MOST_CORNERS
    around, turn = np.sqrt(1 - height**2), math.pi * (1 + math.sqrt(5)) * steps
    directions = np.stack([around * np.cos(turn), around * np.sin(turn), height], axis=1)
    found: Floats = corners[np.unique((directions @ corners.T).argmax(axis=1))]
    return found


class Named(NamedTuple):
    """A shape with a mesh: of which link, for what, and its number there."""

    link: str
    purpose: str
    number: int
    shape: Shape
    mesh: Mesh


def named_meshes(case: Case) -> Iterator[Named]:
    """Yield the shapes with meshes, in the order of the description."""
    for link in case.robot.links:
        for purpose in PURPOSES:
            for index, shape in enumerate(getattr(link, purpose)):
                if isinstance(shape.geometry, Mesh):
                    yield Named(link.name, purpose, index, shape, shape.geometry)


class Meshes:
    """Reads the meshes of a robot, whose ``files`` were found by their names in the description."""

    def __init__(self, case: Case, files: Mapping[str, Path]) -> None:
        self.case = case
        self.files = files
        self.told: list[Diagnostic] = []
        self._known: dict[Mesh, Loaded | None] = {}

    def of(self, geometry: Mesh) -> Loaded | None:
        """Return a mesh that was read by ``read``; None if it could not be."""
        return self._known.get(geometry)

    def read(self, named: Named) -> Loaded | None:
        """Return the mesh of a shape; None, after a warning at its place, if it cannot be read."""
        if named.mesh not in self._known:
            self._known[named.mesh] = self._read(named)
        return self._known[named.mesh]

    def _read(self, named: Named) -> Loaded | None:
        found = TriangleMesh.of_shape(self.case, (named.link, named.purpose, named.number), self.files)
        if isinstance(found, Diagnostic):
            self.told.append(found)
            return None
        return Loaded(named.mesh.file, found.triangles)
