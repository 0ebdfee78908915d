"""Rotations on their way through quaternions and matrices to roll, pitch and yaw."""

from __future__ import annotations

import math

from hypothesis import example, given, settings
from hypothesis import strategies as st

from rosorin_compile.model import Pose
from rosorin_compile.model.geometry import rotation_of_rpy, transform_of_quaternion

ANGLE = st.floats(-3.0, 3.0)


@settings(max_examples=500, deadline=None)
@given(ANGLE, st.floats(-16.0, 0.0), st.sampled_from((1, -1)), st.sampled_from((1, -1)), ANGLE)
@example(-1.57079632679, math.log10(math.pi / 2 - 1.57079632679), 1, 1, 0.0)
def test_near_a_pitch_of_90_degrees_the_rotation_stays(roll, exponent, side, up, yaw):
    """A quarter turn that was written with few digits, as 1.57079632679, is the usual case in drawings."""
    written = Pose(rpy=(roll, up * (math.pi / 2 - side * 10**exponent), yaw)).transform()
    read = transform_of_quaternion((0, 0, 0), written.quaternion())
    again = rotation_of_rpy(read.rpy())
    error = max(
        abs(a - b) for row, other in zip(again, read.rows, strict=True) for a, b in zip(row, other, strict=True)
    )
    assert error < 5e-12
