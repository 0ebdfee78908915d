"""The Python API of pulses: both directions, and the driver's model gives the very numbers."""

import json
import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rosorin_compile.model import Limit, Robot
from rosorin_compile.model.servos import (
    NoPulse,
    ServoGroup,
    nearest,
    position_of,
    pulses_within,
    servo_of,
    to_radians,
    travel,
)
from support.robots import RECORDED, compiled, texts


@pytest.fixture(scope="module")
def rosorin() -> Robot:
    robot = compiled().robot
    assert robot is not None
    return robot


# The groups of the property tests: any resolution a servo can have, either way round, any zero inside the range.
ranges = st.tuples(st.integers(-100, 5000), st.integers(1, 5000)).map(lambda ends: (ends[0], ends[0] + ends[1]))


@st.composite
def groups(draw: st.DrawFn) -> ServoGroup:
    low, high = draw(ranges)
    resolution = draw(st.floats(1e-6, 0.1)) * draw(st.sampled_from([1, -1]))
    return ServoGroup("g", ("j",), resolution, draw(st.integers(low, high)), draw(st.booleans()), (low, high))


@given(groups(), st.data())
def test_a_pulse_comes_back_as_itself(group: ServoGroup, data: st.DataObject) -> None:
    pulse = data.draw(st.integers(*group.pulse_range))
    assert nearest(group, position_of(group, pulse)) == (pulse, group.radians(pulse), 0.0)


@given(groups(), st.floats(0, 1))
def test_a_position_comes_back_within_half_a_pulse(group: ServoGroup, share: float) -> None:
    first, last = travel(group)
    asked = first + share * (last - first)
    pulse, position, difference = nearest(group, asked)
    assert group.pulse_range[0] <= pulse <= group.pulse_range[1]
    assert difference == position - asked
    assert abs(difference) <= abs(group.rad_per_pulse) / 2 * (1 + 1e-9)


@given(groups(), st.floats(-10, 10), st.floats(-10, 10))
def test_the_pulses_within_limits_are_those_whose_positions_are(group: ServoGroup, one: float, other: float) -> None:
    lower, upper = sorted((one, other))
    found = pulses_within(group, Limit(lower, upper))
    slack = 2e-6 * abs(group.rad_per_pulse)
    low, high = group.pulse_range
    inside = [p for p in range(low, high + 1) if lower - slack <= group.radians(p) <= upper + slack]
    strictly = [p for p in inside if lower + slack <= group.radians(p) <= upper - slack]
    if found is None:
        assert not strictly
    else:
        assert inside[0] <= found[0] <= found[1] <= inside[-1]
        assert not strictly or (found[0] <= strictly[0] and strictly[-1] <= found[1])


def test_in_the_middle_the_pulse_nearer_to_zero_is_taken() -> None:
    group = ServoGroup("g", ("j",), 0.5, 500, False, (0, 1000))
    assert nearest(group, 0.25)[0] == 500
    assert nearest(group, 0.75)[0] == 501
    assert nearest(group, -0.75)[0] == 499


def test_the_recorded_tuck(rosorin: Robot) -> None:
    recorded = RECORDED["tuck"]
    radians = to_radians(rosorin, recorded["pulses"])
    assert list(radians.values()) == recorded["positions_rad"]
    assert {joint: nearest(servo_of(rosorin, joint), position)[0] for joint, position in radians.items()} == recorded[
        "pulses"
    ]


def test_the_model_of_the_driver_gives_the_same_doubles(rosorin: Robot) -> None:
    """What the driver does with its file, written out once more: no code of ours between the file and the number."""
    model = json.loads(texts(compiled())["robot_model.json"])["pulse_to_rad"]
    assert model["joints"] == [f"joint{i}" for i in range(1, 6)]
    for joint in model["joints"]:
        group = servo_of(rosorin, joint)
        for pulse in range(1001):
            k, zero = model["rad_per_pulse"], model["zero"]
            theirs = (zero - pulse) * k if model["flipped"] else (pulse - zero) * k
            assert theirs == position_of(group, pulse, joint)


def test_pulses_that_do_not_exist(rosorin: Robot) -> None:
    for pulse in (1001, -1, 5.0):
        with pytest.raises(NoPulse):
            to_radians(rosorin, {"joint1": pulse})  # type: ignore[dict-item]


@pytest.mark.parametrize("position", [2.2, -2.2, math.inf, -math.inf, math.nan, 1e300])
def test_positions_that_no_pulse_gives(rosorin: Robot, position: float) -> None:
    with pytest.raises(NoPulse) as refused:
        nearest(servo_of(rosorin, "joint1"), position)
    assert "-2.0944 to 2.0944" in str(refused.value)
