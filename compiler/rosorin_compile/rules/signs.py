"""Signs and axes: what a simulation needs to know of a joint is not below zero, and an axis is said."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial

from rosorin_compile.model import Cylinder, Joint
from rosorin_compile.model.geometry import dot, unit
from rosorin_compile.source.diagnostics import NOTE, WARNING, Diagnostic
from rosorin_compile.source.rule_registry import JOINTS, rule
from rosorin_compile.source.tree import exists
from rosorin_compile.source.wording import first_of

from .case import Case, joints_by_value, number

SHOWN = 8
UNSAID = (1.0, 0.0, 0.0)
ALONG = 0.9  # cosine: an axle within 25 degrees of an axis lies along it

_WHAT = {
    "damping": "it would drive the joint instead of braking it",
    "friction": "it would drive the joint instead of braking it",
    "armature": "no rotor has such an inertia",
    "stiffness": "the spring would push away from where it is at rest",
    "kp": "the servo would drive the joint away from where it shall be",
    "kv": "the servo would drive the joint instead of braking it",
}


@rule(
    "dynamics-negative",
    "Damping, friction, the inertia of a rotor or a gain is below zero.",
    "It is a size: write it without the sign.",
    JOINTS,
    accept="joint",
    imported="always",
)
def negative(case: Case) -> Iterator[Diagnostic]:
    """Find what a simulation knows of a joint and is below zero."""
    return joints_by_value(case.robot).problems(partial(_negative, case))


def _negative(case: Case, joint: Joint) -> Iterator[Diagnostic]:
    if joint.limit is not None and min(joint.limit.effort or 0, joint.limit.velocity or 0) < 0:
        return  # a part calculates the others from it
    for part, values in (("dynamics", joint.dynamics), ("actuator", joint.actuator)):
        for key in _WHAT:
            value = getattr(values, key, 0.0) or 0.0
            if value < 0:
                place = case.joint(joint, part, key)
                message = (
                    f'the {key} of joint "{joint.name}" is {number(value)}{case.stands_in(place)}, below zero:'
                    f" {_WHAT[key]}"
                )
                yield case.problem("dynamics-negative", message, place, "write it without the sign")


@rule(
    "axis-missing",
    "A note: joints that move say no axis, and turn about x of their frames, the default.",
    "Say it: `axis: [0, 0, 1]`.",
    JOINTS,
)
@rule(
    "axis-across",
    "A warning: the axis of a joint lies across the wheel that it turns: the default, x, or that of a wheel of the "
    "drive.",
    "Write the axis, such as `axis: [0, 1, 0]`, or turn the cylinder: `rpy: [90 deg, 0, 0]`.",
    JOINTS,
    accept="joint",
    imported="always",
)
def missing_axes(case: Case) -> Iterator[Diagnostic]:
    """Joints without an axis: in one note, but for wheels that would tumble."""
    silent: list[Joint] = []
    for joint in case.robot.joints:
        if joint.axis != UNSAID or not (joint.moves or joint.type == "planar"):
            continue
        if exists(case.tree, case.joint(joint, "axis")):
            continue
        if joint.type == "continuous" and lies_across(case, joint):
            message = (
                f'joint "{joint.name}" says no axis and turns "{joint.child}" about x, across the wheel that it is'
            )
            help = "say the axis that is meant, such as axis: [0, 1, 0]"
            yield case.problem("axis-across", message, case.joint(joint), help, severity=WARNING, key=True)
        else:
            silent.append(joint)
    if silent:
        names = first_of([f'"{joint.name}"' for joint in silent], SHOWN)
        what = f"joint {names} says" if len(silent) == 1 else f"joints {names} say"
        message = f"{what} no axis: it is x of the frame of the child, [1, 0, 0]"
        yield case.problem("axis-missing", message, case.joint(silent[0]), "say it", severity=NOTE, key=True)


def lies_across(case: Case, joint: Joint) -> bool:
    """Return True if the child of a joint is one disc, shorter than it is wide, that does not lie along its axis."""
    link = case.robot.link.get(joint.child)
    shapes = (link.collision or link.visual) if link is not None else ()
    if len(shapes) != 1 or not isinstance(shapes[0].geometry, Cylinder) or not any(joint.axis):
        return False
    disc, rows = shapes[0].geometry, shapes[0].pose.transform().rows
    return disc.length < 2 * disc.radius and abs(dot(unit(joint.axis), (rows[0][2], rows[1][2], rows[2][2]))) < ALONG
