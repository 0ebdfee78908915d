"""Two solids are one if they fill the same space, as well as they are known, and no farther."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest

from rosorin_compile.compare.describe import likened
from rosorin_compile.compare.solids import Solid, same_set, solid_of
from rosorin_compile.model import Box, Cylinder, Mesh, Pose, Shape, Sphere
from rosorin_compile.model.geometry import pose_of

TILTED = Pose((0.1, 0.0, 0.0), (0.3, 0.2, 0.1))
BEAM = Shape(Box((-0.01, -0.02, -0.1), (0.01, 0.02, 0.1)), TILTED)
ON_ITS_SIDE = pose_of(TILTED.transform().then(Pose(rpy=(0.0, math.pi / 2, 0.0)).transform()))


def turned(shape: Shape, tolerance: float) -> Solid:
    return solid_of(shape)._replace(turn_tolerance=tolerance)


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
    assert same_set([solid_of(shape)], [solid_of(other)]) == same


def ball(radius: float, x: float) -> Solid:
    return solid_of(Shape(Sphere(radius), Pose((x, 0.0, 0.0))))


@pytest.mark.parametrize(
    ("old", "new", "pairs"),
    [
        ([ball(0.1, 0), ball(0.2, 1)], [ball(0.1, 0.1), ball(0.2, 1.1)], [(0, 0), (1, 1)]),
        ([ball(0.1, 0), ball(0.2, 1)], [ball(0.2, 1.1), ball(0.1, 0.1)], [(0, 1), (1, 0)]),
        ([ball(0.1, 0), ball(0.2, 1)], [ball(0.2, 1.1)], [(1, 0)]),
        ([ball(0.1, 0), solid_of(BEAM)], [solid_of(replace(BEAM, pose=Pose())), ball(0.3, 0.1)], [(0, 1), (1, 0)]),
    ],
)
def test_of_a_few_solids_those_are_held_against_each_other_that_are_alike(
    old: list[Solid], new: list[Solid], pairs: list[tuple[int, int]]
) -> None:
    assert likened(old, new) == pairs
