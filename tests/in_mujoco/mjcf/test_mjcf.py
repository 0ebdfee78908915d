"""The MJCF of small robots, judged by MuJoCo, and by pinocchio on the URDF of the same robot."""

import numpy as np
import pytest

mujoco = pytest.importorskip("mujoco", minversion="3.12")
pinocchio = pytest.importorskip("pinocchio")

from rosorin_compile.model import Box, Capsule, Cylinder, HeightMap, Link, Pose, Robot, Shape, Sphere, Transform  # noqa: E402
from rosorin_compile.mujoco.mjcf.bodies import resting_pose  # noqa: E402
from support.machines import exact_urdf, machine  # noqa: E402
from support.simulator import BASES, at_origin, emit, frame, load, matrix, no_warning, pose, random_states  # noqa: E402

STATES = 200


def pinocchio_at(model: pinocchio.Model, robot: Robot, state: dict[str, float]) -> np.ndarray:
    q = pinocchio.neutral(model)
    for index, name in enumerate(model.names):
        if name in robot.joint:
            at, start = robot.position(robot.joint[name], state), model.joints[index].idx_q
            if model.joints[index].nq == 2:
                q[start : start + 2] = np.cos(at), np.sin(at)
            else:
                q[start] = at
    return q


@pytest.mark.slow
@pytest.mark.parametrize("base", BASES)
def test_every_frame_is_a_body_and_a_site_where_the_model_and_pinocchio_have_it(base):
    robot = at_origin(machine())
    model, data = load(emit(robot, base))
    judge = pinocchio.buildModelFromXML(exact_urdf(robot))
    judge_data = judge.createData()
    assert model.nbody == model.nsite + 1 == len(robot.links) + 2
    for state in random_states(robot, STATES):
        pose(robot, model, data, state)
        pinocchio.framesForwardKinematics(judge, judge_data, pinocchio_at(judge, robot, state))
        for link in robot.links:
            ours = matrix(robot.pose_in_root(link.name, state))
            placed = judge_data.oMf[judge.getFrameId(link.name)]
            for kind in ("body", "site"):
                np.testing.assert_allclose(frame(data, kind, link.name), ours, atol=1e-12)
                judged = np.column_stack((placed.rotation, placed.translation))
                np.testing.assert_allclose(frame(data, kind, link.name), judged, atol=1e-12)


def test_static_frames_of_other_nodes_are_there_once_if_their_numbers_are_known():
    robot = machine()
    model, data = load(emit(robot))
    names = {model.body(i).name for i in range(model.nbody)}
    assert "laser_optical" in names
    assert not names & {"rgb", "odom", "drone"}
    expected = robot.pose_in_root("laser", {}).then(robot.edges[0].pose.transform())
    np.testing.assert_allclose(frame(data, "site", "laser_optical"), matrix(expected), atol=1e-12)


def test_mass_matrix_and_bias_forces_are_those_of_pinocchio_on_the_urdf():
    robot = machine()
    model, data = load(emit(robot))
    model.dof_armature[:] = 0  # URDF has no armature
    judge = pinocchio.buildModelFromXML(exact_urdf(robot))
    judge_data = judge.createData()
    order = [judge.joints[judge.getJointId(model.joint(i).name)].idx_v for i in range(model.njnt)]
    generator = np.random.default_rng(1)
    rounding = 1e-7 if mujoco.__version__.startswith("3.12") else 1e-9  # MuJoCo 3.12 finds principal axes to 5e-9 rad
    for state in random_states(robot, 20):
        data.qvel[:] = generator.uniform(-1, 1, model.nv)
        pose(robot, model, data, state)
        full = np.empty((model.nv, model.nv))
        mujoco.mj_fullM(model, data, full)
        q, v = pinocchio_at(judge, robot, state), np.empty(model.nv)
        v[order] = data.qvel
        upper = np.triu(pinocchio.crba(judge, judge_data, q))
        judged = upper + np.triu(upper, 1).T
        np.testing.assert_allclose(full, judged[np.ix_(order, order)], rtol=rounding, atol=1e-12)
        bias = pinocchio.nonLinearEffects(judge, judge_data, q, v)
        np.testing.assert_allclose(data.qfrc_bias, bias[order], rtol=1e-9, atol=1e-9)


@pytest.mark.parametrize(
    ("geometry", "reach"),
    [
        (Box((-0.1, -0.2, -0.3), (0.1, 0.2, 0.5)), (0.1, 0.2, 0.5)),
        (Cylinder(0.1, 0.5), (0.1, 0.1, 0.25)),
        (Capsule(0.1, 0.5), (0.1, 0.1, 0.35)),
        (Sphere(0.3), (0.3, 0.3, 0.3)),
        (HeightMap((-0.1, -0.1), 0.1, ((0.2, 0.2), (0.2, 0.2)), 0.05), (0.1, 0.1, 0.2)),
    ],
)
def test_a_shape_reaches_as_far_as_it_is_long(geometry, reach):
    """Rays from outside, along the axes of the shape, wherever and however turned it sits."""
    at = Pose((0.3, -0.2, 0.1), (0.4, -0.9, 2.0))
    for purpose in ("collision", "visual"):
        link = Link("thing", **{purpose: (Shape(geometry, at),)})
        model, data = load(emit(Robot("rays", (link,), ())))
        for axis, extent in enumerate(reach):
            inside = np.array([1e-3, 1e-3, 1e-3]) + np.eye(3)[axis]
            start = np.array(at.transform().apply(tuple(inside)))
            ray = np.array(at.transform().rotate(tuple(-np.eye(3)[axis])))
            distance = mujoco.mj_ray(model, data, start, ray, None, True, -1, np.zeros(1, np.int32))
            assert distance == pytest.approx(1 + 1e-3 - extent, abs=2e-5), (purpose, axis)


def test_joints_say_what_the_description_says():
    robot = machine()
    model, _ = load(emit(robot))
    kinds = {"revolute": mujoco.mjtJoint.mjJNT_HINGE, "continuous": mujoco.mjtJoint.mjJNT_HINGE}
    for joint in (j for j in robot.joints if j.moves):
        found, dynamics = model.joint(joint.name), joint.dynamics
        assert found.type[0] == kinds.get(joint.type, mujoco.mjtJoint.mjJNT_SLIDE)
        np.testing.assert_allclose(found.axis, np.array(joint.axis) / np.linalg.norm(joint.axis), atol=1e-15)
        assert bool(model.jnt_limited[found.id]) == (joint.type != "continuous")
        if joint.type != "continuous":
            assert tuple(found.range) == (joint.limit.lower, joint.limit.upper)
        assert tuple(model.jnt_actfrcrange[found.id]) == (-joint.limit.effort, joint.limit.effort)
        assert model.jnt_actfrclimited[found.id]
        dof = found.dofadr[0]
        values = (model.dof_damping[dof], model.dof_frictionloss[dof], model.dof_armature[dof])
        assert values == (dynamics.damping, dynamics.friction, dynamics.armature)


def test_actuators_are_servos_clamped_once():
    robot = machine()
    model, _ = load(emit(robot))
    actuated = {joint.name: joint for joint in robot.joints if joint.actuator}
    assert [model.actuator(i).name for i in range(model.nu)] == list(actuated)
    for name, joint in actuated.items():
        servo = model.actuator(name)
        assert servo.gainprm[0] == joint.actuator.kp
        assert tuple(servo.biasprm[1:3]) == (-joint.actuator.kp, -joint.actuator.kv)
        assert not model.actuator_forcelimited[servo.id]
        limited = joint.type != "continuous"
        assert bool(model.actuator_ctrllimited[servo.id]) == limited
        if limited:
            assert tuple(servo.ctrlrange) == (joint.limit.lower, joint.limit.upper)


@pytest.mark.parametrize("base", BASES)
def test_keyframes_hold_every_pose_with_its_followers(base):
    robot = machine()
    model, data = load(emit(robot, base))
    assert [model.key(i).name for i in range(model.nkey)] == ["home", "up"]
    for named in robot.poses:
        mujoco.mj_resetDataKeyframe(model, data, model.key(named.name).id)
        mujoco.mj_forward(model, data)
        for joint in (j for j in robot.joints if j.moves):
            assert data.joint(joint.name).qpos[0] == robot.position(joint, named.positions)
            if joint.actuator:
                assert data.actuator(joint.name).ctrl[0] == robot.position(joint, named.positions)
        root = resting_pose(robot, named).transform() if base == "free" else Transform()
        for link in robot.links:
            ours = matrix(root.then(robot.pose_in_root(link.name, named.positions)))
            np.testing.assert_allclose(frame(data, "body", link.name), ours, atol=1e-12)
        equality = data.efc_pos[data.efc_type == mujoco.mjtConstraint.mjCNSTR_EQUALITY]
        np.testing.assert_allclose(equality, 0, atol=1e-15)


def test_the_robot_can_be_included_and_attached_twice_into_a_scene(tmp_path):
    (tmp_path / "robot.xml").write_text(emit(machine(), "free"), "utf-8")
    ball = '<body><freejoint/><geom size="0.1"/></body>'
    floor = f'<worldbody><geom name="floor" type="plane" size="1 1 1"/>{ball}</worldbody>'
    (tmp_path / "scene.xml").write_text(f'<mujoco><include file="robot.xml"/>{floor}</mujoco>', "utf-8")
    with no_warning():
        assert mujoco.MjModel.from_xml_path(str(tmp_path / "scene.xml")).nkey == 2
        option = '<option integrator="implicitfast" cone="elliptic" impratio="100"/>'  # those of the robot
        scene = mujoco.MjSpec.from_string(f"<mujoco>{option}{floor}</mujoco>")
        for prefix in ("left_", "right_"):
            robot = mujoco.MjSpec.from_file(str(tmp_path / "robot.xml"))
            scene.attach(robot, prefix=prefix, frame=scene.worldbody.add_frame())
        model = scene.compile()
    assert model.site("left_laser").id != model.site("right_laser").id
