"""Servos: each turns a joint that moves, and no joint has two; their scales against what their joints reach."""

from __future__ import annotations

import math
from collections.abc import Iterator

from rosorin_compile.model import Joint
from rosorin_compile.model.servos import ServoGroup
from rosorin_compile.rules.case import Case, number
from rosorin_compile.rules.poses import fixed
from rosorin_compile.rules.ranges import range_of, span_of
from rosorin_compile.source.diagnostics import WARNING, Diagnostic
from rosorin_compile.source.rule_registry import POSES, rule
from rosorin_compile.source.tree import Path

# rad. A pulse or a tick of a servo is a hundredth of that; a hand that counts in whole turns does so with gears.
COARSE = 0.1
# A servo reaches more or less than its joint, by a gear that is not said too; not by as much.
OTHER_RANGE = 20.0
SEVERAL_TURNS = 4 * math.pi


@rule("two-servos", "A joint is in two servo groups.", "Name it in one.", POSES)
def groups(case: Case) -> Iterator[Diagnostic]:
    """Servos of fixed joints, and joints with two servos."""
    taken: dict[str, Path] = {}
    order = list(case.tree.get("servos") or ())
    servos = case.robot.servos
    for group in sorted(servos, key=lambda group: order.index(group.name)):
        for index, name in enumerate(group.joints):
            path: Path = ("servos", group.name, "joints", index)
            joint = case.robot.joint.get(name)
            if joint is not None and not joint.moves:
                yield fixed(case, joint, path, f'servo group "{group.name}" turns')
            if name in taken and joint is not None:  # else that is told
                message = f'joint "{name}" has two servos'
                related = [case.related("its first servo", taken[name])]
                yield case.problem("two-servos", message, path, "name it in one place", related=related)
            taken.setdefault(name, path)


@rule(
    "servo-range",
    "A warning: a pulse turns a servo by many degrees, or all pulses together reach much more or much less than the "
    "joint.",
    "`rad_per_pulse` is the angle of one pulse, in radians: `${240*deg / 1000}`.",
    POSES,
)
def scales(case: Case) -> Iterator[Diagnostic]:
    """Scales of pulses that are in degrees, or were turned into radians twice."""
    for group in case.robot.servos:
        joints = [case.robot.joint[name] for name in group.joints if name in case.robot.joint]
        reach = abs(group.rad_per_pulse) * (group.pulse_range[1] - group.pulse_range[0])
        told = _coarse(case, group, reach) if any(joint.type != "prismatic" for joint in joints) else None
        told = told or next((found for joint in joints if (found := _other_range(case, group, joint, reach))), None)
        if told is not None:
            yield told


def _coarse(case: Case, group: ServoGroup, reach: float) -> Diagnostic | None:
    if abs(group.rad_per_pulse) < COARSE or reach < SEVERAL_TURNS:
        return None
    place: Path = ("servos", group.name, "rad_per_pulse")
    message = (
        f'a pulse turns the servos "{group.name}" by {number(group.rad_per_pulse)} rad{case.stands_in(place)}, and all'
        f" of them by {number(reach)} rad, {number(round(reach / (2 * math.pi), 1))} turns: this looks like degrees"
    )
    help = "rad_per_pulse is in radians: ${240*deg / 1000} is 240 degrees over 1000 pulses"
    return case.problem("servo-range", message, place, help, severity=WARNING)


def _other_range(case: Case, group: ServoGroup, joint: Joint, reach: float) -> Diagnostic | None:
    ends = range_of(joint)
    if ends is None or 1 / OTHER_RANGE <= reach / (ends[1] - ends[0]) <= OTHER_RANGE:
        return None
    place: Path = ("servos", group.name, "rad_per_pulse")
    unit = "m" if joint.type == "prismatic" else "rad"
    message = (
        f'all pulses of the servos "{group.name}" together are {number(reach)} {unit}{case.stands_in(place)}, and joint'
        f' "{joint.name}" goes from {span_of(ends, joint)}{case.stands_in(case.joint(joint, "limit"))}'
    )
    related = [case.related("its limits", case.joint(joint, "limit"))]
    help = "rad_per_pulse is the way of one pulse, in radians or metres"
    return case.problem("servo-range", message, place, help, related=related, severity=WARNING)
