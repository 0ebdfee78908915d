"""Tolerance: how well numbers, rotations and places are known, and when two of them mean the same.

A program that prints six digits leaves half of the sixth open. That a file was printed so shows in its numbers: none
has more. Numbers of a description are exact. What is calculated from several numbers is known no better than all of
them together.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterator, Mapping
from typing import NamedTuple

from rosorin_compile.formats import Value
from rosorin_compile.formats.facts import PI_CUT
from rosorin_compile.model import Transform, Vector
from rosorin_compile.model.geometry import norm, rotation_of_rpy
from rosorin_compile.source.diagnostics import Span
from rosorin_compile.source.numbers import Style
from rosorin_compile.source.tree import Map, Seq

from .proof import Tolerance

# Fewer digits than these are taken for a choice, not for rounding: 0.1 is 0.1.
FEWEST = 6
# What has more digits than these is exact as far as a double can tell.
_MOST = 14
# By how much less a number is known that was calculated from printed ones.
_CALCULATED = 4.0
# What arithmetic on the way to a number costs: relative, and absolute for lengths (m) and angles (rad).
NOISE = Tolerance.NUMBER
# Three coordinates may be off at once; three angles may all turn about one line.
ROOT_THREE, TURNS = 3**0.5, 3.0
# Closer than this to a pitch of 90 degrees (its cosine), roll and yaw are not told apart.
_GIMBAL = 1e-6
_NUMBER = r"[+-]?(?P<whole>[0-9]*)\.?(?P<part>[0-9]*)(?:[eE](?P<power>[+-]?[0-9]+))?"


class Printing(NamedTuple):
    """How a source prints its numbers, by their key ("xyz", "rpy", "ixx"); without a style numbers are exact.

    ``general`` is the style of all numbers: that of what was calculated from others, as angles from a quaternion.
    """

    styles: Mapping[str, Style | None]
    general: Style | None = None

    def tolerance(self, key: str, *values: float) -> float:
        """Return how well the values of a key are known, the worst of them."""
        if key in self.styles:
            style, share = self.styles[key], 1.0
        else:
            style, share = self.general, _CALCULATED
        return share * max(map(style.tolerance, values), default=0.0) if style else 0.0


EXACT = Printing({})


def printing_of(tree: Map) -> Printing:
    """Return how the numbers of a tree were printed whose spans cover the digits of its numbers."""
    digits: dict[str, list[tuple[int, int]]] = {}
    for key, span in _numbers(tree, ""):
        counted = _counted(span.source.line(span.line)[span.column - 1 : span.column - 1 + span.length])
        if counted:
            digits.setdefault(key, []).append(counted)
    styles = {key: _style(found) for key, found in sorted(digits.items())}
    return Printing(styles, _style([counted for found in digits.values() for counted in found]))


def _numbers(node: Map | Seq, key: str) -> Iterator[tuple[str, Span]]:
    """Yield the key and the place of each number; items of a list have the key of the list."""
    waiting: list[tuple[Map | Seq, str]] = [(node, key)]
    while waiting:
        node, key = waiting.pop()
        pairs = list(node.items()) if isinstance(node, Map) else list(enumerate(node))
        for step, value in pairs:
            name = step if isinstance(step, str) else key
            if isinstance(value, (Map, Seq)):
                waiting.append((value, name))
            elif isinstance(value, (int, float)) and not isinstance(value, bool):
                yield name, node.value_spans[step]  # type: ignore[index]


def _counted(text: str) -> tuple[int, int] | None:
    """Return how many digits a number has, from the first one that is not zero, and how many after the point.

    >>> _counted("-1.5708"), _counted("0.0120"), _counted("7.5437e-05"), _counted("abc")
    ((5, 4), (2, 3), (5, 9), None)
    """
    found = re.fullmatch(_NUMBER, text.strip())
    if not found or not (found["whole"] or found["part"]):
        return None
    part = found["part"].rstrip("0")
    power = int((found["power"] or "0")[:6])
    whole = found["whole"] if part else found["whole"].rstrip("0")
    return len((whole + part).lstrip("0")), max(0, len(part) - power)


def _style(found: list[tuple[int, int]]) -> Style | None:
    """Return the style with the fewest digits that explains all numbers; None for exact ones, and for none at all."""
    if not found:
        return None
    for digits in range(FEWEST, _MOST + 1):
        if all(significant <= digits or decimals <= digits for significant, decimals in found):
            return Style(digits, all(one <= digits for one, _ in found), all(other <= digits for _, other in found))
    return None


def joined(one: float, other: float) -> float:
    """Return how far two printed numbers may be apart that mean the same.

    Rounded alike they are equal, and neighbours in print are two tolerances apart; rounded differently their tolerances
    add up.
    """
    larger, smaller = max(one, other), min(one, other)
    return larger + min(smaller, larger / 2)


def same_value(one: Value | None, other: Value | None, noise: float = 0.0) -> bool:
    """Say whether two values mean the same, as far as they are printed.

    ``noise`` is what two writers may have calculated differently; of one writer it is nothing.
    """
    if one is None or other is None:
        return one is other
    if isinstance(one.value, str) or isinstance(other.value, str):
        return one.value == other.value
    allowed = noise * max(abs(one.value), abs(other.value)) + (noise if one.unit in ("m", "rad") else 0.0)
    return abs(one.value - other.value) <= joined(one.tolerance, other.tolerance) + allowed


class Turn(NamedTuple):
    """A rotation as roll, pitch, yaw (rad) in the form of ``formats.facts.angles``, and how well each is known.

    That is how far the rotation may be turned about an axis of its own: near a pitch of 90 degrees the angles of one
    and the same rotation are further apart.
    """

    rpy: Vector
    tolerance: Vector


def wrapped(angle: float) -> float:
    """Return an angle (rad) within plus and minus half a turn; half a turn itself is plus, in print as well."""
    half = math.pi + PI_CUT
    return half - (half - angle) % math.tau


def same_angles(one: Turn, other: Turn) -> bool:
    """Say whether two rotations that one writer printed are one, angle by angle and as a whole."""
    steps = zip(one.rpy, other.rpy, one.tolerance, other.tolerance, strict=True)
    upright = max(abs(math.cos(one.rpy[1])), _GIMBAL)
    close = all(abs(wrapped(b - a)) * upright <= joined(s, t) + NOISE for a, b, s, t in steps)
    return close and same_turn(one, other)


def same_turn(one: Turn | None, other: Turn | None) -> bool:
    """Say whether two writers mean the same rotation, in whichever angles."""
    if one is None or other is None:
        return one is other
    allowed = joined(sum(one.tolerance), sum(other.tolerance)) + NOISE
    pairs = zip(rotation_of_rpy(one.rpy), rotation_of_rpy(other.rpy), strict=True)
    return all(abs(a - b) <= allowed for rows in pairs for a, b in zip(*rows, strict=True))


class Placed(NamedTuple):
    """Where something is, and how well that is known: lengths (m) and angles (rad)."""

    transform: Transform
    length: float = 0.0
    angle: float = 0.0

    def then(self, child: Placed) -> Placed:
        """Return this place followed by another one in it."""
        length = self.length + child.length + self.angle * norm(child.transform.xyz)
        return Placed(self.transform.then(child.transform), length, self.angle + child.angle)

    def inverse(self) -> Placed:
        """Return the way back."""
        length = self.length + self.angle * norm(self.transform.xyz)
        return Placed(self.transform.inverse(), length, self.angle)


HERE = Placed(Transform())


class Gap(NamedTuple):
    """How far two places are apart (m, rad), and how far they may be as well as they are known."""

    distance: float
    angle: float
    length_tolerance: float
    angle_tolerance: float

    @property
    def closed(self) -> bool:
        """Whether the two places are the same."""
        return self.distance <= self.length_tolerance and self.angle <= self.angle_tolerance


def gap(one: Placed, other: Placed, tolerance: float) -> Gap:
    """Return how far two places are apart; ``tolerance`` (m, rad) is no distance."""
    return Gap(
        math.dist(one.transform.xyz, other.transform.xyz),
        one.transform.angle_to(other.transform),
        tolerance + joined(one.length, other.length),
        tolerance + joined(one.angle, other.angle),
    )
