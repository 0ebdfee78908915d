"""Engines step what is written: robots that stand free settle at one height, those that are held stay where they are.

The URDF in PyBullet, Drake and MuJoCo, the MJCF in MuJoCo and Drake, the SDF in Drake, for two seconds; and MJX takes
the MJCF. PyBullet and MJX are in an environment of their own (ENGINES, as .ci/run sets it), and so is Drake (DRAKE).
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path
from typing import Any, NamedTuple
from xml.etree import ElementTree

import pytest

from rosorin_compile.formats import FORMATS
from rosorin_compile.formats.templating import Templates
from rosorin_compile.formats.urdf.write import elements_of
from rosorin_compile.model import Output, Robot
from rosorin_compile.mujoco.mjcf.bodies import home_of, resting_pose
from rosorin_compile.mujoco.mjcf.contacts import refused_by_mjx
from support import stepping_child
from support.paths import ROOT, ROSORIN
from support.robots import compiled

pytest.importorskip("mujoco", minversion="3.12")

pytestmark = pytest.mark.slow

PYTHONS = {"pybullet": os.environ.get("ENGINES", ""), "drake": os.environ.get("DRAKE", ""), "mujoco": sys.executable}
JUDGED = [("urdf", "pybullet"), ("urdf", "drake"), ("urdf", "mujoco"), ("mjcf", "mujoco"), ("mjcf", "drake")]
JUDGED += [("sdf", "drake")]

# Those that stand free, and those that are held, each with its arguments.
FREE: dict[str, dict[str, str]] = {
    "rosorin": {"base": "free"},
    "omni_base": {},
    "ackermann_car": {},
    "porter": {},
    "turtlebot3_burger": {},
    "unitree_a1": {"base": "free"},
}
FIXED: dict[str, dict[str, str]] = {"ur5e": {}}
# What has layers of its own says itself who touches whom, and accepts the rule not-in-mjx.
LAYERED = ["porter"]
SECONDS = 2.0
DROP = 0.005  # m: where a robot begins above the floor
SAME = 0.002  # m


class Robots(NamedTuple):
    """A robot as engines get it: its model, a folder of its files by format, whether it is free."""

    robot: Robot
    files: dict[str, Path]
    free: bool


def written(name: str, folder: Path) -> Robots:
    path = ROSORIN if name == "rosorin" else ROOT / "examples" / name / "robot.yaml"
    made = compiled(path, {**FREE, **FIXED}[name])
    assert made.robot is not None
    outputs = {
        one.backend: one for one in made.robot.outputs if one.backend != "urdf" or "inertial" in elements_of(one)
    }
    files = {}
    for kind in ("urdf", "mjcf", "sdf"):
        output = outputs.get(kind, Output(kind, kind, f"{name}.{kind}", {}))
        files[kind] = folder / output.file
        files[kind].write_text(FORMATS[kind].write(made.robot, output, Templates(path.parent))[0], "utf-8")
    return Robots(made.robot, files, name in FREE)


def jobs(robots: Robots) -> dict[str, list[dict[str, Any]]]:
    robot = robots.robot
    home = home_of(robot)
    places = robot.poses_in_root(dict(home.positions))
    lift = resting_pose(robot, home).xyz[2] + DROP
    held = {j.name: robot.position(j, home.positions) for j in robot.joints if j.type in ("revolute", "prismatic")}
    asked: dict[str, list[dict[str, Any]]] = {}
    for kind, engine in JUDGED:
        file = robots.files[kind]
        root = robot.root if kind == "mjcf" else top(file)
        above = places[root].xyz[2]  # of the root of the file, which may lack frames without mass
        job = {"engine": engine, "file": str(file), "held": held, "seconds": SECONDS, "root": root}
        height = lift + above if robots.free else None
        asked.setdefault(engine, []).append({**job, "height": height, "kind": kind, "above": above})
    return asked


def top(file: Path) -> str:
    root = ElementTree.parse(file).getroot()
    joints = list(root.iter("joint"))
    below = {child.get("link") or child.text for joint in joints for child in joint.iter("child")}
    return next(str(link.get("name")) for link in root.iter("link") if link.get("name") not in below)


def stepped(robots: Robots, *only: str) -> dict[str, dict[str, Any]]:
    found: dict[str, dict[str, Any]] = {}
    for engine, asked in jobs(robots).items():
        python = PYTHONS[engine]
        if not python or engine not in (only or PYTHONS):
            continue
        lines = answers(python, asked)
        for job, said in zip(asked, lines, strict=True):
            found[f"{job['kind']} in {engine}"] = {**said, "stands": said.get("height", 0.0) - job["above"]}
    return found


def answers(python: str, asked: list[dict[str, Any]]) -> list[dict[str, Any]]:
    words = [python, stepping_child.__file__]
    ran = subprocess.run(words, input=json.dumps(asked), capture_output=True, text=True, check=False)
    assert ran.returncode == 0, ran.stderr[-2000:]
    return [json.loads(line) for line in ran.stdout.splitlines() if line.startswith("{")]


@pytest.mark.tier("engines")
@pytest.mark.parametrize("name", sorted({*FREE, *FIXED}))
def test_every_robot_settles_alike_everywhere(name: str, tmp_path: Path) -> None:
    """Nothing runs away, and what stands free stands at the same height in each engine."""
    robots = written(name, tmp_path)
    found = stepped(robots)
    assert [(key, said) for key, said in found.items() if not said.get("finite")] == []
    if robots.free:
        heights = {key: said["stands"] for key, said in found.items()}
        assert max(heights.values()) - min(heights.values()) < SAME, heights


def in_mjx(file: Path) -> dict[str, Any]:
    if not PYTHONS["pybullet"]:
        pytest.skip("ENGINES names no Python that has MJX")
    scene = file.with_name("on_a_floor.xml")
    floor = '<worldbody><geom type="plane" size="0 0 1"/></worldbody>'
    scene.write_text(f'<mujoco><include file="{file.name}"/>{floor}</mujoco>', "utf-8")
    (said,) = answers(PYTHONS["pybullet"], [{"engine": "mjx", "file": str(scene)}])
    return said


@pytest.mark.landing("engines", "omni_base")
@pytest.mark.parametrize("name", sorted({*FREE, *FIXED}))
def test_mjx_takes_a_robot_unless_the_rule_names_it(name: str, tmp_path: Path) -> None:
    robots = written(name, tmp_path)
    (output,) = [one for one in robots.robot.outputs if one.backend == "mjcf"]
    assert bool(list(refused_by_mjx(robots.robot, output))) == (name in LAYERED)
    said = in_mjx(robots.files["mjcf"])
    assert "not implemented" in said.get("refused", "") if name in LAYERED else said.get("finite"), said


@pytest.mark.landing("engines", "not-in-mjx")
@pytest.mark.parametrize("name", ["not-in-mjx", "not-in-mjx-layers"])
def test_mjx_refuses_what_the_rule_names(name: str, tmp_path: Path) -> None:
    made = compiled(ROOT / "tests" / "bad" / f"{name}.yaml")
    assert made.robot is not None
    (output,) = made.robot.outputs
    file = tmp_path / output.file
    file.write_text(FORMATS["mjcf"].write(made.robot, output, Templates(tmp_path))[0], "utf-8")
    kinds = [f"mjGEOM_{kind.upper()}" for ((pair, *_),) in [list(refused_by_mjx(made.robot, output))] for kind in pair]
    said = in_mjx(file)
    assert all(kind in said.get("refused", "") for kind in kinds), said


def test_pybullet_throws_away_what_the_rule_warns_of(tmp_path: Path) -> None:
    if not PYTHONS["pybullet"]:
        pytest.skip("ENGINES names no Python that has PyBullet")
    robots = written("rosorin", tmp_path)
    urdf = robots.files["urdf"]
    urdf.write_text(urdf.read_text("utf-8").replace('damping="0" friction', 'damping="1" friction'), "utf-8")
    assert not stepped(robots, "pybullet")["urdf in pybullet"]["finite"]
