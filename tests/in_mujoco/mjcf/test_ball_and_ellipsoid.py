"""Ball joints and ellipsoids: MuJoCo has them, a URDF has what stands for them."""

import random
from pathlib import Path

import pytest

from rosorin_compile.joint_values import position
from rosorin_compile.model import Ellipsoid, Shape
from rosorin_compile.model.link import inertial_of
from rosorin_compile.source.diagnostics import RequestError
from support.paths import data_text
from support.robots import compiled_text

mujoco = pytest.importorskip("mujoco")

TEXT = data_text("robots/ball_and_ellipsoid.yaml")


def test_mujoco_has_the_same_robot(tmp_path: Path) -> None:
    made = compiled_text(tmp_path, TEXT)
    robot, texts = made.robot, {one.backend: one.text for one in made.artifacts}
    assert robot is not None
    model = mujoco.MjModel.from_xml_string(texts["mjcf"])
    data = mujoco.MjData(model)
    assert model.joint("ball").type == mujoco.mjtJoint.mjJNT_BALL
    assert list(model.dof_damping[:4]) == [0.1, 0.1, 0.1, 0.0]
    assert list(model.key("home").qpos) == [1, 0, 0, 0, 0.2]
    rng = random.Random(3)  # noqa: S311
    for _ in range(50):
        quaternion = [rng.gauss(0, 1) for _ in range(4)]
        data.qpos[:] = [quaternion[3], *quaternion[:3], 0.5]
        mujoco.mj_forward(model, data)
        meant = robot.poses_in_root({"ball": quaternion, "turn": 0.5})
        for link in ("egg", "tip"):
            assert data.site(link).xpos == pytest.approx(meant[link].xyz, abs=1e-11)  # numbers are printed to 1e-12
            assert list(data.site(link).xmat) == pytest.approx([c for row in meant[link].rows for c in row], abs=1e-11)


def test_a_urdf_has_what_stands_for_them(tmp_path: Path) -> None:
    made = compiled_text(tmp_path, TEXT)
    urdf = next(one.text for one in made.artifacts if one.backend == "urdf")
    assert '<joint name="ball" type="floating">' in urdf
    assert '<box size="0.2 0.4 0.6"/>' in urdf
    said = [one.message for one in made.diagnostics if one.rule == "urdf-cannot-say"]
    assert said == [
        'URDF has no ellipsoids: 1 of link "egg" is written as a box of the same extents',
        'URDF has no ball joint: "ball" becomes a floating joint',
    ]


def test_the_inertia_of_an_ellipsoid_is_that_of_mujoco() -> None:
    mine = inertial_of([Shape(Ellipsoid((0.1, 0.2, 0.3)))], mass=2.0)
    text = '<mujoco><worldbody><body><geom type="ellipsoid" size=".1 .2 .3" mass="2"/></body></worldbody></mujoco>'
    theirs = mujoco.MjModel.from_xml_string(text).body_inertia[1]
    assert sorted((mine.ixx, mine.iyy, mine.izz)) == pytest.approx(sorted(theirs), rel=1e-12)


def test_a_ball_is_placed_by_angles_or_a_quaternion(tmp_path: Path) -> None:
    robot = compiled_text(tmp_path, TEXT).robot
    assert robot is not None
    assert position(robot, "ball", "0,0,90deg") == pytest.approx((0, 0, 0.5**0.5, 0.5**0.5))
    assert position(robot, "ball", "0,0,0,2") == (0, 0, 0, 2)
    with pytest.raises(RequestError, match="write ball=roll,pitch,yaw or ball=qx,qy,qz,qw"):
        position(robot, "ball", "1,2")
    with pytest.raises(RequestError, match="is zero"):
        position(robot, "ball", "0,0,0,0")
