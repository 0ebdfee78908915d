"""The actuators of a generated MJCF: names, order and control ranges."""

import math
from collections.abc import Iterator, Mapping, Sequence
from typing import NamedTuple

from rosorin_compile.model import Joint, Output, Robot
from rosorin_compile.model.geometry import cross, dot, unit
from rosorin_compile.model.link import together
from rosorin_compile.model.simulation import GENERAL, MOTOR, POSITION, SENSOR_ELEMENT, VELOCITY, Actuator
from rosorin_compile.rules.case import Case
from rosorin_compile.source.diagnostics import NOTE, Diagnostic, Suggestion, count_of, first_of
from rosorin_compile.source.xml.elements import FlatElement, found_in

from .unsupported import along_link_of, position_range

_STIFF = 100.0
_SHOWN = 4  # maximum number of names in a message
# Default ``input`` of the actuator types that can have several controls.
_INPUTS = {"pid": "pos vel", "dcmotor": "voltage"}


class Drive(NamedTuple):
    """An actuator with its joint, if any; ``in_joint`` is true if the description defines it in the joint's entry."""

    name: str
    actuator: Actuator
    joint: Joint | None
    in_joint: bool


def drives(robot: Robot, joints: Sequence[Joint], output: Output | None = None) -> list[Drive]:
    """Return all actuators in MJCF order: first those in the output options, then those of ``joints``, then others."""
    moved = [(joint, joint.actuator) for joint in joints if joint.actuator and joint.moves]
    made = [Drive(own.name or joint.name, own, joint, True) for joint, own in moved]
    made += [Drive(one.name, one, robot.joint.get(one.targets.get("joint", "")), False) for one in robot.actuators]
    made += stand_ins(robot, joints, output)
    rank = {name: place for place, name in enumerate(output.options.get("actuators", ()))} if output else {}
    return sorted(made, key=lambda drive: rank.get(drive.name, len(rank)))


def stand_ins(robot: Robot, joints: Sequence[Joint], output: Output | None) -> list[Drive]:
    """Return the servos that the output option ``drives`` adds for joints without an actuator, except mimic joints.

    Their gain is computed from the mass (kg) or inertia (kg*m^2) that a joint moves, with joints at zero. The natural
    frequency of servo and load is ``_STIFF`` (rad/s). Gravity then deflects a pendulum of 0.3 m by
    9.81 / (0.3 * _STIFF^2) = 3 mrad, and the simulation is stable with steps of 2 ms.
    """
    kind = output.options.get("drives", "none") if output else "none"
    if kind == "none":
        return []
    driven = {name for one in robot.actuators for name in one.targets.values()}
    driven |= {found.attributes.get("joint", "") for found in _kept(robot)}
    places, made = robot.poses_in_root({}), list[Drive]()
    for joint in joints:
        if not joint.moves or joint.mimic or joint.actuator or joint.name in driven:
            continue
        back, felt = places[joint.child].inverse(), 1e-6
        links = [robot.link[name] for name in robot.subtree(joint.child)]
        parts = [(one.inertial, back.then(places[one.name])) for one in links if one.inertial and one.inertial.mass > 0]
        if parts:
            body, (x, y, z) = together(parts), unit(joint.axis)
            xx, yy, zz, xy, xz, yz = along_link_of(body)
            about = xx * x * x + yy * y * y + zz * z * z + 2 * (xy * x * y + xz * x * z + yz * y * z)
            arm = cross((x, y, z), body.pose.xyz)
            felt = max(felt, body.mass if joint.type == "prismatic" else about + body.mass * dot(arm, arm))
        # With this gain, joint damping reduces the speed by at most 2 %.
        servo = Actuator(VELOCITY, kv=float(f"{max(felt * _STIFF, 50 * joint.total_damping):.2g}"))
        if kind == POSITION and position_range(joint) is not None:
            servo = Actuator(POSITION, kp=float(f"{felt * _STIFF**2:.2g}"), damping_ratio=1.0)
        made.append(Drive(joint.name, servo, joint, True))
    return made


def aims(drive: Drive) -> tuple[float, float] | None:
    """Return the control range of an actuator (for servos in rad, m, rad/s or m/s), or None if it is unlimited."""
    actuator, joint = drive.actuator, drive.joint
    if actuator.unlimited or "inheritrange" in actuator.mjcf:
        return None
    if actuator.range is not None or joint is None:
        return actuator.range
    ends = position_range(joint) if actuator.type == POSITION else None
    speed = joint.limit.known_value("velocity") if actuator.type == VELOCITY and joint.limit else None
    low, high = (-speed, speed) if speed else ends or (0.0, 0.0)
    low, high = sorted((actuator.gear[0] if actuator.gear else 1.0) * end for end in (low, high))
    return (low, high) if speed or ends else None


def is_clamped(robot: Robot, joint: Joint, effort: float) -> bool:
    """Return True if the actuators of a joint already limit its force to ``effort`` (N*m or N)."""
    own = [joint.actuator] if joint.actuator else []
    others, total = robot.actuators if own and own[0].targets == {} else (), 0.0
    for actuator in (*own, *(one for one in others if one.targets.get("joint") == joint.name)):
        gear, mjcf = abs(actuator.gear[0]) if actuator.gear else 1.0, actuator.mjcf
        gain = mjcf.get("gainprm", 1.0) if actuator.type == GENERAL else 1.0
        gain = gain[0] if isinstance(gain, tuple) else gain
        usual = {"gaintype": "fixed", "biastype": "none"} if actuator.type == GENERAL else {}
        is_plain = actuator.type in (MOTOR, GENERAL) and all(mjcf.get(key, text) == text for key, text in usual.items())
        is_limited = actuator.range is not None and not actuator.unlimited and mjcf.get("ctrllimited") is not False
        if actuator.force is not None and mjcf.get("forcelimited") is not False:
            total += gear * max(map(abs, actuator.force))
        elif is_plain and is_limited and isinstance(gain, (int, float)):
            total += gear * abs(float(gain)) * max(map(abs, actuator.range or ()))
        else:  # the largest force of other actuators is unknown
            return False
    return bool(own) and math.isclose(total, effort, rel_tol=1e-12)


def _kept(robot: Robot) -> list[FlatElement]:
    elements = [found for text in robot.mjcf if "<actuator" in text for found in found_in(text)]
    return [found for found in elements if found.tags[:-1] == ("actuator",)]


def kept_controls(robot: Robot) -> int:
    """Return the number of controls of actuators in raw MJCF."""
    return sum(control_count(found.tags[-1], found.attributes) for found in _kept(robot))


def control_count(tag: str, attributes: Mapping[str, object]) -> int:
    """Return the number of controls of an actuator, which is more than one for some types."""
    kind = tag if tag in _INPUTS else str(attributes.get("gaintype", ""))
    words = str(attributes.get("input") or _INPUTS.get(kind, ""))
    if "so3" in kind or tag == "orientation":
        return 4 if words == "quat" else 3
    return (0 if words == "none" else len(words.split())) if kind in _INPUTS else 1


def check(case: Case, output: Output) -> Iterator[Diagnostic]:
    """Report duplicate actuator names, unknown names in the output options, and servos with an assumed strength."""
    robot, names = case.robot, dict[str, Drive]()

    def place_of(drive: Drive) -> tuple[str | int, ...]:
        if drive.joint is not None and drive.in_joint:
            return case.joint(drive.joint, "actuator")
        return ("actuators", drive.name)

    if assumed := stand_ins(robot, robot.joints, output):
        count, which = count_of(len(assumed), "joint"), first_of([one.name for one in assumed], _SHOWN)
        message = f"{count} without an actuator: servos of an assumed strength move them in {output.file} ({which})"
        moved = {link for one in assumed if one.joint for link in robot.subtree(one.joint.child)}
        affected = [one.name for one in robot.sensors if any(part.link in moved for part in one.simulated)]
        message += f", which changes what sensors measure in MuJoCo ({first_of(affected, _SHOWN)})" if affected else ""
        if not robot.has_free_base(output) and any(one.joint and one.joint.type == "continuous" for one in assumed):
            message += "; the base is fixed, so wheels turn in the air: base: free lets them drive"
        place = ("outputs", output.name, "drives")
        yield case.problem("drives-assumed", message, place, "describe the real actuators", severity=NOTE)
    for drive in drives(robot, robot.joints, output):
        if names.setdefault(drive.name, drive) is not drive:
            message = f'two actuators have the name "{drive.name}"'
            related = [case.related_place("the other actuator", place_of(names[drive.name]))]
            yield case.problem("mjcf-actuators", message, place_of(drive), "rename one of them", related=related)
    sensors = {part.name for sensor in robot.sensors for part in sensor.simulated if part.kind == SENSOR_ELEMENT}
    raw = (one for text in robot.mjcf for one in found_in(text) if one.tags[0] == "sensor" and len(one.tags) == 2)
    sensors |= {one.attributes["name"] for one in raw if "name" in one.attributes}
    for kind, known in (("actuator", {*names}), ("sensor", sensors)):
        ordered = output.options.get(f"{kind}s", ())
        for index, name in enumerate(ordered):
            path = ("outputs", output.name, f"{kind}s", index)
            if name not in known:
                message = f'there is no {kind} "{name}" in the MJCF'
                yield case.problem("mjcf-actuators", message, path, Suggestion(name, known))
            elif name in ordered[:index]:
                yield case.problem("mjcf-actuators", f'the {kind} "{name}" is listed again', path, "remove one")
