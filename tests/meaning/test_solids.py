"""Two solids are one if they fill the same space, as well as they are known, and no farther."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest

from rosorin_compile.compare.shape_wording import likened
from rosorin_compile.compare.solids import same_bodies, same_set, solid_from, solid_of
from rosorin_compile.formats import Value
from rosorin_compile.formats.facts import Solid
from rosorin_compile.model import Box, Cylinder, HeightMap, Mesh, Pose, Shape, Sphere
from rosorin_compile.model.geometry import pose_of
from rosorin_compile.model.shape import MERGED, ROWS

TILTED = Pose((0.1, 0.0, 0.0), (0.3, 0.2, 0.1))
BEAM = Shape(Box((-0.01, -0.02, -0.1), (0.01, 0.02, 0.1)), TILTED)
ON_ITS_SIDE = pose_of(TILTED.transform().then(Pose(rpy=(0.0, math.pi / 2, 0.0)).transform()))


def turned(shape: Shape, tolerance: float) -> Solid:
    return solid_from(shape)._replace(turn_tolerance=tolerance)


@pytest.mark.parametrize(("step", "same"), [(0.0, True), (1e-4, True), (5e-4, False), (1e-3, False), (3e-3, False)])
def test_a_box_that_lies_on_its_side_is_the_same_as_far_as_its_angles_are_known(step: float, same: bool) -> None:
    """They are known to a thousandth, with which corners that are a decimetre away move by a tenth of a millimetre."""
    longer = Shape(Box((-0.1 - step, -0.02, -0.01), (0.1 + step, 0.02, 0.01)), ON_ITS_SIDE)
    assert same_set([turned(BEAM, 1e-3)], [turned(longer, 0.0)]) == same
    assert same_set([turned(longer, 1e-3)], [turned(BEAM, 0.0)]) == same


@pytest.mark.parametrize("shape", [BEAM, Shape(Mesh("a.stl", (1.0, 1.0, 1.0))), Shape(Cylinder(0.1, 0.2))])
@pytest.mark.parametrize(("moved", "same"), [(5e-10, True), (2e-9, False)])
def test_a_solid_that_is_not_turned_is_one_within_a_nanometre(shape: Shape, moved: float, same: bool) -> None:
    x, y, z = shape.pose.xyz
    other = replace(shape, pose=Pose((x + moved, y, z), shape.pose.rpy))
    assert same_set([solid_from(shape)], [solid_from(other)]) == same


def test_boxes_that_are_cut_otherwise_are_the_same_bodies() -> None:
    grid = HeightMap((-0.3, 0.1), 0.07, ((0.1, 0.2, 0.2), (0.2, 0.2, 0.2), (0.0, 0.2, 0.3)), 0.1)
    rows, merged = ([solid_from(Shape(box)) for box in grid.boxes(form)] for form in (ROWS, MERGED))
    assert not same_set(rows, merged)
    assert same_bodies(rows, merged)
    assert not same_bodies(rows, merged[1:])
    assert not same_bodies(rows, [])


def test_halves_that_an_artifact_turns_by_a_quarter_are_the_body_that_is_not_cut() -> None:
    sizes = {"size x": Value(0.4), "size y": Value(0.2), "size z": Value(0.1), "yaw": Value(math.pi / 2)}
    halves = [solid_of({"geometry": Value("box"), **sizes, "origin x": Value(x)}) for x in (-0.1, 0.1)]
    assert same_bodies(halves, [solid_from(Shape(Box((-0.2, -0.2, -0.05), (0.2, 0.2, 0.05))))])
    assert not same_bodies(halves, [solid_from(Shape(Box((-0.2, -0.2, -0.05), (0.2, 0.3, 0.05))))])


def ball(radius: float, x: float) -> Solid:
    return solid_from(Shape(Sphere(radius), Pose((x, 0.0, 0.0))))


@pytest.mark.parametrize(
    ("old", "new", "pairs"),
    [
        ([ball(0.1, 0), ball(0.2, 1)], [ball(0.1, 0.1), ball(0.2, 1.1)], [(0, 0), (1, 1)]),
        ([ball(0.1, 0), ball(0.2, 1)], [ball(0.2, 1.1), ball(0.1, 0.1)], [(0, 1), (1, 0)]),
        ([ball(0.1, 0), ball(0.2, 1)], [ball(0.2, 1.1)], [(1, 0)]),
        ([ball(0.1, 0), solid_from(BEAM)], [solid_from(replace(BEAM, pose=Pose())), ball(0.3, 0.1)], [(0, 1), (1, 0)]),
    ],
)
def test_of_a_few_solids_those_are_held_against_each_other_that_are_alike(
    old: list[Solid], new: list[Solid], pairs: list[tuple[int, int]]
) -> None:
    assert likened(old, new) == pairs
