"""MJCF becomes a description that is the same robot: MuJoCo has the file, pinocchio the URDF that we make of it.

Every file in tests/data/mjcf/corners and tests/data/mjcf/public is imported, and so is what our own compiler writes.
"""

import struct
import zlib
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest

pytest.importorskip("mujoco", minversion="4")

from dataclasses import replace

from rosorin_compile.formats.imported_robot import ReadOptions
from rosorin_compile.model import Joint
from rosorin_compile.mujoco.mjcf.robot import read_mjcf
from support.mjcf_oracle import Case, frames_differ, imported, inertias_differ, limits_differ, shapes_differ
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


def holds(case: Case, folder: Path) -> None:
    assert frames_differ(case, STATES) < SAME
    assert inertias_differ(case) < SAME
    assert limits_differ(case) < SAME
    assert shapes_differ(case, folder) < 1e-6  # MuJoCo keeps vertices with seven digits


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
    holds(imported(path), path.parent)


def driven(joint: Joint) -> tuple[object, float]:
    """Return what drives a joint, and all its damping: an MJCF of ours has that of the drive in that of the joint."""
    return joint.actuator and replace(joint.actuator, damping=0.0), joint.braking


def test_our_own_mjcf_comes_back() -> None:
    case = imported(OUTPUTS / "rosorin.xml")
    holds(case, OUTPUTS)
    robot = compiled().robot
    assert robot is not None
    assert case.robot.root == robot.root
    assert set(robot.link) <= set(case.robot.link)
    moving = {joint.name: joint for joint in robot.joints if joint.moves}
    ours = {joint.name: joint for joint in case.robot.joints if joint.moves}
    assert {name: (j.type, j.parent, j.child, j.mimic) for name, j in moving.items()} == {
        name: (j.type, j.parent, j.child, j.mimic) for name, j in ours.items()
    }
    assert {name: driven(j) for name, j in moving.items()} == {name: driven(j) for name, j in ours.items()}
    assert {pose.name for pose in case.robot.poses} == {"home", *(pose.name for pose in robot.poses)}
    for name, link in robot.link.items():
        solids = [solid for shape in link.collision for solid in shape.solids("merged")]
        assert len(case.robot.link[name].collision) == len(solids)
        assert bool(case.robot.link[name].visual) == bool(link.visual)


@pytest.mark.landing("engines", *(path.parent.name for path in AT_A_LANDING))
@pytest.mark.parametrize("path", EXAMPLES, ids=lambda path: path.parent.name)
def test_examples_come_back_from_their_mjcf(path: Path, tmp_path: Path) -> None:
    robot = compiled(path).robot
    assert robot is not None
    file = tmp_path / "robot.xml"
    file.write_text(emit(robot), "utf-8")
    case = imported(file)
    holds(case, tmp_path)
    for joint in robot.joints:
        if joint.moves:
            again = case.robot.joint[joint.name]
            assert (again.type, again.parent, again.child) == (joint.type, joint.parent, joint.child)
            if joint.limit is not None and again.limit is not None:
                assert again.limit.lower == pytest.approx(joint.limit.lower, abs=1e-12)
                assert again.limit.effort == joint.limit.effort


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
    pixels = b"\0\xff\xff\xff"
    chunks = [(b"IHDR", b"\0\0\0\1\0\0\0\1\x08\x02\0\0\0"), (b"IDAT", zlib.compress(pixels)), (b"IEND", b"")]
    png = [struct.pack(">I", len(d)) + k + d + struct.pack(">I", zlib.crc32(k + d)) for k, d in chunks]
    (tmp_path / "look" / "t.png").write_bytes(b"\x89PNG\r\n\x1a\n" + b"".join(png))
    made = read_mjcf(tmp_path / "robot.xml", ReadOptions())
    assert made.tree is not None, made.diagnostics
    names = [file.relative_to(tmp_path).as_posix() for file in made.files]
    assert names == ["robot.xml", "solid/m.obj", "solid/h.bin", "look/t.png"]


def test_pairs_that_may_touch_are_those_of_the_file() -> None:
    pairs = tree("free")["disabled_contacts"]
    assert [list(pair["links"]) for pair in pairs] == [["trunk", "leg"], ["tail", "leg"]]
    assert [pair.span.line for pair in pairs] == [29, 30]
    assert {pair["reason"] for pair in pairs} == {"excluded from contact in the MJCF"}


@pytest.mark.parametrize("name", ["anchors", "balls", "hopper", "masses"])
def test_a_second_turn_is_the_same_robot(name: str, tmp_path: Path) -> None:
    """MJCF -> description -> MJCF -> description: links between joints have no mass in either."""
    first = imported({**CORNERS, **PUBLIC}[name])
    file = tmp_path / "robot.xml"
    file.write_text(emit(first.robot), "utf-8")
    second = imported(file)
    assert frames_differ(second, 20) < SAME
    assert set(first.robot.link) == set(second.robot.link)
    for joint in first.robot.joints:
        again = second.robot.joint[joint.name]
        assert (again.type, again.parent, again.child) == (joint.type, joint.parent, joint.child)
        assert again.origin.xyz == pytest.approx(joint.origin.xyz, abs=1e-12)
    for name, link in first.robot.link.items():
        ours, theirs = link.inertial, second.robot.link[name].inertial
        assert (ours is None) == (theirs is None), name
        if ours is not None and theirs is not None:
            assert theirs.mass == pytest.approx(ours.mass, rel=1e-12)
