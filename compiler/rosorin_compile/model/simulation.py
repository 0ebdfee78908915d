"""What only a simulation has of links, joints, shapes and the base: actuators, contact, marks, and how the root stands.

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
Rename = Callable[[str], str]

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

    def renamed(self, link: Rename, joint: Rename) -> Actuator:
        """Return it with other names of links and joints."""
        return replace(self, targets=Renames(link, joint).values(self.targets))

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

    @property
    def sliding_friction(self) -> float | None:
        """The coefficient of sliding friction, the first of the three of MuJoCo; None if it is not given."""
        given = self.values.get("friction")
        first = given[0] if isinstance(given, tuple) and given else given
        return float(first) if isinstance(first, (int, float)) else None


@dataclass(frozen=True)
class Marked:
    """Something that a link has in simulation alone: a site, a camera or a light (``tag``), where it sits in it."""

    tag: str
    name: str
    pose: Pose = IDENTITY
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


AT_ORIGIN = Root()


class Renames:
    """Other names of links and joints in what a simulation has, also where they are part of a name."""

    def __init__(self, link: Rename, joint: Rename) -> None:
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


def _in_one(name: str, rename: Rename, made: Any) -> str:
    found = None if rename(name) != name else made.fullmatch(name)
    return rename(found[1]) + found[2] if found else rename(name)
