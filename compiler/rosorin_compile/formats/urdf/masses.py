"""Masses of a URDF: of which joints and links it is, what each of them weighs, and who will not read one without.

robot_state_publisher and planners need no masses. libsdformat drops every link without one, and so Gazebo reads a URDF
without any as an empty model; PyBullet takes 1 kg for each link without an inertial, MuJoCo 1 g for each cm^3 of its
shapes (run with libsdformat 12, PyBullet 3.2.7, MuJoCo 4). None of them does where the inertial is there and zero.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING

from rosorin_compile.model import Inertial, Joint, Output, Robot
from rosorin_compile.model.cached import of_robot
from rosorin_compile.model.geometry import IDENTITY
from rosorin_compile.source.diagnostics import NOTE, Diagnostic, error
from rosorin_compile.source.rule_registry import FORMATS, Rule
from rosorin_compile.source.wording import counted, quoted

if TYPE_CHECKING:
    from rosorin_compile.rules.case import Case

RULES = (
    Rule(
        "urdf-without-mass",
        "A note: `elements` leaves the inertials of links out of the URDF, and no other output is a URDF that has them:"
        " Gazebo reads it as an empty model, other simulators invent masses.",
        "[A second URDF for simulators](artifacts.md#a-urdf-for-simulators), or `accept` it with its reason.",
        FORMATS,
    ),
    Rule(
        "urdf-mass-sum",
        "Masses that move to one link of the URDF are together no number.",
        "Correct them.",
        FORMATS,
    ),
)

INERTIAL = "inertial"
PUBLISHED, ALL, BODIES = FRAMES = ("published", "all", "bodies")
_NOTHING = Inertial(0.0, IDENTITY, 0.0, 0.0, 0.0)


def frames_of(output: Output) -> str:
    """Return which frames an output has: those that robot_state_publisher knows, all, or those of bodies."""
    return str(output.options.get("frames", PUBLISHED))


def joints_of(robot: Robot, output: Output) -> tuple[Joint, ...]:
    """Return the joints that an output has, in the order of the description."""
    if frames_of(output) == BODIES:
        bodies = _bodies(robot)
        return tuple(joint for joint in robot.joints if joint.parent in bodies and joint.child in bodies)
    return robot.joints if frames_of(output) == ALL else robot.in_urdf()


def links_of(robot: Robot, output: Output) -> frozenset[str]:
    """Return the links that an output has; without any joints its topmost."""
    return _links(robot, frames_of(output))


@of_robot
def _links(robot: Robot, frames: str) -> frozenset[str]:
    if frames == BODIES:
        return _bodies(robot)
    joints = robot.joints if frames == ALL else robot.in_urdf()
    ends = frozenset(name for joint in joints for name in (joint.parent, joint.child))
    return ends or frozenset([robot.root])


def _bodies(robot: Robot) -> frozenset[str]:
    """Return the links that have a mass, those that a joint moves, and those that hold them together."""
    kept: set[str] = set()
    for link in reversed(list(robot.walk())):
        joint = robot.joint_to.get(link.name)
        if link.name in kept or link.inertial is not None or (joint is not None and not joint.is_fixed):
            kept |= {link.name, joint.parent} if joint is not None else {link.name}
    top = robot.root
    while robot.link[top].inertial is None:
        below = [joint for joint in robot.joints_from.get(top, ()) if joint.child in kept]
        if len(below) != 1 or not below[0].is_fixed:
            break
        kept.discard(top)
        top = below[0].child
    return frozenset(kept) or frozenset([robot.root])


def has_inertials(output: Output) -> bool:
    """Say whether an output has the inertials of links."""
    return INERTIAL in output.options.get("elements", (INERTIAL,))


def inertials(robot: Robot, output: Output) -> Mapping[str, Inertial]:
    """Return what the links of an output weigh, with what each carries. Raises ValueError as ``inertials_at``.

    Where an output is of bodies, a link that only holds others together has a mass of zero, or simulators invent one.
    """
    return _inertials(robot, frames_of(output)) if has_inertials(output) else {}


@of_robot
def _inertials(robot: Robot, frames: str) -> Mapping[str, Inertial]:
    links = _links(robot, frames)
    found = robot.inertials_at(links)
    return {**dict.fromkeys(links, _NOTHING), **found} if frames == BODIES else found


def too_much(problem: ValueError) -> Diagnostic:
    """Return the error about masses that are together no number."""
    return error("urdf-mass-sum", f"in the URDF some masses move to one link: {problem}", None, "correct them")


def standing_still(robot: Robot, carried: frozenset[str]) -> Iterator[Diagnostic]:
    """Yield a note on links whose mass is in the URDF, but not the joints that move it."""
    names = []
    for name, (carrier, _) in robot.carriers(frozenset(carried)).items():
        if name != carrier and robot.link[name].inertial is not None and robot.moves_between(name, carrier):
            names.append(name)
    if names:
        which = f"{'link' if len(names) == 1 else 'links'} {quoted(names, 3)}"
        message = f"the mass of {which} stands still in the URDF, where the joints at zero put it:"
        message += " robot_state_publisher does not publish what moves it"
        yield Diagnostic("urdf-cannot-say", NOTE, message, help='"frames: bodies" has these joints, for simulators')


def check(case: Case, output: Output) -> Iterator[Diagnostic]:
    """Find an output without inertials, of a robot that has them and no other URDF."""
    others = (one for one in case.robot.outputs if one.backend == output.backend)
    if has_inertials(output) or any(map(has_inertials, others)):
        return
    heavy = sum(link.inertial is not None and link.inertial.mass > 0 for link in case.robot.links)
    if heavy:
        message = f"{output.file} leaves out {counted(heavy, 'inertial')}: Gazebo reads it as an empty model, and other"
        message += " simulators invent masses"
        help = "give simulators a second URDF, or accept urdf-without-mass with its reason"
        yield case.problem("urdf-without-mass", message, ("outputs", output.name, "elements"), help, severity=NOTE)
