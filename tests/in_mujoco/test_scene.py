"""The scene of a robot: MuJoCo loads it, the robot stands on its floor, and its camera sees all of it, in light."""

import os
from pathlib import Path

import numpy as np
import pytest

mujoco = pytest.importorskip("mujoco", minversion="3.12")

from rosorin_compile.source.diagnostics import has_errors  # noqa: E402
from support.paths import DATA, ROOT, ROSORIN, data_text  # noqa: E402
from support.robots import compiled_text, of_this_project  # noqa: E402
from support.scenes import BACK_END, seen  # noqa: E402

ROBOTS = {path.parent.name: path for path in [ROSORIN, *sorted((ROOT / "examples").glob("*/robot.yaml"))]}

# CI has the libraries: there it is no reason.
needs_screen = pytest.mark.skipif(
    not BACK_END and not os.environ.get("CI"), reason="MuJoCo draws off screen with libEGL or libOSMesa"
)

LEG = data_text("robots/scene_leg.yaml")


def written(folder: Path, text: str) -> Path:
    made = compiled_text(folder, text)
    assert not has_errors(made.diagnostics), made.diagnostics
    for artifact in made.artifacts:
        (folder / artifact.file).parent.mkdir(parents=True, exist_ok=True)
        (folder / artifact.file).write_text(artifact.text, "utf-8")
    return folder


def gap(scene: Path) -> float:
    """Return how far the robot is above the floor at home (m); negative inside."""
    model = mujoco.MjModel.from_xml_path(str(scene))
    data = mujoco.MjData(model)
    mujoco.mj_resetDataKeyframe(model, data, 0)
    mujoco.mj_forward(model, data)
    floor, ends = model.geom("floor").id, np.zeros(6)
    solid = [at for at in range(model.ngeom) if model.geom_contype[at] and at != floor]
    return min(mujoco.mj_geomDistance(model, data, floor, geom, 10.0, ends) for geom in solid)


@pytest.mark.parametrize("base", ["fixed", "free"])
def test_a_scene_shares_names_with_its_robot(tmp_path: Path, base: str) -> None:
    """The robot has a camera, a site and a geom that are called like those of a scene."""
    outputs = f"outputs: {{mjcf: {{file: hopper.xml, base: {base}}}, scene: {{file: scene.xml}}}}\n"
    scene = written(tmp_path, LEG + outputs) / "scene.xml"
    model = mujoco.MjModel.from_xml_path(str(scene))
    assert model.camera("overview_").bodyid[0] == 0
    assert model.camera("overview").bodyid[0] == model.body("foot").id
    assert model.geom("floor_").type[0] == mujoco.mjtGeom.mjGEOM_PLANE
    assert model.geom("floor").bodyid[0] == model.body("body").id


@pytest.mark.parametrize(("base", "root"), [("free", ""), ("fixed", ""), ("fixed", "root: {xyz: [0, 0, -1]}\n")])
def test_the_floor_is_where_the_robot_ends(tmp_path: Path, base: str, root: str) -> None:
    """A free one stands on it; under one that is held lower, it is lower."""
    text = LEG.replace("overview", "eye").replace("name: floor", "name: ball").replace("sites: {floor", "sites: {flat")
    outputs = f"outputs: {{mjcf: {{file: hopper.xml, base: {base}}}, scene: {{file: scene.xml}}}}\n"
    scene = written(tmp_path, text + root + outputs) / "scene.xml"
    assert gap(scene) == pytest.approx(0.0, abs=1e-6)


@pytest.mark.parametrize(("base", "free"), [("", True), (", base: fixed", False)])
def test_a_robot_that_drives_stands_free_on_its_floor(tmp_path: Path, base: str, free: bool) -> None:
    text = (DATA / "simulation" / "drive-differential.yaml").read_text("utf-8")
    outputs = f"outputs: {{mjcf: {{file: good.xml{base}}}, scene: {{file: scene.xml}}}}\n"
    scene = written(tmp_path, text + outputs) / "scene.xml"
    model = mujoco.MjModel.from_xml_path(str(scene))
    assert (mujoco.mjtJoint.mjJNT_FREE in model.jnt_type) == free
    assert model.key(0).name == "home"
    assert gap(scene) == pytest.approx(0.0, abs=1e-6)


def test_a_robot_that_is_held_high_hangs_over_the_floor(tmp_path: Path) -> None:
    text = LEG.replace("overview", "eye").replace("name: floor", "name: ball").replace("sites: {floor", "sites: {flat")
    outputs = "root: {xyz: [0, 0, 2]}\noutputs: {mjcf: {file: hopper.xml}, scene: {file: scene.xml}}\n"
    assert gap(written(tmp_path, text + outputs) / "scene.xml") > 1.8


def test_a_scene_of_one_of_two_in_another_folder(tmp_path: Path) -> None:
    outputs = """outputs:
  mjcf: {file: hopper.xml}
  flying: {backend: mjcf, file: sim/flying.xml, base: free}
  scene: {file: sim/scene.xml, of: flying}
"""
    scene = written(tmp_path, LEG + outputs) / "sim" / "scene.xml"
    assert '<include file="flying.xml"/>' in scene.read_text("utf-8")
    assert mujoco.MjModel.from_xml_path(str(scene)).nq == 8


@pytest.mark.slow
@pytest.mark.parametrize("name", ROBOTS)
def test_the_scene_of_every_robot_here_loads_and_has_a_key_home(name: str, tmp_path: Path) -> None:
    for artifact in of_this_project(ROBOTS[name]).artifacts:
        (tmp_path / artifact.file).write_text(artifact.text, "utf-8")
    model = mujoco.MjModel.from_xml_path(str(tmp_path / "scene.xml"))
    assert model.key(0).name == "home"
    assert gap(tmp_path / "scene.xml") >= -1e-6


@pytest.mark.slow
@needs_screen
@pytest.mark.landing("engines", "rosorin")
@pytest.mark.parametrize("name", ROBOTS)
def test_the_camera_sees_the_robot_in_light_on_a_floor(name: str, tmp_path: Path) -> None:
    for artifact in of_this_project(ROBOTS[name]).artifacts:
        (tmp_path / artifact.file).write_text(artifact.text, "utf-8")
    shown = seen(tmp_path / "scene.xml", tmp_path)
    assert 0.02 < shown.robot.mean() < 0.6
    assert shown.floor.mean() > 0.2
    sky = ~(shown.robot | shown.floor)
    assert 0.02 < sky.mean() < 0.5
    assert sky[0].all(), "the sky is not above all else"
    red, _, blue = shown.pixels[sky].mean(axis=0)
    assert blue > red + 20, "the sky is not blue"
    assert len(np.unique(shown.pixels[sky], axis=0)) > 3, "the sky is of one colour"
    assert len(np.unique(shown.pixels[shown.floor] // 32, axis=0)) >= 4, "the floor has no pattern"
    border = np.ones_like(shown.robot)
    border[1:-1, 1:-1] = False
    assert not shown.robot[border].any(), "the robot is not all in the picture"
    colours = shown.pixels[shown.robot].astype(int)
    assert colours.max(axis=1).mean() > 90, "the robot is in the dark"
    assert colours.max(axis=1).std() > 10, "the light has no direction"
    assert len(np.unique(colours // 32, axis=0)) >= 8, "the robot is of one colour"


@pytest.mark.slow
@needs_screen
@pytest.mark.landing("engines", "turtlebot3_burger")
@pytest.mark.parametrize("name", ROBOTS)
def test_the_floor_has_no_specks(name: str, tmp_path: Path) -> None:
    """At the end of what the map of shadows has, MuJoCo draws dots where there is no shadow."""
    for artifact in of_this_project(ROBOTS[name]).artifacts:
        (tmp_path / artifact.file).write_text(artifact.text, "utf-8")
    shown = seen(tmp_path / "scene.xml", tmp_path)
    corner = shown.pixels[-40:, -80:].astype(int).sum(axis=2)
    assert shown.floor[-40:, -80:].all()
    around = np.median(np.lib.stride_tricks.sliding_window_view(corner, (5, 5)), axis=(2, 3))
    assert int((around - corner[2:-2, 2:-2] > 40).sum()) <= 8
