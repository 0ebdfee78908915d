"""picture: its files and their pixels, its options, its errors and exit codes; the same bytes each time."""

import math
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from rosorin_compile.cli.main import main
from rosorin_compile.viewer.picture.render import AXIS_COLOURS
from support.drawings import hue_name, pixels
from support.paths import IMPORTED, OUTPUTS, ROOT, data_text

LABEL = (0x1F, 0x29, 0x33)
PORTER = ROOT / "examples" / "porter" / "robot.yaml"
ARM = data_text("robots/picture_command_arm.yaml")
BARE = data_text("robots/picture_command_bare.yaml")
PROJECT = {
    "descriptions/arm/robot.yaml": ARM,
    "descriptions/bare/robot.yaml": BARE,
    "descriptions/broken/robot.yaml": "robot: broken\nlinks: {a: {}}\njoints: {j: {type: fixed, parent: a, child: b}}",
}
pytestmark = pytest.mark.usefixtures("project")


def drawn_by(*words: str, file: str = "arm.png") -> np.ndarray:
    size = () if "--size" in words else ("--size", "160x120")
    assert main(["picture", *words, *size, "-o", file, "--force"]) == 0
    return pixels(Path(file).read_bytes())


def count_of(shown: np.ndarray, colour: tuple[int, int, int]) -> int:
    return int((np.abs(shown[..., :3].astype(int) - colour).max(axis=2) < 20).sum())


def rows_of(shown: np.ndarray, name: str) -> np.ndarray:
    return np.array([index for index, row in enumerate(shown) if any(hue_name(colour) == name for colour in row)])


def test_poses_and_positions_move_what_is_drawn():
    small = ("arm", "--from", "side")
    flat, up = drawn_by(*small), drawn_by(*small, "--pose", "up")
    assert np.ptp(rows_of(up, "red")) > 3 * np.ptp(rows_of(flat, "red"))
    assert (drawn_by(*small, "--joint", "shoulder=90deg") == up).all()
    assert (drawn_by(*small, "--pose", "up", "--joint", "shoulder=0") == flat).all()


def test_a_view_is_that_of_its_angles():
    small = ("arm", "--transparent")
    azimuth, elevation = (math.degrees(math.atan2(*pair)) for pair in ((-1.15, 1.0), (0.75, math.hypot(1.0, 1.15))))
    by_name, by_angle = drawn_by(*small), drawn_by(*small, f"--from={azimuth}deg,{elevation}deg")
    assert (np.abs(by_name.astype(int) - by_angle).max(axis=2) > 2).mean() < 0.001  # the last digit may move an edge
    assert (drawn_by(*small, "--from", "90deg,10deg") != by_name).any()


def test_a_transparent_picture_has_a_shadow_and_nothing_else_behind_the_robot():
    shown = drawn_by("arm", "--transparent", "--size", "320x200")
    assert shown.shape[2] == 4
    assert shown[:5, :, 3].max() == 0
    shade = shown[(shown[..., 3] > 0) & (shown[..., 3] < 60)]
    assert len(shade) > 300
    assert (shade[:, :3] < 60).mean() > 0.9
    assert (shown[..., 3] == 255).sum() > 2000


def test_frames_have_their_axes_and_names():
    shown = drawn_by("arm", "--frame", "upper", "--size", "400x300")
    plain = drawn_by("arm", "--size", "400x300")
    assert all(count_of(shown, colour) > 4 and not count_of(plain, colour) for colour in AXIS_COLOURS)
    assert count_of(shown, LABEL) > count_of(plain, LABEL) + 40
    assert (drawn_by("arm", "--frames", "--size", "400x300") != shown).any()


def test_a_robot_of_frames_alone_shows_them():
    shown = drawn_by("bare", "--size", "400x300", file="bare.png")
    assert all(count_of(shown, colour) > 4 for colour in AXIS_COLOURS)
    assert count_of(shown, LABEL) > 40


def test_collision_shapes_are_a_veil_over_visuals_and_all_there_is_without():
    text = ARM.replace("  base: {visual", "  base: {collision: [{sphere: {radius: 0.3}}], visual")
    Path("descriptions/arm/robot.yaml").write_text(text, "utf-8")
    with_veil = drawn_by("arm", "--collision", "--transparent")
    without = drawn_by("arm", "--transparent")
    veiled = (with_veil[..., 3] > 80) & (with_veil[..., 3] < 130)
    assert veiled.sum() > 1000
    assert not ((without[..., 3] > 80) & (without[..., 3] < 130)).sum() > 200


@pytest.mark.slow
def test_its_bytes_are_the_same_each_time():
    found = set()
    for seed in ("0", "77"):
        command = [sys.executable, "-m", "rosorin_compile", "picture", str(PORTER), "--pose", "ready", "--frames"]
        words = [*command, "--size", "160x120", "-o", f"{seed}.png"]
        subprocess.run(words, check=True, env={**os.environ, "PYTHONHASHSEED": seed}, capture_output=True)
        found.add(Path(f"{seed}.png").read_bytes())
    assert len(found) == 1


@pytest.mark.parametrize("path", [OUTPUTS / "rosorin.urdf", OUTPUTS / "rosorin.xml", IMPORTED / "rover" / "rover.urdf"])
def test_robots_of_other_formats(path):
    shown = drawn_by(str(path), "--transparent")
    assert (shown[..., 3] == 255).sum() > 300


MESHES = """\
robot: meshes
links:
  a: {visual: [{mesh: {file: a.stl}, rgba: [0.8, 0.2, 0.2, 1]}, {mesh: {file: gone.stl}}]}
"""


def test_a_dark_picture_is_dark_around_the_same_robot():
    light, dark = (drawn_by("arm", "--frames", "--theme", name) for name in ("light", "dark"))
    corner = (slice(0, 10), slice(0, 10))
    assert light[corner].min() > 200
    assert dark[corner].max() < 60
    bare = [drawn_by("bare", "--size", "320x240", "--theme", name) for name in ("light", "dark")]
    assert bare[0].min() < 60 < 180 < bare[1].max(), "letters are told from what is behind them"


COLOURED = """\
robot: coloured
links: {a: {visual: [{mesh: {file: a.obj}}]}, b: {visual: [{mesh: {file: a.obj}, rgba: [0, 1, 0, 1]}]}}
joints: {j: {type: fixed, parent: a, child: b, xyz: [0, 3, 0]}}
"""
MATERIALS = "newmtl blue\nKd 0 0 1\nnewmtl image\nKd 0 0 0\nmap_Kd skin.png\n"


def test_colours_of_materials_are_drawn_where_the_visual_has_none():
    trimesh = pytest.importorskip("trimesh")
    folder = Path("descriptions/coloured")
    folder.mkdir()
    (folder / "robot.yaml").write_text(COLOURED, "utf-8")
    cube = trimesh.creation.box((1, 1, 1)).export(file_type="obj", include_normals=False)
    (folder / "a.obj").write_text("mtllib a.mtl\nusemtl blue\n" + "".join(line + "\n" for line in cube.splitlines()))
    (folder / "a.mtl").write_text(MATERIALS)

    def hues() -> set[str]:
        shown = drawn_by("coloured", "--transparent")
        return {hue_name(colour) for colour in shown[shown[..., 3] == 255]}

    assert hues() == {"blue", "green"}
    (folder / "a.obj").write_text((folder / "a.obj").read_text().replace("usemtl blue", "usemtl image"))
    assert "green" in hues()
    assert "blue" not in hues()


def test_meshes_are_drawn_and_missing_ones_reported(capsys):
    trimesh = pytest.importorskip("trimesh")
    folder = Path("descriptions/meshes")
    folder.mkdir()
    (folder / "robot.yaml").write_text(MESHES, "utf-8")
    trimesh.creation.icosphere(subdivisions=5, radius=0.2).export(folder / "a.stl")
    shown = drawn_by("meshes", "--transparent")
    assert 'the mesh gone.stl of link "a" is not found' in capsys.readouterr().err
    solid = shown[shown[..., 3] == 255]
    assert len(solid) > 1500
    assert {hue_name(colour) for colour in solid} == {"red"}
