"""Fit bounding shapes to a mesh: box, oriented box, cylinder, capsule and stack of boxes.

Each shape encloses the mesh, even after its dimensions are rounded. A shape with a larger rotation is only chosen if
its volume is more than one percent smaller.
"""

import itertools
import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import ConvexHull, QhullError  # type: ignore[import-untyped,unused-ignore]
from scipy.spatial.distance import pdist, squareform  # type: ignore[import-untyped,unused-ignore]
from trimesh import Trimesh
from trimesh.bounds import oriented_bounds
from trimesh.intersections import slice_faces_plane
from trimesh.nsphere import minimum_nsphere

from rosorin_compile.model import Box, Capsule, Cylinder, Pose, Shape, Transform
from rosorin_compile.model.shape import volume_and_moments

Floats = NDArray[np.float64]
Vector = tuple[float, float, float]

_STL_NOISE = 1e-7  # m, rounding error of STL coordinates, which have 24 bits


@dataclass(frozen=True)
class Fit:
    """A bounding shape of a mesh in one or more non-overlapping pieces, and how well it fits."""

    kind: str
    pieces: tuple[Shape, ...]
    volume: float  # m^3
    overhang: float | None  # volume outside the mesh in m^3, or None if the mesh is not watertight
    overlap: float  # fraction of the mesh vertices inside the shape


def fit_shapes(triangles: Floats, digits: int, stack: int, axis: str = "auto") -> dict[str, Fit]:
    """Fit a bounding shape of each kind to triangles (n, 3, 3) in metres, and return the fits by kind.

    Lengths have ``digits`` decimals. The stack has ``stack`` boxes along ``axis``: x, y, z, or auto (least volume).
    """
    corners = triangles.reshape(-1, 3)
    mesh = Trimesh(corners, np.arange(len(corners)).reshape(-1, 3), process=True)
    size = abs(float(mesh.volume)) if mesh.is_watertight else 0.0
    triangles = np.round(triangles, 10)  # avoid divisions by differences below 0.1 nm
    hull = _hull(triangles.reshape(-1, 3))
    oriented = _oriented_box(hull, digits)
    angles: list[Vector] = [(0, math.pi / 2, 0), (math.pi / 2, 0, 0), (0, 0, 0)]  # rotate z to the x, y and z axis
    if oriented.pose.rpy != (0, 0, 0):
        angles += [_angles_along((x, y, z)) for x, y, z in zip(*oriented.pose.transform().rows, strict=True)]
    cylinders, capsules = zip(*(_round_shapes(hull, rpy, digits) for rpy in angles), strict=True)
    pieces = {
        "box": (Shape(enclosing_box(triangles, digits)),),
        "oriented_box": (oriented,),
        "cylinder": (_smallest(cylinders),),
        "capsule": (_smallest(capsules),),
        "stack": _stack(triangles, stack, axis, digits),
    }
    fits = {}
    for kind, shapes in pieces.items():
        volume = sum(map(_volume, shapes))
        inside = np.any([_contains(shape, corners) for shape in shapes], axis=0)
        fits[kind] = Fit(kind, shapes, volume, max(0.0, volume - size) if size else None, float(inside.mean()))
    return fits


def enclosing_box(points: Floats, digits: int) -> Box:
    """Return the axis-aligned box around points (..., 3), rounded outwards to ``digits`` decimals."""
    points = points.reshape(-1, 3)
    low = [round_down(float(value), digits) for value in points.min(axis=0)]
    high = [round_up(float(value), digits) for value in points.max(axis=0)]
    high = [b if b > a else round(a + 10.0**-digits, digits) for a, b in zip(low, high, strict=True)]
    return Box((low[0], low[1], low[2]), (high[0], high[1], high[2]))


def round_up(value: float, digits: int) -> float:
    """Round a length (m) up to ``digits`` decimals; an excess of at most 0.1 um is rounded down instead."""
    scale = 10.0**digits
    return round(math.ceil(value * scale - min(_STL_NOISE * scale, 0.05)) / scale, digits) + 0.0


def round_down(value: float, digits: int) -> float:
    """Round a length (m) down to ``digits`` decimals, with the same tolerance as ``round_up``."""
    return -round_up(-value, digits) + 0.0


def in_frame(points: Floats, pose: Pose) -> Floats:
    """Transform points (n, 3) from the parent frame into the frame at ``pose``."""
    local: Floats = (points - np.array(pose.xyz)) @ _rotation(pose.rpy)
    return local


def _rotation(rpy: Vector) -> Floats:
    return np.array(Pose((0, 0, 0), rpy).transform().rows)


def _rounded_angles(rpy: Vector) -> Vector:
    """Round angles (rad) within 0.01 degrees of a whole degree to that degree, others to six decimals."""
    degrees = map(math.degrees, rpy)
    x, y, z = (
        math.radians(round(d)) if abs(d - round(d)) < 0.01 else round(angle, 6) + 0.0
        for d, angle in zip(degrees, rpy, strict=True)
    )
    return x, y, z


def _angles_along(axis: Vector) -> Vector:
    """Return roll, pitch and yaw (rad) of a frame whose z axis is parallel to ``axis`` and points upwards."""
    x, y, z = axis if axis[2] >= 0 else (-axis[0], -axis[1], -axis[2])
    return _rounded_angles((0.0, math.atan2(math.hypot(x, y), z), math.atan2(y, x)))


def _rounded_pose(xyz: Floats, rpy: Vector, digits: int) -> Pose:
    x, y, z = (round(float(value), digits) + 0.0 for value in xyz)
    return Pose((x, y, z), rpy)


def _hull(points: Floats) -> Floats:
    """Return the vertices of the convex hull of points (n, d), or all points of a flat mesh."""
    try:
        return np.asarray(points[np.sort(ConvexHull(points).vertices)])
    except (QhullError, ValueError):
        return np.unique(points, axis=0)


def _oriented_box(hull: Floats, digits: int) -> Shape:
    """Return the smallest box aligned with a face of the hull, or the axis-aligned box if it is about as small."""
    aligned = Shape(enclosing_box(hull, digits))
    try:
        with np.errstate(all="ignore"):
            axes = oriented_bounds(hull)[0][:3, :3]
    except (QhullError, LookupError, TypeError, ValueError):  # a flat mesh has no oriented box
        return aligned
    rpy = _least_rotation(axes)
    if rpy == (0, 0, 0):
        return aligned
    local = hull @ _rotation(rpy)
    pose = _rounded_pose(_rotation(rpy) @ ((local.min(axis=0) + local.max(axis=0)) / 2), rpy, digits)
    half = np.abs(in_frame(hull, pose)).max(axis=0)
    x, y, z = (_positive(2 * float(value), digits) / 2 for value in half)
    return _smallest([aligned, Shape(Box((-x, -y, -z), (x, y, z)), pose)])


def _least_rotation(axes: Floats) -> Vector:
    """Return roll, pitch and yaw (rad) of a box; ``axes`` (rows) may be permuted and flipped for the least rotation."""
    turned = [
        axes[list(order)] * np.array(signs)[:, None]
        for order in itertools.permutations(range(3))
        for signs in itertools.product((1, -1), repeat=3)
    ]
    best = max((rows for rows in turned if np.linalg.det(rows) > 0), key=lambda rows: round(float(np.trace(rows)), 9))
    rows = best.T.tolist()
    return _rounded_angles(Transform((tuple(rows[0]), tuple(rows[1]), tuple(rows[2]))).rpy())


def _positive(value: float, digits: int) -> float:
    """Round a length (m) up to at least one unit of the last decimal."""
    return max(round_up(value, digits), 10.0**-digits)


def _round_shapes(points: Floats, rpy: Vector, digits: int) -> tuple[Shape, Shape]:
    """Return the smallest cylinder and capsule around points (n, 3), along the z axis of a frame rotated by ``rpy``."""
    rotation = _rotation(rpy)
    local = points @ rotation
    (x, y), _ = smallest_circle(local[:, :2])
    z = (float(local[:, 2].min()) + float(local[:, 2].max())) / 2
    axis = _rounded_pose(rotation @ np.array([x, y, z]), rpy, digits)
    local = in_frame(points, axis)
    radial, axial = np.hypot(local[:, 0], local[:, 1]), local[:, 2]
    radius, length = _positive(float(radial.max()), digits), _positive(2 * float(abs(axial).max()), digits)
    cylinder, capsules = Shape(Cylinder(radius, length), axis), list[Shape]()
    for factor in np.linspace(1.0, 1.5, 32).tolist():
        radius = _positive(float(radial.max()) * factor, digits)
        bulge = np.sqrt(np.maximum(radius**2 - radial**2, 0))
        middle = (float((axial - bulge).max()) + float((axial + bulge).min())) / 2
        pose = _rounded_pose(rotation @ np.array([0, 0, middle]) + np.array(axis.xyz), rpy, digits)
        local = in_frame(points, pose)
        distance = np.hypot(local[:, 0], local[:, 1])
        radius = max(radius, round_up(float(distance.max()), digits))
        reach = abs(local[:, 2]) - np.sqrt(np.maximum(radius**2 - distance**2, 0))
        capsules.append(Shape(Capsule(radius, _positive(2 * float(reach.max()), digits)), pose))
    return cylinder, min(capsules, key=lambda shape: round(_volume(shape), 15))


def _stack(triangles: Floats, count: int, axis: str, digits: int) -> tuple[Shape, ...]:
    """Return a stack of boxes of equal thickness along an axis; each box encloses its slice of the mesh."""
    if axis == "auto":
        stacks = [_stack(triangles, count, name, digits) for name in "xyz"]
        return min(stacks, key=lambda shapes: round(sum(map(_volume, shapes)), 15))
    along = "xyz".index(axis)
    normal = np.eye(3)[along]
    lowest, highest = triangles[:, :, along].min(), triangles[:, :, along].max()
    cuts = np.round(np.linspace(lowest, highest, count + 1), digits)
    cuts[0], cuts[-1] = lowest, highest
    boxes = []
    for low, high in itertools.pairwise(cuts.tolist()):
        height = triangles[:, :, along]
        corners = triangles[(height.max(axis=1) >= low) & (height.min(axis=1) <= high)]
        points, faces = corners.reshape(-1, 3), np.arange(3 * len(corners)).reshape(-1, 3)
        # Add the vertices in the cutting planes, because trimesh drops faces in these planes.
        inside = points[(points[:, along] >= low - _STL_NOISE) & (points[:, along] <= high + _STL_NOISE)]
        for direction, cut in ((normal, low), (-normal, high)):
            if len(faces):
                points, faces, _ = slice_faces_plane(points, faces, direction, normal * cut)
        points = np.concatenate([inside, points[faces].reshape(-1, 3)])
        if len(points):
            points[:, along] = points[:, along].clip(low, high)
            boxes.append(Shape(enclosing_box(points, digits)))
    return tuple(boxes)


def _smallest(shapes: Sequence[Shape]) -> Shape:
    """Return the smallest shape; a later shape must be more than one percent smaller than an earlier shape."""
    best = shapes[0]
    for shape in shapes[1:]:
        best = shape if _volume(shape) < 0.99 * _volume(best) else best
    return best


def _volume(shape: Shape) -> float:
    return volume_and_moments(shape.geometry)[0]


def smallest_circle(points: Floats) -> tuple[tuple[float, float], float]:
    """Return centre and radius of the smallest circle around points (n, 2)."""
    hull = _hull(points)
    distances = squareform(pdist(hull))
    first, second = divmod(int(distances.argmax()), len(hull))
    centre, radius = (hull[first] + hull[second]) / 2, distances[first, second] / 2
    # If two points define the circle, they are the farthest pair; otherwise search for the centre.
    if np.linalg.norm(hull - centre, axis=1).max() > radius * (1 + 1e-9) + 1e-15:
        centre, _ = minimum_nsphere(hull)
    return (float(centre[0]), float(centre[1])), float(np.linalg.norm(hull - centre, axis=1).max())


def _contains(shape: Shape, points: Floats) -> NDArray[np.bool_]:
    local, geometry = in_frame(points, shape.pose), shape.geometry
    if isinstance(geometry, Box):
        beyond = np.maximum(np.array(geometry.lower) - local, local - np.array(geometry.upper)).max(axis=1)
    else:
        assert isinstance(geometry, Cylinder | Capsule)  # noqa: S101 - fits contain no other shapes
        radial, axial = np.hypot(local[:, 0], local[:, 1]), abs(local[:, 2]) - geometry.length / 2
        if isinstance(geometry, Cylinder):
            beyond = np.maximum(radial - geometry.radius, axial)
        else:
            beyond = np.hypot(radial, axial.clip(0)) - geometry.radius
    contained: NDArray[np.bool_] = beyond <= 2e-7  # tolerance in metres for points on the surface
    return contained
