"""The links of a robot as floating bodies in MuJoCo, and which of them are inside each other at joint positions.

Every body is placed where the model of the robot has it, so that nothing depends on joints of MuJoCo or on which
neighbours it lets collide. Meshes are their convex hulls, as simulators take them.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from importlib import import_module
from itertools import combinations
from typing import TYPE_CHECKING, Any, NamedTuple

from rosorin_compile.model import Joint, Robot, Shape

from ..mjcf.bodies import weld_groups
from .solids import SAMPLES, Meshes, Solid, solids_of

if TYPE_CHECKING:
    from .solids import Floats

LEAST = 5e-4  # m: what printing and the search for the depth cost, and what touching parts may overlap by
_TESTED = 150  # points of one solid that are looked for inside the mesh of another
_MEMORY = 2**28  # bytes for contacts: parts that are full of each other have many

Positions = Mapping[str, Any]  # of joints in rad or m; of a joint with several coordinates, a sequence
Pair = tuple[str, str]  # two links; in a scene of a robot the one that is nearer to the root first


class Overlap(NamedTuple):
    """How deep (m) two links are in each other, and the solids where it is deepest, in the order of the pair."""

    depth: float
    solids: tuple[Solid, Solid]


class Bodies:
    """Floating bodies in MuJoCo: each is named by the link that its solids are placed in."""

    def __init__(
        self, robot: Robot, shapes: Mapping[str, Sequence[Shape]], meshes: Meshes, excluded: Iterable[Pair] = ()
    ) -> None:
        """Build the bodies of links with their shapes; ``excluded`` pairs never touch."""
        self.mujoco = mujoco = import_module("mujoco")
        self.robot = robot
        self.kinematics = replace(robot, edges=()).kinematics  # by the joints alone
        self.names = list(shapes)
        solids = {name: solids_of(shapes[name], name, meshes) for name in shapes}
        self.solids = [solid for name in self.names for solid in solids[name]]  # in the order of MuJoCo's geoms
        spec: Any = mujoco.MjSpec()
        spec.memory = _MEMORY
        for name in self.names:  # with a prefix, for MuJoCo has a body "world"
            body = spec.worldbody.add_body(name=f"link {name}", explicitinertial=True, mass=1, inertia=[1, 1, 1])
            body.add_freejoint()
            for solid in solids[name]:
                values: dict[str, Any] = {"pos": solid.place.xyz, "quat": solid.place.quaternion()}
                if solid.mesh is not None:
                    mesh = spec.add_mesh(name=str(len(spec.meshes)), uservert=solid.hull.vertices.ravel())
                    values["meshname"] = mesh.name
                else:
                    values["size"] = solid.size
                kind = f"mjGEOM_{type(solid.shape.geometry).__name__.upper()}"
                body.add_geom(type=getattr(mujoco.mjtGeom, kind), **values)
        for pair in excluded:
            if solids.keys() >= set(pair):
                spec.add_exclude(bodyname1=f"link {pair[0]}", bodyname2=f"link {pair[1]}")
        self.model: Any = spec.compile()
        self.data: Any = mujoco.MjData(self.model)

    def rows(self, states: Sequence[Positions], names: Sequence[str] = ()) -> Floats:
        """Return where the bodies, or some of them, are in states of the same joints: 7 numbers each in a row a state.

        With all bodies, a row is one for ``put``.
        """
        import numpy as np

        names, joints = names or self.names, states[0].keys() if states else ()
        positions = {joint: np.array([state[joint] for state in states]) for joint in joints}
        frames = self.kinematics.all_frames(self.robot.root, positions, names)
        rows = np.empty((len(states), len(names), 7))
        quaternion = np.empty(4)
        for number, name in enumerate(names):
            turns, places = frames[name]
            rows[:, number, :3] = places
            for row, turn in zip(rows, np.broadcast_to(turns, (len(states), 3, 3)), strict=True):
                self.mujoco.mju_mat2Quat(quaternion, np.ascontiguousarray(turn).reshape(-1))
                row[number, 3:] = quaternion
        return rows.reshape(len(states), 7 * len(names))

    def put(self, row: Floats) -> None:
        """Place the bodies as a row of ``rows`` has them."""
        self.data.qpos[:] = row
        self.mujoco.mj_kinematics(self.model, self.data)

    def contacts(self, row: Floats, farthest: float) -> Iterator[tuple[Solid, Solid, float]]:
        """Yield the solids that touch where a row of ``rows`` has the bodies, and their distance (m), below zero."""
        self.put(row)
        self.mujoco.mj_collision(self.model, self.data)
        contact = self.data.contact
        for (first, second), distance in zip(contact.geom.tolist(), contact.dist.tolist(), strict=True):
            if distance <= farthest:
                yield self.solids[first], self.solids[second], distance

    def move(self, points: Floats, source: Solid, target: Solid) -> Floats:
        """Transform points (n, 3) from the frame of the body of one solid to that of another."""
        turns, places = self.data.xmat, self.data.xpos
        old, new = (int(self.model.geom_bodyid[self.solids.index(solid)]) for solid in (source, target))
        moved: Floats = (points @ turns[old].reshape(3, 3).T + places[old] - places[new]) @ turns[new].reshape(3, 3)
        return moved

    def touches(self, solids: tuple[Solid, Solid], positions: Positions) -> bool:
        """Return True if two shapes overlap as they are, and not only the hulls of their meshes.

        Corners and middles of triangles of one shape are looked for inside the other one.
        """
        if all(solid.mesh is None for solid in solids):
            return True
        self.put(self.rows([positions])[0])
        for inner, outer in (solids, solids[::-1]):
            points = self.move(inner.surface(), inner, outer)
            points = points[outer.contains(points)]
            if len(points) and outer.contains(points[:: 1 + len(points) // _TESTED], exact=True).any():
                return True
        return False


class Scene(Bodies):
    """The collision shapes of a robot, where links that are fixed to each other or disabled never touch."""

    def __init__(self, robot: Robot, meshes: Meshes) -> None:
        shapes = {link.name: link.collision for link in robot.walk()}
        groups = weld_groups(robot)
        self.order = {name: number for number, name in enumerate(shapes)}
        self.top = {name: top for top, names in groups.items() for name in names}  # the link that a link is fixed to
        moving = [joint for joint in robot.joints if not joint.is_fixed]
        self.joint_between = {frozenset((self.top[joint.parent], joint.child)): joint for joint in moving}
        fixed = [pair for names in groups.values() for pair in combinations(names, 2)]
        super().__init__(robot, shapes, meshes, [*fixed, *robot.disabled_contacts])
        self._points: dict[str, Floats] = {}

    def overlaps(self, positions: Positions) -> dict[Pair, Overlap]:
        """Return the links that are inside each other at joint positions."""
        return self.overlaps_at(self.rows([positions])[0])

    def overlaps_at(self, row: Floats) -> dict[Pair, Overlap]:
        """Return the links that are inside each other where a row of ``rows`` has the bodies."""
        overlaps: dict[Pair, Overlap] = {}
        for first, second, distance in self.contacts(row, -LEAST):
            if self.order[first.link] > self.order[second.link]:
                first, second = second, first
            pair = (first.link, second.link)
            if pair not in overlaps or overlaps[pair].depth < -distance:
                overlaps[pair] = Overlap(-distance, (first, second))
        return overlaps

    def joint_of(self, pair: Pair) -> Joint | None:
        """Return the joint between two neighbouring links, or None if they are not neighbours."""
        return self.joint_between.get(frozenset((self.top[pair[0]], self.top[pair[1]])))

    def solids_of(self, link: str) -> list[Solid]:
        """Return the solids of a link."""
        return [solid for solid in self.solids if solid.link == link]

    def volume(self, link: str) -> float:
        """Return the volume (m^3) of the solids of a link, of meshes that of their hulls."""
        return float(sum(solid.hull.volume for solid in self.solids_of(link)))

    def share(self, small: str, large: str, positions: Positions, exact: bool = False) -> float:
        """Return how much of the volume of a link (0 to 1) is inside another one, or the hulls of its meshes.

        ``exact``: inside the meshes themselves, for a few points.
        """
        import numpy as np

        inner, outer = self.solids_of(small), self.solids_of(large)
        if small not in self._points:
            generator, volume = np.random.default_rng(1), self.volume(small)
            counts = [max(8, round(SAMPLES * solid.hull.volume / volume)) for solid in inner]
            samples = [solid.sample(count, generator) for solid, count in zip(inner, counts, strict=True)]
            self._points[small] = np.concatenate(samples)
        self.put(self.rows([positions])[0])
        points = self.move(self._points[small], inner[0], outer[0])
        points = points[:: 1 + len(points) // _TESTED] if exact else points
        inside = np.zeros(len(points), dtype=bool)
        for solid in outer:
            inside |= solid.contains(points, exact)
        return float(inside.mean()) if len(points) else 0.0
