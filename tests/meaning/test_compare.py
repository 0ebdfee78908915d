"""What a change of the description does to the artifacts is said by meaning, in exact words."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
import yaml

from support.comparing import described, meaning
from support.paths import data_text

CHANGES = yaml.safe_load(data_text("cases/compare_changes.yaml"))


@pytest.mark.slow
@pytest.mark.parametrize("change", CHANGES, ids=lambda change: change["id"])
def test_a_change_of_the_description_is_named(change: dict[str, Any], tmp_path: Path) -> None:
    edits = change.get("edits") or [[change["file"], change["old"], change["new"]]]
    comparison = described(tmp_path, *edits)
    assert meaning(comparison) == change["said"]
    assert comparison.texts


def test_a_joint_that_moves_now_is_one_line(tmp_path: Path) -> None:
    moving = "type: revolute\n    axis: [0, 0, 1]\n    limit: {lower: -1, upper: 1, effort: 1, velocity: 1}"
    said = meaning(described(tmp_path, ("camera.yaml", "type: fixed", moving)))
    assert said[:2] == [
        "camera_link0: topic /tf_static -> /tf: frames",
        "camera_connect_joint type fixed -> revolute: urdf, urdf_sim, mjcf, robot_model",
    ]
    assert {" ".join(line.split()[:2]).rstrip(":") for line in said[2:]} <= {
        "contact pair",
        "contact pairs",
        "excluded contacts",
    }
