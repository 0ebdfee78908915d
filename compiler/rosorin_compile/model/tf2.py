"""The transform that tf2 computes for two frames: the same operations in the same order.

``lookupTransform`` of tf2 (geometry2, ``tf2/src/buffer_core.cpp``) walks from both frames up to where they meet and
multiplies quaternions on the way, so that even signs and zeros of the result follow from the order of operations. The
formulas are those of Bullet's linear algebra in geometry2 (``tf2/LinearMath/Quaternion.h`` and ``Matrix3x3.h``, equal
in Humble and Jazzy). Quaternions are x, y, z, w.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import NamedTuple

from .geometry import Quaternion, Rows, Transform, Vector, plus, quaternion_of
from .joint import motion
from .kinematics import Graph, Move, Positions, Step, position_of


class Answer(NamedTuple):
    """The pose of ``target`` in ``source``: metres, quaternion x y z w, and the moves from one to the other."""

    source: str
    target: str
    translation: Vector
    quaternion: Quaternion
    way: tuple[Move, ...]

    @property
    def rows(self) -> Rows:
        x, y, z, w = self.quaternion
        s = 2.0 / (x * x + y * y + z * z + w * w)
        xs, ys, zs = x * s, y * s, z * s
        wx, wy, wz = w * xs, w * ys, w * zs
        xx, xy, xz = x * xs, x * ys, x * zs
        yy, yz, zz = y * ys, y * zs, z * zs
        return (
            (1.0 - (yy + zz), xy - wz, xz + wy),
            (xy + wz, 1.0 - (xx + zz), yz - wx),
            (xz - wy, yz + wx, 1.0 - (xx + yy)),
        )

    @property
    def rpy(self) -> Vector:
        return rpy(self.rows)

    @property
    def degrees(self) -> Vector:
        roll, pitch, yaw = (angle * (180.0 / math.pi) for angle in self.rpy)
        return (roll, pitch, yaw)


def lookup(graph: Graph, source: str, target: str, positions: Positions) -> Answer:
    """Return the pose of ``target`` in ``source`` at joint positions (rad or m).

    Raises NoWay, and KeyError for unknown frames.
    """
    way = graph.way(source, target)
    to_top = [move.step for move in way if move.up]
    from_top = [move.step for move in reversed(way) if not move.up]
    below, above = _accumulate(graph, from_top, positions), _accumulate(graph, to_top, positions)
    # tf2 leaves out the frame that it starts from only where it meets it on its way: never at the root of its tree.
    if not way or (not to_top and source in graph.published):
        quaternion, translation = below
    else:
        x, y, z, w = above[0]
        quaternion = (-x, -y, -z, w)
        x, y, z = above[1]
        translation = _rotate(quaternion, (-x, -y, -z))
        if from_top or target not in graph.published:
            translation = plus(_rotate(quaternion, below[1]), translation)
            quaternion = _product(quaternion, below[0])
    return Answer(source, target, translation, quaternion, way)


def _accumulate(graph: Graph, steps: Iterable[Step], positions: Positions) -> tuple[Quaternion, Vector]:
    """Return the lowest frame of steps in the highest, accumulated upwards."""
    quaternion: Quaternion = (0.0, 0.0, 0.0, 1.0)
    vector: Vector = (0.0, 0.0, 0.0)
    for step in steps:
        joint = step.joint
        pose = step.pose if joint is None else joint.origin
        assert pose is not None  # noqa: S101 - the graph leaves out steps without numbers
        # Not pose.transform(): publishers keep the rounding of sines, and the signs of the zeros that follow from it.
        transform = Transform(rows_of_rpy(pose.rpy), pose.xyz)
        if joint is not None and not joint.is_fixed:
            position = position_of(graph.robot, joint, positions)
            transform = transform.then(motion(joint.type, joint.axis, position))
        rotation = quaternion_of(transform.rows)
        vector = plus(_rotate(rotation, vector), transform.xyz)
        quaternion = _product(rotation, quaternion)
    return quaternion, vector


def _product(a: Quaternion, b: Quaternion) -> Quaternion:
    """Return the rotation ``b``, then ``a``."""
    ax, ay, az, aw = a
    bx, by, bz, bw = b
    return (
        aw * bx + ax * bw + ay * bz - az * by,
        aw * by + ay * bw + az * bx - ax * bz,
        aw * bz + az * bw + ax * by - ay * bx,
        aw * bw - ax * bx - ay * by - az * bz,
    )


def _rotate(q: Quaternion, v: Vector) -> Vector:
    x, y, z, w = q
    a, b, c = v
    turned = (w * a + y * c - z * b, w * b + z * a - x * c, w * c + x * b - y * a, -x * a - y * b - z * c)
    return _product(turned, (-x, -y, -z, w))[:3]


def rows_of_rpy(angles: Vector) -> Rows:
    """Return the rotation matrix of fixed-axis roll, pitch, yaw in radians, like tf2's ``Matrix3x3::setRPY``."""
    (si, ci), (sj, cj), (sh, ch) = ((math.sin(angle), math.cos(angle)) for angle in angles)
    cc, cs, sc, ss = ci * ch, ci * sh, si * ch, si * sh
    return (
        (cj * ch, sj * sc - cs, sj * cc + ss),
        (cj * sh, sj * ss + cc, sj * cs - sc),
        (-sj, cj * si, cj * ci),
    )


def rpy(rows: Rows) -> Vector:
    """Return fixed-axis roll, pitch, yaw (radians) like ``getRPY`` of tf2: the solution with a pitch within 90 degrees.

    The pitch is exactly +-90 degrees, and the yaw zero, only where the matrix has 1 or more: within rounding is not
    enough. A pitch of zero is -0.0, since tf2 negates an arc sine.
    """
    down = rows[2][0]
    if abs(down) >= 1:
        return (math.atan2(rows[2][1], rows[2][2]), math.copysign(math.pi / 2, -down), 0.0)
    pitch = -math.asin(down)
    level = math.cos(pitch)
    roll = math.atan2(rows[2][1] / level, rows[2][2] / level)
    return (roll, pitch, math.atan2(rows[1][0] / level, rows[0][0] / level))
