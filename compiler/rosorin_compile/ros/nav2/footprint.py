"""Compute the footprint of a robot: a polygon in its base frame that contains the projection of all collision shapes.

The sides are parallel to the sides of the convex hull of all boxes and meshes; for round shapes, sides in 16 more
directions are added. Each side touches the robot. If there are too many sides, the side whose removal adds the least
area is removed first. Corners are then rounded, and the sides are moved outwards until the polygon contains every
shape.
"""

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from itertools import count
from typing import NamedTuple

from rosorin_compile.model import Box, Mesh, Robot, Vector
from rosorin_compile.model.bounds import reach_along
from rosorin_compile.model.geometry import dot
from rosorin_compile.model.mesh_vertices import Clouds
from rosorin_compile.model.shape import MERGED

Point = tuple[float, float]
Side = tuple[Point, float]  # unit normal of a side, and its distance from the origin (m)

LEAST_CORNERS, CORNERS = 4, 12
LARGEST = 1e6  # m: maximum coordinate
DIGITS = 4  # decimal places of coordinates in m
_ROUND = 16  # number of candidate sides for round shapes
_NOTHING = 5e-4  # sides whose removal adds less than this fraction of the area are removed
_SIDES = 48  # maximum number of hull sides; the longest are used
_SLACK = 1e-7  # m: tolerance for rounding errors of a costmap, which uses 32-bit floats
_STRAIGHT = 1e-9
_WIDEST = math.radians(150)  # largest angle between normals of adjacent sides: sharper corners are avoided
_FARTHEST_CORNER = 1.05 / math.cos(_WIDEST / 2)  # maximum shift of a corner if its sides move by 1 m, plus 5 %


class Solid(NamedTuple):
    """A collision shape in the base frame (m); ``reach`` is the support function, the extent along a unit vector.

    ``corners`` are the corners of a box, or the vertices of the convex hull of a mesh; round shapes have none.
    """

    reach: Callable[[Vector], float]
    corners: Sequence[Vector] = ()


class Footprint(NamedTuple):
    """A footprint: counter-clockwise corners, inscribed and circumscribed radius, and the z range of the robot (m)."""

    corners: tuple[Point, ...]
    inscribed: float
    circumscribed: float
    lowest: float
    highest: float


def solids_of(robot: Robot, base: str, positions: Mapping[str, float], clouds: Clouds) -> tuple[list[Solid], list[str]]:
    """Return the collision shapes in the frame ``base`` and the links with unreadable meshes.

    ``positions`` are joint positions (rad or m); ``clouds`` returns the vertices of a mesh.
    """
    places = robot.poses_in_root(dict(positions))
    from_base = places[base].inverse()
    found: list[Solid] = []
    unknown: dict[str, None] = {}
    for link, place in places.items():
        there = from_base.then(place)
        for shape in robot.link[link].collision:
            frame = there.then(shape.pose.transform())
            if isinstance(shape.geometry, Mesh):
                a, b, c = shape.geometry.scale
                points = [frame.apply((a * x, b * y, c * z)) for x, y, z in clouds(shape.geometry) or ()]
                found += [_mesh(points)] if points else []
                unknown |= {} if points else {link: None}
            elif pieces := shape.solids(MERGED):
                boxes = [piece.geometry for piece in pieces if isinstance(piece.geometry, Box)]
                ends = (zip(box.lower, box.upper, strict=True) for box in boxes)
                corners = {(x, y, z) for xs, ys, zs in ends for x in xs for y in ys for z in zs}
                found.append(Solid(reach_along(shape, there), [frame.apply(corner) for corner in corners]))
    return found, list(unknown)


def _mesh(points: Sequence[Vector]) -> Solid:
    by_place = {point[:2]: point for point in points}
    ends = (min(points, key=lambda point: point[2]), max(points, key=lambda point: point[2]))
    outermost = (*(by_place[corner] for corner in _hull(list(by_place))), *ends)
    return Solid(lambda way: max(dot(point, way) for point in outermost), outermost)


def footprint(solids: Sequence[Solid], most: int = CORNERS, margin: float = 0.0) -> Footprint:
    """Compute a footprint with at most ``most`` corners (at least four) around shapes.

    ``margin`` is the clearance around the shapes (m). Raises ValueError if the robot is larger than ``LARGEST`` (m).
    """
    ways = ((0, 0, -1), (0, 0, 1), (-1, 0, 0), (1, 0, 0), (0, -1, 0), (0, 1, 0))
    down, up, *_ = sizes = [_reach(solids, way) for way in ways]
    if not all(abs(size) < LARGEST for size in sizes):
        raise ValueError(f"the robot is larger than {LARGEST:,.0f} m")
    most = max(most, LEAST_CORNERS)
    sides = _fewer([(one, _reach(solids, (*one, 0.0)) + margin) for one in _normals(solids, most)], most)
    for tried in count():
        moved = _polygon([(normal, at + 10.0**-DIGITS / 2 * tried) for normal, at in sides])
        points = _hull([(round(x, DIGITS) + 0.0, round(y, DIGITS) + 0.0) for x, y in moved])
        if holds(solids, points, margin):
            break
    inscribed = min(at for _, at in _sides(points))
    # Because of rounding, shapes can protrude by up to _SLACK: add the resulting shift of a corner to the radius.
    beyond = max(_reach(solids, (*normal, 0.0)) + margin - at for normal, at in _sides(points))
    circumscribed = max(math.hypot(*point) for point in points) + max(0.0, beyond) * _FARTHEST_CORNER
    return Footprint(tuple(points), inscribed, circumscribed, -down, up)


def _reach(solids: Sequence[Solid], direction: Vector) -> float:
    return max(solid.reach(direction) for solid in solids)


def holds(solids: Sequence[Solid], points: Sequence[Point], margin: float = 0.0) -> bool:
    """Return True if the convex hull of ``points`` (m) contains all shapes with a clearance of ``margin`` (m)."""
    ring = _hull(points)
    return len(ring) > 2 and all(_reach(solids, (*normal, 0.0)) + margin <= at + _SLACK for normal, at in _sides(ring))


def pad(points: Sequence[Point], padding: float) -> list[Point]:
    """Pad a footprint as a costmap does: shift each nonzero coordinate of a corner by ``padding`` (m) away from zero.

    Source: ros-navigation/navigation2:nav2_costmap_2d/src/footprint.cpp, padFootprint.
    """

    def moved(value: float) -> float:
        return value + math.copysign(padding, value) if value else value

    return [(moved(x), moved(y)) for x, y in points]


def _normals(solids: Sequence[Solid], most: int) -> list[Point]:
    cornered, round_ones = [one for one in solids if one.corners], [one for one in solids if not one.corners]
    ring = _hull([corner[:2] for solid in cornered for corner in solid.corners])
    edges = list(zip(ring, [*ring[1:], *ring[:1]], strict=True)) if len(ring) > 2 else []
    longest = sorted(edges, key=lambda edge: -math.dist(*edge))[:_SIDES]
    angles = [math.atan2(ax - bx, by - ay) % math.tau for (ax, ay), (bx, by) in longest]
    ordered = sorted(angles)
    gaps = [(after - before) % math.tau for before, after in zip(ordered, [*ordered[1:], *ordered[:1]], strict=True)]
    if max(gaps, default=math.tau) > _WIDEST or len(edges) > _SIDES or (round_ones and not holds(round_ones, ring)):
        steps = _ROUND if cornered else most
        angles += [math.tau * step / steps for step in range(steps)]
    angles = sorted({round(angle, 9) % round(math.tau, 9) for angle in angles})
    return [(_straight(math.cos(angle)), _straight(math.sin(angle))) for angle in angles]


def _straight(value: float) -> float:
    return float(round(value)) if abs(value - round(value)) < _STRAIGHT else value


def _fewer(sides: Sequence[Side], most: int) -> list[Side]:
    """Remove sides that hardly change the area, and then further sides until at most ``most`` are left."""
    left = list(sides)

    def added(index: int) -> float:
        """Return the area (m^2) that removing a side adds, or infinity if the adjacent sides would not intersect."""
        before, side, after = (left[(index + step) % len(left)] for step in (-1, 0, 1))
        angle = math.atan2(_cross(before[0], after[0]), before[0][0] * after[0][0] + before[0][1] * after[0][1])
        if not 0 < angle < _WIDEST:
            return math.inf
        return abs(_turn(_meet(before, side), _meet(before, after), _meet(side, after))) / 2

    while len(left) > LEAST_CORNERS:
        cost, index = min((added(index), index) for index in range(len(left)))
        corners = _polygon(left)
        area = sum(_cross(corners[index - 1], corners[index]) for index in range(len(corners))) / 2
        if math.isinf(cost) or (len(left) <= most and cost > _NOTHING * area):
            break
        del left[index]
    return left


def _sides(ring: Sequence[Point]) -> Iterator[Side]:
    for (ax, ay), (bx, by) in zip(ring, [*ring[1:], *ring[:1]], strict=True):
        length = math.hypot(bx - ax, by - ay)
        normal = ((by - ay) / length, (ax - bx) / length)
        yield normal, normal[0] * ax + normal[1] * ay


def _polygon(sides: Sequence[Side]) -> list[Point]:
    return [_meet(sides[index - 1], sides[index]) for index in range(len(sides))]


def _meet(first: Side, second: Side) -> Point:
    ((a, b), p), ((c, d), q) = first, second
    return ((p * d - q * b) / (a * d - b * c), (a * q - c * p) / (a * d - b * c))


def _hull(points: Sequence[Point]) -> list[Point]:
    ordered = sorted(set(points))
    if len(ordered) < 3:
        return ordered
    halves = []
    for some in (ordered, ordered[::-1]):
        ring: list[Point] = []
        for point in some:
            while len(ring) > 1 and _turn(ring[-2], ring[-1], point) <= _STRAIGHT * _STRAIGHT:
                ring.pop()
            ring.append(point)
        halves += ring[:-1]
    return halves


def _cross(a: Point, b: Point) -> float:
    return a[0] * b[1] - a[1] * b[0]


def _turn(a: Point, b: Point, c: Point) -> float:
    return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
