"""Bodies: the links of a robot that are fixed to each other, and where each link sits in its body.

A body is named after its topmost link. What moves against what is a matter of bodies; which link of a body hangs on
which other one is a matter of writing.
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import cached_property
from typing import NamedTuple

from ..model import Joint, Robot, Transform
from ..model.geometry import norm
from .printing import Printing

Positions = Mapping[str, float]
# Three coordinates off at once; three angles may all turn about one line.
_ROOT_THREE, TURNS = 3**0.5, 3.0


class Placed(NamedTuple):
    """Where something is, and how well that is known: lengths (m) and angles (rad)."""

    transform: Transform
    length: float = 0.0
    angle: float = 0.0

    def then(self, child: Placed) -> Placed:
        """Return this place followed by another one in it."""
        length = self.length + child.length + self.angle * norm(child.transform.xyz)
        return Placed(self.transform.then(child.transform), length, self.angle + child.angle)

    def inverse(self) -> Placed:
        """Return the way back."""
        length = self.length + self.angle * norm(self.transform.xyz)
        return Placed(self.transform.inverse(), length, self.angle)


HERE = Placed(Transform())


class Bodies:
    """The bodies of a robot; ``split`` are fixed joints that separate bodies all the same, because they move in B."""

    def __init__(self, robot: Robot, printing: Printing, split: frozenset[str] = frozenset()) -> None:
        self.robot = robot
        self.printing = printing
        self.top: dict[str, str] = {}
        self._known: dict[tuple[str, str], Placed] = {}
        self.members: dict[str, list[str]] = {}
        for link in robot.walk():
            joint = robot.joint_to.get(link.name)
            moves = joint is None or not joint.is_fixed or joint.name in split
            self.top[link.name] = link.name if joint is None or moves else self.top[joint.parent]
            self.members.setdefault(self.top[link.name], []).append(link.name)

    @cached_property
    def order(self) -> Mapping[str, int]:
        """The place of each link in the tree, parents first."""
        return {link.name: index for index, link in enumerate(self.robot.walk())}

    def edge(self, joint: Joint, position: float) -> Placed:
        """Return the child of a joint in its parent at a position (rad or m)."""
        xyz, rpy = joint.origin.xyz, joint.origin.rpy
        length = _ROOT_THREE * self.printing.room("xyz", *xyz)
        angle = TURNS * self.printing.room("rpy", *rpy)
        if position and joint.moves:
            tilt = _ROOT_THREE * self.printing.room("axis", *joint.axis) / (norm(joint.axis) or 1.0)
            turns = joint.type != "prismatic"
            length, angle = length + (0.0 if turns else tilt * abs(position)), angle + (2 * tilt if turns else 0.0)
        return Placed(joint.transform(position), length, angle)

    def entering(self, top: str) -> Joint | None:
        """Return the joint that moves a body; None for the root's."""
        return self.robot.joint_to.get(top)

    def above(self, top: str) -> str | None:
        """Return the body that a body moves against."""
        joint = self.entering(top)
        return self.top[joint.parent] if joint else None

    def joints_between(self, upper: str, lower: str) -> list[Joint] | None:
        """Return the joints from a body down to another one; None if that is not below it."""
        found: list[Joint] = []
        top: str | None = lower
        while top != upper:
            joint = self.entering(top) if top is not None else None
            if joint is None:
                return None
            found.append(joint)
            top = self.top[joint.parent]
        return found[::-1]

    def relative(self, source: str, target: str, positions: Positions) -> Placed:
        """Return where a link sits in another one of the same body, or of one above."""
        joints = self.joints_between(self.top[source], self.top[target]) or []
        here, found = source, HERE
        for joint in joints:
            found = found.then(self._within(here, joint.parent))
            found = found.then(self.edge(joint, positions.get(joint.name, 0.0)))
            here = joint.child
        return found.then(self._within(here, target))

    def _within(self, source: str, target: str) -> Placed:
        """Return where a link sits in another one of the same body, by way of the last link that both hang on."""
        known = self._known.get((source, target))
        if known is None:
            up, down = self._way(source), self._way(target)
            while up and down and up[-1] is down[-1]:
                up.pop()
                down.pop()
            known = HERE
            for joint in up:
                known = known.then(self.edge(joint, 0.0).inverse())
            for joint in reversed(down):
                known = known.then(self.edge(joint, 0.0))
            self._known[source, target] = known
        return known

    def _way(self, link: str) -> list[Joint]:
        """Return the joints from a link up to the top of its body."""
        found = []
        while link != self.top[link]:
            found.append(self.robot.joint_to[link])
            link = found[-1].parent
        return found


class Gap(NamedTuple):
    """How far two places are apart (m, rad), and how far they may be as well as they are known."""

    distance: float
    angle: float
    length_room: float
    angle_room: float

    @property
    def closed(self) -> bool:
        """Whether the two places are the same."""
        return self.distance <= self.length_room and self.angle <= self.angle_room
