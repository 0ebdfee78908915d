"""What only a simulation has: actuators, contact, tendons, constraints, sites, cameras, lights, and how a base stands.

Attributes that the language has no word for are kept under the names that MuJoCo gives them, in SI units (``Values``).
"""

from __future__ import annotations

from collections.abc import Mapping

from ..startup.records import dataclass, field
from .geometry import IDENTITY, Pose
from .simulated import Attribute

Values = Mapping[str, Attribute]

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


NO_SIMULATION = Simulation()
