"""Batteries: a section for rosorin-compile that adds their mass to links."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

from rosorin_compile.extend import Case, Diagnostic, Section, rule
from rosorin_compile.model import Inertial, Pose, Robot, Vector


@dataclass(frozen=True)
class Battery:
    """A battery in a link: its mass (kg) is at a point of it (m); ``voltage`` in V, ``capacity`` in A*h."""

    name: str
    link: str
    mass: float
    voltage: float
    cells: int
    capacity: float | None = None
    xyz: Vector = (0.0, 0.0, 0.0)


def add_masses(robot: Robot, batteries: Mapping[str, Battery]) -> Robot:
    """Return the robot with a point mass for each battery."""
    masses: dict[str, list[Inertial]] = {}
    for battery in batteries.values():
        masses.setdefault(battery.link, []).append(Inertial(battery.mass, Pose(battery.xyz), 0, 0, 0))
    return robot.with_masses(masses)


@rule("battery-cell-voltage", "A cell of a battery has no voltage that a cell can have: 1 to 5 V.", "Correct `cells`.")
def cell_voltage(case: Case) -> Iterator[Diagnostic]:
    """Find batteries whose cells no chemistry has."""
    for name, battery in case.robot.sections[SECTION].items():
        each = battery.voltage / battery.cells
        if not 1 <= each <= 5:
            message = f'each cell of battery "{name}" has {each:.3g} V'
            yield case.problem("battery-cell-voltage", message, ("battery", name, "voltage"), "1 to 5 V are usual")


SECTION = Section.by_name("battery", Battery, adds=add_masses, checks=(cell_voltage,))
