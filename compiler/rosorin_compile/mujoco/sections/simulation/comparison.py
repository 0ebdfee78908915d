"""What the sections for a simulation say, by what it is called, each thing as words with values."""

from __future__ import annotations

from collections.abc import Sequence

from rosorin_compile.compare.simulation import words_of
from rosorin_compile.compare.values import Said
from rosorin_compile.model.simulation import Actuator
from rosorin_compile.model.simulator import ContactPair, Entry, Tendon

Things = dict[str, Said]


def actuators(entries: Sequence[Actuator]) -> Things:
    """Return the actuators that do not stand with a joint."""
    return {f"actuator {one.name}": words_of(one) for one in entries}


def tendons(entries: Sequence[Tendon]) -> Things:
    """Return the tendons."""
    return {f"tendon {one.name}": words_of(one) for one in entries}


def constraints(entries: Sequence[Entry]) -> Things:
    """Return what is held together beyond joints."""
    return {f"constraint {one.name}": {"type": one.tag, **words_of(one)} for one in entries}


def mjcf_sensors(entries: Sequence[Entry]) -> Things:
    """Return the sensors of MuJoCo that bring no frame."""
    return {f"simulated sensor {one.name}": {"kind": one.tag, **words_of(one)} for one in entries}


def contact_pairs(entries: Sequence[ContactPair]) -> Things:
    """Return who touches whom whatever their layers say; a pair without a name has its place in the list."""
    return {f"contact pair {one.name or place}": words_of(one) for place, one in enumerate(entries, start=1)}


def contact_layers(names: Sequence[str]) -> Things:
    """Return the layers of contacts, as one thing: their order is that of MuJoCo's bits."""
    return {"contact layers": {"order": names}} if names else {}
