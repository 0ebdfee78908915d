"""Rotations on their way through quaternions and matrices to roll, pitch and yaw."""

from __future__ import annotations

import math
import random

import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from rosorin_compile.model import Pose, Transform
from rosorin_compile.model.geometry import rotation_about, rotation_of_rpy, unit

ANGLE = st.floats(-3.0, 3.0)


@settings(max_examples=500, deadline=None)
@given(ANGLE, st.floats(-16.0, 0.0), st.sampled_from((1, -1)), st.sampled_from((1, -1)), ANGLE)
@example(-1.57079632679, math.log10(math.pi / 2 - 1.57079632679), 1, 1, 0.0)
def test_near_a_pitch_of_90_degrees_the_rotation_stays(roll, exponent, side, up, yaw):
    """A quarter turn that was written with few digits, as 1.57079632679, is the usual case in drawings."""
    written = Pose(rpy=(roll, up * (math.pi / 2 - side * 10**exponent), yaw)).transform()
    read = Transform.of_quaternion((0, 0, 0), written.quaternion())
    again = rotation_of_rpy(read.rpy())
    error = max(
        abs(a - b) for row, other in zip(again, read.rows, strict=True) for a, b in zip(row, other, strict=True)
    )
    assert error < 5e-12


def test_the_angle_between_two_rotations():
    for seed in range(200):
        rng = random.Random(seed)  # noqa: S311
        axis, angle = [rng.gauss(0, 1) for _ in range(3)], rng.choice([1e-9, 1e-3, rng.uniform(0, math.pi)])
        first = Pose((1.0, 2.0, 3.0), tuple(rng.uniform(-3, 3) for _ in range(3))).transform()
        turned = first.then(Transform(rotation_about(tuple(axis), angle), (4.0, 5.0, 6.0)))
        assert first.angle_to(turned) == pytest.approx(angle, abs=2e-7)
        about, by = first.turn_to(turned)
        assert by == first.angle_to(turned)
        assert about == pytest.approx(unit(tuple(axis)), abs=1e-5) or angle < 1e-6


def test_what_is_not_turned_has_no_axis():
    assert Transform().turn_to(Transform(xyz=(1.0, 0.0, 0.0))) == ((0.0, 0.0, 0.0), 0.0)
