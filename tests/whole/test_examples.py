"""The robots in examples/: the same as their xacro, in fewer words, and as their makers publish them; they simulate.

``test_driving.py`` drives those that have wheels.
"""

from collections.abc import Mapping
from functools import lru_cache
from typing import Any

import numpy as np
import pytest

from rosorin_compile.formats.compilation import CompileResult
from rosorin_compile.model import Robot
from rosorin_compile.source.diagnostics import NOTE
from rosorin_compile.source.diagnostics import text as report
from support.paths import ROOT
from support.robots import compiled, texts
from support.round_trip import differences

pytestmark = pytest.mark.slow

EXAMPLES = sorted(path.parent for path in (ROOT / "examples").glob("*/robot.yaml"))
NAMES = [folder.name for folder in EXAMPLES]
PUBLISHED = [folder.name for folder in EXAMPLES if (folder / "xacro").is_dir()]  # the others are no product
STATES = 200

# kg: the sum of what is published, or of what the description says of body and wheels.
MASSES = {
    "turtlebot3_burger": 1.00173292,
    "ur5e": 21.7,
    "unitree_a1": 13.74,
    "omni_base": 2.5 + 3 * 0.15,
    "ackermann_car": 1.4 + 4 * 0.08 + 2 * 0.04,
    "porter": 18 + 2 * 0.1 + 2 * 1.2 + (1.2 + 1.4 + 1 + 0.5 + 0.3) + (0.2 + 2 * 0.05) + 0.15 + 0.07 + 0.3,
}


@lru_cache
def example(name: str) -> CompileResult:
    return compiled(ROOT / "examples" / name / "robot.yaml")


def robot_of(name: str) -> Robot:
    robot = example(name).robot
    assert robot is not None
    return robot


def artifact(name: str, suffix: str) -> str:
    return texts(example(name))[f"{name}{suffix}"]


def expanded_xacro(name: str) -> str:
    xacro = pytest.importorskip("xacro")
    return str(xacro.process_file(str(ROOT / "examples" / name / "xacro" / "robot.xacro")).toxml())


@pytest.mark.parametrize("name", NAMES)
def test_compiles_with_notes_at_most(name: str) -> None:
    made = example(name)
    assert not [found for found in made.diagnostics if found.severity != NOTE], report(made.diagnostics)


@pytest.mark.parametrize("name", PUBLISHED)
def test_is_the_robot_of_its_xacro(name: str) -> None:
    # How it drives is said in elements that are none of URDF: to one simulator there, to ros2_control here.
    found = differences(expanded_xacro(name).encode(), artifact(name, ".urdf").encode(), tolerance=1e-12)
    assert [line for line in found if not line.startswith("('robot', 'kept')")] == []


def scene(name: str) -> tuple[Any, Any]:
    mujoco = pytest.importorskip("mujoco", minversion="3.12")
    spec = mujoco.MjSpec.from_string(artifact(name, ".xml"))
    spec.worldbody.add_geom(name="floor", type=mujoco.mjtGeom.mjGEOM_PLANE).size = [0, 0, 1]
    model = spec.compile()
    data = mujoco.MjData(model)
    if model.nkey:
        mujoco.mj_resetDataKeyframe(model, data, 0)
    return model, data


def run(model: Any, data: Any, seconds: float = 1.0) -> None:
    """Simulate; every state is finite, and every joint stays within its limits (a soft bound gives a little)."""
    import mujoco

    from support.simulator import no_warning

    limited = np.flatnonzero(model.jnt_limited)
    at, (lower, upper) = model.jnt_qposadr[limited], model.jnt_range[limited].T
    with no_warning():
        while data.time < seconds - 1e-9:
            mujoco.mj_step(model, data)
            assert np.isfinite([*data.qpos, *data.qvel]).all()
            assert ((data.qpos[at] > lower - 0.01) & (data.qpos[at] < upper + 0.01)).all()


def touching(model: Any, data: Any) -> set[str]:
    """Return the bodies that touch the floor; no body touches another."""
    from support.simulator import contacts

    pairs = contacts(model, data)
    assert all("world" in pair for pair in pairs), pairs
    return {name for pair in pairs for name in pair} - {"world"}


def tilt(data: Any, body: str) -> float:
    return float(np.arccos(np.clip(data.body(body).xmat[8], -1, 1)))


def pinocchio_at(pinocchio: Any, model: Any, state: Mapping[str, float]) -> Any:
    velocity = np.zeros(model.nv)
    for name, value in state.items():
        if model.existJointName(name):  # only simulations have the rollers of a wheel
            velocity[model.joints[model.getJointId(name)].idx_v] = value
    return pinocchio.integrate(model, pinocchio.neutral(model), velocity)


@pytest.mark.landing("engines", "ackermann_car-free", "omni_base-free", "turtlebot3_burger-fixed", "ur5e-fixed")
@pytest.mark.parametrize("base", ["fixed", "free"])
@pytest.mark.parametrize("name", NAMES)
def test_mujoco_has_the_frames_of_pinocchio(name: str, base: str) -> None:
    pytest.importorskip("mujoco", minversion="3.12")
    pinocchio = pytest.importorskip("pinocchio")
    from support import simulator

    robot = robot_of(name)
    robot = simulator.at_origin(robot)
    model, data = simulator.load(simulator.emit(robot, base))
    assert simulator.contacts(model, data) == set()
    assert sum(model.body_mass) == pytest.approx(MASSES[name], rel=1e-12)
    if base == "free":
        data.qpos[:7] = (0, 0, 0, 1, 0, 0, 0)  # it would stand on a floor
    judge = pinocchio.buildModelFromXML(artifact(name, ".urdf"))
    judge_data = judge.createData()
    shared = [link.name for link in robot.links if f'<link name="{link.name}"' in artifact(name, ".urdf")]
    unpublished = {j.child for j in robot.joints if j.publisher.kind == "static_transform_publisher"}
    assert {link.name for link in robot.links} == {*shared, *unpublished, *robot.simulated_frames}
    for state in simulator.random_states(robot, STATES):
        simulator.pose(robot, model, data, state)
        state = {joint.name: robot.position(joint, state) for joint in robot.joints if joint.moves}  # followers, too
        pinocchio.framesForwardKinematics(judge, judge_data, pinocchio_at(pinocchio, judge, state))
        for link in shared:
            judged = judge_data.oMf[judge.getFrameId(link)]
            expected = np.column_stack((judged.rotation, judged.translation))
            np.testing.assert_allclose(simulator.frame(data, "body", link), expected, atol=1e-9)


def test_turtlebot_stands_on_its_wheels_and_caster() -> None:
    model, data = scene("turtlebot3_burger")
    run(model, data)
    assert touching(model, data) - {"caster_back_link"} == {"wheel_left_link", "wheel_right_link"}
    assert tilt(data, "base_link") < np.radians(0.5)  # the caster of the file hangs half a millimetre above the floor
    assert data.body("base_footprint").xpos == pytest.approx([0, 0, 0], abs=1e-3)
    assert data.sensor("imu_accelerometer").data[2] == pytest.approx(9.81, abs=0.01)


def test_ur5e_holds_its_home() -> None:
    model, data = scene("ur5e")
    home = data.qpos.copy()
    run(model, data)
    assert touching(model, data) == set()
    assert 0 < np.abs(data.qpos - home).max() < np.radians(1)  # it hangs on springs


def test_a1_stands() -> None:
    model, data = scene("unitree_a1")
    assert data.qpos[2] == pytest.approx(0.2686, abs=1e-4)  # of the base; the feet touch the floor
    run(model, data)
    feet = touching(model, data)
    assert feet == {"FR_foot", "FL_foot", "RR_foot", "RL_foot"}
    assert data.body("trunk").xpos[2] > 0.23
    assert tilt(data, "trunk") < np.radians(5)
    assert np.abs(data.qvel).max() < 0.5
    assert sum(data.sensor(f"{foot}_contact").data[0] for foot in feet) == pytest.approx(9.81 * 13.74, rel=0.05)
