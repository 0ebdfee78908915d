"""Joints: how their axes changed, and how they count their positions.

``Coordinates`` are joints that move the same way and count their positions otherwise.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import NamedTuple

from rosorin_compile.model import Joint, Vector
from rosorin_compile.model.geometry import angle_between, dot, minus, norm, unit
from rosorin_compile.source.numbers import amount

from .bodies import Bodies, span_of
from .difference import JOINT, Item
from .pairing import Pairing
from .precision import joined
from .sentences import About, axis_change, number, row, value_change


def axis_item(pairing: Pairing, joint: Joint, twin: Joint, frame: str) -> Item | None:
    """Return how the axis of a joint changed, seen from a frame that it moves; None if it did not.

    Such a frame sees the axis in the same place at every position.
    """
    if not joint.moves or not twin.moves or not norm(joint.axis) or not norm(twin.axis):
        return None
    seen = []
    for bodies, one in ((pairing.a, joint), (pairing.b, twin)):
        place = bodies.relative(frame, one.child, {})
        known = place.angle + 2 * bodies.printing.tolerance("axis", *one.axis) / norm(one.axis)
        seen.append((place.transform.rotate(unit(one.axis)), place.transform.xyz, known, place.length))
    (old, here, first, near), (new, there, second, far) = seen
    turned = angle_between(old, new)
    if turned > pairing.tolerance + joined(first, second):
        text = str(axis_change(joint.name, joint.axis, twin.axis, turned))
        return Item(JOINT, joint.name, "axis", text, row(old), row(new))
    way = minus(there, here)
    along = dot(way, old)
    across = minus(way, (old[0] * along, old[1] * along, old[2] * along))
    if joint.type != "prismatic" and norm(across) > pairing.tolerance + joined(near, far):
        text = f"{joint.name} axis moved {amount(norm(across), 'm')} in {frame}"
        return Item(JOINT, joint.name, "axis", text, row(here), row(there))
    return None


def changed(kind: str, name: str, quantity: str, values: tuple[float | None, float | None], unit: str) -> Item:
    """Return the item about a number that changed; None is a number that is not given."""
    return Item(kind, name, quantity, str(value_change(About(name, quantity), *values, unit)), *values, unit)


def differ(
    a: Bodies, b: Bodies, key: str, values: tuple[float | None, float | None], tolerance: float, scale: float = 0.0
) -> bool:
    """Say whether two numbers that were written under a key differ by more than their digits and the tolerance.

    The tolerance is one part of the larger number, or of ``scale``.
    """
    old, new = values
    if old is None or new is None:
        return old is not new
    known = joined(a.printing.tolerance(key, old), b.printing.tolerance(key, new))
    return abs(new - old) > known + tolerance * max(abs(old), abs(new), scale)


_ALIKE = 1e-6
# How finely a shift of zero that follows from limits is looked for (rad, m).
_LEAST = 1e-6


class Coordinate(NamedTuple):
    """How a joint of B counts: its position is ``sign`` times that of A, plus ``shift`` (rad or m)."""

    joint: str
    sign: int
    shift: float
    same_limits: bool
    axes: tuple[Vector, Vector]

    def of(self, position: float) -> float:
        """Return the position in B of a position in A."""
        return self.sign * position + self.shift

    def item(self) -> Item:
        """Return the difference in words."""
        limits = "its limits follow" if self.same_limits else "its limits do not follow"
        if self.sign < 0:
            turned = axis_change(self.joint, self.axes[0], self.axes[1], math.pi).text
            shift = f", zero is shifted by {number(self.shift)}" if self.shift else ""
            text = f"{turned}{shift}; {limits}"
        else:
            sign = "-" if self.shift < 0 else "+"
            shift = f"position in B = position in A {sign} {number(abs(self.shift))}"
            text = f"{self.joint} counts from another zero: {shift}; {limits}"
        return Item(JOINT, self.joint, "coordinate", text, row(self.axes[0]), row(self.axes[1]), when="always")


Coordinates = Mapping[str, Coordinate]


def coordinate_of(joint: Joint, twin: Joint, fits: Callable[[Coordinate | None], bool]) -> Coordinate | None:
    """Return how a joint of B counts, if it counts otherwise and moves the same way; None if not.

    ``fits`` says whether what hangs on the joint is in its place if B counts so. A shift of zero is taken for one only
    if the limits are shifted, too: otherwise the joint was turned.
    """
    if not joint.moves or fits(None):
        return None
    axes = joint.axis, twin.axis
    for sign in (-1, 1):
        for shift in [0.0] * (sign < 0) + _shifts(joint, twin, sign):
            same = _follows(joint, twin, sign, shift)
            trial = Coordinate(joint.name, sign, shift, same, axes)
            if (same or not shift) and fits(trial):
                return trial
    return None


def _bounds(joint: Joint) -> tuple[float, float] | None:
    limit = joint.limit
    if limit is None or limit.lower is None or limit.upper is None:
        return None
    return limit.lower, limit.upper


def _shifts(joint: Joint, twin: Joint, sign: int) -> list[float]:
    """Return the shift of zero that limits would say; none without limits."""
    mine, theirs = _bounds(joint), _bounds(twin)
    if joint.type == "continuous" or mine is None or theirs is None:
        return []
    shift = theirs[0] - (mine[0] if sign > 0 else -mine[1])
    return [shift] if abs(shift) > _LEAST else []


def _follows(joint: Joint, twin: Joint, sign: int, shift: float) -> bool:
    """Say whether the limits of a joint of B are those of A in B's coordinate."""
    mine, theirs = _bounds(joint), _bounds(twin)
    if mine is None or theirs is None or joint.type == "continuous":
        return mine is None and theirs is None
    low, high = sorted((sign * mine[0] + shift, sign * mine[1] + shift))
    allowed = _ALIKE * max(1.0, *map(abs, span_of(joint)))
    return math.isclose(low, theirs[0], abs_tol=allowed) and math.isclose(high, theirs[1], abs_tol=allowed)
