"""Sections that a package brings: one entry, many by name, a list, an axis, two deep, one that names a sensor."""

import json
import os
import shutil
import subprocess
import sys
from collections.abc import Mapping
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import pytest
import yaml
from jsonschema import Draft7Validator

WORDS = Path(__file__).parent / "words"
ROBOT = (WORDS / "robot.yaml").read_text("utf-8")
ASKING = Path(__file__).parent / "asking.py"

# Changes of the robot that are mistakes, with what is reported.
BAD = yaml.safe_load((WORDS / "mistakes.yaml").read_text("utf-8"))
# Markers on markers, the inner one first, and in a circle.
MARKS = "markers:\n  - {link: one, frame: two}\n  - {link: THREE, frame: one}\n  -"
LINKED = {
    "chain": ("markers:\n  -", MARKS.replace("THREE", "lid_spot")),
    "circle": ("markers:\n  -", MARKS.replace("THREE", "two")),
}
# A change of the robot, and what diff says of both.
OTHER: Mapping[str, tuple[list[tuple[str, str]], list[str]]] = {
    "other-value": ([("3000 g", "4 kg")], ["payload mass 3 -> 4 kg (+1.0 kg)"]),
    "other-default": ([("3000 g,", "3000 g, fragile: true,")], []),
    "other-axis": (
        [("[1, 1, 0]", "[1, 0, 0]")],
        ["magnet left_catch direction 1 1 0 -> 1 0 0", "magnet right_catch direction 1 -1 0 -> 1 0 0"],
    ),
    "other-deep": (
        [("magnet: catch", "gauge: 2, magnet: catch")],
        ["cable left_loom strands left_signal gauge 1 -> 2", "cable right_loom strands right_signal gauge 1 -> 2"],
    ),
    "other-gone": ([("payload: {link: box, mass: 3000 g, xyz: [0.1, 0, 0]}\n", "")], ["removed: payload"]),
    "other-new": (
        [("  - {link: box, frame", "  - {link: base, frame: floor}\n  - {link: box, frame")],
        ["new: markers 1"],
    ),
    "other-height": ([("20 mm", "30 mm")], ["markers 1 height 0.02 -> 0.03"]),
    "other-link": ([("box", "crate")], ["link box renamed to crate"]),
}


ACCEPTED = (
    ("3000 g", "300 kg"),
    ("\npayload:", "\naccept: [{rule: payload-too-heavy, of: [box], reason: the lid holds it}]\npayload:"),
)


def changed(*pairs: tuple[str, str]) -> str:
    text = ROBOT
    for old, new in pairs:
        assert old in text, old
        text = text.replace(old, new)
    return text


def run(packages: Path, *words: str, **more: str) -> str:
    environment = {**os.environ, "PYTHONPATH": str(packages), "PYTHONDONTWRITEBYTECODE": "1", **more}
    ran = subprocess.run(
        [sys.executable, *words], env=environment, check=False, capture_output=True, text=True, cwd=packages.parent
    )
    assert not ran.stderr, ran.stderr
    return ran.stdout


@pytest.fixture(scope="module")
def packages(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("sections") / "packages"
    info = folder / "words-1.dist-info"
    info.mkdir(parents=True)
    (info / "METADATA").write_text("Metadata-Version: 2.1\nName: words\nVersion: 1\n", "utf-8")
    shutil.copy(WORDS / "entry_points.txt", info)
    shutil.copy(WORDS / "words.py", folder)
    shutil.copytree(WORDS / "wiring", folder / "wiring")
    return folder


@pytest.fixture(scope="module")
def answers(packages: Path) -> Any:
    robots = packages.parent / "robots"
    robots.mkdir()
    (robots / "robot.yaml").write_text(ROBOT, "utf-8")
    (robots / "accepted.yaml").write_text(changed(*ACCEPTED), "utf-8")
    for name, mistake in BAD.items():
        (robots / f"{name}.yaml").write_text(changed((mistake["old"], mistake["new"])), "utf-8")
    for name, pair in LINKED.items():
        (robots / f"{name}.yaml").write_text(changed(pair), "utf-8")
    for name, (pairs, _) in OTHER.items():
        (robots / f"{name}.yaml").write_text(changed(*pairs), "utf-8")
    return json.loads(run(packages, str(ASKING), str(robots), ROSORIN_COMPILE_CACHE="off"))


def test_a_part_with_sections_is_placed_twice(answers: Any) -> None:
    said = answers["robots"]["robot"]["said"]
    assert answers["robots"]["robot"]["told"] == []
    assert said["payload"] == {"link": "box", "mass": 3.0, "xyz": [0.1, 0, 0], "fragile": True}
    assert said["magnets"] == {
        "left_catch": {"link": "left_plate", "direction": [1, 1, 0]},
        "left_foot": {"link": "base", "direction": [-1.0, 0.0, 0.0], "strength": 2},  # turned with the use
        "right_catch": {"link": "right_plate", "direction": [1, -1, 0]},
        "right_foot": {"link": "base", "direction": [0.0, -1.0, 0.0], "strength": 2},
    }
    assert said["markers"] == [
        {"height": 0.02, "link": "box", "frame": "lid_spot"},
        {"height": 0.1, "link": "left_plate", "frame": "left_spot"},
        {"height": 0.1, "link": "right_plate", "frame": "right_spot"},
    ]
    strand = {"gauge": 1, "sensor": "left_eye", "magnet": "left_catch"}
    assert said["wiring"]["left_loom"] == {"strands": {"left_signal": strand}}


def test_what_a_section_adds_is_in_every_artifact(answers: Any) -> None:
    texts = answers["robots"]["robot"]["texts"]
    urdf = ElementTree.fromstring(texts["urdf"])
    box = next(link for link in urdf.iter("link") if link.get("name") == "box")
    assert box.find("inertial/mass").get("value") == "5"  # type: ignore[union-attr]
    assert box.find("inertial/origin").get("xyz") == "0.06 0 0"  # type: ignore[union-attr]
    inertia = {key: float(value) for key, value in box.find("inertial/inertia").items()}  # type: ignore[union-attr]
    # By the parallel axis theorem: 2 kg at 0 and 3 kg at 0.1 m, about 0.06 m.
    assert inertia["izz"] == pytest.approx(0.02 + 0.01 + 2 * 0.06**2 + 3 * 0.04**2)
    assert "<mass>5</mass>" in texts["sdf"]
    assert 'mass="5"' in texts["mjcf"]
    for text in texts.values():
        assert "lid_spot" in text
        assert "right_spot" in text


@pytest.mark.parametrize("name", BAD)
def test_what_is_wrong_is_told(answers: Any, name: str) -> None:
    told, mistake = answers["robots"][name]["told"], BAD[name]
    found = [one for one in told if one[0] == mistake["rule"]]
    assert found, told
    assert mistake["message"] in found[0][1]
    assert mistake["help"] in found[0][2]
    assert found[0][3] == mistake["line"]
    assert not answers["robots"][name]["texts"]


def test_what_is_wrong_may_be_accepted_of_the_link_that_is_named(answers: Any) -> None:
    accepted = answers["robots"]["accepted"]
    message = "accepted: it weighs 300 kg (reason: the lid holds it)"
    assert [one[1] for one in accepted["told"] if one[0] in ("payload-too-heavy", "accept-unused")] == [message]
    assert accepted["texts"]


@pytest.mark.parametrize("name", OTHER)
def test_a_difference_is_told_of_the_section(answers: Any, name: str) -> None:
    assert answers["robots"][name]["differences"] == OTHER[name][1]


def test_editors_know_the_sections(answers: Any) -> None:
    schema = answers["schema"]["properties"]
    names = [*schema]
    assert names.index("wiring") < names.index("accept")
    assert {"payload", "magnets", "markers", "wiring"} <= schema.keys()
    assert schema["payload"]["properties"]["mass"]["description"] == "What it weighs."
    assert "kg" in schema["payload"]["properties"]["mass"]["pattern"]
    assert "for" in schema["magnets"]["additionalProperties"]["properties"]
    judge = Draft7Validator(answers["schema"])
    sound, wrong = (yaml.safe_load(text) for text in (ROBOT, changed(("strength: 2", "strenght: 2"))))
    assert [error.message for error in judge.iter_errors(sound)] == []
    assert ["strenght" in error.message for error in judge.iter_errors(wrong)] == [True]


def test_explain_has_both_lines(packages: Path, answers: Any) -> None:
    del answers
    printed = run(packages, "-m", "rosorin_compile", "explain", "robots/robot.yaml", "box", "mass")
    assert [line.split()[-1] for line in printed.splitlines() if "kg" in line] == ["2", "g", "it"]
    assert "payload mass  3 kg  robots/robot.yaml:27:28  3000 g" in printed
    printed = run(packages, "-m", "rosorin_compile", "explain", "robots/robot.yaml", "lid_spot", "right_catch")
    assert "robots/robot.yaml:29:17" in printed
    assert "z               0.02 m  of markers" in printed
    assert "direction[1]  -1" in printed


def test_an_entry_may_refer_to_what_another_entry_defines(answers: Any) -> None:
    chain, circle = (answers["robots"][name] for name in LINKED)
    assert [one for one in chain["told"] if one[0] not in ("unused",)] == answers["robots"]["robot"]["told"]
    joints = {joint.get("name"): joint for joint in ElementTree.fromstring(chain["texts"]["urdf"]).iter("joint")}
    parents = {name: joints[f"{name}_joint"].find("parent").get("link") for name in ("one", "two")}
    assert parents == {"one": "lid_spot", "two": "one"}
    assert {one[0] for one in circle["told"]} >= {"unknown-link"}
