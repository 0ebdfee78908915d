"""A section in a folder with its schema: entries in entries, one of which names a sensor."""

from collections.abc import Mapping
from dataclasses import dataclass, field

from rosorin_compile.extend import Section


@dataclass(frozen=True)
class Strand:
    name: str
    sensor: str
    gauge: float
    magnet: str = ""


@dataclass(frozen=True)
class Cable:
    name: str
    strands: Mapping[str, Strand] = field(default_factory=dict)
    colour: str = "black"


SECTION = Section.by_name("wiring", Cable)
