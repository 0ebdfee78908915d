"""What the MJCF says is read back as facts."""

from __future__ import annotations

import numpy as np
import pytest

mujoco = pytest.importorskip("mujoco", minversion="4")

from rosorin_compile.compare.solids import same_set  # noqa: E402
from rosorin_compile.compare.tolerance import same_turn  # noqa: E402
from rosorin_compile.compare.view import view_of  # noqa: E402
from rosorin_compile.formats.facts import angles  # noqa: E402
from rosorin_compile.formats.urdf import facts as urdf_facts  # noqa: E402
from rosorin_compile.model import Pose  # noqa: E402
from rosorin_compile.model.geometry import Transform  # noqa: E402
from rosorin_compile.mujoco.mjcf import facts as mjcf_facts  # noqa: E402
from support.machines import exact_urdf, machine  # noqa: E402
from support.simulator import BASES, emit, frame, load, matrix, pose, random_states  # noqa: E402


def test_facts_are_what_was_emitted():
    robot = machine()
    for base in BASES:
        facts = mjcf_facts.read(emit(robot, base))
        number = {tuple(fact): value.value for fact, value in facts.items()}
        numbers = [(value.value, value.tolerance) for value in facts.values() if not isinstance(value.value, str)]
        assert all(tolerance <= 1e-10 * max(1.0, abs(value)) for value, tolerance in numbers)
        assert number["joint", "lift", "type"] == "prismatic"
        assert number["joint", "roll", "type"] == "continuous"
        assert facts["joint", "lift", "upper"] == (0.3, "m", pytest.approx(0.3e-12))
        assert facts["joint", "shoulder", "effort"] == (3.0, "N*m", pytest.approx(3e-12))
        assert [number["joint", "shoulder", f"axis {axis}"] for axis in "xyz"] == [-0.01, 0.02, -0.999]
        assert [number["joint", "claw", f"mimic {what}"] for what in ("joint", "multiplier", "offset")] == [
            "shoulder",
            -2,
            0.25,
        ]
        assert facts["link", "torso", "mass"] == (0.7, "kg", pytest.approx(0.7e-12))
        assert number["link", "torso", "inertia xz"] == -2e-4
        assert [number["link", "torso", f"collision 1 size {axis}"] for axis in "xyz"] == pytest.approx([0.2, 0.2, 0.2])
        assert number["link", "upper", "collision 1 length"] == 0.21234567891
        assert number["link", "mat", "collision shapes"] == 3
        assert facts["pose", "up", "lift"] == (0.1, "m", pytest.approx(0.1e-12))
        assert number["pose", "up", "claw"] == -0.75
        assert number["frame", "laser", "parent"] == "wheel"
        assert number["frame", "laser", "yaw"] == pytest.approx(np.pi, abs=1e-12)
        assert number.get(("link", "base", "base")) == ("free" if base == "free" else None)
        for joint in robot.joints:
            for name, value in zip(("roll", "pitch", "yaw"), joint.origin.rpy, strict=True):
                assert number["frame", joint.child, name] == pytest.approx(value, abs=1e-12)
            for axis, value in zip("xyz", joint.origin.xyz, strict=True):
                assert number["frame", joint.child, f"origin {axis}"] == value


def test_damping_that_is_a_polynomial_is_read_as_what_is_linear():
    text = """<mujoco><worldbody><body name="base"><body name="arm">
        <joint name="hinge" damping="%s"/></body></body></worldbody></mujoco>"""
    assert mjcf_facts.read(text % "0.5 0.1")["joint", "hinge", "damping"].value == 0.5
    for broken in ("", "0.5 much"):
        with pytest.raises(ValueError, match=r"could not convert|not a number"):
            mjcf_facts.read(text % broken)


@pytest.mark.parametrize(
    ("transform", "same"),
    [
        (Pose(rpy=(0, 0, -np.pi)).transform(), (0, 0, np.pi)),
        (Pose(rpy=(0.3, 2.0, 0.1)).transform(), (0.3 - np.pi, np.pi - 2, 0.1 - np.pi)),
        (Transform.of_quaternion((0, 0, 0), (-1e-17, 0, 0, 1)), (0, 0, np.pi)),
        (Transform.of_quaternion((0, 0, 0), (1e-17, 0, 0, 2)), (0, 0, np.pi)),
    ],
)
def test_one_rotation_has_one_form(transform, same):
    assert angles(transform) == pytest.approx(same, abs=1e-12)


def test_facts_of_the_urdf_and_of_the_mjcf_agree():
    robot = machine()
    ours, theirs = mjcf_facts.read(emit(robot)), urdf_facts.read(exact_urdf(robot))
    compared = 0
    for fact, value in ours.items():
        turned = fact.name == "upper" and fact.quantity.startswith("inertia")  # along other axes in the URDF
        reshaped = fact.name == "upper" and fact.quantity.startswith("collision 1")  # a capsule is a cylinder there
        if fact not in theirs or turned or reshaped:
            continue
        compared += 1
        other = theirs[fact]
        if isinstance(value.value, str):
            assert value.value == other.value, fact
        else:
            assert value.value == pytest.approx(other.value, abs=max(value.tolerance + other.tolerance, 1e-12)), fact
            assert value.unit == other.unit, fact
    assert compared > 150


def test_tolerances_cover_what_six_digits_lose():
    robot = machine()
    exact, six = mjcf_facts.read(emit(robot)), mjcf_facts.read(emit(robot, number_format="six"))
    assert exact.keys() == six.keys()
    wide = 0
    for fact, value in six.items():
        if isinstance(value.value, str):
            continue
        wide += value.tolerance > 0
        if value.unit != "rad":  # a tolerance of a rotation is that of the whole, not that of its angles
            assert abs(value.value - exact[fact].value) <= value.tolerance + exact[fact].tolerance, fact
    assert wide > 100
    printed, meant = view_of(six, {}), view_of(exact, {})
    assert printed.turns.keys() == meant.turns.keys()
    assert len(meant.turns) > 5
    assert all(same_turn(turn, meant.turns[name]) for name, turn in printed.turns.items())
    assert all(same_set(solids, meant.shapes[key]) for key, solids in printed.shapes.items())
    model, data = load(emit(robot, number_format="six"))
    for state in random_states(robot, 20):
        pose(robot, model, data, state)
        for link in robot.links:
            expected = matrix(robot.pose_in_root(link.name, state))
            np.testing.assert_allclose(frame(data, "site", link.name), expected, atol=1e-5)


@pytest.mark.parametrize(
    "text",
    [
        "",
        "<mujoco>",
        "<robot/>",
        "<mujoco/>",
        '<!DOCTYPE mujoco [<!ENTITY a "b">]><mujoco><worldbody/></mujoco>',
        "<mujoco><worldbody><body/></worldbody></mujoco>",
        '<mujoco><worldbody><body name="a" pos="0 0"/></worldbody></mujoco>',
        '<mujoco><worldbody><body name="a" pos="0 0 x"/></worldbody></mujoco>',
        '<mujoco><worldbody><body name="a"><inertial mass="nan"/></body></worldbody></mujoco>',
        '<mujoco><worldbody><body name="a"><inertial mass="1_0"/></body></worldbody></mujoco>',
        '<mujoco><worldbody><body name="a"><body name="b" quat="0 0 0 0"/></body></worldbody></mujoco>',
        '<mujoco><worldbody/><keyframe><key name="k" qpos="1"/></keyframe></mujoco>',
        '<mujoco><worldbody/><equality><joint joint1="a" joint2="b"/></equality></mujoco>',
        '<mujoco><worldbody/><actuator><position joint="a" kp="1"/></actuator></mujoco>',
        '<mujoco><worldbody><body name="a"><geom class="x_visual" type="mesh" mesh="m"/></body></worldbody></mujoco>',
    ],
)
def test_damaged_text_is_a_value_error(text):
    with pytest.raises(ValueError, match=r"."):
        mjcf_facts.read(text)


def test_cutting_an_artifact_anywhere_is_a_value_error():
    text = emit(machine())
    for end in range(0, len(text.rstrip()) - 1, 37):
        with pytest.raises(ValueError, match=r"."):
            mjcf_facts.read(text[:end])


OF_A_SIMULATION = """<mujoco><worldbody>
<body name="base"><freejoint name="free"/><site name="base"/><site name="mark" size="0.1"/>
  <geom name="foot" size="0.1"/>
  <body name="arm"><joint name="turn" type="hinge" axis="0 0 1"/><geom name="tip" size="0.1"/></body></body></worldbody>
<equality><connect name="shut" site1="base" site2="mark" solref="0.01 1"/>
  <joint joint1="turn" polycoef="0.5 0 0 0 0"/></equality>
<tendon><fixed name="rope"><joint joint="turn" coef="2"/></fixed></tendon>
<contact><pair geom1="foot" geom2="tip" margin="0.2"/></contact>
<actuator><motor name="push" joint="turn" gear="2"/></actuator>
<keyframe><key name="home" qpos="1 2 3 1 0 0 0 0.5"/><key name="zero"/></keyframe></mujoco>"""


def test_what_a_simulation_has_is_read() -> None:
    facts = mjcf_facts.read(OF_A_SIMULATION)
    plain = {tuple(fact): value.value for fact, value in facts.items() if fact.kind != "frame"}
    assert plain == {
        ("link", "base", "base"): "free",
        ("link", "base", "site"): "base",
        ("link", "base", "site mark size"): 0.1,
        ("link", "base", "collision shapes"): 0.0,
        ("link", "base", "visual shapes"): 0.0,
        ("link", "base", "rubs with arm"): "may touch",
        ("joint", "turn", "type"): "continuous",
        ("joint", "turn", "child"): "arm",
        ("joint", "turn", "axis x"): 0.0,
        ("joint", "turn", "axis y"): 0.0,
        ("joint", "turn", "axis z"): 1.0,
        ("link", "arm", "collision shapes"): 0.0,
        ("link", "arm", "visual shapes"): 0.0,
        ("constraint", "shut", "connect site1"): "base",
        ("constraint", "shut", "connect site2"): "mark",
        ("constraint", "shut", "connect solref 1"): 0.01,
        ("constraint", "shut", "connect solref 2"): 1.0,
        ("joint", "turn", "mimic offset"): 0.5,
        ("tendon", "rope", "fixed"): "fixed",
        ("tendon", "rope", "1 joint joint"): "turn",
        ("tendon", "rope", "1 joint coef"): 2.0,
        ("actuator", "push", "motor joint"): "turn",
        ("actuator", "push", "motor gear"): 2.0,
        ("contact pair", "foot tip", "pair geom1"): "foot",
        ("contact pair", "foot tip", "pair geom2"): "tip",
        ("contact pair", "foot tip", "pair margin"): 0.2,
        ("pose", "home", "turn"): 0.5,
        ("pose", "zero", "turn"): 0.0,
    }
