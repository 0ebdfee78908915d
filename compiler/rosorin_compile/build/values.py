"""Small values as entries of a description say them: vectors, poses, and what a joint has."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from ..model import IDENTITY, Dynamics, Limit, Mimic, Pose, Vector


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


def limit_of(entry: Mapping[str, Any] | None) -> Limit | None:
    """Return the limit of a joint."""
    if entry is None:
        return None
    return Limit(**{key: float(value) for key, value in entry.items() if key != "source"})


def mimic_of(entry: Mapping[str, Any] | None) -> Mimic | None:
    """Return what a joint follows."""
    if entry is None:
        return None
    return Mimic(entry["joint"], float(entry.get("multiplier", 1)), float(entry.get("offset", 0)))


def dynamics_of(entry: Mapping[str, Any] | None) -> Dynamics | None:
    """Return the dynamics of a joint."""
    if entry is None:
        return None
    return Dynamics(**{key: float(value) for key, value in entry.items() if key != "source"})
