"""The links of a URDF in MuJoCo: which of them touch in a state, and how near the others come.

Each link floats by itself and is put where the model has it, so that MuJoCo leaves out no neighbours. Its shapes are
those that the URDF has for it. Meshes are their convex hulls, which touch before the meshes do.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from importlib import import_module
from itertools import product
from typing import TYPE_CHECKING, Any

from rosorin_compile.model import Transform

from ..physics.scene import Overlap, Scene, solids_of
from .planning import Pair, Planning, ordered

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from ..physics.files import Floats, Loaded, Meshes

    Numbers = NDArray[np.int_]

FAR = 0.02  # m: links that stay farther apart than this are said to do so, without the distance
_POSE = 7  # numbers of a place: x, y, z, and a quaternion
TOUCH = 1e-6  # m: faces that lie on each other touch, whatever the rounding of the poses made of it


class Contacts(Scene):
    """The collision shapes of the links of a URDF; pairs of ``left_out`` are not looked at."""

    def __init__(self, planning: Planning, meshes: Meshes, left_out: Iterable[Pair] = ()) -> None:
        self.planning, self.meshes = planning, meshes
        self.robot = planning.robot
        self.kinematics = replace(planning.robot, edges=()).kinematics  # by the joints alone
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
        self.model.geom_margin[:] = TOUCH
        self._points = {}
        self._between: dict[Pair, list[tuple[int, int]]] = {}

    def corners(self, mesh: Loaded) -> Floats:
        """Return all corners (n, 3) of the hull of a mesh: what never touches is said of the whole of it."""
        return mesh.outline

    def excluded(self) -> Iterable[tuple[int, int]]:
        """Yield the bodies that MuJoCo is not to look at together, by their numbers."""
        for pair in self.apart:
            one, other = sorted(pair)
            if one in self.body_of and other in self.body_of:
                yield self.body_of[one], self.body_of[other]

    def placed(self, states: Sequence[Mapping[str, float]]) -> Floats:
        """Return where the links are in states (rad or m by joint, the same joints in all), as rows for ``put``."""
        import numpy as np

        names = states[0].keys() if states else ()
        positions = {name: np.array([state[name] for state in states]) for name in names}
        frames = self.kinematics.all_frames(self.robot.root, positions, self.tops)
        rows = np.empty((len(states), len(self.tops), _POSE))
        quaternion = np.empty(4)
        for number, top in enumerate(self.tops):
            turns, places = frames[top]
            rows[:, number, :3] = places
            for row, turn in zip(rows, np.broadcast_to(turns, (len(states), 3, 3)), strict=True):
                self.mujoco.mju_mat2Quat(quaternion, np.ascontiguousarray(turn).reshape(-1))
                row[number, 3:] = quaternion
        return rows.reshape(len(states), -1)

    def put(self, row: Floats, look: bool = True) -> None:
        """Put the links where a row of ``placed`` has them, and let MuJoCo ``look`` for contacts."""
        self.data.qpos[:] = row
        self.mujoco.mj_kinematics(self.model, self.data)
        if look:
            self.mujoco.mj_collision(self.model, self.data)

    def place(self, positions: Mapping[str, float], look: bool = True) -> None:
        """Put the links where joint positions (rad or m) have them, and let MuJoCo ``look`` for contacts."""
        self.put(self.placed([positions])[0], look)

    def touching(self, positions: Mapping[str, float]) -> dict[Pair, float]:
        """Return the pairs of links that touch at joint positions, and the distance (m), below zero deep."""
        return self.touching_at(self.placed([positions])[0]) if len(self.tops) > 1 else {}

    def touching_at(self, row: Floats) -> dict[Pair, float]:
        """Return the same where a row of ``placed`` has the links."""
        if len(self.tops) < 2:
            return {}
        self.put(row)
        contact = self.data.contact
        found: dict[Pair, float] = {}
        for (one, other), far in zip(contact.geom.tolist(), contact.dist.tolist(), strict=True):
            pair = ordered((self.solids[one].link, self.solids[other].link))
            if far <= min(TOUCH, found.get(pair, TOUCH)):
                found[pair] = far
        return found

    def apart_at_least(self, one: Numbers, other: Numbers) -> Floats:
        """Return how near (m) the spheres around pairs of shapes are, where the links were placed last.

        ``one`` and ``other`` have the numbers of the shapes, which are not nearer themselves.
        """
        import numpy as np

        places, radii = self.data.geom_xpos, self.model.geom_rbound
        made: Floats = np.linalg.norm(places[one] - places[other], axis=1) - radii[one] - radii[other]
        return made

    def between(self, pair: Pair) -> list[tuple[int, int]]:
        """Return the shapes of two links, each of one with each of the other, by their numbers."""
        if pair not in self._between:
            one, other = ([n for n, solid in enumerate(self.solids) if solid.link == name] for name in pair)
            self._between[pair] = list(product(one, other))
        return self._between[pair]

    def exact(self, pair: Pair, positions: Mapping[str, float], most: float) -> float:
        """Return the distance (m) of a pair, ``most`` at most; below zero deep.

        It is asked for, because contacts do not say it: with a margin of centimetres MuJoCo 4.0 misses some of them.
        """
        self.place(positions, look=False)
        ask = self.mujoco.mj_geomDistance
        found = (float(ask(self.model, self.data, one, other, most, None)) for one, other in self.between(pair))
        return min(found, default=most)

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
