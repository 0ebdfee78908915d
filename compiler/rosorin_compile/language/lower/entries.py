"""Entries of a description that become one value each: vectors, poses, what a joint has, publishers."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from rosorin_compile.model import Limit, Publisher
from rosorin_compile.model.joint import NODE, Calibration, Dynamics, Mimic, SafetyController
from rosorin_compile.model.link import NO_SOURCE, Source
from rosorin_compile.model.shape import Material, Rgba
from rosorin_compile.model.simulation import Actuator, Attribute

from ..schema import fragment_at
from .plainly import record_of

# Takes the rule, the message, the path and the way out of a problem, and whether it is at a key.
Problem = Callable[..., None]


def entries_of(tree: Mapping[str, Any], section: str) -> list[tuple[str, Any]]:
    """Return the entries of a section in the order of the model: by name, or as they are written (x-ordered)."""
    entries = (tree.get(section) or {}).items()
    return list(entries) if fragment_at((section,)).get("x-ordered") else sorted(entries)


def rgba_of(entry: Mapping[str, Any]) -> Rgba | None:
    """Return the colour of an entry."""
    if "rgba" not in entry:
        return None
    red, green, blue, alpha = map(float, entry["rgba"])
    return (red, green, blue, alpha)


def material_of(name: str, entry: Mapping[str, Any]) -> Material:
    """Return a material."""
    return Material(name, rgba_of(entry), entry.get("texture", ""), values_of(entry.get("mjcf")))


def limit_of(entry: Mapping[str, Any] | None) -> Limit | None:
    """Return the limit of a joint."""
    return None if entry is None else record_of(Limit, entry)


def mimic_of(entry: Mapping[str, Any] | None) -> Mimic | None:
    """Return what a joint follows."""
    return None if entry is None else record_of(Mimic, entry)


def actuator_of(entry: Mapping[str, Any] | None) -> Actuator | None:
    """Return what drives a joint."""
    if entry is None:
        return None
    gear = entry.get("gear", [])
    gears = tuple(map(float, gear if isinstance(gear, list) else [gear]))
    return record_of(Actuator, entry, gear=gears, mjcf=values_of(entry.get("mjcf")))


def values_of(entry: Mapping[str, Any] | None) -> dict[str, Attribute]:
    """Return attributes in MuJoCo's words, by name."""
    return {name: attribute_of(value) for name, value in sorted(entry.items())} if entry else {}


def attribute_of(value: Any) -> Attribute:
    """Return the value of an attribute of MuJoCo."""
    if isinstance(value, list):
        return tuple(_scalar(item) for item in value)
    return None if value is None else _scalar(value)


def _scalar(value: Any) -> float | str | bool:
    if isinstance(value, (bool, str)):
        return value if isinstance(value, bool) else str(value)
    return float(value)


def dynamics_of(entry: Mapping[str, Any] | None) -> Dynamics | None:
    """Return the dynamics of a joint."""
    return None if entry is None else record_of(Dynamics, entry)


def calibration_of(entry: Mapping[str, Any] | None) -> Calibration | None:
    """Return the calibration of a joint."""
    return None if entry is None else record_of(Calibration, entry)


def safety_of(entry: Mapping[str, Any] | None) -> SafetyController | None:
    """Return the safety controller of a joint."""
    return None if entry is None else record_of(SafetyController, entry)


def source_of(entry: Mapping[str, Any] | None) -> Source:
    """Return where the values of an entry come from."""
    return record_of(Source, entry) if entry else NO_SOURCE


def texts_of(entry: Mapping[str, Any]) -> tuple[str, ...]:
    """Return the elements of XML that an entry has for the URDF."""
    return tuple(entry.get("urdf_elements") or ())


def node_of(name: str, entry: Mapping[str, Any] | None) -> Publisher:
    """Return a node that publishes what the description does not own."""
    return record_of(Publisher, entry, kind=NODE, name=(entry or {}).get("node", name))
