"""What only a simulation has of links, shapes and the root: marks of links, contacts, how the root stands."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from rosorin_compile.model.simulation import Attribute, Contact, Marked, Root

from .entries import attribute_of, values_of
from .plainly import pose_of_entry

_MARKED = {"sites": "site", "cameras": "camera", "lights": "light"}
_PLACED = ("xyz", "rpy", "source")


def marked_of(entry: Mapping[str, Any]) -> tuple[Marked, ...]:
    """Return the sites, cameras and lights of a link."""
    if _MARKED.keys().isdisjoint(entry):
        return ()
    return tuple(
        Marked(tag, name, pose_of_entry(one or {}), others(one or {}, _PLACED))
        for section, tag in _MARKED.items()
        for name, one in (entry.get(section) or {}).items()
    )


def contact_of(entry: Mapping[str, Any] | None) -> Contact | None:
    """Return how a shape touches."""
    if entry is None:
        return None
    layers, touches = (tuple(entry[key]) if key in entry else None for key in ("layers", "touches"))
    return Contact(layers, touches, others(entry, ("layers", "touches", "source")))


def others(entry: Mapping[str, Any], known: tuple[str, ...]) -> dict[str, Attribute]:
    """Return the values of an entry whose keys are MuJoCo's own words."""
    return {key: attribute_of(value) for key, value in sorted(entry.items()) if key not in known}


def root_of(entry: Mapping[str, Any]) -> Root:
    """Return how the root link stands in the world."""
    words = {"damping": "damping", "friction": "frictionloss", "armature": "armature"}
    values = values_of(entry.get("mjcf")) | reworded(entry, words)
    placed = "xyz" in entry or "rpy" in entry
    world = bool(entry.get("world", False))
    return Root(pose_of_entry(entry), entry.get("joint", ""), values, placed, world)


def reworded(entry: Mapping[str, Any], words: Mapping[str, str]) -> dict[str, Attribute]:
    """Return the values of an entry whose keys have other words in MuJoCo."""
    return {word: attribute_of(entry[key]) for key, word in words.items() if key in entry}
