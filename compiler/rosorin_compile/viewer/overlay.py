"""Overlays: one robot drawn under another one, and which links moved, for a page of changes.

Links that moved themselves are distinguished from those that were only carried. A shape that is where it was is not
drawn twice.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import replace
from itertools import product
from typing import NamedTuple

from rosorin_compile.compare.bodies import Bodies, same_motion
from rosorin_compile.compare.diff import not_carried, pair_sides
from rosorin_compile.compare.difference import Difference
from rosorin_compile.compare.names import renamed_robot
from rosorin_compile.compare.precision import Precision, exact
from rosorin_compile.compare.shapes import pieces_of
from rosorin_compile.compare.solids import Solid, match
from rosorin_compile.model import Link, Mesh, Pose, Robot, Shape
from rosorin_compile.model.geometry import pose_of

# What became of a link. One that was carried is attached to one that moved.
MOVED, CARRIED, SHAPED, NEW, REMOVED = "moved", "carried", "shaped", "new", "removed"
PURPOSES = ("visual", "collision")
_LEAST = 1e-9  # m and rad


class Overlay(NamedTuple):
    """The robot before, under the names of the one of now, and what became of its links.

    ``how`` has the links that did not stay, by name; ``shapes`` the shapes of old links that are elsewhere or gone, by
    link and purpose; ``at`` is the old root in the new one. ``frames`` are the frames at which something is to be
    seen, by the name that a comparison has for it.
    """

    old: Robot
    how: Mapping[str, str]
    shapes: Mapping[tuple[str, str], tuple[Shape, ...]]
    at: Pose
    frames: Mapping[str, str] = {}

    def with_meshes(self, changed: Collection[str]) -> Overlay:
        """Return it with the links, too, whose mesh files are others: ``changed``, as the description names them."""
        how, shapes = dict(self.how), dict(self.shapes)
        for link, purpose in product(self.old.links, PURPOSES):
            others = [s for s in getattr(link, purpose) if isinstance(s.geometry, Mesh) and s.geometry.file in changed]
            if others and how.setdefault(link.name, SHAPED) == SHAPED:
                shapes[link.name, purpose] = (*dict.fromkeys((*shapes.get((link.name, purpose), ()), *others)),)
        return self._replace(how=how, shapes=shapes)

    def drawn(self) -> Robot:
        """Return the robot before with the shapes alone that are drawn of it."""
        links = (
            Link(link.name, **{purpose: self.shapes.get((link.name, purpose), ()) for purpose in PURPOSES})
            for link in self.old.links
        )
        return replace(self.old, links=tuple(links))


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
    unknown = {links.get(name, old_links.get(name, name)) for name in not_carried(pairing, a, b)[0]}
    found = moves(old, b.robot, difference.tolerance, (a.printing, b.printing), unknown)
    return found._replace(frames=frames)


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
) -> Overlay:
    """Return what became of each link of two robots that call the same links by the same names.

    ``tolerance`` (m, rad) is no difference, besides what ``precisions`` leave open; ``unknown`` are links that the
    format of one of the two cannot contain.
    """
    tolerance = max(tolerance, _LEAST)
    a, b = Bodies(old, precisions[0]), Bodies(new, precisions[1])
    # What is taken to be where it was: a root, or the first link that both have; else none.
    names = [new.root, old.root, *(link.name for link in new.walk())]
    anchor = next((name for name in names if name in a.top and name in b.top), "")
    # One of two formats may have no word for a purpose at all.
    purposes = [p for p in PURPOSES if all(any(getattr(x, p) for x in robot.links) for robot in (old, new))]
    how: dict[str, str] = {}
    for link in new.walk():
        name = link.name
        if name not in a.top:
            how[name] = NEW
            continue
        # The nearest link above that both have.
        above = next((j.parent for j in reversed(new.chain(name)) if j.parent in a.top), anchor)
        if name != anchor and not _same_place(a, b, above, name, tolerance):
            how[name] = MOVED
        elif name != anchor and how.get(above) in (MOVED, CARRIED):
            how[name] = CARRIED
        elif any(_gone(a, b, name, p, tolerance) or _gone(b, a, name, p, tolerance) for p in purposes):
            how[name] = SHAPED
    how |= {link.name: REMOVED for link in old.walk() if link.name not in new.link}
    shapes: dict[tuple[str, str], tuple[Shape, ...]] = {}
    for link, purpose in product(old.links, PURPOSES):
        name, what = link.name, how.get(link.name)
        found: Sequence[Shape] = ()
        if what in (MOVED, CARRIED):
            found = getattr(link, purpose)
        elif what == REMOVED or (what == SHAPED and purpose in purposes):
            mates = [mate for mate in a.members[a.top[name]] if mate in b.top and how.get(mate) not in (MOVED, CARRIED)]
            found = _gone(a, b, name, purpose, tolerance, name if name in b.top else next(iter(mates), ""))
        if found and name not in unknown:
            shapes[name, purpose] = tuple(found)
    at = Pose()
    if anchor:
        here, there = (side.relative(side.robot.root, anchor).transform for side in (a, b))
        at = pose_of(there.then(here.inverse()))
    return Overlay(old, {name: what for name, what in how.items() if name not in unknown}, shapes, at)


def _same_place(a: Bodies, b: Bodies, above: str, name: str, tolerance: float) -> bool:
    ways = [side.joints_between(side.top[above], side.top[name]) or [] for side in (a, b)]
    followers = [[joint.mimic for joint in way] for way in ways]
    return followers[0] == followers[1] and same_motion(a, b, above, name, tolerance)


def _gone(a: Bodies, b: Bodies, name: str, purpose: str, tolerance: float, mate: str | None = None) -> list[Shape]:
    """Return the shapes of a link of ``a`` that no link fixed to it, or to ``mate``, has in ``b``."""
    pieces = _pieces(a, name, purpose)
    mate = name if mate is None else mate
    if not mate:
        return [shape for shape, _ in pieces]
    solids = [solid.seen_from(a.relative(mate, name)) for _, solid in pieces]
    around = [
        solid.seen_from(b.relative(mate, member))
        for member in b.members[b.top[mate]]
        for _, solid in _pieces(b, member, purpose)
    ]
    return [pieces[index][0] for index in match(solids, around, tolerance).old]


def _pieces(side: Bodies, name: str, purpose: str) -> list[tuple[Shape, Solid]]:
    """Return the solids of a link in its own frame, each as a shape, too."""
    shapes = [solid for shape in getattr(side.robot.link[name], purpose) for solid in shape.solids()]
    pieces = pieces_of(name, shapes, side.precision, capsules=False)
    return [(shape, piece.solid) for shape, piece in zip(shapes, pieces, strict=True)]
