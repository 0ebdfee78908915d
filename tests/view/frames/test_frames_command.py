"""rosorin-compile frames: who publishes each frame, in the terminal, as JSON, as files; and every way to ask amiss."""

import json
import re
from pathlib import Path

import pytest

from rosorin_compile.cli.main import main
from support.paths import ROOT
from support.robots import copy_of_rosorin

Shown = pytest.CaptureFixture[str]
ON, OFF = "slam is on", "slam is off"


@pytest.fixture(autouse=True)
def rosorin(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    copy_of_rosorin(tmp_path)
    monkeypatch.chdir(tmp_path)
    return tmp_path


def shown(capsys: Shown, *words: str) -> list[str]:
    """What a call prints; nothing may be said on standard error."""
    code = main(["frames", *words])
    out, err = capsys.readouterr()
    assert (code, err) == (0, "")
    return out.rstrip("\n").split("\n")


def refused(capsys: Shown, *words: str) -> str:
    assert main(["frames", *words]) == 2
    out, err = capsys.readouterr()
    assert out == ""
    return err.removeprefix("rosorin-compile: ").rstrip("\n")


def test_a_tree_for_each_situation(capsys: Shown) -> None:
    said = shown(capsys)
    half = said.index("")
    on, off = said[:half], said[half + 1 :]
    assert (on[0], off[0]) == (ON, OFF)
    assert on[3].split() == ["└──", "odom", "slam_toolbox", "/tf", "when", "slam"]
    assert off[3].split() == ["└──", "odom", "amcl", "/tf", "when", "not", "slam"]
    assert on[4:] == off[4:]
    assert on[5].split() == ["├╌╌", "base_footprint", "(above)", "nobody", "(1)", "-", "base_joint", "(fixed)"]
    assert on[-2:] == [
        "(1) the filter of the odometry owns the transform into base_link",
        "(2) the claw is not in /joint_states",
    ]
    column = on[1].index("published by")
    assert all(line[column - 1] == " " and line[column] != " " for line in on[3:-2])


def test_one_mode(capsys: Shown) -> None:
    every = shown(capsys)
    half = every.index("")
    for words in (["slam"], ["slam=on"], [" slam "]):
        assert shown(capsys, "rosorin", "--mode", *words) == every[:half]
    for words in (["not slam"], ["slam=off"]):
        assert shown(capsys, "--mode", *words) == every[half + 1 :]


def test_who_publishes_this_frame(capsys: Shown) -> None:
    said = shown(capsys, "--frame", "base_link", "--mode", "slam")
    assert said == [
        ON,
        "frame              published by  topic  joint",
        "map",
        "└── odom           slam_toolbox  /tf           when slam",
        "    └── base_link  ekf           /tf",
    ]
    said = shown(capsys, "--frame", "odom")
    assert [line for line in said if line.startswith("slam is")] == [ON, OFF]


def test_a_root_and_a_frame_that_is_only_in_the_description(capsys: Shown) -> None:
    assert shown(capsys, "--frame", "map") == [
        "frame  published by  topic  joint",
        "map",
    ]
    said = shown(capsys, "--frame", "base_footprint", "--mode", "slam")
    assert "base_footprint (above)  nobody (1)" in said[-2]


def test_a_frame_that_is_not_there_in_a_mode(capsys: Shown, rosorin: Path) -> None:
    edges = "  - {parent: base_link, child: marker, publisher: ekf, when: slam}\n"
    path = rosorin / "descriptions" / "rosorin" / "publishers.yaml"
    path.write_text(path.read_text("utf-8") + edges, "utf-8")
    assert shown(capsys, "--frame", "marker", "--mode", "not slam") == [
        OFF,
        "marker is not there",
    ]


def test_the_edges_of_one_publisher(capsys: Shown) -> None:
    assert shown(capsys, "--publisher", "deptrum") == [
        "from               to               published by  topic       joint",
        "depth_camera_link  rgb_camera_link  deptrum       /tf_static",
    ]
    said = shown(capsys, "--publisher", "nobody")
    assert len(said) == 1 + 7 + 2
    assert shown(capsys, "--publisher", "amcl", "--mode", "slam") == ["amcl publishes nothing here"]
    assert len(shown(capsys, "--publisher", "amcl")) == 2


def test_json_says_all_of_it(capsys: Shown) -> None:
    document = json.loads("\n".join(shown(capsys, "--format", "json")))["result"]
    assert document["name"] == "rosorin"
    on, off = document["situations"]
    assert (on["when"], on["modes"], off["modes"]) == (ON, [{"slam": True}], [{"slam": False}])
    assert len(on["frames"]) == len(off["frames"]) == 23
    assert {
        "parent": "odom",
        "child": "base_link",
        "publisher": "ekf",
        "why": None,
        "topic": "/tf",
        "when": None,
        "joint": None,
        "type": None,
    } in on["edges"]
    (nobody,) = [edge for edge in on["edges"] if edge["parent"] == "base_footprint"]
    assert (nobody["publisher"], nobody["topic"], nobody["joint"], nobody["type"]) == (
        None,
        None,
        "base_joint",
        "fixed",
    )
    way = json.loads("\n".join(shown(capsys, "--format", "json", "--frame", "link2", "--mode", "slam")))["result"][
        "situations"
    ][0]
    assert [edge["child"] for edge in way["edges"]] == ["odom", "base_link", "link1", "link2"]
    assert way["frames"] == ["map", "odom", "base_link", "link1", "link2"]
    ekf = json.loads("\n".join(shown(capsys, "--format", "json", "--publisher", "ekf")))["result"]["situations"]
    assert [[edge["child"] for edge in one["edges"]] for one in ekf] == [["base_link"], ["base_link"]]


# Files.


def labels(picture: Path) -> list[str]:
    return re.findall(r'class="panel" data-when="(.*?)"', picture.read_text("utf-8"))


@pytest.mark.parametrize("file", ["f.svg", "F.SVG"])
def test_a_picture_of_every_situation_or_of_one(capsys: Shown, rosorin: Path, file: str) -> None:
    assert shown(capsys, "-o", file) == [f"rosorin: {file}"]
    assert labels(rosorin / file) == [ON, OFF]
    assert shown(capsys, "-o", file, "--mode", "not slam") == [f"rosorin: {file}"]
    assert labels(rosorin / file) == [OFF]


def test_a_picture_is_the_artifact(capsys: Shown, rosorin: Path) -> None:
    shown(capsys, "-o", "here/frames.svg", "--mode", "slam")
    made = (rosorin / "here" / "frames.svg").read_text("utf-8")
    assert made == (ROOT / "outputs" / "rosorin" / "frames_slam.svg").read_text("utf-8")


def test_a_folder_gets_a_picture_for_each_situation(capsys: Shown, rosorin: Path) -> None:
    said = shown(capsys, "-o", "pictures/")
    assert said == ["rosorin: pictures/frames_slam_on.svg", "rosorin: pictures/frames_slam_off.svg"]
    (rosorin / "pictures" / "mine.txt").write_text("mine", "utf-8")
    assert shown(capsys, "-o", "pictures") == said
    assert sorted(path.name for path in (rosorin / "pictures").iterdir()) == [
        "frames_slam_off.svg",
        "frames_slam_on.svg",
        "mine.txt",
    ]
    assert labels(rosorin / "pictures" / "frames_slam_on.svg") == [ON]


def test_nobody_elses_file_is_overwritten(capsys: Shown, rosorin: Path) -> None:
    (rosorin / "notes.svg").write_text("my notes", "utf-8")
    assert refused(capsys, "-o", "notes.svg") == (
        "notes.svg exists and was not written by this tool: name another file, or add --force"
    )
    (rosorin / "pictures").mkdir()
    (rosorin / "pictures" / "frames_slam_on.svg").write_text("<svg/>", "utf-8")
    assert "pictures/frames_slam_on.svg exists" in refused(capsys, "-o", "pictures")
    assert (rosorin / "notes.svg").read_text("utf-8") == "my notes"
    assert shown(capsys, "-o", "notes.svg", "--force") == ["rosorin: notes.svg"]


# Amiss.


def test_too_many_trees_ask_for_modes(capsys: Shown, rosorin: Path) -> None:
    path = rosorin / "descriptions" / "rosorin" / "publishers.yaml"
    text = path.read_text("utf-8")
    modes = "".join(f"  m{at}: a mode\n" for at in range(5))
    edges = "".join(f"  - {{parent: odom, child: f{at}, publisher: ekf, when: m{at}}}\n" for at in range(5))
    path.write_text(text.replace("modes:\n", f"modes:\n{modes}") + edges, "utf-8")
    assert refused(capsys) == (
        "the tree of frames differs in 64 combinations of modes: too many to show; name modes: --mode NAME"
    )
    assert len(json.loads("\n".join(shown(capsys, "--mode", "m0", "--format", "json")))["result"]["situations"]) == 32


def test_a_description_with_errors(capsys: Shown, rosorin: Path) -> None:
    path = rosorin / "descriptions" / "rosorin" / "publishers.yaml"
    path.write_text(path.read_text("utf-8") + "nonsense: 1\n", "utf-8")
    assert main(["frames"]) == 1
    assert "error[unknown-key]" in capsys.readouterr().err
