"""The parts of a robot in MuJoCo: which of them are inside each other at joint positions, and how far.

A body of the scene is what no joint moves against each other. Each of them floats, and is put where the model has it,
so that nothing here depends on joints of MuJoCo or on which neighbours it lets collide. Meshes are their convex hulls,
as simulators take them.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from importlib import import_module
from itertools import product
from typing import TYPE_CHECKING, Any, NamedTuple

from rosorin_compile.model import (
    Box,
    Capsule,
    Cylinder,
    Ellipsoid,
    Geometry,
    Joint,
    Mesh,
    Robot,
    Shape,
    Sphere,
    Transform,
)

from .files import Hull, Loaded, Meshes

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    Floats = NDArray[np.float64]
    Flags = NDArray[np.bool_]

# What printing and the search for the depth cost, and what touching parts may overlap by (m).
LEAST = 5e-4
# Points that a part is sampled with, to say how much of it is inside another one.
SAMPLES = 600
_MEMORY = 2**28  # bytes for contacts: parts that are full of each other have many
_ON_SURFACE, _ASKED = 4_000, 150  # points of a mesh, and of those in the hull of the other how many are asked
_SMALLEST = 1e-6  # MuJoCo's own limit is less; a shape of this size (m) is a point

Pair = tuple[str, str]  # two links; the one that is nearer to the root first


class Solid(NamedTuple):
    """A shape of a link: its number in ``collision``, its place in its body, and the mesh, if it is one."""

    link: str
    number: int
    shape: Shape
    place: Transform
    mesh: Loaded | None

    @property
    def hull(self) -> Hull | None:
        """The hull of a mesh, which is not flat."""
        return self.mesh.hull if self.mesh else None

    @property
    def volume(self) -> float:
        """The volume in m^3, of a mesh that of its hull."""
        return self.hull.volume if self.hull else self.shape.volume


class Overlap(NamedTuple):
    """How deep (m) two links are in each other, and the two shapes where it is deepest."""

    depth: float
    one: Solid
    other: Solid


class Scene:
    """The collision shapes of a robot, and what is inside what.

    ``joint_between`` has the joint of two bodies that hang on each other, by the numbers of the bodies.
    """

    def __init__(self, robot: Robot, meshes: Meshes) -> None:
        self.robot = robot
        self.order = {link.name: number for number, link in enumerate(robot.walk())}
        self.tops: list[str] = []
        self.body_of: dict[str, int] = {}
        self.joint_between: dict[frozenset[int], Joint] = {}
        self.solids: list[Solid] = []
        places: dict[str, Transform] = {}
        for link in robot.walk():
            joint = robot.joint_to.get(link.name)
            if joint is not None and joint.is_fixed:
                self.body_of[link.name] = self.body_of[joint.parent]
                places[link.name] = places[joint.parent].then(joint.origin.transform())
            else:
                self.body_of[link.name] = len(self.tops)
                self.tops.append(link.name)
                places[link.name] = Transform()
                if joint is not None:
                    pair = frozenset((self.body_of[joint.parent], self.body_of[link.name]))
                    self.joint_between[pair] = joint
            self.solids += solids_of(link.collision, link.name, places[link.name], meshes)
        self.of_link: dict[str, list[Solid]] = {}
        for solid in self.solids:
            self.of_link.setdefault(solid.link, []).append(solid)
        self.apart = {frozenset(pair) for pair in robot.disabled_contacts}
        self.mujoco: Any = import_module("mujoco")
        self.model, self.data = self._made()
        self._points: dict[str, Floats] = {}

    def _made(self) -> tuple[Any, Any]:
        mujoco = self.mujoco
        spec = mujoco.MjSpec()
        spec.memory = _MEMORY
        spec.compiler.inertiafromgeom = mujoco.mjtInertiaFromGeom.mjINERTIAFROMGEOM_FALSE  # MuJoCo 3.3 asks otherwise
        bodies = []
        for number in range(len(self.tops)):
            body = spec.worldbody.add_body(name=f"b{number}", explicitinertial=True, mass=1.0, inertia=[1.0, 1.0, 1.0])
            body.add_freejoint()
            bodies.append(body)
        for number, solid in enumerate(self.solids):
            geometry = solid.shape.geometry
            values: dict[str, Any] = {"pos": solid.place.xyz, "quat": solid.place.quaternion()}
            if solid.mesh is not None:
                spec.add_mesh(name=str(number), uservert=self.corners(solid.mesh).ravel())
                values |= {"type": mujoco.mjtGeom.mjGEOM_MESH, "meshname": str(number)}
            else:
                kind, size = _primitive(geometry)
                values |= {"type": getattr(mujoco.mjtGeom, kind), "size": size}
            bodies[self.body_of[solid.link]].add_geom(**values)
        for one, other in self.excluded():
            spec.add_exclude(bodyname1=bodies[one].name, bodyname2=bodies[other].name)
        model = spec.compile()
        # MuJoCo numbers geoms by body; the solids follow it.
        order = sorted(range(len(self.solids)), key=lambda number: self.body_of[self.solids[number].link])
        self.solids = [self.solids[number] for number in order]
        return model, mujoco.MjData(model)

    def corners(self, mesh: Loaded) -> Floats:
        """Return the corners (n, 3) whose hull stands for a mesh, which is not flat."""
        if mesh.hull is None:
            raise ValueError("a flat mesh has no hull")
        return mesh.hull.corners

    def excluded(self) -> Iterable[tuple[int, int]]:
        """Return the bodies that MuJoCo is not to look at together, by their numbers."""
        return ()

    def poses(self, positions: Mapping[str, float]) -> list[Transform]:
        """Return where each body is in the root frame at joint positions (rad or m)."""
        placed = self.robot.poses_in_root(positions)
        return [placed[top] for top in self.tops]

    def overlaps(self, positions: Mapping[str, float]) -> dict[Pair, Overlap]:
        """Return the links that are inside each other at joint positions (rad or m), those that may be left aside."""
        import numpy as np

        if not self.solids:
            return {}
        rows = [(*pose.xyz, *pose.quaternion()) for pose in self.poses(positions)]
        self.data.qpos[:] = np.array(rows).ravel()
        self.mujoco.mj_kinematics(self.model, self.data)
        self.mujoco.mj_collision(self.model, self.data)
        contact = self.data.contact
        found: dict[Pair, Overlap] = {}
        for number in np.flatnonzero(contact.dist < -LEAST):
            one, other = (self.solids[geom] for geom in contact.geom[number])
            if self.order[one.link] > self.order[other.link]:
                one, other = other, one
            pair, depth = (one.link, other.link), -float(contact.dist[number])
            if frozenset(pair) not in self.apart and (pair not in found or found[pair].depth < depth):
                found[pair] = Overlap(depth, one, other)
        return found

    def joint_of(self, pair: Pair) -> Joint | None:
        """Return the joint that two links are neighbours by; None if they are not."""
        return self.joint_between.get(frozenset((self.body_of[pair[0]], self.body_of[pair[1]])))

    def smaller(self, pair: Pair) -> tuple[str, str]:
        """Return the two links, the one with less volume first."""
        one, other = sorted(pair, key=lambda name: sum(solid.volume for solid in self.of_link[name]))
        return one, other

    def share(self, small: str, large: str, positions: Mapping[str, float], exact: bool = False) -> float:
        """Return how much of the volume of a link (0 to 1) is inside another one, or the hulls of its meshes.

        ``exact``: inside the meshes themselves, of which a few points are asked.
        """
        import numpy as np

        poses = self.poses(positions)
        way = poses[self.body_of[large]].inverse().then(poses[self.body_of[small]])
        points = self.points(small) @ np.array(way.rows).T + np.array(way.xyz)
        points = points[:: 1 + len(points) // _ASKED] if exact else points
        inside = np.zeros(len(points), dtype=bool)
        for solid in self.of_link[large]:
            inside |= _is_within(solid, points) if exact and solid.mesh else _inside(solid, points)
        return float(inside.mean()) if len(points) else 0.0

    def touches(self, overlap: Overlap, positions: Mapping[str, float]) -> bool:
        """Say whether two shapes are inside each other as they are, and not by the hulls of their meshes alone.

        Asked of corners and middles of triangles: whether one of them is inside the other shape.
        """
        import numpy as np

        if overlap.one.mesh is None and overlap.other.mesh is None:
            return True
        poses = self.poses(positions)
        for solid, other in ((overlap.one, overlap.other), (overlap.other, overlap.one)):
            way = poses[self.body_of[other.link]].inverse().then(poses[self.body_of[solid.link]])
            points = _surface(solid) @ np.array(way.rows).T + np.array(way.xyz)
            points = points[_inside(other, points)]
            if not len(points):
                continue
            if _is_within(other, points[:: 1 + len(points) // _ASKED]).any():
                return True
        return False

    def points(self, link: str) -> Floats:
        """Return points (n, 3) that fill the shapes of a link, in the frame of its body."""
        import numpy as np

        if link not in self._points:
            solids = self.of_link[link]
            volume = sum(solid.volume for solid in solids) or 1.0
            generator = np.random.default_rng(1)
            made = [_sampled(solid, max(8, round(SAMPLES * solid.volume / volume)), generator) for solid in solids]
            self._points[link] = np.concatenate(made)
        return self._points[link]


def solids_of(shapes: tuple[Shape, ...], link: str, place: Transform, meshes: Meshes) -> list[Solid]:
    """Return the shapes of a link that have a body."""
    made = []
    for index, shape in enumerate(shapes):
        for solid in shape.solids():
            mesh = None
            if isinstance(solid.geometry, Mesh):
                mesh = meshes.of(solid.geometry)
                if mesh is None or mesh.hull is None or mesh.hull.volume < _SMALLEST**3:
                    continue
            elif not all(math.isfinite(size) and size > _SMALLEST for size in _primitive(solid.geometry)[1]):
                continue
            made.append(Solid(link, index, solid, place.then(solid.origin().transform()), mesh))
    return made


def _primitive(geometry: Geometry) -> tuple[str, list[float]]:
    """Return how MuJoCo calls a primitive, and its sizes as MuJoCo counts them."""
    if isinstance(geometry, Box):
        return "mjGEOM_BOX", [side / 2 for side in geometry.size]
    if isinstance(geometry, Sphere):
        return "mjGEOM_SPHERE", [geometry.radius] * 3
    if isinstance(geometry, Ellipsoid):
        return "mjGEOM_ELLIPSOID", list(geometry.radii)
    if isinstance(geometry, (Cylinder, Capsule)):
        kind = "mjGEOM_CYLINDER" if isinstance(geometry, Cylinder) else "mjGEOM_CAPSULE"
        return kind, [geometry.radius, geometry.length / 2, geometry.radius]
    raise TypeError(f"{type(geometry).__name__} is no primitive")


def half_sizes(solid: Solid) -> tuple[float, float, float]:
    """Return half the sides (m) of the box around a primitive, along its own axes."""
    kind, sizes = _primitive(solid.shape.geometry)
    if kind in ("mjGEOM_BOX", "mjGEOM_SPHERE", "mjGEOM_ELLIPSOID"):
        return (sizes[0], sizes[1], sizes[2])
    radius, half = sizes[0], sizes[1]
    return (radius, radius, half + (radius if kind == "mjGEOM_CAPSULE" else 0.0))


def corners_of(shape: Shape, meshes: Meshes) -> Floats | None:
    """Return corners (n, 3) around a solid in the frame of its link; None of a mesh that was not read, or is flat."""
    import numpy as np

    place = shape.origin().transform()
    if isinstance(shape.geometry, Mesh):
        loaded = meshes.of(shape.geometry)
        if loaded is None:
            return None
        corners = loaded.hull.corners if loaded.hull else np.array(loaded.box)
    else:
        half = half_sizes(Solid("", 0, shape, place, None))
        corners = np.array(list(product(*((-side, side) for side in half))))
    made: Floats = corners @ np.array(place.rows).T + np.array(place.xyz)
    return made


def _surface(solid: Solid) -> Floats:
    """Return points (n, 3) on a solid in the frame of its body; of a primitive points that fill it."""
    import numpy as np

    if solid.mesh is None:
        return _sampled(solid, SAMPLES, np.random.default_rng(2))
    triangles = solid.mesh.triangles
    points = np.concatenate([triangles.mean(axis=1), triangles.reshape(-1, 3)])
    points = points[:: 1 + len(points) // _ON_SURFACE]
    made: Floats = points @ np.array(solid.place.rows).T + np.array(solid.place.xyz)
    return made


def winding(triangles: Floats, points: Floats) -> Floats:
    """Return how often a surface of triangles (m, 3, 3) winds around points (n, 3): 1 inside a closed one, 0 outside.

    The sum of the solid angles (A. Van Oosterom, J. Strackee, 1983); a surface with holes gives something between
    (A. Jacobson, L. Kavan, O. Sorkine-Hornung, "Robust inside-outside segmentation using generalized winding numbers",
    2013). One that is inside out winds the other way, which counts the same.
    """
    import numpy as np

    made = np.zeros(len(points))
    for index, point in enumerate(points):
        a, b, c = (triangles[:, corner] - point for corner in range(3))
        x, y, z = (np.linalg.norm(side, axis=1) for side in (a, b, c))
        over = np.einsum("ij,ij->i", a, np.cross(b, c))
        under = x * y * z + (a * b).sum(1) * z + (b * c).sum(1) * x + (c * a).sum(1) * y
        made[index] = abs(float(np.arctan2(over, under).sum())) / (2 * math.pi)
    return made


def _sampled(solid: Solid, count: int, generator: Any) -> Floats:
    """Return about ``count`` points (n, 3) in a solid, in the frame of its body."""
    import numpy as np

    if solid.hull is not None:
        lower, upper = solid.hull.corners.min(axis=0), solid.hull.corners.max(axis=0)
    else:
        upper = np.array(half_sizes(solid))
        lower = -upper
    points = lower + generator.random((4 * count, 3)) * (upper - lower)
    points = points[_holds(solid, points)][:count]
    made: Floats = points @ np.array(solid.place.rows).T + np.array(solid.place.xyz)
    return made


def _inside(solid: Solid, points: Floats) -> Flags:
    """Say which points (n, 3) of the frame of its body are in a solid."""
    import numpy as np

    return _holds(solid, (points - np.array(solid.place.xyz)) @ np.array(solid.place.rows))


def _is_within(solid: Solid, points: Floats) -> Flags:
    """Say which points (n, 3) of the frame of its body are in a mesh."""
    import numpy as np

    if solid.mesh is None:
        return _inside(solid, points)
    local = (points - np.array(solid.place.xyz)) @ np.array(solid.place.rows)
    return np.asarray(winding(solid.mesh.triangles, local) > 0.5)


def _holds(solid: Solid, points: Floats) -> Flags:
    """Say which points (n, 3) of its own frame are in a solid."""
    import numpy as np

    if solid.hull is not None:
        planes = solid.hull.planes
        return np.asarray((points @ planes[:, :3].T + planes[:, 3] <= 0).all(axis=1))
    geometry = solid.shape.geometry
    if isinstance(geometry, Box):
        return np.asarray((np.abs(points) <= half_sizes(solid)).all(axis=1))
    if isinstance(geometry, Sphere):
        return np.asarray((points**2).sum(axis=1) <= geometry.radius**2)
    radius, _, half = half_sizes(solid)
    across, along = (points[:, :2] ** 2).sum(axis=1), np.abs(points[:, 2])
    if isinstance(geometry, Cylinder):
        return np.asarray((across <= radius**2) & (along <= half))
    return np.asarray(across + np.maximum(along - half + radius, 0) ** 2 <= radius**2)
