"""Values of the sections ``tendons`` and ``contact_pairs``."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from rosorin_compile.model.simulation import Values


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


@dataclass(frozen=True)
class ContactPair:
    """Two links, or two shapes by the names of their geoms, that touch whatever their layers are."""

    name: str = ""
    links: tuple[str, str] | None = None
    shapes: tuple[str, str] | None = None
    values: Values = field(default_factory=dict, hash=False)
