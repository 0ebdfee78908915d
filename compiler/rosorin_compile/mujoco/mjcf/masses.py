"""Masses and inertias in the terms of MuJoCo, and which of them it does not load."""

from __future__ import annotations

from collections.abc import Iterator

from rosorin_compile.model import Inertial, Robot
from rosorin_compile.model.cached import of_robot
from rosorin_compile.model.mass import Inertia, along_link, principal_moments
from rosorin_compile.source.diagnostics import ERROR, NOTE, WARNING, Diagnostic, and_more
from rosorin_compile.source.rule_registry import Heading, Rule

from .bodies import weld_groups

RULES = (
    Rule(
        "mjcf-refused-inertia",
        "MuJoCo does not load an inertia that the description accepts.",
        "Correct it, or take `mjcf` out of `outputs`.",
        Heading.FORMATS,
    ),
    Rule(
        "mjcf-needs-mass",
        "A body that moves has no mass: MuJoCo does not load that.",
        "Give it an inertial, or make the joint fixed.",
        Heading.FORMATS,
    ),
)

# What MuJoCo 4.0.0 loads, found by trying: the least mass and moment of what moves, the least moment of fullinertia.
LEAST = 1e-15
LEAST_EIGENVALUE = 1e-14


def has_mass(inertial: Inertial) -> bool:
    """Say whether an inertial says anything: neither mass nor inertia is what a link without one has."""
    i = inertial
    return bool(i.mass) or any((i.ixx, i.iyy, i.izz, i.ixy, i.ixz, i.iyz))


def has_products(inertial: Inertial) -> bool:
    """Say whether an inertia has products in its own frame, whose axes are no principal ones then."""
    return any((inertial.ixy, inertial.ixz, inertial.iyz))


def along_link_of(inertial: Inertial) -> Inertia:
    """Return the inertia of an inertial along the axes of its link: xx yy zz xy xz yz."""
    six = (inertial.ixx, inertial.iyy, inertial.izz, inertial.ixy, inertial.ixz, inertial.iyz)
    return along_link(six, inertial.pose.transform())


@of_robot
def weightless(robot: Robot, free: bool) -> list[str]:
    """Return the links without any mass that a joint moves, and that carry mass by further joints.

    A body of MJCF with two joints comes as such a link: it has no mass, what hangs on it has. MuJoCo loads no moving
    body without mass, so in the MJCF these have the least that it takes, which changes no motion: what hangs on them is
    some 10^12 times heavier.
    """
    groups = weld_groups(robot)
    massive = {link.name for link in robot.links if link.inertial is not None and has_mass(link.inertial)}
    empty = {top for top, names in groups.items() if massive.isdisjoint(names)}
    if not free:
        empty.discard(robot.root)  # which no joint moves
    if not empty:
        return []
    top_of = {name: top for top, names in groups.items() for name in names}
    heavy: set[str] = set()
    without = []
    for top in reversed(groups):
        inertials = [inertial for name in groups[top] if (inertial := robot.link[name].inertial) is not None]
        joint = robot.joint_to.get(top)
        if top in heavy and top in empty:
            without.append(top)
        if joint is not None and (top in heavy or any(map(_is_body, inertials))):
            heavy.add(top_of[joint.parent])
    return without[::-1]


def masses(robot: Robot, free: bool) -> Iterator[Diagnostic]:
    """Yield what MuJoCo does not load, and what it takes for something else.

    ``free``: the base floats.
    """
    yield from _massless(robot, free)
    yield from _impossible(robot)


def _massless(robot: Robot, free: bool) -> Iterator[Diagnostic]:
    """Yield an error for each moving body that has no mass, or no inertia, with what is fixed to it."""
    carried = weightless(robot, free)
    if carried:
        what = f'link "{carried[0]}"{and_more(len(carried) - 1)}'
        message = f"MuJoCo loads no moving body without mass: {what}, whose mass hangs on further joints,"
        message += f" {'has' if len(carried) == 1 else 'have'} {LEAST:g} kg in the MJCF"
        yield Diagnostic("mjcf-cannot-say", NOTE, message)
    for top, names in weld_groups(robot).items():
        if top in carried:
            continue
        joint = robot.joint_to.get(top)
        inertials = [inertial for name in names if (inertial := robot.link[name].inertial) is not None]
        if (joint is None and not free) or any(map(_is_body, inertials)):
            continue
        what = f'joint "{joint.name}" moves link "{top}"' if joint else f'"base: free" lets link "{top}" move'
        lacks = "mass and inertia above zero" if inertials else "a mass"
        message = f"{what}, but neither it nor a link fixed to it has {lacks}: MuJoCo does not load that"
        way_out = "make the joint fixed" if joint else 'say "base: fixed"'
        given = "another inertial" if inertials else "an inertial"
        yield Diagnostic("mjcf-needs-mass", ERROR, message, help=f'give "{top}" {given}, or {way_out}')


def _is_body(inertial: Inertial) -> bool:
    return inertial.mass >= LEAST and principal_moments(inertial)[0] >= LEAST


def _impossible(robot: Robot) -> Iterator[Diagnostic]:
    """Yield an error for each inertia that MuJoCo loads on no link, a warning for each that it takes for another."""
    fine: set[int] = set()  # inertials, which many links may share
    for link in robot.links:
        if link.inertial is None or id(link.inertial) in fine or not has_mass(link.inertial):
            continue
        low, middle, high = principal_moments(link.inertial)
        products = has_products(link.inertial) and any(along_link_of(link.inertial)[3:])
        taken_for_zero = link.inertial.mass < 0 or (low < 0 and not products)
        if taken_for_zero:
            message = f'MuJoCo takes the negative mass or moments of link "{link.name}" for zero'
            yield Diagnostic("mjcf-cannot-say", WARNING, message, help="correct them")
        if (low if products else max(low, 0.0)) + middle < high:
            why = "the largest of its principal moments is more than the sum of the others"
        elif low < LEAST_EIGENVALUE and products:
            why = "it has products, and a principal moment of zero"
        else:
            if not taken_for_zero:
                fine.add(id(link.inertial))
            continue
        message = f'MuJoCo does not load the inertia of link "{link.name}": {why}'
        yield Diagnostic("mjcf-refused-inertia", ERROR, message, help="correct it, or take mjcf out of outputs")
