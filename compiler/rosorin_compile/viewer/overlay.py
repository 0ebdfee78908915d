"""Overlays: one robot drawn under another one, and which links moved, for a page of changes.

Links that moved themselves are distinguished from those that were only carried. A shape that is where it was is not
drawn twice.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import replace
from typing import NamedTuple

from rosorin_compile.compare.bodies import Bodies, same_motion
from rosorin_compile.compare.diff import not_carried, pair_sides
from rosorin_compile.compare.difference import Difference
from rosorin_compile.compare.names import renamed_robot
from rosorin_compile.compare.pairs import Pair
from rosorin_compile.compare.precision import Precision, exact
from rosorin_compile.compare.shapes import pieces_of
from rosorin_compile.compare.solids import Solid, match
from rosorin_compile.model import Link, Mesh, Pose, Robot, Shape
from rosorin_compile.model.geometry import pose_of

from .before import robot_before

# What became of a link. One that was carried is attached to one that moved.
MOVED, CARRIED, SHAPED, NEW, REMOVED = "moved", "carried", "shaped", "new", "removed"
PURPOSES = ("visual", "collision")
_LEAST = 1e-9  # m and rad


class Moves(NamedTuple):
    """What became of links, by name, without those that stayed; and how the old robot is drawn.

    ``shapes`` are those of old links that are not where they were, by link and purpose. ``at`` is the old root in the
    new one.
    """

    how: Mapping[str, str]
    shapes: Mapping[tuple[str, str], tuple[Shape, ...]]
    at: Pose


class Overlay(NamedTuple):
    """The robot before, under the names of the one of now, and what became of its links.

    ``frames`` are the frames at which something is to be seen, by the name that a comparison has for it.
    """

    old: Robot
    moves: Moves
    frames: Mapping[str, str] = {}

    def with_meshes(self, changed: Collection[str]) -> Overlay:
        """Return it with the links, too, whose mesh files are others: ``changed``, as the description names them."""
        how, shapes = dict(self.moves.how), dict(self.moves.shapes)
        for link in self.old.links:
            for purpose in PURPOSES:
                every = getattr(link, purpose)
                others = tuple(s for s in every if isinstance(s.geometry, Mesh) and s.geometry.file in changed)
                if others and how.setdefault(link.name, SHAPED) == SHAPED:
                    shapes[link.name, purpose] = (*dict.fromkeys((*shapes.get((link.name, purpose), ()), *others)),)
        return self._replace(moves=self.moves._replace(how=how, shapes=shapes))

    def drawn(self) -> Robot:
        """Return the robot before with the shapes alone that are drawn of it."""
        shapes = self.moves.shapes
        links = (
            Link(
                one.name, visual=shapes.get((one.name, "visual"), ()), collision=shapes.get((one.name, "collision"), ())
            )
            for one in self.old.links
        )
        return replace(self.old, links=tuple(links))


def before(robot: Robot, pairs: Sequence[Pair]) -> Overlay:
    """Return what a robot was under what it is; ``pairs`` are the artifacts that differ, before and after."""
    old = robot_before(robot, pairs)
    return Overlay(old, moves(old, robot))


def of_two(difference: Difference, prefix: str | None) -> Overlay:
    """Return the first of two robots under the second one; ``prefix`` is that of the second one."""
    a, b = difference.sides
    pairing = pair_sides(a, b, difference.tolerance, prefix)
    first, second = pairing.a.robot, pairing.b.robot
    # The common names keep the order of links and joints: so the second robot's own names are known.
    links, joints = (
        {common.name: own.name for common, own in zip(getattr(second, kind), getattr(b.robot, kind), strict=True)}
        for kind in ("links", "joints")
    )
    old_links, old_joints = _apart([*first.link], links), _apart([*first.joint], joints)
    frames: dict[str, str] = {}
    for robot, names in ((first, old_links), (second, links)):
        frames |= {joint.name: names[joint.child] for joint in robot.joints if joint.child in robot.link}
        frames |= {name: names[name] for name in robot.link}
    old = renamed_robot(first, old_links, old_joints)
    missing, _ = not_carried(pairing, a, b)
    unknown = {links.get(name, old_links.get(name, name)) for name in missing}
    return Overlay(old, moves(old, b.robot, difference.tolerance, (a.printing, b.printing), unknown), frames)


def _apart(names: Sequence[str], shared: Mapping[str, str]) -> dict[str, str]:
    """Return the second robot's names for those of the first one; a name that it uses otherwise gets another one."""
    taken = set(shared.values())
    return {name: shared.get(name, f"{name} (before)" if name in taken else name) for name in names}


def moves(
    old: Robot,
    new: Robot,
    tolerance: float = _LEAST,
    precisions: tuple[Precision, Precision] = (exact, exact),
    unknown: Collection[str] = (),
) -> Moves:
    """Return what became of each link of two robots that call the same links by the same names.

    ``tolerance`` (m, rad) is no difference, besides what ``precisions`` leave open; ``unknown`` are links that the
    format of one of the two cannot contain.
    """
    work = _Moves(Bodies(old, precisions[0]), Bodies(new, precisions[1]), max(tolerance, _LEAST))
    how = work.links() | {link.name: REMOVED for link in old.walk() if link.name not in new.link}
    shapes = {
        (link.name, purpose): found
        for link in old.links
        for purpose in PURPOSES
        if link.name not in unknown and (found := tuple(work.drawn(link.name, purpose, how.get(link.name, ""))))
    }
    return Moves({name: what for name, what in how.items() if name not in unknown}, shapes, work.at())


class _Moves:
    """Compares the links of a robot with those of the one before, from the root down."""

    def __init__(self, old: Bodies, new: Bodies, tolerance: float) -> None:
        self.old, self.new, self.tolerance = old, new, tolerance
        self.how: dict[str, str] = {}
        # What is taken to be where it was: a root, or the first link that both have; else none.
        known = [name for name in (new.robot.root, old.robot.root) if name in old.top and name in new.top]
        self.anchor = next(iter([*known, *(link.name for link in new.robot.walk() if link.name in old.top)]), "")
        robots = old.robot, new.robot
        # One of two formats may have no word for a purpose at all.
        self.purposes = [p for p in PURPOSES if all(any(getattr(x, p) for x in robot.links) for robot in robots)]

    def at(self) -> Pose:
        """Return the root of the old robot in that of the new one, all joints at zero."""
        if not self.anchor:
            return Pose()
        old, new = (side.relative(side.robot.root, self.anchor).transform for side in (self.old, self.new))
        return pose_of(new.then(old.inverse()))

    def links(self) -> dict[str, str]:
        """Return what became of each link."""
        for link in self.new.robot.walk():
            name = link.name
            if name not in self.old.top:
                self.how[name] = NEW
                continue
            above = self._above(name)
            if name != self.anchor and not self._same(above, name):
                self.how[name] = MOVED
            elif name != self.anchor and self.how.get(above) in (MOVED, CARRIED):
                self.how[name] = CARRIED
            elif any(self._gone(name, purpose) or self._fresh(name, purpose) for purpose in self.purposes):
                self.how[name] = SHAPED
        return self.how

    def _above(self, name: str) -> str:
        """Return the nearest link above that both have; the anchor, where there is none."""
        chain = [joint.parent for joint in reversed(self.new.robot.chain(name))]
        return next((link for link in chain if link in self.old.top), self.anchor)

    def _same(self, above: str, name: str) -> bool:
        ways = [side.joints_between(side.top[above], side.top[name]) or [] for side in (self.old, self.new)]
        followers = [[joint.mimic for joint in way] for way in ways]
        return followers[0] == followers[1] and same_motion(self.old, self.new, above, name, self.tolerance)

    def _gone(self, name: str, purpose: str) -> list[Shape]:
        """Return the old shapes of a link that none of the links fixed to it has now."""
        pieces = _pieces(self.old, name, purpose)
        rest = match([solid for _, solid in pieces], _around(self.new, name, purpose), self.tolerance)
        return [pieces[index][0] for index in rest.old]

    def _fresh(self, name: str, purpose: str) -> bool:
        new = [solid for _, solid in _pieces(self.new, name, purpose)]
        return bool(match(_around(self.old, name, purpose), new, self.tolerance).new)

    def drawn(self, name: str, purpose: str, how: str) -> list[Shape]:
        """Return the shapes of an old link that are drawn: all, if it is elsewhere, or only those that are gone."""
        if how in (MOVED, CARRIED):
            return [*getattr(self.old.robot.link[name], purpose)]
        if how == SHAPED:
            return self._gone(name, purpose) if purpose in self.purposes else []
        if how != REMOVED:
            return []
        pieces = _pieces(self.old, name, purpose)
        mates = [mate for mate in self.old.members[self.old.top[name]] if mate in self.new.top]
        mate = next((mate for mate in mates if self.how.get(mate) not in (MOVED, CARRIED)), None)
        if mate is None:
            return [shape for shape, _ in pieces]
        solids = [solid.seen_from(self.old.relative(mate, name)) for _, solid in pieces]
        return [pieces[index][0] for index in match(solids, _around(self.new, mate, purpose), self.tolerance).old]


def _pieces(side: Bodies, name: str, purpose: str) -> list[tuple[Shape, Solid]]:
    """Return the solids of a link in its own frame, each as a shape, too."""
    shapes = [solid for shape in getattr(side.robot.link[name], purpose) for solid in shape.solids()]
    pieces = pieces_of(name, shapes, side.precision, capsules=False)
    return [(shape, piece.solid) for shape, piece in zip(shapes, pieces, strict=True)]


def _around(side: Bodies, name: str, purpose: str) -> list[Solid]:
    """Return the solids of all links that are fixed to one, in its frame."""
    return [
        solid.seen_from(side.relative(name, member))
        for member in side.members[side.top[name]]
        for _, solid in _pieces(side, member, purpose)
    ]
