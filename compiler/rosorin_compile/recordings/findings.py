"""Create findings of rules about recordings, and format their numbers."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import replace

from rosorin_compile.model import Transform, Vector
from rosorin_compile.source.diagnostics import ERROR, NOTE, WARNING, Diagnostic, Help, Related, diagnostic
from rosorin_compile.source.numbers import amount
from rosorin_compile.source.rule_registry import find_declared

# The help of a rule is the default for its findings.

YEAR = 365.25 * 86400.0  # s
_NEAR = math.radians(2.0)  # tolerance for a half turn or a quarter turn
_AXES = ("x", "y", "z")
_WEIGHT = {ERROR: 0, WARNING: 1, NOTE: 2}


def problem(
    rule: str, subject: str, message: str, help: Help = "", evidence: Iterable[str] = (), severity: str = ""
) -> Diagnostic:
    """Return a finding about a subject (an edge, topic or joint); ``evidence`` is printed below the message.

    By default, help and severity are those of the rule.
    """
    related, known = tuple(Related(line, None) for line in evidence), find_declared(rule)
    usual = known.help[:1].lower() + known.help[1:].rstrip(".").replace("`", "")
    return replace(diagnostic(rule, severity or known.severity, message, None, help or usual, related), of=(subject,))


def sort_findings(findings: Iterable[Diagnostic]) -> list[Diagnostic]:
    """Remove duplicate findings, and sort by severity; the order is otherwise unchanged."""
    unique: dict[tuple[object, ...], Diagnostic] = {}
    for finding in findings:
        unique.setdefault((finding.rule, finding.of, finding.message), finding)
    return sorted(unique.values(), key=lambda finding: _WEIGHT[finding.severity])


def seconds(value: float) -> str:
    """Return a time in s, ms or years with at most three digits.

    >>> seconds(12.34), seconds(0.0981), seconds(0.0021), seconds(1.79e9)
    ('12.3 s', '98 ms', '2.1 ms', '56.7 years')
    """
    if value >= YEAR:
        return f"{value / YEAR:.1f} years"
    if value >= 1:
        return f"{value:.1f} s"
    return f"{value * 1e3:.0f} ms" if value >= 0.01 else f"{value * 1e3:.1f} ms"


def rate_text(rate: float | None) -> str:
    """Format a rate in Hz, or return "-" if it is unknown."""
    return "-" if rate is None or math.isnan(rate) else f"{rate:.1f} Hz"


def share(part: int, total: int) -> str:
    """Return a part of a total: '12 of 300 (4 %)'."""
    percent = 100 * part / total if total else 0.0
    shown = f"{percent:.0f}" if percent >= 1 or percent == 0 else f"{percent:.1g}"
    return f"{part:,} of {total:,} ({shown} %)"


def pose_text(transform: Transform) -> str:
    """Format a transform in metres and degrees."""
    xyz = " ".join(_short(value, 6) for value in transform.xyz)
    rpy = " ".join(_short(math.degrees(value), 3) for value in transform.rpy())
    return f"{xyz} m, {rpy} deg"


def _short(value: float, digits: int) -> str:
    if not abs(value) < 1e6:
        return f"{value:.6g}"
    text = f"{value:.{digits}f}".rstrip("0").rstrip(".")
    return "0" if text in ("-0", "") else text


def difference(described: Transform, recorded: Transform) -> tuple[float, float, str]:
    """Return the distance between two transforms in m and rad, and a description of the difference.

    Translations are along the axes of the parent, rotations about the axes of the described child.
    """
    move = [b - a for a, b in zip(described.xyz, recorded.xyz, strict=True)]
    axis, angle = described.turn_to(recorded)
    far = math.hypot(*move)
    parts = []
    if angle > 1e-7:
        name, degrees = _main_axis(axis), math.degrees(angle)
        along = f"({', '.join(_short(value, 2) for value in axis)})"
        shown = f"{degrees:.1f}" if degrees >= 1 else f"{degrees:.2g}"
        if name and abs(angle - math.pi) < _NEAR:
            shown = "180"
        elif name:
            shown = "90" if abs(degrees - 90) < 0.05 else shown
            shown = f"-{shown}" if axis[_AXES.index(name)] < 0 else shown
        parts.append(f"turned by {shown} deg about {name or along}")
    if far > 1e-7:
        steps = [(name, step) for name, step in zip(_AXES, move, strict=True) if abs(step) > 0.02 * far]
        words = (f"{'-' if step < 0 else '+'}{amount(abs(step), 'm')} in {name}" for name, step in steps)
        parts.append(f"moved by {', '.join(words)}")
    return far, angle, " and ".join(parts)


def value_rule(described: Transform, recorded: Transform) -> str:
    """Return the rule for a wrong value; a half turn about z suggests a sensor that is mounted backwards."""
    axis, angle = described.turn_to(recorded)
    backwards = abs(angle - math.pi) <= _NEAR and _main_axis(axis) == "z"
    return "mounted-backwards" if backwards else "edge-wrong-value"


def _main_axis(axis: Vector) -> str:
    """Return "x", "y" or "z" for a unit vector within 4 degrees of that axis, otherwise an empty string."""
    largest = max(range(3), key=lambda at: abs(axis[at]))
    return _AXES[largest] if abs(axis[largest]) > math.cos(2 * _NEAR) else ""
