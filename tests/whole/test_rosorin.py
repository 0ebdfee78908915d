"""The reference robot: what was recorded on the real one comes out of every artifact, and all engines agree."""

import math
import xml.etree.ElementTree as ElementTree
from pathlib import Path

import numpy as np
import pytest

from rosorin_compile.cli.main import main
from support.engines import Frames, MuJoCo, Pinocchio, RobotModel, StaticTf, Yourdfpy, pose
from support.paths import DATA, OUTPUTS, data_text
from support.robots import RECORDED, compiled, copy_of_rosorin, texts
from support.unrounded import compile_unrounded

STATES = 200
ARM = ("joint1", "joint2", "joint3", "joint4", "joint5")
URDF_LINKS = {
    "base_link",
    *(f"link{n}" for n in range(1, 6)),
    *("gripper_link", "end_effector_link", "camera_link0", "camera_link", "depth_camera_link"),
}
LAUNCH = {"laser", "imu_link"}
SIMULATED = {"base_footprint", "l_link", "r_link", "l_in_link", "l_out_link", "r_in_link", "r_out_link"}
HALF_DIGIT = 5.0e-4  # tf2_echo prints three decimals


def engines(files: dict[str, str], folder: Path) -> dict[str, object]:
    urdf = folder / "rosorin.urdf"
    urdf.write_text(files["rosorin.urdf"], "utf-8")
    return {
        "pinocchio": Pinocchio(files["rosorin.urdf"]),
        "yourdfpy": Yourdfpy(urdf),
        "mujoco sites": MuJoCo(files["rosorin.xml"], "site"),
        "mujoco bodies": MuJoCo(files["rosorin.xml"], "body"),
        "robot_model": RobotModel(files["robot_model.json"], {"lidar_frame": "laser"}),
        "launch file": StaticTf.from_launch(files["static_tf.launch.py"]),
        "static_tf.json": StaticTf.from_json(files["static_tf.json"]),
    }


def states(count: int) -> list[dict[str, float]]:
    random = np.random.default_rng(20260927)
    return [dict(zip(ARM, random.uniform(-2.09, 2.09, len(ARM)), strict=True)) for _ in range(count)]


def disagreement(readers: dict[str, object], count: int) -> dict[tuple[str, str, str], float]:
    """Return the largest difference of any pose entry for each pair of engines and each frame that both know."""
    worst: dict[tuple[str, str, str], float] = {}
    for positions in states(count):
        found: dict[str, Frames] = {name: reader.frames(positions) for name, reader in readers.items()}
        names = list(found)
        for index, first in enumerate(names):
            for second in names[index + 1 :]:
                for frame in found[first].keys() & found[second].keys():
                    key = (first, second, frame)
                    off = float(np.abs(found[first][frame] - found[second][frame]).max())
                    worst[key] = max(worst.get(key, 0.0), off)
    return worst


def test_all_engines_agree_within_what_was_printed(tmp_path: Path) -> None:
    worst = disagreement(engines(texts(compiled()), tmp_path), STATES)
    covered = {frame for *_, frame in worst}
    assert covered - set(compiled().robot.simulated_frames) == URDF_LINKS | LAUNCH | SIMULATED
    assert max(worst.values()) < 2e-6, max(worst.items(), key=lambda item: item[1])


def test_all_engines_agree_exactly_with_exact_numbers(tmp_path: Path) -> None:
    path = copy_of_rosorin(tmp_path, {"robot.yaml": ("number_format: six", "number_format: exact")})
    readers = engines(texts(compiled(path, by=compile_unrounded)), tmp_path)
    for name in ("launch file", "static_tf.json"):
        del readers[name]
    worst = disagreement(readers, STATES)
    assert {frame for *_, frame in worst} >= URDF_LINKS | {"laser"}
    assert max(worst.values()) < 1e-12, max(worst.items(), key=lambda item: item[1])


@pytest.mark.parametrize("check", RECORDED["tf"], ids=lambda c: f"{c['from']}-{c['to']}")
@pytest.mark.parametrize("base", ["fixed", "free"])
def test_what_was_recorded_on_the_robot(check: dict, base: str, tmp_path: Path) -> None:
    pose = dict(zip(ARM, RECORDED["tuck"]["positions_rad"], strict=True)) if check.get("pose") else {}
    seen = []
    for name, reader in engines(texts(compiled(arguments={"base": base})), tmp_path).items():
        frames = reader.frames(pose)
        if check["from"] not in frames or check["to"] not in frames:
            continue
        seen.append(name)
        found = np.linalg.inv(frames[check["from"]]) @ frames[check["to"]]
        assert np.abs(found[:3, 3] - check["translation"]).max() <= HALF_DIGIT, (name, found[:3, 3])
        if "rpy_deg" in check:
            rpy = _rpy_degrees(found)
            off = (np.array(rpy) - check["rpy_deg"] + 180) % 360 - 180
            assert np.abs(off).max() <= HALF_DIGIT, (name, rpy)
    assert any(name.startswith("mujoco") for name in seen)
    expected_urdf = check["to"] not in LAUNCH and check["from"] == "base_link"
    assert ("pinocchio" in seen) == expected_urdf


def _rpy_degrees(placed: np.ndarray) -> list[float]:
    r = placed[:3, :3]
    angles = (
        math.atan2(r[2, 1], r[2, 2]),
        math.atan2(-r[2, 0], math.hypot(r[2, 1], r[2, 2])),
        math.atan2(r[1, 0], r[0, 0]),
    )
    return [math.degrees(angle) for angle in angles]


def test_tuck_pose_is_what_the_driver_reported() -> None:
    robot = compiled().robot
    (tuck,) = [pose for pose in robot.poses if pose.name == "tuck"]
    assert dict(tuck.pulses) == RECORDED["tuck"]["pulses"]
    assert [tuck.positions[joint] for joint in ARM] == RECORDED["tuck"]["positions_rad"]


def test_urdf_is_that_of_the_guide() -> None:
    """Element by element and number by number as printed; only white space and the spelling of 1.0 are free."""
    ours = ElementTree.fromstring(texts(compiled())["rosorin.urdf"])
    guide = ElementTree.parse(DATA / "guide_rosorin.urdf").getroot()
    assert _elements(ours) == _elements(guide)


def _elements(node: ElementTree.Element) -> tuple:
    attributes = {key: value.replace("1.0", "1") if value == "1.0" else value for key, value in node.attrib.items()}
    return node.tag, attributes, [_elements(child) for child in node]


def test_every_entry_says_where_it_comes_from() -> None:
    robot = compiled().robot
    entries = [*robot.links, *robot.joints, *robot.sensors, *robot.servos, *robot.poses]
    assert [entry.name for entry in entries if not entry.source.status] == []


# A sensor added through YAML only reaches every artifact that its publisher says.


REAR = data_text("robots/rosorin_rear.yaml")


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    copy_of_rosorin(tmp_path)
    monkeypatch.chdir(tmp_path)
    assert main(["all"]) == 0
    return tmp_path


def add(folder: Path, sensor: str) -> dict[str, str]:
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
