"""What simulators make of a URDF that no schema finds: missing masses, and damping that explicit steps cannot take."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from rosorin_compile.model import Inertial, Joint, Output, Robot, Transform
from rosorin_compile.model.cached import of_robot
from rosorin_compile.model.geometry import dot, minus, unit
from rosorin_compile.model.mass import together
from rosorin_compile.model.sections import sections_in_urdf
from rosorin_compile.rules.case import Case, number
from rosorin_compile.source.diagnostics import NOTE, WARNING, Diagnostic, Span
from rosorin_compile.source.rule_registry import FORMATS, Rule
from rosorin_compile.source.wording import counted

from .content import elements_of, joints_of

RULES = (
    Rule(
        "urdf-without-mass",
        "A note: `elements` leaves the inertials of links out of the URDF, and no other output is a URDF that has them:"
        " Gazebo reads it as an empty model, other simulators invent masses.",
        "[A second URDF for simulators](artifacts.md#a-urdf-for-simulators), or `accept` it with its reason.",
        FORMATS,
    ),
    Rule(
        "explicit-damping-unstable",
        "A warning: a joint of a URDF damps so light a part that a simulator with explicit steps of 1/240 s, such as "
        "PyBullet, throws it out of the world: damping * step > 2 * inertia.",
        "The damping of a servo belongs to its `actuator`, which no URDF has; else damp less, or correct the mass.",
        FORMATS,
        accept="joint",
        imported="always",
    ),
)

STEP = 1 / 240  # s, that of PyBullet if nobody sets another; Gazebo has 1/1000


def check(case: Case, output: Output) -> Iterator[Diagnostic]:
    """Validate an output of a URDF and return diagnostics."""
    others = [one for one in case.robot.outputs if one.backend == output.backend]
    has_inertials = "inertial" in elements_of(output)
    heavy = sum(link.inertial is not None and link.inertial.mass > 0 for link in case.robot.links)
    if heavy and not has_inertials and not any("inertial" in elements_of(one) for one in others):
        message = f"{output.file} leaves out {counted(heavy, 'inertial')}: Gazebo reads it as an empty model, and other"
        message += " simulators invent masses"
        help = "give simulators a second URDF, or accept urdf-without-mass with its reason"
        yield case.problem("urdf-without-mass", message, ("outputs", output.name, "elements"), help, severity=NOTE)
    if case.robot.is_tree and has_inertials and "dynamics" in elements_of(output):
        yield from _damping(case, joints_of(case.robot, output))
    for section in sections_in_urdf(output):
        if section.check_urdf is not None:
            yield from section.check_urdf(case, output)


def _damping(case: Case, joints: tuple[Joint, ...]) -> Iterator[Diagnostic]:
    """Find joints whose damping is unstable in explicit steps, even with all that hangs on them held together.

    A step of ``dt`` takes ``damping * dt / inertia`` of a speed away; if that is more than twice of it, each step is
    faster than the one before. MuJoCo and Drake damp implicitly: all is stable. A URDF has no inertia of rotors.
    """
    places: dict[Span | None, list[tuple[float, Joint, float]]] = {}
    for joint in joints:
        damping = joint.dynamics.damping if joint.dynamics is not None and joint.moves else 0.0
        inertia = _moved_inertia(case.robot).get(joint.child, 0.0) if damping > 0 else 0.0
        if inertia > 0 and damping * STEP > 2 * inertia:
            span = case.related("", case.joint(joint, "dynamics", "damping")).span
            places.setdefault(span, []).append((inertia / damping, joint, inertia))
    for found in places.values():
        ratio, joint, inertia = min(found, key=lambda one: one[0])
        units = ("N*s/m", "kg") if joint.type == "prismatic" else ("N*m*s/rad", "kg*m^2")
        path = case.joint(joint, "dynamics", "damping")
        more = f"; so are {counted(len(found) - 1, 'other joint')}" if len(found) > 1 else ""
        message = f'joint "{joint.name}" has a damping of {number(inertia / ratio)} {units[0]}{case.stands_in(path)} on'
        message += f" {number(inertia)} {units[1]}: unstable in the explicit steps of PyBullet{more}"
        help = "give the damping of a servo to its actuator, which no URDF has: actuator: {damping: ...}; it is stable"
        help += f" up to {number(2 * inertia / STEP)} at 1/240 s"
        yield case.problem("explicit-damping-unstable", message, path, help, severity=WARNING)


@of_robot
def _moved_inertia(robot: Robot) -> Mapping[str, float]:
    """Return the inertia of what each joint moves with all that hangs on it, by child, where joints are at zero.

    For a joint that turns, the inertia about its axis (kg*m^2); for one that slides, the mass (kg).
    """
    found: dict[str, float] = {}
    below: dict[str, list[tuple[Inertial, Transform]]] = {}
    try:
        poses = robot.poses_in_root({}) if robot.mimics_resolve else {}
    except ValueError:  # a joint without an axis: reported where it is written
        poses = {}
    for link in reversed(list(robot.walk())) if poses else ():
        parts, joint, pose = below.pop(link.name, []), robot.joint_to.get(link.name), poses[link.name]
        parts += [(link.inertial, pose)] if link.inertial is not None else []
        if not parts or joint is None:
            continue
        try:
            i = together(parts)  # along the axes of the root
        except ValueError:  # no mass: reported where it is written
            continue
        below.setdefault(joint.parent, []).append((i, Transform()))
        if joint.moves:
            axis, place = pose.rotate(unit(joint.axis)), i.pose.transform()
            x, y, z = place.inverse().rotate(axis)
            about = i.ixx * x * x + i.iyy * y * y + i.izz * z * z + 2 * (i.ixy * x * y + i.ixz * x * z + i.iyz * y * z)
            way = minus(place.xyz, pose.xyz)
            about += i.mass * max(0.0, dot(way, way) - dot(axis, way) ** 2)
            found[link.name] = i.mass if joint.type == "prismatic" else about
    return found
