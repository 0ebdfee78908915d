"""A height map put in the place of another: only that collision changes, in every way that it may be written."""

import difflib
import json
import shutil
from pathlib import Path

import pytest
import trimesh
from hypothesis import strategies as st

from rosorin_compile.cli.main import main
from rosorin_compile.formats.compilation import compile_robot
from rosorin_compile.importing.extract.height_map import find_map, replace_map
from rosorin_compile.model import HeightMap
from rosorin_compile.model.mesh_triangles import ExtractProblem
from rosorin_compile.source.diagnostics import Source
from rosorin_compile.source.load import parse_yaml
from support.meshes import box
from support.paths import ROSORIN, data_text

CHASSIS = "descriptions/rosorin/chassis.yaml"
STAND_IN = "the chassis height map agrees with the published outline"

Said = pytest.CaptureFixture[str]


@pytest.fixture
def rosorin(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A copy of the reference robot, and a chassis that is as large as its own: a deck with a block at the rear."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("ROSORIN_COMPILE_CACHE", str(tmp_path / "cache"))
    shutil.copytree(ROSORIN.parent, tmp_path / "descriptions" / "rosorin")
    deck = box((-0.1426, -0.106, -0.011), (0.157, 0.104, 0.073))
    block = box((-0.14, -0.05, 0.073), (-0.1, 0.05, 0.112))
    for name, mesh in (("base_link.stl", deck), ("block.stl", block)):
        trimesh.Trimesh(**trimesh.triangles.to_kwargs(mesh)).export(tmp_path / name)
    return tmp_path


COMMAND = ["extract", "heightmap", "base_link.stl", "block.stl", "--xyz", "0,0,25mm", "--into", CHASSIS]


@pytest.mark.slow
def test_stand_in_of_the_reference_robot_is_replaced_by_one_command(rosorin: Path, capsys: Said) -> None:
    before = Path(CHASSIS).read_text("utf-8")
    assert STAND_IN in "".join(
        d.message for d in compile_robot(rosorin / "descriptions/rosorin/robot.yaml").diagnostics
    )
    assert main(COMMAND) == 0
    said = capsys.readouterr()
    assert said.err == ""
    assert said.out.splitlines() == [
        "30 x 23 cells of 10 mm from x -0.14266, y -0.106; 630 of 690 have a height, 0.098 to 0.137 m",
        f"{CHASSIS}:9: height map of base_footprint replaced",
    ]
    after = Path(CHASSIS).read_text("utf-8")
    changed = [line for line in difflib.ndiff(before.splitlines(), after.splitlines()) if line[0] in "+-"]
    words = {line[2:].split()[0] for line in changed}
    assert words == {"-", "method:", "source:", "status:", "note:", "rear)"}
    assert [line for line in before.splitlines() if "#" in line] == [line for line in after.splitlines() if "#" in line]
    compiled = compile_robot(rosorin / "descriptions/rosorin/robot.yaml")
    assert compiled.robot is not None
    assert STAND_IN not in "".join(d.message for d in compiled.diagnostics)
    (model,) = (json.loads(artifact.text) for artifact in compiled.artifacts if artifact.file == "robot_model.json")
    assert "stand_in" not in model["chassis_heightmap"]
    heights = model["chassis_heightmap"]["z"]
    assert (len(heights), len(heights[0])) == (30, 23)
    assert (heights[10][10], heights[1][10], heights[10][22]) == (0.098, 0.137, 0)


def test_twice_changes_nothing(rosorin: Path, capsys: Said) -> None:
    assert main(COMMAND) == 0
    path = rosorin / CHASSIS
    text, status = path.read_bytes(), path.stat()
    capsys.readouterr()
    assert main(COMMAND) == 0
    assert capsys.readouterr().out.endswith(f"\n{CHASSIS}:9: height map of base_footprint unchanged\n")
    assert (path.read_bytes(), path.stat().st_mtime_ns) == (text, status.st_mtime_ns)


def test_mesh_in_the_wrong_place_writes_nothing(rosorin: Path, capsys: Said) -> None:
    before = (rosorin / CHASSIS).read_bytes()
    assert main([*COMMAND[:4], "--xyz", "0,0,-1", "--into", CHASSIS]) == 1
    assert "error[height-map-empty]: the mesh has no surface above z = 0 of base_footprint over the grid" in (
        capsys.readouterr().err
    )
    assert (rosorin / CHASSIS).read_bytes() == before


def test_permissions_and_links_stay(rosorin: Path) -> None:
    real = rosorin / "elsewhere.yaml"
    (rosorin / CHASSIS).rename(real)
    real.chmod(0o640)
    (rosorin / CHASSIS).symlink_to(real)
    assert main(COMMAND) == 0
    assert (rosorin / CHASSIS).is_symlink()
    assert real.stat().st_mode & 0o777 == 0o640
    assert "top of base_link.stl, block.stl" in real.read_text()
    assert not list(rosorin.glob(".rosorin-compile-*"))


MADE = HeightMap((0.0, -0.5), 0.25, ((0.1, 0.2), (0.3, 0.0)), 0.25, "by hand")

BLOCK = data_text("robots/extract_into_block.yaml")
FLOW = """\
links: {body: {collision: [{height_map: {origin: [0, 0], cell: 1, heights: [[1, 2], [3, 4]]}, name: top}]}}   # all
other: [1, 2]
"""
SOURCE_FIRST = data_text("robots/extract_into_source_first.yaml")
SOURCE_BLOCK = data_text("robots/extract_into_source_block.yaml")
LAST_LINE = "links:\n  body:\n    collision:\n      - height_map:\n          cell: 1\n          origin: [0, 0]\n"
LAST_LINE += "          heights:\n            - [1]"


def replace_in(folder: Path, text: str, made: HeightMap = MADE, note: str = "x", link: str | None = None) -> str:
    path = folder / "body.yaml"
    path.write_bytes(text.encode())
    return replace_map(find_map(path, link), made, "calculated", note)


@pytest.mark.parametrize("end", ["\n", "\r\n"])
@pytest.mark.parametrize("text", [BLOCK, SOURCE_FIRST, SOURCE_BLOCK, LAST_LINE])
def test_block_styles(text: str, end: str, tmp_path: Path) -> None:
    new = replace_in(tmp_path, text.replace("\n", end), note='a: "note" # {x}')
    tree = parse_yaml(Source("new.yaml", new))
    entry = next(entry for entry in tree["links"]["body"]["collision"] if "height_map" in entry)
    there = entry["height_map"]
    assert there == {"origin": [0, -0.5], "cell": 0.25, "heights": [[0.1, 0.2], [0.3, 0]], "method": "by hand"}
    assert entry["source"] == {"status": "calculated", "note": 'a: "note" # {x}'}
    begin = text.index("height_map") if "source" not in text else text.index("source")
    assert new.startswith(text[:begin].replace("\n", end)[: begin - 2])
    for comment in ("# before", "# the body", "# untouched", "# kept", "# a cell", "# rows", "# where", "# behind"):
        assert (comment in new) == (comment in text), comment
    assert replace_in(tmp_path, new, link="body")


HEIGHTS = st.integers(1, 4).flatmap(
    lambda n: st.lists(st.lists(st.floats(0, 2), min_size=n, max_size=n), min_size=1, max_size=4)
)


ALIAS = """\
rows: &rows [[1]]
links:
  body:
    collision: [{height_map: {origin: [0, 0], cell: 1, heights: *rows}}]
"""
ANCHOR = data_text("robots/extract_into_anchor.yaml")


@pytest.mark.parametrize("text", [FLOW, ALIAS, ANCHOR])
def test_other_styles_are_not_edited(text: str, tmp_path: Path) -> None:
    with pytest.raises(ExtractProblem) as caught:
        replace_in(tmp_path, text, link="body")
    assert caught.value.diagnostic.rule == "extract-into"
    assert caught.value.diagnostic.message.endswith("is written in a way that cannot be edited")


@pytest.mark.parametrize(
    ("text", "link", "message"),
    [
        ("links: {a: {}}\n", None, "has no height map under links: (existing: none)"),
        (FLOW, "a", 'has no height map of the link "a" under links: (existing: body)'),
        (ANCHOR, None, "has 2 height maps under links: (existing: body, other)"),
        ("[1, 2]\n", None, "has no height map under links: (existing: none)"),
    ],
)
def test_no_place_for_it(text: str, link: str | None, message: str, tmp_path: Path) -> None:
    with pytest.raises(ExtractProblem) as caught:
        replace_in(tmp_path, text, link=link)
    assert caught.value.diagnostic.message.endswith(message)


def test_file_that_is_no_yaml_says_where(rosorin: Path, capsys: Said) -> None:
    (rosorin / CHASSIS).write_text("links: [\n")
    assert main(COMMAND) == 1
    assert "descriptions/rosorin/chassis.yaml:1:8: error[yaml-syntax]" in capsys.readouterr().err
    assert main([*COMMAND[:-1], "nowhere.yaml"]) == 1
    assert "error[file-unreadable]: cannot read nowhere.yaml: No such file or directory" in capsys.readouterr().err
