"""The command line of extract: results as YAML, JSON and tables, robots and meshes, and what it does not take."""

import json
from pathlib import Path

import pytest
import trimesh
import yaml
from jsonschema import Draft7Validator

from rosorin_compile.cli.main import main
from rosorin_compile.formats.compilation import compile_robot
from support.meshes import box
from support.paths import data_text
from support.robots import compiled
from support.schemas import schema

pytestmark = pytest.mark.slow

SCHEMA = schema("robot_model")

Said = pytest.CaptureFixture[str]


@pytest.fixture
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    trimesh.Trimesh(**trimesh.triangles.to_kwargs(box((0, 0, 0), (0.2, 0.1, 0.06)))).export("brick.stl")
    trimesh.Trimesh(**trimesh.triangles.to_kwargs(box((0, 0, 0), (0.2, 0.1, 0.06))[:-1])).export("open.stl")
    Path("robot.urdf").write_text(URDF)
    return tmp_path


URDF = data_text("robots/extract_command_urdf.urdf")


@pytest.mark.parametrize("shape", ["box", "oriented_box", "cylinder", "capsule", "stack", "smallest"])
def test_every_shape_can_be_written(here: Path, shape: str) -> None:
    assert main(["extract", "boxes", "brick.stl", "--shape", shape, "--stack", "3", "-o", "boxes.yaml"]) == 0
    (here / "robot.yaml").write_text("robot: brick\ninclude: [boxes.yaml]\noutputs: {urdf: {file: brick.urdf}}\n")
    compiled = compile_robot(Path("robot.yaml"))
    assert compiled.robot is not None
    assert len(compiled.robot.link["brick"].collision) == (3 if shape == "stack" else 1)


def test_open_mesh_is_said_to_be_open(here: Path, capsys: Said) -> None:
    assert here.is_dir()
    assert main(["extract", "boxes", "open.stl", "-o", "boxes.yaml"]) == 0
    row = capsys.readouterr().out.splitlines()[1].split()
    assert row == ["open", "box", "1200.0", "cm3", "open", "mesh", "100%"]
    assert main(["extract", "boxes", "open.stl", "--format", "json"]) == 0
    found = json.loads(capsys.readouterr().out)["result"]["open"]
    assert (found["closed"], found["triangles"]) == (False, 11)
    assert found["shapes"]["box"]["overhang_volume"] is None


def test_links_of_a_robot_in_their_own_frames(here: Path, capsys: Said) -> None:
    assert here.is_dir()
    assert main(["extract", "boxes", "robot.urdf"]) == 0
    assert "{box: {min: [1, 0, 0], max: [1.4, 0.1, 0.06]}}" in capsys.readouterr().out
    assert main(["extract", "boxes", "robot.urdf", "--from", "visual", "--link", "body"]) == 0
    assert "{box: {min: [0, 0, 0], max: [0.2, 0.1, 0.06]}}" in capsys.readouterr().out


def test_heightmap_of_a_link_in_another_frame(here: Path, capsys: Said) -> None:
    assert here.is_dir()
    words = "extract heightmap robot.urdf --link body --frame floor --from visual --format json --cell 2cm"
    assert main(words.split()) == 0
    found = json.loads(capsys.readouterr().out)["result"]
    Draft7Validator(SCHEMA["properties"]["chassis_heightmap"]).validate(found)
    assert (found["frame"], found["cell"], found["origin_xy"]) == ("floor", 0.02, [-0.1, 0])
    assert found["z"] == [[0.16] * 10] * 5


def test_the_bottom_stands_in_the_map_and_compiles(here: Path, capsys: Said) -> None:
    words = ["extract", "heightmap", "brick.stl", "--frame", "base", "--cell", "5cm", "--xyz", "0,0,25mm", "--bottom"]
    assert main([*words, "-o", "map.yaml"]) == 0
    (entry,) = yaml.safe_load(Path("map.yaml").read_text())["links"]["base"]["collision"]
    assert entry["height_map"]["bottom"] == "25 mm"
    robot = "robot: r\ninclude: [map.yaml]\noutputs: {mjcf: {file: r.xml}}\n"
    (here / "r.yaml").write_text(robot)
    (box,) = compiled(here / "r.yaml").robot.link["base"].collision[0].solids("merged")
    assert (box.geometry.lower[2], box.geometry.upper[2]) == (0.025, 0.1)
    capsys.readouterr()
    for more in (["--format", "json"], ["--into", "r.yaml"]):
        assert main([*words, *more]) == 2
        assert "--bottom excludes --" in capsys.readouterr().err


def test_millimetres_are_suspected_and_scaled(here: Path, capsys: Said) -> None:
    big = trimesh.Trimesh(**trimesh.triangles.to_kwargs(box((0, 0, 0), (200, 100, 60))))
    big.export(here / "mm.stl")
    assert main(["extract", "boxes", "mm.stl"]) == 0
    said = capsys.readouterr().err
    assert "warning[mesh-looks-like-millimetres]: mm.stl is 200 m long; that looks like millimetres" in said
    assert main(["extract", "boxes", "mm.stl", "--scale", "0.001"]) == 0
    said = capsys.readouterr()
    assert "max: [0.2, 0.1, 0.06]" in said.out
    assert "millimetres" not in said.err


def test_files_of_others_are_not_overwritten(here: Path, capsys: Said) -> None:
    words = ["extract", "boxes", "brick.stl", "-o", "boxes.yaml"]
    assert main(words) == 0
    assert main(words) == 0
    (here / "boxes.yaml").write_text("robot: mine\n")
    capsys.readouterr()
    assert main(words) == 1
    assert capsys.readouterr().err.splitlines() == [
        "error[extract-file]: this tool did not write boxes.yaml: it is not replaced",
        "    name another file, or add --force",
    ]
    assert (here / "boxes.yaml").read_text() == "robot: mine\n"
    assert main([*words, "--force"]) == 0
    (here / "file").write_text("")
    capsys.readouterr()
    assert main(["extract", "boxes", "brick.stl", "-o", "file/boxes.yaml"]) == 1
    assert capsys.readouterr().err.startswith("error[extract-file]: cannot write file/boxes.yaml: ")


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["boxes", "folder.stl"], "error[mesh-unreadable]: cannot read folder.stl: Is a directory"),
        (["boxes", "robot.urdf", "--link", "floor"], "error[mesh-empty]: floor has no mesh that can be read"),
        (["heightmap", "robot.urdf", "--link", "floor"], "error[mesh-empty]: floor has no mesh that can be read"),
        (["heightmap", "brick.stl", "--cell", "1um"], "error[height-map-grid]: a grid of 200,001 x "),
        (["heightmap", "brick.stl", "--below", "-1"], "error[height-map-empty]: nothing of the mesh is below -1 m"),
        (["heightmap", "brick.stl", "--into", "robot.urdf"], "robot.urdf"),
    ],
)
def test_problems(here: Path, capsys: Said, words: list[str], message: str) -> None:
    (here / "folder.stl").mkdir()
    assert main(["extract", *words]) == 1
    assert message in capsys.readouterr().err
