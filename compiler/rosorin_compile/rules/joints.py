"""Joints: axes, limits and their units, signs, and keys that have no effect or contradict each other."""

from __future__ import annotations

import math
from collections.abc import Iterator

from rosorin_compile.language.schema import joint_unit, subject
from rosorin_compile.model import Cylinder, Joint, Limit
from rosorin_compile.model.geometry import dot, norm, unit
from rosorin_compile.model.joint import Dynamics
from rosorin_compile.source.diagnostics import Diagnostic
from rosorin_compile.source.rule_registry import JOINTS, SIMULATED, Check, rule
from rosorin_compile.source.tree import Path, at, exists
from rosorin_compile.source.units import Quantity, describe, parse_unit
from rosorin_compile.source.wording import first_of, listed

from .case import Case, number, per_joint

# Axes that were measured, printed to five digits, miss 1 by about 1e-5.
AXIS_TOLERANCE = 1e-3
ZERO_AXIS = 1e-9
DEFAULT_AXIS = (1.0, 0.0, 0.0)
ALONG = 0.9  # cosine: an axle within 25 degrees of an axis is parallel to it
SHOWN = 8
ROUNDING = 1e-6  # relative, of numbers that are read from a file which has both

_SEVERAL = ("axis", "limit", "actuator", "calibration", "safety_controller")
_WITHOUT_EFFECT = {
    "fixed": (*_SEVERAL, "dynamics"),
    "floating": _SEVERAL,
    "ball": _SEVERAL,
    "planar": ("actuator",),
}
_STRENGTHS = {
    "effort": ("N*m", "N", "no force in ROS, unlimited force in MuJoCo"),
    "velocity": ("rad/s", "m/s", "a controller that keeps to it never moves the joint"),
}
_NOT_NEGATIVE = {
    "damping": "it would drive the joint instead of braking it",
    "friction": "it would drive the joint instead of braking it",
    "armature": "no rotor has such an inertia",
    "stiffness": "the spring would push away from where it is at rest",
    "kp": "the servo would drive the joint away from its target",
    "kv": "the servo would drive the joint instead of braking it",
}


@rule("axis-zero", "An axis is zero: no direction.", "Name one, such as `[0, 0, 1]`.", JOINTS)
@rule("axis-not-unit", "An axis is not of unit length.", "Scale it to length 1.", JOINTS, "joint", "always")
@per_joint
def axes(case: Case, joint: Joint) -> Iterator[Diagnostic]:
    """Validate axes; readers differ in whether they normalise."""
    if joint.is_fixed or joint.is_axleless:
        return
    length, path = norm(joint.axis), case.joint(joint, "axis")
    if length < ZERO_AXIS:
        yield case.problem("axis-zero", f'the axis of joint "{joint.name}" is zero: no direction', path)
    elif abs(length - 1) > AXIS_TOLERANCE:
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
@per_joint
def limits(case: Case, joint: Joint) -> Iterator[Diagnostic]:
    """Validate limits: readers of URDF require some, and no joint can have others."""
    path, limit, called = case.joint(joint, "limit"), joint.limit, f'joint "{joint.name}"'
    if limit is None:
        if joint.type in ("revolute", "prismatic"):
            help = "add limit: {lower: , upper: , effort: , velocity: }"
            help += ", or make it continuous" if joint.type == "revolute" else ""
            yield case.problem("limit-missing", f"{called} is {joint.type} and has no limit", path, help)
        return
    if not joint.moves and joint.type != "planar":
        return
    ends = ["lower", "upper"] if joint.type in ("revolute", "prismatic") else []
    missing = [key for key in (*ends, "effort", "velocity") if getattr(limit, key) is None]
    if missing:
        id, why = "limit-incomplete", "readers of URDF refuse a limit without effort and velocity"
        if {"lower", "upper"} & set(missing):
            id, why = "limit-missing", "without lower and upper it is locked in ROS and free in MuJoCo"
        message = f"the limit of {called} lacks {listed(missing)}"
        yield case.problem(id, message, path, f"add {listed(missing)}: {why}", within=True)
    yield from _ends(case, joint, limit)
    for key, (turning, sliding, effect) in _STRENGTHS.items():
        value: float | None = getattr(limit, key)
        if value is not None and value < 0:
            strength = sliding if joint.type in ("prismatic", "planar") else turning
            message = f"the {key} limit of {called} is {number(value)} {strength}, below zero"
            yield case.problem("limit-negative", message, (*path, key), "write it without the sign")
        elif value == 0:
            message = f"the {key} limit of {called} is zero: {effect}"
            yield case.problem("limit-zero", message, (*path, key), f"give the {key} that the joint really has")


def _ends(case: Case, joint: Joint, limit: Limit) -> Iterator[Diagnostic]:
    path, lower, upper = case.joint(joint, "limit"), limit.lower, limit.upper
    if joint.type == "continuous":
        key = next((key for key in ("lower", "upper") if getattr(limit, key) is not None), "")
        if key:
            message = f'joint "{joint.name}" is continuous: it turns without end and has no {key} limit'
            help = "make it revolute, or remove lower and upper"
            yield case.problem("limit-on-continuous", message, (*path, key), help, key=True)
    elif lower is not None and upper is not None and lower >= upper:
        unit_ = "rad" if joint.type == "revolute" else "m"
        message = f'the lower limit {number(lower)} {unit_} of joint "{joint.name}" is '
        related = [("the upper limit", (*path, "upper"))]
        if lower > upper:
            message += f"above its upper limit {number(upper)} {unit_}"
            yield case.problem("limit-swapped", message, (*path, "lower"), related=related)
        else:
            message += f"its upper limit {number(upper)} {unit_}: locked in ROS, free in MuJoCo"
            help = "make the joint fixed, or give it room to move"
            yield case.problem("limit-equal", message, (*path, "lower"), help, related=related)


@Check
def units(case: Case) -> Iterator[Diagnostic]:
    """Quantities with the unit of another type of joint: a slide in radians, a hinge in metres."""
    yield from per_joint(_units)(case)
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
    expected = joint_unit(path, joint.type == "prismatic", leader.type == "prismatic" if leader is not None else None)
    parsed = parse_unit(expected) if expected is not None else None
    if not isinstance(value, Quantity) or parsed is None or parsed[1] == value.dimension:
        return
    follows = "" if path[-1] != "multiplier" or leader is None else f" that follows a {leader.type} one"
    message = f"{subject(list(path))} is {describe(parsed[1])} for a {joint.type} joint{follows}, but "
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
                help = f"remove {key}, or correct the type of the joint"
                yield case.problem("ignored-key", message, (*path, key), help, key=True)
    for link in case.robot.links:
        path = case.link(link.name, "inertial", "of")
        shapes = at(case.tree, path)
        for index, shape in enumerate(shapes if isinstance(shapes, list) else ()):
            for key in [key for key in ("contact", "mjcf", "urdf_elements") if key in shape]:
                message = f'a shape of the inertial of link "{link.name}" only has a mass: its {key} has no effect'
                help = f"move {key} to a collision shape, or to a visual"
                yield case.problem("ignored-key", message, (*path, index, key), help, key=True)


@rule("dynamics-negative", "Damping, friction or a gain is below zero.", "Drop the sign.", JOINTS, "joint", "always")
@per_joint
def negative(case: Case, joint: Joint) -> Iterator[Diagnostic]:
    """Validate the signs of what simulations and servos read."""
    if joint.limit is not None and min(joint.limit.effort or 0, joint.limit.velocity or 0) < 0:
        return  # a part calculates the others from it
    for part, values in (("dynamics", joint.dynamics), ("actuator", joint.actuator)):
        for key, effect in _NOT_NEGATIVE.items():
            value = getattr(values, key, 0.0) or 0.0
            if value < 0:
                path = case.joint(joint, part, key)
                message = f'the {key} of joint "{joint.name}" is {number(value)}{case.stands_in(path)}, below zero'
                yield case.problem("dynamics-negative", f"{message}: {effect}", path, "write it without the sign")
    path = case.joint(joint, "mjcf")
    spring, pair = joint.mjcf.get("springyield"), _numbers(joint, "springdamper")
    if isinstance(spring, float) and spring < 0:
        message = f'the springyield of joint "{joint.name}" is {number(spring)}, below zero'
        yield case.problem("dynamics-negative", message, (*path, "springyield"), "write it without the sign")
    if any(pair) and min(pair) <= 0:
        message = f'the springdamper of joint "{joint.name}" is not above zero'
        help = "write a time in s and a ratio above zero"
        yield case.problem("dynamics-negative", message, (*path, "springdamper"), help)


@rule("axis-missing", "A note: moving joints have no axis: x, the default.", "Write `axis: [0, 0, 1]`.", JOINTS)
@rule("axis-across", "A warning: the axis of a joint is across its wheel.", "Correct it.", JOINTS, "joint", "always")
def missing_axes(case: Case) -> Iterator[Diagnostic]:
    """Find joints without an axis: one note for all, but for wheels that would tumble."""
    without: list[Joint] = []
    for joint in case.robot.joints:
        if joint.axis != DEFAULT_AXIS or not (joint.moves or joint.type == "planar"):
            continue
        if exists(case.tree, case.joint(joint, "axis")):
            continue
        if joint.type == "continuous" and lies_across(case, joint):
            message = f'joint "{joint.name}" has no axis and turns "{joint.child}" about x, across the wheel that it is'
            help = "write the axis, such as axis: [0, 1, 0]"
            yield case.problem("axis-across", message, case.joint(joint), help, key=True)
        else:
            without.append(joint)
    if without:
        names = first_of([f'"{joint.name}"' for joint in without], SHOWN)
        what = f"joint {names} has" if len(without) == 1 else f"joints {names} have"
        message = f"{what} no axis: it is x of the frame of the child, [1, 0, 0]"
        yield case.problem("axis-missing", message, case.joint(without[0]), key=True)


def lies_across(case: Case, joint: Joint) -> bool:
    """Return True if the child of a joint is one disc, shorter than it is wide, across the axis of the joint."""
    link = case.robot.link.get(joint.child)
    shapes = (link.collision or link.visual) if link is not None else ()
    if len(shapes) != 1 or not isinstance(shapes[0].geometry, Cylinder) or not any(joint.axis):
        return False
    disc, rows = shapes[0].geometry, shapes[0].pose.transform().rows
    return disc.length < 2 * disc.radius and abs(dot(unit(joint.axis), (rows[0][2], rows[1][2], rows[2][2]))) < ALONG


# --- keys of MuJoCo that contradict those of the language ---

_POLYNOMIAL = "leave one of them out, or begin the polynomial of mjcf with the other number"


@rule("joint-word", help="Leave one of them out.", topic=SIMULATED)
def contradictions(case: Case) -> Iterator[Diagnostic]:
    """The `mjcf` of a joint or a tendon contradicts its other keys: formats would differ in what they take."""
    for joint in case.robot.joints:
        if not joint.mjcf or joint.is_fixed:
            continue
        path, called = case.joint(joint), f'joint "{joint.name}"'
        for word, mine, theirs, other, help in (*_of_dynamics(joint), *_of_limit(joint)):
            message = f"{called} has {mine} in mjcf, and {theirs} in {'.'.join(other)}"
            related = [("the other one", (*path, *other))]
            yield case.problem("joint-word", message, (*path, "mjcf", word), help, related=related, key=True)
        if joint.type == "continuous" and "range" in joint.mjcf:
            help = "leave it out, or make the joint revolute and write its limit"
            message = f"{called} is continuous, and has a range in mjcf"
            yield case.problem("joint-word", message, (*path, "mjcf", "range"), help, key=True)
    for name, entry in case.section("tendons").items():
        for word in ("stiffness", "damping"):
            values = (entry.get("mjcf") or {}).get(word)
            if word in entry and values and not _same(values[0], entry[word]):
                message = f'tendon "{name}" has a {word} of {number(values[0])} in mjcf, and {number(entry[word])}'
                path = ("tendons", name, "mjcf", word)
                yield case.problem("joint-word", f"{message} in {word}", path, _POLYNOMIAL, key=True)


def _of_dynamics(joint: Joint) -> Iterator[tuple[str, str, str, tuple[str, str], str]]:
    """Yield contradictions about damping and spring: the key, both values, the other path, and the way out."""
    dynamics, drive = joint.dynamics or Dynamics(), joint.actuator.damping if joint.actuator else 0.0
    pair = _numbers(joint, "springdamper")
    for word, value in (("stiffness", dynamics.stiffness), ("damping", joint.braking)):
        other = ("actuator" if word == "damping" and drive else "dynamics", word)
        theirs, mine = number(drive if other[0] == "actuator" else value), _numbers(joint, word)
        if value and mine and not _same(mine[0], value):
            yield word, f"a {word} of {number(mine[0])}", theirs, other, _POLYNOMIAL
        if value and pair and min(pair) > 0:
            help = f"leave one of them out: MuJoCo makes another {word} of springdamper"
            yield "springdamper", "a springdamper", f"a {word} of {theirs}", other, help


def _of_limit(joint: Joint) -> Iterator[tuple[str, str, str, tuple[str, str], str]]:
    limit = joint.limit
    if not joint.moves or limit is None:
        return
    ends, force = _numbers(joint, "range"), _numbers(joint, "actuatorfrcrange")
    known = (limit.lower, limit.upper) if joint.type != "continuous" else ()
    for mine, theirs, key in zip(ends, known, ("lower", "upper"), strict=False):
        if theirs is not None and not _same(mine, theirs):
            text = f"a range of {number(ends[0])} to {number(ends[1])}"
            yield "range", text, number(theirs), ("limit", key), "leave it out, and correct the limit"
            break
    if force and limit.effort is not None and not _same(max(map(abs, force)), limit.effort):
        text = f"a force of {number(force[0])} to {number(force[1])}"
        help = "leave it out, or write the larger of its ends as the effort"
        yield "actuatorfrcrange", text, number(limit.effort), ("limit", "effort"), help


def _numbers(joint: Joint, word: str) -> tuple[float, ...]:
    value = joint.mjcf.get(word)
    return tuple(map(float, value)) if isinstance(value, tuple) else ()


def _same(value: float, other: float) -> bool:
    return math.isclose(value, other, rel_tol=ROUNDING, abs_tol=ROUNDING**2)
