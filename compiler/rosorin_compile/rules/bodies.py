"""Rules about masses, inertias and centres of mass: impossible, implausible or missing values."""

import math
from collections.abc import Iterator

from rosorin_compile.model import ROBOT_STATE_PUBLISHER, Inertial, Link, Mesh, Vector
from rosorin_compile.model.bounds import Bounds, bounds_of
from rosorin_compile.source.diagnostics import NOTE, Diagnostic
from rosorin_compile.source.rule_registry import JOINTS, NUMBERS, rule
from rosorin_compile.source.tree import Path, exists, value_at
from rosorin_compile.source.units import has_unit

from .case import Case, number
from .joints import pieces
from .shapes import diagonal, longest

DENSEST = 22_590.0  # kg/m^3: osmium at 20 degrees (CRC Handbook of Chemistry and Physics)
LIGHTEST = 1.0  # kg/m^3: air has 1.2, usable aerogels more than 3
LIGHTEST_INERTIA = 0.05  # kg/m^3: SDF's default inertia (1 kg*m^2 for 1 kg) implies 0.06
FOAM = 25.0  # kg/m^3: a lower density is probably meant in g/cm^3 (up to 22.6); only the lightest foams are below it
ROUGHLY = 1.5  # factor that allows for rounded sizes and for shapes that omit small parts such as a flange
ROUGH_INERTIA = 2.0  # factor, because densities are computed from differences of moments, which may have one digit
LESS_THAN_SEEN = 10.0  # factor, because collision shapes may be smaller than the link, such as a sphere under a foot
NO_SHAPE = 0.005  # m: in a link with meshes, primitive shapes up to this size are placeholders
NO_MASS = 0.001  # kg: masses up to this are often placeholders for engines that require a mass
BEYOND = 2.0  # factor for rough shapes; a radius of gyration is at most the distance to the farthest point of a body
OUTSIDE = 0.7  # fraction of the diagonal of the shapes; even with hidden counterweights, the centre is closer
FLATTEST = 0.01  # ratio of squared semi-axes: the inertia of flatter bodies may have been printed with too few digits
ROUNDING = 1e-9  # relative to the largest moment: rounding error of the description and of the eigenvalues
# If a larger share of the moving links lacks mass or collision shapes, the omission is intended.
FEW_WITHOUT_MASS, FEW_WITHOUT_COLLISION = 0.5, 0.25


@rule("mass-not-positive", "A mass is not above 0.", "Correct or remove `inertial`.", NUMBERS, "link", "lenient")
@rule("inertia-not-positive-definite", "A moment is not above zero.", "Check the values.", NUMBERS, "link", "always")
@rule("inertia-triangle", "A principal moment exceeds the others.", "Check the units.", NUMBERS, "link", "always")
def physical(case: Case) -> Iterator[Diagnostic]:
    """Report masses that are not positive, and physically impossible inertias."""
    for link, inertial in [(link, link.inertial) for link in case.robot.links if link.inertial]:
        path = case.link(link.name, "inertial")
        if not inertial.mass > 0:
            message = f'the mass of link "{link.name}" is {number(inertial.mass)} kg, but must be above zero'
            yield case.problem("mass-not-positive", message, (*path, "mass"))
        low, middle, high = inertial.principal_moments
        message = f'{number(low)}, {number(middle)} and {number(high)} kg*m^2 of link "{link.name}"'
        if high == low == 0 and not inertial.mass > 0:
            continue
        if low <= ROUNDING * 1e-3 * abs(high):
            message = f"the principal moments of inertia {message} are not all above zero (not positive definite)"
            yield case.problem("inertia-not-positive-definite", message, (*path, "inertia"), within=True)
        elif low + middle < high * (1 - ROUNDING):
            message = f"the principal moments {message} are impossible: the largest exceeds the sum of the others"
            yield case.problem("inertia-triangle", message, (*path, "inertia"), within=True)


@rule("density-looks-like-grams", "A warning: a density is in g/cm^3.", "Write the unit.", NUMBERS, "link", "always")
@rule("mass-implausible", "A warning: the mass does not fit the size.", "Check the units.", NUMBERS, "link", "always")
@rule("inertia-implausible", "A warning: no body has this inertia.", "Correct the inertia.", NUMBERS, "link", "always")
@rule("centre-outside", "A warning: a centre of mass is far off its link.", "Check `xyz`.", NUMBERS, "link", "always")
def plausible(case: Case) -> Iterator[Diagnostic]:
    """Report implausible masses, inertias and centres of mass, compared with the shapes of the link."""
    for link, inertial in [(link, link.inertial) for link in case.robot.links if link.inertial]:
        path = case.link(link.name, "inertial")
        density = value_at(case.tree, (*path, "density")) if inertial.mass > 0 else None
        if density and not has_unit(density) and 0 < density < FOAM:
            message = f'the density of link "{link.name}" is {number(density)} kg/m^3; water has 1000 kg/m^3'
            help = f'write "{number(density)} g/cm^3" if g/cm^3 is meant, "{number(density)} kg/m^3" if not'
            yield case.problem("density-looks-like-grams", message, (*path, "density"), help)
        if inertial.mass > NO_MASS:
            visual, collision = bounds_of(link.visual), bounds_of(link.collision)
            bounds = visual.join(collision) if visual and collision else visual or collision
            # The sizes of meshes are not available, so the bounding box may cover only a part of the link.
            has_all = bounds and (not visual) == (not link.visual) and (not collision) == (not link.collision)
            whole = bounds if has_all else None
            found = list(_mass(case, link, inertial.mass, bounds, whole is not None)) if bounds else []
            yield from found or (() if exists(case.tree, (*path, "of")) else _inertia(case, link, inertial, whole))
            yield from _centre(case, link, inertial.pose.xyz, whole)


def _mass(case: Case, link: Link, mass: float, bounds: Bounds, complete: bool) -> Iterator[Diagnostic]:
    volume = math.prod(bounds.size)
    if not volume > 0 or (not complete and max(bounds.size) <= NO_SHAPE):
        return
    density = mass / volume
    if density <= DENSEST * ROUGHLY * (1.0 if complete else LESS_THAN_SEEN):
        # The bounding box of a tilted plate is mostly empty, so use the volumes of the shapes.
        shapes = ([one for one in own if not isinstance(one.geometry, Mesh)] for own in (link.visual, link.collision))
        if density >= LIGHTEST or mass >= LIGHTEST * max(math.fsum(one.volume for one in own) for own in shapes):
            return
    path, shape = case.link(link.name, "inertial"), _shape(case, link)
    place = (*path, "density" if exists(case.tree, (*path, "density")) else "mass")
    sizes = " x ".join(map(number, bounds.size))
    message = f'link "{link.name}" has {number(mass)} kg{case.stand_in(place)} in {sizes} m{case.stand_in(shape)},'
    message += f" a density of {number(density)} kg/m^3 (osmium: 22,590, air: 1.2)"
    yield case.problem("mass-implausible", message, place, related=[("the shape", shape)])


def _inertia(case: Case, link: Link, inertial: Inertial, bounds: Bounds | None) -> Iterator[Diagnostic]:
    low, middle, high = inertial.principal_moments
    if not (low > 0 and high <= (low + middle) * (1 + 1e-6)):  # another rule reports these
        return
    # Of all bodies with this mass and inertia, the uniform ellipsoid has the lowest peak density. Its moments
    # m/5 (b^2 + c^2), ... give the squares of its semi-axes.
    squares = [5 / 2 * (low + middle + high - 2 * moment) / inertial.mass for moment in (low, middle, high)]
    volume = 4 / 3 * math.pi * math.sqrt(math.prod(max(square, FLATTEST * max(squares)) for square in squares))
    radius, density = math.sqrt(high / inertial.mass), inertial.mass / volume if volume > 0 else math.inf
    limit = bounds.reach(inertial.pose.xyz) if bounds else diagonal(case.robot)
    limit, what = limit or math.inf, ""
    if density > DENSEST * ROUGH_INERTIA:
        what = "small for its mass"
    elif radius > BEYOND * limit:
        what = f"large (radius of gyration {number(radius)} m, shapes up to {number(limit)} m)"
    elif not bounds and density < LIGHTEST_INERTIA:
        what = "large for its mass"
    if what:
        path = case.link(link.name, "inertial")
        place: Path = (*path, "inertia", max(("ixx", "iyy", "izz"), key=lambda key: float(getattr(inertial, key))))
        message = f'the inertia of link "{link.name}"{case.stand_in(place)} is too {what}: the implied density is'
        message += f" {number(density)} kg/m^3 (osmium: 22,590, air: 1.2)"
        yield case.problem("inertia-implausible", message, place, related=[("the mass", (*path, "mass"))])


def _centre(case: Case, link: Link, centre: Vector, bounds: Bounds | None) -> Iterator[Diagnostic]:
    size = bounds.diagonal if bounds else diagonal(case.robot)
    away = bounds.gap(Bounds(centre, centre)) if bounds else math.hypot(*centre)
    if size > 0 and (OUTSIDE if bounds else BEYOND) * size < away:
        what = "its shapes, which measure only" if bounds else "its frame, but the entire robot measures"
        related = [("the shape", _shape(case, link))] if bounds else []
        place = case.link(link.name, "inertial", "xyz", max(range(3), key=lambda index: abs(centre[index])))
        message = f'the centre of mass of link "{link.name}"{case.stand_in(place)} is {number(away)} m away from'
        yield case.problem("centre-outside", f"{message} {what} {number(size)} m", place, related=related)


def _shape(case: Case, link: Link) -> Path:
    shapes = sorted(case.shapes(link), key=lambda one: one[1][-2] == "visual")
    return next(((*path, *longest(one)[0]) for _, path, one in shapes if not isinstance(one.geometry, Mesh)), ())


@rule("inertial-missing", "A warning: a moving link has no mass, unlike most.", "Add `inertial` to the link.", JOINTS)
@rule("collision-missing", "A note: a moving link collides with nothing, unlike most.", "Add `collision`.", JOINTS)
def links_without_mass(case: Case) -> Iterator[Diagnostic]:
    """Report moving links without mass or collision shapes, if most moving links have them."""
    robot = case.robot
    joints = [joint for joint in robot.joints if joint.parent in robot.link and joint.child in robot.link]
    fixed = [(joint.parent, joint.child) for joint in joints if joint.is_fixed]
    order = {name: index for index, name in enumerate(robot.link)}
    groups = pieces([*zip(order, order, strict=True), *fixed])
    parts = [[robot.link[name] for name in sorted(names, key=order.__getitem__)] for names in groups]
    moved = {joint.child for joint in robot.joints if not joint.is_fixed}
    shaped = [part for part in parts if any(one.visual or one.collision for one in part)]
    shaped = [part for part in shaped if any(link.name in moved for link in part)]
    light = [part for part in shaped if not any(link.inertial for link in part)]
    heavy = sum(any(link.inertial for link in part) for part in parts)
    few = heavy and (len(light) <= FEW_WITHOUT_MASS * len(shaped) or len(shaped) == 1)
    seen = [part for part in shaped if any(link.visual for link in part)]
    through = [part for part in seen if not any(link.collision for link in part)]
    lack = [("inertial-missing", part, "has no mass") for part in light if few]
    if len(seen) - len(through) > 1 and len(through) <= max(1, FEW_WITHOUT_COLLISION * len(seen)):
        lack += [("collision-missing", part, "has no collision shape") for part in through]
    for id, part, what in lack:
        name = next(link.name for link in part if link.visual or link.collision)
        yield case.problem(id, f'link "{name}" moves but {what}, unlike most moving links', case.link(name), key=True)


@rule("root-inertial", help="Add a root link without mass, with a fixed joint to this link.", topic=JOINTS)
def root_inertial(case: Case) -> Iterator[Diagnostic]:
    """A note: the root link of the URDF has a mass, which kdl_parser ignores with a warning.

    ros/kdl_parser@humble:src/kdl_parser.cpp: "The root link ... has an inertia specified in the URDF, but KDL does not
    support a root link with an inertia."
    """
    joints = case.robot.in_urdf() if case.outputs_read_by(ROBOT_STATE_PUBLISHER) else ()
    roots = {joint.parent for joint in joints} - {joint.child for joint in joints}
    link = case.robot.link.get(next(iter(roots))) if len(roots) == 1 else None
    if link is not None and link.inertial is not None:
        message = f'link "{link.name}" is the root of the URDF and has a mass, which kdl_parser ignores with a warning'
        yield case.problem("root-inertial", message, case.link(link.name, "inertial"), severity=NOTE, key=True)
