"""Moves: which links of a robot sit or look otherwise than in another one, for a picture of the two.

What moved itself is told apart from what only went with it. A shape that is where it was needs no second picture.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping
from typing import NamedTuple

from rosorin_compile.model import Pose, Robot, Shape
from rosorin_compile.model.geometry import pose_of

from .bodies import Bodies, gap, states_of
from .precision import EXACT, Placed, Printing
from .shapes import Piece, pieces_of, seen
from .solids import Solid, match

# What became of a link. One that was carried hangs on one that moved.
MOVED, CARRIED, SHAPED, NEW, REMOVED = "moved", "carried", "shaped", "new", "removed"
PURPOSES = ("visual", "collision")
_LEAST = 1e-9  # m and rad


class Moves(NamedTuple):
    """What became of links, by name, those that stayed left out; and how the old robot is drawn.

    ``shapes`` are those of old links that are not where they were, by link and purpose. ``at`` is where the old root
    sits in the new one.
    """

    how: Mapping[str, str]
    shapes: Mapping[tuple[str, str], tuple[Shape, ...]]
    at: Pose


def moves(
    old: Robot,
    new: Robot,
    tolerance: float = _LEAST,
    printings: tuple[Printing, Printing] = (EXACT, EXACT),
    unsaid: Collection[str] = (),
) -> Moves:
    """Return what became of each link of two robots that call the same links by the same names.

    ``tolerance`` (m, rad) is no difference, besides what ``printings`` leave open; ``unsaid`` are links that one of the
    two has no word for.
    """
    work = _Moves(Bodies(old, printings[0]), Bodies(new, printings[1]), max(tolerance, _LEAST))
    work.walk()
    shapes = {
        (link.name, purpose): found
        for link in old.links
        for purpose in PURPOSES
        if link.name not in unsaid and (found := tuple(work.drawn(link.name, purpose)))
    }
    removed = {link.name: REMOVED for link in old.walk() if link.name not in new.link}
    how = {name: what for name, what in {**work.how, **removed}.items() if name not in unsaid}
    return Moves(how, shapes, work.at())


class _Moves:
    """Goes through the links of the new robot from the root down."""

    def __init__(self, old: Bodies, new: Bodies, tolerance: float) -> None:
        self.old, self.new, self.tolerance = old, new, tolerance
        self.how: dict[str, str] = {}
        self.anchor = self._anchor()
        self._rest: dict[tuple[str, str], tuple[list[Shape], bool]] = {}
        # One of two formats may have no word for a purpose at all.
        self.told = {
            purpose
            for purpose in PURPOSES
            if all(any(getattr(link, purpose) for link in side.robot.links) for side in (old, new))
        }

    def _anchor(self) -> str:
        """Return the link that is taken to be where it was: a root, or the first link that both have; else none."""
        old, new = self.old.robot, self.new.robot
        roots = [new.root] * (new.root in old.link) + [old.root] * (old.root in new.link)
        return next(iter(roots), "") or next((link.name for link in new.walk() if link.name in old.link), "")

    def at(self) -> Pose:
        """Return where the root of the old robot sits in that of the new one, all joints at zero."""
        if not self.anchor:
            return Pose()
        old, new = (side.relative(side.robot.root, self.anchor, {}) for side in (self.old, self.new))
        return pose_of(new.transform.then(old.transform.inverse()))

    def walk(self) -> None:
        """Say what became of each link."""
        for link in self.new.robot.walk():
            name = link.name
            if name not in self.old.robot.link:
                self.how[name] = NEW
                continue
            above = self._above(name)
            if name == self.anchor:
                continue
            if not self._same(above, name):
                self.how[name] = MOVED
            elif self.how.get(above) in (MOVED, CARRIED):
                self.how[name] = CARRIED
            elif any(self._reshaped(name, purpose) for purpose in self.told):
                self.how[name] = SHAPED
        if self.anchor and any(self._reshaped(self.anchor, purpose) for purpose in self.told):
            self.how[self.anchor] = SHAPED

    def _above(self, name: str) -> str:
        """Return the nearest link above that both have; the anchor, where there is none."""
        robot = self.new.robot
        while name in robot.joint_to:
            name = robot.joint_to[name].parent
            if name in self.old.robot.link:
                return name
        return self.anchor

    def _same(self, above: str, name: str) -> bool:
        """Say whether a link sits in another one as it did, at all positions of the joints between."""
        was, way = (side.joints_between(side.top[above], side.top[name]) for side in (self.old, self.new))
        if was is None or way is None:
            return False
        kinds = [sorted(joint.type for joint in joints if not joint.moves) for joints in (was, way)]
        old, new = ([joint for joint in joints if joint.moves] for joints in (was, way))
        if len(old) != len(new) or kinds[0] != kinds[1] or [j.mimic for j in old] != [j.mimic for j in new]:
            return False
        names = dict(zip((joint.name for joint in new), (joint.name for joint in old), strict=True))
        for state in states_of(list(zip(new, old, strict=True))):
            before = self.old.relative(above, name, {names[joint]: value for joint, value in state.items()})
            if not gap(before, self.new.relative(above, name, state), self.tolerance).closed:
                return False
        return True

    def _reshaped(self, name: str, purpose: str) -> bool:
        """Say whether a link that is in both robots has other shapes now."""
        old, fresh = self._difference(name, purpose)
        return bool(old) or fresh

    def _difference(self, name: str, purpose: str) -> tuple[list[Shape], bool]:
        """Return the shapes that are no more where they were, and whether there are others.

        All links that are fixed to each other count: some formats give the shapes of one to another.
        """
        known = self._rest.get((name, purpose))
        if known is None:
            old, new = (list(_pieces(side, name, purpose)) for side in (self.old, self.new))
            before = list(_around(self.old, name, purpose))
            gone = match([piece.solid for _, piece in old], list(_around(self.new, name, purpose)), self.tolerance).old
            fresh = match(before, [piece.solid for _, piece in new], self.tolerance).new
            known = self._rest[name, purpose] = ([old[index][0] for index in gone], bool(fresh))
        return known

    def _left(self, name: str, purpose: str) -> list[Shape]:
        """Return the shapes of a link that is no more, but for those that another link of the same body has now."""
        pieces = list(_pieces(self.old, name, purpose))
        mates = [other for other in self.old.members[self.old.top[name]] if other in self.new.robot.link]
        mate = next((other for other in mates if self.how.get(other) not in (MOVED, CARRIED)), None)
        if mate is None:
            return [shape for shape, _ in pieces]
        place = self.old.relative(mate, name, {})
        solids = [seen(piece, place).solid for _, piece in pieces]
        return [pieces[index][0] for index in match(solids, list(_around(self.new, mate, purpose)), self.tolerance).old]

    def drawn(self, name: str, purpose: str) -> list[Shape]:
        """Return the shapes of an old link that are drawn: all, if it is elsewhere, or only those that are no more."""
        how = self.how.get(name, "" if name in self.new.robot.link else REMOVED)
        if how == SHAPED:
            return self._difference(name, purpose)[0] if purpose in self.told else []
        if how == REMOVED:
            return self._left(name, purpose)
        return list(getattr(self.old.robot.link[name], purpose)) if how in (MOVED, CARRIED) else []


def _pieces(side: Bodies, name: str, purpose: str) -> Iterator[tuple[Shape, Piece]]:
    """Yield the solids of a link in its own frame, each as a shape, too."""
    shapes = getattr(side.robot.link[name], purpose)
    solids = [solid for shape in shapes for solid in shape.solids()]
    yield from zip(solids, pieces_of(name, shapes, side.printing, capsules=False), strict=True)


def _around(side: Bodies, name: str, purpose: str) -> Iterator[Solid]:
    """Yield the solids of all links that are fixed to one, in its frame."""
    for member in side.members[side.top[name]]:
        place: Placed = side.relative(name, member, {})
        for _, piece in _pieces(side, member, purpose):
            yield seen(piece, place).solid
