"""Existence: links and joints that only one of two robots has, and those that it calls otherwise."""

from __future__ import annotations

from collections.abc import Iterator

from ..model import Robot
from .pairing import Pairing
from .values import JOINT, NAME, Item
from .wording import several


def compare_names(pairing: Pairing, not_carried: frozenset[str], fixed_names: bool) -> Iterator[Item]:
    """Yield new, removed and renamed links and joints; what hangs on a new or removed link goes with it."""
    a, b = pairing.a.robot, pairing.b.robot
    yield from _only(a, b, not_carried, "removed")
    yield from _only(b, a, not_carried, "new")
    yield from _joints(pairing)
    # The keys are the names in B without its prefix.
    for new, old in sorted(pairing.links.items(), key=lambda pair: pairing.a.order[pair[1]]):
        yield Item(NAME, old, "name", f"link {old} renamed to {new}", old, new)
    for new, old in pairing.joints.items():
        joint = a.joint.get(old)
        if joint is not None and (fixed_names or not joint.is_fixed):
            yield Item(NAME, old, "name", f"joint {old} renamed to {new}", old, new)


def _only(robot: Robot, other: Robot, not_carried: frozenset[str], word: str) -> Iterator[Item]:
    """Yield the links of a robot that the other one has not, each tree of them once."""
    missing = [n.name for n in robot.walk() if n.name not in other.link and n.name not in not_carried]
    heads: dict[str, str] = {}
    below: dict[str, list[str]] = {}
    for name in missing:
        joint = robot.joint_to.get(name)
        head = heads[joint.parent] if joint is not None and joint.parent in heads else name
        heads[name] = head
        below.setdefault(head, []).append(name)
    for head, names in below.items():
        joint, link = robot.joint_to.get(head), robot.link[head]
        what = "link" if link.inertial or link.collision or link.visual else "frame"
        how = f" ({joint.type} on {joint.parent}, {joint.name})" if joint is not None else " (the root)"
        with_it = f", and with it {several(names[1:])}" if len(names) > 1 else ""
        values = (head, None) if word == "removed" else (None, head)
        yield Item(NAME, head, "existence", f"{word}: {what} {head}{how}{with_it}", *values)


def _joints(pairing: Pairing) -> Iterator[Item]:
    """Yield the joints above a body that has none in the other robot: one stands free that hung on something."""
    for top in pairing.bodies:
        mine, theirs = pairing.pair_of_joints(top)
        if (mine is None) == (theirs is None):
            continue
        joint, word = (mine, "removed") if mine is not None else (theirs, "new")
        if joint is not None:
            text = f"{word}: joint {joint.name} ({joint.type}, {joint.parent} to {joint.child})"
            values = (joint.name, None) if word == "removed" else (None, joint.name)
            yield Item(JOINT, joint.name, "existence", text, *values)
