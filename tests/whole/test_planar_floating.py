"""Planar and floating joints: every artifact means the same motion, at states that are not zero."""

import math
import random
from pathlib import Path

import numpy as np
import pinocchio
import pytest

from rosorin_compile.model import Joint, Transform
from rosorin_compile.model.geometry import plane_axes
from support.paths import DATA
from support.reading import leaves_of
from support.robots import compiled_text, sound

mujoco = pytest.importorskip("mujoco", minversion="3.12")

ROBOT = (DATA / "robots/planar_floating.yaml").read_text("utf-8")
AXES = [(0.0, 0.0, 1.0), (0.6, 0.0, 0.8), (0.0, 0.0, -1.0), (1.0, 0.0, 0.0), (-0.36, 0.48, -0.8)]


def robot_with(folder: Path, axis: tuple[float, ...]):
    return sound(compiled_text(folder, ROBOT.replace("AXIS", str(list(axis)))))


def states(seed: int):
    dice = random.Random(seed)  # noqa: S311
    for _ in range(20):
        quaternion = [dice.gauss(0, 1) for _ in range(4)]
        length = math.hypot(*quaternion)
        yield (
            [dice.uniform(-2, 2) for _ in range(3)] + [q / length for q in quaternion],
            [dice.uniform(-2, 2) for _ in range(3)],
            dice.uniform(-3, 3),
        )


def placed(robot, free, sliding, turn) -> dict[str, Transform]:
    at = {"free": free, "sliding": sliding, "ns/turn": turn, "follow": 2 * turn + 0.5}
    found = {}
    for link in robot.link:
        here = Transform()
        for joint in robot.chain(link):
            here = here.then(joint.transform(at[joint.name]))
        found[link] = here
    return found


def assert_same(transform: Transform, rows, xyz) -> None:
    assert np.allclose(np.array(transform.rows), np.asarray(rows).reshape(3, 3), atol=1e-9)
    assert np.allclose(transform.xyz, xyz, atol=1e-9)


@pytest.mark.parametrize("axis", AXES)
def test_mujoco_moves_the_bodies_as_the_model_says(tmp_path, axis):
    robot, artifacts, _ = robot_with(tmp_path, axis)
    model = mujoco.MjModel.from_xml_string(artifacts["mjcf"])
    data = mujoco.MjData(model)
    names = [model.joint(index).name for index in range(model.njnt)]
    assert names == [
        "free_TX",
        "free_TY",
        "free_TZ",
        "free_R",
        *(f"sliding_{e}" for e in ("TX", "TY", "RZ")),
        "ns/turn",
        "follow",
    ]
    for free, sliding, turn in states(1):
        x, y, z, qx, qy, qz, qw = free
        data.qpos = [x, y, z, qw, qx, qy, qz, *sliding, turn, 2 * turn + 0.5]
        mujoco.mj_kinematics(model, data)
        for link, transform in placed(robot, free, sliding, turn).items():
            assert_same(transform, data.body(link).xmat, data.body(link).xpos)


@pytest.mark.parametrize("axis", AXES)
def test_mujocos_own_reader_of_urdf_has_the_same_planar_joint(tmp_path, axis):
    """It makes a free joint of a floating one, which is at the origin of the world: left out of the comparison."""
    robot, artifacts, _ = robot_with(tmp_path, axis)
    urdf = artifacts["urdf"].replace('type="floating"', 'type="fixed"')
    model = mujoco.MjModel.from_xml_string(urdf)
    data = mujoco.MjData(model)
    joints = [model.joint(f"sliding_{end}").id for end in ("TX", "TY", "RZ")]
    moved = 0
    for _, sliding, turn in states(2):
        for joint, value in zip(
            [*joints, model.joint("ns/turn").id, model.joint("follow").id],
            [*sliding, turn, 2 * turn + 0.5],
            strict=True,
        ):
            data.qpos[model.jnt_qposadr[joint]] = value
        mujoco.mj_kinematics(model, data)
        for link, transform in placed(robot, 0.0, sliding, turn).items():
            body = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_BODY, link)
            if body > 0:
                moved += 1
                assert_same(transform, data.xmat[body], data.xpos[body])
    assert moved >= 60


def test_pinocchio_moves_the_links_as_the_model_says(tmp_path):
    """JointModelFreeFlyer takes x y z qx qy qz qw, JointModelPlanar x y cos sin, about z whatever the axis."""
    robot, artifacts, _ = robot_with(tmp_path, (0.0, 0.0, 1.0))
    model = pinocchio.buildModelFromXML(artifacts["urdf"])
    data = model.createData()
    assert [model.joints[model.getJointId(name)].shortname() for name in ("free", "sliding")] == [
        "JointModelFreeFlyer",
        "JointModelPlanar",
    ]
    for free, (x, y, angle), turn in states(3):
        q = pinocchio.neutral(model)
        for name, values in (
            ("free", free),
            ("sliding", [x, y, math.cos(angle), math.sin(angle)]),
            ("ns/turn", [math.cos(turn), math.sin(turn)]),
            ("follow", [math.cos(2 * turn + 0.5), math.sin(2 * turn + 0.5)]),
        ):
            joint = model.joints[model.getJointId(name)]
            q[joint.idx_q : joint.idx_q + joint.nq] = values
        pinocchio.framesForwardKinematics(model, data, q)
        for link, transform in placed(robot, free, (x, y, angle), turn).items():
            frame = data.oMf[model.getFrameId(link)]
            assert_same(transform, frame.rotation, frame.translation)


@pytest.mark.parametrize("axis", AXES)
def test_readers_know_them_again(tmp_path, axis):
    _, artifacts, _ = robot_with(tmp_path, axis)
    for format in ("urdf", "mjcf"):
        found = leaves_of(format, artifacts[format])
        assert found["joint", "free", "type"] == "floating"
        assert found["joint", "sliding", "type"] == "planar"
        assert found["joint", "sliding", "axis"] == pytest.approx(axis)
    poses = {
        quantity: value for (kind, _, quantity), value in leaves_of("mjcf", artifacts["mjcf"]).items() if kind == "pose"
    }
    assert poses["ns/turn"] == 0.5
    assert poses["free_R w"] == 1.0
    assert poses["sliding_TX"] == 0.0


def test_what_is_left_out_is_told(tmp_path):
    _, artifacts, made = robot_with(tmp_path, (0.0, 0.0, 1.0))
    told = [d.message for d in made.diagnostics if d.severity == "warning" and "mimic" not in d.message]
    assert told == [
        'joint "sliding" is planar, but robot_state_publisher publishes it as a fixed joint',
        'joint "sliding" is planar, without its limit and dynamics in the MJCF',
        'robot_model cannot express the floating joint "free", which is left out',
        'robot_model cannot express the planar joint "sliding", which is left out',
    ]
    assert '<limit lower="-1" upper="1" effort="5" velocity="1"/>' in artifacts["urdf"]
    assert '<dynamics damping="1" friction="0"/>' in artifacts["urdf"]


def test_names_of_others_are_not_taken(tmp_path):
    text = ROBOT.replace("AXIS", "[0, 0, 1]").replace("follow:", "sliding_RZ:")
    _, artifacts, _ = sound(compiled_text(tmp_path, text))
    model = mujoco.MjModel.from_xml_string(artifacts["mjcf"])
    assert [model.joint(index).name for index in range(4, 9)] == [
        "sliding__TX",
        "sliding__TY",
        "sliding__RZ",
        "ns/turn",
        "sliding_RZ",
    ]


@pytest.mark.parametrize(
    ("kind", "numbers"),
    [("planar", (1.0,)), ("floating", (1.0,) * 6), ("ball", (1.0,) * 3), ("planar", 1.0), ("revolute", (1.0,))],
)
def test_wrong_number_of_coordinates(kind, numbers):
    with pytest.raises(ValueError, match="position"):
        Joint("a", kind, "x", "y").transform(numbers)


@pytest.mark.parametrize("seed", range(20))
def test_plane_axes_are_a_right_handed_frame(seed):
    dice = random.Random(seed)  # noqa: S311
    normal = (dice.gauss(0, 1), dice.gauss(0, 1), dice.gauss(0, 1))
    x, y = plane_axes(normal)
    rows = np.array([x, y, np.array(normal) / np.linalg.norm(normal)])
    assert np.allclose(rows @ rows.T, np.eye(3), atol=1e-12)
    assert np.linalg.det(rows) == pytest.approx(1.0)
