"""MuJoCo for tests: a warning of the compiler or of the simulation is a failure."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import contextmanager

import mujoco
import numpy as np
from numpy.typing import NDArray

from rosorin_compile.emit import mjcf
from rosorin_compile.model import Output, Robot, Transform
from rosorin_compile.templating import Templates

BASES = ("fixed", "free")


def emit(robot: Robot, base: str = "fixed", number_format: str = "exact") -> str:
    """Return the MJCF of a robot."""
    options = {"base": base, "number_format": number_format}
    return mjcf.write(robot, Output("mjcf", "mjcf", "robot.xml", options), Templates())[0]


@contextmanager
def no_warning() -> Iterator[None]:
    """Fail if the engine warns. What its compiler warns of is a Python warning, which pytest makes an error."""
    said: list[str] = []
    mujoco.set_mju_user_warning(said.append)
    try:
        yield
    finally:
        mujoco.set_mju_user_warning(None)
    assert said == []


def load(text: str, assets: Mapping[str, bytes] | None = None) -> tuple[mujoco.MjModel, mujoco.MjData]:
    """Return the compiled model, at its zero pose."""
    with no_warning():
        model = mujoco.MjModel.from_xml_string(text, dict(assets or {}))
        data = mujoco.MjData(model)
        mujoco.mj_forward(model, data)
    return model, data


def random_states(robot: Robot, count: int) -> Iterator[dict[str, float]]:
    """Yield positions of the joints that follow no other, within their limits, never the same twice."""
    generator = np.random.default_rng(20261120)
    for _ in range(count):
        state = {}
        for joint in robot.joints:
            if joint.moves and not joint.mimic:
                ends = mjcf.position_range(joint) or (-3.0, 3.0)
                state[joint.name] = float(generator.uniform(*ends))
        yield state


def pose(robot: Robot, model: mujoco.MjModel, data: mujoco.MjData, positions: Mapping[str, float]) -> None:
    """Set every joint, followers too: a mimic is a soft constraint, which kinematics does not know."""
    for joint in robot.joints:
        if joint.moves:
            data.qpos[model.jnt_qposadr[model.joint(joint.name).id]] = robot.position(joint, positions)
    mujoco.mj_forward(model, data)


def matrix(transform: Transform) -> NDArray[np.float64]:
    """Return a transform of the model of the robot as a 3x4 matrix."""
    return np.column_stack((np.array(transform.rows), np.array(transform.xyz)))


def frame(data: mujoco.MjData, kind: str, name: str) -> NDArray[np.float64]:
    """Return where a body or a site is in the world, as a 3x4 matrix."""
    if kind == "body":
        return np.column_stack((data.body(name).xmat.reshape(3, 3), data.body(name).xpos))
    return np.column_stack((data.site(name).xmat.reshape(3, 3), data.site(name).xpos))


def contacts(model: mujoco.MjModel, data: mujoco.MjData) -> set[tuple[str, str]]:
    """Return the pairs of bodies that touch."""
    bodies = [(model.geom_bodyid[c.geom1], model.geom_bodyid[c.geom2]) for c in data.contact[: data.ncon]]
    return {tuple(sorted((model.body(a).name, model.body(b).name))) for a, b in bodies}
