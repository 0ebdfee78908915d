"""Sensors on links that are there: the same artifacts as those of a sensor that brings its frame; what Gazebo has."""

from __future__ import annotations

from pathlib import Path
from xml.etree import ElementTree

import pytest

from rosorin_compile.formats.compiled import compile_robot
from rosorin_compile.source.diagnostics import has_errors
from rosorin_compile.source.load import load_mapping
from support.paths import ROOT

TYPES = sorted(load_mapping(ROOT / "parts" / "sensors.yaml", "sensors.yaml")["sensor_types"])
OUTPUTS = """outputs:
  urdf: {file: r.urdf, gazebo: true}
  mjcf: {file: r.xml}
  sdf: {file: r.sdf, gazebo: true}
  frames: {file: frames.md}
"""
BODY = "{inertial: {mass: 1, of: collision}, collision: [{box: {size: [0.2, 0.2, 0.1]}}]}"


def texts(folder: Path, text: str, **arguments: object) -> dict[str, str]:
    """Return the artifacts of a description by file."""
    folder.mkdir(exist_ok=True)
    (folder / "robot.yaml").write_text(text, "utf-8")
    made = compile_robot(folder / "robot.yaml", arguments)
    assert not has_errors(made.diagnostics), [one.message for one in made.diagnostics]
    return {one.file: one.text for one in made.artifacts}


@pytest.mark.parametrize("kind", TYPES)
def test_a_sensor_on_a_link_is_as_one_that_brings_it(tmp_path: Path, kind: str) -> None:
    image = "camera" in kind
    links = f"links:\n  base_link: {BODY}\n  eye: {BODY}\n"
    tool = "  tool: {type: fixed, parent: eye, child: tool, xyz: [0, 0, 0.1]}\n" if kind == "force_torque" else ""
    links += f"  tool: {BODY}\n" if tool else ""
    brings = f"robot: r\n{links}" + (f"joints:\n{tool}" if tool else "")
    brings += (
        f"sensors:\n  s: {{type: {kind}, parent: base_link, frame: eye, xyz: [0.1, 0, 0.2], rpy: [0, 10 deg, 0]}}\n"
    )
    optical = "  eye_optical_joint: {type: fixed, parent: eye, child: eye_optical, rpy: [-90 deg, 0, -90 deg]}\n"
    there = f"robot: r\n{links}" + ("  eye_optical: {}\n" if image else "") + f"joints:\n{tool}"
    there += "  eye_joint: {type: fixed, parent: base_link, child: eye, xyz: [0.1, 0, 0.2], rpy: [0, 10 deg, 0]}\n"
    there += (optical if image else "") + f"sensors:\n  s: {{type: {kind}, frame: eye}}\n"
    if kind == "contact":  # by default it feels with what it sits on, which is here the link itself
        brings = brings.replace("rpy: [0, 10 deg, 0]}", "rpy: [0, 10 deg, 0], with: {surface: sensor}}")
    assert texts(tmp_path / "there", there + OUTPUTS) == texts(tmp_path / "brings", brings + OUTPUTS)


CAMERA = f"""robot: r
links: {{base_link: {BODY}, eye: {{}}, image: {{}}}}
joints:
  eye_joint: {{type: fixed, parent: base_link, child: eye, xyz: [0.1, 0, 0.2], rpy: [0, 10 deg, 20 deg]}}
  image_joint: {{type: fixed, parent: eye, child: image, rpy: [-90 deg, 0, -90 deg]}}
sensors:
  with: {{type: camera, frame: eye, optical: {{frame: image}}}}
  without: {{type: camera, frame: eye, optical: false}}
"""


def test_a_camera_without_an_optical_frame_looks_as_one_with_it(tmp_path: Path) -> None:
    mujoco = pytest.importorskip("mujoco", minversion="4")
    made = texts(tmp_path / "r", CAMERA + OUTPUTS)
    model = mujoco.MjModel.from_xml_string(made["r.xml"])
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    one, other = data.camera("with"), data.camera("without")
    assert one.xpos == pytest.approx(other.xpos, abs=1e-12)
    assert one.xmat == pytest.approx(other.xmat, abs=1e-12)
    cameras = {one.get("name"): one for one in ElementTree.fromstring(made["r.urdf"]).iter("sensor")}
    assert [cameras[name].find("pose") for name in ("with", "without")] == [None, None]
    assert [cameras[name].findtext("gz_frame_id") for name in ("with", "without")] == ["image", "eye"]
    assert "eye_optical" not in "".join(made.values())


IN_A_PART = f"""robot: r
links: {{base_link: {BODY}}}
parts:
  head:
    links: {{eye: {{}}}}
    joints: {{eye: {{type: fixed, parent: mount, child: eye, xyz: [0.1, 0.05, 0]}}}}
    sensors:
      lidar: {{type: lidar_2d, frame: eye, stamps: [eye]}}
      imu: {{type: imu, frame: eye}}
use:
  left: {{part: head, parent: base_link, xyz: [0, 0.2, 0]}}
  right: {{part: head, parent: base_link, xyz: [0, -0.2, 0], mirror: y}}
"""


def test_in_a_part_it_gets_the_prefix(tmp_path: Path) -> None:
    made = texts(tmp_path / "r", IN_A_PART + OUTPUTS)
    blocks = ElementTree.fromstring(made["r.urdf"]).iter("gazebo")
    found = {
        (block.get("reference"), one.get("name"), one.findtext("gz_frame_id")) for block in blocks for one in block
    }
    sides = ("left", "right")
    assert found == {(f"{side}_eye", f"{side}_{name}", f"{side}_eye") for side in sides for name in ("lidar", "imu")}


def test_several_sensors_may_sit_on_a_frame_that_one_of_them_brings(tmp_path: Path) -> None:
    text = f"robot: r\nlinks: {{base_link: {BODY}}}\nsensors:\n"
    text += (
        "  imu: {type: imu, frame: eye}\n  lidar: {type: lidar_2d, parent: base_link, frame: eye, xyz: [0, 0, 0.1]}\n"
    )
    urdf = ElementTree.fromstring(texts(tmp_path / "r", text + OUTPUTS)["r.urdf"])
    assert [(one.get("reference"), one[0].get("name")) for one in urdf.iter("gazebo")] == [
        ("eye", "imu"),
        ("eye", "lidar"),
    ]


CHANGED = f"""robot: r
args: {{gazebo: {{default: true}}}}
links: {{base_link: {BODY}}}
sensors:
  lidar:
    type: lidar_2d
    frame: base_link
    with: {{rays: 5, fov: 180 deg, rate: 5}}
    gazebo:
      xyz: [0, 0, 1 cm]
      elements:
        always_on: true
        topic: null
        lidar: {{scan: {{horizontal: {{resolution: 2}}}}, range: {{min: null, resolution: 15 mm}}}}
        plugin: [{{attributes: {{name: a, filename: b.so}}, text: "007"}}, {{attributes: {{name: c}}}}]
outputs: {{urdf: {{file: r.urdf, gazebo: "${{gazebo}}"}}}}
"""
LIDAR = """\
    <sensor name="lidar" type="TYPE">
      <pose>0 0 0.01 0 0 0</pose>
      <update_rate>5</update_rate>
      <TAG>
        <scan>
          <horizontal>
            <samples>5</samples>
            <resolution>2</resolution>
            <min_angle>-1.570796326795</min_angle>
            <max_angle>1.570796326795</max_angle>
          </horizontal>
        </scan>
        <range>
          <max>100</max>
          <resolution>0.015</resolution>
        </range>
      </TAG>
      <always_on>true</always_on>
      <plugin name="a" filename="b.so">
        <text>007</text>
      </plugin>
      <plugin name="c"/>
    </sensor>
"""


@pytest.mark.parametrize(
    ("gazebo", "kind", "tag", "frame"),
    [
        ("classic", "ray", "ray", ""),
        ("fortress", "gpu_lidar", "lidar", "      <ignition_frame_id>base_link</ignition_frame_id>\n"),
        ("harmonic", "gpu_lidar", "lidar", "      <gz_frame_id>base_link</gz_frame_id>\n"),
    ],
)
def test_a_mapping_changes_what_a_type_brings(tmp_path: Path, gazebo: str, kind: str, tag: str, frame: str) -> None:
    urdf = texts(tmp_path / "r", CHANGED, gazebo=gazebo)["r.urdf"]
    wanted = LIDAR.replace("TYPE", kind).replace("TAG", tag).replace("</pose>\n", f"</pose>\n{frame}")
    assert wanted in urdf


def test_a_frame_of_messages_can_be_left_out(tmp_path: Path) -> None:
    text = CHANGED.replace("topic: null", "gz_frame_id: null")
    assert "frame_id" not in texts(tmp_path / "r", text, gazebo="harmonic")["r.urdf"]


def test_limits_may_stay_those_of_the_urdf(tmp_path: Path) -> None:
    text = """robot: r
args: {limits: {default: true}}
links: {base: {}, arm: {}}
joints:
  turn:
    {type: revolute, parent: base, child: arm, axis: [0, 0, 1], limit: {lower: -1, upper: 1, effort: 1, velocity: 1}}
control: {motor: {plugin: a/B, joints: {turn: {command: position, state: position, limits: "${limits}"}}}}
outputs: {urdf: {file: r.urdf, control: jazzy}}
"""

    def joint(limits: object) -> str:
        urdf = texts(tmp_path / "r", text, limits=limits)["r.urdf"]
        return urdf.partition("</hardware>")[2].partition("</joint>")[0]

    assert '<param name="min">-1</param>' in joint(True)
    assert '<limits enable="false"/>' in joint(False)
    assert "min" not in joint(False)
    assert "min" not in joint("urdf")
    assert "limits" not in joint("urdf")
