"""URDF -> description -> MJCF, against MuJoCo's own import of the URDF: frames, masses, inertias and shapes agree.

MuJoCo is told to keep fixed links and visuals. It knows no ``package://`` and no mesh that is not there, so shapes of
meshes are left out of both; and it wants mass under every joint, so moving links without it are given some. Links
without an inertial have no mass of ours, where MuJoCo would fill their collision shapes with water.
"""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np
import pytest
from numpy.typing import NDArray

mujoco = pytest.importorskip("mujoco", minversion="3.12")

from rosorin_compile.formats.imported_robot import ReadOptions  # noqa: E402
from rosorin_compile.formats.robot_files import read_robot  # noqa: E402
from rosorin_compile.formats.templating import Templates  # noqa: E402
from rosorin_compile.formats.urdf import write as urdf  # noqa: E402
from rosorin_compile.language.lower import lower  # noqa: E402
from rosorin_compile.model import Output, Robot  # noqa: E402
from support.images import png  # noqa: E402
from support.paths import OUTPUTS, ROOT  # noqa: E402
from support.robots import compiled  # noqa: E402
from support.simulator import emit, load, pose, random_states  # noqa: E402

pytestmark = pytest.mark.slow

SETTINGS = '<mujoco><compiler fusestatic="false" strippath="false" discardvisual="false"/></mujoco>'
EXAMPLES = sorted(ROOT.glob("examples/*/robot.yaml"))
FOLDERS = ("tests/data", "tests/data/mjcf/urdf", "tests/imported/*", "tests/round_trip/*")
FILES = sorted({OUTPUTS / "rosorin.urdf", *(path for folder in FOLDERS for path in ROOT.glob(f"{folder}/*.urdf"))})
INERTIAL = '<inertial><mass value="2"/><inertia ixx="0.3" ixy="0.01" ixz="0" iyy="0.2" iyz="0" izz="0.4"/></inertial>'
STATES = 200
_MESHES = re.compile(r"<(visual|collision)[^<>]*>(?:(?!</\1>).)*?<mesh.*?</\1>", re.DOTALL)


def both(text: str, folder: Path) -> tuple[Robot, Any, Any]:
    """Return the robot that was imported from a URDF, our MJCF of it, and MuJoCo's own import, both compiled."""
    path = folder / "robot.urdf"
    path.write_text(with_masses(_MESHES.sub("", text)), "utf-8")
    imported = read_robot(path, ReadOptions())
    assert imported.tree is not None, [d.message for d in imported.diagnostics]
    robot = lower(imported.tree).robot
    assert robot is not None
    text_of_ours = emit(robot, visuals="own")
    pictures = {found: png(0) for found in re.findall(r'<texture [^>]*file="([^"]+)"', text_of_ours)}
    ours, _ = load(text_of_ours, pictures)
    with_settings = re.sub(r"(<robot\b[^>]*>)", rf"\1{SETTINGS}", path.read_text("utf-8"), count=1)
    theirs, _ = load(with_settings)
    return robot, ours, theirs


def with_masses(text: str) -> str:
    """Return a URDF in which every link that a joint moves has mass."""
    root = ElementTree.fromstring(text)
    for joint in root.iter("joint"):
        child = joint.find("child")
        if joint.get("type") not in (None, "fixed") and child is not None:
            link = root.find(f"link[@name='{child.get('link')}']")
            if link is not None and link.find("inertial") is None:
                link.append(ElementTree.fromstring(INERTIAL))
    return ElementTree.tostring(root, encoding="unicode")


def frame(model: Any, data: Any, name: str) -> NDArray[np.float64]:
    """Return where a link is, as a 4x4 matrix; MuJoCo's import makes the root link of a URDF its world."""
    index = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_BODY, name)
    made = np.eye(4)
    if index > 0:
        made[:3, :3], made[:3, 3] = data.xmat[index].reshape(3, 3), data.xpos[index]
    return made


def agree(robot: Robot, ours: Any, theirs: Any) -> None:
    """Fail unless both models are the same robot."""
    here, there = mujoco.MjData(ours), mujoco.MjData(theirs)
    for positions in random_states(robot, STATES):
        pose(robot, ours, here, positions)
        pose(robot, theirs, there, positions)
        for link in robot.link:
            assert np.abs(frame(ours, here, link) - frame(theirs, there, link)).max() < 1e-9, link
    for name in robot.link:
        if mujoco.mj_name2id(theirs, mujoco.mjtObj.mjOBJ_BODY, name) <= 0:
            continue
        if robot.link[name].inertial is None:
            assert ours.body(name).mass == 0, name
        else:
            assert ours.body(name).mass == pytest.approx(theirs.body(name).mass, abs=1e-12, rel=1e-9), name
            assert np.abs(inertia(ours, name) - inertia(theirs, name)).max() < 1e-9, name
        counts = [int((model.geom_bodyid == model.body(name).id).sum()) for model in (ours, theirs)]
        assert counts[0] == counts[1], name
    assert equalities(ours) == equalities(theirs)
    for joint in robot.joints:
        if joint.moves:
            a, b = ours.joint(joint.name), theirs.joint(joint.name)
            assert np.abs(a.range - b.range).max() < 1e-12
            assert np.abs(a.axis - b.axis).max() < 1e-9
            assert (a.damping, a.frictionloss) == (b.damping, b.frictionloss)


def equalities(model: Any) -> list[tuple[str, str, list[float]]]:
    """Return follower, leader and coefficients of each joint that follows another."""
    names = [[model.joint(index).name for index in ids] for ids in (model.eq_obj1id, model.eq_obj2id)]
    return sorted((first, second, row[:5].tolist()) for first, second, row in zip(*names, model.eq_data, strict=True))


def inertia(model: Any, name: str) -> NDArray[np.float64]:
    """Return the inertia of a body about the origin and along the axes of its frame, 3x3."""
    body = model.body(name)
    turn = np.empty(9)
    mujoco.mju_quat2Mat(turn, body.iquat)
    rows, at, mass = turn.reshape(3, 3), body.ipos, body.mass[0]
    return rows @ np.diag(body.inertia) @ rows.T + mass * (at @ at * np.eye(3) - np.outer(at, at))


@pytest.mark.parametrize("path", FILES, ids=lambda path: path.stem)
def test_a_urdf_becomes_the_mjcf_that_mujoco_would_make(path: Path, tmp_path: Path) -> None:
    agree(*both(path.read_text("utf-8"), tmp_path))


@pytest.mark.parametrize("path", EXAMPLES, ids=lambda path: path.parent.name)
def test_an_example_becomes_the_mjcf_that_mujoco_would_make(path: Path, tmp_path: Path) -> None:
    robot = compiled(path).robot
    assert robot is not None
    text = urdf.write(robot, Output("urdf", "urdf", "robot.urdf", {}), Templates())[0]
    agree(*both(text, tmp_path))
