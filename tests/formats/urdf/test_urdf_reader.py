"""What a URDF says as facts, and how far its numbers can be trusted."""

from __future__ import annotations

import itertools
import math

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rosorin_compile.compare.view import called
from rosorin_compile.formats import FORMATS, Fact, Value
from rosorin_compile.formats.urdf import facts as urdf_facts
from rosorin_compile.source.numbers import exact, six
from support.machines import TESTER
from support.robots import compiled
from support.urdf_robots import emit


def test_reading_gives_back_what_the_robot_is() -> None:
    facts = {fact: value._replace(tolerance=0.0) for fact, value in urdf_facts.read(emit(TESTER)).items()}
    shoulder = {fact.quantity: value for fact, value in facts.items() if fact[:2] == ("joint", "shoulder")}
    assert shoulder == {
        "type": Value("revolute"),
        "child": Value("arm"),
        "axis x": Value(0.6),
        "axis y": Value(0.0),
        "axis z": Value(-0.8),
        "lower": Value(-2.0, "rad"),
        "upper": Value(2.5, "rad"),
        "effort": Value(3.0, "N*m"),
        "velocity": Value(4.0, "rad/s"),
        "damping": Value(0.1, "N*m*s/rad"),
        "friction": Value(0.2, "N*m"),
    }
    assert facts[Fact("joint", "slider", "velocity")] == Value(1.0, "m/s")
    assert facts[Fact("joint", "finger", "mimic joint")] == Value("shoulder")
    assert facts[Fact("joint", "finger", "mimic multiplier")] == Value(-0.5)
    assert facts[Fact("joint", "finger", "mimic offset")] == Value(0.1, "rad")
    assert facts[Fact("frame", "arm", "parent")] == Value("base_link")
    assert facts[Fact("frame", "arm", "origin x")] == Value(0.3, "m")
    assert facts[Fact("link", "arm", "mass")] == Value(1.5, "kg")
    assert facts[Fact("link", "arm", "collision shapes")] == Value(3.0)
    assert facts[Fact("link", "arm", "collision 2 size y")].value == 0.4
    assert facts[Fact("link", "arm", "visual 2 file")] == Value("package://robot/a&b.stl")
    assert facts[Fact("link", "arm", "visual 1 blue")] == Value(0.25)


def test_defaults_are_those_of_urdf() -> None:
    text = """<robot name="r"><link name="a"/><link name="b"/>
    <joint name="j" type="continuous"><parent link="a"/><child link="b"/><mimic joint="k"/></joint></robot>"""
    facts = urdf_facts.read(text)
    assert facts[Fact("frame", "b", "origin x")] == Value(0.0, "m")
    assert [facts[Fact("joint", "j", f"axis {a}")].value for a in "xyz"] == [1.0, 0.0, 0.0]
    assert facts[Fact("joint", "j", "mimic multiplier")] == Value(1.0, "", 0.5e-6)
    assert facts[Fact("joint", "j", "mimic offset")] == Value(0.0, "rad")


def test_a_mesh_without_a_scale_is_as_large_as_its_file() -> None:
    shape = '<collision><geometry><mesh filename="a.stl"/></geometry></collision>'
    facts = urdf_facts.read(f'<robot name="r"><link name="a">{shape}</link></robot>')
    assert [facts[Fact("link", "a", f"collision 1 scale {axis}")].value for axis in "xyz"] == [1.0, 1.0, 1.0]


def origin(token: str) -> Value:
    joint = f'<joint name="j" type="fixed"><origin xyz="{token} 0 0"/><parent link="a"/><child link="b"/></joint>'
    return urdf_facts.read(f'<robot name="r"><link name="a"/><link name="b"/>{joint}</robot>')[
        Fact("frame", "b", "origin x")
    ]


@pytest.mark.parametrize(
    ("token", "tolerance"),
    [
        ("0.1", 0.5e-6),  # may have been 0.1 and a little
        ("-1.570796", 0.5e-6),
        ("7.5437e-05", 0.5e-10),
        ("0.04662", 0.5e-7),
        ("123.457", 0.5e-6),
        ("0", 0.0),
        ("3.141592653589793", 0.0),  # six would not have printed it
        ("0.12345678", 0.0),
    ],
)
def test_the_tolerance_follows_from_what_was_printed(token: str, tolerance: float) -> None:
    assert origin(token).tolerance == pytest.approx(tolerance, rel=1e-9)


@given(st.floats(-1e6, 1e6))
@settings(max_examples=300, deadline=None)
def test_a_rounded_number_is_within_its_tolerance(number: float) -> None:
    rounded = origin(six(number))
    assert abs(float(rounded.value) - number) <= rounded.tolerance * (1 + 1e-9) + abs(number) * 1e-15
    whole = origin(exact(number))
    assert whole.value == number


GOOD = emit(TESTER)
DAMAGED = {
    "cut off": GOOD[:-20],
    "empty": "",
    "another root": "<mujoco/>",
    "an entity": '<!DOCTYPE r [<!ENTITY a "b">]>' + GOOD,
    "no name": GOOD.replace('<link name="slide"/>', "<link/>"),
    "no parent": GOOD.replace('<parent link="base_link"/>', ""),
    "no child": GOOD.replace('<child link="arm"/>', ""),
    "not a number": GOOD.replace('radius="0.3"', 'radius="wide"'),
    "not finite": GOOD.replace('radius="0.3"', 'radius="inf"'),
    "two numbers": GOOD.replace('xyz="0.6 0 -0.8"', 'xyz="0.6 0"'),
    "no mass": GOOD.replace('<mass value="1.5"/>', ""),
    "no inertia": GOOD.replace('ixx="0.02"', ""),
    "no geometry": GOOD.replace('<geometry><sphere radius="0.3"/></geometry>', ""),
    "an empty geometry": GOOD.replace('<sphere radius="0.3"/>', ""),
    "two geometries": GOOD.replace("<geometry><sphere", "<geometry><cone/><sphere"),
}


@pytest.mark.parametrize("text", DAMAGED.values(), ids=DAMAGED)
def test_a_damaged_urdf_is_a_value_error(text: str) -> None:
    assert text != GOOD
    with pytest.raises(ValueError):  # noqa: PT011 - the kind is the promise
        urdf_facts.read(text)


def test_all_artifacts_of_the_reference_robot_say_the_same() -> None:
    made = compiled()
    assert made.robot is not None
    readers = [(artifact, FORMATS[artifact.backend].facts) for artifact in made.artifacts]
    said = {artifact.file: read(artifact.text) for artifact, read in readers if read is not None}
    # The driver knows a link by another name.
    names = {old: new for one in made.artifacts for old, new in called(made.robot, one).items()}
    mjcf = said["rosorin.xml"] = dict(said["rosorin.xml"])
    for fact in [fact for fact in mjcf if fact.quantity == "damping"]:  # there it has that of the drive in it
        joint = made.robot.joint[fact.name]
        assert mjcf[fact].value == joint.braking
        mjcf[fact] = mjcf[fact]._replace(value=joint.dynamics.damping if joint.dynamics else 0.0)
    compared = 0
    for first, second in itertools.combinations(said.values(), 2):
        for fact in first.keys() & second.keys():
            a, b = first[fact], second[fact]
            # Which link carries a shape, and what is seen, is each artifact's own affair.
            if fact.kind == "link" and fact.quantity.startswith(("collision", "visual")):
                continue
            compared += 1
            if isinstance(a.value, float) and isinstance(b.value, float):
                # Near a pitch of 90 degrees, roll and yaw of one rotation are the farther apart.
                pitch = first.get(fact._replace(quantity="pitch")) if fact.quantity in ("roll", "yaw") else None
                upright = abs(math.cos(float(pitch.value))) if pitch else 1.0
                assert abs(a.value - b.value) * upright <= a.tolerance + b.tolerance + 1e-15, fact
            else:
                assert names.get(str(a.value), a.value) == names.get(str(b.value), b.value), fact
            assert a.unit == b.unit, fact
    assert compared > 300
