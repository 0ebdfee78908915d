"""SRDFs that people have, read beside the URDF in tests/data/srdf: what is kept, what is told, what is refused.

The comment of each file in tests/data/srdf/told and tests/data/srdf/bad lists its diagnostics (see support/cases.py).
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from rosorin_compile.cli.main import main
from rosorin_compile.formats.imported import Imported, ReadOptions
from rosorin_compile.formats.reading import join, read_robot
from rosorin_compile.language.lower import lower
from rosorin_compile.model import DisabledCollision, Robot
from rosorin_compile.ros.moveit import Ball, Moveit, VirtualJoint
from support.cases import as_xml_comment, check
from support.commands import Shown
from support.paths import DATA

FILES = DATA / "srdf"
TOLD = sorted(FILES.glob("told/*.srdf"))
BAD = sorted(FILES.glob("bad/*.srdf"))


def joined(file: Path, **options: Any) -> Imported:
    """Return the arm with what an SRDF says of it."""
    how = ReadOptions(**options)
    return join(read_robot(FILES / "arm.urdf", how), "srdf", file, how)


def robot_of(imported: Imported) -> tuple[Robot, Moveit]:
    """Return a robot, and what it has for MoveIt."""
    assert imported.tree is not None
    robot = lower(imported.tree).robot
    assert robot is not None
    assert robot.moveit is not None
    return robot, robot.moveit


@pytest.mark.parametrize("file", [*TOLD, *BAD], ids=lambda file: file.stem)
def test_message(file: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(file.parent)
    made = joined(Path(file.name))
    assert (made.tree is None) == (file in BAD)
    check(file, as_xml_comment(made.diagnostics, file.name))
    carried_not = [one for one in made.diagnostics if one.rule == "import-cannot-carry"]
    assert len(made.left_out) == len(carried_not)


@pytest.mark.parametrize("file", [file for file in BAD if file.stem in ("misspelt", "numbers")], ids=lambda f: f.stem)
def test_a_misspelt_word_can_be_left_out(file: Path) -> None:
    made = joined(file, lenient=True)
    assert (made.tree is not None) == (file.stem == "misspelt")


def test_every_word_is_kept() -> None:
    made = joined(FILES / "everything.srdf")
    assert not made.diagnostics
    _, moveit = robot_of(made)
    assert moveit.virtual_joint == VirtualJoint("planar", "odom", "world_joint")
    groups = {group.name: group for group in moveit.groups}
    assert list(groups) == ["arm", "hand", "base", "all", "forked"]
    assert groups["arm"].chain == ("base_link", "tool")
    assert groups["hand"].links == ("left", "right")
    assert groups["base"].joints == ("world_joint",)
    assert groups["all"].groups == ("arm", "hand")
    assert (groups["forked"].chain, groups["forked"].joints) == (("base_link", "upper"), ("grip",))
    (gripper,) = moveit.end_effectors
    assert (gripper.name, gripper.group, gripper.parent, gripper.parent_group) == ("gripper", "hand", "tool", "arm")
    assert moveit.passive_joints == ("caster",)
    assert moveit.joint_properties == {"world_joint": {"motion_model": "diff_drive"}, "elbow": {"weight": "1.50"}}
    assert moveit.spheres == {"upper": (Ball((0, 0, 0.1), 0.05), Ball((0, 0, 0.2), 0.05)), "wheel": ()}
    assert moveit.unchecked_links == ("wheel",)
    assert moveit.checked == (("lower", "wheel"),)
    assert moveit.disabled == (
        DisabledCollision(("base_link", "upper"), "Adjacent"),
        DisabledCollision(("left", "lower"), "User"),
        DisabledCollision(("left", "right"), "they close on each other"),
    )


def test_states_of_one_name_are_one_pose_where_they_agree() -> None:
    robot, moveit = robot_of(joined(FILES / "everything.srdf"))
    poses = {pose.name: dict(pose.positions) for pose in robot.poses}
    assert poses == {
        "home": {"shoulder": 0.5, "elbow": -1.25, "grip": 0.01},
        "bent_arm": {"elbow": 1},
        "bent_all": {"elbow": 2, "shoulder": 0},
        "parked": {},
    }
    (parked,) = [pose for pose in robot.poses if pose.name == "parked"]
    assert parked.base is not None
    assert (parked.base.xyz, parked.base.rpy) == ((1, 2, 0), (0, 0, 0.5))
    states = {group.name: group.states for group in moveit.groups}
    assert states == {
        "arm": {"home": "home", "bent": "bent_arm"},
        "hand": {"home": "home"},
        "base": {"parked": "parked"},
        "all": {"bent": "bent_all"},
        "forked": {},
    }


def test_what_is_imported_compiles_to_the_same(home: Path, capsys: Shown) -> None:
    sources = [str(FILES / "arm.urdf"), "--srdf", str(FILES / "everything.srdf")]
    assert main(["import", *sources, "-o", "first"]) == 0
    assert main(["all", "first", "-o", "out/first"]) == 0
    made = capsys.readouterr().out
    assert "arm.srdf" in made
    one = joined(FILES / "everything.srdf")
    how = ReadOptions()
    (urdf,) = home.rglob("arm.urdf")
    other = join(read_robot(urdf, how), "srdf", urdf.with_suffix(".srdf"), how)
    (robot, moveit), (again, said) = robot_of(one), robot_of(other)
    assert said == moveit
    assert [(pose.name, pose.positions, pose.base) for pose in again.poses] == [
        (pose.name, pose.positions, pose.base) for pose in robot.poses
    ]


@pytest.mark.usefixtures("home")
def test_a_srdf_alone_is_no_robot(capsys: Shown) -> None:
    assert main(["import", str(FILES / "everything.srdf")]) == 1
    said = capsys.readouterr().err
    assert "error[wrong-format]: this is an SRDF, which belongs to a robot and has none itself" in said
    assert f"import ROBOT --srdf {FILES / 'everything.srdf'} reads both" in " ".join(said.split())


@pytest.mark.usefixtures("home")
def test_a_srdf_that_is_not_there(capsys: Shown) -> None:
    assert main(["import", str(FILES / "arm.urdf"), "--srdf", str(FILES / "everythin.srdf")]) == 2
    assert 'everythin.srdf is not there; did you mean "' in capsys.readouterr().err


@pytest.mark.usefixtures("home")
def test_strictly_what_is_not_carried_is_an_error(capsys: Shown) -> None:
    command = ["import", str(FILES / "arm.urdf"), "--srdf", str(FILES / "told" / "others.srdf")]
    assert main([*command, "--strict"]) == 1
    assert "error[import-cannot-carry]" in capsys.readouterr().err
    assert main(command) == 0
