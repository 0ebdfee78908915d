"""A sensor that sees nothing but its robot is told, and MuJoCo reads the same; one that looks out is left alone."""

from __future__ import annotations

from pathlib import Path

import pytest

from support.paths import ROOT
from support.robots import compiled_text

HEAD = "robot: r\noutputs: {mjcf: {file: r.xml}}\n"
BOX = "base_link: {collision: [{box: {size: [400 mm, 300 mm, 200 mm]}}], inertial: {mass: 1, of: collision}}"
ROD = "{collision: [{cylinder: {radius: 40 mm, length: 50 mm}}]}"
PLATE = "plate: {visual: [{box: {size: [2 mm, 300 mm, 300 mm]}}]}"
MAP = "{origin: [-0.1, -0.1], cell: 0.1, heights: [[0.2, 0.2], [0.2, 0.2]]}"


def robot(sensor: str, links: str = BOX, joints: str = "") -> str:
    """Return a description with one sensor."""
    return f"links: {{{links}}}\njoints: {{{joints}}}\nsensors: {{s: {{{sensor}}}}}\n"


def told(text: str, folder: Path) -> list[str]:
    """Return what is said of sensors that see their robot."""
    made = compiled_text(folder, HEAD + text)
    assert made.robot is not None, made.diagnostics
    return [one.message for one in made.diagnostics if one.rule == "sensor-sees-itself"]


CAMERA = "type: camera, parent: base_link, frame: c, xyz: [200 mm, 0, 0]"
LIDAR = "type: lidar_2d, parent: base_link, frame: l"
OUTSIDE = {
    "on the deck": robot(f"{LIDAR}, xyz: [0, 0, 110 mm]"),
    "in a front face": robot(CAMERA),
    "half of its view free": robot(f"{LIDAR}, xyz: [210 mm, 0, 0]"),
    "in its own housing": robot(f"{LIDAR}, xyz: [0, 0, 150 mm]", f"{BOX}, l: {ROD}"),
    "in the housing of its maker": robot(
        "type: lidar_2d, parent: mount, frame: l",
        f"{BOX}, mount: {ROD}, plug: {{}}",
        "up: {type: fixed, parent: base_link, child: mount, xyz: [0, 0, 150 mm]},"
        " side: {type: fixed, parent: mount, child: plug}",
    ),
    "a plate that slides away": robot(
        CAMERA,
        f"{BOX}, {PLATE}",
        "j: {type: prismatic, parent: base_link, child: plate, xyz: [220 mm, 0, 0], axis: [0, 1, 0],"
        " limit: {lower: 0, upper: 0.4, effort: 1, velocity: 1}}",
    ),
    "an imu in the body": robot("type: imu, parent: base_link, frame: i"),
}


@pytest.mark.parametrize("name", OUTSIDE)
def test_what_looks_out_is_left_alone(name: str, tmp_path: Path) -> None:
    assert told(OUTSIDE[name], tmp_path) == []


INSIDE = {
    "a lidar": robot(LIDAR),
    "one ray": robot("type: range_finder, parent: base_link, frame: l, xyz: [199 mm, 0, 0]"),
    "in a map of heights": robot(
        "type: lidar_3d, parent: base_link, frame: l, xyz: [0.05, 0, 0.1], with: {vertical_fov: 10 deg}",
        f"base_link: {{collision: [{{height_map: {MAP}}}]}}",
    ),
    "a camera behind a plate": robot(
        CAMERA, f"{BOX}, {PLATE}", "j: {type: fixed, parent: base_link, child: plate, xyz: [220 mm, 0, 0]}"
    ),
}


@pytest.mark.parametrize("name", INSIDE)
def test_what_sees_nothing_else_is_told_once(name: str, tmp_path: Path) -> None:
    (said,) = told(INSIDE[name], tmp_path)
    assert said.startswith("all rays of ")


def test_it_may_be_accepted(tmp_path: Path) -> None:
    for name in ("l", "l_joint"):
        entry = f"accept: [{{rule: sensor-sees-itself, of: [{name}], reason: a dummy}}]\n"
        assert told(entry + INSIDE["a lidar"], tmp_path) == []


def test_the_lidar_of_the_reference_robot_sees() -> None:
    """With the stand-in of its chassis, by MuJoCo: in all directions but that of the tower behind it."""
    mujoco = pytest.importorskip("mujoco")
    model = mujoco.MjModel.from_xml_path(str(ROOT / "outputs/rosorin/rosorin.xml"))
    data = mujoco.MjData(model)
    mujoco.mj_step(model, data)
    names = [model.sensor(index).name for index in range(model.nsensor)]
    beams = [data.sensor(name).data[0] for name in names if name.startswith("lidar_")]
    assert len(beams) == 36
    assert beams.count(-1) >= 0.75 * len(beams)
    assert all(beam == -1 or beam > 0.08 for beam in beams)
