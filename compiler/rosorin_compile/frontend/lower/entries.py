"""Small values as entries of a description say them: vectors, poses, and what a joint has."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from ...model import (
    IDENTITY,
    NODE,
    Calibration,
    Dynamics,
    Limit,
    Material,
    Mimic,
    Pose,
    Publisher,
    SafetyController,
    Source,
    Vector,
)
from ...model.shape import Rgba


def vector_of(value: Any, default: Vector = (0.0, 0.0, 0.0)) -> Vector:
    """Return three numbers of a description as a vector."""
    if value is None:
        return default
    x, y, z = value
    return (float(x), float(y), float(z))


def pose_of_entry(entry: Mapping[str, Any]) -> Pose:
    """Return the pose that ``xyz`` (m) and ``rpy`` (rad) of an entry say."""
    if "xyz" not in entry and "rpy" not in entry:
        return IDENTITY
    return Pose(vector_of(entry.get("xyz")), vector_of(entry.get("rpy")))


def rgba_of(entry: Mapping[str, Any]) -> Rgba | None:
    """Return the colour of an entry."""
    if "rgba" not in entry:
        return None
    red, green, blue, alpha = map(float, entry["rgba"])
    return (red, green, blue, alpha)


def material_of(name: str, entry: Mapping[str, Any]) -> Material:
    """Return a material."""
    return Material(name, rgba_of(entry), entry.get("texture", ""))


def limit_of(entry: Mapping[str, Any] | None) -> Limit | None:
    """Return the limit of a joint."""
    if entry is None:
        return None
    return Limit(**_numbers(entry))


def mimic_of(entry: Mapping[str, Any] | None) -> Mimic | None:
    """Return what a joint follows."""
    if entry is None:
        return None
    return Mimic(entry["joint"], float(entry.get("multiplier", 1)), float(entry.get("offset", 0)))


def dynamics_of(entry: Mapping[str, Any] | None) -> Dynamics | None:
    """Return the dynamics of a joint."""
    if entry is None:
        return None
    return Dynamics(**_numbers(entry))


def calibration_of(entry: Mapping[str, Any] | None) -> Calibration | None:
    """Return the calibration of a joint."""
    return None if entry is None else Calibration(**_numbers(entry))


def safety_of(entry: Mapping[str, Any] | None) -> SafetyController | None:
    """Return the safety controller of a joint."""
    return None if entry is None else SafetyController(**_numbers(entry))


def source_of(entry: Mapping[str, Any] | None) -> Source:
    """Return where the values of an entry come from."""
    entry = entry or {}
    return Source(entry.get("status", ""), entry.get("note", ""), entry.get("measured", ""))


def texts_of(entry: Mapping[str, Any]) -> tuple[str, ...]:
    """Return the elements of XML that an entry has for the URDF."""
    return tuple(entry.get("urdf_elements") or ())


def node_of(name: str, entry: Mapping[str, Any] | None) -> Publisher:
    """Return a node that publishes what the description does not own."""
    entry = entry or {}
    stamps = tuple(entry.get("stamps", ()))
    return Publisher(NODE, entry.get("node", name), entry.get("package", ""), entry.get("about", ""), stamps)


def _numbers(entry: Mapping[str, Any]) -> dict[str, float]:
    return {key: float(value) for key, value in entry.items() if key != "source"}
