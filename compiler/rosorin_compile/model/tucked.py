"""Tucked: what the pose of a footprint leaves out, and where that reaches farthest."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from typing import NamedTuple

from .footprint import Placed, solids
from .joint import Joint
from .rest_pose import Clouds
from .robot import Robot

_WAYS = tuple((math.cos(math.tau * i / 16), math.sin(math.tau * i / 16), 0.0) for i in range(16))
_STEPS = 8  # from one limit of a joint to the other
_NEARLY = 1e-3  # m: as far as anywhere
_MATTERS = 0.02  # m: what a footprint would be smaller by


class Left(NamedTuple):
    """A joint that a pose leaves at zero: the link that reaches farthest there, how far, and how far it has to (m)."""

    joint: str
    link: str
    reach: float
    least: float


def left_out(robot: Robot, base: str, positions: Mapping[str, float], clouds: Clouds) -> Iterator[Left]:
    """Yield joints that a pose does not name, and that decide on the footprint by being where they reach farthest.

    ``positions`` are those of the pose (rad or m), ``base`` is the frame of the footprint. Shapes of unknown size are
    left aside.
    """
    placed, _ = solids(robot, base, positions, clouds)
    farthest = {max(placed, key=lambda one, way=way: one.reach(way)).link for way in _WAYS} if placed else set()  # type: ignore[misc]
    for joint in robot.joints:
        if not joint.moves or joint.mimic is not None or joint.name in positions:
            continue
        below = set(robot.below(joint.child))
        ends = _ends(joint)
        if ends is None or not farthest & below:
            continue
        here = _reach(placed, below)
        lower, upper = ends
        others = [
            _reach(
                solids(robot, base, {**positions, joint.name: lower + (upper - lower) * i / _STEPS}, clouds)[0], below
            )
            for i in range(_STEPS + 1)
        ]
        if here[0] >= max(others)[0] - _NEARLY and here[0] - min(others)[0] > _MATTERS:
            yield Left(joint.name, here[1], here[0], min(others)[0])


def _reach(placed: list[Placed], below: set[str]) -> tuple[float, str]:
    """Return how far the links that a joint moves reach from the base (m), and which of them does."""
    return max((one.reach(way), one.link) for one in placed if one.link in below for way in _WAYS)


def _ends(joint: Joint) -> tuple[float, float] | None:
    if joint.type == "continuous":
        return -math.pi, math.pi
    lower, upper = (joint.limit.known(side) for side in ("lower", "upper")) if joint.limit else (None, None)
    return None if lower is None or upper is None or not lower < upper else (lower, upper)
