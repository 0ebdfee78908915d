"""The sections that only a simulation has as values: actuators, tendons, constraints, sensors of MuJoCo, and contacts.

The words of the language become the attributes of MuJoCo's elements; what they name (links, joints, sites) stays the
name that the description has for it.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

from rosorin_compile.language.lower.entries import Problem, actuator_of, entries_of, values_of
from rosorin_compile.language.lower.plainly import pose_of_entry
from rosorin_compile.language.lower.simulation import others, reworded
from rosorin_compile.model import Pose
from rosorin_compile.model.simulation import Actuator, Attribute, Entry
from rosorin_compile.mujoco.sections.simulation.values import ContactPair, Stop, Tendon

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


def actuators_of(tree: Mapping[str, Any], _: Problem) -> tuple[Actuator, ...]:
    """Return the actuators that do not stand with a joint."""
    made = ((name, entry, actuator_of(entry)) for name, entry in entries_of(tree, "actuators"))
    return tuple(
        replace(one, name=name, targets={word: entry[key] for key, word in TARGETS.items() if key in entry})
        for name, entry, one in made
        if one is not None
    )


def tendons_of(tree: Mapping[str, Any], _: Problem) -> tuple[Tendon, ...]:
    """Return the tendons."""
    return tuple(_tendon(name, entry) for name, entry in entries_of(tree, "tendons"))


def constraints_of(tree: Mapping[str, Any], _: Problem) -> tuple[Entry, ...]:
    """Return what is held together beyond joints."""
    return tuple(_constraint(name, entry) for name, entry in entries_of(tree, "constraints"))


def mjcf_sensors_of(tree: Mapping[str, Any], _: Problem) -> tuple[Entry, ...]:
    """Return the sensors of MuJoCo that bring no frame."""
    return tuple(_sensor(name, entry) for name, entry in entries_of(tree, "mjcf_sensors"))


def contact_layers_of(tree: Mapping[str, Any], _: Problem) -> tuple[str, ...]:
    """Return the layers of contacts in the order of their bits."""
    return tuple(tree["contact_layers"])


def contact_pairs_of(tree: Mapping[str, Any], _: Problem) -> tuple[ContactPair, ...]:
    """Return who touches whom whatever their layers say."""
    return tuple(_contact_pair(entry) for entry in tree["contact_pairs"])


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
    values = reworded(entry, _OF_TENDON) | values_of(entry.get("mjcf"))
    joints = {joint: float(factor) for joint, factor in (entry.get("joints") or {}).items()}
    return Tendon(name, joints, tuple(_stop(stop) for stop in entry.get("path") or ()), values)


def _stop(entry: Mapping[str, Any]) -> Stop:
    if "pulley" in entry:
        return Stop("pulley", {"divisor": float(entry["pulley"])})
    if "shape" in entry:
        return Stop("geom", reworded(entry, {"shape": "geom", "side_site": "sidesite"}))
    return Stop("site", reworded(entry, {"site": "site"}))


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
    return Entry(entry["type"], name, values | reworded(entry, _OF_CONSTRAINT))


def _contact_pair(entry: Mapping[str, Any]) -> ContactPair:
    values = others(entry, ("name", "links", "shapes", "source"))
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
    values = reworded(entry, MEASURED)
    for key, kind, word in (("object", "objtype", "objname"), ("reference", "reftype", "refname")):
        for what, one in (entry.get(key) or {}).items():
            values |= {kind: _OBJECTS[what], word: one}
    return Entry(entry["kind"], name, values | others(entry, _OF_SENSOR))
