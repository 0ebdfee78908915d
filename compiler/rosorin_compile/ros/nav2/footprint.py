"""The footprint of a robot: a polygon in its base frame that contains every collision shape, seen from above.

Each side of the polygon touches the robot, so that it contains every shape by construction. The directions of the sides
are those of the convex hull around all boxes and meshes, and sixteen more where something is round. Sides are removed
one by one, the one that adds the least area first, until there are as few as requested. The corners are rounded at the
end, and the sides moved outwards until nothing is lost by that.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from itertools import count
from typing import NamedTuple

from rosorin_compile.model import Box, Mesh, Robot, Vector
from rosorin_compile.model.bounds import along
from rosorin_compile.model.geometry import dot
from rosorin_compile.model.mesh_vertices import Clouds, no_clouds
from rosorin_compile.model.shape import MERGED

Point = tuple[float, float]
Side = tuple[Point, float]  # the normal of a side, and its distance from the origin (m)

LEAST_CORNERS, CORNERS = 4, 12
LARGEST = 1e6  # m
DIGITS = 4  # decimals of a corner (m)
_STEP = 10.0**-DIGITS
_SMALL_STEPS = 20  # in which a footprint grows that is too small after rounding; then larger ones
_ROUND = 16  # directions in which something round is touched
_NOTHING = 5e-4  # of the area: a side that adds less is removed, too
_SIDES = 48  # the longest sides of a hull that are used
_SLACK = 1e-7  # m; the numbers of a costmap have 32 bits
_STRAIGHT = 1e-9
# Between the normals of two adjacent sides: corners are not sharper. Of five sides, one can be removed in any case.
_WIDEST = math.radians(150)
_FARTHEST_CORNER = 1.05 / math.cos(_WIDEST / 2)  # of how far its sides move; rounded corners are sharper
_DIRECTIONS = tuple((math.cos(math.tau * i / 16), math.sin(math.tau * i / 16), 0.0) for i in range(16))


class Placed(NamedTuple):
    """A collision shape in the base frame: its link, and how far it reaches along a unit vector (m).

    ``corners`` (m) are those of boxes, or the outermost vertices of a mesh; empty for a round shape.
    """

    link: str
    reach: Callable[[Vector], float]
    corners: Sequence[Vector] = ()


class Footprint(NamedTuple):
    """Counter-clockwise corners (m), the radii of the circles around the origin inside and outside, and the heights.

    ``lowest`` and ``highest`` (m) are along z of the base frame. ``meshes`` are the links with a mesh of unknown size,
    which is not included; ``solids`` are the shapes that are.
    """

    corners: tuple[Point, ...]
    inscribed: float
    circumscribed: float
    lowest: float
    highest: float
    meshes: tuple[str, ...] = ()
    solids: tuple[Placed, ...] = ()

    def holds(self, points: Sequence[Point]) -> bool:
        """Return True if every solid is inside the hull of points (m)."""
        return outside(self.solids, points)[0] <= _SLACK


def solids(
    robot: Robot, base: str, positions: Mapping[str, float], clouds: Clouds = no_clouds
) -> tuple[list[Placed], list[str]]:
    """Return the collision shapes in a base frame at joint positions (rad or m), and the links with unknown meshes."""
    places = robot.poses_in_root(dict(positions))
    from_base = places[base].inverse()
    found: list[Placed] = []
    meshes: list[str] = []
    for name, place in places.items():
        there = from_base.then(place)
        for shape in robot.link[name].collision:
            frame = there.then(shape.pose.transform())
            if isinstance(shape.geometry, Mesh):
                vertices = clouds(shape.geometry)
                if not vertices:
                    meshes.append(name)
                    continue
                a, b, c = shape.geometry.scale
                points = _outermost([frame.apply((a * x, b * y, c * z)) for x, y, z in vertices])
                found.append(Placed(name, lambda way, points=points: max(dot(p, way) for p in points), points))  # type: ignore[misc]
            elif pieces := shape.solids(MERGED):
                boxes = [piece.geometry for piece in pieces if isinstance(piece.geometry, Box)]
                ends = (zip(box.lower, box.upper, strict=True) for box in boxes)
                corners = {(x, y, z) for xs, ys, zs in ends for x in xs for y in ys for z in zs}
                found.append(Placed(name, along(shape, there), [frame.apply(corner) for corner in corners]))
    return found, list(dict.fromkeys(meshes))


def _outermost(points: Sequence[Vector]) -> tuple[Vector, ...]:
    by_place = {point[:2]: point for point in points}
    ends = (min(points, key=lambda point: point[2]), max(points, key=lambda point: point[2]))
    return (*(by_place[corner] for corner in _hull(list(by_place))), *ends)


def footprint(
    robot: Robot,
    base: str,
    positions: Mapping[str, float],
    corners: int = CORNERS,
    clouds: Clouds = no_clouds,
    margin: float = 0.0,
) -> Footprint | None:
    """Return the footprint of a robot in the plane of its base frame, or None if it has no collision shapes.

    ``positions`` are in rad or m by joint; ``corners`` is the largest number of corners, four or more; ``margin`` (m)
    is left free around the robot. Raises ValueError for a robot larger than ``LARGEST``.
    """
    placed, meshes = solids(robot, base, positions, clouds)
    if not placed:
        return None
    axes = [(i, 0.0, 0.0) for i in (-1.0, 1.0)] + [(0.0, i, 0.0) for i in (-1.0, 1.0)]
    down, up = (_reach(placed, (0.0, 0.0, i)) for i in (-1.0, 1.0))
    if not all(abs(size) < LARGEST for size in (down, up, *(_reach(placed, axis) for axis in axes))):
        raise ValueError(f"the robot is larger than {LARGEST:,.0f} m")
    sides = [(normal, _reach(placed, (*normal, 0.0)) + margin) for normal in _normals(placed, corners)]
    points = _rounded(placed, _fewer(sides, max(corners, LEAST_CORNERS)), margin)
    pairs = [(points[index - 1], points[index]) for index in range(len(points))]
    inscribed = min(_cross(a, b) / math.hypot(b[0] - a[0], b[1] - a[1]) for a, b in pairs)
    # Rounding leaves out at most the slack. All sides moved out by so much move no corner farther than this.
    beyond = max(_reach(placed, (*normal, 0.0)) + margin - at for normal, at in _sides(points))
    circumscribed = max(math.hypot(*point) for point in points) + max(0.0, beyond) * _FARTHEST_CORNER
    return Footprint(tuple(points), inscribed, circumscribed, -down, up, tuple(meshes), tuple(placed))


def _reach(placed: Sequence[Placed], direction: Vector) -> float:
    return max(solid.reach(direction) for solid in placed)


def padded(points: Sequence[Point], padding: float) -> list[Point]:
    """Return a footprint like a costmap pads it: a corner moves by the signs of its coordinates, on an axis by none.

    ros-navigation/navigation2:nav2_costmap_2d/src/footprint.cpp, padFootprint.
    """

    def sign(value: float) -> float:
        return (value > 0) - (value < 0)

    return [(x + sign(x) * padding, y + sign(y) * padding) for x, y in points]


def outside(placed: Sequence[Placed], points: Sequence[Point], margin: float = 0.0) -> tuple[float, str]:
    """Return how far a robot with a margin (m) reaches out of the hull of points (m), and the link that does."""
    ring = _hull(points)
    if len(ring) < 3:
        return math.inf, placed[0].link if placed else ""
    worst, link = 0.0, ""
    for normal, at in _sides(ring):
        for solid in placed:
            beyond = solid.reach((*normal, 0.0)) + margin - at
            if beyond > worst + _SLACK:
                worst, link = beyond, solid.link
    return worst, link


class LeftOut(NamedTuple):
    """A joint that a pose leaves at zero: the link that reaches farthest there, how far, and the least possible (m)."""

    joint: str
    link: str
    reach: float
    least: float


def left_out(robot: Robot, base: str, positions: Mapping[str, float], clouds: Clouds) -> Iterator[LeftOut]:
    """Yield joints that a pose does not name, and that determine the footprint since they reach farthest at zero.

    ``positions`` are those of the pose (rad or m), ``base`` is the frame of the footprint.
    """

    def reach(placed: Sequence[Placed]) -> tuple[float, str]:
        return max((solid.reach(way), solid.link) for solid in placed if solid.link in below for way in _DIRECTIONS)

    placed, _ = solids(robot, base, positions, clouds)
    farthest = {max(placed, key=lambda solid, way=way: solid.reach(way)).link for way in _DIRECTIONS if placed}  # type: ignore[misc]
    for joint in robot.joints:
        below = set(robot.below(joint.child))
        if not joint.moves or joint.mimic is not None or joint.name in positions or not farthest & below:
            continue
        lower, upper = (joint.limit.known(side) for side in ("lower", "upper")) if joint.limit else (None, None)
        if joint.type == "continuous":
            lower, upper = -math.pi, math.pi
        if lower is None or upper is None or not lower < upper:
            continue
        states = [{**positions, joint.name: lower + (upper - lower) * i / 8} for i in range(9)]
        reaches = [reach(solids(robot, base, state, clouds)[0])[0] for state in states]
        here, link = reach(placed)
        if here >= max(reaches) - 1e-3 and here - min(reaches) > 0.02:  # m
            yield LeftOut(joint.name, link, here, min(reaches))


def _sides(ring: Sequence[Point]) -> Iterator[Side]:
    for (ax, ay), (bx, by) in zip(ring, [*ring[1:], *ring[:1]], strict=True):
        length = math.hypot(bx - ax, by - ay)
        normal = ((by - ay) / length, (ax - bx) / length)
        yield normal, normal[0] * ax + normal[1] * ay


def _normals(placed: Sequence[Placed], most: int) -> list[Point]:
    cornered = [solid for solid in placed if solid.corners]
    ring = _hull([corner[:2] for solid in cornered for corner in solid.corners])
    sides = list(zip(ring, [*ring[1:], *ring[:1]], strict=True)) if len(ring) > 2 else []
    longest = sorted(sides, key=lambda side: -math.dist(*side))[:_SIDES]
    angles = [math.atan2(ax - bx, by - ay) for (ax, ay), (bx, by) in longest]
    if len(longest) < max(3, len(sides)) or outside([solid for solid in placed if not solid.corners], ring)[0]:
        steps = max(most, LEAST_CORNERS) if not cornered else _ROUND
        angles += [2 * math.pi * step / steps for step in range(steps)]
    angles = sorted({round(angle % (2 * math.pi), 9) % round(2 * math.pi, 9) for angle in angles})
    normals = []
    for index, angle in enumerate(angles):
        gap = (angles[(index + 1) % len(angles)] - angle) % (2 * math.pi)
        # One half-way to the next where that is too far for a corner.
        for turn in [angle] if 0 < gap <= _WIDEST else [angle, (angle + gap / 2) % (2 * math.pi)]:
            x, y = (round(c) if abs(c - round(c)) < _STRAIGHT else c for c in (math.cos(turn), math.sin(turn)))
            normals.append((float(x), float(y)))
    return normals


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


def _meet(first: Side, second: Side) -> Point:
    ((a, b), p), ((c, d), q) = first, second
    under = a * d - b * c
    return ((p * d - q * b) / under, (a * q - c * p) / under)


def _polygon(sides: Sequence[Side]) -> list[Point]:
    return [_meet(sides[index - 1], sides[index]) for index in range(len(sides))]


def _fewer(sides: list[Side], most: int) -> list[Side]:

    def added(index: int) -> float:
        """Return the area that removing a side adds (m^2); infinite if its neighbours would not meet."""
        before, side, after = (left[(index + step) % len(left)] for step in (-1, 0, 1))
        angle = math.atan2(_cross(before[0], after[0]), before[0][0] * after[0][0] + before[0][1] * after[0][1])
        if not 0 < angle < _WIDEST:
            return math.inf
        return abs(_turn(_meet(before, side), _meet(before, after), _meet(side, after))) / 2

    left = list(sides)
    while len(left) > LEAST_CORNERS:
        cost, index = min((added(index), index) for index in range(len(left)))
        corners = _polygon(left)
        area = sum(_cross(corners[index - 1], corners[index]) for index in range(len(corners))) / 2
        if math.isinf(cost) or (len(left) <= most and cost > _NOTHING * area):
            break
        del left[index]
    return left


def _rounded(placed: Sequence[Placed], sides: Sequence[Side], margin: float) -> list[Point]:
    for tried in count():
        more = _STEP / 2 * (tried if tried < _SMALL_STEPS else 2 ** (tried - _SMALL_STEPS / 2))
        corners = _polygon([(normal, at + more) for normal, at in sides])
        points = _hull([(round(x, DIGITS) + 0.0, round(y, DIGITS) + 0.0) for x, y in corners])
        if outside(placed, points, margin)[0] <= _SLACK:
            break
    return points
