"""The home pose of a robot, and the pose of its root when it stands free on a floor."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import NamedTuple

from rosorin_compile.model.bounds import Bounds, along
from rosorin_compile.model.geometry import IDENTITY, Pose, Vector
from rosorin_compile.model.mesh_vertices import Clouds, no_clouds
from rosorin_compile.model.robot import JointPose, Robot
from rosorin_compile.model.shape import Mesh

HOME = "home"
_DIGITS = 9  # of a height in metres: removes rounding only
_AXES: tuple[Vector, ...] = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))
_BACK: tuple[Vector, ...] = ((-1.0, -0.0, -0.0), (-0.0, -1.0, -0.0), (-0.0, -0.0, -1.0))


class Reach(NamedTuple):
    """The box around shapes (m), or None if there are none, and the number of meshes of unknown size."""

    bounds: Bounds | None
    meshes: int


def home_of(robot: Robot) -> JointPose:
    """Return the pose called home; without one all joints are at zero, or at the limit nearest to it."""
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


def stands_at(robot: Robot, pose: JointPose, clouds: Clouds = no_clouds) -> Pose:
    """Return the pose of the root of a free robot in the world.

    It is that of the pose, or that of the root in the description. Without either, the robot stands upright, its lowest
    collision shape at z = 0; with meshes of unknown size it stays at the origin.
    """
    if pose.base is not None:
        return pose.base
    if robot.root_in_world.placed:
        return robot.root_in_world.pose
    bounds, meshes = reach(robot, pose.positions, clouds=clouds)
    if bounds is None or meshes:
        return IDENTITY
    return Pose((0.0, 0.0, 0.0 - round(bounds.lower[2], _DIGITS)))


def reach(
    robot: Robot,
    positions: Mapping[str, float],
    purpose: str = "collision",
    at: Pose = IDENTITY,
    clouds: Clouds = no_clouds,
) -> Reach:
    """Return the space that the shapes of a robot take at joint positions (rad or m), with its root ``at`` a pose."""
    lower, upper, meshes = [math.inf] * 3, [-math.inf] * 3, 0
    world = at.transform()
    for name, place in robot.poses_in_root(dict(positions)).items():
        shapes = getattr(robot.link[name], purpose)
        there = world.then(place) if shapes else place
        for shape in shapes:
            if not isinstance(shape.geometry, Mesh):
                far = along(shape, there)
                for axis in range(3):
                    lower[axis] = min(lower[axis], -far(_BACK[axis]))
                    upper[axis] = max(upper[axis], far(_AXES[axis]))
                continue
            points = clouds(shape.geometry)
            meshes += points is None
            if points:
                frame = there.then(shape.pose.transform())
                for axis in range(3):
                    a, b, c = (cell * scale for cell, scale in zip(frame.rows[axis], shape.geometry.scale, strict=True))
                    values = [a * x + b * y + c * z for x, y, z in points]
                    lower[axis] = min(lower[axis], frame.xyz[axis] + min(values))
                    upper[axis] = max(upper[axis], frame.xyz[axis] + max(values))
    if lower[0] > upper[0]:
        return Reach(None, meshes)
    (a, b, c), (d, e, f) = lower, upper
    return Reach(Bounds((a, b, c), (d, e, f)), meshes)
