"""check --html and diff --html: the data of the page, the robot before and what became of it."""

import json
import shutil
import struct
from pathlib import Path
from typing import Any

import jsonschema
import pytest

from rosorin_compile.cli.main import main
from rosorin_compile.viewer.page import data_of
from support.commands import Shown, edit, write_files
from support.paths import ROOT, data_text
from support.schemas import schema

VALID = jsonschema.Draft7Validator(schema("page"))
CART = data_text("robots/changes_cart.yaml")
NAMES = ("arm", "cart")
PROJECT = {f"descriptions/{name}/robot.yaml": CART.format(name) for name in NAMES}


def stl(size: float) -> bytes:
    """Return a mesh: the corner of a cube of that size (m)."""
    corners = ((0, 0, 0), (size, 0, 0), (0, size, 0), (0, 0, size))
    faces = ((0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3))
    triangles = [struct.pack("<12fH", 0, 0, 0, *(v for i in face for v in corners[i]), 0) for face in faces]
    return bytes(80) + struct.pack("<I", len(faces)) + b"".join(triangles)


@pytest.fixture
def committed(project: Path, capsys: Shown) -> Path:
    for name in NAMES:
        (project / f"descriptions/{name}/camera.stl").write_bytes(stl(0.03))
    assert main(["all"]) == 0
    capsys.readouterr()
    return project


def page(capsys: Shown, *words: str, code: int) -> Any:
    assert main([*words, "--html", "page.html"]) == code
    capsys.readouterr()
    data = data_of(Path("page.html").read_text("utf-8"))
    VALID.validate(data)
    return data


def drawn(data: Any) -> dict[str, list[str]]:
    found = {
        link["name"]: [one["kind"] for one in (*link["visual"], *link["collision"])] for link in data["before"]["links"]
    }
    return {name: kinds for name, kinds in found.items() if kinds}


def test_a_sensor_that_the_urdf_does_not_know(committed: Path, capsys: Shown) -> None:
    edit(committed / "descriptions/cart/robot.yaml", "[0, 0, 120 mm]", "[0, 0, 130 mm]")
    data = page(capsys, "check", "cart", code=1)
    assert data["said"] == "1 change against what is committed"
    text = "laser moved 10.0 mm in base_link: origin z 0.12 -> 0.13 m"
    assert data["changes"] == [{"text": text, "frame": "laser", "artifacts": ["static_tf", "frames"]}]
    assert (data["moved"], drawn(data), data["notes"]) == ({"laser": "moved"}, {}, [])
    before = {joint["child"]: joint["xyz"] for joint in data["before"]["joints"]}
    assert before == {"mast": [0.1, 0.0, 0.05], "camera": [0.0, 0.0, 0.2], "laser": [0.0, 0.0, 0.12]}


def test_what_is_carried_is_told_apart_and_its_mesh_is_there_once(committed: Path, capsys: Shown) -> None:
    edit(committed / "descriptions/cart/robot.yaml", "[100 mm, 0, 50 mm]", "[200 mm, 0, 50 mm]")
    data = page(capsys, "check", "cart", code=1)
    assert data["moved"] == {"mast": "moved", "camera": "carried"}
    assert drawn(data) == {"mast": ["box"], "camera": ["mesh"]}
    assert list(data["robot"]["meshes"]) == ["camera.stl"]
    assert data["before"]["meshes"] == {}


def test_another_mesh_is_drawn_as_it_was(home: Path, capsys: Shown) -> None:
    """Meshes stand beside an MJCF: the one that is committed is another one than that of the description."""
    part = home / "descriptions/part/part.stl"
    robot = "robot: part\nlinks: {base: {collision: [{mesh: {file: part.stl}}]}}\n"
    write_files(home, {"descriptions/part/robot.yaml": f"{robot}outputs: {{mjcf: {{file: part.xml}}}}\n"})
    part.write_bytes(stl(0.03))
    assert main(["all"]) == 0
    part.write_bytes(stl(0.06))
    data = page(capsys, "check", code=1)
    assert data["changes"] == []
    assert (data["moved"], drawn(data)) == ({"base": "shaped"}, {"base": ["mesh"]})
    now, was = data["robot"]["meshes"]["part.stl"], data["before"]["meshes"]["part.stl"]
    assert now["data"] != was["data"]
    assert data["notes"] == ["part.stl: another file than the mesh is; rosorin-compile all writes it"]
    bare = page(capsys, "check", "--no-meshes", code=1)
    assert (bare["robot"]["meshes"], bare["before"]["meshes"]) == ({}, {})


def test_a_robot_with_errors_is_not_in_it(committed: Path, capsys: Shown) -> None:
    edit(committed / "descriptions/cart/robot.yaml", "child: mast,", "chidl: mast,")
    edit(committed / "descriptions/arm/robot.yaml", "[0, 0, 120 mm]", "[0, 0, 130 mm]")
    data = page(capsys, "check", code=1)
    assert (data["robot"]["name"], data.get("others")) == ("arm", None)
    edit(committed / "descriptions/cart/robot.yaml", "chidl: mast,", "child: mast,")
    data = page(capsys, "check", code=1)  # those that changed are first
    assert [data["robot"]["name"], *(one["robot"]["name"] for one in data["others"])] == ["arm", "cart"]
    assert (data["others"][0]["said"], data["others"][0]["changes"]) == ("no change: this is what is committed", [])


def test_nothing_is_committed(committed: Path, capsys: Shown) -> None:
    shutil.rmtree(committed / "outputs/cart")
    data = page(capsys, "check", "cart", code=1)
    assert data["said"] == "nothing is committed to compare with"
    assert "before" not in data
    assert str(committed) not in Path("page.html").read_text("utf-8")


def test_a_committed_urdf_brings_no_file_from_elsewhere(committed: Path, capsys: Shown) -> None:
    """A mesh that an old artifact names is in the page only if it was committed with it."""
    (committed / "secret.stl").write_bytes(stl(1.0))
    edit(committed / "outputs/cart/cart.urdf", "camera.stl", "../../secret.stl")
    data = page(capsys, "check", "cart", code=1)
    assert data["before"]["meshes"]["../../secret.stl"] == {"missing": "not found"}


def test_the_page_is_not_written_over_what_it_is_made_of(committed: Path, capsys: Shown) -> None:
    before = (committed / "outputs/cart/cart.urdf").read_bytes()
    assert main(["check", "cart", "--html", "outputs/cart/cart.urdf"]) == 2
    assert "is one of the files that it would be made of" in capsys.readouterr().err
    assert (committed / "outputs/cart/cart.urdf").read_bytes() == before


# diff: whatever the two are written in.

BURGER = ROOT / "examples/turtlebot3_burger/robot.yaml"


@pytest.fixture
def burger(home: Path, capsys: Shown) -> Path:
    """TurtleBot3 as it is committed, and a description in which its scanner sits 10 mm higher and is wider."""
    for name in ("old", "new"):
        shutil.copytree(BURGER.parent, home / f"descriptions/{name}")
    assert main(["all", "old", "-q"]) == 0
    edit(home / "descriptions/new/robot.yaml", "[-32 mm, 0, 172 mm]", "[-32 mm, 0, 182 mm]")
    edit(home / "descriptions/new/robot.yaml", "radius: 55 mm", "radius: 60 mm")
    capsys.readouterr()
    return home


@pytest.mark.usefixtures("burger")
def test_diff_of_formats(capsys: Shown) -> None:
    for old in ("old", "outputs/old/turtlebot3_burger.urdf", "outputs/old/turtlebot3_burger.xml"):
        data = page(capsys, "diff", old, "new", code=1)
        assert "base_scan" in [change.get("frame") for change in data["changes"]]
        assert data["moved"]["base_scan"] == "moved"
        assert {how for name, how in data["moved"].items() if name != "base_scan"} <= {"removed"}  # sites of the MJCF
        assert drawn(data) == {"base_scan": ["cylinder"]}
        origins = {joint["child"]: joint["xyz"][2] for joint in data["before"]["joints"]}
        assert origins["base_scan"] == pytest.approx(0.172)
    data = page(capsys, "diff", "old", "outputs/old/turtlebot3_burger.urdf", code=0)
    assert (data["changes"], data["moved"], drawn(data)) == ([], {}, {})
    assert data["said"].endswith("the same robot, as far as it was compared")


@pytest.mark.usefixtures("burger")
def test_diff_under_a_prefix_and_another_name(capsys: Shown) -> None:
    """The names of the page are those of B, also for the robot before."""
    urdf = Path("outputs/old/turtlebot3_burger.urdf").read_text("utf-8")
    theirs = urdf.replace('"base_scan"', '"scanner"').replace("0.172", "0.192")
    for name in (
        "base_footprint",
        "base_link",
        "wheel_left_link",
        "wheel_right_link",
        "caster_back_link",
        "imu_link",
        "scanner",
    ):
        theirs = theirs.replace(f'"{name}"', f'"tb3_{name}"')
    Path("theirs.urdf").write_text(theirs)
    data = page(capsys, "diff", "outputs/old/turtlebot3_burger.urdf", "theirs.urdf", code=1)
    assert data["moved"] == {"tb3_scanner": "moved"}
    assert {change.get("frame") for change in data["changes"]} == {"tb3_scanner"}
    assert drawn(data) == {"tb3_scanner": ["cylinder"]}
    assert data["before"]["root"] == "tb3_base_footprint"


# A change of colour, pages that are old, and who does not read to the end.


def test_a_change_of_colour_alone_has_both_colours(project: Path, capsys: Shown) -> None:
    lamp = "robot: lamp\nlinks: {base: {visual: [{box: {size: [1, 1, 1]}, rgba: [1, 0, 0, 1]}]}}\n"
    write_files(project, {"old.yaml": lamp, "new.yaml": lamp.replace("[1, 0, 0, 1]", "[0, 0.5, 0, 1]")})
    meant = {"was": [1.0, 0.0, 0.0, 1.0], "is": [0.0, 0.5, 0.0, 1.0]}
    data = page(capsys, "diff", "old.yaml", "new.yaml", code=1)
    assert [(one["frame"], one["colours"]) for one in data["changes"]] == [("base", meant)]
    shutil.rmtree("descriptions")
    write_files(project, {"descriptions/lamp/robot.yaml": lamp + "outputs: {urdf: {file: lamp.urdf}}\n"})
    assert main(["all"]) == 0
    edit(project / "descriptions/lamp/robot.yaml", "[1, 0, 0, 1]", "[0, 0.5, 0, 1]")
    data = page(capsys, "check", code=1)
    assert [(one["frame"], one["colours"]) for one in data["changes"]] == [("base", meant)]


def test_without_a_robot_that_compiles_there_is_no_new_page(committed: Path, capsys: Shown) -> None:
    page(capsys, "check", code=0)
    for name in NAMES:
        edit(committed / f"descriptions/{name}/robot.yaml", "child: mast,", "chidl: mast,")
    assert main(["check", "--html", "page.html"]) == 1
    assert "page.html: no new page, because no robot compiles" in "".join(capsys.readouterr())


@pytest.mark.usefixtures("committed")
def test_a_page_to_send_has_no_path_of_this_machine(capsys: Shown, tmp_path_factory: pytest.TempPathFactory) -> None:
    """A robot that stands elsewhere, with a mesh that is named by an absolute path."""
    away = tmp_path_factory.mktemp("away")
    (away / "part.stl").write_bytes(stl(0.03))
    text = f"robot: r\nlinks: {{base: {{visual: [{{mesh: {{file: {away}/part.stl}}}}]}}}}\n"
    (away / "robot.yaml").write_text(text)
    for words in (["view", str(away / "robot.yaml")], ["diff", str(away / "robot.yaml"), "cart"]):
        main([*words, "--html", "page.html"])
        data = data_of(Path("page.html").read_text("utf-8"))
        VALID.validate(data)
        capsys.readouterr()
        seen = json.dumps({**data, "changes": [], "notes": []})
        assert str(away) not in seen, seen[max(0, seen.find(str(away)) - 200) :][:400]
    assert main(["view", str(away / "robot.yaml"), "--html", "page.html"]) == 0
    (link,) = data_of(Path("page.html").read_text("utf-8"))["robot"]["links"]
    assert (link["where"]["file"], link["visual"][0]["mesh"]) == ("robot.yaml", "part.stl")
