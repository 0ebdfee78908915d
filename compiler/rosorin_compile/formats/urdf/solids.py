"""What links of a URDF collide with; rollers that it does not carry leave a cylinder, or the robot would stand low."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence, Set

from rosorin_compile.model import Capsule, Cylinder, Ellipsoid, Mesh, Output, Robot, Shape, Transform, Vector
from rosorin_compile.model.bounds import along
from rosorin_compile.model.cached import of_robot
from rosorin_compile.model.geometry import dot, norm, pose_of
from rosorin_compile.model.joint import plane_axes
from rosorin_compile.model.shape import ROWS, plain

_LAST = ("what the last set of frames leaves out",)
_DIRECTIONS = 360  # around an axle, beside that of the middle of a shape: 40 um are missing at 1 m


def boxes_of(output: Output) -> str:
    """Return the form of the boxes that height maps are in an output."""
    return str(output.options.get("height_maps", ROWS))


def version_of(output: Output) -> str:
    """Return the version of the format that an output asks for; 1.2 is a number in YAML, and a name all the same."""
    return str(output.options.get("version", "1.0"))


def solids(robot: Robot, link: str, output: Output, carried: frozenset[str]) -> list[Shape]:
    """Return the collision shapes that a link has in a URDF that carries these frames."""
    shapes = collisions(robot, link, carried, boxes_of(output))
    unsaid = (Ellipsoid,) if version_of(output) != "1.0" else (Capsule, Ellipsoid)
    return [Shape(plain(s.geometry), s.pose) if isinstance(s.geometry, unsaid) else s for s in shapes]


def collisions(robot: Robot, link: str, carried: Set[str], boxes: str) -> list[Shape]:
    """Return what a link collides with in a URDF that carries these frames; ``boxes`` is the form of height maps.

    A link that turns, and whose parts that turn on it are not carried, is one cylinder around it and them.
    """
    own = robot.shapes_at(link, carried, "collision", boxes)[0]
    joint = robot.joint_to.get(link)
    if joint is None or joint.type != "continuous":  # no wheel: two sets of all frames are not held against each other
        return own
    lost = _lost_of(robot, frozenset(carried)).get(link)
    if not lost:
        return own
    x, y, z = joint.axis
    length = norm((x, y, z))
    axis = (x / length, y / length, z / length)
    bare = [(solid, Transform()) for solid in own if not isinstance(solid.geometry, Mesh)]
    if _radius(lost, axis) <= _radius(bare, axis):
        return own
    return [_around([*bare, *lost], axis), *(solid for solid in own if isinstance(solid.geometry, Mesh))]


def _lost_of(robot: Robot, carried: frozenset[str]) -> Mapping[str, Sequence[tuple[Shape, Transform]]]:
    """Return the same as ``_lost``; two equal sets of frames are held against each other once, not for each wheel."""
    last = robot.worked_out.get(_LAST)
    if last is None or last[0] is not carried:
        last = robot.worked_out[_LAST] = carried, _lost(robot, carried)
    found: Mapping[str, Sequence[tuple[Shape, Transform]]] = last[1]
    return found


@of_robot
def _lost(robot: Robot, carried: frozenset[str]) -> Mapping[str, Sequence[tuple[Shape, Transform]]]:
    """Return the shapes, no meshes, of what is not carried and turns on a wheel that is, by wheel, placed in it."""
    found: dict[str, list[tuple[Shape, Transform]]] = {}
    for name, (carrier, place) in robot.carriers(frozenset(carried)).items():
        solids = robot.link[name].collision if name not in carried else ()
        joint = robot.joint_to.get(carrier)
        if solids and joint is not None and joint.type == "continuous" and robot.moves_between(name, carrier):
            placed = [(solid, place) for solid in solids if not isinstance(solid.geometry, Mesh)]
            found.setdefault(carrier, []).extend(placed)
    return found


def _radius(placed: Sequence[tuple[Shape, Transform]], axis: Vector) -> float:
    """Return how far shapes reach from an axis through the origin (m)."""
    u, v = plane_axes(axis)
    turns = [2 * math.pi * step / _DIRECTIONS for step in range(_DIRECTIONS)]
    farthest = 0.0
    for solid, place in placed:
        middle = place.then(solid.pose.transform()).xyz
        reach = along(solid, place)
        for turn in (math.atan2(dot(middle, v), dot(middle, u)), *turns):
            across, up = math.cos(turn), math.sin(turn)
            x, y, z = (across * one + up * other for one, other in zip(u, v, strict=True))
            farthest = max(farthest, reach((x, y, z)))
    return farthest


def _around(placed: Sequence[tuple[Shape, Transform]], axis: Vector) -> Shape:
    """Return the cylinder around shapes, about an axis through the origin."""
    x, y, z = axis
    reaches = [along(solid, place) for solid, place in placed]
    ends = [max(reach((x, y, z)) for reach in reaches), -max(reach((-x, -y, -z)) for reach in reaches)]
    middle = (ends[0] + ends[1]) / 2
    (a, b, c), (d, e, f) = plane_axes(axis)
    turned = Transform(((a, d, x), (b, e, y), (c, f, z)), (x * middle, y * middle, z * middle))
    return Shape(Cylinder(_radius(placed, axis), ends[0] - ends[1]), pose_of(turned))
