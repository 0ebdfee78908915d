"""Standing: the pose that a robot is at home in, and where its root is when it stands on a floor in that pose."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import NamedTuple

from .bounds import Bounds
from .geometry import IDENTITY, Pose, Transform, Vector, dot
from .robot import JointPose, Robot
from .shape import Box, Capsule, Cylinder, Ellipsoid, Mesh, Shape

HOME = "home"

_DIGITS = 9  # of a height in metres: what is left of rounding is no millimetre
_AXES: tuple[Vector, ...] = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))


class Reach(NamedTuple):
    """The box around shapes (m), None where there is none, and how many meshes are not in it: their size is unknown."""

    bounds: Bounds | None
    meshes: int


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


def stands_at(robot: Robot, pose: JointPose) -> Pose:
    """Return where the root of a free robot is in the world in a pose.

    As the pose says it, else as the description says of the root; else straight up, so high that the lowest collision
    shape touches z = 0. A robot that collides with meshes stays at zero: their size is not known here.
    """
    if pose.base is not None:
        return pose.base
    root = robot.simulation.root
    if root.placed:
        return root.pose
    bounds, meshes = reach(robot, pose.positions)
    if bounds is None or meshes:
        return IDENTITY
    return Pose((0.0, 0.0, 0.0 - round(bounds.lower[2], _DIGITS)))


def reach(robot: Robot, positions: Mapping[str, float], purpose: str = "collision", at: Pose = IDENTITY) -> Reach:
    """Return the space that the shapes of a robot take at joint positions (rad or m), its root ``at`` a place."""
    lower, upper, meshes = [math.inf] * 3, [-math.inf] * 3, 0
    world = at.transform()
    for name, place in robot.poses_in_root(dict(positions)).items():
        solids = [solid for shape in getattr(robot.link[name], purpose) for solid in shape.solids()]
        there = world.then(place) if solids else place
        for solid in solids:
            if isinstance(solid.geometry, Mesh):
                meshes += 1
                continue
            for axis, direction in enumerate(_AXES):
                lower[axis] = min(lower[axis], -along(solid, there, (-direction[0], -direction[1], -direction[2])))
                upper[axis] = max(upper[axis], along(solid, there, direction))
    if lower[0] > upper[0]:
        return Reach(None, meshes)
    (a, b, c), (d, e, f) = lower, upper
    return Reach(Bounds((a, b, c), (d, e, f)), meshes)


def along(solid: Shape, place: Transform, direction: Vector) -> float:
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
