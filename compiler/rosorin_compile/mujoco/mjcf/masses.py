"""Masses and inertias in the terms of MuJoCo, and which of them it does not load."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from rosorin_compile.model import Inertial, Robot
from rosorin_compile.model.cached import of_robot
from rosorin_compile.model.mass import Inertia, along_link
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
    top_of = {name: top for top, names in groups.items() for name in names}
    massive = {top_of[link.name] for link in robot.links if link.inertial is not None and has_mass(link.inertial)}
    heavy: set[str] = set()
    without = []
    for top in reversed(groups):
        joint = robot.joint_to.get(top)
        if top in heavy and top not in massive and (free or top != robot.root):  # the root is moved by no joint
            without.append(top)
        if joint is not None and (top in heavy or any(map(_is_body, _inertials(robot, groups[top])))):
            heavy.add(top_of[joint.parent])
    return without[::-1]


def _inertials(robot: Robot, names: Sequence[str]) -> list[Inertial]:
    return [inertial for name in names if (inertial := robot.link[name].inertial) is not None]


def _is_body(inertial: Inertial) -> bool:
    return inertial.mass >= LEAST and inertial.principal_moments[0] >= LEAST


def masses(robot: Robot, free: bool) -> Iterator[Diagnostic]:
    """Yield what MuJoCo does not load, and what it takes for something else; ``free``: the base floats."""
    carried = weightless(robot, free)
    if carried:
        what = f'link "{carried[0]}"{and_more(len(carried) - 1)}'
        message = f"MuJoCo loads no moving body without mass: {what}, whose mass hangs on further joints,"
        message += f" {'has' if len(carried) == 1 else 'have'} {LEAST:g} kg in the MJCF"
        yield Diagnostic("mjcf-cannot-say", NOTE, message)
    for top, names in weld_groups(robot).items():
        joint, inertials = robot.joint_to.get(top), _inertials(robot, names)
        if top in carried or (joint is None and not free) or any(map(_is_body, inertials)):
            continue
        what = f'joint "{joint.name}" moves link "{top}"' if joint else f'"base: free" lets link "{top}" move'
        lacks = "mass and inertia above zero" if inertials else "a mass"
        message = f"{what}, but neither it nor a link fixed to it has {lacks}: MuJoCo does not load that"
        way_out = "make the joint fixed" if joint else 'say "base: fixed"'
        given = "another inertial" if inertials else "an inertial"
        yield Diagnostic("mjcf-needs-mass", ERROR, message, help=f'give "{top}" {given}, or {way_out}')
    for link in robot.links:
        if link.inertial is None or not has_mass(link.inertial):
            continue
        low, middle, high = link.inertial.principal_moments
        products = has_products(link.inertial) and any(along_link_of(link.inertial)[3:])
        if link.inertial.mass < 0 or (low < 0 and not products):
            message = f'MuJoCo takes the negative mass or moments of link "{link.name}" for zero'
            yield Diagnostic("mjcf-cannot-say", WARNING, message, help="correct them")
        why = "it has products, and a principal moment of zero" if low < LEAST_EIGENVALUE and products else ""
        if (low if products else max(low, 0.0)) + middle < high:
            why = "the largest of its principal moments is more than the sum of the others"
        if why:
            message = f'MuJoCo does not load the inertia of link "{link.name}": {why}'
            yield Diagnostic("mjcf-refused-inertia", ERROR, message, help="correct it, or take mjcf out of outputs")
