"""diff: each change is reported once, as in data/cases/diff.yaml; the same robot in other words is no change."""

import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import jsonschema
import pytest
import yaml

from rosorin_compile.formats.compilation import compile_robot
from rosorin_compile.model import Robot
from support.commands import write_files
from support.comparing import DIFF, changed, compared, told
from support.paths import data_text
from support.schemas import schema

ARM = DIFF / "arm.yaml"
SHOULDER = "axis: [0, 1, 0]\n    limit: {lower: -1.5, upper: 2,"


def sides(case: dict[str, Any], folder: Path) -> list[Path]:
    if "edits" in case:
        return [ARM, changed(folder, *case["edits"])]
    for side in "ab":
        write_files(folder / side, case[side])
    return [folder / side / name for side in "ab" for name in case[side]]


@pytest.mark.parametrize("case", yaml.safe_load(data_text("cases/diff.yaml")), ids=lambda case: case["name"])
def test_differences(case: dict[str, Any], tmp_path: Path) -> None:
    one, other = sides(case, tmp_path)
    found = compared(one, other)
    assert [item["text"] for item in found["differences"]] == case["reported"]
    assert found["notes"] == case.get("notes", [])
    jsonschema.validate(found, schema("robot_diff"))
    if not case["reported"]:
        assert told(other, one) == []


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
    assert told(ARM, path) == ["new: frame plate (fixed on base_link, plate_joint)"]


def test_several_changes_come_by_importance_then_by_the_tree(tmp_path: Path) -> None:
    elbow = "  elbow:\n    type: revolute\n    parent: upper_arm\n    child: fore_arm\n    xyz: [0.2"
    edits = [("rgba: [0.8", "rgba: [0.9"), ("mass: 0.4", "mass: 0.5"), ("upper: 2, effort: 1", "upper: 1.9, effort: 1")]
    edits += [(elbow, f"{elbow}1"), ("xyz: [0, 0, 0.22]", "xyz: [0, 0, 0.25]"), ("mass: 0.1", "mass: 0.2")]
    found = compared(ARM, changed(tmp_path, *edits))
    kinds = [(item["kind"], item["name"]) for item in found["differences"]]
    assert kinds[:3] == [("frame", "laser"), ("joint", "elbow"), ("limit", "shoulder")]
    assert kinds[3:] == [("mass", "mast"), ("mass", "finger"), ("visual", "base_link")]
    assert found["summary"] == "different: 1 frame, 1 joint, 1 limit, 2 masses, 1 visual"
    laser, elbow_moved = found["differences"][:2]
    assert (laser["distance"], laser["angle"], laser["when"]) == (pytest.approx(0.03), 0, "always")
    assert elbow_moved["distance"] == pytest.approx(0.01)


def test_an_axis_is_reported_where_it_is_off_the_most(tmp_path: Path) -> None:
    path = changed(tmp_path, (SHOULDER, SHOULDER.replace("0, 1, 0", "0, 0.8, 0.6")))
    (item,) = compared(ARM, path)["differences"]
    old, new = (_without_followers(compile_robot(file).robot) for file in (ARM, path))

    def off(position: float) -> float:
        return math.dist(*(robot.pose_in_root("tool", {"shoulder": position}).xyz for robot in (old, new)))

    assert item["when"] == "away from 0"
    assert item["distance"] == pytest.approx(off(item["at"]["shoulder"]), abs=1e-12)
    assert item["distance"] == pytest.approx(max(off(-1.5 + 0.01 * index) for index in range(351)), rel=0.01)


def _without_followers(robot: Robot | None) -> Robot:
    """Return a robot whose followers are moved on their own, as diff moves them."""
    assert robot is not None
    return replace(robot, joints=tuple(replace(joint, mimic=None) for joint in robot.joints))


def test_a_urdf_has_the_mass_of_what_another_node_moves(tmp_path: Path) -> None:
    """It does not move there, and belongs to the body that carries it."""
    solid = "{inertial: {mass: %s, of: collision}, collision: [{sphere: {radius: 0.1}}]}"
    path = tmp_path / "a.yaml"
    path.write_text(
        f"robot: r\nlinks: {{root: {{}}, base: {solid % 1}, arm: {solid % 0.5}, hand: {solid % 0.2}}}\njoints:\n"
        "  f: {type: fixed, parent: root, child: base}\n"
        "  turn: {type: continuous, parent: base, child: arm, axis: [0, 1, 0], xyz: [0, 0, 0.2], publisher: driver}\n"
        "  bend: {type: continuous, parent: base, child: hand, axis: [0, 1, 0], xyz: [0, 0.3, 0.2]}\n"
        "publishers: {driver: {}}\noutputs: {urdf: {file: r.urdf}}\n",
        "utf-8",
    )
    urdf = tmp_path / "r.urdf"
    urdf.write_text(compile_robot(path).artifacts[0].text, "utf-8")
    assert told(path, urdf) == told(urdf, path) == []
    urdf.write_text(urdf.read_text("utf-8").replace('mass value="0.2"', 'mass value="0.3"'), "utf-8")
    assert told(path, urdf) == ["hand mass 0.2 -> 0.3 kg (+100.0 g)"]
