"""States: the positions of joints at which two robots are held against each other; the same ones in every run."""

from __future__ import annotations

import math
import random
from collections.abc import Sequence

from ..model import Joint, Robot

_SEED = 5
_RANDOM = 48
_STEPS = 16
# Of more joints than these each one alone is too much.
_FEW = 40
# How far joints without limits are moved (rad, m).
_TURN, _SLIDE = math.pi, 0.5


def span_of(*joints: Joint | None) -> tuple[float, float]:
    """Return between which positions (rad or m) a joint is moved; the first of the joints with limits says."""
    reach = _SLIDE if any(joint is not None and joint.type == "prismatic" for joint in joints) else _TURN
    for joint in joints:
        limit = joint.limit if joint is not None and joint.type != "continuous" else None
        if limit is not None and limit.lower is not None and limit.upper is not None and limit.lower < limit.upper:
            return max(limit.lower, -2 * reach), min(limit.upper, 2 * reach)
    return -reach, reach


def positions_of(*joints: Joint | None) -> list[float]:
    """Return positions (rad or m) of a joint, zero first, then from one limit to the other."""
    lower, upper = span_of(*joints)
    steps = [lower + (upper - lower) * index / _STEPS for index in range(_STEPS + 1)]
    return [0.0, *(position for position in steps if abs(position) > 1e-6)]


def states_of(joints: Sequence[tuple[Joint, Joint | None]]) -> list[dict[str, float]]:
    """Return states of a few joints: zero, each at its limits alone, and some of all together."""
    found: list[dict[str, float]] = [{}]
    for joint, twin in joints:
        found += [{joint.name: position} for position in span_of(joint, twin) if position]
    chance = random.Random(_SEED)  # noqa: S311
    for _ in range(6 if len(joints) > 1 else 1):
        found.append({joint.name: chance.uniform(*span_of(joint, twin)) for joint, twin in joints})
    return found


def whole_states(robot: Robot, twin: Robot) -> list[dict[str, float]]:
    """Return states of a whole robot: zero, its poses, random ones, and of few joints each at its limits alone."""
    free = [joint for joint in robot.joints if joint.moves and joint.mimic is None]
    pairs = [(joint, twin.joint.get(joint.name)) for joint in free]
    found = states_of(pairs) if len(pairs) <= _FEW else [{}]
    found += [{name: value for name, value in pose.positions.items() if value} for pose in robot.poses]
    chance = random.Random(_SEED)  # noqa: S311
    for _ in range(_RANDOM):
        found.append({joint.name: chance.uniform(*span_of(joint, other)) for joint, other in pairs})
    return found
