"""What check says of a change of the description is what diff says of the two descriptions, in the same words."""

from __future__ import annotations

from pathlib import Path

import pytest

from rosorin_compile.output.committed import compare
from support.comparing import DIFF, changed, told
from support.robots import compiled

PLANTED = [
    ("xyz: [0, 0, 0.22]", "xyz: [0, 0, 0.25]"),
    ("rpy: [0, 0, 3.141592653589793]", "rpy: [0, 0, 0]"),
    ("xyz: [0.1, 0, 0.16]", "xyz: [0.1, 0, 0.17]"),
    ("xyz: [0.1, 0, 0.16]\n    rpy: [0, 0, 0.1]", "xyz: [0.1, 0, 0.17]\n    rpy: [0, 0, 0.2]"),
    ("type: revolute\n    parent: upper_arm", "type: prismatic\n    parent: upper_arm"),
    ("parent: fore_arm\n    child: slider", "parent: upper_arm\n    child: slider"),
    ("upper: 2, effort: 10", "upper: 1.9, effort: 10"),
    ("effort: 10", "effort: 11"),
    ("velocity: 0.2", "velocity: 0.25"),
    ("damping: 0.5", "damping: 0.6"),
    ("armature: 0.01", "armature: 0.02"),
    ("multiplier: 5", "multiplier: -5"),
    ("    mimic: {joint: slide, multiplier: 5, offset: 0.1}\n", ""),
    ("effort: 5, velocity: 3}", "effort: 5, velocity: 3}\n    safety_controller: {k_velocity: 10}"),
    ("mass: 2,", "mass: 2.1,"),
    ("xyz: [0.1, 0, 0], rpy: [0, 0, 0.3]", "xyz: [0.1, 0, 0.01], rpy: [0, 0, 0.3]"),
    ("izz: 0.04", "izz: 0.03"),
    ("radius: 0.04, length: 0.06", "radius: 0.04, length: 0.07"),
    ("capsule: {radius: 0.03", "cylinder: {radius: 0.03"),
    ("size: [0.02, 0.02, 0.2]", "size: [0.02, 0.03, 0.2]"),
    ("sphere: {radius: 0.02}", "sphere: {radius: 0.021}"),
    ("      - {cylinder: {radius: 0.04, length: 0.06}, xyz: [0.1, 0, 0.13]}\n", ""),
    ("rgba: [0.8", "rgba: [0.9"),
    ("  mast_joint: {type: fixed", "  mast_fix: {type: fixed"),
    ("publisher: tf_laser}", "publisher: tf_scan}"),
    ("elbow: -1", "elbow: -1.1"),
]


@pytest.mark.parametrize(("old", "new"), PLANTED, ids=[new.strip() for _, new in PLANTED])
def test_check_and_diff_say_the_same_sentence(tmp_path: Path, old: str, new: str) -> None:
    path = changed(tmp_path, (old, new))
    (line,) = told(DIFF / "arm.yaml", path)
    assert line in _said_by_check(path)


def test_an_axis_is_said_alike_and_diff_adds_how_far_it_reaches(tmp_path: Path) -> None:
    path = changed(
        tmp_path, ("axis: [0, 1, 0]\n    limit: {lower: -1.5", "axis: [0, 0.8, 0.6]\n    limit: {lower: -1.5")
    )
    (line,) = told(DIFF / "arm.yaml", path)
    assert any(line.startswith(f"{said}: ") for said in _said_by_check(path)), line


def _said_by_check(path: Path) -> list[str]:
    before, after = compiled(DIFF / "arm.yaml"), compiled(path)
    assert after.robot is not None
    committed = {artifact.file: artifact.text.encode() for artifact in before.artifacts}
    changes = compare(after.robot, after.artifacts, committed).changes
    return [change.text for change in changes]
