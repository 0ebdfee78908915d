"""Diff: changes planted in an arm are each told once, in these words; other ways to write it are no difference."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import jsonschema
import pytest
import yaml

from rosorin_compile.formats.compiled import compile_robot
from rosorin_compile.model import Robot
from support.comparing import ARM, DIFF, changed, compared, diff, told
from support.paths import data_text
from support.schemas import schema

SCHEMA = schema("robot_diff")
SHOULDER = "axis: [0, 1, 0]\n    limit: {lower: -1.5, upper: 2,"
TOOL = "type: fixed, parent: finger, child: tool, xyz: [0.05, 0, 0]"
LIMIT = "limit: {lower: -2, upper: 2, effort: 5, velocity: 3}"

CASES = yaml.safe_load(data_text("cases/diff.yaml"))
PLANTED = CASES["planted"]


@pytest.mark.parametrize(("changes", "line"), PLANTED, ids=[line for _, line in PLANTED])
def test_a_planted_change_is_told_once_in_these_words(
    tmp_path: Path, changes: list[tuple[str, str]], line: str
) -> None:
    found = compared(DIFF / "arm.yaml", changed(tmp_path, *changes))
    assert [item["text"] for item in found["differences"]] == [line]
    assert not found["not_compared"]
    jsonschema.validate(found, SCHEMA)


# The same arm in other words.
SAME = CASES["same"]


@pytest.mark.parametrize(("name", "changes"), SAME, ids=[name for name, _ in SAME])
def test_the_same_in_other_words_is_no_difference(tmp_path: Path, name: str, changes: list[tuple[str, str]]) -> None:
    text = ARM
    for old, new in changes:
        assert old in text, name
        text = text.replace(old, new, 1)
    path = tmp_path / "other.yaml"
    path.write_text(text, "utf-8")
    assert told(DIFF / "arm.yaml", path) == []
    assert told(path, DIFF / "arm.yaml") == []


def test_a_robot_that_is_split_into_files_is_the_same(tmp_path: Path) -> None:
    head, joints = ARM.split("joints:\n", 1)
    joints, tail = joints.split("servos:", 1)
    (tmp_path / "robot.yaml").write_text(f"{head}include: [more.yaml]\nservos:{tail}", "utf-8")
    (tmp_path / "more.yaml").write_text(f"joints:\n{joints}", "utf-8")
    code, out, _ = diff(DIFF / "arm.yaml", tmp_path)
    assert code == 0
    assert out.splitlines()[-1] == "the same robot, as far as it was compared"


def test_an_inserted_frame_is_new_and_moves_nothing(tmp_path: Path) -> None:
    path = changed(
        tmp_path,
        ("  marker: {}\n", "  marker: {}\n  plate: {}\n"),
        (
            "type: fixed, parent: base_link, child: mast, xyz: [-0.1, 0, 0.1]",
            "type: fixed, parent: plate, child: mast, xyz: [-0.1, 0, 0]",
        ),
        (
            "joints:\n  mast",
            "joints:\n  plate_joint: {type: fixed, parent: base_link, child: plate, xyz: [0, 0, 0.1]}\n  mast",
        ),
    )
    assert told(DIFF / "arm.yaml", path) == ["new: frame plate (fixed on base_link, plate_joint)"]


def test_several_changes_come_by_importance_then_by_the_tree(tmp_path: Path) -> None:
    path = changed(
        tmp_path,
        ("rgba: [0.8", "rgba: [0.9"),
        ("mass: 0.4", "mass: 0.5"),
        ("upper: 2, effort: 10", "upper: 1.9, effort: 10"),
        (
            "  elbow:\n    type: revolute\n    parent: upper_arm\n    child: fore_arm\n    xyz: [0.2",
            "  elbow:\n    type: revolute\n    parent: upper_arm\n    child: fore_arm\n    xyz: [0.21",
        ),
        ("xyz: [0, 0, 0.22]", "xyz: [0, 0, 0.25]"),
        ("mass: 0.1", "mass: 0.2"),
    )
    found = compared(DIFF / "arm.yaml", path)
    assert [(item["kind"], item["name"]) for item in found["differences"]] == [
        ("frame", "laser"),
        ("joint", "elbow"),
        ("limit", "shoulder"),
        ("mass", "mast"),
        ("mass", "finger"),
        ("visual", "base_link"),
    ]
    assert found["summary"] == "different: 1 frame, 1 joint, 1 limit, 2 masses, 1 visual"
    laser, elbow = found["differences"][:2]
    assert laser["distance"] == pytest.approx(0.03)
    assert (laser["angle"], laser["when"]) == (0, "always")
    assert elbow["distance"] == pytest.approx(0.01)


def test_an_axis_says_where_it_is_off_the_most(tmp_path: Path) -> None:
    path = changed(tmp_path, (SHOULDER, SHOULDER.replace("0, 1, 0", "0, 0.8, 0.6")))
    (item,) = compared(DIFF / "arm.yaml", path)["differences"]
    old, new = (_free(compile_robot(file).robot) for file in (DIFF / "arm.yaml", path))

    def off(position: float) -> float:
        return math.dist(*(robot.pose_in_root("tool", {"shoulder": position}).xyz for robot in (old, new)))

    assert item["when"] == "away from 0"
    assert item["distance"] == pytest.approx(off(item["at"]["shoulder"]), abs=1e-12)
    assert item["distance"] == pytest.approx(max(off(-1.5 + 0.01 * index) for index in range(351)), rel=0.01)


def _free(robot: Robot | None) -> Robot:
    """Return a robot whose followers are moved on their own, as diff moves them."""
    assert robot is not None
    return replace(robot, joints=tuple(replace(joint, mimic=None) for joint in robot.joints))
