"""Collisions in the URDF: shapes of frames that it does not carry move to the link that they are fixed to."""

from __future__ import annotations

import itertools
import math

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rosorin_compile.formats.templating import Templates
from rosorin_compile.formats.urdf.write import write
from rosorin_compile.model import (
    ROBOT_STATE_PUBLISHER,
    STATIC_TRANSFORM_PUBLISHER,
    Box,
    HeightMap,
    Joint,
    Link,
    Output,
    Pose,
    Publisher,
    Robot,
    Shape,
    Sphere,
    Transform,
    Vector,
)
from rosorin_compile.model.geometry import plane_axes
from rosorin_compile.model.joint import UNPUBLISHED
from support.machines import BOX, LIMIT
from support.urdf_robots import emit, link, numbers, parsed

NOBODY = Publisher(UNPUBLISHED, about="for a test")
SIMULATED = Publisher(UNPUBLISHED, about="for a test", simulated=True)
STATIC = Publisher(STATIC_TRANSFORM_PUBLISHER, "tf")

angle = st.floats(-math.pi, math.pi)
coordinate = st.floats(-2, 2)
any_pose = st.builds(Pose, st.tuples(coordinate, coordinate, coordinate), st.tuples(angle, angle, angle))
quarter = st.sampled_from([0.0, math.pi / 2, math.pi, -math.pi / 2, -math.pi])
turned = st.builds(Pose, st.tuples(coordinate, coordinate, coordinate), st.tuples(quarter, quarter, quarter))


def mounted(below: Pose, above: Pose, further: Pose, own: Pose) -> Robot:
    """Return base_link with boxes on frames that are fixed to it, above and below, and that the URDF does not carry."""
    box = (Shape(BOX, own),)
    return Robot(
        "r",
        (Link("floor", collision=box), Link("base_link"), Link("laser"), Link("cover", collision=box), Link("arm")),
        (
            Joint("floor_joint", "fixed", "floor", "base_link", below, publisher=NOBODY),
            Joint("laser_joint", "fixed", "base_link", "laser", above, publisher=STATIC),
            Joint("cover_joint", "fixed", "laser", "cover", further, publisher=NOBODY),
            Joint("arm_joint", "revolute", "base_link", "arm", limit=LIMIT),
        ),
    )


def corners(box: Box, transform: Transform) -> set[tuple[float, ...]]:
    """Return the corners of a box, to the nanometre."""
    points = itertools.product(*zip(box.lower, box.upper, strict=True))
    return {tuple(round(c, 9) + 0.0 for c in transform.apply((x, y, z))) for x, y, z in points}


def far_apart(one: Box, placed_one: Transform, other: Box, placed_other: Transform) -> float:
    """Return how far the farthest corner of one box is from the nearest corner of the other."""
    first, second = corners(one, placed_one), corners(other, placed_other)
    return max(min(math.dist(a, b) for b in second) for a in first)


@given(any_pose | turned, any_pose | turned, any_pose | turned, any_pose | turned)
@settings(max_examples=150, deadline=None)
def test_shapes_of_frames_that_are_not_carried_move_to_the_link_they_are_fixed_to(
    below: Pose, above: Pose, further: Pose, own: Pose
) -> None:
    robot = mounted(below, above, further, own)
    text = emit(robot)
    assert [element.get("name") for element in parsed(text).iter("link")] == ["base_link", "arm"]
    found = list(link(text, "base_link").iterfind("collision"))
    assert len(found) == 2
    for collision, frame in zip(found, ("cover", "floor"), strict=True):
        origin, box = collision.find("origin"), collision.find("geometry/box")
        assert origin is not None
        assert box is not None
        x, y, z = (size / 2 for size in numbers(box.get("size")))
        (a, b, c), (r, p, w) = numbers(origin.get("xyz")), numbers(origin.get("rpy"))
        there = Pose((a, b, c), (r, p, w)).transform()
        meant = robot.transform("base_link", frame, {}).then(own.transform())
        assert far_apart(Box((-x, -y, -z), (x, y, z)), there, BOX, meant) < 1e-8


@given(turned, turned)
@settings(max_examples=100, deadline=None)
def test_a_quarter_turn_gives_a_box_along_the_axes(above: Pose, own: Pose) -> None:
    text = emit(mounted(Pose(), above, Pose(), own))
    origins = [origin.get("rpy") for origin in link(text, "base_link").iterfind("collision/origin")]
    assert origins == ["0 0 0", "0 0 0"]


def test_a_height_map_becomes_boxes_that_cover_it() -> None:
    heights = ((0.11, 0.12, 0.0), (0.2, 0.0, 0.3))
    robot = Robot("r", (Link("a", collision=(Shape(HeightMap((1.0, 2.0), 0.5, heights, 0.1)),)),), ())
    found = []
    for collision in link(emit(robot), "a").iterfind("collision"):
        centre, size = numbers(collision[0].get("xyz")), numbers(collision.find("geometry/box").get("size"))  # type: ignore[union-attr]
        found.append([round(c - s / 2, 9) for c, s in zip(centre, size, strict=True)] + [round(s, 9) for s in size])
    assert found == [[1.0, 2.0, 0.0, 0.5, 1.0, 0.2], [1.5, 2.0, 0.0, 0.5, 0.5, 0.2], [1.5, 3.0, 0.0, 0.5, 0.5, 0.3]]


def test_height_maps_of_an_output_are_cut_as_it_asks_and_begin_at_their_bottom() -> None:
    grid = HeightMap((0.0, 0.0), 1.0, ((0.3, 0.3), (0.3, 0.3)), 0.1, "", 0.15)
    robot = Robot("r", (Link("a", collision=(Shape(grid),)),), ())
    found = {}
    for form in ("", "rows", "merged", "grounded"):
        options = {"height_maps": form} if form else {}
        text = write(robot, Output("urdf", "urdf", "r.urdf", options), Templates())[0]
        boxes = [numbers(c.find("geometry/box").get("size")) for c in link(text, "a").iterfind("collision")]  # type: ignore[union-attr]
        found[form] = [[round(side, 9) for side in box] for box in boxes]
    assert found[""] == found["rows"] == [[1.0, 2.0, 0.15]] * 2
    assert found["merged"] == [[2.0, 2.0, 0.15]]
    assert found["grounded"] == [[1.0, 2.0, 0.3]] * 2


ROLLERS = 6


def rolling(hub: Vector, ring: float, radius: float, axis: Vector, *, published: bool = False) -> Robot:
    """Return a base with a wheel, a hub and spheres around it that turn on it, and are not in the URDF."""
    publisher = Publisher(ROBOT_STATE_PUBLISHER) if published else SIMULATED
    u, v = plane_axes(axis)
    turns = [2 * math.pi * step / ROLLERS for step in range(ROLLERS)]
    places = [
        tuple(ring * (math.cos(turn) * a + math.sin(turn) * b) for a, b in zip(u, v, strict=True)) for turn in turns
    ]
    x, y, z = (side / 2 for side in hub)
    links = [Link("base"), Link("hub", collision=(Shape(Box((-x, -y, -z), (x, y, z))),))]
    joints = [Joint("axle", "continuous", "base", "hub", Pose((0.1, 0.2, 0.3)), axis)]
    for number, place in enumerate(places):
        links.append(Link(f"roller{number}", collision=(Shape(Sphere(radius)),)))
        at = Pose((place[0], place[1], place[2]))
        joints.append(Joint(f"turn{number}", "continuous", "hub", f"roller{number}", at, u, publisher=publisher))
    return Robot("r", tuple(links), tuple(joints))


AXES = [(0.0, 1.0, 0.0), (1.0, 0.0, 0.0), (0.0, 0.0, -1.0), (0.0, 0.6, 0.8)]


@pytest.mark.parametrize("axis", AXES)
def test_a_wheel_whose_rollers_are_not_carried_is_the_cylinder_around_them(axis: Vector) -> None:
    robot = rolling((0.02, 0.02, 0.02), 0.04, 0.01, axis)
    (collision,) = link(emit(robot), "hub").iterfind("collision")
    cylinder, origin = collision.find("geometry/cylinder"), collision.find("origin")
    assert cylinder is not None
    assert origin is not None
    assert float(cylinder.get("radius", "")) == pytest.approx(0.05, abs=1e-12)
    assert float(cylinder.get("length", "")) >= 0.02 - 1e-12  # of the spheres; the corners of the box reach further
    r, p, w = numbers(origin.get("rpy"))
    along = Pose((0.0, 0.0, 0.0), (r, p, w)).transform().rotate((0.0, 0.0, 1.0))
    assert along == pytest.approx(axis, abs=1e-9)
    assert numbers(origin.get("xyz")) == pytest.approx((0, 0, 0), abs=1e-12)


def test_a_wheel_that_reaches_as_far_as_its_rollers_and_one_that_has_them_stay_as_they_are() -> None:
    large = rolling((0.12, 0.02, 0.12), 0.04, 0.01, (0.0, 1.0, 0.0))
    carried = rolling((0.02, 0.02, 0.02), 0.04, 0.01, (0.0, 1.0, 0.0), published=True)
    for robot in (large, carried):
        found = [collision.find("geometry") for collision in link(emit(robot), "hub").iterfind("collision")]
        assert [child.tag for geometry in found if geometry is not None for child in geometry] == ["box"]
