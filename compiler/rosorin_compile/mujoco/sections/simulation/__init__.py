"""The sections that only a simulation has, beside what links, joints and shapes say of it.

They share values, comparison and rules, and so a folder: each has its piece of the schema in a file of its name.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from rosorin_compile.language.sections.mjcf_elements import MJCF_ELEMENTS
from rosorin_compile.model.sections import OwnSection
from rosorin_compile.model.simulation import Actuator
from rosorin_compile.model.simulator import ContactPair, Entry, Simulation, Tendon

if TYPE_CHECKING:
    from rosorin_compile.model import Robot


def _in_folder(name: str, after: str, tells: str = "", rules: str = "") -> OwnSection[Any]:
    found = {"lowers": f"lowering:{name}_of", "tells": tells, "rules": rules}
    return OwnSection.in_folder(__name__, __path__[0], (), name=name, after=after, **found)


ACTUATORS: OwnSection[tuple[Actuator, ...]] = _in_folder("actuators", "root", "comparison:actuators", "rules.actuators")
TENDONS: OwnSection[tuple[Tendon, ...]] = _in_folder("tendons", "actuators", "comparison:tendons", "rules.tendons")
CONSTRAINTS: OwnSection[tuple[Entry, ...]] = _in_folder(
    "constraints", "tendons", "comparison:constraints", "rules.constraints"
)
MJCF_SENSORS: OwnSection[tuple[Entry, ...]] = _in_folder(
    "mjcf_sensors", "constraints", "comparison:mjcf_sensors", "rules.sensors"
)
CONTACT_LAYERS: OwnSection[tuple[str, ...]] = _in_folder("contact_layers", "mjcf_sensors", "comparison:contact_layers")
# The rules of numbers are those of all of these sections.
CONTACT_PAIRS: OwnSection[tuple[ContactPair, ...]] = _in_folder(
    "contact_pairs", "contact_layers", "comparison:contact_pairs", "rules.numbers"
)

_ALL: tuple[OwnSection[Any], ...] = (
    *(ACTUATORS, TENDONS, CONSTRAINTS, MJCF_SENSORS, CONTACT_LAYERS, CONTACT_PAIRS, MJCF_ELEMENTS),
)


def gathered(robot: Robot) -> Simulation:
    """Return all of them of a robot, with how its root stands: ``robot.simulation`` for templates and users."""
    return Simulation(robot.root_in_world, *(robot.sections[one] for one in _ALL))
