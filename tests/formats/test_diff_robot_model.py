"""The driver's JSON read as a robot: what it says is there, in its place, and what is wrong with it is told by line."""

from __future__ import annotations

import json
from pathlib import Path

from support.comparing import told
from support.paths import ROOT

OURS = ROOT / "outputs" / "rosorin" / "robot_model.json"


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
