"""The links of a URDF in MuJoCo: which of them touch in a state, and how near the others come."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from itertools import product
from typing import TYPE_CHECKING, Any, Protocol

from rosorin_compile.model import DisabledCollision, Joint, Output, Robot, Shape, Transform

from ..physics.scene import Bodies, Overlap, Pair
from ..physics.solids import Meshes, Solid, solids_of

if TYPE_CHECKING:
    from collections.abc import Collection
    from pathlib import Path

    from ..physics.solids import Floats

FAR = 0.02  # m: links that stay farther apart than this are reported so, without the distance
TOUCH = 1e-6  # m: faces that lie on each other touch, whatever the rounding of the poses made of it

State = dict[str, float]  # of joints that move by themselves, rad or m


class Planning(Protocol):
    """The robot as MoveIt plans with it: a URDF, and the matrix that its description includes.

    ``ros.srdf.planning`` implements it, and the API passes it in. ``said`` is the section ``moveit``.
    """

    @property
    def robot(self) -> Robot: ...
    @property
    def urdf(self) -> Output: ...
    @property
    def said(self) -> Any: ...
    @property
    def links(self) -> Collection[str]: ...
    @property
    def joints(self) -> Mapping[str, Joint]: ...
    @property
    def solids(self) -> Mapping[str, list[Shape]]: ...
    @property
    def digest(self) -> str: ...
    @property
    def meshes(self) -> Sequence[str]: ...
    def digests(self, files: Mapping[str, Path]) -> dict[str, str]: ...
    def parts(self, meshes: Mapping[str, str]) -> Any: ...
    def same_pairs(self, now: Any) -> dict[Pair, DisabledCollision | None]: ...
    def between(self, base: str, tip: str) -> list[Joint]: ...


def ordered(one: str, other: str) -> Pair:
    """Return a pair of links sorted by name."""
    return (one, other) if one < other else (other, one)


class Contacts(Bodies):
    """The collision shapes of the links of a URDF; ``excluded`` pairs are not tested."""

    def __init__(self, planning: Planning, meshes: Meshes, excluded: Iterable[Pair] = ()) -> None:
        links = sorted(planning.solids)
        solids = {name: solids_of(planning.solids[name], name, Transform(), meshes) for name in links}
        super().__init__(planning.robot, solids, lambda mesh: mesh.outline, excluded)
        self.model.geom_margin[:] = TOUCH
        self.number = {name: number for number, name in enumerate(links)}
        self.geoms: dict[str, list[int]] = {name: [] for name in links}
        for geom, solid in enumerate(self.solids):
            self.geoms[solid.link].append(geom)

    def touching(self, row: Floats) -> dict[Pair, float]:
        """Return the pairs of links that touch where a row of ``rows`` has them, and the distance (m), below zero."""
        distances: dict[Pair, float] = {}
        for one, other, distance in self._contacts(row):
            pair = ordered(one.link, other.link)
            distances[pair] = min(distance, distances.get(pair, distance))
        return distances

    def _contacts(self, row: Floats) -> Iterator[tuple[Solid, Solid, float]]:
        self.put(row)
        self.mujoco.mj_collision(self.model, self.data)
        contact = self.data.contact
        for (one, other), distance in zip(contact.geom.tolist(), contact.dist.tolist(), strict=True):
            if distance <= TOUCH:
                yield self.solids[one], self.solids[other], distance

    def touch_as_meshes(self, pair: Pair, state: State) -> bool:
        """Return True if a pair whose hulls touch does so by the meshes themselves."""
        if not any(self.solids[geom].mesh for link in pair for geom in self.geoms[link]):
            return True
        contacts = list(self._contacts(self.rows([state])[0]))
        overlaps = (Overlap(-distance, one, other) for one, other, distance in contacts)
        return any(
            self.touches(found, state) for found in overlaps if ordered(found.one.link, found.other.link) == pair
        )

    def geom_pairs(self, pair: Pair) -> list[tuple[int, int]]:
        """Return each shape of one link with each of the other, by their numbers."""
        return list(product(self.geoms[pair[0]], self.geoms[pair[1]]))

    def sphere_gaps(self, geoms: Floats) -> Floats:
        """Return how near (m) the spheres around pairs of shapes (2, n) are, where the links were placed last."""
        import numpy as np

        places, radii = self.data.geom_xpos, self.model.geom_rbound
        one, other = geoms
        gaps: Floats = np.linalg.norm(places[one] - places[other], axis=1) - radii[one] - radii[other]
        return gaps

    def distances(self, pair: Pair, states: Sequence[State], most: float) -> Iterator[float]:
        """Yield the distance (m) of a pair in each state, ``most`` at most; below zero is the depth.

        Contacts do not have it: with a margin of centimetres MuJoCo 4.0 misses some of them.
        """
        geoms, measure = self.geom_pairs(pair), self.mujoco.mj_geomDistance
        places = [slice(7 * self.number[link], 7 * self.number[link] + 7) for link in pair]
        for row in self.rows(states, pair):
            self.data.qpos[places[0]], self.data.qpos[places[1]] = row[:7], row[7:]
            self.mujoco.mj_kinematics(self.model, self.data)
            gaps = (float(measure(self.model, self.data, one, other, most, None)) for one, other in geoms)
            yield min(gaps, default=most)
