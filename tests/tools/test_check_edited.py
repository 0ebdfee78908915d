"""check recognises an artifact that was edited by hand: it contradicts artifacts that are up to date."""

from __future__ import annotations

from pathlib import Path

import pytest

from rosorin_compile.cli.main import main
from support.commands import Shown, edit, write_files

ROBOT = """\
robot: mast
links:
  base_link: {inertial: &inertial {mass: 1, inertia: {ixx: 0.01, iyy: 0.01, izz: 0.01}}}
  mast: {inertial: *inertial}
joints:
  mast_joint:
    {type: revolute, parent: base_link, child: mast, xyz: [0, 0, 100 mm], axis: [0, 0, 1], actuator: {kp: 30},
     limit: {lower: -1, upper: 1, effort: 5, velocity: 2}}
outputs: {urdf: {file: mast.urdf}, mjcf: {file: mast.xml}, frames: {file: frames.md}}
"""
DESCRIPTION, URDF, MJCF = "descriptions/mast/robot.yaml", "outputs/mast/mast.urdf", "outputs/mast/mast.xml"
EDITED = " was edited: it differs from the other artifacts"


@pytest.mark.usefixtures("compiled")
@pytest.mark.parametrize(
    ("file", "old", "new", "line"),
    [
        (URDF, "0 0 0.1", "0 0 0.2", f"{URDF}{EDITED}"),
        (MJCF, 'pos="0 0 0.1"', 'pos="0 0 0.2"', f"{MJCF}{EDITED}"),
        (
            DESCRIPTION,
            "100 mm",
            "120 mm",
            "mast moved 20.0 mm in base_link: origin z 0.1 -> 0.12 m: urdf, mjcf, frames",
        ),
        (DESCRIPTION, "kp: 30", "kp: 40", "mast_joint kp 30 -> 40 N*m/rad"),
        (MJCF, 'kp="30"', 'kp="40"', "mast_joint kp 40 -> 30 N*m/rad"),  # no other artifact has it
    ],
)
def test_who_changed(file: str, old: str, new: str, line: str, capsys: Shown) -> None:
    edit(Path(file), old, new)
    assert main(["check"]) == 1
    assert capsys.readouterr().out.startswith(line)


@pytest.fixture
def compiled(home: Path, capsys: Shown) -> None:
    """The robot with its artifacts."""
    write_files(home, {DESCRIPTION: ROBOT})
    assert main(["all"]) == 0
    capsys.readouterr()
