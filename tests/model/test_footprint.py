"""The footprint: no shape reaches out of it, whatever the robot is made of; points of the shapes are the judges."""

import math
import random
from collections.abc import Sequence

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rosorin_compile.model import (
    Box,
    Capsule,
    Cylinder,
    Ellipsoid,
    Joint,
    Link,
    Mesh,
    Pose,
    Robot,
    Shape,
    Sphere,
    Vector,
)
from rosorin_compile.ros.nav2.footprint import Footprint, Solid, footprint, holds, pad, solids_of

FLOAT32 = 2e-7  # m; a costmap has 32 bits
CLOUDS: dict[str, list[Vector]] = {}


def cloud(mesh: Mesh) -> list[Vector] | None:
    return CLOUDS.get(mesh.file)


def sampled(shape: Shape, chance: random.Random, count: int = 40) -> list[Vector]:
    geometry, points = shape.geometry, []
    for _ in range(count):
        a, b, c = (chance.gauss(0, 1) for _ in range(3))
        length = math.hypot(a, b, c) or 1.0
        x, y, z = a / length, b / length, c / length
        if isinstance(geometry, Sphere):
            points.append((geometry.radius * x, geometry.radius * y, geometry.radius * z))
        elif isinstance(geometry, Ellipsoid):
            points.append(tuple(part * radius for part, radius in zip((x, y, z), geometry.radii, strict=True)))
        elif isinstance(geometry, Capsule):
            end = math.copysign(geometry.length / 2, z)
            points.append((geometry.radius * x, geometry.radius * y, geometry.radius * z + end))
        elif isinstance(geometry, Cylinder):
            flat = math.hypot(x, y) or 1.0
            end = math.copysign(geometry.length / 2, z)
            points.append((geometry.radius * x / flat, geometry.radius * y / flat, end))
        elif isinstance(geometry, Box):
            points.append(tuple(chance.choice(ends) for ends in zip(geometry.lower, geometry.upper, strict=True)))
        elif isinstance(geometry, Mesh):
            corners = chance.choices(CLOUDS[geometry.file], k=3)
            parts = [chance.random() for _ in corners]
            point = [
                sum(p * corner[axis] for p, corner in zip(parts, corners, strict=True)) / sum(parts)
                for axis in range(3)
            ]
            points.append(tuple(part * scale for part, scale in zip(point, geometry.scale, strict=True)))
    if isinstance(geometry, Mesh):
        points += [tuple(p * s for p, s in zip(one, geometry.scale, strict=True)) for one in CLOUDS[geometry.file]]
    return points


def is_within(point: Sequence[float], corners: Sequence[tuple[float, float]], slack: float = FLOAT32) -> bool:
    x, y = point[:2]
    for (ax, ay), (bx, by) in zip(corners, [*corners[1:], corners[0]], strict=True):
        if ((bx - ax) * (y - ay) - (by - ay) * (x - ax)) / math.hypot(bx - ax, by - ay) < -slack:
            return False
    return True


length = st.floats(0.005, 1.5)
angle = st.floats(-4, 4)
place = st.tuples(*[st.floats(-1, 1)] * 3)
pose = st.builds(Pose, place, st.tuples(angle, angle, angle))
corner = st.tuples(*[st.floats(-500, 500)] * 3)


@st.composite
def meshes(draw: st.DrawFn) -> Mesh:
    name = f"{len(CLOUDS)}.stl"
    CLOUDS[name] = draw(st.lists(corner, min_size=4, max_size=120))
    scale = draw(st.sampled_from([(0.001, 0.001, 0.001), (0.002, 0.001, 0.0005), (-0.001, 0.001, 0.001)]))
    return Mesh(name, scale)


geometries = st.one_of(
    st.builds(lambda a, b, c: Box((-a, -b, -c), (a, b, c)), length, length, length),
    st.builds(lambda a, b, c: Box((a / 9, -b, c / 2), (a, b / 3, c)), length, length, length),
    st.builds(Cylinder, length, length),
    st.builds(Capsule, length, length),
    st.builds(Sphere, length),
    st.builds(lambda a, b, c: Ellipsoid((a, b, c)), length, length, length),
    meshes(),
)
links = st.lists(st.lists(st.builds(Shape, geometries, pose), max_size=3), min_size=1, max_size=4)


@st.composite
def robots(draw: st.DrawFn) -> Robot:
    """Return a robot of up to four links, each on one before it by a joint of any kind that moves, or a fixed one."""
    shapes = draw(links)
    shapes[0] = shapes[0] or [Shape(draw(geometries))]
    made = [Link(f"l{index}", collision=tuple(some)) for index, some in enumerate(shapes)]
    joints = []
    for index in range(1, len(made)):
        above = draw(st.integers(0, index - 1))
        kind = draw(st.sampled_from(["fixed", "continuous", "prismatic"]))
        axis = draw(st.sampled_from([(0.0, 0.0, 1.0), (0.0, 1.0, 0.0), (0.6, 0.0, 0.8)]))
        joints.append(Joint(f"j{index}", kind, f"l{above}", f"l{index}", draw(pose), axis))
    return Robot("random", tuple(made), tuple(joints))


def points_of(robot: Robot, base: str, positions: dict[str, float], chance: random.Random) -> list[Vector]:
    from_base = robot.pose_in_root(base, positions).inverse()
    return [
        from_base.then(robot.pose_in_root(link.name, positions)).then(shape.pose.transform()).apply(point)
        for link in robot.links
        for shape in link.collision
        for point in sampled(shape, chance)
    ]


@settings(max_examples=120, deadline=None)
@given(robots(), st.integers(4, 20), st.floats(-3, 3), st.integers(0, 2**32))
def test_no_robot_reaches_out_of_its_footprint(robot: Robot, corners: int, position: float, seed: int) -> None:
    base = robot.links[-1].name
    positions = {joint.name: position for joint in robot.joints if not joint.is_fixed}
    solids, unknown = solids_of(robot, base, positions, cloud)
    assert not unknown
    made = footprint(solids, corners)
    assert 3 <= len(made.corners) <= corners
    for point in points_of(robot, base, positions, random.Random(seed)):  # noqa: S311
        assert is_within(point, made.corners)
        assert made.lowest - 1e-9 <= point[2] <= made.highest + 1e-9
        assert math.hypot(point[0], point[1]) <= made.circumscribed + 1e-9
    assert all(round(value, 4) == value for one in made.corners for value in one)


@settings(max_examples=50, deadline=None)
@given(robots(), st.floats(0, 0.2), st.integers(0, 2**32))
def test_a_margin_is_free_on_all_sides(robot: Robot, margin: float, seed: int) -> None:
    made = footprint(solids_of(robot, "l0", {}, cloud)[0], 12, margin)
    chance = random.Random(seed)  # noqa: S311
    for x, y, _ in points_of(robot, "l0", {}, chance):
        way = chance.uniform(0, math.tau)
        assert is_within((x + margin * math.cos(way), y + margin * math.sin(way)), made.corners, 1e-6)


def placed(*shapes: Shape) -> list[Solid]:
    return solids_of(Robot("r", (Link("base", collision=shapes),), ()), "base", {}, cloud)[0]


def of(*shapes: Shape) -> Footprint:
    return footprint(placed(*shapes))


def test_a_box_has_its_own_corners() -> None:
    made = of(Shape(Box((-0.2, -0.1, 0), (0.3, 0.1, 0.4)), Pose((0, 0, 0.05))))
    assert set(made.corners) == {(-0.2, -0.1), (0.3, -0.1), (0.3, 0.1), (-0.2, 0.1)}
    assert (made.inscribed, made.lowest, made.highest) == pytest.approx((0.1, 0.05, 0.45))
    assert made.circumscribed == pytest.approx(math.hypot(0.3, 0.1))


@pytest.mark.parametrize("more", [2e-9, 3e-8])
def test_the_circle_holds_what_the_corners_leave_out_for_the_digits_of_a_costmap(more: float) -> None:
    half = 1 + more
    for shape in (
        Shape(Box((-half, -half, 0), (half, half, 1))),
        Shape(Cylinder(half, 2 * half), Pose(rpy=(0, math.pi / 2, 0))),
    ):
        made = of(shape)
        assert set(made.corners) == {(-1, -1), (1, -1), (1, 1), (-1, 1)}
        assert math.hypot(half, half) <= made.circumscribed < math.hypot(1, 1) + 5 * more


def test_a_mesh_without_vertices_is_reported() -> None:
    robot = Robot("r", (Link("base", collision=(Shape(Sphere(0.1)), Shape(Mesh("unknown.stl")))),), ())
    assert solids_of(robot, "base", {}, cloud)[1] == ["base"]


def test_padding_is_that_of_a_costmap() -> None:
    """A corner on an axis is not moved in that direction; one of a slanted side may move inwards."""
    assert pad([(1.0, 0.0), (-1.0, 2.0)], 0.1) == [(1.1, 0.0), (-1.1, 2.1)]
    turned = placed(Shape(Box((-0.6, -0.2, 0), (0.4, 0.05, 0.3)), Pose(rpy=(0, 0, math.radians(55)))))
    corners = footprint(turned).corners
    assert not holds(turned, pad(corners, 0.03))
    assert holds(turned, corners)
