"""The home pose of a robot, the ranges of its joints, and the pose of its root when it stands free on a floor."""

from __future__ import annotations

import math
from collections.abc import Mapping
from functools import reduce

from rosorin_compile.model import Joint
from rosorin_compile.model.bounds import Bounds, reach_along
from rosorin_compile.model.geometry import IDENTITY, Pose
from rosorin_compile.model.mesh_vertices import Clouds, no_clouds
from rosorin_compile.model.robot import JointPose, Robot
from rosorin_compile.model.shape import Mesh

HOME = "home"
_DIGITS = 9  # of a height in metres: removes rounding only


def range_of(joint: Joint) -> tuple[float, float] | None:
    """Return the range of a joint that moves by itself (rad or m), a turn without limits; None if it has no bounds."""
    limit = joint.limit
    if not joint.moves or joint.mimic is not None:
        return None
    if joint.type != "continuous" and limit is not None and limit.lower is not None and limit.upper is not None:
        return limit.lower, limit.upper
    return None if joint.type == "prismatic" else (-math.pi, math.pi)


def leader_of(robot: Robot, joint: Joint) -> Joint:
    """Return the joint that a joint follows in the end, or itself."""
    while joint.mimic is not None:
        joint = robot.joint[joint.mimic.joint]
    return joint


def home_of(robot: Robot) -> JointPose:
    """Return the pose called home; without one all joints are at zero, or at the limit nearest to it."""
    named = next((pose for pose in robot.poses if pose.name == HOME), None)
    return JointPose(HOME, nearest_to_zero(robot)) if named is None else named


def nearest_to_zero(robot: Robot) -> dict[str, float]:
    """Return the limits (rad or m), no stand-ins, nearest to zero of the joints whose limits do not include it."""
    measured = [joint for joint in robot.joints if joint.limit and not {"lower", "upper"} & set(joint.limit.stand_ins)]
    ranges = {joint.name: range_of(joint) or (0.0, 0.0) for joint in measured}
    return {name: low if low > 0.0 else high for name, (low, high) in ranges.items() if low < high and low * high > 0.0}


def stands_at(robot: Robot, pose: JointPose, clouds: Clouds = no_clouds) -> Pose:
    """Return the pose of the root of a free robot in the world.

    It is that of the pose, or that of the root in the description. Without either, the robot stands upright, its lowest
    collision shape at z = 0; with meshes of unknown size it stays at the origin.
    """
    if pose.base is not None:
        return pose.base
    if robot.root_in_world.placed:
        return robot.root_in_world.pose
    bounds, meshes = reach(robot, pose.positions, "collision", IDENTITY, clouds)
    if bounds is None or meshes:
        return IDENTITY
    return Pose((0.0, 0.0, 0.0 - round(bounds.lower[2], _DIGITS)))


def reach(
    robot: Robot, positions: Mapping[str, float], purpose: str, at: Pose, clouds: Clouds
) -> tuple[Bounds | None, int]:
    """Return the box (m) around the shapes of a robot at joint positions (rad or m), with its root ``at`` a pose.

    It is None without shapes. The second value is the number of meshes of unknown size, which are not in it.
    """
    boxes, unknown, root = list[Bounds](), 0, at.transform()
    for name, place in robot.poses_in_root(dict(positions)).items():
        for shape in getattr(robot.link[name], purpose):
            there = root.then(place)
            if isinstance(shape.geometry, Mesh):
                points, frame = clouds(shape.geometry), there.then(shape.pose.transform())
                a, b, c = shape.geometry.scale
                placed = [frame.apply((a * x, b * y, c * z)) for x, y, z in points or ()]
                unknown += points is None
                if placed:
                    (x, y, z), (u, v, w) = (map(limit, zip(*placed, strict=True)) for limit in (min, max))
                    boxes.append(Bounds((x, y, z), (u, v, w)))
                continue
            far = reach_along(shape, there)
            lower, upper = (
                (sign * far((sign, 0.0, 0.0)), sign * far((0.0, sign, 0.0)), sign * far((0.0, 0.0, sign)))
                for sign in (-1.0, 1.0)
            )
            boxes += [Bounds(lower, upper)] if lower[0] <= upper[0] else []
    return reduce(Bounds.join, boxes) if boxes else None, unknown
