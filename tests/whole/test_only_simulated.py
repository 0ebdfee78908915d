"""What only simulations have is no frame: ``publisher: {simulation: WHY}``, and what hangs there unpublished."""

import json
from pathlib import Path

import pytest

from rosorin_compile.formats.compilation import Compiled
from rosorin_compile.model import Robot
from support.paths import data_text
from support.robots import compiled_text, sound, texts

LINKS = data_text("robots/only_simulated_links.yaml")
OUTPUTS = """outputs:
  urdf: {file: r.urdf}
  sim: {backend: urdf, file: sim.urdf, frames: bodies}
  mjcf: {file: r.xml}
  frames: {file: frames.md}
  picture: {backend: frames_picture, file: frames.svg}
  robot_model: {file: model.json}
"""
SIMULATED = LINKS.replace("KIND", "simulation") + OUTPUTS
UNPUBLISHED = LINKS.replace("KIND", "none") + OUTPUTS


def made(folder: Path, text: str) -> tuple[Robot, dict[str, str], Compiled]:
    robot, _, compiled = sound(compiled_text(folder, text))
    return robot, texts(compiled), compiled


def test_the_model_knows_what_it_is_and_why(tmp_path: Path) -> None:
    robot, _, _ = made(tmp_path, SIMULATED)
    assert dict(robot.simulated_frames) == {"roller": "it rolls | so", "tip": "it rolls | so"}
    assert robot.frames == ["base_link", "hub"]
    assert made(tmp_path, UNPUBLISHED)[0].simulated_frames == {}


def test_simulators_have_it_and_drivers_do_not(tmp_path: Path) -> None:
    _, files, _ = made(tmp_path, SIMULATED)
    for file, there in (("r.urdf", False), ("sim.urdf", True), ("r.xml", True), ("model.json", False)):
        assert ('"roller"' in files[file]) == there, file
    assert list(json.loads(files["model.json"])["joints"]) == ["axle"]
    asked = SIMULATED.replace("{file: model.json}", "{file: model.json, joints: [spin]}")
    assert list(json.loads(made(tmp_path, asked)[1]["model.json"])["joints"]) == ["spin"]
    assert list(json.loads(made(tmp_path, UNPUBLISHED)[1]["model.json"])["joints"]) == ["axle", "spin", "end"]


def test_a_sensor_of_a_simulation_stamps_no_message(tmp_path: Path) -> None:
    given = "publisher: {simulation: the truth}, with: {rays: 9, max_range: 3}"
    lidar = f"{{type: lidar_2d, parent: PARENT, frame: truth, {given}}}"
    for parent in ("roller", "base_link"):
        sensors = f"sensors: {{lidar: {lidar.replace('PARENT', parent)}}}\n"
        robot, files, compiled = made(tmp_path, SIMULATED + sensors)
        assert robot.sensors[0].stamps == ()
        assert robot.simulated_frames["truth"] == "the truth"
        assert [one for one in compiled.diagnostics if one.rule == "unknown-frame-id"] == []
        assert "Only simulations have" in files["frames.md"]
        assert "and truth (the truth)" in files["frames.md"] if parent == "roller" else "truth" in files["frames.md"]


@pytest.mark.parametrize(
    ("old", "new", "rule"),
    [
        (", publisher: {none: nobody asks}", "", "split-urdf"),
        ("{none: nobody asks}", "{static_transform_publisher: tf_tip}", "split-tf"),
        ("{simulation: it rolls | so}", "{simulation: a, none: b}", "wrong-value"),
        ("{simulation: it rolls | so}", "{simulation: ''}", "empty-text"),
        ("{simulation: it rolls | so}", "{simulation: 3}", "wrong-type"),
        ("{simulation: it rolls | so}", "[{by: {simulation: a}}]", "unknown-key"),
    ],
)
def test_what_makes_no_sense_is_told(tmp_path: Path, old: str, new: str, rule: str) -> None:
    assert old in SIMULATED
    made = compiled_text(tmp_path, SIMULATED.replace(old, new))
    assert rule in {one.rule for one in made.diagnostics}
