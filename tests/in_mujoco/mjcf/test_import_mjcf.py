"""MJCF becomes a description that is the same robot: MuJoCo has the file, pinocchio the URDF that we make of it.

Every file in tests/data/mjcf/corners and tests/data/mjcf/public is imported, and so is what our own compiler writes.
"""

from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest

pytest.importorskip("mujoco", minversion="3.12")

from dataclasses import replace

from rosorin_compile.formats.imported_robot import ReadOptions
from rosorin_compile.model import Joint
from rosorin_compile.mujoco.mjcf import process
from rosorin_compile.mujoco.mjcf.robot import read_mjcf
from support.images import png
from support.mjcf_oracle import Case, frames_differ, imported
from support.paths import DATA, OUTPUTS, ROOT
from support.robots import compiled
from support.simulator import emit

pytestmark = pytest.mark.slow

MJCF = DATA / "mjcf"
CORNERS = {path.stem: path for path in sorted(MJCF.glob("corners/*.xml"))}
PUBLIC = {path.stem: path for path in sorted(MJCF.glob("public/*.xml"))}
EXAMPLES = sorted(ROOT.glob("examples/*/robot.yaml"))
AT_A_LANDING = [path for path in EXAMPLES if path.parent.name == "unitree_a1"]
STATES = 200
SAME = 1e-9


def holds(case: Case) -> None:
    assert frames_differ(case, STATES) < SAME
    proof = process.prove(case.imported, case.text, {})
    assert (proof.wrong, proof.unknown) == ({}, "")


def said(path: Path) -> list[str]:
    """Return what is said of a file, as line: severity[rule]: message."""
    return [
        f"{d.span.line if d.span else 0}: {d.severity}[{d.rule}]: {d.message}"
        for d in read_mjcf(path, ReadOptions()).diagnostics
    ]


@cache
def tree(name: str) -> Any:
    made = read_mjcf(CORNERS[name], ReadOptions())
    assert made.tree is not None, said(CORNERS[name])
    return made.tree


@pytest.mark.parametrize("name", [*CORNERS, *PUBLIC])
def test_the_robot_is_the_same(name: str) -> None:
    path = {**CORNERS, **PUBLIC}[name]
    holds(imported(path))


def driven(joint: Joint) -> tuple[object, float]:
    """Return what drives a joint, and all its damping: an MJCF of ours has that of the drive in that of the joint."""
    return joint.actuator and replace(joint.actuator, damping=0.0), joint.total_damping


def test_our_own_mjcf_comes_back() -> None:
    case = imported(OUTPUTS / "rosorin.xml")
    holds(case)
    robot = compiled().robot
    assert robot is not None
    assert case.robot.root == robot.root
    assert set(robot.link) <= set(case.robot.link)
    moving = {joint.name: joint for joint in robot.joints if joint.moves}
    ours = {joint.name: joint for joint in case.robot.joints if joint.moves}
    for name, joint in moving.items():
        again = ours[name]
        assert (again.type, again.parent, again.child, again.mimic) == (
            joint.type,
            joint.parent,
            joint.child,
            joint.mimic,
        )
        assert driven(again) == driven(joint)
    assert {pose.name for pose in case.robot.poses} == {"home", *(pose.name for pose in robot.poses)}


@pytest.mark.landing("engines", *(path.parent.name for path in AT_A_LANDING))
@pytest.mark.parametrize("path", EXAMPLES, ids=lambda path: path.parent.name)
def test_examples_come_back_from_their_mjcf(path: Path, tmp_path: Path) -> None:
    robot = compiled(path).robot
    assert robot is not None
    file = tmp_path / "robot.xml"
    file.write_text(emit(robot), "utf-8")
    case = imported(file)
    holds(case)


def test_the_files_that_were_read_include_meshes_height_fields_and_textures(tmp_path: Path) -> None:
    text = (
        '<mujoco><compiler meshdir="solid" texturedir="look"/><asset><mesh name="m" file="m.obj"/>'
        '<hfield name="h" file="h.bin" size="1 1 1 1"/><texture name="t" type="2d" file="t.png"/></asset>'
        '<worldbody><geom type="hfield" hfield="h"/><body name="b"><geom type="mesh" mesh="m"/></body></worldbody>'
        "</mujoco>"
    )
    (tmp_path / "robot.xml").write_text(text, "utf-8")
    for folder in ("solid", "look"):
        (tmp_path / folder).mkdir()
    corners = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n"
    (tmp_path / "solid" / "m.obj").write_text(corners, "utf-8")
    (tmp_path / "solid" / "h.bin").write_bytes(np.array([2, 2], np.int32).tobytes() + np.ones(4, np.float32).tobytes())
    (tmp_path / "look" / "t.png").write_bytes(png(10))
    made = read_mjcf(tmp_path / "robot.xml", ReadOptions())
    assert made.tree is not None, made.diagnostics
    names = [file.relative_to(tmp_path).as_posix() for file in made.files]
    assert names == ["robot.xml", "solid/m.obj", "solid/h.bin", "look/t.png"]


def test_pairs_that_may_touch_are_those_of_the_file() -> None:
    pairs = tree("free")["disabled_contacts"]
    assert [list(pair["links"]) for pair in pairs] == [["trunk", "leg"], ["tail", "leg"]]
    assert [pair.span.line for pair in pairs] == [29, 30]
    assert {pair["reason"] for pair in pairs} == {"excluded from contact in the MJCF"}
