"""Names: which link of B is which link of A, seen through a prefix and through new names for the same thing."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import replace
from typing import NamedTuple

from ..model import Joint, Robot
from .bodies import Bodies
from .places import gap
from .printing import Printing

# A prefix is one if so many of the names that could bear it do.
_MOST = 0.6
# Where a joint is moved to, to see whether two joints turn or slide the same way (rad or m).
_PROBE = 0.5


class Known(NamedTuple):
    """What two robots are compared with: how well their numbers are known, and what counts as equal."""

    a: Printing
    b: Printing
    tolerance: float


def prefix_of(a: Robot, b: Robot) -> str:
    """Return what all names of the links of ``b`` begin with that those of ``a`` do not have; empty if nothing is."""
    mine, theirs = [link.name for link in a.links], [link.name for link in b.links]
    plain = len(set(mine) & set(theirs))
    found: dict[str, int] = {}
    for name in mine:
        for other in theirs:
            if other.endswith(name) and other != name:
                prefix = other[: -len(name)]
                found[prefix] = found.get(prefix, 0) + 1
    if not found:
        return ""
    best = max(sorted(found), key=lambda prefix: found[prefix])
    enough = found[best] > max(1, plain) and found[best] >= _MOST * min(len(mine), len(theirs))
    return best if enough else ""


def renamed(robot: Robot, links: Mapping[str, str], joints: Mapping[str, str]) -> Robot:
    """Return a robot under other names; links and joints that are not mentioned keep theirs."""

    def link(name: str) -> str:
        return links.get(name, name)

    def joint(name: str) -> str:
        return joints.get(name, name)

    return replace(
        robot,
        links=tuple(replace(one, name=link(one.name)) for one in robot.links),
        joints=tuple(_joint(one, links, joints) for one in robot.joints),
        sensors=tuple(
            replace(s, frame=link(s.frame), optical_frame=link(s.optical_frame), joint=joint(s.joint))
            for s in robot.sensors
        ),
        edges=tuple(replace(edge, parent=link(edge.parent), child=link(edge.child)) for edge in robot.edges),
        servos=tuple(replace(group, joints=tuple(map(joint, group.joints))) for group in robot.servos),
        poses=tuple(
            replace(
                pose,
                positions={joint(name): value for name, value in pose.positions.items()},
                pulses={joint(name): value for name, value in pose.pulses.items()},
            )
            for pose in robot.poses
        ),
        disabled_contacts=tuple((link(one), link(other)) for one, other in robot.disabled_contacts),
    )


def _joint(joint: Joint, links: Mapping[str, str], joints: Mapping[str, str]) -> Joint:
    parent, child = links.get(joint.parent, joint.parent), links.get(joint.child, joint.child)
    mimic = joint.mimic and replace(joint.mimic, joint=joints.get(joint.mimic.joint, joint.mimic.joint))
    return replace(joint, name=joints.get(joint.name, joint.name), parent=parent, child=child, mimic=mimic)


def without_prefix(robot: Robot, prefix: str) -> Robot:
    """Return a robot whose names have lost a prefix, unless the shorter name is taken."""

    def shorter(names: Iterable[str]) -> dict[str, str]:
        every = set(names)
        cut = {name: name.removeprefix(prefix) for name in every if name.startswith(prefix) and name != prefix}
        return {name: short for name, short in cut.items() if short not in every}

    return renamed(robot, shorter(robot.link), shorter(robot.joint))


def new_names(a: Robot, b: Robot, known: Known) -> dict[str, str]:
    """Return the links of ``b`` that are links of ``a`` under another name: b's name -> a's name.

    Such a link sits in the same place, moves in the same way, or hangs on the joint of the same name.
    """
    found: dict[str, str] = {}
    bodies = Bodies(a, known.a), Bodies(b, known.b)
    here = {link.name: link.name for link in a.links if link.name in b.link}
    again = True
    while again:
        again = False
        for link in a.walk():
            taken = set(here.values())
            spare = [other.name for other in b.walk() if other.name not in taken] if link.name not in here else []
            rated = [
                (_likeness(bodies, link.name, other, here, known.tolerance), -at) for at, other in enumerate(spare)
            ]
            best, at = max(rated, default=(0.0, 0))
            if best > 0:
                found[spare[-at]] = link.name
                here[link.name] = spare[-at]
                # What hangs on it may be known by it now.
                again = True
    return found


def _likeness(bodies: tuple[Bodies, Bodies], one: str, other: str, here: Mapping[str, str], tolerance: float) -> float:
    """Return how much a link of B is like one of A; 0 if it cannot be the same."""
    a, b = (body.robot for body in bodies)
    above, below = a.joint_to.get(one), b.joint_to.get(other)
    if above is None or below is None:
        known = _same_place(bodies, one, other, here, tolerance)
        known = known or (above is below is None and not _placed(bodies, here))
        return 1.0 + _alike(a, b, one, other, here) if known else 0.0
    if above.is_fixed != below.is_fixed:
        return 0.0
    same_joint = above.name == below.name and here.get(above.parent) == below.parent
    if not same_joint and not _same_place(bodies, one, other, here, tolerance):
        return 0.0
    return 1.0 + 4.0 * same_joint + _alike(a, b, one, other, here)


def _placed(bodies: tuple[Bodies, Bodies], here: Mapping[str, str]) -> bool:
    """Say whether the roots' bodies share a link: then the roots have places of their own to be known by."""
    a, b = bodies
    return any(here.get(name) in b.members[b.robot.root] for name in a.members[a.robot.root])


def _same_place(bodies: tuple[Bodies, Bodies], one: str, other: str, here: Mapping[str, str], tolerance: float) -> bool:
    """Say whether two links sit in the same place against a link that is known, and move against it alike."""
    a, b = bodies
    for start, moving in ((a.top[one], False), (a.above(a.top[one]), True)):
        anchors = [name for name in a.members[start] if name in here] if start is not None else []
        goal = b.above(b.top[other]) if moving else b.top[other]
        anchor = next((name for name in anchors if b.top[here[name]] == goal), None)
        if anchor is None:
            continue
        joints = [body.entering(body.top[name]) for body, name in zip(bodies, (one, other), strict=True)]
        for position in (0.0, _PROBE) if moving else (0.0,):
            first = a.relative(anchor, one, {joints[0].name: position} if joints[0] else {})
            second = b.relative(here[anchor], other, {joints[1].name: position} if joints[1] else {})
            if not gap(first, second, tolerance).closed:
                return False
        return True
    return False


def _alike(a: Robot, b: Robot, one: str, other: str, here: Mapping[str, str]) -> float:
    """Return what speaks for two links to be the same besides their place."""
    from difflib import SequenceMatcher

    first, second = a.link[one], b.link[other]
    mine = {here[joint.child] for joint in a.joints_from.get(one, ()) if joint.child in here}
    theirs = {joint.child for joint in b.joints_from.get(other, ())}
    points = 3.0 * bool(mine & theirs)
    points += first.inertial == second.inertial
    points += len(first.collision) == len(second.collision) and len(first.visual) == len(second.visual)
    return points + SequenceMatcher(None, one, other, autojunk=False).ratio()
