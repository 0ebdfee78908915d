"""The robot in MuJoCo: what its actuators are, where it stands, and what comes of numbers that end."""

import math
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from rosorin_compile.formats import FORMATS
from rosorin_compile.formats.templating import Templates
from rosorin_compile.model import Joint, Limit, Link, Output, Robot
from rosorin_compile.model.drive import Drive
from rosorin_compile.mujoco.mjcf.bodies import home_of
from rosorin_compile.mujoco.mjcf.engine import quiet
from rosorin_compile.mujoco.scenarios import FORCE, FREE, POSITION, VELOCITY, World, hold, swept_joints
from support.paths import ROOT, ROSORIN, data_text
from support.robots import compiled

pytest.importorskip("mujoco", minversion="3.12")

pytestmark = pytest.mark.slow  # MuJoCo

NAMES = ("position", "velocity", "motor", "general", "damper", "geared", "unlimited")


@pytest.fixture
def mujoco() -> Iterator[Any]:
    with quiet() as found:
        yield found


def robot(names: tuple[str, ...] = NAMES, drive: Drive | None = None) -> Robot:
    joints = [Joint(name, "revolute", "base", f"{name}_link", axis=(0, 0, 1), limit=Limit(-1, 1)) for name in names]
    return Robot("r", (Link("base"), *(Link(f"{name}_link") for name in names)), tuple(joints), drive=drive)


def mjcf(names: tuple[str, ...], actuators: str, more: str = "") -> str:
    bodies = "".join(
        f'<body name="{name}_link"><joint name="{name}"/><geom size="0.1" contype="0" conaffinity="0"/></body>'
        for name in names
    )
    body = f'<body name="base"><freejoint/><geom size="0.1"/>{bodies}</body>'
    return f"<mujoco>{more}<worldbody>{body}</worldbody><actuator>{actuators}</actuator></mujoco>"


ACTUATORS = data_text("robots/world_actuators.xml")


def test_what_an_actuator_is_is_read_from_its_gain_and_bias(mujoco: Any) -> None:
    world = World(mujoco, robot(), mjcf(NAMES, ACTUATORS), FREE, Path())
    kinds = {one.joint: one.kind for one in world.actuators}
    assert kinds == {
        "position": POSITION,
        "velocity": VELOCITY,
        "motor": FORCE,
        "general": POSITION,
        "damper": VELOCITY,
        "geared": POSITION,
        "unlimited": POSITION,
        "": FORCE,
    }
    assert world.own == ()
    targets = {one.joint: one.targets for one in world.actuators if one.kind != FORCE}
    assert targets["position"] == pytest.approx((-0.5, 0.7))
    assert targets["geared"] == pytest.approx((-0.5, 1.5))
    assert targets["unlimited"] == ()
    assert targets["velocity"] == pytest.approx((-6, 6))
    assert targets["damper"] == pytest.approx((-4, 8))  # 4 * 10 / 2, through a gear of 5
    found = {joint.name: ends for joint, ends in swept_joints(world)}
    assert {name: pytest.approx(ends) for name, ends in found.items()} == {
        "position": (-0.5, 0.7),
        "general": (-1, 1),
        "geared": (-0.5, 1),
        "unlimited": (-1, 1),
        "velocity": (-0.1, 0.1),  # a joint without limits, driven by velocity
        "damper": (-0.1, 0.1),
    }


def test_an_actuator_brings_its_joint_where_it_is_told(mujoco: Any) -> None:
    text = mjcf(
        NAMES,
        ACTUATORS,
        '<option gravity="0 0 0" integrator="implicitfast"/><default><joint damping="0.001"/></default>',
    )
    world = World(mujoco, robot(), text, FREE, Path())
    world.reset({"position": 0.2, "general": 0.3, "geared": 0.1})
    for _ in world.run(0.5):
        pass
    for name, position in {"position": 0.2, "general": 0.3, "geared": 0.1, "unlimited": 0.0}.items():
        assert world.position(name) == pytest.approx(position, abs=1e-3)
    world.reset({})
    world.hold("general", 0.4)
    for _ in world.run(
        4.0, lambda _: [world.turn(name, 1.5, world.sample) for name in ("velocity", "damper", "unlimited")]
    ):
        pass
    assert world.position("general") == pytest.approx(0.4, abs=0.01)
    for name in ("velocity", "damper"):
        assert world.data.joint(name).qvel[0] == pytest.approx(1.5, rel=0.01)
    assert world.position("unlimited") == pytest.approx(6, rel=0.1)


GEOMS = {
    "sphere": 'type="sphere" size="0.1"',
    "capsule": 'type="capsule" size="0.05 0.2"',
    "cylinder": 'type="cylinder" size="0.1 0.15"',
    "ellipsoid": 'type="ellipsoid" size="0.1 0.2 0.3"',
    "box": 'type="box" size="0.1 0.2 0.3"',
    "mesh": 'type="mesh" mesh="m"',
}
MESH = '<asset><mesh name="m" vertex="0 0 0 0.3 0 0 0 0.2 0 0 0 0.5"/></asset>'


@pytest.mark.parametrize("quat", ["1 0 0 0", "0.7 0.1 -0.5 0.3", "0.2 0.9 0.3 -0.1"])
@pytest.mark.parametrize("geom", GEOMS)
def test_a_robot_begins_on_the_floor(mujoco: Any, geom: str, quat: str) -> None:
    """A hair lower MuJoCo has a contact with the floor, and a hair higher it has none; a ghost does not count."""
    ghost = '<geom size="2" contype="0" conaffinity="0"/>'
    body = (
        f'<body name="base" pos="0.1 0 3"><freejoint/>{ghost}<geom {GEOMS[geom]} quat="{quat}" pos="0 0.1 0.2"/></body>'
    )
    world = World(
        mujoco, Robot("r", (Link("base"),), ()), f"<mujoco>{MESH}<worldbody>{body}</worldbody></mujoco>", FREE, Path()
    )
    world.reset({})
    for height, contacts in ((-2e-5, True), (1e-4, False)):
        world.reset({})
        world.data.qpos[2] += height
        mujoco.mj_forward(world.model, world.data)
        assert (world.data.ncon > 0) == contacts
        assert world.contacts()[1] == (["base"] if contacts else [])


def test_numbers_that_end_are_told(mujoco: Any) -> None:
    world = World(mujoco, robot(("motor",)), mjcf(("motor",), '<motor joint="motor"/>'), FREE, Path())
    world.reset({})
    world.data.ctrl[0] = float("inf")
    assert list(world.run(0.1)) == []
    assert "MuJoCo warns: Nan, Inf or huge value in CTRL" in world.broken
    world.reset({})
    world.data.qvel[0] = 1e200
    assert list(world.run(0.1)) == []
    assert world.broken.startswith("after 0 s: MuJoCo warns: Nan, Inf or huge value in QVEL")
    assert hold(world, "home", {}, 0.5).broken == ""  # a trial begins anew


SLOPE = math.radians(10.0)
CREEP = 0.01  # m in 5 s: four mecanum wheels went 30 mm with MuJoCo's own cone and impratio


def creeps(path: Path, mujoco: Any, option: dict[str, Any] | None = None) -> float:
    """Return how far (m) a robot goes down a slope of 10 degrees in 5 s while all that drives it is told to hold."""
    made = compiled(path)
    assert made.robot is not None
    options = next((dict(one.options) for one in made.robot.outputs if one.backend == "mjcf"), {})
    options["option"] = {**options.get("option", {}), **(option or {})}
    output = Output("mjcf", "mjcf", "robot.xml", {**options, "base": FREE})
    text, _ = FORMATS["mjcf"].compile(made.robot, output, Templates())
    world = World(mujoco, made.robot, text, FREE, path.parent)
    world.reset(dict(home_of(made.robot).positions))
    for _ in world.run(1.0):  # it settles on the level
        pass
    down = 9.81 * math.sin(SLOPE)
    begin = world.data.qpos[:2].copy()
    world.model.opt.gravity[:] = [down, 0.0, -9.81 * math.cos(SLOPE)]
    for _ in world.run(5.0):
        pass
    return float(np.hypot(*(world.data.qpos[:2] - begin)))


OTHERS = ("ackermann_car", "omni_base", "porter", "turtlebot3_burger", "unitree_a1")
STANDING = [ROSORIN, *(ROOT / "examples" / name / "robot.yaml" for name in OTHERS)]


@pytest.mark.parametrize("path", STANDING, ids=lambda path: path.parent.name)
def test_a_robot_stands_on_a_slope(mujoco: Any, path: Path) -> None:
    assert creeps(path, mujoco) < CREEP
