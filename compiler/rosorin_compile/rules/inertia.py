"""Mass and inertia that a body can have."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial

from rosorin_compile.model import Link
from rosorin_compile.source.diagnostics import Diagnostic
from rosorin_compile.source.rule_registry import NUMBERS, rule

from . import shared_values
from .case import Case, number

# Relative to the largest moment: rounding of the description and of the eigenvalues, no more.
ROUNDING = 1e-9


@rule(
    "mass-not-positive",
    "A mass is zero or below.",
    "Correct it; leave `inertial` out for a mere frame.",
    NUMBERS,
    accept="link",
    imported="lenient",
)
@rule(
    "inertia-not-positive-definite",
    "An inertia has a principal moment that is not above zero.",
    "Check signs and products.",
    NUMBERS,
    accept="link",
    imported="always",
)
@rule(
    "inertia-triangle",
    "One principal moment is larger than the sum of the others: no body is like that.",
    "Check the order ixx, iyy, izz, and the units.",
    NUMBERS,
    accept="link",
    imported="always",
)
def physical(case: Case) -> Iterator[Diagnostic]:
    """Masses that are not positive, and inertias that no body has."""
    return shared_values.links(case.robot).problems(partial(_physical, case))


def _physical(case: Case, link: Link) -> Iterator[Diagnostic]:
    inertial = link.inertial
    if inertial is None:
        return
    path = case.link(link.name, "inertial")
    if not inertial.mass > 0:
        message = f'the mass of link "{link.name}" is {number(inertial.mass)} kg; a mass is above zero'
        help = "leave inertial out for a frame without mass"
        yield case.problem("mass-not-positive", message, (*path, "mass"), help)
    low, middle, high = inertial.principal_moments
    if high == low == 0 and not inertial.mass > 0:
        return
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
