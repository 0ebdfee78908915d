"""MJX: MuJoCo on accelerators, which loads no model of which two shapes may touch that it cannot collide.

What it lacks (mujoco-mjx 3.17, JAX): cylinders and ellipsoids against boxes, meshes and height fields, and fields
against each other. The floor of a scene, a plane, meets all shapes.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence, Set
from functools import cached_property
from typing import NamedTuple

from rosorin_compile.model import HeightMap, Mesh, Output, Robot, Shape
from rosorin_compile.rules.case import Case
from rosorin_compile.source.diagnostics import NOTE, Diagnostic
from rosorin_compile.source.rule_registry import Heading, Rule

from .bodies import body_name, weld_groups
from .contacts import Contacts, contacts
from .height_fields import HFIELD, form_of, solids
from .masks import Mask, Masks
from .omissions import has_volume, is_written

RULES = (
    Rule(
        "not-in-mjx",
        "A note: two shapes of a robot may touch that MJX does not collide, such as a cylinder and a box: it loads no "
        "MJCF with these. MuJoCo itself does.",
        "Make one of them a capsule or a sphere, or keep them apart: by the layers of their `contact`, or wheels by a "
        "`drive`.",
        Heading.FORMATS,
    ),
)

_ROUND = ("cylinder", "ellipsoid")
CANNOT = {
    *(frozenset((one, other)) for one in _ROUND for other in ("box", "mesh", HFIELD)),
    frozenset((HFIELD,)),
}


class _Look(NamedTuple):
    """What decides of a shape whether it meets another one: what it is, and its bits."""

    kind: str
    mask: Mask


class _Place(NamedTuple):
    """A collision shape: its link, and its place there."""

    link: str
    number: int


class Refused(NamedTuple):
    """Two kinds of shapes that MJX does not collide, with the first two shapes of these that may touch."""

    kinds: tuple[str, str]
    first: _Place
    second: _Place


def refused(robot: Robot, output: Output) -> Iterator[Refused]:
    """Yield what MJX does not collide and MuJoCo does, each two kinds of shapes once."""
    filtered = _Filtered(robot, output)
    found: set[frozenset[str]] = set()
    looks = list(filtered.shapes.items())
    for at, (one, places) in enumerate(looks):
        for other, others in looks[at:]:
            kinds = frozenset((one.kind, other.kind))
            if kinds not in CANNOT or kinds in found or not one.mask.meets(other.mask):
                continue
            pair = filtered.first((one.kind, places), (other.kind, others))
            if pair is not None:
                found.add(kinds)
                if other.kind in _ROUND:
                    yield Refused((other.kind, one.kind), pair[1], pair[0])
                else:
                    yield Refused((one.kind, other.kind), *pair)


def check(case: Case, output: Output) -> Iterator[Diagnostic]:
    """Yield a note for each two kinds of shapes that may touch and that MJX does not collide: on the first of them."""
    if not case.robot.is_tree:  # told by the rules about joints
        return
    for kinds, first, second in refused(case.robot, output):
        message = f'MJX does not collide a {kinds[0]} with a {kinds[1]}, which may touch: links "{first.link}" and'
        message += f' "{second.link}"; it does not load the MJCF'
        help = "make one of them a capsule, or keep them apart: by layers of their contact, or wheels by a drive"
        path = case.link(first.link, "collision", first.number)
        yield case.problem("not-in-mjx", message, path, help, severity=NOTE)


class _Filtered:
    """The shapes of a robot by what they are, and who of them MuJoCo keeps apart by links."""

    def __init__(self, robot: Robot, output: Output) -> None:
        self.robot = robot
        self.form = form_of(output)
        self.implied = output.options.get("contacts", "implied") == "implied"
        self.top_of = {name: top for top, names in weld_groups(robot).items() for name in names}
        self.world = "" if robot.has_free_base(output) else robot.root  # the top of what is welded to the world
        self.shapes = self._looks(Masks(robot, self.implied))

    def _looks(self, masks: Masks) -> Mapping[_Look, list[_Place]]:
        """Return the first shape of each link that looks like that, by its look."""
        made: dict[_Look, dict[str, _Place]] = {}
        for link in self.robot.links:
            for index, shape in enumerate(link.collision):
                kind = self._kind(shape)
                if kind:
                    look = _Look(kind, masks.of(link.name, shape))
                    made.setdefault(look, {}).setdefault(link.name, _Place(link.name, index))
        return {look: list(places.values()) for look, places in made.items()}

    def _kind(self, shape: Shape) -> str:
        """Return what a shape is in MuJoCo; empty if it has no geom."""
        geometry = shape.geometry
        if not has_volume(geometry) or (isinstance(geometry, Mesh) and not is_written(self.robot, geometry)):
            return ""
        if isinstance(geometry, HeightMap):
            return HFIELD if self.form == HFIELD else "box" if solids(shape, self.form) else ""
        return type(geometry).__name__.lower()

    def first(
        self, first: tuple[str, Sequence[_Place]], second: tuple[str, Sequence[_Place]]
    ) -> tuple[_Place, _Place] | None:
        """Return the first two shapes that nothing keeps apart: neither a weld nor a joint nor an exclude.

        Both are given by what they are, with their places.
        """
        (kind, ones), (other_kind, others) = first, second
        for one in ones:
            for other in others:
                paired = frozenset(((one.link, kind), (other.link, other_kind))) in self._paired
                if paired or (self._included(one.link, other.link) and self._meet(one.link, other.link)):
                    return one, other
        return None

    @cached_property
    def _contacts(self) -> Contacts:
        return contacts(self.robot, self.form, self.implied)

    @cached_property
    def _paired(self) -> Set[frozenset[tuple[str, str]]]:
        """Links that may touch across a joint, each with what it touches with."""
        both = ([(geom.link, self._kind(geom.solid.shape)) for geom in pair] for pair in self._contacts.pairs)
        return set(map(frozenset, both))

    @cached_property
    def _excluded(self) -> Set[frozenset[str]]:
        return set(map(frozenset, self._contacts.excluded))

    def _included(self, one: str, other: str) -> bool:
        return frozenset((body_name(self.robot, one), body_name(self.robot, other))) not in self._excluded

    def _meet(self, one: str, other: str) -> bool:
        """Say whether MuJoCo lets two links touch: they are not welded together, and no joint is between them alone."""
        first, second = self.top_of[one], self.top_of[other]
        if first == second:
            return False
        above = {self._above(first), self._above(second)}
        return self.world in (first, second) or not above & {first, second}

    def _above(self, top: str) -> str:
        joint = self.robot.joint_to.get(top)
        return self.top_of[joint.parent] if joint is not None else ""
