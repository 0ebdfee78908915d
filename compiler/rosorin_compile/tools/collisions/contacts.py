"""The links of a URDF in MuJoCo: which of them touch in a state, and how near the others come.

Each link floats by itself and is put where the model has it, so that MuJoCo leaves out no neighbours. Its shapes are
those that the URDF has for it. Meshes are their convex hulls, which touch before the meshes do.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from importlib import import_module
from typing import TYPE_CHECKING, Any

from ...formats.srdf.planning import Planning, ordered
from ...model import Transform
from ...model.moveit import Pair
from ..physics.scene import Overlap, Scene, solids_of

if TYPE_CHECKING:
    from ..physics.files import Floats, Loaded, Meshes

MARGIN = 0.02  # m: how near parts are seen that do not touch
TOUCH = 1e-6  # m: faces that lie on each other touch, whatever the rounding of the poses made of it


class Contacts(Scene):
    """The collision shapes of the links of a URDF; pairs of ``left_out`` are not looked at."""

    def __init__(self, planning: Planning, meshes: Meshes, left_out: Iterable[Pair] = ()) -> None:
        self.robot = planning.robot
        self.tops = sorted(planning.solids)
        self.order = {name: number for number, name in enumerate(self.tops)}
        self.body_of = dict(self.order)
        self.joint_between = {}
        self.apart = {frozenset(pair) for pair in left_out}
        self.solids = []
        for name in self.tops:
            self.solids += solids_of(tuple(planning.solids[name]), name, Transform(), meshes)
        self.of_link = {}
        for solid in self.solids:
            self.of_link.setdefault(solid.link, []).append(solid)
        self.mujoco: Any = import_module("mujoco")
        self.model, self.data = self._made()
        self.model.geom_margin[:] = MARGIN
        self._points = {}

    def corners(self, mesh: Loaded) -> Floats:
        """Return all corners (n, 3) of the hull of a mesh: what never touches is said of the whole of it."""
        return mesh.outline

    def excluded(self) -> Iterable[tuple[int, int]]:
        """Yield the bodies that MuJoCo is not to look at together, by their numbers."""
        for pair in self.apart:
            one, other = sorted(pair)
            if one in self.body_of and other in self.body_of:
                yield self.body_of[one], self.body_of[other]

    def place(self, positions: Mapping[str, float]) -> None:
        """Put the links where joint positions (rad or m) have them, and let MuJoCo look for contacts."""
        placed = self.robot.poses_in_root(positions)
        numbers: list[float] = []
        for top in self.tops:
            numbers += [*placed[top].xyz, *placed[top].quaternion()]
        self.data.qpos[:] = numbers
        self.mujoco.mj_kinematics(self.model, self.data)
        self.mujoco.mj_collision(self.model, self.data)

    def distances(self, positions: Mapping[str, float]) -> dict[Pair, float]:
        """Return how near (m) pairs of links are at joint positions, of those nearer than MARGIN; below zero deep."""
        if len(self.tops) < 2:
            return {}
        self.place(positions)
        contact = self.data.contact
        found: dict[Pair, float] = {}
        for (one, other), far in zip(contact.geom.tolist(), contact.dist.tolist(), strict=True):
            pair = ordered((self.solids[one].link, self.solids[other].link))
            if far < found.get(pair, MARGIN):
                found[pair] = far
        return found

    def exact(self, pair: Pair, positions: Mapping[str, float]) -> float:
        """Return the distance (m) of a pair that is near each other: that of contacts is less where edges are apart."""
        self.place(positions)
        contact = self.data.contact
        nearest = MARGIN
        for (one, other), far in zip(contact.geom.tolist(), contact.dist.tolist(), strict=True):
            if ordered((self.solids[one].link, self.solids[other].link)) == pair:
                if far > TOUCH:
                    far = float(self.mujoco.mj_geomDistance(self.model, self.data, one, other, MARGIN, None))
                nearest = min(nearest, far)
        return nearest

    def touches_at(self, pair: Pair, positions: Mapping[str, float]) -> bool:
        """Say whether a pair whose hulls touch does so by the meshes themselves."""
        if not any(solid.mesh for name in pair for solid in self.of_link[name]):
            return True
        self.place(positions)
        contact = self.data.contact
        for (one, other), far in zip(contact.geom.tolist(), contact.dist.tolist(), strict=True):
            solids = self.solids[one], self.solids[other]
            is_pair = ordered((solids[0].link, solids[1].link)) == pair
            if is_pair and far <= TOUCH and self.touches(Overlap(-far, *solids), positions):
                return True
        return False
