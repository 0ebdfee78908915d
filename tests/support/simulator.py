"""MuJoCo for tests: a warning of the compiler or of the simulation is a failure."""

from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path

import mujoco
import numpy as np
from numpy.typing import NDArray

from rosorin_compile.formats.templating import Templates
from rosorin_compile.model import Output, Robot, Transform
from rosorin_compile.model.simulation import Root
from rosorin_compile.mujoco.mjcf import write as mjcf
from rosorin_compile.mujoco.mjcf.unsupported import position_range
from support.robots import compiled

BASES = ("fixed", "free")


def emit(robot: Robot, base: str = "fixed", number_format: str = "exact", **more: object) -> str:
    """Return the MJCF of a robot; ``more`` are options of the output."""
    options = {"base": base, "number_format": number_format, **more}
    return mjcf.write(robot, Output("mjcf", "mjcf", "robot.xml", options), Templates())[0]


def at_origin(robot: Robot) -> Robot:
    """Return a robot whose root is at the origin of the world, where it would stand on a floor if it is free."""
    return replace(robot, root_in_world=Root(placed=True))


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
                ends = position_range(joint) or (-3.0, 3.0)
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


# Robots of a few lines, with a scene around them whose right reading is known.


Model = tuple[mujoco.MjModel, mujoco.MjData]

GRAVITY = 9.81
# A room with its walls 2 m in front, 1 m behind, 1.5 m to the left and 0.5 m to the right of the origin of the world,
# its floor 0.7 m below and its ceiling 1.1 m above.
ROOM = {0: (-1.0, 2.0), 1: (-0.5, 1.5), 2: (-0.7, 1.1)}


def written(folder: Path, text: str) -> Path:
    """Write a description of a robot that begins at base_link, and return its file."""
    path = folder / "descriptions" / "probe" / "robot.yaml"
    path.parent.mkdir(parents=True, exist_ok=True)
    base = "" if "\nlinks:" in text or text.startswith("links:") else "links: {base_link: {}}\n"
    path.write_text(f"robot: probe\n{base}{text}\noutputs: {{mjcf: {{file: probe.xml}}}}\n", "utf-8")
    return path


def emitted(folder: Path, text: str) -> str:
    (artifact,) = compiled(written(folder, text)).artifacts
    return artifact.text


def probe(folder: Path, text: str, scene: str = "") -> Model:
    """Return a robot with a scene around it in MuJoCo; no warning is let through."""
    return load(emitted(folder, text).replace("<worldbody>", f"<worldbody>{scene}"))


def sensor(kind: str, rpy: Sequence[float] = (0, 0, 0), xyz: Sequence[float] = (0, 0, 0), more: str = "") -> str:
    at = f"xyz: {list(map(float, xyz))}, rpy: {list(map(float, rpy))}"
    return f"sensors:\n  probe: {{type: {kind}, parent: base_link, frame: probe_link, {at}{more}}}"


def said(said_by: Model, name: str) -> NDArray[np.float64]:
    return np.array(said_by[1].sensor(name).data)


def room() -> str:
    """Return the walls of the room, planes without thickness are not seen from behind: boxes of 10 cm."""
    boxes = []
    for axis, ends in ROOM.items():
        for end in ends:
            at, size = np.zeros(3), np.full(3, 5.0)
            at[axis], size[axis] = end + np.sign(end) * 0.05, 0.05
            boxes.append(f'<geom type="box" pos="{" ".join(map(str, at))}" size="{" ".join(map(str, size))}"/>')
    return "".join(boxes)


def distance(start: NDArray[np.float64], direction: NDArray[np.float64]) -> float:
    """Return how far it is to the walls of the room."""
    ways = [(end - start[axis]) / direction[axis] for axis, ends in ROOM.items() for end in ends if direction[axis]]
    return float(min(way for way in ways if way > 0))


def rays(said_by: Model, prefix: str) -> NDArray[np.float64]:
    """Return the readings of numbered sensors, in the order of their numbers."""
    model, _ = said_by
    names = sorted(model.sensor(i).name for i in range(model.nsensor))
    return np.array([said(said_by, name)[0] for name in names if name.startswith(f"{prefix}_")])
