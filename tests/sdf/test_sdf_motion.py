"""One description moves alike in MuJoCo (its MJCF) and in Drake (its SDF): springs, friction, closed loops."""

import json
import subprocess
from pathlib import Path

import numpy as np
import pytest

from rosorin_compile.cli.main import main
from support import in_drake
from support.paths import TESTS, data_text

mujoco = pytest.importorskip("mujoco")
pytestmark = pytest.mark.slow

STEPS, SECONDS, ALIKE = 20, 1.0, 0.02
OUTPUTS = "outputs: {sdf: {file: r.sdf}, mjcf: {file: r.xml, base: BASE, option: {timestep: 0.001}}}\n"
PENDULUM = data_text("robots/sdf_motion_pendulum.yaml")
END = "  end: {inertial: {mass: 0.1, inertia: {ixx: 1e-4, iyy: 1e-4, izz: 1e-4}}}\n"
BOX = """robot: box
links:
  base_link:
    inertial: {mass: 2, xyz: [0, 0, 0.02], inertia: {ixx: 0.03, iyy: 0.03, izz: 0.05}}
    collision: [{box: {size: [0.4, 0.4, 0.04]}, xyz: [0, 0, 0.02], contact: {friction: [0.3]}}]
"""
LINKAGE = data_text("robots/sdf_motion_linkage.yaml")


def moved(text: str, folder: Path, floor: float | None = None, push: float = 0.0) -> tuple[np.ndarray, np.ndarray]:
    """Return the positions of all links at each step: in MuJoCo, and in Drake."""
    (folder / "robot.yaml").write_text(text + OUTPUTS.replace("BASE", "fixed" if floor is None else "free"), "utf-8")
    assert main(["all", str(folder / "robot.yaml"), "-o", str(folder / "out")]) == 0
    asked = {
        "file": str(folder / "out/r.sdf"),
        "seconds": SECONDS,
        "steps": STEPS,
        "floor": floor,
        "positions": {},
        "push": {"base_link": push} if push else {},
    }
    in_drake.need()
    words = [in_drake.PYTHON, "-P", str(TESTS / "support/drake_motion.py")]
    ran = subprocess.run(words, input=json.dumps(asked), capture_output=True, text=True, timeout=120, check=False)
    assert ran.returncode == 0, ran.stderr
    found = json.loads(ran.stdout)
    mjcf = (folder / "out/r.xml").read_text("utf-8")
    if floor is not None:
        ground = f'<worldbody><geom type="plane" size="9 9 1" friction="{floor} 0.005 0.0001"/>'
        mjcf = mjcf.replace("<worldbody>", ground, 1)
    model = mujoco.MjModel.from_xml_string(mjcf)
    data = mujoco.MjData(model)
    if push:
        data.qpos[2], data.qvel[0] = 0.0, push
    names = list(found[0])
    ours = []
    for _ in range(STEPS):
        mujoco.mj_step(model, data, round(SECONDS / STEPS / model.opt.timestep))
        ours.append([data.body(name).xpos.copy() for name in names])
    return np.array(ours), np.array([[step[name] for name in names] for step in found])


def apart(ours: np.ndarray, theirs: np.ndarray) -> float:
    """Return how far two motions are apart at most, as a part of the way of the link that moves farthest."""
    way = np.linalg.norm(ours - ours[0], axis=-1).max()
    assert way > 0.05
    return float(np.linalg.norm(ours - theirs, axis=-1).max() / way)


def test_a_pendulum_with_a_spring(tmp_path: Path) -> None:
    assert apart(*moved(PENDULUM.replace("joints:", f"{END}joints:"), tmp_path)) < ALIKE


def test_a_box_that_slides_with_friction(tmp_path: Path) -> None:
    ours, theirs = moved(BOX, tmp_path, floor=0.3, push=2.0)
    assert apart(ours[:, :, :2], theirs[:, :, :2]) < ALIKE
    assert ours[-1, 0, 0] == pytest.approx(2**2 / (2 * 0.3 * 9.81), rel=ALIKE)


def test_a_linkage_of_four_bars(tmp_path: Path) -> None:
    assert apart(*moved(LINKAGE, tmp_path)) < ALIKE


def test_a_loop_that_drake_closes_comes_back(tmp_path: Path) -> None:
    (tmp_path / "robot.yaml").write_text(LINKAGE + OUTPUTS.replace("BASE", "fixed"), "utf-8")
    assert main(["all", str(tmp_path / "robot.yaml"), "-o", str(tmp_path / "out")]) == 0
    assert main(["import", str(tmp_path / "out/r.sdf"), "-o", str(tmp_path / "again")]) == 0
    text = (tmp_path / "again/robot.yaml").read_text("utf-8")
    assert "pin: {type: connect, links: [rod, rocker], at: [0.42, 0, 0.001]}" in text
