"""What a URDF weighs, whoever publishes its joints: held against the model, and against engines that read URDF."""

from __future__ import annotations

import random
import subprocess
import sys
from collections.abc import Iterable
from pathlib import Path
from xml.etree import ElementTree as ET

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from rosorin_compile.formats.templating import Templates
from rosorin_compile.formats.urdf import write as urdf
from rosorin_compile.formats.urdf.write import inertials_at
from rosorin_compile.model import (
    ROBOT_STATE_PUBLISHER,
    Box,
    Inertial,
    Joint,
    Limit,
    Link,
    Output,
    Pose,
    Publisher,
    Shape,
    Transform,
)
from rosorin_compile.model import Robot as Model
from rosorin_compile.model.colours import default_colours, with_visuals
from rosorin_compile.model.joint import UNPUBLISHED, Mimic
from support import sdformat
from support.robots import compiled, compiled_text, texts
from support.urdf_robots import emit

OURS = Publisher(ROBOT_STATE_PUBLISHER, ROBOT_STATE_PUBLISHER)
NOBODY = Publisher(UNPUBLISHED)
FRAMES = ("published", "all", "bodies")
SIM = texts(compiled())["rosorin_sim.urdf"]
MASS = 0.9332425148926046 + 4 * 0.0705  # kg, the sum of the masses in the description
# Links of the reference robot that weigh something, but not those that hold nothing: frames, and the floor's.
BODIES = {
    *("base_link", "laser", "link1", "link2", "link3", "link4", "link5", "camera_link0", "camera_link", "gripper_link"),
    *("r_link", "l_link", "l_in_link", "l_out_link", "r_in_link", "r_out_link"),
}
for _wheel in (f"{end}_{side}_wheel" for end in ("front", "rear") for side in ("left", "right")):
    BODIES |= {f"{_wheel}_link", *(f"{_wheel}_roller_{number}" for number in range(9))}


class Whole:
    """Several inertials as one: mass, centre of mass, and inertia about it, by numpy alone."""

    def __init__(self, parts: Iterable[tuple[float, NDArray[np.float64], NDArray[np.float64]]]) -> None:
        some = list(parts)
        self.mass = sum(mass for mass, _, _ in some)
        self.centre = sum(mass * at for mass, at, _ in some) / self.mass
        self.inertia = np.zeros((3, 3))
        for mass, at, inertia in some:
            d = at - self.centre
            self.inertia += inertia + mass * (d @ d * np.eye(3) - np.outer(d, d))

    def is_close(self, other: Whole, size: float) -> bool:
        return bool(
            abs(self.mass - other.mass) <= 1e-12 * self.mass
            and abs(self.centre - other.centre).max() <= 1e-12 * size
            and abs(self.inertia - other.inertia).max() <= 1e-12 * (abs(self.inertia).max() + self.mass * size**2)
        )


def placed(inertial: Inertial, frame: Transform) -> tuple[float, NDArray[np.float64], NDArray[np.float64]]:
    i, at = inertial, frame.then(inertial.pose.transform())
    own = np.array([[i.ixx, i.ixy, i.ixz], [i.ixy, i.iyy, i.iyz], [i.ixz, i.iyz, i.izz]])
    rows = np.array(at.rows)
    return i.mass, np.array(at.xyz), rows @ own @ rows.T


def of_model(robot: Model, top: str) -> Whole:
    """Return all of a robot at zero, seen from one of its links."""
    there = robot.pose_in_root(top, {}).inverse()
    inertials = ((link.inertial, there.then(robot.pose_in_root(link.name, {}))) for link in robot.links)
    return Whole(placed(inertial, at) for inertial, at in inertials if inertial is not None)


def of_urdf(text: str, robot: Model) -> tuple[str, Whole]:
    """Return the topmost link of a URDF, and all of it as pinocchio reads it, at the zero of the robot."""
    import pinocchio as pin

    model = pin.buildModelFromXML(text)
    data, root = model.createData(), ET.fromstring(text)
    children = {joint.find("child").get("link") for joint in root.iter("joint")}
    top = next(link.get("name") for link in root.iter("link") if link.get("name") not in children)
    step = np.zeros(model.nv)
    for name in list(model.names)[1:]:
        step[model.joints[model.getJointId(name)].idx_v] = robot.position(robot.joint[name], {})
    pin.forwardKinematics(model, data, pin.integrate(model, pin.neutral(model), step))
    every = [data.oMi[i].act(model.inertias[i]) for i in range(model.njoints)]
    return str(top), Whole((one.mass, np.array(one.lever), np.array(one.inertia)) for one in every if one.mass)


def machine(seed: int) -> Model:
    """Return a random robot; robot_state_publisher publishes some piece of its tree, nobody the rest."""
    draw = random.Random(seed)  # noqa: S311

    def pose() -> Pose:
        x, y, z, roll, pitch, yaw = (draw.uniform(-1, 1) for _ in range(6))
        return Pose((x, y, z), (3 * roll, 1.5 * pitch, 3 * yaw))

    count = draw.randint(2, 12)
    links = []
    for number in range(count):
        a, b, c = (draw.uniform(1, 1.9) * 10 ** draw.uniform(-6, -2) for _ in range(3))
        inertial = Inertial(10 ** draw.uniform(-3, 1), pose(), b + c, a + c, a + b, a / 9, b / -9, c / 9)
        links.append(Link(f"l{number}", inertial if draw.random() < 0.7 or number == count - 1 else None))
    top, inside, joints = draw.randrange(count - 1), set(), []
    for child in range(1, count):
        parent = draw.randrange(child)
        published = parent in {top, *inside} and draw.random() < 0.6
        inside |= {child} if published else set()
        kind = draw.choice(["fixed", "fixed", "revolute", "continuous", "prismatic"])
        axis = Pose((0, 0, 0), pose().rpy).transform().rotate((1.0, 0.0, 0.0))
        movers = [joint.name for joint in joints if joint.moves and joint.mimic is None]
        mimic = Mimic(draw.choice(movers), 0.5, draw.uniform(-1, 1)) if movers and draw.random() < 0.3 else None
        joints.append(
            Joint(
                *(f"j{child}", kind, f"l{parent}", f"l{child}", pose(), axis),
                limit=None if kind in ("fixed", "continuous") else Limit(-2.0, 2.0, 1.0, 1.0),
                mimic=mimic if kind != "fixed" else None,
                publisher=OURS if published else NOBODY,
            )
        )
    return Model("r", tuple(links), tuple(joints))


@settings(max_examples=200, deadline=None)
@given(st.integers(0, 10**9), st.sampled_from(FRAMES))
def test_the_sum_in_the_urdf_is_the_sum_of_the_robot(seed: int, frames: str) -> None:
    pytest.importorskip("pinocchio")
    robot = machine(seed)
    if frames == "published" and not robot.in_urdf():
        return  # pinocchio makes no model of one link
    text, _ = urdf.write(robot, Output("urdf", "urdf", "r.urdf", {"frames": frames}), Templates())
    if "<joint" not in text:
        return
    top, read = of_urdf(text, robot)
    assert read.is_close(of_model(robot, top), size=20.0)


def test_a_mass_that_stays_where_it_is_stays_as_it_is_written() -> None:
    inertial = Inertial(0.1 + 0.2, Pose((0.1, 0.2, 0.3), (0.4, 0.5, 0.6)), 1.0, 1.1, 1.2, 0.01)
    robot = Model("r", (Link("a", inertial), Link("b")), (Joint("j", "fixed", "a", "b", publisher=NOBODY),))
    assert inertials_at(robot, {"a"}) == {"a": inertial}
    mount = Pose((1.0, 0.0, 0.0), (0.0, 0.0, 0.5))
    turned = Model("r", (Link("a"), Link("b", inertial)), (Joint("j", "fixed", "a", "b", mount, publisher=NOBODY),))
    moved = inertials_at(turned, {"a"})["a"]
    assert (moved.mass, moved.ixx, moved.ixy) == (inertial.mass, 1.0, 0.01)


# The reference robot in the simulators.


def test_gazebo_drops_no_mass_of_the_reference_robot(tmp_path: Path) -> None:
    sdformat.need()
    model, said = sdformat.as_sdf(SIM, tmp_path)
    assert said == ""
    moving = {
        joint.find("child").get("link") for joint in ET.fromstring(SIM).iter("joint") if joint.get("type") != "fixed"
    }
    assert {link.get("name") for link in model.iter("link")} == {"base_link", *moving}  # what is fixed is one link
    assert sum(float(one.text or "") for one in model.iter("mass")) == pytest.approx(MASS, rel=1e-12)
    seen, solid = (len(list(model.iter(what))) for what in ("visual", "collision"))
    assert solid == 35 + 9 + 4 * (1 + 9 * 3)
    assert seen == solid - 4 * 9 * 2  # a roller is three spheres that look like one cylinder
    empty, _ = sdformat.as_sdf(texts(compiled())["rosorin.urdf"], tmp_path)
    assert list(empty.iter("link")) == []


def test_pinocchio_has_all_bodies_of_the_reference_robot() -> None:
    pin = pytest.importorskip("pinocchio")
    model = pin.buildModelFromXML(SIM, pin.JointModelFreeFlyer())
    assert pin.computeTotalMass(model) == pytest.approx(MASS, rel=1e-12)
    assert {frame.name for frame in model.frames if frame.type == pin.FrameType.BODY} == BODIES
    robot = compiled().robot
    assert robot is not None
    top, read = of_urdf(SIM, robot)
    assert top == "base_link"
    assert read.is_close(of_model(robot, "base_link"), size=0.5)


BULLET = """import sys, pybullet as p
p.connect(p.DIRECT)
body = p.loadURDF(sys.argv[1])
print("\\n", sum(p.getDynamicsInfo(body, link)[0] for link in range(-1, p.getNumJoints(body))))
"""


def bullet(urdf: str, folder: Path) -> float:
    """Return what a robot weighs in PyBullet (kg), which may crash: in a process of its own."""
    path = folder / "judged.urdf"
    path.write_text(urdf, "utf-8")
    ran = subprocess.run([sys.executable, "-c", BULLET, path], capture_output=True, text=True, check=True, timeout=120)
    return float(ran.stdout.split()[-1])


@pytest.mark.slow
def test_pybullet_invents_no_mass(tmp_path: Path) -> None:
    if subprocess.run([sys.executable, "-c", "import pybullet"], capture_output=True, check=False).returncode:
        pytest.skip("pybullet is not installed")
    assert bullet(SIM, tmp_path) == pytest.approx(MASS, rel=1e-6)
    assert bullet(texts(compiled())["rosorin.urdf"], tmp_path) == 11.0  # 1 kg for each link
    held = texts(compiled_text(tmp_path, HELD))["sim.urdf"]
    assert bullet(held, tmp_path) == pytest.approx(3.0, rel=1e-6)


# A chassis without mass that holds two masses together, frames that weigh nothing, and a joint that nobody publishes.
HELD = """robot: held
links:
  floor: {}
  chassis: {collision: [{box: {size: [0.3, 0.3, 0.1]}}]}
  battery: {inertial: {mass: 1, of: collision}, collision: [{box: {size: [0.1, 0.1, 0.1]}}]}
  mast: {inertial: {mass: 1, of: collision}, collision: [{box: {size: [0.1, 0.1, 0.1]}}]}
  fan: {inertial: {mass: 1, of: collision}, collision: [{box: {size: [0.1, 0.1, 0.1]}}]}
  tip: {collision: [{sphere: {radius: 0.05}}]}
joints:
  up: {type: fixed, parent: floor, child: chassis, xyz: [0, 0, 0.1]}
  battery_joint: {type: fixed, parent: chassis, child: battery, xyz: [0.1, 0, 0]}
  mast_joint: {type: fixed, parent: chassis, child: mast, xyz: [0, 0, 0.3]}
  fan_joint: {type: continuous, parent: mast, child: fan, axis: [0, 0, 1], publisher: {none: no encoder}}
  tip_joint: {type: fixed, parent: fan, child: tip, xyz: [0.2, 0, 0], publisher: {none: it is on the fan}}
outputs:
  urdf: {file: held.urdf, elements: [collision]}
  simulated: {backend: urdf, file: sim.urdf, frames: bodies, visuals: from_collision}
  static_tf: {file: held.launch.py}
"""


def links(text: str) -> dict[str, ET.Element]:
    return {str(link.get("name")): link for link in ET.fromstring(text).iter("link")}


def test_gazebo_reads_bodies_that_a_link_without_mass_holds(tmp_path: Path) -> None:
    sdformat.need()
    model, said = sdformat.as_sdf(texts(compiled_text(tmp_path, HELD))["sim.urdf"], tmp_path)
    assert (said, {link.get("name") for link in model.iter("link")}) == ("", {"chassis", "fan"})
    assert sum(float(one.text or "") for one in model.iter("mass")) == pytest.approx(3.0)


# Visuals that come from collision shapes.


def boxes(*names: str, **visual: tuple[Shape, ...]) -> Model:
    box = Shape(Box((0, 0, 0), (1, 1, 1)), name="hull", stand_in="a guess", urdf_elements=("<verbose/>",))
    made = [Link(name, visual=visual.get(name, ()), collision=(box, box)) for name in names]
    joints = [Joint(f"to_{name}", "fixed", names[0], name) for name in names[1:]]
    return Model("r", tuple(made), tuple(joints))


def test_a_link_without_visuals_is_seen_as_its_collision_shapes_in_one_colour() -> None:
    own = (Shape(Box((0, 0, 0), (2, 2, 2)), rgba=(1.0, 0.0, 0.0, 1.0)),)
    robot = boxes("a", "b", "c", b=own)
    seen = with_visuals(robot)
    assert seen.link["b"] == robot.link["b"]
    assert [visual.geometry for visual in seen.link["a"].visual] == [
        shape.geometry for shape in robot.link["a"].collision
    ]
    assert {(v.name, v.stand_in, v.urdf_elements) for v in seen.link["a"].visual} == {("", "", ())}
    assert [seen.colour(visual) for visual in seen.link["c"].visual] == [default_colours(robot)["c"]] * 2
    assert with_visuals(seen) == seen
    text = emit(robot, {"visuals": "from_collision", "elements": []})
    assert {name: len(link.findall("visual")) for name, link in links(text).items()} == {"a": 2, "b": 1, "c": 2}
    assert "<visual" not in emit(boxes("a", "b"))
