"""A mirrored use of a part is the reflection of the part, across each axis, at joint states that are not zero."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

np = pytest.importorskip("numpy")

from rosorin_compile.model import Pose, Robot  # noqa: E402
from support.robots import compiled_text, sound  # noqa: E402

PART = """\
robot: r
parts:
  arm:
    links:
      upper:
        inertial: {mass: 1, xyz: [0.1, 0.2, 0.3], rpy: [0.1, 0.2, 0.3],
                   inertia: {ixx: 0.03, iyy: 0.04, izz: 0.05, ixy: 0.001, ixz: 0.002, iyz: 0.003}}
        collision:
          - {box: {min: [-0.1, -0.2, -0.3], max: [0.3, 0.5, 0.7]}, xyz: [0.1, 0.2, 0.3], rpy: [0.3, 0.2, 0.1]}
        visual: [{mesh: {file: a.stl, scale: [1, 2, 3]}, xyz: [0.3, 0.2, 0.1], rpy: [0.2, 0.3, 0.1]}]
      lower: {}
      hand: {}
    joints:
      turn: {type: revolute, parent: mount, child: upper, xyz: [0.1, 0.2, 0.3], rpy: [0.3, 0.1, 0.2],
             axis: [0.6, 0, 0.8], limit: {lower: -2, upper: 2, effort: 1, velocity: 1}}
      slide: {type: prismatic, parent: upper, child: lower, xyz: [0.2, 0.3, 0.1], rpy: [0.1, 0.3, 0.2],
              axis: [0, 0.6, 0.8], limit: {lower: -2, upper: 2, effort: 1, velocity: 1}}
      spin: {type: continuous, parent: lower, child: hand, xyz: [0.3, 0.1, 0.2], rpy: [0.2, 0.1, 0.3]}
links: {base: {}}
use:
  plain: {part: arm, parent: base, xyz: [0.1, 0, 0.2], rpy: [0, 0.2, 0]}
  twin: {part: arm, parent: base, xyz: [0.1, 0, 0.2], rpy: [0, 0.2, 0], mirror: AXIS}
"""
MOUNT = Pose((0.1, 0.0, 0.2), (0.0, 0.2, 0.0))
STATE = {"turn": 0.5, "slide": 0.3, "spin": -0.7}


def matrix(transform: Any) -> Any:
    made = np.eye(4)
    made[:3, :3], made[:3, 3] = transform.rows, transform.xyz
    return made


@pytest.fixture(name="mirrored", params=range(3), ids="xyz")
def _mirrored(request: pytest.FixtureRequest, tmp_path: Path) -> tuple[Robot, Any]:
    robot, _, _ = sound(compiled_text(tmp_path, PART.replace("AXIS", "xyz"[request.param])))
    reflection = np.eye(4)
    reflection[request.param, request.param] = -1
    return robot, reflection


def test_frames_are_reflected(mirrored: tuple[Robot, Any]) -> None:
    robot, reflection = mirrored
    state = {f"{use}_{joint}": value for use in ("plain", "twin") for joint, value in STATE.items()}
    mount = matrix(MOUNT.transform())
    for link in ("upper", "lower", "hand"):
        plain, twin = (matrix(robot.pose_in_root(f"{use}_{link}", state)) for use in ("plain", "twin"))
        expected = mount @ reflection @ np.linalg.inv(mount) @ plain @ reflection
        np.testing.assert_allclose(twin, expected, atol=1e-12)
