"""What only simulations have is no frame: ``publisher: {simulation: WHY}``, and what hangs there unpublished."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from rosorin_compile.cli.main import main
from rosorin_compile.formats.compiled import Compiled
from rosorin_compile.formats.frames import publishing
from rosorin_compile.model import Robot
from support.commands import Shown
from support.robots import compiled_text, sound, texts

LINKS = """robot: r
links:
  base_link: {}
  hub: {inertial: {mass: 1, of: collision}, collision: [{sphere: {radius: 0.1}}]}
  roller: {inertial: {mass: 0.1, of: collision}, collision: [{sphere: {radius: 0.02}}]}
  tip: {inertial: {mass: 0.2, of: [{sphere: {radius: 0.01}}]}}
joints:
  axle: {type: continuous, parent: base_link, child: hub, axis: [0, 1, 0]}
  spin:
    {type: continuous, parent: hub, child: roller, xyz: [0.2, 0, 0], axis: [0, 0, 1], publisher: {KIND: it rolls | so}}
  end: {type: fixed, parent: roller, child: tip, xyz: [0.1, 0, 0], publisher: {none: nobody asks}}
"""
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


def test_lists_of_frames_say_it_in_a_sentence_alone(tmp_path: Path) -> None:
    robot, files, _ = made(tmp_path, SIMULATED)
    page = files["frames.md"]
    assert "\nOnly simulations have roller, tip (it rolls \\| so).\n" in page
    assert "| roller " not in page
    assert "Checked: one frame has one parent" in page
    assert "roller" not in publishing(robot).in_words()
    assert "roller" not in files["frames.svg"]
    assert ">tip<" not in files["frames.svg"]
    without = made(tmp_path, UNPUBLISHED)[1]
    assert "Only simulations" not in without["frames.md"]
    assert "| roller " in without["frames.md"]
    assert "roller" in without["frames.svg"]


def test_simulators_have_it_and_drivers_do_not(tmp_path: Path) -> None:
    _, files, _ = made(tmp_path, SIMULATED)
    for file, there in (("r.urdf", False), ("sim.urdf", True), ("r.xml", True), ("model.json", False)):
        assert ('"roller"' in files[file]) == there, file
    assert list(json.loads(files["model.json"])["joints"]) == ["axle"]
    asked = SIMULATED.replace("{file: model.json}", "{file: model.json, joints: [spin]}")
    assert list(json.loads(made(tmp_path, asked)[1]["model.json"])["joints"]) == ["spin"]
    assert list(json.loads(made(tmp_path, UNPUBLISHED)[1]["model.json"])["joints"]) == ["axle", "spin", "end"]


def test_the_urdf_misses_only_what_is_a_frame(tmp_path: Path) -> None:
    def missed(text: str) -> str:
        said = [one.message for one in made(tmp_path, text)[2].diagnostics if one.rule == "urdf-cannot-say"]
        return "\n".join(said)

    assert "roller (collision)" in missed(UNPUBLISHED)
    assert "roller (collision)" not in missed(SIMULATED)
    assert "mass" in missed(SIMULATED)  # which rides along at zero


def test_frames_answers_for_the_robot(home: Path, capsys: Shown) -> None:
    (home / "r.yaml").write_text(SIMULATED)
    assert main(["frames", "r.yaml"]) == 0
    assert "roller" not in capsys.readouterr().out
    assert main(["frames", "r.yaml", "--format", "json"]) == 0
    assert "roller" not in capsys.readouterr().out
    assert main(["frames", "r.yaml", "--frame", "roller"]) == 2
    assert 'there is no frame "roller"' in capsys.readouterr().err
    assert main(["tf", "r.yaml", "base_link", "tip"]) == 0  # geometry is known of every link
    assert "0.3" in capsys.readouterr().out


def test_explain_and_diff_say_it(home: Path, capsys: Shown) -> None:
    (home / "a.yaml").write_text(SIMULATED)
    (home / "b.yaml").write_text(UNPUBLISHED)
    assert main(["explain", "a.yaml", "roller"]) == 0
    assert "hub -> roller: spin, continuous, of simulations alone: it rolls | so" in capsys.readouterr().out
    assert main(["diff", "a.yaml", "b.yaml"]) == 1
    assert 'roller: published by simulations -> "nobody: it rolls | so"' in capsys.readouterr().out


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
