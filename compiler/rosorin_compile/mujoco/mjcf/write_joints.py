"""The joints of an MJCF: the attributes of each, couplings of those that follow another, and the keys of named poses.

A joint of several positions is several joints of MuJoCo on one body, or one that is free or a ball.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

from markupsafe import Markup

from rosorin_compile.formats.templating import attributes
from rosorin_compile.model import Joint, Pose, Robot, Vector
from rosorin_compile.model.geometry import plane_axes, pose_of
from rosorin_compile.model.joint import Dynamics
from rosorin_compile.model.robot import JointPose
from rosorin_compile.model.simulation import Attribute
from rosorin_compile.mujoco.rest_pose import HOME, home_of
from rosorin_compile.source.numbers import NumberFormat, numbers, vector

from .bodies import FLOATING, PLANAR, STIFF, is_free, reference
from .omissions import position_range
from .servos import Drive, controls_of, is_clamped, kept_controls
from .write_elements import ElementPrinter

# The types of joints that one joint of MuJoCo is.
TYPES = {"revolute": "hinge", "continuous": "hinge", "prismatic": "slide"}

_AXES: tuple[Vector, ...] = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))
_AT_ORIGIN = {"planar": (0.0, 0.0, 0.0), "floating": (0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0)}
_AT_ORIGIN |= {"ball": (1.0, 0.0, 0.0, 0.0)}


def stands(joint: Joint) -> Pose:
    """Return where the body of a joint stands in the one above it."""
    ref = reference(joint)
    return pose_of(joint.transform(ref)) if ref else joint.origin


def free_joint(robot: Robot) -> str:
    """Return a name for the joint of a floating base that no other joint has."""
    name = f"{robot.root}_free"
    while name in robot.joint:
        name += "_"
    return name


def several(joint: Joint, printer: ElementPrinter) -> list[Markup]:
    """Return the attributes of the joints that a body has for a planar, floating or ball joint, in their order."""
    if is_free(printer.robot, joint):
        return [attributes(name=joint.name, type="free", **_inner(joint, printer))]
    if joint.type == "ball":
        return [attributes(name=joint.name, type="ball", **_inner(joint, printer))]
    base, number = base_name(joint, printer.robot), printer.number
    if joint.type == "planar":
        axes = (*plane_axes(joint.axis), joint.axis)
        kinds = ("slide", "slide", "hinge")
        parts = zip(PLANAR, kinds, axes, strict=True)
    else:
        parts = zip(FLOATING[:3], ("slide",) * 3, _AXES, strict=True)
    made = [attributes(name=base + end, **_motion(kind, axis, number)) for end, kind, axis in parts]
    return made if joint.type == "planar" else [*made, attributes(name=base + FLOATING[3], type="ball")]


def base_name(joint: Joint, robot: Robot) -> str:
    """Return the name of a joint, with underscores after it where its parts would have the names of others."""
    base = joint.name
    while any(base + end in robot.joint for end in {*PLANAR, *FLOATING}):
        base += "_"
    return base


def single(joint: Joint, printer: ElementPrinter) -> dict[str, str]:
    """Return the attributes of a joint of one position, but its name."""
    values = _motion(TYPES[joint.type], joint.axis, printer.number)
    ends = position_range(joint)
    if ends:
        values["range"] = numbers(ends, printer.number)
    return {**values, **_inner(joint, printer)}


def _motion(kind: str, axis: Vector, number: NumberFormat) -> dict[str, str]:
    """Return the type and the axis of a joint of one position; MuJoCo's own are a hinge and z."""
    values = {} if kind == "hinge" else {"type": kind}
    return values if axis == _AXES[2] else {**values, "axis": vector(axis, number)}


def _inner(joint: Joint, printer: ElementPrinter) -> dict[str, str]:
    """Return the attributes of what holds and moves a joint."""
    number, dynamics = printer.number, joint.dynamics or Dynamics()
    # That of the drive, too: no force limit clamps it, and MJX leaves out the damping of actuators (MuJoCo 3.17).
    words = {"damping": joint.braking, "frictionloss": dynamics.friction, "armature": dynamics.armature}
    words |= {"stiffness": dynamics.stiffness, "springref": dynamics.spring_reference}
    values = {word: number(value) for word, value in words.items() if value}
    effort = joint.limit.known("effort") if joint.limit is not None else None
    if effort and not is_clamped(printer.robot, joint, effort):
        values["actuatorfrcrange"] = numbers([-effort, effort], number)
    if joint.mjcf:
        values |= printer.texts(joint.mjcf)
    return values


def followers(robot: Robot, joints: Sequence[Joint], number: NumberFormat) -> list[Markup]:
    """Return the attributes of the constraints of joints that follow another; of one that never moves: their angle."""
    made = []
    for joint, mimic in ((joint, joint.mimic) for joint in joints if joint.mimic is not None and joint.moves):
        leader = robot.joint[mimic.joint]
        values = {"name": mimic.name or joint.name, "joint1": joint.name}
        values |= {"joint2": leader.name} if leader.moves else {}
        factor = mimic.multiplier if leader.moves else 0.0
        # MuJoCo counts both from their references.
        offset = mimic.offset + factor * reference(leader) - reference(joint)
        tuned = {"solref": mimic.solref or STIFF["solref"], "solimp": mimic.solimp or STIFF["solimp"]}
        words = {word: numbers(values, number) for word, values in tuned.items()}
        made.append(attributes(**values, polycoef=numbers([offset, factor, 0.0, 0.0, 0.0], number), **words))
    return made


Key = tuple[str, list[float], list[float], dict[str, Attribute]]


def keys(
    robot: Robot, joints: Sequence[Joint], drives: Sequence[Drive], stands: Callable[[JointPose], Pose] | None
) -> list[Key]:
    """Return name, qpos, ctrl and the rest of each pose: where the base ``stands`` if it is free, then the joints.

    The first key is home. A robot without that pose has it all the same, if anything of it can move. One that was
    imported has its poses in the order of its source, and what is made up behind them: simulators begin at the first.
    """
    made: list[Key] = []
    home, others = home_of(robot), [pose for pose in robot.poses if pose.name != HOME]
    poses = (home, *others)
    if robot.source.status == "imported":
        poses = robot.poses if len(others) < len(robot.poses) else (*others, home)
    for pose in poses:
        at: dict[str, Sequence[float]] = {}
        for joint in joints:
            at[joint.name] = _AT_ORIGIN.get(joint.type) or (robot.position(joint, pose.positions),)
            if is_free(robot, joint):
                at[joint.name] = (*joint.origin.xyz, *joint.origin.transform().quaternion())
        ctrl: list[float] = []
        for drive in drives:
            control, moved, gear = 0.0, drive.joint, drive.actuator.gear
            if drive.actuator.holds_position and moved is not None and moved.moves:  # it is to hold the pose
                control = at[moved.name][0] * (gear[0] if gear else 1.0)
            ctrl += controls_of(drive, pose.controls.get(drive.name, control))
        place = stands(pose) if stands else None
        qpos = [*place.xyz, *place.transform().quaternion()] if place else []
        qpos += [number for joint in joints for number in at[joint.name]]
        if qpos or ctrl or pose in robot.poses:
            whole = pose.mjcf.get("qpos")
            where = list(map(float, whole)) if isinstance(whole, tuple) else qpos
            more = {word: value for word, value in pose.mjcf.items() if word != "qpos"}
            made.append((pose.name, where, ctrl + [0.0] * kept_controls(robot), more))
    return made
