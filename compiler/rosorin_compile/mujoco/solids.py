"""Find overlaps between the collision shapes of links, with each link as a floating body in MuJoCo.

The poses of the bodies come from the kinematics of the robot, so that MuJoCo's joints and its contact filter for
adjacent bodies have no effect. Meshes are replaced by their convex hulls, as in simulators.
"""

import math
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from importlib import import_module
from itertools import combinations, product
from pathlib import Path
from typing import Any, NamedTuple

from rosorin_compile.model import Box, Capsule, Cylinder, Joint, Mesh, Robot, Shape, Transform
from rosorin_compile.model.mesh_triangles import TriangleMesh
from rosorin_compile.rules.case import Case
from rosorin_compile.source.diagnostics import Diagnostic
from rosorin_compile.source.progress import Progress

from .mjcf.bodies import half_sizes, weld_groups

Floats = Any  # a numpy array; numpy is an optional dependency
Meshes = Mapping[Mesh, Any]  # readable meshes as ``trimesh.Trimesh`` in metres
Positions = Mapping[str, Any]  # joint positions in rad or m; a sequence for a joint with several coordinates
Pair = tuple[str, str]  # two links; in a ``Scene``, the link nearer to the root is first

_LEAST = 5e-4  # m: smaller overlaps are caused by rounding in files and in MuJoCo
_SMALLEST = 1e-6  # m: a smaller shape has no volume
_FILLING, _ON_SURFACE, _TESTED = 600, 4_000, 150  # number of points in a link, on a mesh, and to test against a mesh


class MeshShape(NamedTuple):
    """A mesh shape: its link, its purpose ("collision" or "visual"), and its index in the shapes for that purpose."""

    link: str
    purpose: str
    number: int
    mesh: Mesh


def read_meshes(
    case: Case, files: Mapping[str, Path], colliding: Collection[str] | None = None
) -> tuple[list[MeshShape], Meshes, list[Diagnostic]]:
    """Read the meshes of all shapes, or only of the collision shapes that use a file in ``colliding``.

    ``files`` maps file names in the description to paths. Return (shapes with a mesh, readable meshes, a warning for
    each unreadable mesh).
    """
    import numpy as np
    import trimesh

    shapes, meshes, problems = list[MeshShape](), dict[Mesh, Any](), dict[Mesh, Diagnostic]()
    for link, purpose in product(case.robot.links, ("collision", "visual") if colliding is None else ("collision",)):
        for number, shape in enumerate(getattr(link, purpose)):
            if isinstance(shape.geometry, Mesh) and (colliding is None or shape.geometry.file in colliding):
                shapes.append(MeshShape(link.name, purpose, number, shape.geometry))
    for number, one in enumerate(shapes):
        Progress.step("reading meshes", number, len(shapes))
        if one.mesh not in meshes and one.mesh not in problems:
            found = TriangleMesh.of_shape(case, one[:3], files)
            if isinstance(found, Diagnostic):
                problems[one.mesh] = found
            else:
                corners = found.triangles.reshape(-1, 3)
                meshes[one.mesh] = trimesh.Trimesh(corners, np.arange(len(corners)).reshape(-1, 3), process=False)
                meshes[one.mesh].merge_vertices()
    return shapes, meshes, list(problems.values())


@dataclass(frozen=True, eq=False)
class Solid:
    """A shape with volume: its index in the shapes of the link, its pose in the link, and its mesh or None."""

    link: str
    number: int
    shape: Shape
    place: Transform
    mesh: Any = None

    @property
    def size(self) -> list[float]:
        """The three numbers of the attribute ``size`` of a MuJoCo geom (m), for a primitive shape."""
        sizes = half_sizes(self.shape.geometry)
        return [*sizes, *[sizes[0]] * (3 - len(sizes))]

    @cached_property
    def hull(self) -> Any:
        """The convex hull in the frame of the shape as a ``trimesh.Trimesh``, or None for a flat mesh."""
        from trimesh import creation

        geometry = self.shape.geometry
        if isinstance(geometry, Mesh):
            try:
                return self.mesh.convex_hull
            except (RuntimeError, ValueError):  # raised by Qhull
                return None
        if isinstance(geometry, Box):
            return creation.box(geometry.size)
        if isinstance(geometry, (Cylinder, Capsule)):
            make = creation.cylinder if isinstance(geometry, Cylinder) else creation.capsule
            return make(radius=geometry.radius, height=geometry.length)
        return creation.icosphere(3).apply_scale(self.size)

    def in_link(self, points: Floats) -> Floats:
        """Transform points (n, 3) from the frame of the shape to the frame of its link."""
        return TriangleMesh.place(points, self.place.rows, self.place.xyz)

    def contains(self, points: Floats, exact: bool = False) -> Any:
        """Return a mask (n,) of the points (n, 3) inside the hull, or inside the mesh if ``exact``.

        A point is inside a mesh if the solid angles of the triangles (A. Van Oosterom, J. Strackee, 1983) add up to
        more than half a sphere, which also works for meshes with holes (A. Jacobson, L. Kavan, O. Sorkine-Hornung,
        "Robust inside-outside segmentation using generalized winding numbers", 2013).
        """
        import numpy as np

        local, angles = (points - np.array(self.place.xyz)) @ np.array(self.place.rows), []
        if not exact or self.mesh is None:
            return self._in_hull(local)
        for point in local:
            a, b, c = (self.mesh.triangles[:, corner] - point for corner in range(3))
            x, y, z = (np.linalg.norm(side, axis=1) for side in (a, b, c))
            under = x * y * z + (a * b).sum(1) * z + (b * c).sum(1) * x + (c * a).sum(1) * y
            angles.append(2 * np.arctan2((a * np.cross(b, c)).sum(1), under).sum())
        return np.abs(angles) > 2 * math.pi

    def _in_hull(self, points: Floats) -> Any:
        normals = self.hull.face_normals
        return (points @ normals.T <= (normals * self.hull.triangles[:, 0]).sum(axis=1)).all(axis=1)

    def sample(self, count: int, generator: Any) -> Floats:
        """Return up to ``count`` random points (n, 3) inside the hull, in the frame of the link."""
        lower, upper = self.hull.bounds
        points = lower + generator.random((4 * count, 3)) * (upper - lower)
        return self.in_link(points[self._in_hull(points)][:count])


def solids_of(shapes: Sequence[Shape], link: str, meshes: Meshes) -> list[Solid]:
    """Convert the shapes of a link to solids, except shapes without volume."""
    solids = []
    for number, piece in ((number, piece) for number, shape in enumerate(shapes) for piece in shape.solids()):
        mesh = meshes.get(piece.geometry) if isinstance(piece.geometry, Mesh) else None
        solid = Solid(link, number, piece, piece.origin().transform(), mesh)
        if isinstance(piece.geometry, Mesh):
            has_volume = mesh is not None and solid.hull is not None and solid.hull.volume >= _SMALLEST**3
        else:
            has_volume = all(math.isfinite(size) and size > _SMALLEST for size in solid.size)
        solids += [solid] if has_volume else []
    return solids


class Overlap(NamedTuple):
    """The largest overlap of two links: its depth (m), and the two solids in the order of the links."""

    depth: float
    solids: tuple[Solid, Solid]


class Bodies:
    """Links as floating bodies in MuJoCo; ``solids`` are in the order of the geoms of the model."""

    def __init__(
        self, robot: Robot, shapes: Mapping[str, Sequence[Shape]], meshes: Meshes, excluded: Iterable[Pair] = ()
    ) -> None:
        """Build one body for each link in ``shapes``; pairs in ``excluded`` are never in contact."""
        self.mujoco = mujoco = import_module("mujoco")
        self.robot = robot
        self.kinematics = replace(robot, edges=()).kinematics  # without static transforms of other ROS nodes
        self.names, self.solids = list(shapes), list[Solid]()
        self.solids_of = {name: solids_of(shapes[name], name, meshes) for name in shapes}
        spec: Any = mujoco.MjSpec()
        spec.memory = 2**28  # bytes for contacts, because overlapping links have many
        for name, solids in self.solids_of.items():  # names need a prefix, because MuJoCo reserves "world"
            body = spec.worldbody.add_body(name=f"link {name}", explicitinertial=True, mass=1, inertia=[1, 1, 1])
            body.add_freejoint()
            for solid in solids:
                kind = getattr(mujoco.mjtGeom, f"mjGEOM_{type(solid.shape.geometry).__name__.upper()}")
                geom = body.add_geom(type=kind, pos=solid.place.xyz, quat=solid.place.quaternion())
                if solid.mesh is None:
                    geom.size = solid.size
                else:
                    geom.meshname = f"{len(spec.meshes)}"
                    spec.add_mesh(name=geom.meshname, uservert=solid.hull.vertices.ravel())
                self.solids.append(solid)
        for first, second in excluded:
            if {first, second} <= self.solids_of.keys():
                spec.add_exclude(bodyname1=f"link {first}", bodyname2=f"link {second}")
        self.model: Any = spec.compile()
        self.data: Any = mujoco.MjData(self.model)

    def rows(self, states: Sequence[Positions], names: Sequence[str] = ()) -> Floats:
        """Return an array with a row per state: poses (x y z qw qx qy qz) of the bodies in ``names`` (default: all)."""
        import numpy as np

        names, joints = names or self.names, states[0].keys() if states else ()
        positions = {joint: np.array([state[joint] for state in states]) for joint in joints}
        frames = self.kinematics.all_frames(self.robot.root, positions, names)
        rows, quaternion = np.empty((len(states), len(names), 7)), np.empty(4)
        for number, name in enumerate(names):
            turns, rows[:, number, :3] = frames[name]
            for row, turn in zip(rows, np.broadcast_to(turns, (len(states), 3, 3)), strict=True):
                self.mujoco.mju_mat2Quat(quaternion, np.ascontiguousarray(turn).reshape(-1))
                row[number, 3:] = quaternion
        return rows.reshape(len(states), 7 * len(names))

    def put(self, row: Floats) -> None:
        """Move all bodies to the poses in a row, as returned by ``rows``."""
        self.data.qpos[:] = row
        self.mujoco.mj_kinematics(self.model, self.data)

    def contacts(self, row: Floats, farthest: float) -> Iterator[tuple[Solid, Solid, float]]:
        """Move all bodies; yield (solid, solid, distance in m, negative inside) for distances up to ``farthest``."""
        self.put(row)
        self.mujoco.mj_collision(self.model, self.data)
        contact = self.data.contact
        for (first, second), distance in zip(contact.geom.tolist(), contact.dist.tolist(), strict=True):
            if distance <= farthest:
                yield self.solids[first], self.solids[second], distance

    def overlaps(self, states: Sequence[Positions], farthest: float = -_LEAST) -> Iterator[dict[Pair, Overlap]]:
        """Move all bodies to each state, and yield the pairs of links that overlap, in the order of the bodies.

        Pairs count if their distance (m, negative inside) is up to ``farthest``. All states must have the same joints.
        """
        for row in self.rows(states):
            overlaps: dict[Pair, Overlap] = {}
            for *solids, distance in self.contacts(row, farthest):
                first, second = sorted(solids, key=lambda solid: self.names.index(solid.link))
                pair = (first.link, second.link)
                if pair not in overlaps or overlaps[pair].depth < -distance:
                    overlaps[pair] = Overlap(-distance, (first, second))
            yield overlaps

    def move(self, points: Floats, source: Solid, target: Solid) -> Floats:
        """Transform points (n, 3) at the current poses from the link frame of ``source`` to that of ``target``."""
        turns, places = self.data.xmat, self.data.xpos
        old, new = (int(self.model.geom_bodyid[self.solids.index(solid)]) for solid in (source, target))
        return (points @ turns[old].reshape(3, 3).T + places[old] - places[new]) @ turns[new].reshape(3, 3)

    def touches(self, solids: tuple[Solid, Solid], positions: Positions) -> bool:
        """Return True if two solids, and not only their convex hulls, touch: points of one are inside the other."""
        import numpy as np

        if all(solid.mesh is None for solid in solids):
            return True
        self.put(self.rows([positions])[0])
        for inner, outer in (solids, solids[::-1]):
            if inner.mesh is None:
                points = inner.sample(_FILLING, np.random.default_rng(2))
            else:
                points = np.concatenate([inner.mesh.triangles_center, inner.mesh.triangles.reshape(-1, 3)])
                points = inner.in_link(points[:: 1 + len(points) // _ON_SURFACE])
            points = self.move(points, inner, outer)
            points = points[outer.contains(points)]
            if len(points) and outer.contains(points[:: 1 + len(points) // _TESTED], exact=True).any():
                return True
        return False


class Scene(Bodies):
    """The collision shapes of a robot; links fixed to each other and disabled pairs are never in contact."""

    def __init__(self, robot: Robot, meshes: Meshes) -> None:
        shapes, groups = {link.name: link.collision for link in robot.walk()}, weld_groups(robot)
        self.top = {name: top for top, names in groups.items() for name in names}  # topmost link of each fixed group
        moving = [joint for joint in robot.joints if not joint.is_fixed]
        self.joint_between = {frozenset((self.top[joint.parent], joint.child)): joint for joint in moving}
        fixed = [pair for names in groups.values() for pair in combinations(names, 2)]
        super().__init__(robot, shapes, meshes, [*fixed, *robot.disabled_contacts])
        self.volume = {link: float(sum(one.hull.volume for one in solids)) for link, solids in self.solids_of.items()}
        self._points: dict[str, Floats] = {}

    def joint_of(self, pair: Pair) -> Joint | None:
        """Return the joint between two links, or between links fixed to them; None if there is no such joint."""
        return self.joint_between.get(frozenset((self.top[pair[0]], self.top[pair[1]])))

    def share(self, small: str, large: str, positions: Positions, exact: bool = False) -> float:
        """Estimate the share (0 to 1) of ``small`` inside the hulls (if ``exact``, inside the meshes) of ``large``."""
        import numpy as np

        inner, outer = self.solids_of[small], self.solids_of[large]
        if small not in self._points:
            generator, volume = np.random.default_rng(1), self.volume[small]
            counts = [max(8, round(_FILLING * solid.hull.volume / volume)) for solid in inner]
            samples = [solid.sample(count, generator) for solid, count in zip(inner, counts, strict=True)]
            self._points[small] = np.concatenate(samples)
        self.put(self.rows([positions])[0])
        points = self.move(self._points[small], inner[0], outer[0])
        points = points[:: 1 + len(points) // _TESTED] if exact else points
        return float(np.any([solid.contains(points, exact) for solid in outer], axis=0).mean()) if len(points) else 0.0
