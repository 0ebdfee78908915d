"""A rule for heavy balls, and a function for their mass."""

from __future__ import annotations

import math
from collections.abc import Iterator

from rosorin_compile.extend import Case, Diagnostic, function, rule


@rule("ball-too-heavy", "A ball is heavier than 5 kg.", "Use a smaller ball.", accept="link")
def light_enough(case: Case) -> Iterator[Diagnostic]:
    """Yield a problem for each link that is too heavy for a toy."""
    for link in case.robot.links:
        if link.inertial is not None and link.inertial.mass > 5:
            message = f"link {link.name} has {link.inertial.mass:g} kg"
            mass = case.link(link.name, "inertial", "mass")
            yield case.problem("ball-too-heavy", message, mass, "use a smaller ball")


@function("ball_mass", "`ball_mass(radius, density)`: the mass of a ball, in kg")
def ball_mass(radius: float, density: float) -> float:
    """Return the mass (kg) of a ball, from its radius (m) and density (kg/m^3)."""
    return float(density) * 4 / 3 * math.pi * float(radius) ** 3
