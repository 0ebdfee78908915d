"""Sensors on links that are there: the same artifacts as those of a sensor that brings its frame; what Gazebo has."""

from __future__ import annotations

from pathlib import Path
from xml.etree import ElementTree

import pytest

from rosorin_compile.formats.compilation import compile_robot
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
    mujoco = pytest.importorskip("mujoco", minversion="3.12")
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
