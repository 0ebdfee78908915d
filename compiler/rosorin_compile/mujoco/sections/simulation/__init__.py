"""The sections that only a simulation has, besides what links, joints and shapes have for it."""

from __future__ import annotations

from collections.abc import Sequence

from rosorin_compile.compare.simulation import words_of
from rosorin_compile.compare.values import Said
from rosorin_compile.model.sections import Section
from rosorin_compile.model.simulation import Actuator, Entry
from rosorin_compile.mujoco.sections.simulation.values import ContactPair, Tendon
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

Things = dict[str, Said]


def _actuators(entries: Sequence[Actuator]) -> Things:
    """Return the actuators that do not stand with a joint."""
    return {f"actuator {one.name}": words_of(one) for one in entries}


def _tendons(entries: Sequence[Tendon]) -> Things:
    """Return the tendons."""
    return {f"tendon {one.name}": words_of(one) for one in entries}


def _constraints(entries: Sequence[Entry]) -> Things:
    """Return what is held together beyond joints."""
    return {f"constraint {one.name}": {"type": one.tag, **words_of(one)} for one in entries}


def _mjcf_sensors(entries: Sequence[Entry]) -> Things:
    """Return the sensors of MuJoCo that bring no frame."""
    return {f"simulated sensor {one.name}": {"kind": one.tag, **words_of(one)} for one in entries}


def _contact_pairs(entries: Sequence[ContactPair]) -> Things:
    """Return who touches whom whatever their layers say; a pair without a name has its place in the list."""
    return {f"contact pair {one.name or place}": words_of(one) for place, one in enumerate(entries, start=1)}


def _contact_layers(names: Sequence[str]) -> Things:
    """Return the layers of contacts, as one thing: their order is that of MuJoCo's bits."""
    return {"contact layers": {"order": names}} if names else {}


ACTUATORS: Section[tuple[Actuator, ...]] = Section(
    "actuators", lower=actuators_of, describe=_actuators, checks=checks_of(actuators)
)
TENDONS: Section[tuple[Tendon, ...]] = Section(
    "tendons", lower=tendons_of, describe=_tendons, checks=checks_of(tendons)
)
CONSTRAINTS: Section[tuple[Entry, ...]] = Section(
    "constraints", lower=constraints_of, describe=_constraints, checks=checks_of(constraints)
)
MJCF_SENSORS: Section[tuple[Entry, ...]] = Section(
    "mjcf_sensors", lower=mjcf_sensors_of, describe=_mjcf_sensors, checks=checks_of(sensors)
)
CONTACT_LAYERS: Section[tuple[str, ...]] = Section("contact_layers", lower=contact_layers_of, describe=_contact_layers)
# The rules of numbers are those of all of these sections.
CONTACT_PAIRS: Section[tuple[ContactPair, ...]] = Section(
    "contact_pairs", lower=contact_pairs_of, describe=_contact_pairs, checks=checks_of(numbers)
)
