"""The sections that only a simulation has, besides what links, joints and shapes have for it."""

from __future__ import annotations

from rosorin_compile.model.sections import Section
from rosorin_compile.model.simulation import Actuator
from rosorin_compile.model.simulator import ContactPair, Entry, Tendon
from rosorin_compile.source.rule_registry import checks_of

from .lowering import (
    actuators_of,
    constraints_of,
    contact_layers_of,
    contact_pairs_of,
    mjcf_sensors_of,
    tendons_of,
)
from .rules import actuators, constraints, numbers, sensors, tendons

ACTUATORS: Section[tuple[Actuator, ...]] = Section("actuators", lower=actuators_of, checks=checks_of(actuators))
TENDONS: Section[tuple[Tendon, ...]] = Section("tendons", lower=tendons_of, checks=checks_of(tendons))
CONSTRAINTS: Section[tuple[Entry, ...]] = Section("constraints", lower=constraints_of, checks=checks_of(constraints))
MJCF_SENSORS: Section[tuple[Entry, ...]] = Section("mjcf_sensors", lower=mjcf_sensors_of, checks=checks_of(sensors))
CONTACT_LAYERS: Section[tuple[str, ...]] = Section("contact_layers", lower=contact_layers_of)
# The rules of numbers are those of all of these sections.
CONTACT_PAIRS: Section[tuple[ContactPair, ...]] = Section(
    "contact_pairs", lower=contact_pairs_of, checks=checks_of(numbers)
)
