"""Bodies: whether a link can have the mass, the inertia and the centre of mass that are said of it."""

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

from . import shared_values
from .case import Case, number
from .sizes import all_ways, longest

# kg/m^3. Osmium, at 20 degrees (CRC Handbook of Chemistry and Physics, "Density of the elements").
DENSEST = 22_590.0
# Air has 1.2, aerogels that one can hold more than 3: nothing solid is lighter than this.
LIGHTEST = 1.0
HUGE = 1e9  # m; what is larger is told elsewhere, and its third power may be no number
# Sizes are rounded, and a box around a part leaves out a flange: half as much again is let pass.
ROUGHLY = 1.5
# Of the inertia the third power of a root counts, and moments are often rounded to one digit.
ROUGH_INERTIA = 2.0
# Some collide with less than they are, and are seen by a mesh whose size is not known here: a sphere under a foot.
LESS_THAN_SEEN = 10.0
# What is as small as this in the collision of a link with meshes is no shape, but says that there should be none.
NO_SHAPE = 0.005  # m
# Up to a gram stands for "no mass" in the links of many robots, for engines that ask for one.
NO_MASS = 0.001  # kg
# A radius of gyration is at most the distance to the farthest point; shapes may be rough, so twice that passes.
BEYOND = 2.0
# Of the diagonal of the shapes: a counterweight that nobody drew is nearer than that.
OUTSIDE = 0.7
# A solid is no flatter than that: an inertia that is printed to few digits looks like a sheet without thickness.
FLATTEST = 0.01
# What is written in g/cm^3 is below this; cork has 240, foam 20 to 200.
FOAM = 25.0  # kg/m^3


class _Body(NamedTuple):
    """A link with a mass, what is known of its shapes, and how long all the ways between joints of the robot are."""

    link: Link
    inertial: Inertial
    path: Path
    bounds: Bounds | None
    whole: bool
    reach: float


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
    "A warning: an inertia that no body of this mass and size has.",
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
    return shared_values.links(case.robot).problems(partial(_plausible, case))


def _plausible(case: Case, link: Link) -> Iterator[Diagnostic]:
    inertial = link.inertial
    if inertial is None or not inertial.mass > 0:
        return
    path = case.link(link.name, "inertial")
    if exists(case.tree, (*path, "density")):
        yield from _density(case, link, path)
    if inertial.mass <= NO_MASS:
        return
    moments = None if exists(case.tree, (*path, "of")) else inertial.principal_moments
    if _is_usual(link, inertial, moments):
        return
    bounds, whole = _bounds(link)
    body = _Body(link, inertial, path, bounds, whole, all_ways(case.robot))
    told = list(_mass(case, body)) or (list(_inertia(case, body, moments)) if moments else [])
    yield from told
    yield from _centre(case, body)


def _is_usual(link: Link, inertial: Inertial, moments: Vector | None) -> bool:
    """Say quickly that there is nothing to say of a link, as of nearly all.

    What is known of a link's largest shape is at most true of all of them: the space they take is larger, and so is the
    way from the centre of mass to the farthest point.
    """
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
    return moments[2] <= mass * (BEYOND * min(HUGE, largest.radius)) ** 2 and _densest(mass, *moments) <= DENSEST


def _bounds(link: Link) -> tuple[Bounds | None, bool]:
    """Return the bounding box of the shapes of a link whose sizes are known, and whether all are known."""
    seen, felt = bounds_of(link.visual), bounds_of(link.collision)
    whole = (seen is None) == (not link.visual) and (felt is None) == (not link.collision)
    if seen and felt:
        return seen.join(felt), whole
    return (seen or felt), whole


def _mass(case: Case, body: _Body) -> Iterator[Diagnostic]:
    """Yield a warning where a mass does not go with the space that the shapes take."""
    link, bounds, mass = body.link, body.bounds, body.inertial.mass
    if bounds is None or (not body.whole and max(bounds.size) <= NO_SHAPE):
        return
    volume = math.prod(bounds.size)
    if not volume > 0:
        return
    density = mass / volume
    heavy = density > DENSEST * ROUGHLY * (1.0 if body.whole else LESS_THAN_SEEN)
    if not heavy and (density >= LIGHTEST or mass >= LIGHTEST * _volume(link)):  # a plate that is tilted fills little
        return
    key = "density" if exists(case.tree, (*body.path, "density")) else "mass"
    place, shape = (*body.path, key), _shape(case, link)
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
    """Return the volume (m^3) of what a link collides with or of what is seen, whichever is more; without meshes."""
    solids = ([shape for shape in own if not isinstance(shape.geometry, Mesh)] for own in (link.visual, link.collision))
    return max(math.fsum(volume_of(shape.geometry) for shape in own) for own in solids)


def _inertia(case: Case, body: _Body, principal: Vector) -> Iterator[Diagnostic]:
    """Yield a warning where an inertia is smaller than that of the densest body, or larger than the link."""
    link, mass = body.link, body.inertial.mass
    low, middle, high = principal
    if not (low > 0 and high <= (low + middle) * (1 + 1e-6)):  # other rules say so
        return
    moments = {"ixx": body.inertial.ixx, "iyy": body.inertial.iyy, "izz": body.inertial.izz}
    place: Path = (*body.path, "inertia", max(moments, key=lambda key: moments[key]))
    radius = math.sqrt(high / mass)
    density = _densest(mass, low, middle, high)
    if density > DENSEST * ROUGH_INERTIA:
        message = (
            f'the inertia of link "{link.name}"{case.stands_in(place)} is too small for its {number(mass)} kg'
            f"{case.stands_in((*body.path, 'mass'))}: so close together they are {_dense(density)} dense at least,"
            f" and nothing is denser than {DENSEST:,.0f} (osmium)"
        )
        help = "correct the mass, in kg, or the inertia, in kg*m^2"
        related = [case.related("the mass", (*body.path, "mass"))]
        yield case.problem("inertia-implausible", message, place, help, related=related, severity=WARNING)
        return
    limit = body.bounds.reach(body.inertial.pose.xyz) if body.bounds and body.whole else body.reach
    if not limit > 0 or radius <= BEYOND * limit:
        return
    whole = body.bounds is not None and body.whole
    than = f"its shapes reach {number(limit)} m" if whole else f"all ways between joints are {number(limit)} m"
    message = (
        f'the inertia of link "{link.name}"{case.stands_in(place)} is too large for its size: {number(mass)} kg with'
        f" {number(high)} kg*m^2 lie {number(radius)} m from their centre on the average, and {than}"
    )
    help = "of: collision calculates the inertia of the shapes" if whole else "the inertia is in kg*m^2"
    related = [case.related("the shape", _shape(case, link))] if whole else []
    yield case.problem("inertia-implausible", message, place, help, related=related, severity=WARNING)


def _densest(mass: float, low: float, middle: float, high: float) -> float:
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
    """Yield a warning where the centre of mass is far from everything that the link is."""
    centre = body.inertial.pose.xyz
    place: Path = (*body.path, "xyz", max(range(3), key=lambda index: abs(centre[index])))
    what = f'the centre of mass of link "{body.link.name}"{case.stands_in(place)}'
    help = "xyz of inertial is seen from the frame of the link, in metres"
    if body.bounds is not None and body.whole:
        away = body.bounds.gap(Bounds(centre, centre))
        if away > OUTSIDE * body.bounds.diagonal:
            shape = _shape(case, body.link)
            message = (
                f"{what} lies {number(away)} m outside of its shapes{case.stands_in(shape)}, which take a space of"
                f" {_sizes(body.bounds)}"
            )
            related = [case.related("the shape", shape)]
            yield case.problem("centre-outside", message, place, help, related=related, severity=WARNING)
    elif 0 < body.reach * BEYOND < math.hypot(*centre):
        message = (
            f"{what} lies {number(math.hypot(*centre))} m from its frame, and all ways between joints are"
            f" {number(body.reach)} m"
        )
        yield case.problem("centre-outside", message, place, help, severity=WARNING)


def _density(case: Case, link: Link, path: Path) -> Iterator[Diagnostic]:
    """Yield a warning about a density that looks like g/cm^3."""
    place = (*path, "density")
    density = at(case.tree, place)
    if has_unit(density) or not 0 < density < FOAM:
        return
    message = f'the density of link "{link.name}" is {number(density)} kg/m^3, that of foam or less: water has 1000'
    help = f'write "{number(density)} g/cm^3" if that is meant, "{number(density)} kg/m^3" if not'
    yield case.problem("density-looks-like-grams", message, place, help, severity=WARNING)


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
