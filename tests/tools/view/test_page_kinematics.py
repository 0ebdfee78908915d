"""The page puts every frame where the model has it: its own module, run by node, on random robots and states."""

from __future__ import annotations

import json
import math
import random
import shutil
import subprocess
from pathlib import Path
from typing import Any

import pytest

from rosorin_compile.formats.page.data import robot_data
from rosorin_compile.model import Joint, Link, Mimic, Pose, Robot
from support.paths import ROOT, ROSORIN
from support.robots import compiled

NODE = shutil.which("node")
NEAR = 1e-9
STATES = 200
KINDS = ("fixed", "revolute", "continuous", "prismatic", "planar", "floating")

pytestmark = pytest.mark.skipif(NODE is None, reason="node runs the page's module")


def _axis(rng: random.Random) -> tuple[float, float, float]:
    return rng.choice(
        [(1.0, 0.0, 0.0), (0.0, -1.0, 0.0), (0.0, 0.0, -1.0), tuple(rng.uniform(-1, 1) for _ in range(3))]
    )


def random_robot(rng: random.Random, size: int) -> Robot:
    """A tree of joints of every type; some follow another one, some of those a third."""
    joints: list[Joint] = []
    for index in range(size):
        leaders = [joint for joint in joints if joint.moves]
        kind = rng.choice(KINDS)
        mimic = None
        if kind in ("revolute", "prismatic") and leaders and rng.random() < 0.4:
            mimic = Mimic(rng.choice(leaders).name, rng.uniform(-2, 2), rng.uniform(-1, 1))
        origin = Pose(*(tuple(rng.uniform(-3, 3) for _ in range(3)) for _ in range(2)))
        parent = rng.choice(["base", *(joint.child for joint in joints)])
        joints.append(Joint(f"j{index}", kind, parent, f"l{index}", origin, _axis(rng), mimic=mimic))
    links = [Link("base"), *(Link(joint.child) for joint in joints)]
    return Robot("random", tuple(links), tuple(joints))


def random_state(rng: random.Random, robot: Robot) -> dict[str, Any]:
    state: dict[str, Any] = {}
    for joint in robot.joints:
        numbers = [rng.uniform(-3, 3) for _ in joint.coordinates]
        if numbers and joint.mimic is None and rng.random() < 0.9:  # what is not named is at zero
            state[joint.name] = numbers if len(numbers) > 1 else numbers[0]
    return state


def _largest_difference(robot: Robot, states: list[dict[str, Any]]) -> float:
    question = json.dumps({"robot": robot_data(robot), "states": states})
    command = [str(NODE), str(ROOT / "viewer/places.js")]
    answer = json.loads(subprocess.run(command, input=question, capture_output=True, text=True, check=True).stdout)
    worst = 0.0
    for state, places in zip(states, answer, strict=True):
        meant = robot.poses_in_root(state)
        assert places.keys() == meant.keys()
        for link, (x, y, z, qx, qy, qz, qw) in places.items():
            w, *rest = meant[link].quaternion()
            same = w * qw + sum(a * b for a, b in zip(rest, (qx, qy, qz), strict=True))
            apart = math.dist([w, *rest], [math.copysign(1, same) * value for value in (qw, qx, qy, qz)])
            worst = max(worst, math.dist(meant[link].xyz, (x, y, z)), apart)
    return worst


@pytest.mark.parametrize("seed", range(10))
def test_the_page_agrees_with_the_model_on_random_robots(seed: int) -> None:
    rng = random.Random(seed)  # noqa: S311
    robot = random_robot(rng, 12)
    assert _largest_difference(robot, [random_state(rng, robot) for _ in range(STATES)]) < NEAR


REAL = [ROSORIN, *sorted(ROOT.glob("examples/*/robot.yaml"))]


@pytest.mark.parametrize("path", REAL, ids=lambda path: path.parent.name)
def test_the_page_agrees_with_the_model_on_real_robots(path: Path) -> None:
    robot = compiled(path).robot
    assert robot is not None
    rng = random.Random(path.parent.name)  # noqa: S311
    assert _largest_difference(robot, [random_state(rng, robot) for _ in range(STATES)]) < NEAR


def test_the_page_has_tests_of_its_own() -> None:
    done = subprocess.run([str(NODE), "--test"], cwd=ROOT / "viewer", capture_output=True, text=True, timeout=120)
    assert done.returncode == 0, done.stdout
    assert "# fail 0" in done.stdout
    assert "# pass 0" not in done.stdout
