"""Lacking: what a link of a robot does not have, though those around it do; and the mass that readers drop."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

from rosorin_compile.model import ROBOT_STATE_PUBLISHER, Link
from rosorin_compile.source.diagnostics import NOTE, WARNING, Diagnostic
from rosorin_compile.source.rule_registry import JOINTS, rule

from .case import Case

# Most have it: where more than this lack mass or collision, the robot is drawn without on purpose.
FEW_WITHOUT_MASS = 0.5
FEW_WITHOUT_COLLISION = 0.25  # or a single one


class _Piece(NamedTuple):
    """Links that fixed joints hold together, whether a joint moves them, and what one of them has.

    A mass may be one that is none, which is told already.
    """

    links: list[Link]
    moves: bool
    has_mass: bool
    is_seen: bool
    collides: bool


@rule(
    "inertial-missing",
    "A warning: a link that moves has no mass, though most of the robot has.",
    "Give it an `inertial`, or make the joint fixed.",
    JOINTS,
)
@rule(
    "collision-missing",
    "A note: a link that moves is seen and collides with nothing, though nearly all others do.",
    "Give it a `collision`.",
    JOINTS,
)
def parts(case: Case) -> Iterator[Diagnostic]:
    """Find moving parts without mass or without collision, where others have one."""
    pieces = _pieces(case)
    moving = [piece for piece in pieces if piece.moves and (piece.is_seen or piece.collides)]
    light = [piece for piece in moving if not piece.has_mass]
    if len(light) <= FEW_WITHOUT_MASS * len(moving) or len(moving) == 1:
        heavy = sum(piece.has_mass for piece in pieces)
        for piece in light if heavy else ():
            link = next(link for link in piece.links if link.visual or link.collision)
            have = "another part of the robot has" if heavy == 1 else f"{heavy} other parts of the robot have"
            message = f'link "{link.name}" moves and has no mass, and {have}'
            help = "give it an inertial: engines drop it, or refuse the robot"
            path = case.link(link.name)
            yield case.problem("inertial-missing", message, path, help, severity=WARNING, key=True)
    seen = [piece for piece in moving if piece.is_seen]
    through = [piece for piece in seen if not piece.collides]
    others = len(seen) - len(through)
    if others > 1 and len(through) <= max(1, FEW_WITHOUT_COLLISION * len(seen)):
        for piece in through:
            link = next(link for link in piece.links if link.visual)
            message = f'link "{link.name}" moves, is seen and collides with nothing, unlike {others}'
            message += " other parts of the robot"
            path = case.link(link.name)
            yield case.problem("collision-missing", message, path, "give it a collision", severity=NOTE, key=True)


def _pieces(case: Case) -> list[_Piece]:
    """Return the links that move as one; of a robot whose joints lead in circles, or whose links are missing, too."""
    above = {link.name: link.name for link in case.robot.links}

    def first(name: str) -> str:
        while above[name] != name:
            above[name] = above[above[name]]
            name = above[name]
        return name

    for joint in case.robot.joints:
        if joint.is_fixed and joint.parent in above and joint.child in above:
            above[first(joint.child)] = first(joint.parent)
    top = {name: first(name) for name in above}
    moved = {top[joint.child] for joint in case.robot.joints if not joint.is_fixed and joint.child in top}
    pieces: dict[str, list[Link]] = {}
    for link in case.robot.links:
        pieces.setdefault(top[link.name], []).append(link)
    return [_piece(links, name in moved) for name, links in pieces.items()]


def _piece(links: list[Link], moves: bool) -> _Piece:
    has_mass = is_seen = collides = False
    for link in links:
        has_mass = has_mass or link.inertial is not None
        is_seen = is_seen or bool(link.visual)
        collides = collides or bool(link.collision)
    return _Piece(links, moves, has_mass, is_seen, collides)


@rule(
    "root-inertial",
    "A note: the root link of the URDF has a mass, which kdl_parser drops with a warning, as robot_state_publisher "
    "does at each start.",
    "Begin the robot at a link without mass, with a fixed joint to this one.",
    JOINTS,
)
def root(case: Case) -> Iterator[Diagnostic]:
    """Look at the root of what robot_state_publisher reads: whether it has a mass.

    ros/kdl_parser@humble:src/kdl_parser.cpp: "The root link ... has an inertia specified in the URDF, but KDL does not
    support a root link with an inertia."
    """
    joints = case.robot.in_urdf()
    if not joints or not case.feeding(ROBOT_STATE_PUBLISHER):
        return
    children = {joint.child for joint in joints}
    roots = dict.fromkeys(joint.parent for joint in joints if joint.parent not in children)
    for name in roots if len(roots) == 1 else ():
        link = case.robot.link.get(name)
        if link is not None and link.inertial is not None:
            message = (
                f'link "{name}" is the root of the URDF and has a mass: kdl_parser drops it, and robot_state_publisher'
                " warns of it"
            )
            help = f'begin the robot at a link without mass, with a fixed joint to "{name}"'
            yield case.problem("root-inertial", message, case.link(name, "inertial"), help, severity=NOTE, key=True)
