"""The drive of a robot: what kind of base it is, and which joints are its wheels. ``driving`` has its kinematics."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import ClassVar

from .link import NO_SOURCE, Source

MECANUM, DIFFERENTIAL, OMNI, TRICYCLE, ACKERMANN = "mecanum", "differential", "omni", "tricycle", "ackermann"

# What the joints of each kind are, in the order in which they are told.
ROLES: Mapping[str, tuple[str, ...]] = {
    MECANUM: ("front_left", "rear_left", "front_right", "rear_right"),
    DIFFERENTIAL: ("left", "right"),
    OMNI: ("wheels",),
    TRICYCLE: ("steering", "driven", "rolling"),
    ACKERMANN: ("steering", "driven", "rolling"),
}
STEERED = (TRICYCLE, ACKERMANN)
SLIDING = (MECANUM, OMNI)  # drives that go sideways


@dataclass(frozen=True)
class Drive:
    """What drives a robot on the ground: ``kind`` is one of the words here, ``joints`` has the joints of each role.

    ``frame`` is the base frame, empty for the root. ``radius`` (m) is that of all wheels; None: as their shapes say.
    """

    MECANUM: ClassVar[str] = MECANUM
    DIFFERENTIAL: ClassVar[str] = DIFFERENTIAL
    OMNI: ClassVar[str] = OMNI
    TRICYCLE: ClassVar[str] = TRICYCLE
    ACKERMANN: ClassVar[str] = ACKERMANN

    kind: str
    joints: Mapping[str, tuple[str, ...]]
    frame: str = ""
    radius: float | None = None
    source: Source = NO_SOURCE

    @property
    def wheels(self) -> tuple[str, ...]:
        """The joints of the wheels that a motor turns, each once."""
        roles = ("driven",) if self.kind in STEERED else ROLES[self.kind]
        return tuple(dict.fromkeys(name for role in roles for name in self.joints.get(role, ())))

    @property
    def steering(self) -> tuple[str, ...]:
        """The joints that steer."""
        return self.joints.get("steering", ())

    @property
    def slides(self) -> bool:
        """Whether the base goes sideways."""
        return self.kind in SLIDING

    def renamed(self, link: Callable[[str], str], joint: Callable[[str], str]) -> Drive:
        """Return it with other names of links and joints."""
        joints = {role: tuple(map(joint, names)) for role, names in self.joints.items()}
        return replace(self, joints=joints, frame=link(self.frame))
