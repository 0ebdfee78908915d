"""Poses: they turn joints that move, within their limits."""

from __future__ import annotations

from collections.abc import Iterator

from rosorin_compile.model import Joint
from rosorin_compile.source.diagnostics import WARNING, Diagnostic
from rosorin_compile.source.rule_registry import POSES, Check, rule
from rosorin_compile.source.tree import Path

from .case import Case, number
from .magnitudes import FULL_TURN

# Positions come from pulses and printed limits: a hair beyond is rounding.
ROUNDING = 1e-6


def fixed(case: Case, joint: Joint, path: Path, what: str, key: bool = False) -> Diagnostic:
    """Return what is wrong where a joint is moved that does not move, or has no single position."""
    related = [case.related("the joint", case.joint(joint), key=True)]
    if not joint.is_fixed:
        message = f'{what} joint "{joint.name}", which is {joint.type} and has no single position'
        help = "leave it out: it is at its origin in every pose"
        return case.problem("joint-has-no-position", message, path, help, related=related, key=key)
    message = f'{what} joint "{joint.name}", which is fixed'
    return case.problem("joint-is-fixed", message, path, "name a joint that moves", related=related, key=key)


@rule(
    "joint-has-no-position",
    "A servo turns or a pose moves a planar or a floating joint, which has no single position.",
    "Leave it out.",
    POSES,
)
@rule("joint-is-fixed", "A servo turns or a pose moves a joint that is fixed.", "Name a joint that moves.", POSES)
@rule(
    "pose-beyond-limit",
    "A warning: a pose is beyond the limit of a joint.",
    "Correct the pose or the limit.",
    POSES,
)
def positions(case: Case) -> Iterator[Diagnostic]:
    """Poses of joints that are fixed, of followers, or beyond a limit."""
    for pose in case.robot.poses:
        for name, position in pose.positions.items():
            joint = case.robot.joint.get(name)
            if joint is None:
                continue
            kind = "pulses" if name in pose.pulses else "positions"
            path: Path = ("poses", pose.name, kind, name)
            if not joint.moves:
                if kind == "positions":
                    yield fixed(case, joint, path, f'pose "{pose.name}" moves', key=True)
            elif joint.mimic is not None:
                message = f'pose "{pose.name}" places joint "{name}", which follows "{joint.mimic.joint}": no effect'
                help = f'place "{joint.mimic.joint}" instead'
                yield case.problem("ignored-key", message, path, help, severity=WARNING, key=True)
            else:
                yield from _beyond(case, pose.name, joint, position, path)


@Check
def at_zero(case: Case) -> Iterator[Diagnostic]:
    """Joints that a pose does not name, and that cannot be at zero, where it leaves them.

    A pose that is said to be the state of a planning group is about the joints of that.
    """
    moveit = case.robot.moveit
    states = {pose for group in (moveit.groups if moveit else ()) for pose in (group.states or {}).values()}
    for joint in case.robot.joints:
        if joint.mimic is None and joint.moves and any(joint.name in pose.positions for pose in case.robot.poses):
            for pose in case.robot.poses:
                if joint.name not in pose.positions and pose.name not in states:
                    yield from _beyond(case, pose.name, joint, 0.0, ("poses", pose.name), "leaves")


def _beyond(
    case: Case, pose: str, joint: Joint, position: float, path: Path, does: str = "places"
) -> Iterator[Diagnostic]:
    """Yield a warning if a position is outside the limits; angles that look like degrees have a rule of their own."""
    limit = joint.limit
    if limit is None or limit.lower is None or limit.upper is None or joint.type == "continuous":
        return
    if limit.lower > limit.upper or (joint.type == "revolute" and abs(position) > FULL_TURN):
        return
    if limit.lower - ROUNDING <= position <= limit.upper + ROUNDING:
        return
    unit = "m" if joint.type == "prismatic" else "rad"
    side, end = ("below", limit.lower) if position < limit.lower else ("above", limit.upper)
    bound = "lower" if side == "below" else "upper"
    message = (
        f'pose "{pose}" {does} joint "{joint.name}" at {number(position)} {unit},'
        f" {side} its {bound} limit of {number(end)} {unit}"
    )
    related = [case.related("the limit", case.joint(joint, "limit", bound))]
    help = "correct the pose or the limit"
    key = does != "places"
    yield case.problem("pose-beyond-limit", message, path, help, severity=WARNING, related=related, key=key)
