"""Sensors for Gazebo in a URDF: where they sit, which way they look, which numbers they have, and who reads that."""

from __future__ import annotations

from random import Random
from xml.etree import ElementTree as ET

import numpy as np
import pytest

from rosorin_compile.formats.gazebo_elements import DISTRIBUTIONS
from rosorin_compile.source.diagnostics import NOTE
from rosorin_compile.source.diagnostics import text as report
from support import sdformat
from support.comparing import compared, told
from support.paths import ROSORIN
from support.robots import compiled, compiled_text

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


def test_every_type_of_the_library_is_there(tmp_path):
    text, _ = urdf(tmp_path, EVERY)
    found = sensors(text)
    assert {name: one.get("type") for name, (one, _) in found.items()} == TYPES
    assert {name: where for name, (_, where) in found.items()} == {name: name for name in TYPES} | {
        "contact": "base_link", "force_torque": "force_torque_joint"
    }  # fmt: skip
    stamps = {name: one.findtext("gz_frame_id") for name, (one, _) in found.items()}
    assert stamps == {name: name for name in TYPES} | {name: f"{name}_optical" for name in ("camera", "depth_camera")}
    assert all(one.find("pose") is None for one, _ in found.values())


def test_it_is_not_there_unless_it_is_asked_for(tmp_path):
    assert "<gazebo" not in urdf(tmp_path, EVERY.replace("default: true", "default: false"))[0]
    assert "<gazebo" not in compiled(ROSORIN).artifacts[0].text
    assert urdf(tmp_path, EVERY)[0] == urdf(tmp_path, EVERY.replace("default: true", "default: harmonic"))[0]


def test_fortress_names_the_frame_in_its_own_way(tmp_path):
    harmonic = urdf(tmp_path, EVERY)[0]
    fortress = urdf(tmp_path, EVERY.replace("default: true", "default: fortress"))[0]
    assert fortress == harmonic.replace(DISTRIBUTIONS["harmonic"], DISTRIBUTIONS["fortress"])


NUMBERS = """robot: r
links: {base_link: {inertial: {mass: 1, of: collision}, collision: [{box: {size: [1, 1, 1]}, xyz: [0, 0, -3]}]}}
sensors:
  camera:
    type: depth_camera
    parent: base_link
    frame: camera
    with: {hfov: 90 deg, width: 320, height: 200, near: 10 cm, far: 8 m, rate: 15 Hz, noise: 0.01, topic: front}
  lidar: {type: lidar_2d, parent: base_link, frame: lidar, with: {rays: 5, fov: 180 deg, max_range: 12 m, rate: 5 Hz}}
  layers:
    type: lidar_3d
    parent: base_link
    frame: layers
    with: {rays: 4, layers: 16, vertical_fov: 30 deg, min_range: 20 cm, noise: 2 cm}
  imu: {type: imu, parent: base_link, frame: imu, with: {gyro_noise: 1 deg/s, accelerometer_noise: 0.1, rate: 200}}
outputs: {urdf: {file: r.urdf, gazebo: true}}
"""


def test_each_number_is_the_one_of_the_sensor(tmp_path):
    found = {name: values(one) for name, (one, _) in sensors(urdf(tmp_path, NUMBERS)[0]).items()}
    camera = {key.removeprefix("sensor/"): text for key, text in found["camera"].items()}
    assert camera["topic"] == "front"
    assert float(camera["update_rate"]) == 15
    assert float(camera["camera/horizontal_fov"]) == pytest.approx(np.pi / 2, rel=1e-12)
    assert (camera["camera/image/width"], camera["camera/image/height"]) == ("320", "200")
    assert (camera["camera/clip/near"], camera["camera/clip/far"]) == ("0.1", "8")
    assert (camera["camera/noise/type"], camera["camera/noise/stddev"]) == ("gaussian", "0.01")
    lidar, scan = found["lidar"], "sensor/lidar/scan/horizontal"
    assert (lidar[f"{scan}/samples"], lidar["sensor/update_rate"], lidar["sensor/topic"]) == ("5", "5", "lidar")
    assert float(lidar[f"{scan}/min_angle"]) == pytest.approx(-np.pi / 2)
    assert float(lidar[f"{scan}/max_angle"]) == pytest.approx(np.pi / 2)
    assert (lidar["sensor/lidar/range/min"], lidar["sensor/lidar/range/max"]) == ("0.05", "12")
    assert not any("noise" in key for key in lidar)
    layers = found["layers"]
    assert float(layers[f"{scan}/min_angle"]) == pytest.approx(-np.pi)  # a full circle has no ray twice
    assert float(layers[f"{scan}/max_angle"]) == pytest.approx(np.pi / 2)
    assert layers["sensor/lidar/scan/vertical/samples"] == "16"
    assert float(layers["sensor/lidar/scan/vertical/max_angle"]) == pytest.approx(np.radians(15))
    assert (layers["sensor/lidar/range/min"], layers["sensor/lidar/noise/stddev"]) == ("0.2", "0.02")
    imu = found["imu"]
    for axis in "xyz":
        assert float(imu[f"sensor/imu/angular_velocity/{axis}/noise/stddev"]) == pytest.approx(np.radians(1))
        assert imu[f"sensor/imu/linear_acceleration/{axis}/noise/stddev"] == "0.1"
    assert (imu["sensor/update_rate"], imu["sensor/imu/enable_orientation"]) == ("200", "false")


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
    text = NUMBERS[: NUMBERS.index("sensors:")] + "".join(["sensors:\n", *steps, outputs])
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


def test_types_and_sensors_of_your_own_say_it_in_words_of_sdf(tmp_path):
    text = """robot: r
links: {base_link: {inertial: {mass: 1, of: collision}, collision: [{box: {size: [1, 1, 1]}, xyz: [0, 0, -3]}]}}
sensor_types:
  compass:
    params: {rate: {type: frequency, default: 50 Hz}}
    gazebo:
      - sensor: magnetometer
        name: needle
        xyz: [10 mm, 0, 0]
        elements:
          update_rate: ${rate}
          always_on: true
          ignition_frame_id: <north>
          magnetometer: {x: {noise: {attributes: {type: gaussian}, mean: 0}}, y: }
          plugin: [{attributes: {name: a&b, filename: f}}, {attributes: {name: c, filename: g}, level: 2}]
parts:
  head:
    sensors:
      compass: {type: compass, parent: mount, frame: needle, with: {rate: 10}}
      camera: {type: camera, parent: mount, frame: eye, gazebo: []}
      thermal: {type: camera, parent: mount, frame: warm, gazebo: [{sensor: thermal_camera, frame: optical}]}
use: {left: {part: head, parent: base_link}, right: {part: head, parent: base_link}}
outputs: {urdf: {file: r.urdf, gazebo: true}}
"""
    made, _ = urdf(tmp_path, text)
    found = sensors(made)
    assert set(found) == {f"{side}_{name}" for side in ("left", "right") for name in ("compass_needle", "thermal")}
    compass, where = found["left_compass_needle"]
    assert (compass.get("type"), where, compass.findtext("pose")) == ("magnetometer", "left_needle", "0.01 0 0 0 0 0")
    assert [one.tag for one in compass] == [
        *("pose", "update_rate", "always_on", "ignition_frame_id", "magnetometer", "plugin", "plugin")
    ]
    assert (compass.findtext("always_on"), compass.findtext("ignition_frame_id")) == ("true", "<north>")
    assert compass.find("magnetometer/x/noise").get("type") == "gaussian"
    assert [one.get("name") for one in compass.findall("plugin")] == ["a&b", "c"]
    thermal, where = found["right_thermal"]
    assert (where, thermal.findtext("gz_frame_id")) == ("right_warm", "right_warm_optical")


MERGED = """robot: r
links:
  footprint: {}
  base: {inertial: {mass: 100, of: collision}, collision: [{box: {size: [1, 1, 1]}}, {name: deck, sphere: {radius: 1}}]}
  arm: {inertial: {mass: 1, of: collision}, collision: [{box: {size: [1, 1, 1]}}]}
joints:
  up: {type: fixed, parent: footprint, child: base}
  turn: {type: continuous, parent: base, child: arm, axis: [0, 0, 1]}
sensors:
  bump: {type: contact, parent: base, frame: bump}
  feel: {type: contact, parent: arm, frame: feel, with: {surface: parent}}
outputs: {urdf: {file: r.urdf, gazebo: true}}
"""


def test_a_contact_names_the_shapes_as_gazebo_does(tmp_path):
    found = sensors(urdf(tmp_path, MERGED)[0])
    assert [one.text for one in found["bump"][0].iter("collision")] == [
        "footprint_fixed_joint_lump__base_collision", "footprint_fixed_joint_lump__deck_collision_1"
    ]  # fmt: skip
    assert [one.text for one in found["feel"][0].iter("collision")] == ["arm_collision"]
    kept = '<gazebo reference="up"><preserveFixedJoint>true</preserveFixedJoint></gazebo>'
    text = MERGED.replace("footprint: {}", "footprint: {inertial: {mass: 1, density: 1, of: [{sphere: {radius: 1}}]}}")
    text = text.replace("mass: 1, density: 1,", "mass: 1,") + f"urdf_elements: ['{kept}']\n"
    found = sensors(urdf(tmp_path, text)[0])
    assert [one.text for one in found["bump"][0].iter("collision")] == [
        "base_collision", "base_fixed_joint_lump__deck_collision_1"
    ]  # fmt: skip


UNSEEN = [
    ("elements", EVERY.replace("[inertial, visual, collision]", "[collision]"), 1,
     'Gazebo does not see sensors "camera", "depth_camera", "lidar_2d" and 8 more: '
     "it drops links without mass, and no link of this URDF has one"),
    ("no mass", NUMBERS.replace("mass: 1, of: collision", "mass: 1.0e-9, of: collision"), 0, ""),
    ("moves", MERGED.replace("feel: {type: contact, parent: arm, frame: feel, with: {surface: parent}}",
                             "feel: {type: imu, parent: arm, frame: feel}")
     .replace("arm: {inertial: {mass: 1, of: collision}, ", "arm: {"), 1,
     'Gazebo does not see sensor "feel": it drops link "arm", which has no mass in this URDF'),
    ("no shape", MERGED.replace("{type: contact, parent: base, frame: bump}",
                                "{type: contact, parent: base, frame: bump, with: {surface: sensor}}"), 1,
     'Gazebo does not see sensor "bump": link "bump" has no shape in this URDF that could feel'),
    ("not in the urdf", MERGED.replace("{type: contact, parent: base, frame: bump}",
     "{type: contact, parent: base, frame: bump, with: {surface: sensor}, publisher: {none: why}}"), 1,
     'Gazebo does not see sensor "bump": the URDF has no link "bump"'),
    ("nothing on it", EVERY.replace("fixed, parent: force_torque", "fixed, parent: imu"), 1,
     'Gazebo does not see sensor "force_torque": it drops link "force_torque", which has no mass in this URDF'),
]  # fmt: skip


@pytest.mark.parametrize(("text", "count", "first"), [case[1:] for case in UNSEEN], ids=[case[0] for case in UNSEEN])
def test_what_gazebo_cannot_see_is_told(tmp_path, text, count, first):
    made, said = urdf(tmp_path, text, quiet=False)
    said = [one for one in said if "does not see" in one]
    assert len(said) == count
    assert not first or said[0] == first
    names = {name for one in said for name in one.split(": ")[0].split('"')[1::2]}
    assert not names & set(sensors(made))


def test_readers_of_urdf_pass_over_it(tmp_path):
    pinocchio = pytest.importorskip("pinocchio")
    yourdfpy = pytest.importorskip("yourdfpy")
    mujoco = pytest.importorskip("mujoco")
    text, _ = urdf(tmp_path, EVERY)
    path = tmp_path / "r.urdf"
    path.write_text(text, "utf-8")
    assert pinocchio.buildModelFromUrdf(str(path)).nq == 0
    assert set(yourdfpy.URDF.load(str(path)).link_map) == {one.get("name") for one in ET.fromstring(text).iter("link")}
    fused = text.replace("</robot>", '<mujoco><compiler fusestatic="false"/></mujoco></robot>')
    assert mujoco.MjModel.from_xml_string(fused).nbody > 5


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
