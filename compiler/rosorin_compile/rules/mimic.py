"""Mimics: joints that follow another."""

from __future__ import annotations

from collections.abc import Iterator

from rosorin_compile.model import ROBOT_STATE_PUBLISHER, Joint
from rosorin_compile.model.joint import Mimic
from rosorin_compile.source.diagnostics import WARNING, Diagnostic
from rosorin_compile.source.rule_registry import JOINTS, rule

from .case import Case, number


@rule("mimic-unknown", "A joint follows a joint that does not exist.", "Name its leader.", JOINTS)
@rule(
    "mimic-fixed",
    "A joint without a single position (fixed, planar, floating, ball) follows, or is followed.",
    "Name a joint that moves.",
    JOINTS,
    accept="joint",
    imported="always",
)
@rule("mimic-cycle", "Joints follow each other in a circle.", "Let one of them lead.", JOINTS)
def leaders(case: Case) -> Iterator[Diagnostic]:
    """Leaders that are missing or cannot lead, and followers that follow themselves."""
    robot = case.robot
    for joint in robot.joints:
        if joint.mimic is None:
            continue
        path = case.joint(joint, "mimic", "joint")
        leader = robot.joint.get(joint.mimic.joint)
        if not joint.moves:
            message = f'joint "{joint.name}" is {joint.type} and cannot follow "{joint.mimic.joint}"'
            help = "remove mimic, or correct the type of the joint"
            yield case.problem("mimic-fixed", message, case.joint(joint, "mimic"), help, key=True)
        elif leader is None:
            message = f'joint "{joint.name}" follows "{joint.mimic.joint}", but there is no such joint'
            moving = [other.name for other in robot.joints if other.moves and other is not joint]
            help = case.suggest(path, joint.mimic.joint, moving, "name a joint that moves")
            yield case.problem("mimic-unknown", message, path, help)
        elif not leader.moves:
            what = "fixed and never moves" if leader.is_fixed else f"{leader.type} and has no single position"
            message = f'joint "{joint.name}" follows "{leader.name}", which is {what}'
            related = [case.related("the leader", case.joint(leader), key=True)]
            yield case.problem("mimic-fixed", message, path, "name a joint that moves", related=related)
    for circle in circles(case):
        yield _circle(case, circle)


def circles(case: Case) -> Iterator[list[Joint]]:
    """Yield each circle of followers once, beginning with the joint that the description names first."""
    done: set[str] = set()
    for start in case.robot.joints:
        if start.mimic is None:
            continue
        chain: list[Joint] = []
        joint: Joint | None = start
        while joint is not None and joint.name not in done:
            done.add(joint.name)
            chain.append(joint)
            joint = case.robot.joint.get(joint.mimic.joint) if joint.mimic else None
        names = [step.name for step in chain]
        if joint is not None and joint.name in names:
            yield chain[names.index(joint.name) :]


def _circle(case: Case, circle: list[Joint]) -> Diagnostic:
    first = circle[0]
    path = case.joint(first, "mimic", "joint")
    if len(circle) == 1:
        message = f'joint "{first.name}" follows itself'
    else:
        message = f"joints follow each other in a circle: {' -> '.join(joint.name for joint in [*circle, first])}"
    related = [
        case.related(f'"{joint.name}" follows here', case.joint(joint, "mimic", "joint")) for joint in circle[1:]
    ]
    return case.problem("mimic-cycle", message, path, "let one of them lead: remove its mimic", related=related)


@rule("mimic-not-published", "A joint follows one that is not in the URDF.", "Give both the same publisher.", JOINTS)
@rule(
    "mimic-chain",
    "A warning: a follower of a follower, in an order that robot_state_publisher does not resolve.",
    "Follow the first leader directly; the message gives the numbers.",
    JOINTS,
    accept="joint",
    imported="always",
)
def order(case: Case) -> Iterator[Diagnostic]:
    """Followers that robot_state_publisher cannot resolve.

    It goes once through the followers by name (ros/robot_state_publisher@humble:src/robot_state_publisher.cpp), so a
    follower of a follower is lost unless its leader comes first; and readers of the URDF look for the leader there.
    """
    robot = case.robot
    for joint in robot.joints:
        leader = robot.joint.get(joint.mimic.joint) if joint.mimic else None
        if leader is None or joint.mimic is None or joint.publisher.kind != ROBOT_STATE_PUBLISHER:
            continue
        if not (joint.moves and leader.moves) or leader is joint:
            continue
        path = case.joint(joint, "mimic", "joint")
        if leader.publisher.kind != ROBOT_STATE_PUBLISHER:
            message = f'joint "{joint.name}" follows "{leader.name}", which is not in the URDF: another publishes it'
            related = [case.related("the publisher of the leader", case.publisher(leader))]
            help = "give both the same publisher"
            yield case.problem("mimic-not-published", message, path, help, related=related)
        elif leader.mimic is not None and joint.name.encode() < leader.name.encode() and not _in_circle(case, joint):
            yield _chain(case, joint, leader, leader.mimic)


def _in_circle(case: Case, joint: Joint) -> bool:
    seen: set[str] = set()
    here: Joint | None = joint
    while here is not None and here.mimic is not None:
        if here.name in seen:
            return True
        seen.add(here.name)
        here = case.robot.joint.get(here.mimic.joint)
    return False


def _chain(case: Case, joint: Joint, leader: Joint, further: Mimic) -> Diagnostic:
    mimic = joint.mimic or further
    factor = mimic.multiplier * further.multiplier
    offset = mimic.multiplier * further.offset + mimic.offset
    message = (
        f'joint "{joint.name}" follows "{leader.name}", itself a follower that comes later by name:'
        " robot_state_publisher would not move it"
    )
    direct = f"joint: {further.joint}, multiplier: {number(factor)}"
    help = f"follow the leader directly: {{{direct}{f', offset: {number(offset)}' if offset else ''}}}"
    related = [case.related(f'"{leader.name}" follows "{further.joint}"', case.joint(leader, "mimic", "joint"))]
    path = case.joint(joint, "mimic", "joint")
    return case.problem("mimic-chain", message, path, help, severity=WARNING, related=related)
