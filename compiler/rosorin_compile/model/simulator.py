"""What a robot has for a simulation beside its links and joints: tendons, constraints, sensors of MuJoCo, contacts.

An actuator is a value of the model (``model.simulation``): joints have those, too. Attributes are kept as there.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

from .simulation import Rename, Renames, Values


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

    def renamed(self, link: Rename, joint: Rename) -> Tendon:
        """Return it with other names of links and joints."""
        names = Renames(link, joint)
        return replace(
            self,
            joints={names.joint(name): factor for name, factor in self.joints.items()},
            path=tuple(replace(stop, values=names.values(stop.values)) for stop in self.path),
        )


@dataclass(frozen=True)
class Entry:
    """An entry of a list of MuJoCo's: its element, its name, its attributes; ``links`` are the names of bodies."""

    tag: str
    name: str
    values: Values = field(default_factory=dict, hash=False)

    def renamed(self, link: Rename, joint: Rename) -> Entry:
        """Return it with other names of links and joints."""
        return replace(self, values=Renames(link, joint).values(self.values))


@dataclass(frozen=True)
class ContactPair:
    """Two links, or two shapes by the names of their geoms, that touch whatever their layers say."""

    name: str = ""
    links: tuple[str, str] | None = None
    shapes: tuple[str, str] | None = None
    values: Values = field(default_factory=dict, hash=False)

    def renamed(self, link: Rename, joint: Rename) -> ContactPair:
        """Return it with other names of links and joints."""
        names = Renames(link, joint)
        return replace(
            self,
            links=self.links and (link(self.links[0]), link(self.links[1])),
            shapes=self.shapes and (names.shape(self.shapes[0]), names.shape(self.shapes[1])),
        )
