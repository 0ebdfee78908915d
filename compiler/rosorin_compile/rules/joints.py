"""Joints: axes, limits and their units, and what has no effect on a joint of its type."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial

from rosorin_compile.language.schema import joint_unit, subject
from rosorin_compile.model import Joint, Limit
from rosorin_compile.model.geometry import norm
from rosorin_compile.source.diagnostics import WARNING, Diagnostic
from rosorin_compile.source.rule_registry import JOINTS, Check, rule
from rosorin_compile.source.tree import Path, at, exists
from rosorin_compile.source.units import Quantity, describe, parse_unit
from rosorin_compile.source.wording import listed

from .case import Case, joints_by_value, number

# Axes that were measured, printed to five digits, miss 1 by about 1e-5.
AXIS_TOLERANCE = 1e-3
ZERO_AXIS = 1e-9

_WITHOUT_EFFECT = {
    "fixed": ("axis", "limit", "dynamics", "actuator", "calibration", "safety_controller"),
    "floating": ("axis", "limit", "actuator", "calibration", "safety_controller"),
    "ball": ("axis", "limit", "actuator", "calibration", "safety_controller"),
    "planar": ("actuator",),
}


@rule("axis-zero", "An axis is zero: no direction.", "Name one, such as `[0, 0, 1]`.", JOINTS)
@rule(
    "axis-not-unit",
    "An axis is not of unit length; readers differ in what they make of it.",
    "The message gives the same direction with length 1.",
    JOINTS,
    accept="joint",
    imported="always",
)
def axes(case: Case) -> Iterator[Diagnostic]:
    """Axes that are zero, or not of unit length. Readers differ in whether they normalise."""
    return joints_by_value(case.robot).problems(partial(_axis, case))


def _axis(case: Case, joint: Joint) -> Iterator[Diagnostic]:
    if joint.is_fixed or joint.is_axleless:
        return
    length = norm(joint.axis)
    path = case.joint(joint, "axis")
    if length < ZERO_AXIS:
        help = "name the direction, such as [0, 0, 1]"
        yield case.problem("axis-zero", f'the axis of joint "{joint.name}" is zero: no direction', path, help)
    elif abs(length - 1) > AXIS_TOLERANCE:
        unit = ", ".join(number(c / length + 0.0) for c in joint.axis)
        message = f'the axis of joint "{joint.name}" has length {number(length)}, not 1'
        yield case.problem("axis-not-unit", message, path, f"the same direction with length 1: [{unit}]")


@rule(
    "limit-missing",
    "A revolute or prismatic joint has no limit, or a limit without `lower` and `upper`: locked in ROS, free in "
    "MuJoCo.",
    "Add them.",
    JOINTS,
    accept="joint",
    imported="lenient",
)
@rule(
    "limit-incomplete",
    "A limit lacks `effort` or `velocity`; readers of URDF refuse that.",
    "Add them.",
    JOINTS,
    accept="joint",
    imported="lenient",
)
@rule(
    "limit-swapped",
    "`lower` is above `upper`.",
    "Swap or correct them.",
    JOINTS,
    accept="joint",
    imported="lenient",
)
@rule(
    "limit-equal",
    "`lower` is `upper`: locked in ROS, free in MuJoCo.",
    "Make the joint fixed, or give it room.",
    JOINTS,
    accept="joint",
    imported="always",
)
@rule(
    "limit-negative",
    "`effort` or `velocity` is below zero.",
    "It is a size: write it without the sign.",
    JOINTS,
    accept="joint",
    imported="lenient",
)
@rule(
    "limit-zero",
    "`effort` or `velocity` is zero: unlimited in MuJoCo, none in ROS.",
    "Give the value that the joint has.",
    JOINTS,
    accept="joint",
    imported="always",
)
@rule(
    "limit-on-continuous",
    "A continuous joint has `lower` or `upper`.",
    "Make it revolute, or remove them.",
    JOINTS,
    accept="joint",
    imported="always",
)
def limits(case: Case) -> Iterator[Diagnostic]:
    """Limits that readers of URDF ask for and that are missing, and limits that no joint can have."""
    return joints_by_value(case.robot).problems(partial(_limit, case))


def _limit(case: Case, joint: Joint) -> Iterator[Diagnostic]:
    if joint.type in ("revolute", "prismatic") and joint.limit is None:
        help = "add limit: {lower: , upper: , effort: , velocity: }"
        if joint.type == "revolute":
            help += ", or make it continuous"
        message = f'joint "{joint.name}" is {joint.type} and has no limit'
        yield case.problem("limit-missing", message, case.joint(joint, "limit"), help)
    elif (joint.moves or joint.type == "planar") and joint.limit is not None:
        yield from _missing(case, joint, joint.limit)
        yield from _span(case, joint, joint.limit)
        yield from _strength(case, joint, joint.limit)


def _missing(case: Case, joint: Joint, limit: Limit) -> Iterator[Diagnostic]:
    path = case.joint(joint, "limit")
    ends = ["lower", "upper"] if joint.type in ("revolute", "prismatic") else []
    missing = [key for key in (*ends, "effort", "velocity") if getattr(limit, key) is None]
    if not missing:
        return
    message = f'the limit of joint "{joint.name}" lacks {listed(missing)}'
    if {"lower", "upper"} & set(missing):
        rule, why = "limit-missing", "without lower and upper it is locked in ROS and free in MuJoCo"
    else:
        rule, why = "limit-incomplete", "readers of URDF refuse a limit without effort and velocity"
    yield case.problem(rule, message, path, f"add {listed(missing)}: {why}", within=True)


def _span(case: Case, joint: Joint, limit: Limit) -> Iterator[Diagnostic]:
    path, unit = case.joint(joint, "limit"), "rad" if joint.type in ("revolute", "continuous") else "m"
    if joint.type == "continuous":
        for key in ("lower", "upper"):
            if getattr(limit, key) is not None:
                message = f'joint "{joint.name}" is continuous: it turns without end and has no {key} limit'
                help = "make it revolute, or remove lower and upper"
                yield case.problem("limit-on-continuous", message, (*path, key), help, key=True)
                return
        return
    if limit.lower is None or limit.upper is None or limit.lower < limit.upper:
        return
    lower, upper = f"lower limit {number(limit.lower)} {unit}", f"upper limit {number(limit.upper)} {unit}"
    related = [case.related("the upper limit", (*path, "upper"))]
    if limit.lower > limit.upper:
        message = f'the {lower} of joint "{joint.name}" is above its {upper}'
        yield case.problem("limit-swapped", message, (*path, "lower"), "swap or correct them", related=related)
    else:
        message = f'the {lower} of joint "{joint.name}" is its {upper}: locked in ROS, free in MuJoCo'
        help = "make the joint fixed, or give it room to move"
        yield case.problem("limit-equal", message, (*path, "lower"), help, related=related)


def _strength(case: Case, joint: Joint, limit: Limit) -> Iterator[Diagnostic]:
    """Yield what is wrong with effort and velocity."""
    units = {"effort": ("N*m", "N"), "velocity": ("rad/s", "m/s")}
    zero = {
        "effort": "no force in ROS, unlimited force in MuJoCo",
        "velocity": "a controller that keeps to it never moves the joint",
    }
    for key, (turning, sliding) in units.items():
        value: float | None = getattr(limit, key)
        path = case.joint(joint, "limit", key)
        if value is not None and value < 0:
            unit = sliding if joint.type in ("prismatic", "planar") else turning
            message = f'the {key} limit of joint "{joint.name}" is {number(value)} {unit}, below zero'
            yield case.problem("limit-negative", message, path, "it is a size: write it without the sign")
        elif value == 0:
            message = f'the {key} limit of joint "{joint.name}" is zero: {zero[key]}'
            yield case.problem("limit-zero", message, path, f"give the {key} that the joint really has")


@Check
def units(case: Case) -> Iterator[Diagnostic]:
    """Quantities with the unit of another type of joint: a slide in radians, a hinge in metres."""
    yield from joints_by_value(case.robot).problems(partial(_units, case))
    for pose in case.robot.poses:
        for name in pose.positions:
            if name in case.robot.joint and case.robot.joint[name].moves:
                yield from _unit(case, case.robot.joint[name], ("poses", pose.name, "positions", name))


def _units(case: Case, joint: Joint) -> Iterator[Diagnostic]:
    entry = (at(case.tree, case.joint(joint)) or {}) if joint.moves else {}
    for part in ("limit", "dynamics", "actuator", "mimic", "calibration", "safety_controller"):
        for key, value in (entry.get(part) or {}).items():
            if isinstance(value, Quantity):
                yield from _unit(case, joint, case.joint(joint, part, key))


def _unit(case: Case, joint: Joint, path: Path) -> Iterator[Diagnostic]:
    value = at(case.tree, path)
    leader = case.robot.joint.get(joint.mimic.joint) if joint.mimic is not None else None
    wanted = joint_unit(path, joint.type == "prismatic", leader.type == "prismatic" if leader is not None else None)
    unit = parse_unit(wanted) if wanted is not None else None
    if not isinstance(value, Quantity) or unit is None or unit[1] == value.dimension:
        return
    follows = "" if path[-1] != "multiplier" or leader is None else f" that follows a {leader.type} one"
    message = f"{subject(list(path))} is {describe(unit[1])} for a {joint.type} joint{follows}, but "
    message += f"{value.text or number(value)} is {describe(value.dimension)}"
    way = f"write it in {wanted}" if wanted else "write the number alone"
    yield case.problem("wrong-unit", message, path, f"{way}, or correct the type of the joint")


@rule(
    "ignored-key",
    "A warning: something that is said has no effect, such as the axis of a fixed joint, or `xyz` of a part of which "
    "nothing is on the mount.",
    "Remove it, or correct the type of the joint.",
    JOINTS,
)
def without_effect(case: Case) -> Iterator[Diagnostic]:
    """Find what means nothing on a joint of its type, and in a shape that only has a mass."""
    for joint in case.robot.joints:
        keys = _WITHOUT_EFFECT.get(joint.type, ())
        path = case.joint(joint) if keys else ("",)
        for key in keys if path[0] == "joints" else ():
            if exists(case.tree, (*path, key)):
                message = f'joint "{joint.name}" is {joint.type}: its {key} has no effect'
                help = f"remove {key}, or correct the type of the joint"
                yield case.problem("ignored-key", message, (*path, key), help, severity=WARNING, key=True)
    for link in case.robot.links:
        path = case.link(link.name, "inertial", "of")
        shapes = at(case.tree, path)
        for index, shape in enumerate(shapes if isinstance(shapes, list) else ()):
            for key in ("contact", "mjcf", "urdf_elements"):
                if key in shape:
                    message = f'a shape of the inertial of link "{link.name}" only has a mass: its {key} has no effect'
                    help = f"move {key} to a collision shape, or to a visual"
                    yield case.problem("ignored-key", message, (*path, index, key), help, severity=WARNING, key=True)
