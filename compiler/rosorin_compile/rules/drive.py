"""The drive: its wheels turn, lie as wheels do, stand where their names say, and say how large they are."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from typing import NamedTuple

from rosorin_compile.model import Cylinder, Joint, Vector
from rosorin_compile.model.drive import DIFFERENTIAL, MECANUM, OMNI, STEERED, TRICYCLE, Drive
from rosorin_compile.model.geometry import norm
from rosorin_compile.rules.case import Case, number
from rosorin_compile.rules.containment import holds
from rosorin_compile.rules.mimic import circles
from rosorin_compile.rules.signs import lies_across
from rosorin_compile.rules.tf_tree import is_tree
from rosorin_compile.source.diagnostics import WARNING, Diagnostic
from rosorin_compile.source.rule_registry import JOINTS, rule
from rosorin_compile.source.tree import Path, exists

LYING = math.cos(math.radians(30))  # an axis this near to its direction is meant to be that
RADIUS_APART = 0.05  # of a radius that is given: more is another number, such as the diameter
UNEVEN = 0.001  # m
LEAST = 1e-4  # m between wheels that are to be apart
_TURNING = ("revolute", "continuous")


def _place(drive: Drive, role: str, index: int) -> Path:
    """Return the path of a joint of the drive: a role is one name, or a list of names."""
    single = drive.kind == MECANUM or (drive.kind == TRICYCLE and role == "steering")
    return ("drive", drive.kind, role) if single else ("drive", drive.kind, role, index)


class _Named(NamedTuple):
    """A joint that the drive names: its role, and where it does."""

    role: str
    joint: Joint
    path: Path


def _named(case: Case, drive: Drive) -> list[_Named]:
    return [
        _Named(role, case.robot.joint[name], _place(drive, role, index))
        for role, names in drive.joints.items()
        for index, name in enumerate(names)
        if name in case.robot.joint
    ]


@rule(
    "drive-joint",
    "A joint of the drive does not turn, follows another one or is named twice. A "
    "warning where a wheel has limits: it cannot roll on.",
    "Name the joint of a wheel: continuous, moved by itself.",
    JOINTS,
)
def joints(case: Case) -> Iterator[Diagnostic]:
    """Joints of the drive that cannot be what they are named."""
    drive = case.robot.drive
    if drive is None:
        return
    seen: dict[str, Path] = {}
    for role, joint, path in _named(case, drive):
        what = "the steering" if role == "steering" else "a wheel"
        related = [case.related("the joint", case.joint(joint), key=True)]
        if joint.name in seen:
            message = f'joint "{joint.name}" is named twice in the drive'
            first = [case.related("named first here", seen[joint.name])]
            yield case.problem("drive-joint", message, path, "name each joint once", related=first)
        elif joint.type not in _TURNING:
            message = f'joint "{joint.name}" is {joint.type}: {what} turns'
            yield case.problem("drive-joint", message, path, "name a joint that turns", related=related)
        elif joint.mimic is not None:
            message = f'joint "{joint.name}" follows "{joint.mimic.joint}": {what} of a drive is moved by itself'
            yield case.problem("drive-joint", message, path, "name a joint that has no mimic", related=related)
        elif role != "steering" and joint.type == "revolute":
            message = f'joint "{joint.name}" is revolute and has limits: a wheel rolls on'
            help = "type: continuous"
            yield case.problem("drive-joint", message, path, help, related=related, severity=WARNING)
        seen.setdefault(joint.name, path)


def _is_sound(case: Case, drive: Drive) -> bool:
    """Say whether the joints of a drive are there and turn, on a tree with one root, so that places are known."""
    named = [name for names in drive.joints.values() for name in names]
    robot = case.robot
    return (
        is_tree(case)
        and not any(circles(case))
        and all(joint.mimic is None or joint.mimic.joint in robot.joint for joint in robot.joints)
        and (not drive.frame or drive.frame in robot.link)
        and all(name in robot.joint for name in named)
        and all(robot.joint[name].type in _TURNING and norm(robot.joint[name].axis) > 0 for name in named)
        and len(set(named)) == len(named)
    )


@rule(
    "drive-axis",
    "The axis of a wheel is not level across the way, or that of a steering joint not upright, seen from the base "
    "frame (x forward, y left, z up). A warning where a wheel turns forward for a base that goes backward.",
    "Correct the axis, the pose of the joint, or `frame`.",
    JOINTS,
)
def axes(case: Case) -> Iterator[Diagnostic]:
    """Axes of wheels that do not lie, and of steering that does not stand."""
    drive = case.robot.drive
    if drive is None or not _is_sound(case, drive):
        return
    from rosorin_compile.model.drive import axis_in_base

    base = drive.frame or case.robot.root
    for role, joint, path in _named(case, drive):
        axis = axis_in_base(case.robot, drive, joint.name)
        said = f'the axis of joint "{joint.name}" is {_direction(axis)} in "{base}" at zero'
        related = [case.related("the axis", case.joint(joint, "axis"))]
        if role == "steering":
            if abs(axis[2]) < LYING:
                message = f"{said}: what steers a wheel turns about z"
                yield case.problem("drive-axis", message, path, "correct the axis, or the pose", related=related)
        elif math.hypot(axis[0], axis[1]) < LYING:
            help = "correct the axis, or the pose of the joint"
            yield case.problem("drive-axis", f"{said}: the axle of a wheel is level", path, help, related=related)
        elif drive.kind != OMNI and abs(axis[1]) < LYING:
            message = f"{said}: a wheel that goes forward, along x, turns about y"
            help = "correct the axis, or name the frame whose x points forward: frame"
            yield case.problem("drive-axis", message, path, help, related=related)
        elif drive.kind != OMNI and axis[1] < 0:
            message = f"{said}: it turns backward where the base goes forward; controllers take +y"
            help = "turn the axis round, or accept it: simulate goes by the axis"
            yield case.problem("drive-axis", message, path, help, related=related, severity=WARNING)
        elif exists(case.tree, case.joint(joint, "axis")) and lies_across(case, joint):
            message = f'the axis of joint "{joint.name}" lies across "{joint.child}", the wheel that it turns'
            help = "a cylinder stands along z: give the shape rpy: [90 deg, 0, 0], or correct the axis"
            yield case.problem("axis-across", message, case.joint(joint, "axis"), help, severity=WARNING)


def _direction(axis: Vector) -> str:
    """Return an axis in few digits: +y, or [0.7, 0, 0.7]."""
    for index, letter in enumerate("xyz"):
        if abs(axis[index]) > 1 - 1e-9:
            return f"{'-' if axis[index] < 0 else '+'}{letter}"
    return f"[{', '.join(number(round(c, 3) + 0.0) for c in axis)}]"


@rule(
    "drive-places",
    "Wheels do not stand where their names say, or so that they do not move the base in all the ways that a drive of "
    "their kind has. A warning where they do not stand on one floor.",
    "Correct the names, or the poses of the joints.",
    JOINTS,
)
def places(case: Case) -> Iterator[Diagnostic]:
    """Wheels that stand elsewhere than their names say, or cannot drive."""
    drive = case.robot.drive
    if drive is None or not _is_sound(case, drive):
        return
    from rosorin_compile.model.drive import place_in_base

    at = {name: place_in_base(case.robot, drive, name) for names in drive.joints.values() for name in names}
    found = list(_misplaced(case, drive, at))
    yield from found
    if found:
        return
    if drive.kind in STEERED:
        yield from _axle(case, drive, at)
    elif drive.kind == OMNI and _radii(case, drive) is not None and not _moves(case):
        message = "the wheels of the drive cannot move the base in all directions: along x, along y, and turning"
        yield case.problem("drive-places", message, ("drive", OMNI), "three wheels or more, not all along one line")
    yield from _uneven(case, drive, at)


def _misplaced(case: Case, drive: Drive, at: Mapping[str, Vector]) -> Iterator[Diagnostic]:
    """Yield the wheels that are on the other side of their partners than their names say."""
    pairs = {
        MECANUM: (
            ("front_left", "rear_left", 0, "in front of"),
            ("front_right", "rear_right", 0, "in front of"),
            ("front_left", "front_right", 1, "to the left of"),
            ("rear_left", "rear_right", 1, "to the left of"),
        ),
        DIFFERENTIAL: (("left", "right", 1, "to the left of"),),
    }
    for first, second, along, how in pairs.get(drive.kind, ()):
        for index, one in enumerate(drive.joints[first]):
            other = min(drive.joints[second], key=lambda name: at[one][along] - at[name][along])
            if at[one][along] - at[other][along] >= LEAST:
                continue
            letter, base = "xy"[along], drive.frame or case.robot.root
            numbers = f"{letter} {number(round(at[one][along], 6))} and {number(round(at[other][along], 6))} m"
            message = (
                f'wheel "{one}" is named {first.replace("_", " ")}, but is not {how} "{other}": {numbers} in "{base}"'
            )
            path = _place(drive, first, index)
            related = [case.related("the other one", _place(drive, second, drive.joints[second].index(other)))]
            help = "correct the names, the poses of the joints, or frame: x points forward, y left"
            yield case.problem("drive-places", message, path, help, related=related)
            return


def _axle(case: Case, drive: Drive, at: Mapping[str, Vector]) -> Iterator[Diagnostic]:
    """Yield what is wrong with the axle that is not steered."""
    from rosorin_compile.model.drive import steering_of

    rolling = drive.joints.get("rolling", ())
    fixed = rolling or tuple(name for name in drive.wheels if not steering_of(case.robot, drive, name))
    if not fixed:
        message = "all wheels of the drive are steered: nothing says where the axle is that the base turns about"
        help = "name the joints of the wheels that roll behind: rolling: [...]"
        yield case.problem("drive-places", message, ("drive", drive.kind), help, key=True)
        return
    axle = sum(at[name][0] for name in fixed) / len(fixed)
    for index, name in enumerate(drive.steering):
        if abs(at[name][0] - axle) < LEAST:
            message = f'the steering joint "{name}" is on the axle that it is to steer about: no wheelbase'
            path = _place(drive, "steering", index)
            yield case.problem("drive-places", message, path, "correct the poses of the joints")


def _moves(case: Case) -> bool:
    """Say whether the speeds of the wheels say how the base moves."""
    from rosorin_compile.model.drive import driving_of

    try:
        driving_of(case.robot).velocity({})
    except ValueError:
        return False
    return True


def _uneven(case: Case, drive: Drive, at: Mapping[str, Vector]) -> Iterator[Diagnostic]:
    """Yield a warning about wheels that stand on different heights."""
    radii = _radii(case, drive)
    if radii is None or len(drive.wheels) < 2:
        return
    bottoms = {name: at[name][2] - radii[name] for name in drive.wheels}
    low, high = min(bottoms, key=lambda name: bottoms[name]), max(bottoms, key=lambda name: bottoms[name])
    if bottoms[high] - bottoms[low] > UNEVEN:
        message = (
            f'wheel "{high}" ends {1000 * (bottoms[high] - bottoms[low]):.3g} mm above wheel "{low}": they do not stand'
            " on one floor"
        )
        role, index = next((r, names.index(high)) for r, names in drive.joints.items() if high in names)
        help = "correct the pose of one, or its radius"
        yield case.problem("drive-places", message, _place(drive, role, index), help, severity=WARNING)


def _radii(case: Case, drive: Drive) -> dict[str, float] | None:
    """Return the radii of the wheels (m); None where one is not known."""
    from rosorin_compile.model.drive import rolling_radius

    found = {name: drive.radius or rolling_radius(case.robot, name) for name in drive.wheels}
    known = {name: radius for name, radius in found.items() if radius}
    return known if len(known) == len(found) else None


@rule(
    "drive-radius",
    "The shapes of a wheel do not say its radius, as a mesh or a box does not, or it is not positive. A warning "
    "where `radius` is another one than that of the shapes.",
    "`radius` of the drive, or a cylinder or a sphere in the collision of the wheel.",
    JOINTS,
)
def radii(case: Case) -> Iterator[Diagnostic]:
    """Wheels whose radius nobody says, or two say differently."""
    drive = case.robot.drive
    if drive is None or not _is_sound(case, drive):
        return
    if drive.radius is not None and drive.radius <= 0:
        message = f"the radius of the wheels is {number(drive.radius)} m"
        yield case.problem("drive-radius", message, ("drive", "radius"), "write a positive length")
        return
    from rosorin_compile.model.drive import rolling_radius

    for _, joint, path in _named(case, drive):
        if joint.name not in drive.wheels:
            continue
        shown = rolling_radius(case.robot, joint.name)
        if drive.radius is None and not shown:
            message = f'no round shape of link "{joint.child}" says how large the wheel of joint "{joint.name}" is'
            help = "say it: drive: {radius: 40 mm}; or give the wheel a cylinder to collide with"
            yield case.problem("drive-radius", message, path, help)
            return
        if drive.radius is not None and shown and abs(shown - drive.radius) > RADIUS_APART * drive.radius:
            message = (
                f'the radius is {number(drive.radius)} m, but the wheel of joint "{joint.name}" reaches {shown:.4g} m'
            )
            help = "correct one of the two; a diameter is twice the radius"
            yield case.problem("drive-radius", message, ("drive", "radius"), help, severity=WARNING)
            return


@rule(
    "wheel-in-body",
    "A warning: a wheel of the drive is inside a shape of the body that carries it. Meshes are not examined.",
    "Correct `xyz` of the joint, or a size; a pair that is meant goes under `disabled_contacts`.",
    JOINTS,
    accept="joint",
    imported="always",
)
def wheels_in_body(case: Case) -> Iterator[Diagnostic]:
    """Wheels with both faces inside one shape of the body: they cannot touch the floor beside it."""
    drive, robot = case.robot.drive, case.robot
    if drive is None or not _is_sound(case, drive) or robot.source.status == "imported":
        return
    apart = {frozenset(pair) for pair in robot.disabled_contacts}
    places = robot.poses_in_root({})
    for _, joint, _ in _named(case, drive):
        shapes = robot.link[joint.child].collision if joint.name in drive.wheels else ()
        faces = [
            (shape.pose.transform(), shape.geometry.length / 2)
            for shape in shapes
            if isinstance(shape.geometry, Cylinder)
        ]
        points = [turn.apply((0.0, 0.0, side)) for turn, half in faces for side in (-half, half)]
        bodies = [name for name in (joint.parent, *(n for n, _ in robot.fixed_neighbours(joint.parent))) if points]
        for name in bodies:
            step = places[name].inverse().then(places[joint.child])
            index = next((i for i, shape in enumerate(robot.link[name].collision) if holds(shape, step, points)), None)
            if index is not None and frozenset((name, joint.child)) not in apart:
                path = case.joint(joint)
                place = (*path, "xyz") if exists(case.tree, (*path, "xyz")) else path
                related = [case.related("the shape around it", case.link(name, "collision", index))]
                message = f'wheel "{joint.child}" of the drive is inside a shape of link "{name}"'
                help = "correct xyz or a size; a pair that is meant goes under disabled_contacts"
                yield case.problem(
                    "wheel-in-body", message, place, help, related=related, severity=WARNING, key=place == path
                )
                break
