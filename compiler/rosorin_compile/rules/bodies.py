"""Bodies: masses, inertias and centres of mass that a link can have, and links that lack them."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import NamedTuple

from rosorin_compile.model import ROBOT_STATE_PUBLISHER, Inertial, Link, Mesh
from rosorin_compile.model.bounds import Bounds, bounds_of
from rosorin_compile.source.diagnostics import NOTE, Diagnostic
from rosorin_compile.source.rule_registry import JOINTS, NUMBERS, rule
from rosorin_compile.source.tree import Path, at, exists
from rosorin_compile.source.units import has_unit

from .case import Case, number, per_link
from .shapes import diagonal, longest

DENSEST = 22_590.0  # kg/m^3: osmium at 20 degrees (CRC Handbook of Chemistry and Physics)
LIGHTEST = 1.0  # kg/m^3: air has 1.2, aerogels that can be held more than 3
LIGHTEST_INERTIA = 0.05  # kg/m^3: 1 kg with moments of 1 kg*m^2, the placeholder of SDF, has 0.06
FOAM = 25.0  # kg/m^3: a density in g/cm^3 is below this; cork has 240, foam 20 to 200
ROUGHLY = 1.5  # sizes are rounded, and a box around a part leaves out a flange
ROUGH_INERTIA = 2.0  # moments are often rounded to one digit, and their third power counts
LESS_THAN_SEEN = 10.0  # the collision of a link may be smaller than its mesh: a sphere under a foot
NO_SHAPE = 0.005  # m: a collision shape as small as this in a link with meshes is a placeholder
NO_MASS = 0.001  # kg: a placeholder in many robots, for engines that need a mass
BEYOND = 2.0  # a radius of gyration is at most the distance to the farthest point, and shapes may be rough
OUTSIDE = 0.7  # of the diagonal of the shapes: a counterweight that nobody drew is nearer than that
FLATTEST = 0.01  # an inertia that is printed to few digits looks like a sheet without thickness
ROUNDING = 1e-9  # relative to the largest moment: of the description and of the eigenvalues
# Where more moving parts than these lack mass or collision, the robot is drawn without on purpose.
FEW_WITHOUT_MASS, FEW_WITHOUT_COLLISION = 0.5, 0.25


@rule("mass-not-positive", "A mass is not above zero.", "Correct or remove it.", NUMBERS, "link", "lenient")
@rule(
    "inertia-not-positive-definite", "A principal moment is not above zero.", "Check signs.", NUMBERS, "link", "always"
)
@rule(
    "inertia-triangle", "One principal moment exceeds the sum of the others.", "Check units.", NUMBERS, "link", "always"
)
@per_link
def physical(case: Case, link: Link) -> Iterator[Diagnostic]:
    """Masses that are not positive, and inertias that no body has."""
    inertial, path = link.inertial, case.link(link.name, "inertial")
    if inertial is None:
        return
    if not inertial.mass > 0:
        message = f'the mass of link "{link.name}" is {number(inertial.mass)} kg; a mass is above zero'
        yield case.problem("mass-not-positive", message, (*path, "mass"), "leave inertial out for a frame without mass")
    low, middle, high = inertial.principal_moments
    if high == low == 0 and not inertial.mass > 0:
        return
    message = f'{number(low)}, {number(middle)} and {number(high)} kg*m^2 of link "{link.name}"'
    if low <= ROUNDING * 1e-3 * abs(high):
        message = f"of the principal moments {message} not all are above zero (the inertia is not positive definite)"
        yield case.problem("inertia-not-positive-definite", message, (*path, "inertia"), within=True)
    elif low + middle < high * (1 - ROUNDING):
        message = f"no body has the principal moments {message}: the largest is more than the sum of the others"
        help = "check the order ixx, iyy, izz and the units (triangle inequality)"
        yield case.problem("inertia-triangle", message, (*path, "inertia"), help, within=True)


class _Body(NamedTuple):
    """A link with a mass, and the box around its shapes if any has a known size; ``complete`` if all have."""

    link: Link
    inertial: Inertial
    path: Path
    bounds: Bounds | None
    complete: bool


@rule(
    "density-looks-like-grams", "A warning: a density is in g/cm^3.", "Write `2.7 g/cm^3`.", NUMBERS, "link", "always"
)
@rule("mass-implausible", "A warning: no body of this size has this mass.", "Check units.", NUMBERS, "link", "always")
@rule(
    "inertia-implausible", "A warning: no body has this mass and inertia.", "Calculate it.", NUMBERS, "link", "always"
)
@rule(
    "centre-outside", "A warning: a centre of mass is far outside its link.", "Check `xyz`.", NUMBERS, "link", "always"
)
@per_link
def plausible(case: Case, link: Link) -> Iterator[Diagnostic]:
    """Masses against the space of the shapes, inertias against both, and centres of mass."""
    inertial, path = link.inertial, case.link(link.name, "inertial")
    if inertial is None or not inertial.mass > 0:
        return
    density = at(case.tree, (*path, "density")) if exists(case.tree, (*path, "density")) else None
    if density and not has_unit(density) and 0 < density < FOAM:
        message = f'the density of link "{link.name}" is {number(density)} kg/m^3, that of foam or less: water has 1000'
        help = f'write "{number(density)} g/cm^3" if that is meant, "{number(density)} kg/m^3" if not'
        yield case.problem("density-looks-like-grams", message, (*path, "density"), help)
    if inertial.mass > NO_MASS:
        visual, collision = bounds_of(link.visual), bounds_of(link.collision)
        complete = (visual is None) == (not link.visual) and (collision is None) == (not link.collision)
        bounds = visual.join(collision) if visual and collision else visual or collision
        body = _Body(link, inertial, path, bounds, complete and bounds is not None)
        yield from list(_mass(case, body)) or (() if exists(case.tree, (*path, "of")) else _inertia(case, body))
        yield from _centre(case, body)


def _mass(case: Case, body: _Body) -> Iterator[Diagnostic]:
    """Yield a warning where a mass does not match the space that the shapes take."""
    link, bounds, mass = body.link, body.bounds, body.inertial.mass
    volume = math.prod(bounds.size) if bounds else 0.0
    if bounds is None or not volume > 0 or (not body.complete and max(bounds.size) <= NO_SHAPE):
        return
    density = mass / volume
    is_heavy = density > DENSEST * ROUGHLY * (1.0 if body.complete else LESS_THAN_SEEN)
    if not is_heavy:  # a plate that is tilted fills little of the box around it
        shapes = ([one for one in own if not isinstance(one.geometry, Mesh)] for own in (link.visual, link.collision))
        volumes = [math.fsum(one.volume for one in own) for own in shapes]
        if density >= LIGHTEST or mass >= LIGHTEST * max(volumes):
            return
    place, shape = case.value(body.path, "density"), _shape(case, link)
    place = (*place, "mass") if place == body.path else place
    message = f'link "{link.name}" has {number(mass)} kg{case.stands_in(place)} in {_sizes(bounds)}'
    message += f"{case.stands_in(shape)}: {_dense(density)}, and {'osmium has 22,590' if is_heavy else 'air has 1.2'}"
    help = "correct the mass, in kg (850 g is 0.85), or the sizes, in metres (120 mm is 0.12)"
    yield case.problem("mass-implausible", message, place, help, related=[("the shape", shape)])


def _inertia(case: Case, body: _Body) -> Iterator[Diagnostic]:
    """Yield a warning where an inertia is that of something denser than osmium, larger than the link, or like air."""
    mass, inertial = body.inertial.mass, body.inertial
    low, middle, high = inertial.principal_moments
    if not (low > 0 and high <= (low + middle) * (1 + 1e-6)):  # reported by other rules
        return
    moments = {"ixx": inertial.ixx, "iyy": inertial.iyy, "izz": inertial.izz}
    place: Path = (*body.path, "inertia", max(moments, key=lambda key: moments[key]))
    radius, density = math.sqrt(high / mass), _density(mass, low, middle, high)
    limit = body.bounds.reach(inertial.pose.xyz) if body.bounds and body.complete else diagonal(case.robot)
    message = f'the inertia of link "{body.link.name}"{case.stands_in(place)} is too '
    related = [("the mass", (*body.path, "mass"))]
    if density > DENSEST * ROUGH_INERTIA:
        message += f"small for its {number(mass)} kg{case.stands_in(related[0][1])}: at least {_dense(density)},"
        message += " and osmium has 22,590"
    elif limit > 0 and radius > BEYOND * limit:
        message += f"large for its size: its radius of gyration is {number(radius)} m, and its shapes or"
        message += f" the robot reach {number(limit)} m"
    elif not body.complete and density < LIGHTEST_INERTIA:
        message += f"large for its {number(mass)} kg: about {_dense(density)}, and air has 1.2"
    else:
        return
    help = "correct the mass, in kg, or the inertia, in kg*m^2; of: collision calculates it from the shapes"
    yield case.problem("inertia-implausible", message, place, help, related=related)


def _density(mass: float, low: float, middle: float, high: float) -> float:
    """Return the density (kg/m^3) of the even ellipsoid with these principal moments (kg*m^2).

    No body of the same mass and inertia is less dense everywhere: the ellipsoid is the closest packing for given second
    moments (its m/5 (b^2 + c^2), ... give the squares of its semi-axes).
    """
    squares = [5 / 2 * (low + middle + high - 2 * moment) / mass for moment in (low, middle, high)]
    thin = FLATTEST * max(squares)
    volume = 4 / 3 * math.pi * math.sqrt(math.prod(max(square, thin) for square in squares))
    return mass / volume if volume > 0 else math.inf


def _centre(case: Case, body: _Body) -> Iterator[Diagnostic]:
    """Yield a warning where the centre of mass is far outside the link, or the robot if its size is not known."""
    centre = body.inertial.pose.xyz
    away, size, limit = math.hypot(*centre), diagonal(case.robot), BEYOND * diagonal(case.robot)
    what, related = "its frame, and the whole robot measures", []
    if body.bounds is not None and body.complete:
        away, size = body.bounds.gap(Bounds(centre, centre)), body.bounds.diagonal
        limit, what, related = OUTSIDE * size, "its shapes, which measure", [("the shape", _shape(case, body.link))]
    if size > 0 and limit < away:
        place: Path = (*body.path, "xyz", max(range(3), key=lambda index: abs(centre[index])))
        message = f'the centre of mass of link "{body.link.name}"{case.stands_in(place)} is {number(away)} m away from'
        help = "xyz of inertial is relative to the frame of the link, in metres"
        yield case.problem("centre-outside", f"{message} {what} {number(size)} m", place, help, related=related)


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


# --- links that lack a mass or a collision ---


@rule("inertial-missing", "A warning: a moving link has no mass, unlike most.", "Give it an `inertial`.", JOINTS)
@rule("collision-missing", "A note: a moving link collides with nothing, unlike most.", "Add a `collision`.", JOINTS)
def lacking(case: Case) -> Iterator[Diagnostic]:
    """Find parts of links that move together without mass or without collision, where others have one."""
    parts = _rigid_parts(case)
    shaped = [part for part, moves in parts if moves and any(link.visual or link.collision for link in part)]
    light = [part for part in shaped if not any(link.inertial for link in part)]
    heavy = sum(any(link.inertial for link in part) for part, _ in parts)
    few = heavy and (len(light) <= FEW_WITHOUT_MASS * len(shaped) or len(shaped) == 1)
    seen = [part for part in shaped if any(link.visual for link in part)]
    through = [part for part in seen if not any(link.collision for link in part)]
    others = len(seen) - len(through)
    through = through if others > 1 and len(through) <= max(1, FEW_WITHOUT_COLLISION * len(seen)) else []
    for id, found, what, count in (
        ("inertial-missing", light if few else [], "has no mass", heavy),
        ("collision-missing", through, "collides with nothing", others),
    ):
        for part in found:
            name = next(link.name for link in part if link.visual or link.collision)
            message = f'link "{name}" moves and {what}, unlike {count} other part{"s" * (count != 1)} of the robot'
            yield case.problem(id, message, case.link(name), key=True)


def _rigid_parts(case: Case) -> list[tuple[list[Link], bool]]:
    """Return the links that fixed joints hold together, and whether a joint moves them; also of broken trees."""
    above = {link.name: link.name for link in case.robot.links}

    def first(name: str) -> str:
        while above[name] != name:
            above[name] = above[above[name]]
            name = above[name]
        return name

    for joint in case.robot.joints:
        if joint.is_fixed and joint.parent in above and joint.child in above:
            above[first(joint.child)] = first(joint.parent)
    moved = {first(joint.child) for joint in case.robot.joints if not joint.is_fixed and joint.child in above}
    parts: dict[str, list[Link]] = {}
    for link in case.robot.links:
        parts.setdefault(first(link.name), []).append(link)
    return [(links, name in moved) for name, links in parts.items()]


@rule("root-inertial", help="Begin the robot at a link without mass, with a fixed joint to this one.", topic=JOINTS)
def root_inertial(case: Case) -> Iterator[Diagnostic]:
    """A note: the root link of the URDF has a mass, which kdl_parser drops with a warning.

    ros/kdl_parser@humble:src/kdl_parser.cpp: "The root link ... has an inertia specified in the URDF, but KDL does not
    support a root link with an inertia."
    """
    joints = case.robot.in_urdf() if case.feeding(ROBOT_STATE_PUBLISHER) else ()
    roots = {joint.parent for joint in joints} - {joint.child for joint in joints}
    link = case.robot.link.get(next(iter(roots))) if len(roots) == 1 else None
    if link is not None and link.inertial is not None:
        message = f'link "{link.name}" is the root of the URDF and has a mass: kdl_parser drops it, with a warning'
        yield case.problem("root-inertial", message, case.link(link.name, "inertial"), severity=NOTE, key=True)
