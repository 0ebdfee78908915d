"""Mass and inertia that a body can have."""

from __future__ import annotations

import math
from collections.abc import Iterator

from ..diagnostic import Diagnostic
from ..model import Inertial
from .case import Case, number

# Relative to the largest moment: rounding of the description and of the eigenvalues, no more.
ROUNDING = 1e-9


def physical(case: Case) -> Iterator[Diagnostic]:
    """Masses that are not positive, and inertias that no body has."""
    for link in case.robot.links:
        inertial = link.inertial
        if inertial is None:
            continue
        path = case.link(link.name, "inertial")
        if not inertial.mass > 0:
            message = f'the mass of link "{link.name}" is {number(inertial.mass)} kg; a mass is above zero'
            help = "leave inertial out for a frame without mass"
            yield case.problem("mass-not-positive", message, (*path, "mass"), help)
        low, middle, high = principal_moments(inertial)
        if high == low == 0 and not inertial.mass > 0:
            continue
        moments = f"{number(low)}, {number(middle)} and {number(high)} kg*m^2"
        if low <= ROUNDING * 1e-3 * abs(high):
            message = f'the inertia of link "{link.name}" is not positive definite: its principal moments are {moments}'
            help = "a body has three moments above zero; check the signs and that no product is too large"
            yield case.problem("inertia-not-positive-definite", message, (*path, "inertia"), help, within=True)
        elif low + middle < high * (1 - ROUNDING):
            message = (
                f'no body has the inertia of link "{link.name}": of its principal moments {moments}'
                " the largest is more than the sum of the others"
            )
            help = "check the order ixx, iyy, izz and the units (triangle inequality)"
            yield case.problem("inertia-triangle", message, (*path, "inertia"), help, within=True)


def principal_moments(inertial: Inertial) -> tuple[float, float, float]:
    """Return the eigenvalues of an inertia in kg*m^2, smallest first.

    Jacobi's method (1846): turn away the largest product until none is left. Exact to rounding for a 3x3 matrix, also
    where moments are equal, which the closed formula is not.
    """
    i = inertial
    matrix = [[i.ixx, i.ixy, i.ixz], [i.ixy, i.iyy, i.iyz], [i.ixz, i.iyz, i.izz]]
    for _ in range(60):
        p, q = max(((0, 1), (0, 2), (1, 2)), key=lambda at: abs(matrix[at[0]][at[1]]))
        size = max(abs(matrix[k][k]) for k in range(3))
        if abs(matrix[p][q]) <= 1e-17 * size:
            break
        _turn(matrix, p, q)
    low, middle, high = sorted(matrix[k][k] for k in range(3))
    return (low, middle, high)


def _turn(matrix: list[list[float]], p: int, q: int) -> None:
    """Make the product of the axes ``p`` and ``q`` zero by turning about the third axis, in place."""
    theta = (matrix[q][q] / 2 - matrix[p][p] / 2) / matrix[p][q]
    tangent = math.copysign(1.0, theta) / (abs(theta) + math.hypot(theta, 1.0))
    cosine = 1 / math.hypot(tangent, 1.0)
    sine = tangent * cosine
    matrix[p][p] -= tangent * matrix[p][q]
    matrix[q][q] += tangent * matrix[p][q]
    matrix[p][q] = matrix[q][p] = 0.0
    r = 3 - p - q
    first, second = matrix[p][r], matrix[q][r]
    matrix[p][r] = matrix[r][p] = cosine * first - sine * second
    matrix[q][r] = matrix[r][q] = sine * first + cosine * second
