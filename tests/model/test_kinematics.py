"""Kinematics of many states agrees with the model one state at a time, and with pinocchio, on any robot."""

import math
import subprocess
import sys
from collections.abc import Mapping
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from rosorin_compile.model import Edge, Joint, Link, Pose, Publisher, Robot, Transform
from rosorin_compile.model.geometry import rotation_of_rpy
from rosorin_compile.model.joint import NODE, Mimic
from rosorin_compile.model.kinematics import Graph, Kinematics, NoWay
from rosorin_compile.source.system import pip_install
from support.robots import compiled

TOLERANCE = 1e-12
STATES = 5
QUARTERS = [0.0, math.pi / 2, -math.pi / 2, math.pi, 3.1416]
AXES = [(1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0), (0.0, 0.0, -1.0), (-1.0, 0.0, 0.0), (1e-9, 0.0, -1.0)]

metres = st.floats(-2, 2)
angles = st.sampled_from(QUARTERS) | st.floats(-3.2, 3.2)
poses = st.builds(Pose, st.tuples(metres, metres, metres), st.tuples(angles, angles, angles))
directions = st.tuples(*[st.floats(-1, 1)] * 3).filter(lambda axis: math.hypot(*axis) > 0.1)
axes = st.sampled_from(AXES) | directions
numbers = st.lists(st.floats(-4, 4), min_size=STATES, max_size=STATES)


@st.composite
def robots(draw: st.DrawFn, types: tuple[str, ...]) -> Robot:
    """A tree of 1 to 9 joints; some follow a joint before them."""
    joints: list[Joint] = []
    for index in range(draw(st.integers(1, 9))):
        kind = draw(st.sampled_from(types))
        leaders = [joint.name for joint in joints if joint.moves]
        mimic = None
        if leaders and kind in ("revolute", "continuous", "prismatic") and draw(st.booleans()):
            mimic = Mimic(draw(st.sampled_from(leaders)), draw(st.floats(-2, 2)), draw(st.floats(-1, 1)))
        parent = f"link{draw(st.integers(0, index))}"
        joint = Joint(f"joint{index}", kind, parent, f"link{index + 1}", draw(poses), draw(axes), mimic=mimic)
        joints.append(joint)
    return Robot("made", tuple(Link(f"link{i}") for i in range(len(joints) + 1)), tuple(joints))


@st.composite
def positions(draw: st.DrawFn, robot: Robot) -> dict[str, list[float]]:
    free = [joint.name for joint in robot.joints if joint.moves and joint.mimic is None]
    return {name: draw(numbers) for name in free if draw(st.integers(0, 4))}


def matrix(transform: Transform) -> np.ndarray:
    return np.array([[*row, x] for row, x in zip(transform.rows, transform.xyz, strict=True)])


def blocks(found: tuple[np.ndarray, np.ndarray]) -> np.ndarray:
    return np.concatenate([found[0], found[1][:, :, None]], axis=2)


def at(given: Mapping[str, list[float]], index: int) -> dict[str, float]:
    return {name: values[index] for name, values in given.items()}


@settings(max_examples=150, deadline=None)
@given(st.data())
def test_many_states_are_the_model_state_by_state(data: st.DataObject) -> None:
    robot = data.draw(robots(("revolute", "continuous", "prismatic", "fixed")))
    asked = data.draw(positions(robot))
    names = [link.name for link in robot.links]
    source, target = data.draw(st.sampled_from(names)), data.draw(st.sampled_from(names))
    count = STATES if asked else 1
    kinematics = robot.kinematics
    found = blocks(kinematics.transforms(source, target, asked))
    every = kinematics.all_frames(source, asked)
    assert found.shape == (count, 3, 4)
    assert set(every) == set(names)
    for index in range(count):
        state = at(asked, index)
        assert np.abs(found[index] - matrix(robot.transform(source, target, state))).max() < TOLERANCE
        for name, one in every.items():
            assert np.abs(blocks(one)[index] - matrix(robot.transform(source, name, state))).max() < TOLERANCE


def urdf_of(robot: Robot) -> str:
    """A URDF with every digit, made here: what pinocchio reads owes nothing to our backend."""
    lines = [f'<robot name="{robot.name}">', *(f'<link name="{link.name}"/>' for link in robot.links)]
    for joint in robot.joints:
        x, y, z = joint.axis
        length = math.hypot(x, y, z)
        axis = f"{x / length!r} {y / length!r} {z / length!r}"
        xyz, rpy = (" ".join(map(repr, vector)) for vector in (joint.origin.xyz, joint.origin.rpy))
        lines.append(
            f'<joint name="{joint.name}" type="{joint.type}"><parent link="{joint.parent}"/>'
            f'<child link="{joint.child}"/><origin xyz="{xyz}" rpy="{rpy}"/><axis xyz="{axis}"/>'
            f'<limit lower="-9" upper="9" effort="1" velocity="1"/></joint>'
        )
    return "\n".join([*lines, "</robot>"])


@settings(max_examples=100, deadline=None)
@given(st.data())
def test_pinocchio_puts_all_frames_of_any_robot_there(data: st.DataObject) -> None:
    pinocchio = pytest.importorskip("pinocchio")
    robot = data.draw(robots(("revolute", "continuous", "prismatic", "fixed", "floating")))
    asked: dict[str, list] = dict(data.draw(positions(robot)))
    for joint in robot.joints:
        if joint.type == "floating":
            asked[joint.name] = [[0.1, -0.2, 0.3, *quaternion] for quaternion in data.draw(unit_quaternions)]
    model = pinocchio.buildModelFromXML(urdf_of(robot))
    model_data = model.createData()
    every = {name: blocks(found) for name, found in Kinematics(robot).all_frames("link0", asked).items()}
    for index in range(STATES if asked else 1):
        q = pinocchio.neutral(model)
        for joint in robot.joints:
            if model.existJointName(joint.name):
                place = model.joints[model.getJointId(joint.name)]
                q[place.idx_q : place.idx_q + place.nq] = configuration(robot, joint, asked, index, place.nq)
        pinocchio.framesForwardKinematics(model, model_data, q)
        for link in robot.links:
            placed = model_data.oMf[model.getFrameId(link.name)].homogeneous[:3]
            assert np.abs(every[link.name][index] - placed).max() < TOLERANCE


unit_quaternions = st.lists(
    st.tuples(*[st.floats(-1, 1)] * 4)
    .filter(lambda q: math.hypot(*q) > 0.1)
    .map(lambda q: tuple(c / math.hypot(*q) for c in q)),
    min_size=STATES,
    max_size=STATES,
)


def configuration(robot: Robot, joint: Joint, asked: Mapping[str, list], index: int, width: int) -> list[float]:
    """What pinocchio takes as the position of a joint: seven numbers, cosine and sine, or one number."""
    if width == 7:
        return list(asked[joint.name][index])
    position = robot.position(joint, {name: q[index] for name, q in asked.items() if robot.joint[name].moves})
    return [math.cos(position), math.sin(position)] if width == 2 else [position]


@settings(max_examples=100, deadline=None)
@given(poses, axes, st.lists(st.tuples(metres, metres, angles), min_size=1, max_size=4), st.booleans())
def test_planar_joints_move_as_the_model_moves_them(
    origin: Pose, axis: tuple[float, float, float], moved: list[tuple[float, float, float]], up: bool
) -> None:
    joint = Joint("plane", "planar", "a", "b", origin, axis)
    robot = Robot("made", (Link("a"), Link("b")), (joint,))
    found = blocks(Kinematics(robot).transforms(*("ba" if up else "ab"), {"plane": moved}))
    for index, coordinates in enumerate(moved):
        expected = joint.transform(coordinates)
        assert np.abs(found[index] - matrix(expected.inverse() if up else expected)).max() < TOLERANCE


@pytest.mark.parametrize("kind", ["planar", "floating", "ball"])
def test_joints_of_several_coordinates_are_at_zero_unless_they_are_given(kind: str) -> None:
    joint = Joint("free", kind, "a", "b", Pose((1, 2, 3), (0.1, 0.2, 0.3)))
    arm = Joint("arm", "revolute", "b", "c")
    robot = Robot("made", (Link("a"), Link("b"), Link("c")), (joint, arm))
    kinematics = Kinematics(robot)
    found = blocks(kinematics.transforms("a", "c", {"arm": [0.5, 0.6]}))
    assert np.abs(found[1] - matrix(robot.transform("a", "c", {"arm": 0.6}))).max() < TOLERANCE
    one = {"planar": [0.0] * 3, "floating": [0.0] * 6 + [1.0], "ball": [0.0] * 3 + [1.0]}[kind]
    same = blocks(kinematics.transforms("c", "a", {"arm": [0.5, 0.6], "free": one}))
    assert np.abs(same[0] - matrix(robot.transform("c", "a", {"arm": 0.5}))).max() < TOLERANCE
    with pytest.raises(ValueError, match=r'the positions of joint "free" have the shape \(2,\)'):
        kinematics.transforms("a", "c", {"free": [0.0, 0.0]})


def test_lengths_that_differ_are_told() -> None:
    robot = compiled().robot
    assert robot is not None
    with pytest.raises(ValueError, match="different numbers of positions: 2 of joint1, 3 of joint2"):
        Kinematics(robot).transforms("base_link", "link5", {"joint1": [0, 1], "joint2": [0, 1, 2]})
    with pytest.raises(KeyError):
        Kinematics(robot).transforms("base_link", "nowhere", {})


NODE_A = Publisher(NODE, "driver")


def with_edges(*edges: Edge) -> Robot:
    robot = Robot("made", (Link("base"), Link("arm")), (Joint("j", "revolute", "base", "arm"),))
    return replace(robot, edges=edges)


def test_edges_of_other_nodes_lead_on_where_their_pose_is_known() -> None:
    chip = Edge("arm", "chip", NODE_A, moving=False, pose=Pose((0, 1, 0), (0, 0, 1)))
    robot = with_edges(chip, Edge("odom", "base", NODE_A, moving=True))
    kinematics = Kinematics(robot)
    found = blocks(kinematics.transforms("base", "chip", {"j": [0.2]}))
    expected = robot.transform("base", "arm", {"j": 0.2}).then(chip.pose.transform())
    assert np.abs(found[0] - matrix(expected)).max() < TOLERANCE
    assert set(kinematics.all_frames("chip", {})) == {"base", "arm", "chip"}
    with pytest.raises(NoWay) as refused:
        kinematics.transforms("odom", "chip", {"j": [0.2]})
    assert [(step.parent, step.child) for step in refused.value.missing] == [("odom", "base")]


def test_one_transform_of_two_nodes_is_known_if_both_say_the_same() -> None:
    here, there = Pose((1, 0, 0)), Pose((2, 0, 0))
    first = Edge("map", "base", NODE_A, moving=False, when="slam", pose=here)
    same = replace(first, when="not slam", publisher=Publisher(NODE, "amcl"))
    found = blocks(Kinematics(with_edges(first, same)).transforms("map", "base", {}))
    assert found[0][:, 3].tolist() == [1, 0, 0]
    with pytest.raises(NoWay):
        Graph(with_edges(first, replace(same, pose=there))).way("map", "base")


def test_numpy_is_imported_when_it_is_needed_and_named_when_it_is_missing() -> None:
    program = """
import sys
sys.modules["numpy"] = None
from rosorin_compile.model.kinematics import Kinematics
from rosorin_compile.model import Link, Robot
try:
    Kinematics(Robot("made", (Link("base"),), ()))
except ImportError as problem:
    print(problem)
"""
    ran = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
    assert ran.stdout == f"kinematics of many states needs numpy: {pip_install('verify')}\n"


# Rotations on their way through quaternions and matrices to roll, pitch and yaw.


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


# A motion without a direction is refused in one way, whatever the kind of joint.
