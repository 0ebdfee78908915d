"""Pair two robots: links and joints under common names, and their bodies.

Which link of B is which link of A follows from a prefix and from new names for the same thing.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from difflib import SequenceMatcher
from typing import NamedTuple

from rosorin_compile.model import Joint, Robot

from .bodies import Bodies, same_motion
from .difference import JOINT, NAME, Item, Side
from .renaming import renamed
from .sentences import existence
from .sentences import renamed as renamed_text


class Pairing(NamedTuple):
    """Two robots, B under the names of A.

    ``bodies`` are the bodies of A (by their topmost link) that B has too, with those of B; ``links`` and ``joints`` are
    the names in A of what B calls otherwise, by B's name without its prefix; ``prefix`` is what all names of
    ``prefixed`` ("A", "B" or "") begin with.
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
        """Return the joints that move a body of A and its counterpart in B."""
        return self.a.robot.joint_to.get(top), self.b.robot.joint_to.get(self.bodies[top])


def pair(a: Side, b: Side, tolerance: float, prefix: str | None = None) -> Pairing:
    """Pair two robots, link by link. ``prefix`` is what all names of B begin with; None: find it out."""
    one, other, prefixed = a.robot, b.robot, "B" if prefix else ""
    if prefix is None:
        prefix = prefix_of(one, other)
        prefixed = "B" if prefix else ""
        if not prefix:
            prefix = prefix_of(other, one)
            prefixed = "A" if prefix else ""
    if prefixed == "B":
        other = without_prefix(other, prefix)
    elif prefixed == "A":
        one = without_prefix(one, prefix)
    links = _new_names(Bodies(one, a.printing), Bodies(other, b.printing), tolerance)
    other = renamed(other, links, {})
    first = Bodies(one, a.printing, _split(one, other))
    second = Bodies(other, b.printing, _split(other, one))
    bodies = _bodies(first, second)
    joints = _joints(first, second, bodies)
    if joints:
        other = renamed(other, {}, joints)  # bodies are named after links, and stay
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


def _joints(a: Bodies, b: Bodies, bodies: Mapping[str, str]) -> dict[str, str]:
    """Return the joints of B that A calls otherwise: those that move the same bodies, and those that fix a link."""
    found: dict[str, str] = {}
    for top, goal in bodies.items():
        mine, theirs = a.robot.joint_to.get(top), b.robot.joint_to.get(goal)
        if mine is not None and theirs is not None and mine.name != theirs.name:
            found[theirs.name] = mine.name
    for joint in b.robot.joints:
        mine = a.robot.joint_to.get(joint.child)
        if mine is not None and mine.is_fixed and joint.is_fixed and joint.name not in {*found, *a.robot.joint}:
            found |= {joint.name: mine.name} if mine.name not in b.robot.joint else {}
    # A name that a joint of B gets must be free, or become free.
    taken = {name for name in b.robot.joint if name not in found}
    for name in sorted(taken & set(found.values())):
        found[name] = f"{name} (of B)"
    return found


# A prefix is one if so many of the names that could have it do.
_MOST = 0.6


def prefix_of(a: Robot, b: Robot) -> str:
    """Return what the names of most links of ``b`` begin with that those of ``a`` do not have; empty for nothing."""
    mine, theirs = [link.name for link in a.links], [link.name for link in b.links]
    ends = [other[: -len(name)] for name in mine for other in theirs if other.endswith(name) and other != name]
    best = max(sorted(set(ends)), key=ends.count, default="")
    count = ends.count(best)
    is_most = count > max(1, len(set(mine) & set(theirs))) and count >= _MOST * min(len(mine), len(theirs))
    return best if is_most else ""


def without_prefix(robot: Robot, prefix: str) -> Robot:
    """Return a robot whose names have lost a prefix, unless the shorter name is taken."""

    def shorter(names: Iterable[str]) -> dict[str, str]:
        every = set(names)
        cut = {name: name.removeprefix(prefix) for name in every if name.startswith(prefix) and name != prefix}
        return {name: short for name, short in cut.items() if short not in every}

    return renamed(robot, shorter(robot.link), shorter(robot.joint))


def _new_names(a: Bodies, b: Bodies, tolerance: float) -> dict[str, str]:
    """Return the links of B that are links of A under another name: B's name -> A's name.

    Such a link is in the same place and moves in the same way, or is placed by the joint of the same name.
    """
    here = {name: name for name in a.robot.link if name in b.robot.link}
    found: dict[str, str] = {}
    waiting = [link.name for link in a.robot.walk() if link.name not in here]
    again = bool(waiting) and len(here) < len(b.robot.link)
    while again:
        again = False
        for name in waiting:
            taken = {*here.values()}
            spare = [link.name for link in b.robot.walk() if link.name not in taken] if name not in here else []
            rated = [(_likeness(a, b, name, other, here, tolerance), -at) for at, other in enumerate(spare)]
            best, at = max(rated, default=(0.0, 0))
            if best > 0:
                found[spare[-at]], here[name] = name, spare[-at]
                again = True  # what is attached to it may be recognised now
    return found


def _likeness(a: Bodies, b: Bodies, one: str, other: str, here: Mapping[str, str], tolerance: float) -> float:
    """Return how similar a link of B is to one of A; 0 if it cannot be the same."""
    above, below = a.robot.joint_to.get(one), b.robot.joint_to.get(other)
    if above is None and below is None:
        same_root = any(here.get(name) in b.members[b.robot.root] for name in a.members[a.robot.root])
        if same_root and not _same_place(a, b, one, other, here, tolerance):
            return 0.0
        same_joint = False
    else:
        if above is not None and below is not None and above.is_fixed != below.is_fixed:
            return 0.0
        same_joint = (
            above is not None
            and below is not None
            and above.name == below.name
            and here.get(above.parent) == below.parent
        )
        if not same_joint and not _same_place(a, b, one, other, here, tolerance):
            return 0.0
    first, second = a.robot.link[one], b.robot.link[other]
    mine = {here[joint.child] for joint in a.robot.joints_from.get(one, ()) if joint.child in here}
    theirs = {joint.child for joint in b.robot.joints_from.get(other, ())}
    points = 1.0 + 4.0 * same_joint + 3.0 * bool(mine & theirs) + (first.inertial == second.inertial)
    points += len(first.collision) == len(second.collision) and len(first.visual) == len(second.visual)
    return points + SequenceMatcher(None, one, other, autojunk=False).ratio()


def _same_place(a: Bodies, b: Bodies, one: str, other: str, here: Mapping[str, str], tolerance: float) -> bool:
    """Return True if two links have the same place in a link that both have, and move alike in it."""
    for start, goal in ((a.top[one], b.top[other]), (a.above(a.top[one]), b.above(b.top[other]))):
        names = a.members[start] if start is not None else []
        anchor = next((name for name in names if name in here and b.top[here[name]] == goal), None)
        if anchor is not None:
            return same_motion((a, b), (anchor, here[anchor]), (one, other), tolerance)
    return False


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
        yield Item(NAME, old, "name", renamed_text("link", old, new), old, new)
    for new, old in pairing.joints.items():
        joint = a.joint.get(old)
        if joint is not None and (fixed_names or not joint.is_fixed):
            yield Item(NAME, old, "name", renamed_text("joint", old, new), old, new)


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
