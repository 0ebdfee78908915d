"""Values of the sections ``tendons`` and ``contact_pairs``."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

from rosorin_compile.model.simulation import Rename, Renames, Values


@dataclass(frozen=True)
class Stop:
    """A stop of a tendon: the element of MuJoCo (site, geom, pulley) with its attributes."""

    tag: str
    values: Values


@dataclass(frozen=True)
class Tendon:
    """A tendon: factors of joints, or a path; ``values`` are its attributes in MuJoCo."""

    name: str
    joints: Mapping[str, float] = field(default_factory=dict, hash=False)
    path: tuple[Stop, ...] = ()
    values: Values = field(default_factory=dict, hash=False)

    def renamed(self, link: Rename, joint: Rename) -> Tendon:
        """Return it with new names of links and joints."""
        names = Renames(link, joint)
        joints = {names.joint(name): factor for name, factor in self.joints.items()}
        path = tuple(replace(stop, values=names.values(stop.values)) for stop in self.path)
        return replace(self, joints=joints, path=path)


@dataclass(frozen=True)
class ContactPair:
    """Two links, or two shapes by the names of their geoms, that touch whatever their layers are."""

    name: str = ""
    links: tuple[str, str] | None = None
    shapes: tuple[str, str] | None = None
    values: Values = field(default_factory=dict, hash=False)

    def renamed(self, link: Rename, joint: Rename) -> ContactPair:
        """Return it with new names of links and joints."""
        shape = Renames(link, joint).shape
        links = self.links and (link(self.links[0]), link(self.links[1]))
        return replace(self, links=links, shapes=self.shapes and (shape(self.shapes[0]), shape(self.shapes[1])))
