"""Damping that a simulator with explicit steps cannot take: PyBullet reads a URDF like that.

In a step of ``dt`` it takes ``damping * dt / inertia`` of a speed away; if that is more than twice of it, each step is
faster than the one before, and the robot leaves the world at once. MuJoCo and Drake damp implicitly: all is stable.
A URDF has no inertia of rotors, so that of the links is all there is.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

from rosorin_compile.model import Inertial, Joint, Output, Robot, Transform
from rosorin_compile.model.cached import of_robot
from rosorin_compile.model.geometry import dot, unit
from rosorin_compile.model.mass import together
from rosorin_compile.rules.case import Case, number
from rosorin_compile.source.diagnostics import WARNING, Diagnostic, Span
from rosorin_compile.source.rule_registry import FORMATS, Rule
from rosorin_compile.source.wording import counted

from .masses import has_inertials, joints_of

if TYPE_CHECKING:
    from collections.abc import Mapping

RULES = (
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
_MOST = 2.0


def check(case: Case, output: Output) -> Iterator[Diagnostic]:
    """Find joints whose damping is unstable in explicit steps, even with all that hangs on them held together."""
    says = "dynamics" in output.options.get("elements", ("dynamics",))
    if not (case.robot.is_tree and has_inertials(output) and says):
        return
    places: dict[Span | None, list[tuple[float, Joint, float]]] = {}
    for joint in joints_of(case.robot, output):
        damping = joint.dynamics.damping if joint.dynamics is not None and joint.moves else 0.0
        inertia = turned(case.robot).get(joint.child, 0.0) if damping > 0 else 0.0
        if inertia > 0 and damping * STEP > _MOST * inertia:
            span = case.related("", case.joint(joint, "dynamics", "damping")).span
            places.setdefault(span, []).append((inertia / damping, joint, inertia))
    for found in places.values():
        _, joint, inertia = min(found, key=lambda one: one[0])
        yield _problem(case, joint, inertia, len(found) - 1)


def _problem(case: Case, joint: Joint, inertia: float, others: int) -> Diagnostic:
    damping = joint.dynamics.damping if joint.dynamics else 0.0
    slides = joint.type == "prismatic"
    units = ("N*s/m", "kg") if slides else ("N*m*s/rad", "kg*m^2")
    path = case.joint(joint, "dynamics", "damping")
    more = f"; so are {counted(others, 'other joint')}" if others else ""
    message = (
        f'joint "{joint.name}" has a damping of {number(damping)} {units[0]}{case.stands_in(path)} on'
        f" {number(inertia)} {units[1]}: unstable in the explicit steps of PyBullet{more}"
    )
    most = f"it is stable up to {number(_MOST * inertia / STEP)} at 1/240 s"
    help = f"give the damping of a servo to its actuator, which no URDF has: actuator: {{damping: ...}}; {most}"
    return case.problem("explicit-damping-unstable", message, path, help, severity=WARNING)


@of_robot
def turned(robot: Robot) -> Mapping[str, float]:
    """Return what each joint moves with all that hangs on it, by child, where joints are at zero.

    Of a joint that turns the inertia about its axis (kg*m^2), of one that slides the mass (kg).
    """
    below: dict[str, list[tuple[Inertial, Transform]]] = {}
    found: dict[str, float] = {}
    for link in reversed(list(robot.walk())):
        parts = below.pop(link.name, [])
        if link.inertial is not None:
            parts.append((link.inertial, Transform()))
        joint = robot.joint_to.get(link.name)
        if not parts or joint is None:
            continue
        try:
            whole = together(parts)
            place = joint.transform(_at_zero(robot, joint) if joint.moves else 0.0)
        except ValueError:  # no mass or no axis: told where it is written
            continue
        if joint.moves:
            found[link.name] = whole.mass if joint.type == "prismatic" else _about(whole, joint)
        below.setdefault(joint.parent, []).append((whole, place))
    return found


def _at_zero(robot: Robot, joint: Joint) -> float:
    """Return the position of a joint where the others are at zero; 0 of one that follows no joint, or itself."""
    leaders = [joint]
    while (mimic := leaders[-1].mimic) is not None:
        leader = robot.joint.get(mimic.joint)
        if leader is None or leader in leaders:  # told by the rules about mimics
            return 0.0
        leaders.append(leader)
    return robot.position(joint, {})


def _about(inertial: Inertial, joint: Joint) -> float:
    """Return the inertia about the axis of a joint in the frame of its child."""
    place = inertial.pose.transform()
    axis = unit(joint.axis)
    x, y, z = place.inverse().rotate(axis)
    i = inertial
    own = i.ixx * x * x + i.iyy * y * y + i.izz * z * z + 2 * (i.ixy * x * y + i.ixz * x * z + i.iyz * y * z)
    return own + i.mass * max(0.0, dot(place.xyz, place.xyz) - dot(axis, place.xyz) ** 2)
