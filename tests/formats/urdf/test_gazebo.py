"""Sensors for Gazebo in a URDF: where they sit, which way they look, which numbers they have, and who reads that."""

from __future__ import annotations

from random import Random
from xml.etree import ElementTree as ET

import numpy as np
import pytest

from rosorin_compile.formats.gazebo import DISTRIBUTIONS
from rosorin_compile.source.diagnostics import NOTE
from rosorin_compile.source.diagnostics import text as report
from support import sdformat
from support.comparing import compared, told
from support.robots import compiled_text

TYPES = {
    "camera": "camera",
    "depth_camera": "rgbd_camera",
    "lidar_2d": "gpu_lidar",
    "lidar_3d": "gpu_lidar",
    "imu": "imu",
    "range_finder": "gpu_lidar",
    "gnss": "navsat",
    "magnetometer": "magnetometer",
    "altimeter": "altimeter",
    "contact": "contact",
    "force_torque": "force_torque",
}
EVERY = """robot: r
args: {gazebo: {default: true}, elements: {default: [inertial, visual, collision]}}
links:
  base_link: {inertial: {mass: 1, of: collision}, collision: [{box: {size: [1, 1, 0.1]}, xyz: [0, 0, -3]}]}
  tool: {inertial: {mass: 1, of: collision}, collision: [{box: {size: [1, 1, 0.1]}, xyz: [0, 0, -3]}]}
joints:
  tool_joint: {type: fixed, parent: force_torque, child: tool}
sensors:
""" + "".join(f"  {name}: {{type: {name}, parent: base_link, frame: {name}}}\n" for name in TYPES)
EVERY += 'outputs: {urdf: {file: r.urdf, gazebo: "${gazebo}", elements: "${elements}"}}\n'


def urdf(folder, text, quiet=True):
    made = compiled_text(folder, text)
    found = [one.text for one in made.artifacts if one.backend == "urdf"]
    assert found, report(made.diagnostics)
    told = [one for one in made.diagnostics if one.severity != NOTE]
    assert not quiet or told == [], report(told)
    return found[0], [one.message for one in told]


def sensors(text):
    return {
        one.get("name"): (one, block.get("reference"))
        for block in ET.fromstring(text).iter("gazebo")
        for one in block.iter("sensor")
    }


def values(element):
    """Return the leaves of an element: path to text."""
    if not len(element):
        return {element.tag: element.text}
    return {f"{element.tag}/{path}": text for inner in element for path, text in values(inner).items()}


BASE = """robot: r
links: {base_link: {inertial: {mass: 1, of: collision}, collision: [{box: {size: [1, 1, 1]}, xyz: [0, 0, -3]}]}}
"""


def turn(rpy):
    """Return the matrix of roll, pitch, yaw about fixed axes (urdfdom's rule, written down again)."""
    r, p, y = rpy
    x = np.array([[1, 0, 0], [0, np.cos(r), -np.sin(r)], [0, np.sin(r), np.cos(r)]])
    about_y = np.array([[np.cos(p), 0, np.sin(p)], [0, 1, 0], [-np.sin(p), 0, np.cos(p)]])
    return np.array([[np.cos(y), -np.sin(y), 0], [np.sin(y), np.cos(y), 0], [0, 0, 1]]) @ about_y @ x


def placed(xyz, rpy):
    made = np.eye(4)
    made[:3, :3], made[:3, 3] = turn(rpy), xyz
    return made


def from_root(robot, link):
    """Return where a link of a URDF is in the root."""
    above = {joint.find("child").get("link"): joint for joint in robot.iter("joint")}
    pose = np.eye(4)
    while link in above:
        origin = above[link].find("origin")
        here = placed(*([float(one) for one in origin.get(key).split()] for key in ("xyz", "rpy")))
        pose, link = here @ pose, above[link].find("parent").get("link")
    return pose


@pytest.mark.parametrize("seed", range(12))
def test_a_sensor_looks_from_where_its_frame_is(tmp_path, seed):
    """Whoever publishes its frame and those it sits on; a camera looks along z of its optical frame, y of that down."""
    numbers = Random(seed)  # noqa: S311 - a case, no secret
    steps, frames, chain, apart = [], ["base_link"], {"base_link": np.eye(4)}, set()
    for index in range(9):
        kind = numbers.choice(["camera", "lidar_2d", "imu", "depth_camera"])
        parent = numbers.choice(frames)
        xyz = [numbers.uniform(-1, 1) for _ in range(3)]
        rpy = [numbers.uniform(-3, 3), numbers.uniform(-1.5, 1.5), numbers.uniform(-3, 3)]
        static = parent in apart or numbers.random() < 0.4
        apart.update([f"f{index}"] if static else [])
        by = "" if not static else f", publisher: {{static_transform_publisher: tf_{index}}}"
        lens = ""
        if kind == "depth_camera":
            lens = f", optical: {{frame: f{index}_optical, xyz: [{numbers.uniform(0, 1)}, 0.01, 0]}}"
        steps.append(
            f"  s{index}: {{type: {kind}, parent: {parent}, frame: f{index}, xyz: {xyz}, rpy: {rpy}{lens}{by}}}\n"
        )
        frames.append(f"f{index}")
        chain[f"f{index}"] = chain[parent] @ placed(xyz, rpy)
        moved = [float(lens.split("[")[1].split(",")[0]), 0.01, 0] if lens else [0, 0, 0]
        chain[f"f{index}_optical"] = chain[f"f{index}"] @ placed(moved, [-np.pi / 2, 0, -np.pi / 2])
    outputs = "outputs: {urdf: {file: r.urdf, gazebo: true}, static_tf: {file: tf.launch.py}}\n"
    text = BASE + "".join(["sensors:\n", *steps, outputs])
    made, _ = urdf(tmp_path, text)
    robot, found = ET.fromstring(made), sensors(made)
    assert len(found) == 9
    for name, (one, reference) in found.items():
        pose = [float(number) for number in one.findtext("pose", "0 0 0 0 0 0").split()]
        there = from_root(robot, reference) @ placed(pose[:3], pose[3:])
        frame = name.replace("s", "f")
        wanted = chain[frame]
        if "camera" in one.get("type"):
            wanted = chain[f"{frame}_optical"]
            x, y, z = wanted[:3, :3].T
            wanted = np.column_stack([[*z, 0], [*-x, 0], [*-y, 0], wanted[:, 3]])
        np.testing.assert_allclose(there, wanted, atol=1e-9)


def test_a_description_and_its_urdf_are_the_same_robot(home):
    artifact = home / "r.urdf"
    artifact.write_text(urdf(home, EVERY)[0], "utf-8")
    for sides in (("robot.yaml", "r.urdf"), ("r.urdf", "robot.yaml")):
        assert compared(*sides)["differences"] == []
    (home / "robot.yaml").write_text(EVERY.replace("frame: lidar_2d}", "frame: lidar_2d, with: {rays: 7}}"), "utf-8")
    (said,) = told("robot.yaml", "r.urdf")
    assert said.startswith("URDF elements of the robot: 1 new")


@pytest.mark.slow
@pytest.mark.parametrize("which", ["harmonic", "fortress"])
def test_gazebo_reads_the_sensors(tmp_path, which):
    """Types, values and poses, as libsdformat reads them out of the URDF; and SDF knows every element."""
    sdformat.need()
    text = EVERY.replace("default: true", f"default: {which}")
    text = text.replace(
        "type: imu,", "type: imu, with: {gyro_noise: 0.1, accelerometer_noise: 1}, xyz: [0.1, 0.2, 0.3],"
    )
    text = text.replace("frame: imu}", "frame: imu, rpy: [0.1, -0.2, 0.3]}")
    for kind in ("camera", "lidar_3d"):
        text = text.replace(f"type: {kind},", f"type: {kind}, with: {{noise: 0.1}},")
    text, _ = urdf(tmp_path, text)
    model, said = sdformat.as_sdf(text, tmp_path)
    assert said == ""
    read = {one.get("name"): one for one in model.iter("sensor")}
    assert {name: one.get("type") for name, one in read.items()} == TYPES
    tables = sdformat.known("sensor")
    for name, (ours, _) in sensors(text).items():
        wanted = values(ours)
        found = values(read[name])
        for path, value in wanted.items():
            if "pose" not in path and "/collision" not in path:
                assert found[path] == value or float(found[path]) == pytest.approx(float(value), rel=1e-5), path
            table = tables
            for step in path.split("/")[1:]:
                assert step in table or step == DISTRIBUTIONS[which], path
                table = table.get(step, {})
    pose = [float(number) for number in read["imu"].findtext("pose").split()]
    assert pose == pytest.approx([0.1, 0.2, 0.3, 0.1, -0.2, 0.3], abs=1e-5)
    assert [joint.get("name") for joint in model.iter("joint") if joint.find("sensor") is not None] == [
        "force_torque_joint"
    ]
    names = {one.get("name") for one in model.findall("link/collision")}
    assert {one.text for one in read["contact"].iter("collision")} <= names


def random_tree(seed):
    """Return a robot of links with and without shapes and mass, on fixed joints and others, with contact sensors."""
    numbers = Random(seed)  # noqa: S311 - a case, no secret
    links, joints, felt = ["  l0: {inertial: {mass: 1, of: [{sphere: {radius: 1}}]}}\n"], [], []
    for index in range(1, 12):
        shapes = [
            f"{{{numbers.choice(['', f'name: n{index}{k}, '])}sphere: {{radius: 1}}}}"
            for k in range(numbers.choice([0, 1, 1, 3]))
        ]
        kind = numbers.choice(["fixed", "fixed", "fixed", "continuous"])
        mass = "inertial: {mass: 1, of: [{sphere: {radius: 1}}]}, " if kind != "fixed" or numbers.random() < 0.3 else ""
        links.append(f"  l{index}: {{{mass}collision: [{', '.join(shapes)}]}}\n")
        axis = ", axis: [0, 0, 1]" if kind != "fixed" else ""
        parent = numbers.randrange(index)
        joints.append(
            f"  j{numbers.randrange(100)}_{index}: {{type: {kind}, parent: l{parent}, child: l{index}{axis}}}\n"
        )
        if shapes:
            felt.append(f"  s{index}: {{type: contact, parent: l{index}, frame: f{index}}}\n")
    return "".join(["robot: r\nlinks:\n", *links, "joints:\n", *joints, "sensors:\n", *felt]) + (
        "outputs: {urdf: {file: r.urdf, gazebo: true}}\n"
    )


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(8))
def test_a_contact_finds_all_shapes_of_its_link_in_gazebo(tmp_path, seed):
    """Links merge in many ways: each shape of the robot is felt by one sensor, under the name that Gazebo gives it."""
    sdformat.need()
    text, _ = urdf(tmp_path, random_tree(seed), quiet=False)
    model, said = sdformat.as_sdf(text, tmp_path)
    assert said == ""
    ours = [one.text for sensor, _ in sensors(text).values() for one in sensor.iter("collision")]
    assert ours
    theirs = [one.get("name") for one in model.findall("link/collision")]
    assert sorted(ours) == sorted(theirs)
    for link in model.iter("link"):
        own = {one.get("name") for one in link.findall("collision")}
        assert {one.text for sensor in link.findall("sensor") for one in sensor.iter("collision")} <= own
