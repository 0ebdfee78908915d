"""Pairing: two robots under common names, their bodies side by side."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

from ..model import Joint, Robot
from .bodies import Bodies
from .names import Known, new_names, prefix_of, renamed, without_prefix
from .values import Side


class Pairing(NamedTuple):
    """Two robots side by side, B under the names of A.

    ``bodies`` are the bodies of A (by their topmost link) that B has too, with those of B; ``links`` and ``joints`` are
    the names in A of what B calls otherwise, by B's name without its prefix; ``prefix`` stands before all names of
    ``prefixed`` ("A", "B" or "").
    """

    a: Bodies
    b: Bodies
    bodies: Mapping[str, str]
    links: Mapping[str, str]
    joints: Mapping[str, str]
    prefix: str
    prefixed: str
    tolerance: float

    @property
    def shared(self) -> list[str]:
        """The links that both robots have, in the order of A's tree."""
        return [link.name for link in self.a.robot.walk() if link.name in self.b.robot.link]

    def pair_of_joints(self, top: str) -> tuple[Joint | None, Joint | None]:
        """Return the joints that move a body of A and that of B which it is."""
        return self.a.entering(top), self.b.entering(self.bodies[top])


def pair(a: Side, b: Side, tolerance: float, prefix: str | None = None) -> Pairing:
    """Return two robots side by side; ``prefix`` is what the names of B begin with, None: find out."""
    one, other, prefixed = a.robot, b.robot, ""
    if prefix is None:
        prefix = prefix_of(one, other)
        prefixed = "B" if prefix else ""
        if not prefix:
            prefix = prefix_of(other, one)
            prefixed = "A" if prefix else ""
    elif prefix:
        prefixed = "B"
    if prefixed == "B":
        other = without_prefix(other, prefix)
    elif prefixed == "A":
        one = without_prefix(one, prefix)
    links = new_names(one, other, Known(a.printing, b.printing, tolerance))
    other = renamed(other, links, {})
    first = Bodies(one, a.printing, _split(one, other))
    second = Bodies(other, b.printing, _split(other, one))
    bodies = _bodies(first, second)
    joints = _joints(first, second, bodies)
    if joints:
        # Only names change: bodies are named after links.
        other = renamed(other, {}, joints)
        second = Bodies(other, b.printing, _split(other, one))
    return Pairing(first, second, bodies, links, joints, prefix, prefixed, tolerance)


def _split(one: Robot, other: Robot) -> frozenset[str]:
    """Return the fixed joints of a robot that move in the other one."""
    found = []
    for joint in one.joints:
        twin = other.joint_to.get(joint.child)
        if joint.is_fixed and twin is not None and not twin.is_fixed:
            elsewhere = twin.name in one.joint and not one.joint[twin.name].is_fixed
            if twin.parent == joint.parent or (twin.name == joint.name and not elsewhere):
                found.append(joint.name)
    return frozenset(found)


def _bodies(a: Bodies, b: Bodies) -> dict[str, str]:
    """Return which body of B each body of A is: the one that shares most links, if its joint is not another one's."""
    rated: list[tuple[int, int, int, str, str]] = []
    for index, top in enumerate(a.members):
        counts: dict[str, int] = {}
        for name in a.members[top]:
            if name in b.top:
                counts[b.top[name]] = counts.get(b.top[name], 0) + 1
        for goal, count in counts.items():
            mine, theirs = a.entering(top), b.entering(goal)
            same = int(mine is not None and theirs is not None and mine.name == theirs.name)
            rated.append((-same, -count, index, top, goal))
    found: dict[str, str] = {}
    for _, _, _, top, goal in sorted(rated):
        if top not in found and goal not in found.values():
            found[top] = goal
    return {top: found[top] for top in a.members if top in found}


def _joints(a: Bodies, b: Bodies, bodies: Mapping[str, str]) -> dict[str, str]:
    """Return the joints of B that A calls otherwise: those that move the same bodies, and those that fix a link."""
    found: dict[str, str] = {}
    for top, goal in bodies.items():
        mine, theirs = a.entering(top), b.entering(goal)
        if mine is not None and theirs is not None and mine.name != theirs.name:
            found[theirs.name] = mine.name
    moved = set(found)
    for joint in b.robot.joints:
        mine = a.robot.joint_to.get(joint.child)
        fresh = mine is not None and mine.name not in b.robot.joint and joint.name not in a.robot.joint
        if fresh and mine is not None and mine.is_fixed and joint.is_fixed and joint.name not in moved:
            found[joint.name] = mine.name
    # A name that a joint of B gets must be free, or become free.
    taken = {name for name in b.robot.joint if name not in found}
    for name in sorted(taken & set(found.values())):
        found[name] = f"{name} (of B)"
    return found
