"""The footprint of a robot: a polygon in its base frame that no collision shape reaches out of, seen from above.

A side of the polygon lies where the robot reaches farthest in its direction, so that it holds every shape by its
making: the directions are those of the sides of the hull around all boxes and meshes, and sixteen more where something
is round.
Sides are given up one by one, that which costs least area first, until there are as few as asked for; those beside a
side grow together. The corners are rounded at last, and moved outwards until nothing is lost by that.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import partial
from itertools import count
from typing import NamedTuple

from .bounds import along
from .geometry import Transform, Vector, dot
from .rest_pose import Clouds, no_clouds
from .robot import Robot
from .shape import MERGED, Box, Mesh, Shape

Point = tuple[float, float]

LEAST_CORNERS, CORNERS = 4, 12
LARGEST = 1e6  # m
_WAYS: tuple[Vector, ...] = tuple((x, y, z) for i in (-1.0, 1.0) for x, y, z in ((i, 0, 0), (0, i, 0), (0, 0, i)))
DIGITS = 4  # decimals of a corner (m)
_SMALL_STEPS = 20  # in which a footprint grows that is not large enough for its rounding
_ROUND = 16  # directions in which something round is touched
_NOTHING = 5e-4  # of the area
_SIDES = 48  # sides of a hull that are looked at; of more, the longest
_STEP = 10.0**-DIGITS
_SLACK = 1e-7  # m; the numbers of a costmap have 32 bits
_STRAIGHT = 1e-9
# Between the normals of two sides that meet: corners are no thorns. Of five sides, one can be spared in any case.
_WIDEST = math.radians(150)
_FARTHEST_CORNER = 1.05 / math.cos(_WIDEST / 2)  # of how far its sides move; corners that were rounded are sharper


class Footprint(NamedTuple):
    """Corners against the clock (m), the circles around the origin within and around, and how high the robot reaches.

    ``lowest`` and ``highest`` (m) are along z of the base frame. ``meshes`` are the links whose meshes are not in it,
    for nobody knows their size; ``solids`` is what is in it.
    """

    corners: tuple[Point, ...]
    inscribed: float
    circumscribed: float
    lowest: float
    highest: float
    meshes: tuple[str, ...] = ()
    solids: tuple[Placed, ...] = ()

    def holds(self, points: Sequence[Point]) -> bool:
        """Say whether no solid reaches out of the hull of some points."""
        return outside(self.solids, points)[0] <= _SLACK


class Placed(NamedTuple):
    """A collision shape in the base frame: its link, and what says how far it reaches along a unit vector (m).

    ``corners`` are those of boxes, or of a mesh the vertices that reach farthest in the plane and upright (m); nothing
    of what is round.
    """

    link: str
    reach: Callable[[Vector], float]
    corners: Sequence[Vector] = ()


def solids(
    robot: Robot, base: str, positions: Mapping[str, float], clouds: Clouds = no_clouds
) -> tuple[list[Placed], list[str]]:
    """Return the collision shapes in a base frame at joint positions (rad or m).

    ``clouds`` says where the vertices of meshes are; the links with a mesh of which it does not come second.
    """
    places = robot.poses_in_root(dict(positions))
    from_base = places[base].inverse()
    found: list[Placed] = []
    meshes: list[str] = []
    for name, place in places.items():
        there = from_base.then(place)
        for shape in robot.link[name].collision:
            if not isinstance(shape.geometry, Mesh):
                if shape.solids(MERGED):
                    found.append(Placed(name, along(shape, there), _corners(shape, there)))
                continue
            cloud = clouds(shape.geometry)
            if not cloud:
                meshes.append(name)
            else:
                points = _outermost(shape, there, shape.geometry, cloud)
                found.append(Placed(name, partial(_farthest, points), points))
    return found, list(dict.fromkeys(meshes))


def _outermost(shape: Shape, place: Transform, mesh: Mesh, vertices: Sequence[Vector]) -> tuple[Vector, ...]:
    """Return the vertices of a mesh that reach farthest in the plane of the base frame, and up and down."""
    there = place.then(shape.pose.transform())
    a, b, c = mesh.scale
    points = [there.apply((a * x, b * y, c * z)) for x, y, z in vertices]
    by_place = {point[:2]: point for point in points}
    ends = (min(points, key=lambda point: point[2]), max(points, key=lambda point: point[2]))
    return (*(by_place[corner] for corner in _hull(list(by_place))), *ends)


def _farthest(points: Sequence[Vector], direction: Vector) -> float:
    """Return how far points reach along a unit vector (m)."""
    return max(dot(point, direction) for point in points)


def _corners(shape: Shape, place: Transform) -> list[Vector]:
    """Return the corners of the boxes that a shape is made of, each once; none of what is round."""
    boxes = [one.geometry for one in shape.solids(MERGED) if isinstance(one.geometry, Box)]
    ends = (zip(box.lower, box.upper, strict=True) for box in boxes)
    corners = {(x, y, z) for xs, ys, zs in ends for x in xs for y in ys for z in zs}
    there = place.then(shape.pose.transform())
    return [there.apply(corner) for corner in corners]


def footprint(
    robot: Robot,
    base: str,
    positions: Mapping[str, float],
    corners: int = CORNERS,
    clouds: Clouds = no_clouds,
    margin: float = 0.0,
) -> Footprint | None:
    """Return the footprint of a robot in the plane of its base frame; None of one without collision shapes.

    ``positions`` are in rad or m by joint; ``corners`` is how many there may be, four or more. ``clouds`` as in
    ``solids``. ``margin`` (m) is what is left free around the robot. Raises ValueError for one that is larger than
    ``LARGEST``.
    """
    placed, meshes = solids(robot, base, positions, clouds)
    if not placed:
        return None
    lowest, highest = -_reach(placed, (0.0, 0.0, -1.0)), _reach(placed, (0.0, 0.0, 1.0))
    if not all(abs(_reach(placed, way)) < LARGEST for way in _WAYS):
        raise ValueError(f"the robot is larger than {LARGEST:,.0f} m")
    sides = [(normal, _reach(placed, (*normal, 0.0)) + margin) for normal in _normals(placed, corners)]
    sides = _fewer(sides, max(corners, LEAST_CORNERS))
    points = _rounded(placed, sides, margin)
    within = min(_offset(points, index) for index in range(len(points)))
    around = _around(placed, points, margin)
    return Footprint(tuple(points), within, around, lowest, highest, tuple(meshes), tuple(placed))


def _reach(placed: Sequence[Placed], direction: Vector) -> float:
    """Return how far some solids reach along a unit vector (m)."""
    return max(one.reach(direction) for one in placed)


def padded(points: Sequence[Point], padding: float) -> list[Point]:
    """Return a footprint as a costmap pads it: a corner moves by the signs of its coordinates, on an axis by none.

    ros-navigation/navigation2:nav2_costmap_2d/src/footprint.cpp, padFootprint.
    """

    def sign(value: float) -> float:
        return (value > 0) - (value < 0)

    return [(x + sign(x) * padding, y + sign(y) * padding) for x, y in points]


def outside(placed: Sequence[Placed], points: Sequence[Point], margin: float = 0.0) -> tuple[float, str]:
    """Return how far a robot reaches out of the hull of some points (m; zero: it does not), and the link that does.

    ``margin`` (m) is what is to be free around it.
    """
    ring = _hull(points)
    if len(ring) < 3:
        return math.inf, placed[0].link if placed else ""
    worst, link = 0.0, ""
    for normal, at in _sides(ring):
        for one in placed:
            beyond = one.reach((*normal, 0.0)) + margin - at
            if beyond > worst + _SLACK:
                worst, link = beyond, one.link
    return worst, link


def _sides(ring: Sequence[Point]) -> Iterator[_Side]:
    """Yield the sides of a convex polygon against the clock: normal, and distance from the origin along it (m)."""
    for (ax, ay), (bx, by) in zip(ring, [*ring[1:], *ring[:1]], strict=True):
        length = math.hypot(bx - ax, by - ay)
        normal = ((by - ay) / length, (ax - bx) / length)
        yield normal, normal[0] * ax + normal[1] * ay


def _around(placed: Sequence[Placed], points: Sequence[Point], margin: float) -> float:
    """Return the radius of the circle around the corners, and around what reaches out by less than the slack (m)."""
    beyond = max(_reach(placed, (*normal, 0.0)) + margin - at for normal, at in _sides(points))
    # All sides moved out by so much move no corner farther than this: corners are no thorns.
    return max(math.hypot(*point) for point in points) + max(0.0, beyond) * _FARTHEST_CORNER


def _normals(placed: Sequence[Placed], most: int) -> list[Point]:
    """Return the directions of the sides, by angle: each once. Of a robot that is round alone they are ``most``."""
    cornered = [one for one in placed if one.corners]
    ring = _hull([corner[:2] for one in cornered for corner in one.corners])
    sides = list(zip(ring, [*ring[1:], *ring[:1]], strict=True)) if len(ring) > 2 else []
    longest = sorted(sides, key=lambda side: -math.dist(*side))[:_SIDES]
    angles = [math.atan2(ax - bx, by - ay) for (ax, ay), (bx, by) in longest]
    if len(longest) < max(3, len(sides)) or outside([one for one in placed if not one.corners], ring)[0]:
        steps = max(most, LEAST_CORNERS) if not cornered else _ROUND
        angles += [2 * math.pi * step / steps for step in range(steps)]
    turns = sorted({round(angle % (2 * math.pi), 9) % round(2 * math.pi, 9) for angle in angles})
    turns = [turn for at in range(len(turns)) for turn in _blunted(turns[at], turns[(at + 1) % len(turns)])]
    return [(_plain(math.cos(angle)), _plain(math.sin(angle))) for angle in turns]


def _blunted(one: float, other: float) -> list[float]:
    """Return an angle, and one half-way to the next if that is too far for a corner (rad)."""
    gap = (other - one) % (2 * math.pi)
    return [one] if 0 < gap <= _WIDEST else [one, (one + gap / 2) % (2 * math.pi)]


def _plain(value: float) -> float:
    """Return a cosine without what rounding left of zero and one."""
    near = round(value)
    return float(near) if abs(value - near) < _STRAIGHT else value


def _hull(points: Sequence[Point]) -> list[Point]:
    """Return the convex hull of points against the clock (A. M. Andrew, 1979)."""
    ordered = sorted(set(points))

    def half(some: Sequence[Point]) -> list[Point]:
        ring: list[Point] = []
        for point in some:
            while len(ring) > 1 and _turn(ring[-2], ring[-1], point) <= _STRAIGHT * _STRAIGHT:
                ring.pop()
            ring.append(point)
        return ring

    if len(ordered) < 3:
        return ordered
    return [*half(ordered)[:-1], *half(ordered[::-1])[:-1]]


def _turn(a: Point, b: Point, c: Point) -> float:
    return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])


_Side = tuple[Point, float]


def _fewer(sides: list[_Side], most: int) -> list[_Side]:
    """Return so many sides of those given at most, by angle: those without which the area grows most.

    What gains next to nothing goes too.
    """
    left = list(sides)
    while len(left) > LEAST_CORNERS:
        cost, index = min((_cost(left, index), index) for index in range(len(left)))
        if math.isinf(cost) or (len(left) <= most and cost > _NOTHING * _area(left)):
            break
        del left[index]
    return left


def _area(sides: Sequence[_Side]) -> float:
    """Return the area within some sides (m^2)."""
    corners = [_meet(sides[index - 1], sides[index]) for index in range(len(sides))]
    return sum(_cross(corners[index - 1], corners[index]) for index in range(len(corners))) / 2


def _cost(sides: Sequence[_Side], index: int) -> float:
    """Return the area that a polygon gains when a side goes (m^2); infinite if those beside it would not meet."""
    before, own, after = (sides[(index + step) % len(sides)] for step in (-1, 0, 1))
    angle = math.atan2(_cross(before[0], after[0]), before[0][0] * after[0][0] + before[0][1] * after[0][1])
    if not 0 < angle < _WIDEST:
        return math.inf
    peak, one, other = _meet(before, after), _meet(before, own), _meet(own, after)
    return abs(_turn(one, peak, other)) / 2


def _cross(a: Point, b: Point) -> float:
    return a[0] * b[1] - a[1] * b[0]


def _meet(one: _Side, other: _Side) -> Point:
    """Return the point in which two sides meet."""
    (a, b), p = one
    (c, d), q = other
    under = a * d - b * c
    return ((p * d - q * b) / under, (a * q - c * p) / under)


def _rounded(placed: Sequence[Placed], sides: Sequence[_Side], margin: float) -> list[Point]:
    """Return the corners with few decimals, as near as they can be without that a shape, with a margin, reaches out."""
    for tried in count():
        more = _STEP / 2 * (tried if tried < _SMALL_STEPS else 2 ** (tried - _SMALL_STEPS / 2))
        wide = [(normal, at + more) for normal, at in sides]
        corners = [_meet(wide[index - 1], wide[index]) for index in range(len(wide))]
        points = _hull([(round(x, DIGITS) + 0.0, round(y, DIGITS) + 0.0) for x, y in corners])
        if outside(placed, points, margin)[0] <= _SLACK:
            break
    return points


def _offset(points: Sequence[Point], index: int) -> float:
    """Return how far a side is from the origin (m); below zero if the origin is outside of it."""
    (ax, ay), (bx, by) = points[index - 1], points[index]
    return (ax * by - ay * bx) / math.hypot(bx - ax, by - ay)
