"""Ranges: what a joint can reach against what drives it there: its leader, a speed, position zero."""

from __future__ import annotations

import re
from collections.abc import Iterator
from typing import Any

from rosorin_compile.language.annotations import Node
from rosorin_compile.language.schema import sections
from rosorin_compile.model import Joint, Limit
from rosorin_compile.source.diagnostics import NOTE, WARNING, Diagnostic
from rosorin_compile.source.rule_registry import JOINTS, POSES, rule
from rosorin_compile.source.tree import Path
from rosorin_compile.source.wording import first_of

from .case import Case, number

# Limits are printed to a few digits, and a linkage is no exact ratio: so much of the range of a joint may be beyond.
ROUNDED = 0.05
SHOWN = 8

# A limit that is zero, and was calculated.
HAIR = 1e-6
_INITIAL = re.compile(r"<initial_position>\s*([-+]?[0-9.]+(?:[eE][-+]?[0-9]+)?)\s*<")


@rule(
    "mimic-beyond-limit",
    "A warning: a joint that follows another is driven beyond its own limits.",
    "Correct `multiplier` and `offset`, or one of the limits.",
    JOINTS,
    accept="joint",
    imported="always",
)
def followers(case: Case) -> Iterator[Diagnostic]:
    """Followers whose leader, within its limits, puts them beyond their own."""
    for joint in case.robot.joints:
        mimic, own = joint.mimic, range_of(joint)
        leader = case.robot.joint.get(mimic.joint) if mimic else None
        if mimic is None or own is None or leader is None or leader.mimic is not None:
            continue
        driven = range_of(leader)
        if driven is None:
            continue
        ends = sorted(mimic.multiplier * end + mimic.offset for end in driven)
        slack = ROUNDED * (own[1] - own[0])
        if own[0] - slack <= ends[0] and ends[1] <= own[1] + slack:
            continue
        path = case.joint(joint, "mimic")
        outer = abs(mimic.offset) > max(abs(own[0]), abs(own[1])) + slack
        key = "offset" if outer else "multiplier"
        message = (
            f'joint "{joint.name}" follows "{leader.name}" to {span_of(ends, joint)}, beyond its own limits of'
            f" {span_of(own, joint)}{case.stands_in(case.joint(joint, 'limit'))}"
        )
        related = [case.related("its limits", case.joint(joint, "limit"))]
        related.append(case.related("those of the leader", case.joint(leader, "limit")))
        help = "correct multiplier and offset, or one of the limits"
        yield case.problem("mimic-beyond-limit", message, (*path, key), help, related=related, severity=WARNING)


@rule(
    "beyond-joint-limit",
    "A warning: a soft limit, an edge of a calibration or an initial value is beyond the limits of its joint, or soft "
    "limits leave it no room, or it turns without end.",
    "Correct it, or the limit.",
    JOINTS,
    accept="joint",
    imported="always",
)
def within_joint_limits(case: Case) -> Iterator[Diagnostic]:
    """Values that the schema bounds by the limits of a joint (``x-within``) must be within these limits."""
    for section, node in sections().items():
        for path, name, value in _bounded(node, case.tree.get(section), (section,), ""):
            joint = case.robot.joint.get(name)
            if joint is None or not joint.moves:
                continue
            interface = str(path[-2]) if path[-2] in ("velocity", "effort") else "position"
            lower, upper = joint.limits_of(interface)
            below, above = lower is not None and value < lower - HAIR, upper is not None and value > upper + HAIR
            if below or above:
                what = f"{path[-1] if path[-2] != 'calibration' else f'calibration {path[-1]}'}".replace("_", " ")
                limits = f"{number(lower or 0.0)} to {number(upper or 0.0)}"
                message = f'the {what} of joint "{name}" is {number(value)}, beyond its limits of {limits}'
                related = [case.related("its limits", case.joint(joint, "limit"))]
                help = "correct it, or the limit"
                yield case.problem("beyond-joint-limit", message, path, help, related=related, severity=WARNING)
    for joint in case.robot.joints:
        yield from _initial_positions(case, joint)
        safety = joint.safety if joint.moves else None
        both = () if safety is None else (safety.soft_lower_limit, safety.soft_upper_limit)
        ends = [end for end in both if end is not None]
        if joint.type == "continuous" and any(ends):
            message = f'joint "{joint.name}" is continuous: its soft limits have no effect'
            path, help = case.joint(joint, "safety_controller"), "make it revolute, or leave them out"
            yield case.problem("beyond-joint-limit", message, path, help, severity=WARNING, within=True)
        elif len(ends) == 2 and ends[0] >= ends[1]:
            message = f'the soft limits of joint "{joint.name}", {span_of(ends, joint)}, leave it no room to move'
            path, help = case.joint(joint, "safety_controller"), "widen them, or leave them out"
            yield case.problem("beyond-joint-limit", message, path, help, severity=WARNING, within=True)


def _initial_positions(case: Case, joint: Joint) -> Iterator[Diagnostic]:
    """Find initial positions that a joint keeps for SDF beyond its limits."""
    limits = range_of(joint)
    for index, text in enumerate(joint.urdf_elements if limits is not None else ()):
        for value in map(float, _INITIAL.findall(text)):
            if limits is not None and not limits[0] - HAIR <= value <= limits[1] + HAIR:
                message = f'the initial position of joint "{joint.name}" is {number(value)}, beyond its limits of'
                message += f" {number(limits[0])} to {number(limits[1])}"
                path = case.joint(joint, "urdf_elements", index)
                yield case.problem("beyond-joint-limit", message, path, "correct it, or the limit", severity=WARNING)


def _bounded(node: Node | None, value: Any, path: Path, joint: str) -> Iterator[tuple[Path, str, float]]:
    """Yield the numbers that are bounded by their joint, each with its path and the name of the joint."""
    if node is None:
        return
    if node.within and isinstance(value, (int, float)):
        yield path, joint, float(value)
    names = node.keys is not None and "joint" in (node.keys.gives, node.keys.names)
    for key, inner in value.items() if isinstance(value, dict) else ():
        yield from _bounded(node.at(key), inner, (*path, key), key if names else joint)


def range_of(joint: Joint) -> tuple[float, float] | None:
    """Return the limits of a joint that has some; None if they mean nothing."""
    limit: Limit | None = joint.limit
    if joint.type not in ("revolute", "prismatic") or limit is None or limit.lower is None or limit.upper is None:
        return None
    return (limit.lower, limit.upper) if limit.lower < limit.upper else None


def span_of(ends: tuple[float, float] | list[float], joint: Joint) -> str:
    """Return a range of a joint in words."""
    return f"{number(ends[0])} to {number(ends[1])} {'m' if joint.type == 'prismatic' else 'rad'}"


@rule(
    "zero-beyond-limit",
    "A note: zero is not within the limits of a joint, and no pose places it; simulations begin at zero.",
    "Add a pose that does.",
    POSES,
)
def zeros(case: Case) -> Iterator[Diagnostic]:
    """Joints that cannot be at zero and are said to be nowhere else."""
    placed = {name for pose in case.robot.poses for name in pose.positions}
    away = [joint for joint in case.robot.joints if joint.mimic is None and joint.name not in placed]
    away = [joint for joint in away if (ends := range_of(joint)) and not _reaches(ends, 0.0)]
    if not away:
        return
    names = first_of([f'"{joint.name}" ({span_of(range_of(joint) or (0, 0), joint)})' for joint in away], SHOWN)
    message = f"zero, where simulations begin, is not within the limits of {names}"
    first = range_of(away[0]) or (0.0, 0.0)
    place = case.joint(away[0], "limit", "lower" if first[0] > 0 else "upper")
    yield case.problem("zero-beyond-limit", message, place, "add a pose that places it", severity=NOTE)


def _reaches(ends: tuple[float, float], position: float) -> bool:
    return ends[0] - HAIR <= position <= ends[1] + HAIR
