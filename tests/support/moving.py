"""Random robots with joints of every type, and random states of them."""

import random
from typing import Any

from rosorin_compile.model import Joint, Link, Pose, Robot
from rosorin_compile.model.joint import Mimic

KINDS = ("fixed", "revolute", "continuous", "prismatic", "planar", "floating", "ball")


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
