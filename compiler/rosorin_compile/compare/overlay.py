"""Overlays: one robot drawn under another one, as a page of changes shows both.

The one before may have other names, and links that the other one's format has no word for.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import replace
from typing import NamedTuple

from rosorin_compile.model import Link, Mesh, Robot

from .committed import undo_all
from .difference import Difference, Side
from .moves import PURPOSES, SHAPED, Moves, moves
from .pairing import Pairing
from .pairs import Pair
from .renaming import renamed


class Overlay(NamedTuple):
    """The robot before, under the names of the one of now, and what became of its links (see ``Moves``).

    ``frames`` are the frames at which something is to be seen, by the name that a comparison has for it.
    """

    old: Robot
    moves: Moves
    frames: Mapping[str, str] = {}

    def with_meshes(self, changed: Collection[str]) -> Overlay:
        """Return it with the links, too, whose mesh files are others: ``changed``, as the description names them."""
        found, how, shapes = self.moves, dict(self.moves.how), dict(self.moves.shapes)
        for link in self.old.links:
            for purpose in PURPOSES:
                every = getattr(link, purpose)
                others = tuple(s for s in every if isinstance(s.geometry, Mesh) and s.geometry.file in changed)
                if others and how.setdefault(link.name, SHAPED) == SHAPED:
                    known = shapes.get((link.name, purpose), ())
                    shapes[link.name, purpose] = (*known, *(shape for shape in others if shape not in known))
        return self._replace(moves=found._replace(how=how, shapes=shapes))

    def drawn(self) -> Robot:
        """Return the robot before with the shapes alone that are drawn of it."""
        links = [
            Link(link.name, **{purpose: self.moves.shapes.get((link.name, purpose), ()) for purpose in PURPOSES})  # type: ignore[arg-type]
            for link in self.old.links
        ]
        return replace(self.old, links=tuple(links))


def before(robot: Robot, pairs: Sequence[Pair]) -> Overlay:
    """Return what a robot was under what it is; ``pairs`` are the artifacts that differ, before and after."""
    old = undo_all(robot, pairs)
    return Overlay(old, moves(old, robot))


def of_two(difference: Difference, prefix: str | None) -> Overlay:
    """Return the first of two robots under the second one; ``prefix`` is that of the second one."""
    from .diff import side_by_side

    a, b = difference.sides
    names = _Names(side_by_side(a, b, difference.tolerance, prefix), b.robot)
    old = names.old()
    found = moves(old, b.robot, difference.tolerance, (a.printing, b.printing), names.without_word(a, b))
    return Overlay(old, found, names.frames())


class _Names:
    """What the two robots of a comparison call things, by the names that it has for both."""

    def __init__(self, pairing: Pairing, second: Robot) -> None:
        self.pairing = pairing
        self.first, self.second = pairing.a.robot, pairing.b.robot
        self.links = _renaming([link.name for link in second.links], [link.name for link in self.second.links])
        self.joints = _renaming([joint.name for joint in second.joints], [joint.name for joint in self.second.joints])
        self.old_links = _apart([link.name for link in self.first.links], self.links)
        self.old_joints = _apart([joint.name for joint in self.first.joints], self.joints)

    def old(self) -> Robot:
        """Return the first robot under the names of the second one."""
        return renamed(self.first, self.old_links, self.old_joints)

    def without_word(self, a: Side, b: Side) -> set[str]:
        """Return the links that the format of one of the two has no word for."""
        from .not_compared import not_carried

        missing, _ = not_carried(self.pairing, a, b)
        return {self.links.get(name, self.old_links.get(name, name)) for name in missing}

    def frames(self) -> dict[str, str]:
        """Return the frames at which links and joints are to be seen, by the names that the comparison has for them."""
        found: dict[str, str] = {}
        for robot, links in ((self.first, self.old_links), (self.second, self.links)):
            found |= {joint.name: links[joint.child] for joint in robot.joints if joint.child in robot.link}
            found |= {name: links[name] for name in robot.link}
        return found


def _renaming(own: Sequence[str], common: Sequence[str]) -> dict[str, str]:
    """Return the names that a robot has itself by those of a comparison, which keeps their order."""
    return dict(zip(common, own, strict=True))


def _apart(names: Sequence[str], shared: Mapping[str, str]) -> dict[str, str]:
    """Return what the second robot calls what the first one has; what it has not gets a name that is free."""
    taken = set(shared.values())
    return {name: shared.get(name, f"{name} (before)" if name in taken else name) for name in names}
