"""Pairing: two robots under common names, their bodies side by side.

Which link of B is which link of A is seen through a prefix and through new names for the same thing; what only one of
them has is told at the end.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from typing import NamedTuple

from rosorin_compile.model import Joint, Robot

from .bodies import Bodies, gap
from .difference import JOINT, NAME, Item, Side
from .precision import Printing
from .renaming import renamed
from .sentences import existence
from .sentences import renamed as renamed_text

Rename = Callable[[str], str]


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
    """Pair two robots, link by link. ``prefix`` is what all names of B begin with; None: find it out."""
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
    links = new_names(one, other, Precision(a.printing, b.printing, tolerance))
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


# A prefix is one if so many of the names that could bear it do.
_MOST = 0.6
# Where a joint is moved to, to see whether two joints turn or slide the same way (rad or m).
_PROBE = 0.5


class Precision(NamedTuple):
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


def without_prefix(robot: Robot, prefix: str) -> Robot:
    """Return a robot whose names have lost a prefix, unless the shorter name is taken."""

    def shorter(names: Iterable[str]) -> dict[str, str]:
        every = set(names)
        cut = {name: name.removeprefix(prefix) for name in every if name.startswith(prefix) and name != prefix}
        return {name: short for name, short in cut.items() if short not in every}

    return renamed(robot, shorter(robot.link), shorter(robot.joint))


def new_names(a: Robot, b: Robot, known: Precision) -> dict[str, str]:
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


def compare_names(pairing: Pairing, not_carried: frozenset[str], fixed_names: bool) -> Iterator[Item]:
    """Yield new, removed and renamed links and joints; what hangs on a new or removed link goes with it."""
    a, b = pairing.a.robot, pairing.b.robot
    yield from _only(a, b, not_carried, "removed")
    yield from _only(b, a, not_carried, "new")
    yield from _joint_names(pairing)
    # The keys are the names in B without its prefix.
    for new, old in sorted(pairing.links.items(), key=lambda pair: pairing.a.order[pair[1]]):
        yield Item(NAME, old, "name", renamed_text("link", old, new).text, old, new)
    for new, old in pairing.joints.items():
        joint = a.joint.get(old)
        if joint is not None and (fixed_names or not joint.is_fixed):
            yield Item(NAME, old, "name", renamed_text("joint", old, new).text, old, new)


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
        hung = [f"{joint.type} on {joint.parent}", joint.name] if joint is not None else ["the root"]
        values = (head, None) if word == "removed" else (None, head)
        yield Item(NAME, head, "existence", str(existence(word, what, head, hung, names[1:])), *values)


def _joint_names(pairing: Pairing) -> Iterator[Item]:
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
