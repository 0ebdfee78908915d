"""Shapes around a mesh: box, oriented box, cylinder, capsule, stack of boxes. Each of them holds the whole mesh.

Numbers are rounded to ``digits`` decimals in such a way that the rounded shape still holds the mesh. The same mesh
gives the same shape on every machine. Nice directions are preferred: a shape that is turned is taken only if it is
more than one percent smaller than the one that is turned less.

``smallest_circle`` and ``smallest_rectangle`` are those around points of a plane: the shapes seen along an axis.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

from rosorin_compile.model import Box, Capsule, Cylinder, Pose, Shape, Transform

from .meshes import bounds
from .turning import Vector, angles_of_axis, down, matrix, nice_angles, rounded_pose, seen_from, up

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    Floats = NDArray[np.float64]


Tell = Callable[[float], None]

KINDS = ("box", "oriented_box", "cylinder", "capsule", "stack")
AXES = ("x", "y", "z")
# What a shape that is turned further has to have of the volume of one that is turned less.
_WORTH = 0.99
# Faces of the hull that an oriented box may lie on; of more the largest are tried.
_MOST_FACES = 300
_QUARTER = math.pi / 2
_ALONG: dict[str, tuple[float, float, float]] = {"x": (0, _QUARTER, 0), "y": (_QUARTER, 0, 0), "z": (0, 0, 0)}


@dataclass(frozen=True)
class Fit:
    """A shape around a mesh in one or several pieces that share nothing but faces; ``volume`` of all in m^3."""

    kind: str
    pieces: tuple[Shape, ...]

    @property
    def volume(self) -> float:
        """The volume of all pieces in m^3."""
        return sum(_volume(piece) for piece in self.pieces)


def fits(
    triangles: Floats, digits: int, stack: int, axis: str = "auto", tell: Tell = lambda _share: None
) -> dict[str, Fit]:
    """Return a shape of each kind around triangles (n, 3, 3), by kind; ``stack`` boxes along x, y, z or auto.

    ``tell`` hears the share that is done, from 0 to 1.
    """
    hull, normals = _hull(triangles)
    turned = _oriented(hull, normals, digits, tell)
    frames = [Transform(), turned.pose.transform()]
    directions = [_ALONG[name] for name in AXES]
    if turned.pose.rpy != (0, 0, 0):
        directions += [angles_of_axis(frames[1], index) for index in range(3)]
    return {
        "box": Fit("box", (Shape(axis_aligned(triangles, digits)),)),
        "oriented_box": Fit("oriented_box", (turned,)),
        "cylinder": Fit("cylinder", (_smallest([_cylinder(hull, rpy, digits) for rpy in directions]),)),
        "capsule": Fit("capsule", (_smallest([_capsule(hull, rpy, digits) for rpy in directions]),)),
        "stack": Fit("stack", _stack(triangles, stack, axis, digits)),
    }


def axis_aligned(triangles: Floats, digits: int) -> Box:
    """Return the axis-aligned box around triangles (n, 3, 3)."""
    return _box_between(*bounds(triangles), digits)


def _box_between(lower: Floats, upper: Floats, digits: int) -> Box:
    low = [down(float(value), digits) for value in lower]
    high = [up(float(value), digits) for value in upper]
    high = [b if b > a else round(a + 10.0**-digits, digits) for a, b in zip(low, high, strict=True)]
    return Box((low[0], low[1], low[2]), (high[0], high[1], high[2]))


def _hull(triangles: Floats) -> tuple[Floats, Floats]:
    """Return the corners (n, 3) of the convex hull and the normals (m, 3) of its faces, those of large ones first.

    A mesh that is flat has no hull: then these are all its corners, and no normal.
    """
    import numpy as np
    from scipy.spatial import ConvexHull, QhullError  # type: ignore[import-untyped,unused-ignore]

    points = triangles.reshape(-1, 3)
    try:
        hull = ConvexHull(points)
    except (QhullError, ValueError):
        return np.unique(points, axis=0), np.empty((0, 3))
    corners = points[hull.simplices]
    areas = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1)
    normals = np.round(hull.equations[:, :3], 6)
    flip = np.where(normals[:, 0] != 0, normals[:, 0], np.where(normals[:, 1] != 0, normals[:, 1], normals[:, 2])) < 0
    normals = np.where(flip[:, None], -normals, normals) + 0.0
    faces, which = np.unique(normals, axis=0, return_inverse=True)
    total = np.bincount(which.ravel(), areas)
    return points[np.sort(hull.vertices)], faces[np.argsort(-np.round(total, 12), kind="stable")][:_MOST_FACES]


def _oriented(hull: Floats, normals: Floats, digits: int, tell: Tell) -> Shape:
    """Return the smallest box around points: along the axes, turned about one of them, or on a face of the hull."""
    import numpy as np

    best = _turned_box(hull, (0.0, 0.0, 0.0), digits)
    for group in ([np.eye(3)[2]], [np.eye(3)[0], np.eye(3)[1]], list(normals)):
        tried: list[tuple[float, Floats]] = []
        for normal in group:
            tell(len(tried) / len(group))
            tried.append(_on_face(hull, normal))
        if tried:
            _, frame = min(tried, key=lambda volume_and_frame: volume_and_frame[0])
            turned = _turned_box(hull, nice_angles(frame), digits)
            best = turned if _volume(turned) < _WORTH * _volume(best) else best
    return best


def _on_face(hull: Floats, normal: Floats) -> tuple[float, Floats]:
    """Return volume and axes (rows of 3x3) of the smallest box around points with one side upright to a normal."""
    import numpy as np

    normal = normal / np.linalg.norm(normal)
    helper = np.eye(3)[int(np.abs(normal).argmin())]
    first = np.cross(helper, normal)
    first /= np.linalg.norm(first)
    second = np.cross(normal, first)
    angle, area = smallest_rectangle(np.stack([hull @ first, hull @ second], axis=1))
    along = math.cos(angle) * first + math.sin(angle) * second
    return round(area * float(np.ptp(hull @ normal)), 15), np.stack([along, np.cross(normal, along), normal])


def _turned_box(points: Floats, rpy: Vector, digits: int) -> Shape:
    """Return the box with these angles around points (n, 3)."""
    if rpy == (0, 0, 0):
        return Shape(_box_between(points.min(axis=0), points.max(axis=0), digits))
    inside = points @ matrix(rpy)
    middle = matrix(rpy) @ ((inside.min(axis=0) + inside.max(axis=0)) / 2)
    pose = rounded_pose(middle, rpy, digits)
    half = abs(seen_from(points, pose)).max(axis=0)
    x, y, z = (max(up(2 * float(value), digits), 10.0**-digits) / 2 for value in half)
    return Shape(Box((-x, -y, -z), (x, y, z)), pose)


def _cylinder(points: Floats, rpy: Vector, digits: int) -> Shape:
    """Return the smallest cylinder around points (n, 3) whose axis is z of a frame with these angles."""
    import numpy as np

    pose, _ = _around(points, rpy, digits)
    inside = seen_from(points, pose)
    radius = max(up(float(np.hypot(inside[:, 0], inside[:, 1]).max()), digits), 10.0**-digits)
    length = max(up(2 * float(abs(inside[:, 2]).max()), digits), 10.0**-digits)
    return Shape(Cylinder(radius, length), pose)


def _capsule(points: Floats, rpy: Vector, digits: int) -> Shape:
    """Return a small capsule around points (n, 3) whose axis is z of a frame with these angles.

    Its axis is that of the smallest cylinder; of 32 radii from that of the cylinder to 1.5 times it the best is taken.
    """
    import numpy as np

    around, smallest = _around(points, rpy, digits)
    inside = seen_from(points, around)
    far = np.hypot(inside[:, 0], inside[:, 1])
    made: list[Shape] = []
    for factor in np.linspace(1.0, 1.5, 32).tolist():
        radius = max(up(max(smallest * factor, float(far.max())), digits), 10.0**-digits)
        bulge = np.sqrt(np.maximum(radius**2 - far**2, 0))
        top, bottom = float((inside[:, 2] - bulge).max()), float((inside[:, 2] + bulge).min())
        offset = matrix(rpy) @ np.array([0, 0, (top + bottom) / 2]) + np.array(around.xyz)
        pose = rounded_pose(offset, rpy, digits)
        capsule = _capsule_at(points, pose, radius, digits)
        made.append(capsule)
    return min(made, key=lambda shape: round(_volume(shape), 15))


def _capsule_at(points: Floats, pose: Pose, radius: float, digits: int) -> Shape:
    """Return the shortest capsule at a pose around points; a radius that no longer reaches after rounding grows."""
    import numpy as np

    inside = seen_from(points, pose)
    far = np.hypot(inside[:, 0], inside[:, 1])
    radius = max(radius, up(float(far.max()), digits))
    reach = abs(inside[:, 2]) - np.sqrt(np.maximum(radius**2 - far**2, 0))
    length = max(up(2 * float(reach.max()), digits), 10.0**-digits)
    return Shape(Capsule(radius, length), pose)


def _around(points: Floats, rpy: Vector, digits: int) -> tuple[Pose, float]:
    """Return the pose in the middle of the smallest cylinder along z of a frame with these angles, and its radius."""
    import numpy as np

    inside = points @ matrix(rpy)
    (x, y), radius = smallest_circle(inside[:, :2])
    z = (float(inside[:, 2].min()) + float(inside[:, 2].max())) / 2
    return rounded_pose(matrix(rpy) @ np.array([x, y, z]), rpy, digits), radius


def _stack(triangles: Floats, count: int, axis: str, digits: int) -> tuple[Shape, ...]:
    """Return boxes of one thickness along an axis, each around what of the mesh is between its ends."""
    if axis == "auto":
        tried = [_stack(triangles, count, name, digits) for name in AXES]
        return min(tried, key=lambda shapes: round(sum(map(_volume, shapes)), 15))
    import numpy as np

    along = AXES.index(axis)
    lower, upper = bounds(triangles)
    cuts = np.round(np.linspace(lower[along], upper[along], count + 1), digits)
    cuts[0], cuts[-1] = lower[along], upper[along]
    made = []
    for low, high in itertools.pairwise(cuts.tolist()):
        points = _between(triangles, along, low, high)
        if len(points):
            made.append(Shape(_box_between(points.min(axis=0), points.max(axis=0), digits)))
    return tuple(made)


def _between(triangles: Floats, axis: int, low: float, high: float) -> Floats:
    """Return the corners (m, 3) of what two planes across an axis cut out of triangles (n, 3, 3)."""
    import numpy as np

    height = triangles[:, :, axis]
    reach = triangles[(height.max(axis=1) >= low) & (height.min(axis=1) <= high)]
    height = reach[:, :, axis]
    pieces = [reach[(height >= low) & (height <= high)]]
    for first, second in ((0, 1), (1, 2), (2, 0)):
        a, b = reach[:, first], reach[:, second]
        for cut in (low, high):
            # Signs, not lengths: the product of two tiny lengths is zero.
            crosses = np.sign(a[:, axis] - cut) * np.sign(b[:, axis] - cut) < 0
            start, end = a[crosses], b[crosses]
            share = (cut - start[:, axis]) / (end[:, axis] - start[:, axis])
            points = start + share[:, None] * (end - start)
            points[:, axis] = cut
            pieces.append(points)
    return np.concatenate(pieces)


def _smallest(shapes: list[Shape]) -> Shape:
    """Return the shape of the least volume; a later one has to be worth it."""
    best = shapes[0]
    for shape in shapes[1:]:
        best = shape if _volume(shape) < _WORTH * _volume(best) else best
    return best


def _volume(shape: Shape) -> float:
    geometry = shape.geometry
    if isinstance(geometry, Box):
        return math.prod(geometry.size)
    if isinstance(geometry, Cylinder):
        return math.pi * geometry.radius**2 * geometry.length
    if isinstance(geometry, Capsule):
        return math.pi * geometry.radius**2 * (geometry.length + 4 / 3 * geometry.radius)
    raise TypeError(f"no shape around a mesh: {geometry!r}")


Point = tuple[float, float]


def smallest_circle(points: Floats) -> tuple[Point, float]:
    """Return centre and radius of the smallest circle around points (n, 2).

    Two or three points hold it. Beginning anywhere, the point that is farthest outside joins those that hold it now,
    and the smallest circle around these few is the next one; its radius grows each time, so that comes to an end.
    """
    import numpy as np

    held: list[Point] = [(float(points[0, 0]), float(points[0, 1]))]
    centre, radius = held[0], 0.0
    for _ in range(1000):
        distance = np.hypot(points[:, 0] - centre[0], points[:, 1] - centre[1])
        far = int(distance.argmax())
        if distance[far] <= radius * (1 + 1e-12) + 1e-15:
            break
        held, centre, radius = _around_few([*held, (float(points[far, 0]), float(points[far, 1]))])
    distance = np.hypot(points[:, 0] - centre[0], points[:, 1] - centre[1])
    return centre, float(distance.max())


def _around_few(points: list[Point]) -> tuple[list[Point], Point, float]:
    """Return the smallest circle around at most four points, and which of them hold it."""
    best: tuple[list[Point], Point, float] | None = None
    for count in (2, 3):
        for some in itertools.combinations(points, count):
            centre = _middle(*some) if count == 2 else _circumcentre(*some)
            if centre is None:
                continue
            radius = max(math.dist(centre, point) for point in some)
            holds = all(math.dist(centre, point) <= radius * (1 + 1e-9) + 1e-15 for point in points)
            if holds and (best is None or radius < best[2]):
                best = (list(some), centre, radius)
    if best is None:  # points that differ by rounding alone
        return points[-1:], points[-1], 0.0
    return best


def _middle(a: Point, b: Point) -> Point:
    return ((a[0] + b[0]) / 2, (a[1] + b[1]) / 2)


def _circumcentre(a: Point, b: Point, c: Point) -> Point | None:
    """Return the point that is equally far from three others; None if they are on one line."""
    p, q, r, s = b[0] - a[0], b[1] - a[1], c[0] - a[0], c[1] - a[1]
    twice = 2 * (p * s - q * r)
    if abs(twice) <= 1e-12 * math.hypot(p, q) * math.hypot(r, s):
        return None
    first, second = p * p + q * q, r * r + s * s
    return (a[0] + (s * first - q * second) / twice, a[1] + (p * second - r * first) / twice)


def smallest_rectangle(points: Floats) -> tuple[float, float]:
    """Return angle (radians, 0 to pi/2) and area of the smallest rectangle around points (n, 2).

    One of its sides lies on an edge of the convex hull (Freeman and Shapira, 1975). Of rectangles that are the same but
    for rounding, as there are many around a regular prism, that of the smallest angle is taken, on every machine and in
    every order of the points; ``trimesh.bounds.oriented_bounds_2D`` lets the rounding choose.
    """
    import numpy as np
    from scipy.spatial import ConvexHull, QhullError  # type: ignore[import-untyped,unused-ignore]

    try:
        hull = points[ConvexHull(points).vertices]
    except (QhullError, ValueError):  # all on one line
        hull = points
    edges = np.roll(hull, -1, axis=0) - hull
    angles = np.unique(np.round(np.arctan2(edges[:, 1], edges[:, 0]) % (np.pi / 2), 9))
    cosine, sine = np.cos(angles), np.sin(angles)
    along = np.outer(cosine, hull[:, 0]) + np.outer(sine, hull[:, 1])
    across = np.outer(cosine, hull[:, 1]) - np.outer(sine, hull[:, 0])
    areas = np.ptp(along, axis=1) * np.ptp(across, axis=1)
    best = int((areas <= areas.min() * (1 + 1e-9)).argmax())
    return float(angles[best]), float(areas[best])
