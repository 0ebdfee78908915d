"""Standing: the pose that a robot is at home in, and where its root is when it stands on a floor in that pose."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from typing import NamedTuple

from .bounds import Bounds
from .geometry import IDENTITY, Pose, Transform, Vector, dot
from .robot import JointPose, Robot
from .shape import Box, Capsule, Cylinder, Ellipsoid, Mesh, Shape

HOME = "home"

_DIGITS = 9  # of a height in metres: what is left of rounding is no millimetre
_AXES: tuple[Vector, ...] = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))


class Cloud(NamedTuple):
    """The vertices of a mesh file, and the box around them, in the units of the file."""

    points: Sequence[Vector]
    lower: Vector
    upper: Vector


Clouds = Callable[[Mesh], Cloud | None]
"""What says where the vertices of a mesh are; None where nobody knows."""


class Reach(NamedTuple):
    """The box around shapes (m), None where there is none, and how many meshes are not in it: their size is unknown."""

    bounds: Bounds | None
    meshes: int


def _unknown(mesh: Mesh) -> Cloud | None:  # noqa: ARG001 - whoever has read no mesh
    return None


def home_of(robot: Robot) -> JointPose:
    """Return the pose called home; of a robot that has none, all joints at zero, or at the limit next to it."""
    for pose in robot.poses:
        if pose.name == HOME:
            return pose
    positions = {}
    for joint in robot.joints:
        if not joint.moves or joint.mimic is not None or joint.limit is None or joint.type == "continuous":
            continue
        lower, upper = joint.limit.known("lower"), joint.limit.known("upper")
        if lower is not None and upper is not None and lower < upper and not lower <= 0.0 <= upper:
            positions[joint.name] = lower if lower > 0.0 else upper
    return JointPose(HOME, positions)


def stands_at(robot: Robot, pose: JointPose, clouds: Clouds = _unknown) -> Pose:
    """Return where the root of a free robot is in the world in a pose.

    As the pose says it, else as the description says of the root; else straight up, so high that the lowest collision
    shape touches z = 0. A robot that collides with meshes of which nobody knows where they end stays at zero.
    """
    if pose.base is not None:
        return pose.base
    root = robot.simulation.root
    if root.placed:
        return root.pose
    bounds, meshes = reach(robot, pose.positions, clouds=clouds)
    if bounds is None or meshes:
        return IDENTITY
    return Pose((0.0, 0.0, 0.0 - round(bounds.lower[2], _DIGITS)))


def reach(
    robot: Robot,
    positions: Mapping[str, float],
    purpose: str = "collision",
    at: Pose = IDENTITY,
    clouds: Clouds = _unknown,
) -> Reach:
    """Return the space that the shapes of a robot take at joint positions (rad or m), its root ``at`` a place."""
    lower, upper, meshes = [math.inf] * 3, [-math.inf] * 3, 0
    measured: list[tuple[Cloud, Shape, Transform]] = []
    world = at.transform()
    for name, place in robot.poses_in_root(dict(positions)).items():
        solids = [solid for shape in getattr(robot.link[name], purpose) for solid in shape.solids()]
        there = world.then(place) if solids else place
        for solid in solids:
            if isinstance(solid.geometry, Mesh):
                cloud = clouds(solid.geometry)
                meshes += cloud is None
                if cloud is not None and cloud.points:
                    measured.append((cloud, solid, there))
                continue
            for axis, direction in enumerate(_AXES):
                lower[axis] = min(lower[axis], -_along(solid, there, _opposite(direction)))
                upper[axis] = max(upper[axis], _along(solid, there, direction))
    for axis, direction in enumerate(_AXES):
        lower[axis] = -_farthest(measured, _opposite(direction), -lower[axis])
        upper[axis] = _farthest(measured, direction, upper[axis])
    if lower[0] > upper[0]:
        return Reach(None, meshes)
    (a, b, c), (d, e, f) = lower, upper
    return Reach(Bounds((a, b, c), (d, e, f)), meshes)


def _opposite(direction: Vector) -> Vector:
    x, y, z = direction
    return (-x, -y, -z)


def _farthest(measured: Sequence[tuple[Cloud, Shape, Transform]], direction: Vector, known: float) -> float:
    """Return how far meshes reach along a unit vector (m), at least as far as is ``known``.

    The box around a mesh says how far it reaches at most: only those are gone through that may be the farthest.
    """
    most: list[tuple[float, float, Vector, Cloud]] = []
    for cloud, solid, place in measured:
        there = place.then(solid.pose.transform())
        away, inside = dot(there.xyz, direction), there.inverse().rotate(direction)
        scale = solid.geometry.scale if isinstance(solid.geometry, Mesh) else (1.0, 1.0, 1.0)
        x, y, z = (part * factor for part, factor in zip(inside, scale, strict=True))
        sides = zip((x, y, z), cloud.lower, cloud.upper, strict=True)
        most.append((away + sum(max(part * low, part * high) for part, low, high in sides), away, (x, y, z), cloud))
    for end, away, (x, y, z), cloud in sorted(most, key=lambda one: -one[0]):
        if end <= known:
            break
        known = max(known, away + max(x * a + y * b + z * c for a, b, c in cloud.points))
    return known


def _along(solid: Shape, place: Transform, direction: Vector) -> float:
    """Return how far a solid reaches along a unit vector (m); ``place`` is that of its link."""
    there = place.then(solid.pose.transform())
    inside = there.inverse().rotate(direction)
    geometry = solid.geometry
    if isinstance(geometry, Box):
        sides = zip(inside, geometry.lower, geometry.upper, strict=True)
        own = sum(max(part * low, part * high) for part, low, high in sides)
    elif isinstance(geometry, Cylinder | Capsule):
        flat = 1.0 if isinstance(geometry, Capsule) else math.hypot(inside[0], inside[1])
        own = abs(inside[2]) * geometry.length / 2 + geometry.radius * flat
    elif isinstance(geometry, Ellipsoid):
        own = math.hypot(*(part * radius for part, radius in zip(inside, geometry.radii, strict=True)))
    else:
        own = getattr(geometry, "radius", 0.0)
    return dot(there.xyz, direction) + own
