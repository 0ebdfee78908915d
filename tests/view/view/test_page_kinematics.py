"""The page puts every frame where the model has it: its own module, run by node, on random robots and states."""

import json
import math
import random
import shutil
import subprocess
from pathlib import Path
from typing import Any

import pytest

from rosorin_compile.model import Robot
from rosorin_compile.viewer.page.data import robot_data
from support.moving import random_robot, random_state
from support.paths import ROOT, ROSORIN
from support.robots import compiled

NODE = shutil.which("node")
NEAR = 1e-9
STATES = 200

pytestmark = pytest.mark.skipif(NODE is None, reason="node runs the page's module")


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
