"""The sections of simulators that other formats can express in part: actuators and constraints."""

from __future__ import annotations

from rosorin_compile.model.sections import Section
from rosorin_compile.model.simulation import Actuator, Entry
from rosorin_compile.source.rule_registry import checks_of

from .lowering import actuators_of, constraints_of
from .rules import actuators, constraints, numbers

# The rules of numbers are about contacts of shapes as well.
ACTUATORS: Section[tuple[Actuator, ...]] = Section(
    "actuators", lower=actuators_of, checks=(*checks_of(actuators), *checks_of(numbers))
)
CONSTRAINTS: Section[tuple[Entry, ...]] = Section("constraints", lower=constraints_of, checks=checks_of(constraints))
