"""rosorin-compile frames: who publishes each frame, in the terminal, as JSON, as files; and every way to ask amiss."""

import json
import re
from pathlib import Path
from typing import Any

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
    every = shown(capsys)
    half = every.index("")
    on, off = every[:half], every[half + 1 :]
    assert (on[0], off[0], on[4:]) == (ON, OFF, off[4:])
    assert on[3].split() == ["└──", "odom", "slam_toolbox", "/tf", "when", "slam"]
    assert on[5].split() == ["├╌╌", "base_footprint", "(above)", "nobody", "(1)", "-", "base_joint", "(fixed)"]
    assert on[-1] == "(2) the claw is not in /joint_states"
    for word, meant in (("slam", on), ("slam=on", on), (" slam ", on), ("not slam", off), ("slam=off", off)):
        assert shown(capsys, "rosorin", "--mode", word) == meant


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
    assert shown(capsys, "--frame", "map") == ["frame  published by  topic  joint", "map"]


def test_a_publisher_without_edges(capsys: Shown) -> None:
    assert shown(capsys, "--publisher", "amcl", "--mode", "slam") == ["amcl publishes nothing here"]
    assert len(shown(capsys, "--publisher", "nobody")) == 1 + 7 + 2


def test_json(capsys: Shown) -> None:
    def situations(*words: str) -> list[dict[str, Any]]:
        result = json.loads("\n".join(shown(capsys, "--format", "json", *words)))["result"]
        assert result["name"] == "rosorin"
        return list(result["situations"])

    on, off = situations()
    assert (on["when"], on["modes"], off["modes"]) == (ON, [{"slam": True}], [{"slam": False}])
    assert len(on["frames"]) == len(off["frames"]) == 23
    assert ("odom", "base_link", "ekf", None, "/tf", None, None, None) in [tuple(edge.values()) for edge in on["edges"]]
    (nobody,) = [edge for edge in on["edges"] if edge["parent"] == "base_footprint"]
    assert (nobody["publisher"], nobody["topic"], nobody["type"]) == (None, None, "fixed")
    (way,) = situations("--frame", "link2", "--mode", "slam")
    assert way["frames"] == ["map", *(edge["child"] for edge in way["edges"])]
    assert way["frames"] == ["map", "odom", "base_link", "link1", "link2"]
    assert [[edge["child"] for edge in one["edges"]] for one in situations("--publisher", "ekf")] == [["base_link"]] * 2


# Files.


def labels(picture: Path) -> list[str]:
    return re.findall(r'class="panel" data-when="(.*?)"', picture.read_text("utf-8"))


@pytest.mark.parametrize("file", ["here/f.svg", "F.SVG"])
def test_a_picture_of_every_situation_or_of_one(capsys: Shown, rosorin: Path, file: str) -> None:
    assert shown(capsys, "-o", file) == [f"rosorin: {file}"]
    assert labels(rosorin / file) == [ON, OFF]
    assert shown(capsys, "-o", file, "--mode", "slam") == [f"rosorin: {file}"]
    artifact = (ROOT / "outputs" / "rosorin" / "frames_slam.svg").read_text("utf-8")
    assert (rosorin / file).read_text("utf-8") == artifact


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
