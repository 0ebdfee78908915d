"""Rules about the drive: joints, axes, positions and radii of its wheels."""

import math
from collections.abc import Iterator

from rosorin_compile.model import Cylinder, Joint
from rosorin_compile.model import drive as model
from rosorin_compile.model.drive import DIFFERENTIAL, MECANUM, OMNI, STEERED, TRICYCLE, Drive
from rosorin_compile.model.geometry import norm
from rosorin_compile.source.diagnostics import WARNING, Diagnostic
from rosorin_compile.source.rule_registry import JOINTS, rule
from rosorin_compile.source.tree import Path, exists

from .case import Case, number
from .joints import lies_across
from .shapes import holds

PARALLEL = math.cos(math.radians(30))  # an axis within 30 degrees of a direction counts as parallel to it
RADIUS_APART = 0.05  # relative to the specified radius: larger deviations are a mistake, such as a diameter
UNEVEN = 0.001  # m: wheels with larger height differences are not on one floor
LEAST = 1e-4  # m: wheels that are closer than this along an axis have the same position on it
# Pairs of roles whose names imply that the first wheel is farther along x (or y) than the second wheel.
_FRONT, _LEFT = (0, "in front of"), (1, "to the left of")
_PAIRS = {DIFFERENTIAL: [("left", "right", *_LEFT)]}
_PAIRS[MECANUM] = [(f"front_{side}", f"rear_{side}", *_FRONT) for side in ("left", "right")]
_PAIRS[MECANUM] += [(f"{end}_left", f"{end}_right", *_LEFT) for end in ("front", "rear")]


def _named(case: Case, drive: Drive | None) -> Iterator[tuple[str, Joint, Path]]:
    for role, names in drive.joints.items() if drive else ():
        kind = drive.kind if drive else ""
        is_single = kind == MECANUM or (kind == TRICYCLE and role == "steering")
        for index, name in enumerate(names):
            if name in case.robot.joint:
                yield role, case.robot.joint[name], ("drive", kind, role) if is_single else ("drive", kind, role, index)


@rule("drive-joint", help="Name the joint of a wheel: a continuous joint without `mimic`.", topic=JOINTS)
def joints(case: Case) -> Iterator[Diagnostic]:
    """A joint in `drive` is named twice, is a mimic joint or does not rotate; a warning if a wheel joint has limits."""
    seen: set[str] = set()
    for role, joint, path in _named(case, case.robot.drive):
        what = help = severity = ""
        if joint.name in seen:
            what, help = 'named twice in "drive"', "name each joint only once"
        elif joint.type not in ("revolute", "continuous"):
            what = f"{joint.type}, so it cannot turn a wheel"
        elif joint.mimic is not None:
            what = f'not driven: it mimics joint "{joint.mimic.joint}"'
        elif role != "steering" and joint.type == "revolute":
            what, severity = "revolute and has limits, but a wheel must turn without limits", WARNING
        if what:
            message, related = f'joint "{joint.name}" is {what}', [("the joint", case.joint(joint))]
            yield case.problem("drive-joint", message, path, help, related=related, severity=severity)
        seen.add(joint.name)


def _sound(case: Case) -> Drive | None:
    drive, robot = case.robot.drive, case.robot
    if drive is None or not (robot.is_tree and robot.mimics_resolve and (drive.frame or robot.root) in robot.link):
        return None
    named = [name for names in drive.joints.values() for name in names]
    joints = [robot.joint[name] for name in {*named} if name in robot.joint]
    is_sound = all(joint.type in ("revolute", "continuous") and norm(joint.axis) > 0 for joint in joints)
    return drive if is_sound and len(joints) == len(named) else None


@rule("drive-axis", help="Correct the axis, the pose of the joint, or `frame` of `drive`.", topic=JOINTS)
def axes(case: Case) -> Iterator[Diagnostic]:
    """The axle of a wheel is not level, or a steering axis is not vertical; a warning if a wheel turns backward."""
    drive = _sound(case)
    for role, joint, path in _named(case, drive):
        x, y, z = axis = model.axis_in_base(case.robot, drive, joint.name) if drive else joint.axis
        rolls, what, severity = role != "steering" and drive is not None and drive.kind != OMNI, "", ""
        if role == "steering":
            what = "a steering joint turns about z" if abs(z) < PARALLEL else ""
        elif math.hypot(x, y) < PARALLEL:
            what = "the axle of a wheel must be horizontal"
        elif rolls and abs(y) < PARALLEL:
            what = "a wheel that rolls forward, along x, turns about y"
        elif rolls and y < 0:
            what, severity = "a positive speed would drive the base backward; controllers expect +y", WARNING
        elif rolls and exists(case.tree, case.joint(joint, "axis")) and lies_across(case, joint):
            message = f'the axis of joint "{joint.name}" is perpendicular to the axle of "{joint.child}", '
            message += "the wheel that the joint turns"
            help = 'the axle of a cylinder is its z axis: add "rpy: [90 deg, 0, 0]" to the shape, or correct the axis'
            yield case.problem("axis-across", message, case.joint(joint, "axis"), help)
        if what:
            direction = f"[{', '.join(number(round(c, 3) + 0.0) for c in axis)}]"
            message = f'the axis of joint "{joint.name}" is {direction} in the frame of the base: {what}'
            related = [("the axis", case.joint(joint, "axis"))]
            yield case.problem("drive-axis", message, path, related=related, severity=severity)


@rule("drive-places", help="Correct the joint names in `drive`, or the poses of the joints.", topic=JOINTS)
def places(case: Case) -> Iterator[Diagnostic]:
    """A wheel is on the wrong side, or the wheels cannot move the base; a warning if they are not on one floor."""
    if (drive := _sound(case)) is None:
        return
    path_of = {joint.name: path for _, joint, path in _named(case, drive)}
    at = {name: model.place_in_base(case.robot, drive, name) for name in path_of}
    for first, second, along, how in _PAIRS.get(drive.kind, ()):
        for wheel in drive.joints[first]:
            other = max(drive.joints[second], key=lambda name: at[name][along])
            if at[wheel][along] - at[other][along] < LEAST:
                message = f'wheel "{wheel}" is listed as {first.replace("_", " ")}, but is not {how} wheel "{other}"'
                related = [("the other wheel", path_of[other])]
                yield case.problem("drive-places", message, path_of[wheel], related=related)
                return
    radii = {name: drive.radius or model.rolling_radius(case.robot, name) for name in drive.wheels}
    fixed = drive.joints.get("rolling") or [n for n in drive.wheels if not model.steering_of(case.robot, drive, n)]
    if drive.kind in STEERED and not fixed:
        message = "all wheels of the drive are steered, but it needs an unsteered wheel"
        help = 'name the joints of the unsteered wheels: "rolling: [...]"'
        yield case.problem("drive-places", message, ("drive", drive.kind), help, key=True)
    elif drive.kind in STEERED:
        axle = sum(at[name][0] for name in fixed) / len(fixed)
        for name in drive.steering:
            if abs(at[name][0] - axle) < LEAST:
                message = f'the steering joint "{name}" is on the axle of the other wheels: the wheelbase is zero'
                yield case.problem("drive-places", message, path_of[name])
    elif drive.kind == OMNI and all(radii.values()):
        try:
            model.drive_kinematics(case.robot).velocity({})
        except ValueError:
            message = "the wheels of the drive cannot move the base along x, move it along y, and turn it"
            yield case.problem("drive-places", message, ("drive", OMNI), "use three wheels in different directions")
    bottoms = sorted((at[name][2] - (radii[name] or 0.0), name) for name in drive.wheels)
    if all(radii.values()) and bottoms and bottoms[-1][0] - bottoms[0][0] > UNEVEN:
        (low, wheel), (high, other) = bottoms[0], bottoms[-1]
        message = f'wheel "{other}" ends {1000 * (high - low):.3g} mm above wheel "{wheel}": one of them is in the air'
        yield case.problem("drive-places", message, path_of[other], severity=WARNING)


@rule("drive-radius", help="Write `radius` in `drive`, or add a collision cylinder to the wheel.", topic=JOINTS)
def radii(case: Case) -> Iterator[Diagnostic]:
    """The radius of a wheel is unknown or not positive; a warning if `radius` differs from the shapes of a wheel."""
    drive = _sound(case)
    radius, place = drive.radius if drive else None, ("drive", "radius")
    if radius is not None and radius <= 0:
        help = 'correct "radius", or remove it to use the collision cylinders of the wheels'
        yield case.problem("drive-radius", f"the wheel radius must be above zero, not {number(radius)} m", place, help)
        return
    for _, joint, path in _named(case, drive):
        shown = model.rolling_radius(case.robot, joint.name) if drive and joint.name in drive.wheels else radius or 1.0
        if radius is None and not shown:
            message = f'the wheel radius of joint "{joint.name}" is unknown: "{joint.child}" has no round shape'
            yield case.problem("drive-radius", message, path)
            return
        if radius is not None and shown and abs(shown - radius) > RADIUS_APART * radius:
            message = f'"radius" is {number(radius)} m, but the wheel of joint "{joint.name}" has {shown:.4g} m'
            help = "correct one of the two (a diameter is twice the radius)"
            yield case.problem("drive-radius", message, place, help, severity=WARNING)
            return


@rule("wheel-in-body", help="Correct `xyz`, or disable the contact.", topic=JOINTS, accept="joint", imported="always")
def wheels_in_body(case: Case) -> Iterator[Diagnostic]:
    """A warning: a wheel of the drive is inside a shape of the body that carries it. Meshes are not checked."""
    drive, robot = _sound(case), case.robot
    if drive is None or robot.source.status == "imported" or not robot.has_poses:
        return
    apart = {frozenset(pair) for pair in robot.disabled_contacts}
    places = robot.poses_in_root({})
    for joint in (robot.joint[name] for name in drive.wheels):
        shapes = [(one.pose.transform(), one.geometry) for one in robot.link[joint.child].collision]
        discs = [(turn, one.length / 2) for turn, one in shapes if isinstance(one, Cylinder)]
        points = [turn.apply((0.0, 0.0, end)) for turn, half in discs for end in (-half, half)]
        bodies = [joint.parent, *(name for name, _ in robot.fixed_neighbours(joint.parent))] if points else []
        for name in bodies:
            step = places[name].inverse().then(places[joint.child])
            steps = [(one.geometry, one.pose.transform().inverse().then(step)) for one in robot.link[name].collision]
            around = [index for index, (geometry, to_shape) in enumerate(steps) if holds(geometry, to_shape, points)]
            if around and frozenset((name, joint.child)) not in apart:
                place = case.value(case.joint(joint), "xyz")
                related = [("the surrounding shape", case.link(name, "collision", around[0]))]
                message = f'wheel "{joint.child}" of the drive is inside a shape of link "{name}"'
                yield case.problem("wheel-in-body", message, place, related=related, key=place[-1] != "xyz")
                break
