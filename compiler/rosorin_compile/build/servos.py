"""Building servos and poses: pulses become positions."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

from ..diagnostic import did_you_mean
from ..model import JointPose, ServoGroup
from ..registry import POSES, Rule
from ..tree import Path
from .values import source_of

RULES = (
    Rule(
        "unknown-servo",
        "No servo group has this joint, or there is no such group.",
        "Correct the name, or add it to a group.",
        POSES,
    ),
    Rule("pulse-range", "A pulse is outside the range of its servo.", "Correct the pulse or the range.", POSES),
)

# Takes the rule, the message, the path and the way out of a problem.
Problem = Callable[[str, str, Path, str], None]


def servo_group_of(name: str, entry: Mapping[str, Any], problem: Problem) -> ServoGroup:
    """Return a group of servos; ``problem`` takes what is wrong with it."""
    low, high = entry["pulse_range"]
    if not low < high:
        message = f"the pulse range goes from {low} to {high}"
        problem("pulse-range", message, ("servos", name, "pulse_range"), "give the smaller pulse first")
    elif not low <= entry["zero_pulse"] <= high:
        message = f"the zero pulse {entry['zero_pulse']} is outside the pulse range {low} to {high}"
        problem("pulse-range", message, ("servos", name, "zero_pulse"), "correct one of the two")
    flipped, source = entry.get("flipped", False), source_of(entry.get("source"))
    rad = float(entry["rad_per_pulse"])
    if rad == 0:
        message = "a pulse of no angle moves nothing"
        problem("pulse-range", message, ("servos", name, "rad_per_pulse"), "give the angle of one pulse")
    return ServoGroup(name, tuple(entry["joints"]), rad, entry["zero_pulse"], flipped, (low, high), source)


def pose_of_joints(name: str, entry: Mapping[str, Any], servos: Sequence[ServoGroup], problem: Problem) -> JointPose:
    """Return a named pose, pulses as positions; ``problem`` takes what is wrong with it."""
    positions = {joint: float(value) for joint, value in sorted(entry.get("positions", {}).items())}
    pulses = dict(sorted(entry.get("pulses", {}).items()))
    for joint, pulse in pulses.items():
        path: Path = ("poses", name, "pulses", joint)
        group = next((group for group in servos if joint in group.joints), None)
        if group is None:
            known = [joint for group in servos for joint in group.joints]
            message = f'no servo group has the joint "{joint}"'
            problem("unknown-servo", message, path, did_you_mean(joint, known))
            continue
        low, high = group.pulse_range
        if not low <= pulse <= high:
            problem("pulse-range", f"the pulse {pulse} does not exist: {low} to {high}", path, "correct it")
        if joint in positions:
            problem("duplicate-name", f'"{joint}" has a position and a pulse', path, "give one of them")
        positions[joint] = group.radians(pulse)
    return JointPose(name, positions, pulses, source_of(entry.get("source")))
