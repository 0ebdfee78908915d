"""Findings: what is wrong with a recording, as diagnostics, and how its numbers are written."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import replace
from types import MappingProxyType
from typing import Any

from rosorin_compile.model import Transform, Vector
from rosorin_compile.source.diagnostics import ERROR, NOTE, WARNING, Diagnostic, Related, Span
from rosorin_compile.source.numbers import amount

_WEIGHT = {ERROR: 0, WARNING: 1, NOTE: 2}
_NEAR = math.radians(2.0)  # a turn is named a quarter or a half of one if it is one to within this
_AXES = ("x", "y", "z")
YEAR = 365.25 * 86400.0  # s
_NO_NUMBERS: Mapping[str, Any] = MappingProxyType({})


def problem(
    rule: str,
    subject: str,
    message: str,
    help: str = "",
    *,
    severity: str = ERROR,
    evidence: Iterable[str] = (),
    numbers: Mapping[str, Any] = _NO_NUMBERS,
) -> Diagnostic:
    """Return a finding about a subject; each line of ``evidence`` stands below its message."""
    related = tuple(Related(line, None) for line in evidence)
    return Diagnostic(rule, severity, message, None, related, help, (subject,), tuple(numbers.items()))


def with_place(finding: Diagnostic, place: Span) -> Diagnostic:
    """Return a finding with the place in the description, in a remark: the mistake may be the robot's."""
    return replace(finding, related=(*finding.related, Related("described here", place)))


def ordered(findings: Iterable[Diagnostic]) -> list[Diagnostic]:
    """Return each finding once, the most serious first, otherwise as they were found."""
    unique: dict[tuple[object, ...], Diagnostic] = {}
    for finding in findings:
        unique.setdefault((finding.rule, finding.of, finding.message), finding)
    return sorted(unique.values(), key=lambda finding: _WEIGHT[finding.severity])


def seconds(value: float) -> str:
    """Return a time in s or ms, with three digits at most; in years what no robot runs.

    >>> seconds(12.34), seconds(0.0981), seconds(0.0021), seconds(1.79e9)
    ('12.3 s', '98 ms', '2.1 ms', '56.7 years')
    """
    if value >= YEAR:
        return f"{value / YEAR:.1f} years"
    if value >= 1:
        return f"{value:.1f} s"
    return f"{value * 1e3:.0f} ms" if value >= 0.01 else f"{value * 1e3:.1f} ms"


def rate_text(rate: float) -> str:
    """Return a rate in Hz."""
    return "-" if math.isnan(rate) else f"{rate:.1f} Hz"


def share(part: int, whole: int) -> str:
    """Return a part of a whole in words and percent: '12 of 300 (4 %)'."""
    percent = 100 * part / whole if whole else 0.0
    shown = f"{percent:.0f}" if percent >= 1 or percent == 0 else f"{percent:.1g}"
    return f"{part:,} of {whole:,} ({shown} %)"


def pose_text(transform: Transform) -> str:
    """Return a transform as metres and degrees, in as many digits as people compare."""
    xyz = " ".join(_short(value, 6) for value in transform.xyz)
    rpy = " ".join(_short(math.degrees(value), 3) for value in transform.rpy())
    return f"{xyz} m, {rpy} deg"


def _short(value: float, digits: int) -> str:
    if not abs(value) < 1e6:
        return f"{value:.6g}"
    text = f"{value:.{digits}f}".rstrip("0").rstrip(".")
    return "0" if text in ("-0", "") else text


def difference(described: Transform, recorded: Transform) -> tuple[float, float, str]:
    """Return how far apart two transforms are, in metres and radians, and the difference in words.

    The move is along the axes of the parent, the turn about the axes of the described child.
    """
    (x, y, z), (u, v, w) = recorded.xyz, described.xyz
    move = (x - u, y - v, z - w)
    axis, angle = described.turn_to(recorded)
    parts = []
    far = math.hypot(*move)
    if angle > 1e-7:
        parts.append(f"turned by {_turn_text(angle, axis)}")
    if far > 1e-7:
        steps = [f"{'-' if step < 0 else '+'}{amount(abs(step), 'm')} in {along}" for along, step in _large(move, far)]
        parts.append(f"moved by {', '.join(steps)}")
    return far, angle, " and ".join(parts)


def _large(move: Vector, far: float) -> list[tuple[str, float]]:
    return [(axis, step) for axis, step in zip(_AXES, move, strict=True) if abs(step) > 0.02 * far]


def _turn_text(angle: float, axis: Vector) -> str:
    name = main_axis(axis)
    if abs(angle - math.pi) < _NEAR and name:
        return f"180 deg about {name}"
    if name:
        at = _AXES.index(name)
        sign = "-" if axis[at] < 0 else ""
        quarter = abs(angle - math.pi / 2) < math.radians(0.05)
        return f"{sign}{'90' if quarter else _degrees(angle)} deg about {name}"
    return f"{_degrees(angle)} deg about ({', '.join(_short(value, 2) for value in axis)})"


def _degrees(angle: float) -> str:
    degrees = math.degrees(angle)
    return f"{degrees:.1f}" if degrees >= 1 else f"{degrees:.2g}"


def main_axis(axis: Vector) -> str:
    """Return "x", "y" or "z" for an axis (of length one) that is within some degrees of it; otherwise nothing."""
    largest = max(range(3), key=lambda at: abs(axis[at]))
    return _AXES[largest] if abs(axis[largest]) > math.cos(2 * _NEAR) else ""


def half_turn_about(described: Transform, recorded: Transform) -> str:
    """Return the axis about which one rotation is the other turned by half a turn; nothing if it is not."""
    axis, angle = described.turn_to(recorded)
    return "" if abs(angle - math.pi) > _NEAR else main_axis(axis)
