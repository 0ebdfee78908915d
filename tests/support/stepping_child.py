"""A robot stepped in an engine, by a Python that has it: PyBullet and Drake are not installed with the tests.

Standard input is a list of JSON: ``engine``, ``file``, ``height`` (m, where the root begins; null: it is fixed there),
``held`` (positions by joint, in rad or m, which servos hold), ``seconds``, ``root`` (the topmost link). For each one
line of JSON follows: ``height`` of the root at the end (m), ``moved`` (m, how much it changed in the last quarter),
``finite``; or ``refused``.
"""

import json
import math
import sys
from typing import Any

KP, KV = 10000.0, 200.0  # of servos that hold all there is, whatever it weighs: how far their own sag is no question
FAR = 1.0  # m: no robot that stands goes there
STEPS = {"pybullet": 1 / 240, "mujoco": 0.002, "drake": 0.002}  # s


def pybullet(job: dict[str, Any], heights: list[float]) -> bool:
    import pybullet as p

    p.connect(p.DIRECT)
    p.setGravity(0, 0, -9.81)
    fixed = job["height"] is None
    if not fixed:
        p.createMultiBody(0, p.createCollisionShape(p.GEOM_PLANE))
    flags = p.URDF_USE_INERTIA_FROM_FILE
    body = p.loadURDF(job["file"], [0, 0, job["height"] or 0.0], useFixedBase=fixed, flags=flags)
    # What is placed and told is the centre of mass of the base; p[3] and p[4] say where that is in the link.
    offset = p.getDynamicsInfo(body, -1)[3:5]
    p.resetBasePositionAndOrientation(body, *p.multiplyTransforms([0, 0, job["height"] or 0.0], [0, 0, 0, 1], *offset))
    for joint in range(p.getNumJoints(body)):
        name, kind = p.getJointInfo(body, joint)[1].decode(), p.getJointInfo(body, joint)[2]
        if kind not in (p.JOINT_REVOLUTE, p.JOINT_PRISMATIC):
            continue
        p.setJointMotorControl2(body, joint, p.VELOCITY_CONTROL, force=0)  # it holds all joints if nobody asks
        if name in job["held"]:
            p.resetJointState(body, joint, job["held"][name])
            p.setJointMotorControl2(body, joint, p.POSITION_CONTROL, targetPosition=job["held"][name], force=100)
    joints, finite = range(p.getNumJoints(body)), True
    for _ in range(round(job["seconds"] / STEPS["pybullet"])):
        p.stepSimulation()
        place = p.multiplyTransforms(*p.getBasePositionAndOrientation(body), *p.invertTransform(*offset))
        speeds = [p.getJointState(body, joint)[1] for joint in joints]
        heights.append(place[0][2])
        finite &= all(map(math.isfinite, speeds)) and max(map(abs, place[0])) < FAR
    return finite


def mujoco(job: dict[str, Any], heights: list[float]) -> bool:
    import mujoco
    import numpy as np

    spec = mujoco.MjSpec.from_file(job["file"])
    is_urdf = job["file"].endswith(".urdf")
    if is_urdf:
        spec.compiler.fusestatic, spec.compiler.discardvisual = False, True
        for geom in spec.geoms:  # a URDF does not say who may touch whom
            geom.contype, geom.conaffinity = 0, 1
        for joint in spec.joints:
            if joint.name in job["held"]:
                servo = spec.add_actuator(name=joint.name, target=joint.name, trntype=mujoco.mjtTrn.mjTRN_JOINT)
                servo.set_to_position(kp=KP, kv=KV)
        spec.option.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    for servo in spec.actuators if not is_urdf else ():
        if servo.target in job["held"]:
            servo.set_to_position(kp=KP, kv=KV)
            servo.forcelimited = spec.joint(servo.target).actfrclimited = mujoco.mjtLimited.mjLIMITED_FALSE
    root = spec.body(job["root"])
    if job["height"] is not None:
        spec.worldbody.add_geom(type=mujoco.mjtGeom.mjGEOM_PLANE, size=[0, 0, 0.05], solref=[0.004, 1], priority=1)
        if is_urdf:
            root.add_freejoint()
    model = spec.compile()
    model.opt.timestep = STEPS["mujoco"]
    data = mujoco.MjData(model)
    mujoco.mj_resetDataKeyframe(model, data, 0) if model.nkey else mujoco.mj_resetData(model, data)
    for name, position in job["held"].items() if is_urdf else ():
        data.qpos[model.joint(name).qposadr[0]] = position
        data.ctrl[model.actuator(name).id] = position
    if job["height"] is not None:
        data.qpos[2] = job["height"]
    finite, place = True, data.body(job["root"]).xpos
    for _ in range(round(job["seconds"] / STEPS["mujoco"])):
        mujoco.mj_step(model, data)
        heights.append(float(place[2]))
        finite &= bool(np.isfinite(data.qvel).all() and np.abs(place).max() < FAR)
    return finite


def drake(job: dict[str, Any], heights: list[float]) -> bool:
    import logging

    import numpy as np
    from pydrake.geometry import CollisionFilterDeclaration, GeometrySet, HalfSpace
    from pydrake.math import RigidTransform
    from pydrake.multibody.parsing import Parser
    from pydrake.multibody.plant import AddMultibodyPlantSceneGraph, CoulombFriction
    from pydrake.multibody.tree import JointIndex, PdControllerGains
    from pydrake.systems.analysis import Simulator
    from pydrake.systems.framework import DiagramBuilder

    logging.getLogger("drake").setLevel(logging.ERROR)
    builder = DiagramBuilder()
    plant, scene = AddMultibodyPlantSceneGraph(builder, STEPS["drake"])
    robot = Parser(plant).AddModels(job["file"])[0]
    if job["height"] is None and not job["file"].endswith(".xml"):  # an MJCF says itself whether it is held
        plant.WeldFrames(plant.world_frame(), plant.GetFrameByName(job["root"]))
    elif job["height"] is not None:
        plant.RegisterCollisionGeometry(
            plant.world_body(), RigidTransform(), HalfSpace(), "floor", CoulombFriction(1.0, 1.0)
        )
    asked = {}
    for index in plant.GetJointIndices(robot):
        joint = plant.get_joint(JointIndex(index))
        if joint.name() in job["held"]:
            known = plant.HasJointActuatorNamed(joint.name(), robot)
            add = plant.GetJointActuatorByName if known else plant.AddJointActuator
            servo = add(joint.name(), robot if known else joint)
            servo.set_effort_limit(1e4)
            servo.set_controller_gains(PdControllerGains(p=KP, d=KV))
            asked[joint.name()] = servo
            joint.set_default_positions([job["held"][joint.name()]])
    plant.Finalize()
    bodies = [plant.get_body(index) for index in plant.GetBodyIndices(robot)]
    own = GeometrySet([id for body in bodies for id in plant.GetCollisionGeometriesForBody(body)])
    scene.collision_filter_manager().Apply(CollisionFilterDeclaration().ExcludeWithin(own))
    diagram = builder.Build()
    context = diagram.CreateDefaultContext()
    inner = plant.GetMyMutableContextFromRoot(context)
    if asked:
        wanted = np.zeros(2 * plant.num_actuators(robot))
        for name, servo in asked.items():
            wanted[_place(plant, robot, servo)] = job["held"][name]
        plant.get_desired_state_input_port(robot).FixValue(inner, wanted)
    if job["height"] is not None:
        plant.SetFreeBodyPose(inner, plant.GetBodyByName(job["root"]), RigidTransform([0, 0, job["height"]]))
    simulator = Simulator(diagram, context)
    simulator.Initialize()
    finite = True
    for step in range(1, round(job["seconds"] / 0.01) + 1):
        simulator.AdvanceTo(step * 0.01)
        place = plant.EvalBodyPoseInWorld(inner, plant.GetBodyByName(job["root"])).translation()
        heights.append(float(place[2]))
        finite &= bool(np.isfinite(plant.GetPositionsAndVelocities(inner)).all() and np.abs(place).max() < FAR)
    return finite


def _place(plant: Any, robot: Any, servo: Any) -> int:
    return sorted(plant.GetJointActuatorIndices(robot)).index(servo.index())


def mjx(job: dict[str, Any], heights: list[float]) -> bool:
    """Say whether MJX takes a model: it is not stepped, which would be compiled for minutes."""
    import mujoco
    from mujoco import mjx as engine

    model = mujoco.MjModel.from_xml_path(job["file"])
    heights.append(0.0)
    return bool(engine.put_model(model, impl="jax").nq == model.nq)


ENGINES = {"pybullet": pybullet, "mujoco": mujoco, "drake": drake, "mjx": mjx}


def main() -> None:
    """Answer the list of jobs on standard input, one line each."""
    for job in json.load(sys.stdin):
        heights: list[float] = []
        try:
            finite = ENGINES[job["engine"]](job, heights)
        except Exception as problem:  # whatever an engine has against a file
            print("\n" + json.dumps({"refused": f"{type(problem).__name__}: {problem}"}), flush=True)
            continue
        last = heights[-len(heights) // 4 :]
        said = {"height": heights[-1], "moved": max(last) - min(last), "finite": finite}
        print("\n" + json.dumps(said), flush=True)  # PyBullet prints names without ends of lines


if __name__ == "__main__":
    main()
