"""Lower servo groups, and named poses, which may be given in pulses of servos."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from rosorin_compile.model.robot import JointPose
from rosorin_compile.model.servos import ServoGroup
from rosorin_compile.source.rule_registry import POSES, Rule
from rosorin_compile.source.tree import Map, Path

from ..misnamed import name_meant
from .entries import Problem, entries_of, source_of, values_of
from .plainly import pose_of_entry, record_of

RULES = (
    Rule(
        "unknown-servo",
        "No servo group has this joint, or there is no such group.",
        "Correct the name, or add it to a group.",
        POSES,
    ),
    Rule("pulse-range", "A pulse is outside the range of its servo.", "Correct the pulse or the range.", POSES),
)


def servos_of(tree: Mapping[str, Any], problem: Problem) -> tuple[ServoGroup, ...]:
    """Return the groups of servos; ``problem`` takes what is wrong with one."""
    return tuple(_group_of(name, entry, problem) for name, entry in entries_of(tree, "servos"))


def _group_of(name: str, entry: Mapping[str, Any], problem: Problem) -> ServoGroup:
    low, high = entry["pulse_range"]
    if not low < high:
        message = f"the pulse range goes from {low} to {high}"
        problem("pulse-range", message, ("servos", name, "pulse_range"), "give the smaller pulse first")
    elif not low <= entry["zero_pulse"] <= high:
        message = f"the zero pulse {entry['zero_pulse']} is outside the pulse range {low} to {high}"
        problem("pulse-range", message, ("servos", name, "zero_pulse"), "correct one of the two")
    if float(entry["rad_per_pulse"]) == 0:
        message = "a pulse of no angle moves nothing"
        problem("pulse-range", message, ("servos", name, "rad_per_pulse"), "give the angle of one pulse")
    return record_of(ServoGroup, entry, name=name, flipped=entry.get("flipped", False))


def _positions_of(
    pose: str, pulses: Mapping[str, int], servos: tuple[ServoGroup, ...], tree: Map, problem: Problem
) -> dict[str, float]:
    """Return the positions that the pulses of a pose give, by joint; ``problem`` takes what is wrong with one."""
    positions: dict[str, float] = {}
    for joint, pulse in pulses.items():
        path: Path = ("poses", pose, "pulses", joint)
        group = next((group for group in servos if joint in group.joints), None)
        if group is None:
            known = [joint for group in servos for joint in group.joints]
            if joint in (tree.get("joints") or ()) and not {*known} <= tree["joints"].keys():
                continue  # a servo group names it wrongly, which is told
            message = f'no servo group has the joint "{joint}"'
            problem("unknown-servo", message, path, name_meant(tree, path, joint, known), key=True)
            continue
        low, high = group.pulse_range
        if not low <= pulse <= high:
            problem("pulse-range", f"the pulse {pulse} does not exist: {low} to {high}", path, "correct it")
        positions[joint] = group.radians(pulse)
    return positions


def pose_of_joints(
    name: str, entry: Mapping[str, Any], servos: tuple[ServoGroup, ...], tree: Map, problem: Problem
) -> JointPose:
    """Return a named pose of a tree; its pulses are positions by ``servos``.

    ``problem`` takes what is wrong with it.
    """
    positions = {joint: float(value) for joint, value in sorted(entry.get("positions", {}).items())}
    pulses = dict(sorted(entry.get("pulses", {}).items()))
    if pulses:
        given = _positions_of(name, pulses, servos, tree, problem)
        for joint in (joint for joint in given if joint in positions):
            path: Path = ("poses", name, "pulses", joint)
            problem("duplicate-name", f'"{joint}" has a position and a pulse', path, "give one of them")
        positions |= given
    base = pose_of_entry(entry["base"]) if "base" in entry else None
    controls = {actuator: float(value) for actuator, value in sorted(entry.get("controls", {}).items())}
    more = values_of(entry.get("mjcf"))
    return JointPose(name, positions, pulses, source_of(entry.get("source")), base, controls, more)
