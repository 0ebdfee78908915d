"""Furthest: which frame of two robots is off the most, all differences together, and in which state."""

from __future__ import annotations

import math
from collections.abc import Sequence

from ..wording import first_of
from .coordinates import Coordinates
from .pairing import Pairing
from .states import whole_states
from .values import Item
from .wording import far, number

_MOST = 4
# What is no gain (m, rad): the same frame is not to be named for rounding.
_LEAST = 1e-6


def furthest(pairing: Pairing, coordinates: Coordinates, items: Sequence[Item]) -> list[str]:
    """Return a sentence on the frame that is off the most over many states.

    Nothing if none is, or if one of the differences alone says as much.
    """
    a, b = pairing.a.robot, pairing.b.robot
    root = a.root if a.root in b.link else next(iter(pairing.shared), "")
    best: tuple[float, float, str, dict[str, float]] = (0.0, 0.0, "", {})
    zeros = {name: coordinate.of(0.0) for name, coordinate in coordinates.items()}
    for state in whole_states(a, b):
        counted = {name: coordinates[name].of(value) if name in coordinates else value for name, value in state.items()}
        first = a.poses_in_root(state)
        # A follower of B follows its own leader.
        second = b.poses_in_root({**zeros, **counted})
        back = first[root].inverse(), second[root].inverse()
        for name in pairing.shared:
            one, other = (way.then(poses[name]) for way, poses in zip(back, (first, second), strict=True))
            distance, angle = math.dist(one.xyz, other.xyz), one.angle_to(other)
            if distance > best[0] + _LEAST or (not best[0] and angle > best[1] + _LEAST):
                best = (distance, angle, name, state)
    distance, angle, name, state = best
    if not name or any((i.distance or 0) >= 0.999 * distance and (i.angle or 0) >= 0.999 * angle for i in items):
        return []
    moved = [f"{joint} = {number(round(value, 3))}" for joint, value in state.items() if abs(value) > 1e-3]
    at = f" at {first_of(moved, _MOST)}" if moved else " with all joints at 0"
    return [f"all together: {name} is off by up to {far(distance, angle)} in {root}{at}"]
