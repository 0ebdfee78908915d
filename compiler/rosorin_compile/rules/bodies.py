"""Bodies: masses, inertias and centres of mass that a link can have."""

from __future__ import annotations

import math
from collections.abc import Iterator
from functools import partial
from typing import NamedTuple

from rosorin_compile.model import Inertial, Link, Mesh, Vector
from rosorin_compile.model.bounds import Bounds, ball_of, bounds_of
from rosorin_compile.model.shape import volume_of
from rosorin_compile.source.diagnostics import WARNING, Diagnostic
from rosorin_compile.source.rule_registry import NUMBERS, rule
from rosorin_compile.source.tree import Path, at, exists
from rosorin_compile.source.units import has_unit

from .case import Case, links_by_value, number
from .sizes import diagonal, longest

# kg/m^3. Osmium, at 20 degrees (CRC Handbook of Chemistry and Physics, "Density of the elements").
DENSEST = 22_590.0
# Air has 1.2, aerogels that can be held more than 3: nothing solid is lighter than this.
LIGHTEST = 1.0
# Of an inertia without a known size: 1 kg with moments of 1 kg*m^2, the placeholder of SDF, has 0.06.
LIGHTEST_INERTIA = 0.05
HUGE = 1e9  # m; larger sizes are reported elsewhere, and their third power may be no number
# Sizes are rounded, and a box around a part leaves out a flange: half as much again is let pass.
ROUGHLY = 1.5
# Of the inertia the third power of a root counts, and moments are often rounded to one digit.
ROUGH_INERTIA = 2.0
# The collision of a link may be smaller than its mesh, whose size is not known here: a sphere under a foot.
LESS_THAN_SEEN = 10.0
# A collision shape as small as this in a link with meshes is a placeholder.
NO_SHAPE = 0.005  # m
# Up to a gram is a placeholder in many robots, for engines that need a mass.
NO_MASS = 0.001  # kg
# A radius of gyration is at most the distance to the farthest point; shapes may be rough, so twice that passes.
BEYOND = 2.0
# Of the diagonal of the shapes: a counterweight that nobody drew is nearer than that.
OUTSIDE = 0.7
# A solid is no flatter than that: an inertia that is printed to few digits looks like a sheet without thickness.
FLATTEST = 0.01
# A density in g/cm^3 is below this; cork has 240, foam 20 to 200.
FOAM = 25.0  # kg/m^3
# Relative to the largest moment: rounding of the description and of the eigenvalues.
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
    return links_by_value(case.robot).problems(partial(_physical, case))


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


class _Body(NamedTuple):
    """A link with a mass, and the box around its shapes if the sizes of all are known, which ``complete`` tells."""

    link: Link
    inertial: Inertial
    path: Path
    bounds: Bounds | None
    complete: bool


@rule(
    "density-looks-like-grams",
    "A warning: a bare density is that of foam or less, as those in g/cm^3 are.",
    "Write `2.7 g/cm^3`, or `2.7 kg/m^3` if that is meant.",
    NUMBERS,
    accept="link",
    imported="always",
)
@rule(
    "mass-implausible",
    "A warning: a mass that no body of this size has: denser than osmium, or lighter than air.",
    "A mass is in kg, a size in metres.",
    NUMBERS,
    accept="link",
    imported="always",
)
@rule(
    "inertia-implausible",
    "A warning: an inertia that no body of this mass has, or none of this mass and size.",
    "`of: collision` calculates it.",
    NUMBERS,
    accept="link",
    imported="always",
)
@rule(
    "centre-outside",
    "A warning: a centre of mass lies far outside of the shapes of its link.",
    "`xyz` of `inertial` is the centre of mass in the frame of the link, in metres.",
    NUMBERS,
    accept="link",
    imported="always",
)
def plausible(case: Case) -> Iterator[Diagnostic]:
    """Masses against the space of the shapes, inertias against both, and centres of mass."""
    return links_by_value(case.robot).problems(partial(_plausible, case))


def _plausible(case: Case, link: Link) -> Iterator[Diagnostic]:
    inertial = link.inertial
    if inertial is None or not inertial.mass > 0:
        return
    path = case.link(link.name, "inertial")
    density = at(case.tree, (*path, "density")) if exists(case.tree, (*path, "density")) else None
    if density and not has_unit(density) and 0 < density < FOAM:
        message = f'the density of link "{link.name}" is {number(density)} kg/m^3, that of foam or less: water has 1000'
        help = f'write "{number(density)} g/cm^3" if that is meant, "{number(density)} kg/m^3" if not'
        yield case.problem("density-looks-like-grams", message, (*path, "density"), help, severity=WARNING)
    if inertial.mass <= NO_MASS:
        return
    moments = None if exists(case.tree, (*path, "of")) else inertial.principal_moments
    if _is_usual(link, inertial, moments):
        return
    visual, collision = bounds_of(link.visual), bounds_of(link.collision)
    complete = (visual is None) == (not link.visual) and (collision is None) == (not link.collision)
    bounds = visual.join(collision) if visual and collision else visual or collision
    body = _Body(link, inertial, path, bounds, complete and bounds is not None)
    problems = list(_mass(case, body)) or (list(_inertia(case, body, moments)) if moments else [])
    yield from problems
    yield from _centre(case, body)


def _is_usual(link: Link, inertial: Inertial, moments: Vector | None) -> bool:
    """Return True, quickly, for a link that is plausible by its largest shape alone."""
    balls = [ball_of(shape) for shape in (*link.visual, *link.collision)]
    known = [ball for ball in balls if ball is not None]
    if not known or len(known) < len(balls):
        return False
    mass, centre = inertial.mass, inertial.pose.xyz
    largest = max(known, key=lambda ball: ball.volume)
    most = min(HUGE, max(math.dist(largest.middle, ball.middle) + ball.radius for ball in known))
    if not LIGHTEST * 8 * most**3 <= mass <= DENSEST * largest.volume:
        return False
    if math.dist(centre, largest.middle) > OUTSIDE * 2 * largest.radius:
        return False
    if moments is None:
        return True
    return moments[2] <= mass * (BEYOND * min(HUGE, largest.radius)) ** 2 and _density(mass, *moments) <= DENSEST


def _mass(case: Case, body: _Body) -> Iterator[Diagnostic]:
    """Yield a warning where a mass does not go with the space that the shapes take."""
    link, bounds, mass = body.link, body.bounds, body.inertial.mass
    if bounds is None or (not body.complete and max(bounds.size) <= NO_SHAPE):
        return
    volume = math.prod(bounds.size)
    if not volume > 0:
        return
    density = mass / volume
    heavy = density > DENSEST * ROUGHLY * (1.0 if body.complete else LESS_THAN_SEEN)
    if not heavy and (density >= LIGHTEST or mass >= LIGHTEST * _volume(link)):  # a plate that is tilted fills little
        return
    place = (*body.path, "density" if exists(case.tree, (*body.path, "density")) else "mass")
    shape = _shape(case, link)
    message = (
        f'link "{link.name}" has {number(mass)} kg{case.stands_in(place)} in a space of {_sizes(bounds)}'
        f"{case.stands_in(shape)}: {_dense(density)}, and "
    )
    if heavy:
        message += f"nothing is denser than {DENSEST:,.0f} (osmium)"
        help = "correct the mass, in kg (850 g is 0.85), or the sizes, in metres"
    else:
        message += "air has 1.2"
        help = "correct the sizes, in metres (120 mm is 0.12), or the mass, in kg"
    related = [case.related("the shape", shape)]
    yield case.problem("mass-implausible", message, place, help, related=related, severity=WARNING)


def _volume(link: Link) -> float:
    """Return the volume (m^3) of the collision or of the visual shapes, whichever is more; without meshes."""
    shapes = ([one for one in own if not isinstance(one.geometry, Mesh)] for own in (link.visual, link.collision))
    return max(math.fsum(volume_of(one.geometry) for one in own) for own in shapes)


def _inertia(case: Case, body: _Body, principal: Vector) -> Iterator[Diagnostic]:
    """Yield a warning where an inertia is that of something denser than osmium, larger than the link, or like air."""
    link, mass = body.link, body.inertial.mass
    low, middle, high = principal
    if not (low > 0 and high <= (low + middle) * (1 + 1e-6)):  # reported by other rules
        return
    moments = {"ixx": body.inertial.ixx, "iyy": body.inertial.iyy, "izz": body.inertial.izz}
    place: Path = (*body.path, "inertia", max(moments, key=lambda key: moments[key]))
    radius, density = math.sqrt(high / mass), _density(mass, low, middle, high)
    subject = f'the inertia of link "{link.name}"{case.stands_in(place)} is too'
    help = "correct the mass, in kg, or the inertia, in kg*m^2"
    related = [case.related("the mass", (*body.path, "mass"))]
    limit = body.bounds.reach(body.inertial.pose.xyz) if body.bounds and body.complete else diagonal(case.robot)
    if density > DENSEST * ROUGH_INERTIA:
        message = (
            f"{subject} small for its {number(mass)} kg{case.stands_in((*body.path, 'mass'))}: a body with both has a"
            f" density of at least {_dense(density)}, and nothing is denser than {DENSEST:,.0f} (osmium)"
        )
    elif limit > 0 and radius > BEYOND * limit:
        rest = "its shapes reach" if body.complete else "the whole robot measures"
        message = (
            f"{subject} large for its size: {number(mass)} kg with {number(high)} kg*m^2 lie {number(radius)} m from"
            f" their centre on the average, and {rest} {number(limit)} m"
        )
        if body.complete:
            help, related = (
                "of: collision calculates it from the shapes",
                [case.related("the shape", _shape(case, link))],
            )
        else:
            help, related = "the inertia is in kg*m^2", []
    elif not body.complete and density < LIGHTEST_INERTIA:
        message = (
            f"{subject} large for its {number(mass)} kg: a body with both has a density of about {_dense(density)},"
            " and air has 1.2"
        )
    else:
        return
    yield case.problem("inertia-implausible", message, place, help, related=related, severity=WARNING)


def _density(mass: float, low: float, middle: float, high: float) -> float:
    """Return the density (kg/m^3) of the even ellipsoid with these principal moments (kg*m^2).

    No body of the same mass and inertia is less dense everywhere: the ellipsoid is the closest packing for given second
    moments (its m/5 (b^2 + c^2), ... give the squares of its semi-axes).
    """
    total = low + middle + high
    squares = [5 / 2 * (total - 2 * moment) / mass for moment in (low, middle, high)]
    thin = FLATTEST * max(squares)
    volume = 4 / 3 * math.pi * math.sqrt(math.prod(max(square, thin) for square in squares))
    return mass / volume if volume > 0 else math.inf


def _centre(case: Case, body: _Body) -> Iterator[Diagnostic]:
    """Yield a warning where the centre of mass is far outside the link, or the robot if its size is not known."""
    centre, related = body.inertial.pose.xyz, []
    place: Path = (*body.path, "xyz", max(range(3), key=lambda index: abs(centre[index])))
    if body.bounds is not None and body.complete:
        away = body.bounds.gap(Bounds(centre, centre))
        if away <= OUTSIDE * body.bounds.diagonal:
            return
        shape = _shape(case, body.link)
        where = f"{number(away)} m outside of its shapes{case.stands_in(shape)}, which take {_sizes(body.bounds)}"
        related = [case.related("the shape", shape)]
    else:
        away, size = math.hypot(*centre), diagonal(case.robot)
        if not 0 < size * BEYOND < away:
            return
        where = f"{number(away)} m from its frame, and the whole robot measures {number(size)} m"
    message = f'the centre of mass of link "{body.link.name}"{case.stands_in(place)} is {where}'
    help = "xyz of inertial is relative to the frame of the link, in metres"
    yield case.problem("centre-outside", message, place, help, related=related, severity=WARNING)


def _shape(case: Case, link: Link) -> Path:
    """Return the path of the size of a link's first shape that is no mesh."""
    for purpose, shapes in (("collision", link.collision), ("visual", link.visual)):
        for index, shape in enumerate(shapes):
            if not isinstance(shape.geometry, Mesh):
                return case.link(link.name, purpose, index, *longest(shape)[0])
    return case.link(link.name)


def _dense(density: float) -> str:
    return f"{density:,.0f} kg/m^3" if 1000 <= density < 1e12 else f"{number(density)} kg/m^3"


def _sizes(bounds: Bounds) -> str:
    return " x ".join(number(side) for side in bounds.size) + " m"
