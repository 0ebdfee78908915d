"""What tf2 answers when it is asked for a transform: the same composition, one edge after the other.

``lookupTransform`` of tf2 (geometry2, ``tf2/src/buffer_core.cpp``) walks from both frames up to where they meet, and
multiplies quaternions on the way. So the sign of the quaternion of an answer is that of the product, not a convention.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import NamedTuple

from .. import Robot, Transform, Vector
from ..geometry import plus
from ..motion import motion
from .graph import Graph, Move, Step
from .quaternions import (
    UNIT,
    Positions,
    Quaternion,
    Rows,
    at,
    inverse,
    of_rows,
    product,
    rotate,
    rows_of_rpy,
    rpy,
    to_rows,
)

_Accumulated = tuple[Quaternion, Vector]
_NOTHING: _Accumulated = (UNIT, (0.0, 0.0, 0.0))


class Answer(NamedTuple):
    """Where ``target`` sits in ``source``: metres, quaternion x y z w, and the moves from one to the other."""

    source: str
    target: str
    translation: Vector
    quaternion: Quaternion
    way: tuple[Move, ...]

    @property
    def rows(self) -> Rows:
        """The rotation as a matrix, computed from the quaternion as tf2_echo does."""
        return to_rows(self.quaternion)

    @property
    def rpy(self) -> Vector:
        """Fixed-axis roll, pitch, yaw in radians, of the two solutions that of tf2."""
        return rpy(self.rows)

    @property
    def degrees(self) -> Vector:
        """Roll, pitch, yaw in degrees, multiplied as tf2_echo does."""
        roll, pitch, yaw = (angle * (180.0 / math.pi) for angle in self.rpy)
        return (roll, pitch, yaw)


def lookup(graph: Graph, source: str, target: str, positions: Positions) -> Answer:
    """Return where ``target`` sits in ``source`` at joint positions. Raises NoWay, and KeyError for unknown frames."""
    way = graph.way(source, target)
    to_top = [move.step for move in way if move.up]
    from_top = [move.step for move in reversed(way) if not move.up]
    below, above = _up(graph, from_top, positions), _up(graph, to_top, positions)
    # tf2 leaves out the frame that it starts from only where it meets it on its way: never at the root of its tree.
    if not way:
        quaternion, translation = _NOTHING
    elif not to_top and source in graph.parents:
        quaternion, translation = below
    else:
        back = inverse(above[0])
        x, y, z = above[1]
        quaternion, translation = back, rotate(back, (-x, -y, -z))
        if from_top or target not in graph.parents:
            translation = plus(rotate(back, below[1]), translation)
            quaternion = product(back, below[0])
    return Answer(source, target, translation, quaternion, way)


def _up(graph: Graph, steps: Iterable[Step], positions: Positions) -> _Accumulated:
    """Return the lowest frame of steps in the highest, accumulated upwards."""
    quaternion, vector = _NOTHING
    for step in steps:
        transform = _published(step, graph.robot, positions)
        rotation = of_rows(transform.rows)
        vector = plus(rotate(rotation, vector), transform.xyz)
        quaternion = product(rotation, quaternion)
    return quaternion, vector


def _published(step: Step, robot: Robot, positions: Positions) -> Transform:
    """Return a transform as a publisher computes it: half a turn leaves the rounding of its sine in the matrix.

    ``step.transform`` has zero there, and a zero without the sign that the running robot shows.
    """
    pose = step.joint.origin if step.joint is not None else step.pose
    if pose is None:
        raise ValueError(f"the description does not know {step.parent} -> {step.child}")
    mount = Transform(rows_of_rpy(pose.rpy), pose.xyz)
    joint = step.joint
    if joint is None or joint.is_fixed:
        return mount
    return mount.then(motion(joint.type, joint.axis, at(robot, joint, positions)))
