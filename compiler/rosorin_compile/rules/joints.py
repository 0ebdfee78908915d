"""Joints: axes, limits and their units, signs, and keys that have no effect or contradict each other."""

from __future__ import annotations

import math
from collections.abc import Iterator

from rosorin_compile.language.schema import joint_unit, subject
from rosorin_compile.model import Cylinder, Joint
from rosorin_compile.model.geometry import dot, norm, unit
from rosorin_compile.model.joint import Dynamics
from rosorin_compile.source.diagnostics import Diagnostic
from rosorin_compile.source.rule_registry import JOINTS, SIMULATED, Check, rule
from rosorin_compile.source.tree import at, exists
from rosorin_compile.source.units import Quantity, describe, parse_unit
from rosorin_compile.source.wording import first_of, listed

from .case import Case, number

AXIS_TOLERANCE = 1e-3  # axes that were measured, printed to five digits, miss 1 by about 1e-5
ZERO_AXIS = 1e-9
DEFAULT_AXIS = (1.0, 0.0, 0.0)
ALONG = 0.9  # cosine: an axle within 25 degrees of an axis is parallel to it
SHOWN = 8
ROUNDING = 1e-6  # relative, of numbers that are read from a file which has both
_SEVERAL = ("axis", "limit", "actuator", "calibration", "safety_controller")
_WITHOUT_EFFECT = {"fixed": (*_SEVERAL, "dynamics"), "floating": _SEVERAL, "ball": _SEVERAL, "planar": ("actuator",)}


@rule("axis-zero", "An axis is zero: no direction.", "Name one, such as `[0, 0, 1]`.", JOINTS)
@rule("axis-not-unit", "An axis is not of unit length.", "Scale it to length 1.", JOINTS, "joint", "always")
def axes(case: Case) -> Iterator[Diagnostic]:
    """Validate axes; readers differ in whether they normalise."""
    for joint in case.robot.joints:
        length, path = norm(joint.axis), case.joint(joint, "axis")
        if joint.is_fixed or joint.is_axleless or abs(length - 1) <= AXIS_TOLERANCE:
            continue
        if length < ZERO_AXIS:
            yield case.problem("axis-zero", f'the axis of joint "{joint.name}" is zero: no direction', path)
        else:
            direction = ", ".join(number(c / length + 0.0) for c in joint.axis)
            message = f'the axis of joint "{joint.name}" has length {number(length)}, not 1'
            yield case.problem("axis-not-unit", message, path, f"the same direction with length 1: [{direction}]")


@rule("limit-missing", "A joint has no `lower` and `upper` limit.", "Add them.", JOINTS, "joint", "lenient")
@rule("limit-incomplete", "A limit lacks `effort` or `velocity`.", "Add them.", JOINTS, "joint", "lenient")
@rule("limit-swapped", "`lower` is above `upper`.", "Swap or correct them.", JOINTS, "joint", "lenient")
@rule("limit-equal", "`lower` is `upper`: locked in ROS, free in MuJoCo.", "Make it fixed.", JOINTS, "joint", "always")
@rule("limit-negative", "`effort` or `velocity` is below zero.", "Drop the sign.", JOINTS, "joint", "lenient")
@rule("limit-zero", "`effort` or `velocity` is zero.", "Give the real value.", JOINTS, "joint", "always")
@rule("limit-on-continuous", "A continuous joint has limits.", "Make it revolute.", JOINTS, "joint", "always")
def limits(case: Case) -> Iterator[Diagnostic]:
    """Validate limits: readers of URDF require some, and no joint can have others."""
    for joint in case.robot.joints:
        path, limit, called = case.joint(joint, "limit"), joint.limit, f'joint "{joint.name}"'
        is_bounded = joint.type in ("revolute", "prismatic")
        if limit is None and is_bounded:
            help = "add limit: {lower: , upper: , effort: , velocity: }, or make a revolute joint continuous"
            yield case.problem("limit-missing", f"{called} is {joint.type} and has no limit", path, help)
        if limit is None or not (joint.moves or joint.type == "planar"):
            continue
        keys = ("lower", "upper", "effort", "velocity") if is_bounded else ("effort", "velocity")
        missing = [key for key in keys if getattr(limit, key) is None]
        if missing:
            id = "limit-missing" if {"lower", "upper"} & set(missing) else "limit-incomplete"
            message = f"the limit of {called} lacks {listed(missing)}, which readers of URDF require"
            yield case.problem(id, message, path, f"add {listed(missing)}", within=True)
        lower, upper = limit.lower, limit.upper
        if joint.type == "continuous":
            key = "lower" if lower is not None else "upper"
            if getattr(limit, key) is not None:
                message = f"{called} is continuous: it turns without end and has no {key} limit"
                yield case.problem("limit-on-continuous", message, (*path, key), key=True)
        elif lower is not None and upper is not None and lower >= upper:
            id, what = ("limit-swapped", "above") if lower > upper else ("limit-equal", "equal to")
            message = f"the lower limit {number(lower)} of {called} is {what} its upper limit {number(upper)}"
            related = [("the upper limit", (*path, "upper"))]
            yield case.problem(id, f"{message} {joint.unit}", (*path, "lower"), related=related)
        for key in ("effort", "velocity"):
            value = getattr(limit, key)
            if value is not None and value <= 0:
                message = f"the {key} limit of {called} is {number(value)}"
                yield case.problem("limit-negative" if value < 0 else "limit-zero", message, (*path, key))


@Check
def units(case: Case) -> Iterator[Diagnostic]:
    """Quantities with the unit of another type of joint: a slide in radians, a hinge in metres."""
    joints = [joint for joint in case.robot.joints if joint.moves]
    paths = [
        (joint, case.joint(joint, part, key))
        for joint in joints
        for part in ("limit", "dynamics", "actuator", "mimic", "calibration", "safety_controller")
        for key in at(case.tree, case.joint(joint, part)) or ()
    ]
    paths += [
        (case.robot.joint[name], ("poses", pose.name, "positions", name))
        for pose in case.robot.poses
        for name in pose.positions
        if name in case.robot.joint and case.robot.joint[name].moves
    ]
    for joint, path in paths:
        value = at(case.tree, path)
        leader = case.robot.joint.get(joint.mimic.joint) if joint.mimic is not None else None
        expected = joint_unit(path, joint.type == "prismatic", leader.type == "prismatic" if leader else None)
        parsed = parse_unit(expected) if expected is not None else None
        if isinstance(value, Quantity) and parsed is not None and parsed[1] != value.dimension:
            message = f"{subject(list(path))} is {describe(parsed[1])} for a {joint.type} joint, but "
            message += f"{value.text or number(value)} is {describe(value.dimension)}"
            way = f"write it in {expected}" if expected else "write the number alone"
            yield case.problem("wrong-unit", message, path, f"{way}, or correct the type of the joint")


@rule("ignored-key", help="Remove it, or correct the type of the joint.", topic=JOINTS)
def without_effect(case: Case) -> Iterator[Diagnostic]:
    """A warning: a key has no effect, such as the axis of a fixed joint."""
    for joint in case.robot.joints:
        path = case.joint(joint)
        for key in _WITHOUT_EFFECT.get(joint.type, ()) if path[0] == "joints" else ():
            if exists(case.tree, (*path, key)):
                message = f'joint "{joint.name}" is {joint.type}: its {key} has no effect'
                yield case.problem("ignored-key", message, (*path, key), key=True)
    for link in case.robot.links:
        path = case.link(link.name, "inertial", "of")
        shapes = at(case.tree, path)
        for index, shape in enumerate(shapes if isinstance(shapes, list) else ()):
            for key in [key for key in ("contact", "mjcf", "urdf_elements") if key in shape]:
                message = f'a shape of the inertial of link "{link.name}" only has a mass: its {key} has no effect'
                help = f"move {key} to a collision shape, or to a visual"
                yield case.problem("ignored-key", message, (*path, index, key), help, key=True)


@rule("dynamics-negative", "Damping, friction or a gain is below zero.", "Drop the sign.", JOINTS, "joint", "always")
def negative(case: Case) -> Iterator[Diagnostic]:
    """Validate the signs of what simulations and servos read."""
    for joint in case.robot.joints:
        if joint.limit is not None and min(joint.limit.effort or 0, joint.limit.velocity or 0) < 0:
            continue  # a part calculates the others from it
        owners = [("dynamics", key, joint.dynamics) for key in ("damping", "friction", "armature", "stiffness")]
        owners += [("actuator", key, joint.actuator) for key in ("damping", "kp", "kv")]
        values = [(part, key, getattr(owner, key, 0.0) or 0.0) for part, key, owner in owners]
        values.append(("mjcf", "springyield", joint.mjcf.get("springyield", 0.0)))
        pair = _numbers(joint, "springdamper")
        values.append(("mjcf", "springdamper", -1.0 if any(pair) and min(pair) <= 0 else 0.0))
        for part, key, value in values:
            if value < 0:
                path = case.joint(joint, part, key)
                shown = "not above zero" if key == "springdamper" else f"{number(value)}{case.stands_in(path)}"
                yield case.problem("dynamics-negative", f'the {key} of joint "{joint.name}" is {shown}', path)


@rule("axis-missing", "A note: moving joints have no axis: x, the default.", "Write `axis: [0, 0, 1]`.", JOINTS)
@rule("axis-across", "A warning: the axis of a joint is across its wheel.", "Correct it.", JOINTS, "joint", "always")
def missing_axes(case: Case) -> Iterator[Diagnostic]:
    """Find joints without an axis: one note for all, but for wheels that would tumble."""
    others = []
    for joint in case.robot.joints:
        is_default = (joint.moves or joint.type == "planar") and joint.axis == DEFAULT_AXIS
        if is_default and not exists(case.tree, case.joint(joint, "axis")):
            if joint.type == "continuous" and lies_across(case, joint):
                message = f'joint "{joint.name}" has no axis and turns "{joint.child}" about x, across that wheel'
                help = "write the axis, such as axis: [0, 1, 0]"
                yield case.problem("axis-across", message, case.joint(joint), help, key=True)
            else:
                others.append(joint)
    if others:
        names = first_of([f'"{joint.name}"' for joint in others], SHOWN)
        message = f"no axis: {names} {'turns' if len(others) == 1 else 'turn'} about x of the child, [1, 0, 0]"
        yield case.problem("axis-missing", message, case.joint(others[0]), key=True)


def lies_across(case: Case, joint: Joint) -> bool:
    """Return True if the child of a joint is one disc, shorter than it is wide, across the axis of the joint."""
    link = case.robot.link.get(joint.child)
    shapes = (link.collision or link.visual) if link is not None else ()
    if len(shapes) != 1 or not isinstance(shapes[0].geometry, Cylinder) or not any(joint.axis):
        return False
    disc, rows = shapes[0].geometry, shapes[0].pose.transform().rows
    return disc.length < 2 * disc.radius and abs(dot(unit(joint.axis), (rows[0][2], rows[1][2], rows[2][2]))) < ALONG


# --- keys of MuJoCo that contradict those of the language ---


@rule("joint-word", help="Leave one of them out.", topic=SIMULATED)
def contradictions(case: Case) -> Iterator[Diagnostic]:
    """The `mjcf` of a joint contradicts its other keys: formats would differ in what they take."""
    for joint in case.robot.joints:
        path = case.joint(joint)
        for word, other, value in _contradictions(joint) if joint.mjcf and not joint.is_fixed else ():
            message = f'joint "{joint.name}" has another {word} in mjcf than {".".join(other)}, {number(value)}'
            related = [("the other one", (*path, *other))]
            yield case.problem("joint-word", message, (*path, "mjcf", word), related=related, key=True)
        if joint.type == "continuous" and "range" in joint.mjcf:
            message = f'joint "{joint.name}" is continuous, and has a range in mjcf'
            yield case.problem("joint-word", message, (*path, "mjcf", "range"), key=True)


def _contradictions(joint: Joint) -> Iterator[tuple[str, tuple[str, str], float]]:
    """Yield the keys of ``mjcf`` that differ from other keys, with the path and the value of those."""
    dynamics, drive = joint.dynamics or Dynamics(), joint.actuator.damping if joint.actuator else 0.0
    pair = _numbers(joint, "springdamper")
    for word, value in (("stiffness", dynamics.stiffness), ("damping", joint.braking)):
        other = ("actuator" if word == "damping" and drive else "dynamics", word)
        values, theirs = _numbers(joint, word), drive if other[0] == "actuator" else value
        if value and values and not _same(values[0], value):
            yield word, other, theirs
        if value and pair and min(pair) > 0:  # MuJoCo makes another one of springdamper
            yield "springdamper", other, theirs
    limit = joint.limit if joint.moves else None
    known = (limit.lower, limit.upper) if limit and joint.type != "continuous" else ()
    for mine, end, key in zip(_numbers(joint, "range"), known, ("lower", "upper"), strict=False):
        if end is not None and not _same(mine, end):
            yield "range", ("limit", key), end
            break
    force = _numbers(joint, "actuatorfrcrange")
    if force and limit and limit.effort is not None and not _same(max(map(abs, force)), limit.effort):
        yield "actuatorfrcrange", ("limit", "effort"), limit.effort


def _numbers(joint: Joint, word: str) -> tuple[float, ...]:
    value = joint.mjcf.get(word)
    return tuple(map(float, value)) if isinstance(value, tuple) else ()


def _same(value: float, other: float) -> bool:
    return math.isclose(value, other, rel_tol=ROUNDING, abs_tol=ROUNDING**2)
