"""Number forms: how a number of the source is written, always so that it reads back as the same double.

An angle that is exactly a number of degrees is written so; every other number has the digits of the source, unless a
program printed more of them than a double has: 0.050000000000000003 is 0.05.
"""

from __future__ import annotations

import math
from typing import Any

from ...diagnostic import Span
from ...formatting import exact
from ...load import plain_scalar
from ...quantity import Quantity, parse_quantity
from ...tree import Map, Path
from .layout import Verbatim

ROTATING = ("revolute", "continuous")
_DECIMALS = (0, 1, 2)  # of degrees that a person would write
_MAX_DEGREES = 1e6
_DIGITS = 15  # of every decimal number that a double tells from all others

# Keys of a joint that are angles, or angular speeds, where the joint turns.
_OF_JOINT: dict[Path, str] = {
    ("limit", "lower"): "deg",
    ("limit", "upper"): "deg",
    ("limit", "velocity"): "deg/s",
    ("mimic", "offset"): "deg",
    ("calibration", "rising"): "deg",
    ("calibration", "falling"): "deg",
    ("calibration", "reference_position"): "deg",
    ("safety_controller", "soft_lower_limit"): "deg",
    ("safety_controller", "soft_upper_limit"): "deg",
}


def number(value: float, span: Span | None, angle: str = "") -> Verbatim:
    """Return a number as it is written; ``angle`` is the unit in degrees that it may have (deg, deg/s).

    >>> number(-1.5707963267948966, None, "deg"), number(1.5708, None, "deg"), number(-0.0, None)
    ('-90 deg', '1.5708', '0')
    """
    if value == 0:
        return Verbatim("0")
    if isinstance(value, Quantity) and value.text and parse_quantity(value.text) == value:
        return Verbatim(value.text)
    if not math.isfinite(value):
        return Verbatim(".nan" if value != value else ".inf" if value > 0 else "-.inf")
    return Verbatim((angle and in_degrees(value, angle)) or _digits(value, span) or exact(value))


def in_degrees(value: float, unit: str) -> str:
    """Return radians as degrees, empty unless a short number of degrees is exactly this double."""
    degrees = math.degrees(value)
    for decimals in _DECIMALS if abs(degrees) < _MAX_DEGREES else ():
        text = f"{exact(round(degrees, decimals))} {unit}"
        if parse_quantity(text) == value:
            return text
    return ""


def _digits(value: float, span: Span | None) -> str:
    """Return the digits that stand at a place of the source, empty unless they say this very number."""
    if span is None:
        return ""
    token = span.source.line(span.line)[span.column - 1 : span.column - 1 + span.length].removeprefix("+")
    if not token or len(token) != len(token.strip()):
        return ""
    read = plain_scalar(token)
    same = isinstance(read, (int, float)) and not isinstance(read, (bool, Quantity)) and float(read) == float(value)
    if not same or (_significant(token) > _DIGITS and len(exact(value)) < len(token)):
        return ""
    return token


def _significant(token: str) -> int:
    """Return how many digits a number is written with, zeros before the first other one left out."""
    mantissa = token.lower().partition("e")[0]
    return len("".join(filter(str.isdigit, mantissa)).lstrip("0"))


def angle_of(tree: Map, path: Path) -> str:
    """Return the unit in degrees of the value at a path of a description, empty if it is no angle."""
    if len(path) >= 2 and path[-2] == "rpy":
        return "deg"
    if path[:1] == ("joints",) and path[2:] in _OF_JOINT:
        return _OF_JOINT[path[2:]] if _turns(tree, path[1]) else ""
    if path[:1] == ("poses",) and path[2:3] == ("positions",) and len(path) == 4:
        return "deg" if _turns(tree, path[3]) else ""
    return ""


def _turns(tree: Map, joint: Any) -> bool:
    joints = tree.get("joints")
    entry = joints.get(joint) if isinstance(joints, dict) else None
    return isinstance(entry, dict) and entry.get("type") in ROTATING
