"""Corners of what check says of committed artifacts: names that other things have, too, and what a change explains."""

from __future__ import annotations

from pathlib import Path

import pytest
import yaml

from rosorin_compile.model import Robot
from rosorin_compile.output.committed import Comparison, compare
from support.paths import data_text
from support.robots import compiled_text, sound

OUTPUTS = "outputs: {urdf: {file: r.urdf}, mjcf: {file: r.xml}, frames: {file: frames.md}, static_tf: {file: tf.py}}\n"
SOLID = "{mass: 1, inertia: {ixx: 0.1, iyy: 0.1, izz: 0.1}}"
HINGE = "axis: [0, 0, 1], limit: {lower: -1, upper: 1, effort: 1, velocity: 1}"
ROBOT = data_text("robots/committed_corners_robot.yaml")

CASES = yaml.safe_load(data_text("cases/committed_corners.yaml"))
CHANGES = CASES["changes"]


# A height map that boxes are made from, and frames that some artifacts leave out and carry the shapes of.
MAPPED = data_text("robots/committed_corners_mapped.yaml")
BOTH = [("radius: 0.2}, rgba", "radius: 0.25}, rgba"), ("radius: 0.2}}]\n  eye", "radius: 0.25}}]\n  eye")]

OF_MAPPED = CASES["of_mapped"]


@pytest.mark.parametrize(
    ("before", "changes", "said"),
    [
        pytest.param(text, *cases[what], id=what)
        for text, cases in ((ROBOT, CHANGES), (MAPPED, OF_MAPPED))
        for what in cases
    ],
)
def test_what_is_said(tmp_path: Path, before: str, changes: list[tuple[str, str]], said: list[str]) -> None:
    after = before
    for old, new in changes:
        assert after.count(old) == 1, old
        after = after.replace(old, new)
    assert [change.line() for change in _compared(tmp_path, before, after)[1].changes] == said


def _compared(folder: Path, before: str, after: str) -> tuple[Robot, Comparison]:
    """Return the robot of the text after, and what its artifacts say that those of the text before do not."""
    _, _, old = sound(compiled_text(folder, before))
    robot, _, new = sound(compiled_text(folder, after))
    committed = {artifact.file: artifact.text.encode() for artifact in old.artifacts}
    return robot, compare(robot, new.artifacts, committed)
