"""The stock nodes are the judge: robot_state_publisher, static_transform_publisher and tf2 run on our artifacts."""

from __future__ import annotations

import json
import math
import os
import random
from collections.abc import Mapping
from functools import lru_cache
from pathlib import Path
from typing import Any, NamedTuple

import pytest

from rosorin_compile.formats import FORMATS
from rosorin_compile.model import Robot
from rosorin_compile.model.joint import NODE
from rosorin_compile.model.kinematics import Graph
from rosorin_compile.transforms import lookup
from support import stock_nodes
from support.paths import DATA, ROOT, ROSORIN
from support.robots import compiled, texts

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(
        not stock_nodes.installed() and "CI" not in os.environ, reason=f"apt-get install {stock_nodes.PACKAGES}"
    ),
]

# A robot with what the others lack: a slide, followers, and the two joints that robot_state_publisher cannot move.
CORNERS = DATA / "stock_nodes" / "corners.yaml"
CASES = {
    "rosorin": ROSORIN,
    **{name: ROOT / "examples" / name / "robot.yaml" for name in ("turtlebot3_burger", "ur5e", "unitree_a1")},
    "corners": CORNERS,
}
TOLERANCE = 1e-6  # m, and of each component of a quaternion
STATES = 5


class Run(NamedTuple):
    path: Path
    robot: Robot
    artifacts: Mapping[str, str]
    states: list[dict[str, float]]
    said: dict[str, Any]


@lru_cache
def run_of(name: str, folder: Path) -> Run:
    made = compiled(CASES[name])
    robot, artifacts = made.robot, texts(made)
    assert robot is not None
    urdf = next(text for file, text in artifacts.items() if file.endswith(".urdf"))
    static = (
        json.loads(artifacts["static_tf.json"])["static_transform_publisher"] if "static_tf.json" in artifacts else []
    )
    started = [
        stock_nodes.StaticTransform(
            entry["name"], dict(zip(entry["arguments"][::2], entry["arguments"][1::2], strict=True))
        )
        for entry in static
    ]
    states = _states(robot)
    return Run(CASES[name], robot, artifacts, states, stock_nodes.run(urdf, started, states, folder))


@pytest.fixture(scope="module", params=list(CASES))
def run(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Run:
    return run_of(request.param, tmp_path_factory.mktemp(request.param))


def _states(robot: Robot) -> list[dict[str, float]]:
    chance = random.Random(5)  # noqa: S311 - the same states every time
    moving = [joint for joint in robot.joints if joint.moves and joint.mimic is None]
    states = []
    for _ in range(STATES):
        state = {}
        for joint in moving:
            limit = joint.limit
            bounded = limit is not None and limit.lower is not None and limit.upper is not None
            ends = (limit.lower, limit.upper) if bounded and limit is not None else (-math.pi, math.pi)
            state[joint.name] = chance.uniform(ends[0] or 0.0, ends[1] or 0.0)
        states.append(state)
    return states


@pytest.mark.landing("outside", "rosorin", "corners")
def test_every_frame_that_tf2_answers_is_where_tf_says(run):
    graph = Graph(run.robot)
    compared = 0
    for state, answers in zip(run.states, run.said["states"], strict=True):
        for child, (root, xyz, quaternion) in answers.items():
            ours = lookup(graph, root, child, state)
            assert ours.translation == pytest.approx(xyz, abs=TOLERANCE), child
            # tf2 composes from both frames up; even the sign of the quaternion is the same, unless it is half a turn
            sign = 1 if sum(a * b for a, b in zip(ours.quaternion, quaternion, strict=True)) > 0 else -1
            assert ours.quaternion == pytest.approx([sign * c for c in quaternion], abs=TOLERANCE), child
            compared += 1
    assert compared >= STATES * (len(run.robot.published_by("robot_state_publisher")) - 2)


def test_the_topics_carry_exactly_the_edges_of_frames_md(run):
    """Each edge on the topic, by the node and with the parent that frames.md gives it: no more, no fewer."""
    others = {publisher.name for publisher in run.robot.publishers if publisher.kind == NODE}
    frames = FORMATS["frames"].read(run.artifacts["frames.md"]).frames
    expected = {
        ("/tf" if edge.moving else "/tf_static", edge.publisher.name, edge.parent, edge.child)
        for edge in frames
        if edge.publisher.kind == NODE and edge.publisher.name not in others
    }
    assert {tuple(message[:4]) for message in run.said["messages"]} == expected
    assert expected


def test_moving_transforms_are_stamped_with_their_joint_state(run):
    """What verify relies on: a transform of robot_state_publisher has the stamp of its joint state."""
    stamps = {stamp for _, sent in run.said["joint_states"] for stamp in sent}
    moving = [message for message in run.said["messages"] if message[0] == "/tf"]
    assert all(message[4] in stamps for message in moving)
