"""Joints in the terms of MuJoCo: what moves a body, and where it stands in a keyframe.

MuJoCo has a free joint at the top of the tree alone. A floating joint is therefore three slides and a ball on one body,
and a planar joint two slides and a hinge, named as MuJoCo's own reader of URDF names them: NAME_TX, NAME_TY, NAME_RZ.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

from markupsafe import Markup

from ...model import Joint, JointPose, Robot, Vector, plane_axes
from ...numbers import NumberFormat, vector
from ..templating import attributes
from .unsaid import position_range

TYPES = {"revolute": "hinge", "continuous": "hinge", "prismatic": "slide"}
PLANAR = ("_TX", "_TY", "_RZ")
FLOATING = ("_TX", "_TY", "_TZ", "_R")

_AXES: tuple[Vector, ...] = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))
_AT_ORIGIN = {"planar": (0.0, 0.0, 0.0), "floating": (0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0)}


def joints_of(joint: Joint, robot: Robot, number: NumberFormat) -> list[Markup]:
    """Return the attributes of the joints that a body has for one joint, in their order."""
    if joint.moves:
        return [_single(joint, number)]
    base = _base_name(joint, robot)
    if joint.type == "planar":
        axes = (*plane_axes(joint.axis), joint.axis)
        kinds = ("slide", "slide", "hinge")
        parts = zip(PLANAR, kinds, axes, strict=True)
    else:
        parts = zip(FLOATING[:3], ("slide",) * 3, _AXES, strict=True)
    made = [attributes(name=base + end, type=kind, axis=vector(axis, number)) for end, kind, axis in parts]
    return made if joint.type == "planar" else [*made, attributes(name=base + FLOATING[3], type="ball")]


def _base_name(joint: Joint, robot: Robot) -> str:
    """Return the name of a joint, with underscores after it where its parts would have the names of others."""
    base = joint.name
    while any(base + end in robot.joint for end in {*PLANAR, *FLOATING}):
        base += "_"
    return base


def _single(joint: Joint, number: NumberFormat) -> Markup:
    values = {"name": joint.name, "type": TYPES[joint.type], "axis": vector(joint.axis, number)}
    ends = position_range(joint)
    if ends:
        values["range"] = vector(ends, number)
    if joint.dynamics is not None:
        said = joint.dynamics
        words = {"damping": said.damping, "frictionloss": said.friction, "armature": said.armature}
        values |= {word: number(value) for word, value in words.items() if value}
    if joint.limit is not None and joint.limit.effort:
        values["actuatorfrcrange"] = vector([-joint.limit.effort, joint.limit.effort], number)
    return attributes(**values)


def followers(robot: Robot, joints: Sequence[Joint], number: NumberFormat) -> list[Markup]:
    """Return the attributes of the constraints of joints that follow another; of one that never moves: their angle."""
    made = []
    for joint in joints:
        if joint.mimic is None or not joint.moves:
            continue
        values = {"name": joint.name, "joint1": joint.name, "joint2": joint.mimic.joint}
        if not robot.joint[joint.mimic.joint].moves:
            del values["joint2"]
        polynomial = [joint.mimic.offset, joint.mimic.multiplier if "joint2" in values else 0.0, 0.0, 0.0, 0.0]
        made.append(attributes(**values, polycoef=vector(polynomial, number)))
    return made


def keys(robot: Robot, joints: Sequence[Joint], free: bool) -> list[tuple[str, list[float], list[float]]]:
    """Return name, qpos and ctrl of each pose: the free base at the origin of the world, then the joints in order."""
    base = [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0] if free else []
    made = []
    for pose in robot.poses:
        at = _positions(robot, joints, pose)
        qpos = [number for joint in joints for number in at(joint)]
        made.append((pose.name, base + qpos, [at(joint)[0] for joint in joints if joint.actuator and joint.moves]))
    return made


def _positions(robot: Robot, joints: Sequence[Joint], pose: JointPose) -> Callable[[Joint], Sequence[float]]:
    found: Mapping[str, Sequence[float]] = {
        joint.name: _AT_ORIGIN.get(joint.type) or (robot.position(joint, pose.positions),) for joint in joints
    }
    return lambda joint: found[joint.name]
