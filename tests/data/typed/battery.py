"""What a type checker makes of sections of a package: ``robot.sections[...]`` is what the record says."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from rosorin_compile import Robot
from rosorin_compile.extend import Section
from rosorin_compile.model import Inertial, Pose


@dataclass(frozen=True)
class Battery:
    """A battery."""

    link: str
    mass: float


def heavier(robot: Robot, batteries: Mapping[str, Battery]) -> Robot:
    """Return the robot with the masses of its batteries."""
    return robot.with_masses({one.link: [Inertial(one.mass, Pose(), 0, 0, 0)] for one in batteries.values()})


MANY = Section.by_name("battery", Battery, {"additionalProperties": {}}, adds=heavier)
LIST = Section.list_of("batteries", Battery, {"items": {}})
ONE = Section.single("accumulator", Battery, {})


def total(robot: Robot) -> float:
    """Return the mass of all batteries (kg)."""
    alone = robot.sections[ONE]
    masses: list[float] = [one.mass for one in robot.sections[MANY].values()]
    masses += [one.mass for one in robot.sections[LIST]]
    masses += [one.weight for one in robot.sections[LIST]]  # type: ignore[attr-defined]
    return sum(masses) + (alone.mass if alone is not None else 0.0)
