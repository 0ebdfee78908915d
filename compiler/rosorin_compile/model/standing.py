"""Standing: the pose that a robot is at home in, and where its root is when it stands free on a floor in that pose."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from typing import NamedTuple

from .bounds import Bounds
from .geometry import IDENTITY, Pose, Transform, Vector, dot
from .robot import JointPose, Robot
from .shape import MERGED, Box, Capsule, Cylinder, Ellipsoid, Geometry, HeightMap, Mesh, Shape, Sphere

HOME = "home"

_DIGITS = 9  # of a height in metres: what is left of rounding is no millimetre
_AXES: tuple[Vector, ...] = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))
_BACK: tuple[Vector, ...] = ((-1.0, -0.0, -0.0), (-0.0, -1.0, -0.0), (-0.0, -0.0, -1.0))


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


def unknown(mesh: Mesh) -> Cloud | None:  # noqa: ARG001 - whoever has read no mesh
    """Say of no mesh where its vertices are."""
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


def stands_at(robot: Robot, pose: JointPose, clouds: Clouds = unknown) -> Pose:
    """Return where the root of a free robot is in the world in a pose.

    As the pose says it, else as the description says of the root; else straight up, so high that the lowest collision
    shape touches z = 0. A robot that collides with meshes of which nobody knows where they end stays at zero.
    """
    if pose.base is not None:
        return pose.base
    root = robot.root_in_world
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
    clouds: Clouds = unknown,
) -> Reach:
    """Return the space that the shapes of a robot take at joint positions (rad or m), its root ``at`` a place."""
    lower, upper, meshes = [math.inf] * 3, [-math.inf] * 3, 0
    measured: list[tuple[Cloud, Shape, Transform]] = []
    world = at.transform()
    for name, place in robot.poses_in_root(dict(positions)).items():
        shapes = getattr(robot.link[name], purpose)
        there = world.then(place) if shapes else place
        for shape in shapes:
            if isinstance(shape.geometry, Mesh):
                cloud = clouds(shape.geometry)
                meshes += cloud is None
                if cloud is not None and cloud.points:
                    measured.append((cloud, shape, there))
                continue
            far = along(shape, there)
            for axis in range(3):
                lower[axis] = min(lower[axis], -far(_BACK[axis]))
                upper[axis] = max(upper[axis], far(_AXES[axis]))
    for axis in range(3):
        lower[axis] = -_farthest(measured, _BACK[axis], -lower[axis])
        upper[axis] = _farthest(measured, _AXES[axis], upper[axis])
    if lower[0] > upper[0]:
        return Reach(None, meshes)
    (a, b, c), (d, e, f) = lower, upper
    return Reach(Bounds((a, b, c), (d, e, f)), meshes)


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


def along(shape: Shape, place: Transform) -> Callable[[Vector], float]:
    """Return what says how far a shape, no mesh, reaches along a unit vector (m); ``place`` is that of its link."""
    there = place.then(shape.pose.transform())
    (a, b, c), (d, e, f), (g, h, i) = there.rows
    u, v, w = there.xyz
    geometry = shape.geometry
    if isinstance(geometry, Capsule | Sphere):
        radius, half = geometry.radius, geometry.length / 2 if isinstance(geometry, Capsule) else 0.0

        def around(direction: Vector) -> float:
            x, y, z = direction
            return u * x + v * y + w * z + (abs(c * x + f * y + i * z) * half + radius)

        return around
    own = _extent(geometry)

    def reach(direction: Vector) -> float:
        x, y, z = direction
        inside = own(a * x + d * y + g * z, b * x + e * y + h * z, c * x + f * y + i * z)
        return u * x + v * y + w * z + inside

    return reach


def _extent(geometry: Geometry) -> Callable[[float, float, float], float]:
    """Return what says how far a geometry reaches along a unit vector of its own frame (m)."""
    if isinstance(geometry, Cylinder):
        radius, length = geometry.radius, geometry.length
        return lambda x, y, z: abs(z) * length / 2 + radius * math.hypot(x, y)
    if isinstance(geometry, Ellipsoid):
        one, two, three = geometry.radii
        return lambda x, y, z: math.hypot(x * one, y * two, z * three)
    boxes = geometry.boxes(MERGED) if isinstance(geometry, HeightMap) else (geometry,)
    return _extent_of_boxes([box for box in boxes if isinstance(box, Box)])


def _extent_of_boxes(boxes: Sequence[Box]) -> Callable[[float, float, float], float]:
    """Return what says how far the farthest of some boxes reaches; by the sign of a direction one end of each does."""
    if not boxes:  # a height map without a body
        return lambda *_: -math.inf
    corners = [(box.lower, box.upper) for box in boxes]
    xs, ys, zs = (
        ([min(a[axis], b[axis]) for a, b in corners], [max(a[axis], b[axis]) for a, b in corners]) for axis in range(3)
    )

    def extent(x: float, y: float, z: float) -> float:
        ends = zip(xs[x > 0], ys[y > 0], zs[z > 0], strict=True)
        return max([x * a + y * b + z * c for a, b, c in ends])

    return extent
