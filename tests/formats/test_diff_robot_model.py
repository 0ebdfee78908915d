"""The driver's JSON read as a robot: what it says is there, in its place, and what is wrong with it is told by line."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from rosorin_compile.formats.robot_files import read_robot
from rosorin_compile.language.lower import lower
from rosorin_compile.model import Box, HeightMap
from rosorin_compile.source.diagnostics import has_errors
from support.comparing import told
from support.paths import ROOT

OURS = ROOT / "outputs" / "rosorin" / "robot_model.json"


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
