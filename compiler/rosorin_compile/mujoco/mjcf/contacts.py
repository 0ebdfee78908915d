"""Contacts: which links are not to collide, and which may though MuJoCo would not let them.

MuJoCo lets nothing that is welded together on one side of a joint collide with what is welded together on its other
side, where both sides can move. That is right for the two links that the joint connects, and hides too much of the
others: a camera that is fixed to the wrist may well meet the gripper. So of those

- the two links that the joint connects are excluded: they are built into each other;
- links that touch at zero, in each named pose and all over the range of the joint are excluded: a simulation would
  push them apart. What is free in any of these is never hidden;
- links with a mesh are excluded: what a mesh touches is not known here;
- of the others the shapes that the joint can bring together are named as pairs, which MuJoCo then takes into account.
  They slide without friction: shapes around a joint are larger than the parts, and would brake it where they rub.

Where the bits of shapes (``masks``) keep links apart, there is nothing to exclude; and a pair would pass over them.

Pairs and excludes are said for every base, fixed or free: a robot is attached to other things. Pairs are the robot's
own, while the flag that turns MuJoCo's filter off is one of the whole scene, where other robots rely on it.
"""

from __future__ import annotations

import math
from bisect import bisect_left, bisect_right
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence, Set
from functools import cache, cached_property, partial
from typing import NamedTuple

from rosorin_compile.model import Joint, Link, Mesh, Robot, Transform, Vector
from rosorin_compile.model.cached import of_robot
from rosorin_compile.model.geometry import dot, norm, unit
from rosorin_compile.model.joint import motion, plane_axes
from rosorin_compile.model.shape import MERGED
from rosorin_compile.mujoco.mjcf.proximity import NEAR, Solid, Touching, solid_of

from .bodies import body_name, weld_groups
from .height_fields import solids
from .masks import Masks
from .omissions import has_volume, position_range


class Geom(NamedTuple):
    """A collision shape of a link: the number that its geom has there, from 1."""

    link: str
    number: int
    solid: Solid


Meeting = tuple[Geom, Geom]


# Each pair is looked at in each step; of two links that are made of hundreds of shapes it would be all that is done.
MOST = 300
# Into so many steps the range of a joint is cut to see whether two links always touch.
STEPS = 24


class Contacts(NamedTuple):
    """Pairs of bodies that are excluded from contact, and pairs of shapes that may collide where MuJoCo filters.

    ``left`` are links that would need more than ``MOST`` pairs: it is left to MuJoCo whether they collide.
    """

    excluded: list[tuple[str, str]]
    pairs: list[Meeting]
    left: list[tuple[str, str]]


class _Ball(NamedTuple):
    """A ball around a shape (m), its middle in the two lengths that the motion of a joint does not change."""

    first: float
    second: float
    radius: float
    geom: Geom


@of_robot
def contacts(robot: Robot, form: str = MERGED, implied: bool = True) -> Contacts:
    """Return who is not to collide, and who may all the same; ``form`` is that of the height maps.

    The links of each joint come first, then ``disabled_contacts`` of the robot; without ``implied`` these alone. Bodies
    are called as in the MJCF.
    """
    groups = weld_groups(robot)
    top_of = {name: top for top, names in groups.items() for name in names}
    masks = Masks(robot, implied)
    solid = {top: [name for name in names if robot.link[name].collision] for top, names in groups.items()}
    places = cache(partial(_places, robot))
    geoms = cache(lambda name: _geoms(robot.link[name], form))
    meshes = {link.name for link in robot.links for one in link.collision if isinstance(one.geometry, Mesh)}
    named = {frozenset(pair) for pair in robot.disabled_contacts}
    excluded: dict[frozenset[str], tuple[str, str]] = {}
    pairs: list[Meeting] = []
    left: list[tuple[str, str]] = []
    for top, below in solid.items() if implied else ():
        joint = robot.joint_to.get(top)
        above = solid[top_of[joint.parent]] if joint is not None else []
        if joint is None or not below or not above:
            continue
        if above == [joint.parent] and below == [joint.child]:  # neighbours alone, wherever they are
            ends = (joint.parent, joint.child)
            if masks.meet(*ends):
                excluded.setdefault(frozenset(ends), ends)
            continue
        across = _Across(robot, joint, places(), geoms, meshes)
        for links, meeting in across.candidates(above, below):
            if not masks.meet(*links):
                continue
            if across.excludes(links, meeting):
                excluded.setdefault(frozenset(links), links)
            elif len(meeting) > MOST:
                left.append(links)
            elif frozenset(links) not in named:
                pairs += [pair for pair in meeting if masks.pair(*pair)]
    for pair in robot.disabled_contacts:
        if masks.rolling.isdisjoint(pair):  # else the bits say it, of a hundred rollers at once
            excluded.setdefault(frozenset(pair), pair)
    bodies = [(body_name(robot, one), body_name(robot, other)) for one, other in excluded.values()]
    return Contacts(bodies, pairs, left)


def _places(robot: Robot) -> dict[str, Transform]:
    """Return where each link sits in the topmost link that it is welded to."""
    places: dict[str, Transform] = {}
    for link in robot.walk():
        joint = robot.joint_to.get(link.name)
        is_top = joint is None or not joint.is_fixed
        places[link.name] = Transform() if is_top or joint is None else places[joint.parent].then(joint.transform())
    return places


def _geoms(link: Link, form: str) -> list[Geom]:
    """Return the collision shapes of a link that become geoms and have a known size."""
    shapes = (solid for shape in link.collision for solid in solids(shape, form))
    every = ((number, solid_of(shape)) for number, shape in enumerate(shapes, start=1) if has_volume(shape.geometry))
    return [Geom(link.name, number, solid) for number, solid in every if solid is not None]


def _spread(joint: Joint) -> list[float]:
    """Return positions all over the range of a joint that has one number (rad or m)."""
    if joint.type not in ("revolute", "continuous", "prismatic"):
        return []
    ends = position_range(joint) or ((-math.pi, math.pi) if joint.type == "continuous" else None)
    return [ends[0] + (ends[1] - ends[0]) * step / STEPS for step in range(STEPS + 1)] if ends else []


class _Across:
    """What is on both sides of a joint; ``places`` are those of the links in the topmost of their side.

    ``geoms`` gives the shapes of a link.
    """

    def __init__(
        self,
        robot: Robot,
        joint: Joint,
        places: Mapping[str, Transform],
        geoms: Callable[[str], Sequence[Geom]],
        meshes: Set[str],
    ) -> None:
        self.robot = robot
        self.joint = joint
        self.places = places
        self.geoms = geoms
        self.meshes = meshes
        self.base = places[joint.parent].then(joint.origin.transform())

    @cached_property
    def positions(self) -> Iterable[float]:
        """What is looked at of the joint: zero, each pose, and all over its range."""
        states = [{}, *(pose.positions for pose in self.robot.poses)] if self.joint.moves else []
        positions = [0.0, *(self.robot.position(self.joint, state) for state in states), *_spread(self.joint)]
        return dict.fromkeys(positions)

    def ways(self) -> Iterator[Transform]:
        """Yield where the joint puts its child, in all of its positions; mostly the first one is all that is asked."""
        for position in self.positions:
            yield self.base.then(motion(self.joint.type, self.joint.axis, position))

    @cached_property
    def axis(self) -> Vector:
        """The axis of the joint at length 1."""
        return unit(self.joint.axis)

    def candidates(self, above: Sequence[str], below: Sequence[str]) -> Iterator[tuple[tuple[str, str], list[Meeting]]]:
        """Yield the links of both sides that matter to each other, with the shapes that the joint can bring together.

        They are neighbours, those that may meet, and what has a mesh with all of the other side.
        """
        meeting = self._meeting(above, below)
        order = {name: index for index, name in enumerate(below)}
        blind = [name for name in below if name in self.meshes]
        for one in above:
            others = set(below if one in self.meshes else (*blind, *meeting.get(one, ())))
            if one == self.joint.parent:
                others |= {self.joint.child} & order.keys()
            for other in sorted(others, key=order.__getitem__):
                yield (one, other), meeting.get(one, {}).get(other, [])

    def excludes(self, links: tuple[str, str], meeting: Sequence[Meeting]) -> bool:
        """Say whether two links of both sides are not to collide."""
        if links == (self.joint.parent, self.joint.child) or not self.meshes.isdisjoint(links):
            return True
        one, other = (self.places[name] for name in links)
        mine, theirs = ({geom.number: geom.solid for geom in side}.values() for side in zip(*meeting, strict=True))
        touching, back = Touching(list(mine), list(theirs)), one.inverse()
        return all(touching.at(back.then(way).then(other)) for way in self.ways())

    def _meeting(self, above: Sequence[str], below: Sequence[str]) -> dict[str, dict[str, list[Meeting]]]:
        """Return the shapes that some position of the joint may bring together, by the links of both sides."""
        back = self.base.inverse()
        ones = [ball for name in above for ball in self._balls(name, back.then(self.places[name]))]
        others = [ball for name in below for ball in self._balls(name, self.places[name])]
        order = sorted(range(len(others)), key=lambda index: others[index].first)
        firsts, largest = [others[index].first for index in order], max((ball.radius for ball in others), default=0.0)
        found: dict[str, dict[str, list[Meeting]]] = {}
        for one in ones:
            reach = one.radius + largest + NEAR
            window = order[bisect_left(firsts, one.first - reach) : bisect_right(firsts, one.first + reach)]
            for other in (others[index] for index in sorted(window)):
                apart = math.hypot(one.first - other.first, one.second - other.second)
                if apart <= one.radius + other.radius + NEAR:
                    mates = found.setdefault(one.geom.link, {})
                    mates.setdefault(other.geom.link, []).append((one.geom, other.geom))
        return found

    def _balls(self, link: str, place: Transform) -> Iterator[_Ball]:
        """Yield balls around the shapes of a link that become geoms; ``place`` is where the joint sees the link."""
        for geom in self.geoms(link):
            first, second = self._constant(place.apply(geom.solid.middle))
            yield _Ball(first, second, geom.solid.radius, geom)

    def _constant(self, point: Vector) -> tuple[float, float]:
        """Return two lengths (m) of a point that the motion of the joint does not change."""
        if self.joint.type == "floating":
            return 0.0, 0.0
        if self.joint.type == "ball":
            return norm(point), 0.0
        along = dot(self.axis, point)
        if self.joint.type == "planar":
            return along, 0.0
        if self.joint.type == "prismatic":
            one, other = plane_axes(self.joint.axis)
            return dot(one, point), dot(other, point)
        return along, math.sqrt(max(dot(point, point) - along * along, 0.0))
