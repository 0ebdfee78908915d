"""The sections of simulators that other formats can express in part: actuators and constraints.

The words of the language become the attributes of MuJoCo's elements; what they name (links, joints, sites) stays the
name that the description has for it.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

from rosorin_compile.language.lower.records import Problem, actuator_of, entries_of, pose_of_entry, renamed_values
from rosorin_compile.model import Pose
from rosorin_compile.model.sections import Section
from rosorin_compile.model.simulation import Actuator, Attribute, Entry
from rosorin_compile.source.rule_registry import checks_of

from . import actuators, numbers
from .actuators import TARGETS


def _actuators_of(tree: Mapping[str, Any], _: Problem) -> tuple[Actuator, ...]:
    made = ((name, entry, actuator_of(entry)) for name, entry in entries_of(tree, "actuators"))
    return tuple(
        replace(one, name=name, targets={word: entry[key] for key, word in TARGETS.items() if key in entry})
        for name, entry, one in made
        if one is not None
    )


def _constraints_of(tree: Mapping[str, Any], _: Problem) -> tuple[Entry, ...]:
    return tuple(_constraint(name, entry) for name, entry in entries_of(tree, "constraints"))


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
    for key, word in (("links", "body"), ("sites", "site"), ("joints", "joint")):
        values |= {f"{word}{number}": one for number, one in enumerate(entry.get(key) or (), 1)}
    if "xyz" in entry or "rpy" in entry:
        pose: Pose = pose_of_entry(entry)
        values["relpose"] = (*pose.xyz, *pose.transform().quaternion())
    return Entry(entry["type"], name, values | renamed_values(entry, _OF_CONSTRAINT))


# The rules of numbers are about contacts of shapes and constraints as well.
ACTUATORS: Section[tuple[Actuator, ...]] = Section(
    "actuators", lower=_actuators_of, checks=(*checks_of(actuators), *checks_of(numbers))
)
CONSTRAINTS: Section[tuple[Entry, ...]] = Section("constraints", lower=_constraints_of)
