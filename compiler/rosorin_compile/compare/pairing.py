"""Pair two robots: links and joints under common names, and their bodies."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import NamedTuple

from rosorin_compile.model import Joint, Robot

from .bodies import Bodies
from .difference import JOINT, NAME, Item, Side
from .names import (
    Names,
    new_joint_names,
    new_link_names,
    prefix_of,
    renamed_robot,
    with_joint_names,
    with_link_names,
    without_prefix,
)
from .sentences import describe_rename, existence
from .walk import Leaves, leaves

Steps = Sequence[tuple[Names, Names]]


class Pairing(NamedTuple):
    """Two robots, B under the names of A.

    ``bodies`` are the bodies of A (by their topmost link) that B has too, with those of B; ``links`` and ``joints`` are
    the names in A of what B calls otherwise, by B's name without its prefix; ``prefix`` is what all names of
    ``prefixed`` ("A", "B" or "") begin with. ``steps`` are all new names of links and joints, of A and of B.
    """

    a: Bodies
    b: Bodies
    bodies: Mapping[str, str]
    links: Names
    joints: Names
    prefix: str
    prefixed: str
    tolerance: float
    steps: tuple[Steps, Steps]

    @property
    def shared(self) -> list[str]:
        """The links that both robots have, in the order of A's tree."""
        return [link.name for link in self.a.robot.walk() if link.name in self.b.robot.link]

    def pair_of_joints(self, top: str) -> tuple[Joint | None, Joint | None]:
        """Return the joints that move a body of A and its counterpart in B."""
        return self.a.robot.joint_to.get(top), self.b.robot.joint_to.get(self.bodies[top])

    def rename_leaves(self, at: int, found: Leaves, other: Leaves) -> Leaves:
        """Return leaves of A or B under the common names; ``other`` are those of the other robot."""
        for links, joints in self.steps[at]:
            found = with_joint_names(with_link_names(found, links, other), joints, other)
        return found


def pair(a: Side, b: Side, tolerance: float, prefix: str | None = None) -> Pairing:
    """Pair two robots, link by link. ``prefix`` is what all names of B begin with; None: find it out."""
    robots, at = [a.robot, b.robot], 1
    steps: tuple[list[tuple[Names, Names]], list[tuple[Names, Names]]] = ([], [])
    if prefix is None:
        found = [prefix_of(robots[1 - side], robots[side]) for side in (0, 1)]
        at = 1 if found[1] or not found[0] else 0
        prefix = found[at]
    if prefix:
        names = without_prefix(robots[at].link, prefix), without_prefix(robots[at].joint, prefix)
        robots[at] = renamed_robot(robots[at], *names)
        steps[at].append(names)
    links = new_link_names(*(leaves(replace(robot, edges=())) for robot in robots[::-1]))
    other = renamed_robot(robots[1], links, {})
    joints = new_joint_names(leaves(other), leaves(robots[0]))
    # A name that a joint of B gets must be free, or become free.
    for name in sorted({name for name in other.joint if name not in joints} & set(joints.values())):
        joints[name] = f"{name} (of B)"
    one, other = robots[0], renamed_robot(other, {}, joints)
    steps[1].append((links, joints))
    first, second = Bodies(one, a.printing, _split(one, other)), Bodies(other, b.printing, _split(other, one))
    prefixed = "AB"[at] if prefix else ""
    return Pairing(first, second, _bodies(first, second), links, joints, prefix, prefixed, tolerance, steps)


def _split(one: Robot, other: Robot) -> frozenset[str]:
    found = []
    for joint in one.joints:
        twin = other.joint_to.get(joint.child)
        if joint.is_fixed and twin is not None and not twin.is_fixed:
            elsewhere = twin.name in one.joint and not one.joint[twin.name].is_fixed
            if twin.parent == joint.parent or (twin.name == joint.name and not elsewhere):
                found.append(joint.name)
    return frozenset(found)


def _bodies(a: Bodies, b: Bodies) -> dict[str, str]:
    """Return the body of B for each body of A: the one of its joint, or else the one that shares most links."""
    rated: list[tuple[bool, int, int, str, str]] = []
    for index, top in enumerate(a.members):
        goals = [b.top[name] for name in a.members[top] if name in b.top]
        for goal in dict.fromkeys(goals):
            mine, theirs = a.robot.joint_to.get(top), b.robot.joint_to.get(goal)
            other_joint = mine is None or theirs is None or mine.name != theirs.name
            rated.append((other_joint, -goals.count(goal), index, top, goal))
    found: dict[str, str] = {}
    for _, _, _, top, goal in sorted(rated):
        if top not in found and goal not in found.values():
            found[top] = goal
    return {top: found[top] for top in a.members if top in found}


def compare_names(pairing: Pairing, not_carried: frozenset[str], fixed_names: bool) -> Iterator[Item]:
    """Yield new, removed and renamed links and joints; what is attached to a new or removed link goes with it."""
    a, b = pairing.a.robot, pairing.b.robot
    yield from _only(a, b, not_carried, "removed")
    yield from _only(b, a, not_carried, "new")
    for top in pairing.bodies:  # one has no joint now that had one
        mine, theirs = pairing.pair_of_joints(top)
        joint, word = (mine, "removed") if mine is not None else (theirs, "new")
        if joint is not None and (mine is None or theirs is None):
            text = f"{word}: joint {joint.name} ({joint.type}, {joint.parent} to {joint.child})"
            yield Item(JOINT, joint.name, "existence", text, *_values(word, joint.name))
    # The keys are the names in B without its prefix.
    for new, old in sorted(pairing.links.items(), key=lambda pair: pairing.a.order[pair[1]]):
        yield Item(NAME, old, "name", describe_rename("link", old, new), old, new)
    for new, old in pairing.joints.items():
        joint = a.joint.get(old)
        if joint is not None and (fixed_names or not joint.is_fixed):
            yield Item(NAME, old, "name", describe_rename("joint", old, new), old, new)


def _only(robot: Robot, other: Robot, not_carried: frozenset[str], word: str) -> Iterator[Item]:
    """Yield the links of a robot that the other one has not, each tree of them once."""
    heads: dict[str, str] = {}
    below: dict[str, list[str]] = {}
    for link in robot.walk():
        name, joint = link.name, robot.joint_to.get(link.name)
        if name not in other.link and name not in not_carried:
            heads[name] = heads.get(joint.parent, name) if joint is not None else name
            below.setdefault(heads[name], []).append(name)
    for head, names in below.items():
        joint, link = robot.joint_to.get(head), robot.link[head]
        what = "link" if link.inertial or link.collision or link.visual else "frame"
        how = [f"{joint.type} on {joint.parent}", joint.name] if joint is not None else ["the root"]
        yield Item(NAME, head, "existence", existence(word, what, head, how, names[1:]), *_values(word, head))


def _values(word: str, name: str) -> tuple[str | None, str | None]:
    return (name, None) if word == "removed" else (None, name)
