"""What only a simulation has: actuators, contact, tendons, constraints, sites, cameras, lights, and how a base stands.

Attributes that the language has no word for are kept under the names that MuJoCo gives them, in SI units (``Values``).
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from typing import Any

from .geometry import IDENTITY, Pose
from .simulated import Attribute

Values = Mapping[str, Attribute]

# Attributes whose value is the name of a link or of the frame of one, of a joint, of a shape.
_LINKS = frozenset(("body", "body1", "body2", "target", "site", "site1", "site2", "refsite", "sidesite"))
_LINKS |= {"slidersite", "cranksite", "objname", "refname", "subtree1", "subtree2"}
_JOINTS = frozenset(("joint", "joint1", "joint2", "jointinparent"))
_SHAPES = frozenset(("geom", "geom1", "geom2"))
# Names that the MJCF makes of that of a joint that moves in several ways, and of that of a link for its shapes.
_ONE_WAY = re.compile(r"(.+)(_TX|_TY|_TZ|_RZ|_R)")
_SHAPE = re.compile(r"(.+)(_(?:collision|visual)_\d+)")

POSITION, VELOCITY, MOTOR, GENERAL = "position", "velocity", "motor", "general"

# The layer of shapes that say no other.
SHARED_LAYER = "default"


@dataclass(frozen=True)
class Actuator:
    """What drives a joint, a tendon, a site or a body.

    ``targets`` are what it acts on by the word of MuJoCo (joint, tendon, site, refsite, ...); empty for one that stands
    with its joint, whose name it has if ``name`` is empty. ``kp`` and ``kv`` are gains (N*m/rad, N*m*s/rad or N/m,
    N*s/m); ``damping`` is that of the drive, seen at the joint. ``range`` is what it can be asked for; None is what its
    kind and joint say, and with ``unlimited`` anything. ``force`` is the smallest and largest force.
    """

    type: str = POSITION
    name: str = ""
    targets: Mapping[str, str] = field(default_factory=dict, hash=False)
    kp: float | None = None
    kv: float = 0.0
    damping_ratio: float = 0.0
    damping: float = 0.0
    gear: tuple[float, ...] = ()
    range: tuple[float, float] | None = None
    unlimited: bool = False
    force: tuple[float, float] | None = None
    mjcf: Values = field(default_factory=dict, hash=False)

    @property
    def holds_position(self) -> bool:
        """Whether it is asked for a position, and holds it."""
        return self.type == POSITION


@dataclass(frozen=True)
class Contact:
    """How a shape touches: the layers that it is on and those that it touches (None: the shared one), and how."""

    layers: tuple[str, ...] | None = None
    touches: tuple[str, ...] | None = None
    values: Values = field(default_factory=dict, hash=False)


@dataclass(frozen=True)
class Marked:
    """Something that a link has in simulation alone: a site, a camera or a light (``tag``), where it sits in it."""

    tag: str
    name: str
    pose: Pose = IDENTITY
    values: Values = field(default_factory=dict, hash=False)


@dataclass(frozen=True)
class Stop:
    """A stop of a tendon: the element of MuJoCo (site, geom, pulley) with its attributes."""

    tag: str
    values: Values


@dataclass(frozen=True)
class Tendon:
    """A tendon: factors of joints, or a path; ``values`` are its attributes in MuJoCo's words."""

    name: str
    joints: Mapping[str, float] = field(default_factory=dict, hash=False)
    path: tuple[Stop, ...] = ()
    values: Values = field(default_factory=dict, hash=False)


@dataclass(frozen=True)
class Entry:
    """An entry of a list of MuJoCo's: its element, its name, its attributes; ``links`` are the names of bodies."""

    tag: str
    name: str
    values: Values = field(default_factory=dict, hash=False)


@dataclass(frozen=True)
class ContactPair:
    """Two links, or two shapes by the names of their geoms, that touch whatever their layers say."""

    name: str = ""
    links: tuple[str, str] | None = None
    shapes: tuple[str, str] | None = None
    values: Values = field(default_factory=dict, hash=False)


@dataclass(frozen=True)
class Root:
    """How the root link stands in the world, and what a free joint there is called and does.

    ``placed`` says that the description says its pose: a free base that has none stands on the floor (``standing``).
    ``world`` says that it is no body in the world, but the world itself.
    """

    pose: Pose = IDENTITY
    joint: str = ""
    values: Values = field(default_factory=dict, hash=False)
    placed: bool = False
    world: bool = False


_AT_ORIGIN = Root()


@dataclass(frozen=True)
class Simulation:
    """What a robot has for a simulation beside its links and joints, each in the order of the description."""

    root: Root = _AT_ORIGIN
    actuators: tuple[Actuator, ...] = ()
    tendons: tuple[Tendon, ...] = ()
    constraints: tuple[Entry, ...] = ()
    sensors: tuple[Entry, ...] = ()
    contact_layers: tuple[str, ...] = ()
    contact_pairs: tuple[ContactPair, ...] = ()
    elements: tuple[str, ...] = ()

    def renamed(self, link: Callable[[str], str], joint: Callable[[str], str]) -> Simulation:
        """Return it with other names of links and joints; elements are as they are written."""
        names = Renames(link, joint)
        return replace(
            self,
            actuators=tuple(replace(one, targets=names.values(one.targets)) for one in self.actuators),
            tendons=tuple(
                replace(
                    one,
                    joints={names.joint(name): factor for name, factor in one.joints.items()},
                    path=tuple(replace(stop, values=names.values(stop.values)) for stop in one.path),
                )
                for one in self.tendons
            ),
            constraints=tuple(replace(one, values=names.values(one.values)) for one in self.constraints),
            sensors=tuple(replace(one, values=names.values(one.values)) for one in self.sensors),
            contact_pairs=tuple(
                replace(
                    one,
                    links=one.links and (link(one.links[0]), link(one.links[1])),
                    shapes=one.shapes and (names.shape(one.shapes[0]), names.shape(one.shapes[1])),
                )
                for one in self.contact_pairs
            ),
        )


class Renames:
    """Other names of links and joints in what a simulation has, also where they are part of a name."""

    def __init__(self, link: Callable[[str], str], joint: Callable[[str], str]) -> None:
        self.link = link
        self._joint = joint

    def joint(self, name: str) -> str:
        """Return the other name of a joint, or of one of the several that MuJoCo has for it."""
        return _in_one(name, self._joint, _ONE_WAY)

    def shape(self, name: str) -> str:
        """Return the other name of a shape, which may have that of its link."""
        return _in_one(name, self.link, _SHAPE)

    def values(self, values: Mapping[str, Any]) -> dict[str, Any]:
        """Return attributes with the other names in them."""
        by_word = ((_LINKS, self.link), (_JOINTS, self.joint), (_SHAPES, self.shape))
        made = dict(values)
        for words, rename in by_word:
            made |= {word: rename(made[word]) for word in words & made.keys() if isinstance(made[word], str)}
        return made


def _in_one(name: str, rename: Callable[[str], str], made: Any) -> str:
    found = None if rename(name) != name else made.fullmatch(name)
    return rename(found[1]) + found[2] if found else rename(name)


NO_SIMULATION = Simulation()
