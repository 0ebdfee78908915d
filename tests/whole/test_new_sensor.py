"""A sensor added through YAML only reaches every artifact that its publisher says."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from rosorin_compile.cli.main import main
from support.engines import MuJoCo, Pinocchio, StaticTf, pose
from support.paths import OUTPUTS
from support.robots import compiled, copy_of_rosorin, texts

REAR = """
sensors:
  rear_range:
    type: range_finder
    parent: base_link
    frame: rear_range
    xyz: [-140 mm, 0, 30 mm]
    rpy: [0, 0, 180 deg]
    publisher: {static_transform_publisher: tf_base_rear_range}
"""
CAMERA = """
sensors:
  rear_camera:
    type: camera
    parent: base_link
    frame: rear_camera
    xyz: [-0.12, 0, 0.2]
    rpy: [0, 10 deg, 180 deg]
    optical: {frame: rear_camera_optical_frame}
"""
OPTICAL = np.array([[0, 0, 1], [-1, 0, 0], [0, -1, 0]])  # REP 103: x right, y down, z forward


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    copy_of_rosorin(tmp_path)
    monkeypatch.chdir(tmp_path)
    assert main(["all"]) == 0
    return tmp_path


def add(folder: Path, sensor: str) -> dict[str, str]:
    """Add a file with a sensor to the description, through YAML only, and compile it."""
    description = folder / "descriptions" / "rosorin"
    (description / "rear.yaml").write_text(sensor, "utf-8")
    root = description / "robot.yaml"
    text = root.read_text("utf-8").replace("  - simulation.yaml", "  - simulation.yaml\n  - rear.yaml")
    root.write_text(text, "utf-8")
    return texts(compiled(root))


def test_range_finder_reaches_static_tf_mjcf_and_frames(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    files = add(folder, REAR)
    expected = pose([-0.14, 0, 0.03], [0, 0, np.pi])
    for reader in (
        StaticTf.from_launch(files["static_tf.launch.py"]),
        StaticTf.from_json(files["static_tf.json"]),
        MuJoCo(files["rosorin.xml"], "site"),
        MuJoCo(files["rosorin.xml"], "body"),
    ):
        assert np.abs(reader.frames({})["rear_range"] - expected).max() < 1e-8
    assert "tf_base_rear_range" in files["frames.md"]
    before = {path.name: path.read_text("utf-8") for path in OUTPUTS.iterdir()}
    assert {name for name in files if files[name] != before[name]} == {
        "static_tf.launch.py",
        "static_tf.json",
        "rosorin.xml",
        "frames.md",
        "frames_amcl.svg",
        "frames_slam.svg",
    }
    assert main(["check"]) == 1
    shown = capsys.readouterr().out
    assert "rear_range" in shown
    assert main(["all"]) == 0
    assert main(["check"]) == 0


def test_second_camera_with_its_optical_frame_reaches_urdf_and_mjcf(folder: Path) -> None:
    files = add(folder, CAMERA)
    mount = pose([-0.12, 0, 0.2], [0, np.radians(10), np.pi])
    optical = mount.copy()
    optical[:3, :3] = mount[:3, :3] @ OPTICAL
    for reader in (Pinocchio(files["rosorin.urdf"]), MuJoCo(files["rosorin.xml"])):
        frames = reader.frames({})
        assert np.abs(frames["rear_camera"] - mount).max() < 2e-6
        assert np.abs(frames["rear_camera_optical_frame"] - optical).max() < 2e-6
    assert "rear_camera_optical_frame" in files["frames.md"]
    assert "rear_camera" not in files["static_tf.launch.py"]
    assert "rear_camera" not in json.loads(files["robot_model.json"])["joints"]
