"""What only a simulation has: sections that name actuators, tendons, constraints, sensors of MuJoCo, and contacts.

The words of the language become the attributes of MuJoCo's elements; what they name (links, joints, sites) stays the
name that the description has for it.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

from ...model import Pose
from ...model.simulated import Attribute
from ...model.simulation import Contact, ContactPair, Entry, Marked, Root, Simulation, Stop, Tendon
from .entries import actuator_of, attribute_of, entries_of, values_of
from .plainly import pose_of_entry

TARGETS = {
    "joint": "joint",
    "joint_in_parent": "jointinparent",
    "tendon": "tendon",
    "site": "site",
    "reference_site": "refsite",
    "slider_site": "slidersite",
    "crank_site": "cranksite",
    "body": "body",
}
"""What an actuator acts on: the word of the language, and that of MuJoCo."""

_MARKED = {"sites": "site", "cameras": "camera", "lights": "light"}
_PLACED = ("xyz", "rpy", "source")


def lower_simulation(tree: Mapping[str, Any]) -> Simulation:
    """Return what a robot has for a simulation beside its links and joints."""
    actuators = []
    for name, entry in entries_of(tree, "actuators"):
        made = actuator_of(entry)
        if made is not None:
            targets = {word: entry[key] for key, word in TARGETS.items() if key in entry}
            actuators.append(replace(made, name=name, targets=targets))
    return Simulation(
        root=_root(tree.get("root") or {}),
        actuators=tuple(actuators),
        tendons=tuple(_tendon(name, entry) for name, entry in entries_of(tree, "tendons")),
        constraints=tuple(_constraint(name, entry) for name, entry in entries_of(tree, "constraints")),
        sensors=tuple(_sensor(name, entry) for name, entry in entries_of(tree, "mjcf_sensors")),
        contact_layers=tuple(tree.get("contact_layers") or ()),
        contact_pairs=tuple(_contact_pair(entry) for entry in tree.get("contact_pairs") or ()),
        elements=tuple(tree.get("mjcf_elements") or ()),
    )


def marked_of(entry: Mapping[str, Any]) -> tuple[Marked, ...]:
    """Return the sites, cameras and lights of a link."""
    if _MARKED.keys().isdisjoint(entry):
        return ()
    return tuple(
        Marked(tag, name, pose_of_entry(one or {}), _others(one or {}, _PLACED))
        for section, tag in _MARKED.items()
        for name, one in (entry.get(section) or {}).items()
    )


def contact_of(entry: Mapping[str, Any] | None) -> Contact | None:
    """Return how a shape touches."""
    if entry is None:
        return None
    layers, touches = (tuple(entry[key]) if key in entry else None for key in ("layers", "touches"))
    return Contact(layers, touches, _others(entry, ("layers", "touches", "source")))


def _others(entry: Mapping[str, Any], known: tuple[str, ...]) -> dict[str, Attribute]:
    """Return the values of an entry whose keys are MuJoCo's own words."""
    return {key: attribute_of(value) for key, value in sorted(entry.items()) if key not in known}


def _root(entry: Mapping[str, Any]) -> Root:
    words = {"damping": "damping", "friction": "frictionloss", "armature": "armature"}
    values = values_of(entry.get("mjcf")) | _renamed(entry, words)
    placed = "xyz" in entry or "rpy" in entry
    world = bool(entry.get("world", False))
    return Root(pose_of_entry(entry), entry.get("joint", ""), values, placed, world)


def _renamed(entry: Mapping[str, Any], words: Mapping[str, str]) -> dict[str, Attribute]:
    return {word: attribute_of(entry[key]) for key, word in words.items() if key in entry}


_OF_TENDON = {
    "range": "range",
    "spring_length": "springlength",
    "stiffness": "stiffness",
    "damping": "damping",
    "friction": "frictionloss",
    "armature": "armature",
    "force": "actuatorfrcrange",
    "width": "width",
    "rgba": "rgba",
    "material": "material",
}


def _tendon(name: str, entry: Mapping[str, Any]) -> Tendon:
    values = _renamed(entry, _OF_TENDON) | values_of(entry.get("mjcf"))
    joints = {joint: float(factor) for joint, factor in (entry.get("joints") or {}).items()}
    return Tendon(name, joints, tuple(_stop(stop) for stop in entry.get("path") or ()), values)


def _stop(entry: Mapping[str, Any]) -> Stop:
    if "pulley" in entry:
        return Stop("pulley", {"divisor": float(entry["pulley"])})
    if "shape" in entry:
        return Stop("geom", _renamed(entry, {"shape": "geom", "side_site": "sidesite"}))
    return Stop("site", _renamed(entry, {"site": "site"}))


_OF_CONSTRAINT = {
    "torque_scale": "torquescale",
    "polynomial": "polycoef",
    "active": "active",
    "solref": "solref",
    "solimp": "solimp",
    "at": "anchor",
}


def _constraint(name: str, entry: Mapping[str, Any]) -> Entry:
    values: dict[str, Attribute] = {}
    for key, word in (("links", "body"), ("sites", "site"), ("joints", "joint"), ("tendons", "tendon")):
        values |= {f"{word}{number}": one for number, one in enumerate(entry.get(key) or (), 1)}
    if "xyz" in entry or "rpy" in entry:
        pose: Pose = pose_of_entry(entry)
        values["relpose"] = (*pose.xyz, *pose.transform().quaternion())
    return Entry(entry["type"], name, values | _renamed(entry, _OF_CONSTRAINT))


def _contact_pair(entry: Mapping[str, Any]) -> ContactPair:
    values = _others(entry, ("name", "links", "shapes", "source"))
    links, shapes = ((entry[key][0], entry[key][1]) if key in entry else None for key in ("links", "shapes"))
    return ContactPair(entry.get("name", ""), links, shapes, values)


MEASURED = {
    "joint": "joint",
    "tendon": "tendon",
    "actuator": "actuator",
    "site": "site",
    "link": "body",
    "camera": "camera",
    "shape": "geom",
    "mesh": "mesh",
    "link1": "body1",
    "link2": "body2",
    "shape1": "geom1",
    "shape2": "geom2",
}
_OBJECTS = {"link": "xbody", "inertial": "body", "shape": "geom", "site": "site", "camera": "camera"}
_OF_SENSOR = (*MEASURED, "kind", "object", "reference", "source")


def _sensor(name: str, entry: Mapping[str, Any]) -> Entry:
    values = _renamed(entry, MEASURED)
    for key, kind, word in (("object", "objtype", "objname"), ("reference", "reftype", "refname")):
        for what, one in (entry.get(key) or {}).items():
            values |= {kind: _OBJECTS[what], word: one}
    return Entry(entry["kind"], name, values | _others(entry, _OF_SENSOR))
