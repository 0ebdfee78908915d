"""The driver's JSON read as a robot: what it says is there, in its place, and what is wrong with it is told by line."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

from rosorin_compile.formats.imported import Imported
from rosorin_compile.formats.reading import read_robot
from rosorin_compile.language.lower import lower
from rosorin_compile.model import Box, HeightMap
from rosorin_compile.source.diagnostics import has_errors
from support.comparing import told
from support.paths import ROOT

OURS = ROOT / "outputs" / "rosorin" / "robot_model.json"
JOINT: dict[str, Any] = {"type": "revolute", "parent": "a", "child": "b", "xyz": [0, 0, 1], "rpy": [0, 0, 0]}
JOINT |= {"axis": [0, 0, 1], "limit": [-1, 1]}
SMALL: dict[str, Any] = {"source": "", "joints": {"j": JOINT}, "boxes": {}}


def read(folder: Path, model: object) -> Imported:
    path = folder / "small.json"
    path.write_text(model if isinstance(model, str) else json.dumps(model), "utf-8")
    return read_robot(path)


def test_the_driver_model_of_the_reference_robot_is_read_whole() -> None:
    imported = read_robot(OURS)
    assert imported.tree is not None
    assert not has_errors(imported.diagnostics)
    robot = lower(imported.tree).robot
    assert robot is not None
    model = json.loads(OURS.read_text("utf-8"))
    assert list(robot.joint) == list(model["joints"])
    for name, said in model["joints"].items():
        joint = robot.joint[name]
        assert (joint.type, joint.parent, joint.child) == (said["type"], said["parent"], said["child"])
        assert (list(joint.origin.xyz), list(joint.origin.rpy)) == (said["xyz"], said["rpy"])
        limit = joint.limit and [joint.limit.lower, joint.limit.upper]
        assert limit == said["limit"]
    boxes = {link.name: s.geometry for link in robot.links for s in link.collision if isinstance(s.geometry, Box)}
    assert {n: {"min": list(b.lower), "max": list(b.upper)} for n, b in boxes.items()} == model["boxes"]
    (grid,) = [s.geometry for link in robot.links for s in link.collision if isinstance(s.geometry, HeightMap)]
    assert [list(line) for line in grid.heights] == model["chassis_heightmap"]["z"]
    (group,) = robot.servos
    assert group.radians(600) == pytest.approx(-100 * model["pulse_to_rad"]["rad_per_pulse"])
    # 2.09 rad are 498.95 pulses of 0.24 deg.
    assert group.pulse_range == (1, 999)
    assert robot.source.status == "imported"


def test_letters_beyond_the_first_plane_are_read(tmp_path: Path) -> None:
    imported = read(tmp_path, SMALL | {"source": 'a \U0001f916 and \\ud83d "\u00e9"'})
    assert imported.tree is not None
    assert imported.tree["source"]["note"] == 'from small.json: a \U0001f916 and \\ud83d "\u00e9"'


BROKEN: list[tuple[object, str, str]] = [
    ("", "file-empty", "is empty"),
    ("[]", "wrong-format", "does not match type"),
    ("{", "json-syntax", "not JSON: Expecting property name enclosed in double quotes"),
    ('{"source": NaN}', "json-syntax", "not JSON: a number is not finite"),
    ("[" * 100_000, "json-syntax", "not JSON: "),
    (SMALL | {"source": 1}, "wrong-format", 'not a driver\'s model: source: 1 does not match type "string"'),
    ({"source": "", "joints": {}}, "wrong-format", 'not a driver\'s model: the file: "boxes" is a required property'),
    ({"source": "", "joints": {}, "boxes": {}}, "no-links", 'the robot "small" has no links'),
    (
        SMALL | {"joints": {"j": JOINT | {"axis": [0, 0, 0]}}},
        "axis-zero",
        'the axis of joint "j" is zero: no direction',
    ),
    (SMALL | {"joints": {"j": JOINT | {"child": "a"}}}, "joint-cycle", 'joint "j" closes a circle: a -> a'),
]


@pytest.mark.parametrize(("model", "rule", "message"), BROKEN, ids=[f"{r}-{m[-20:]}" for _, r, m in BROKEN])
def test_a_broken_file_is_refused_with_the_reason(tmp_path: Path, model: object, rule: str, message: str) -> None:
    imported = read(tmp_path, model)
    assert imported.tree is None
    errors = [found for found in imported.diagnostics if found.severity == "error"]
    assert [found.rule for found in errors] == [rule]
    assert message in errors[0].message
    assert errors[0].help


def test_a_height_map_and_servos_differ_by_what_changed(tmp_path: Path) -> None:
    model = json.loads(OURS.read_text("utf-8"))
    model["chassis_heightmap"]["z"][3][4] += 0.01
    model["pulse_to_rad"]["zero"] = 510
    model["joints"]["joint2"]["xyz"][2] += 0.001
    path = tmp_path / "robot_model.json"
    path.write_text(json.dumps(model), "utf-8")
    assert told(OURS, path) == [
        "link2 moved 1.0 mm in link1: origin z 0.030345 -> 0.031345 m",
        "base_footprint height map: 1 cell changed, by 10.0 mm",
        "servo of joint1 zero pulse 500 -> 510",
    ]
