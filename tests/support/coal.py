"""Coal, through pinocchio: how far apart the links of a URDF are in a state, as a program says that is not ours."""

import math
from collections.abc import Mapping
from typing import Any

Pair = tuple[str, str]


class Coal:
    """The collision shapes of a URDF; meshes are their convex hulls, as MuJoCo has them."""

    def __init__(self, urdf: str) -> None:
        import pinocchio

        self.pin: Any = pinocchio
        self.model = pinocchio.buildModelFromXML(urdf)
        self.data = self.model.createData()
        kind = pinocchio.GeometryType.COLLISION
        self.geometry = pinocchio.buildGeomFromUrdfString(self.model, urdf, kind)
        for one in self.geometry.geometryObjects:
            if type(one.geometry).__name__.startswith("BVH"):
                one.geometry.buildConvexHull(True, "Qt")
                one.geometry = one.geometry.convex
        self.links = [self.model.frames[one.parentFrame].name for one in self.geometry.geometryObjects]
        self.geometry.removeAllCollisionPairs()
        for one in range(len(self.links)):
            for other in range(one + 1, len(self.links)):
                if self.links[one] != self.links[other]:
                    self.geometry.addCollisionPair(pinocchio.CollisionPair(one, other))
        self.placed = self.geometry.createData()

    def distances(self, positions: Mapping[str, float]) -> dict[Pair, float]:
        """Return how far apart (m) the pairs of links are, below zero in each other."""
        self._compute(self.pin.computeDistances, positions)
        found: dict[Pair, float] = {}
        for pair, result in zip(self.geometry.collisionPairs, self.placed.distanceResults, strict=True):
            names = sorted((self.links[pair.first], self.links[pair.second]))
            key = (names[0], names[1])
            found[key] = min(found.get(key, float("inf")), result.min_distance)
        return found

    def _compute(self, what: Any, positions: Mapping[str, float]) -> None:
        what(self.model, self.data, self.geometry, self.placed, self._state(positions))

    def _state(self, positions: Mapping[str, float]) -> Any:
        q = self.pin.neutral(self.model)
        for name, value in positions.items():
            joint = self.model.joints[self.model.getJointId(name)]
            if joint.nq == 2:  # a continuous joint, as a point on a circle
                q[joint.idx_q : joint.idx_q + 2] = math.cos(value), math.sin(value)
            else:
                q[joint.idx_q] = value
        return q
