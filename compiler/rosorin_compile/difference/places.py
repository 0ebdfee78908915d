"""Places compared: how far two of them are apart, and whether that is more than their sources leave open."""

from __future__ import annotations

import math

from .bodies import Gap, Placed
from .printing import joined


def gap(one: Placed, other: Placed, tolerance: float) -> Gap:
    """Return how far two places are apart; ``tolerance`` (m, rad) is no distance."""
    step = tuple(b - a for a, b in zip(one.transform.xyz, other.transform.xyz, strict=True))
    return Gap(
        math.hypot(*step),
        one.transform.angle_to(other.transform),
        tolerance + joined(one.length, other.length),
        tolerance + joined(one.angle, other.angle),
    )
