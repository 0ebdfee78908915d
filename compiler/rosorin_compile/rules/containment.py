"""Containment: links that are entirely inside another link."""

from __future__ import annotations

import math
from bisect import bisect_left, bisect_right
from collections.abc import Iterator, Sequence
from itertools import product

from rosorin_compile.model import Box, Capsule, Cylinder, Link, Shape, Sphere, Transform, Vector
from rosorin_compile.model.bounds import ball_of
from rosorin_compile.source.diagnostics import Diagnostic
from rosorin_compile.source.rule_registry import JOINTS, rule

from .case import Case
from .kinematics import pieces

ENVELOPE = 4  # links in one shape: it is a box that keeps things away from a hand
_SIDES = [side for side in product((-1, 0, 1), repeat=3) if any(side)]
_CLEARANCE = 1e-9  # m; equal shapes in one place are not inside each other
_TURNS = [math.pi / 4 * step for step in range(8)]


@rule("link-inside-link", help="Correct `xyz`, or disable the contact.", topic=JOINTS, accept="link", imported="always")
def contained_links(case: Case) -> Iterator[Diagnostic]:
    """A warning: a link is entirely inside one shape of another link, with joints at zero; meshes are not examined."""
    robot = case.robot
    has_axes = all(any(joint.axis) for joint in robot.joints if joint.moves or joint.type == "planar")
    if not (robot.is_tree and robot.mimics_resolve and has_axes):  # else no positions can be computed
        return
    places = robot.poses_in_root({})
    ends = {link.name: points for link in robot.links if (points := _points(link, places[link.name]))}
    order = sorted((points[0][0], name) for name, points in ends.items())
    fixed = [(joint.parent, joint.child) for joint in robot.joints if joint.is_fixed]
    rigid = pieces([*zip(robot.link, robot.link, strict=True), *fixed])
    group = {name: index for index, names in enumerate(rigid) for name in names}
    near = {frozenset((group[joint.parent], group[joint.child])) for joint in robot.joints}
    apart = {frozenset(pair) for pair in robot.disabled_contacts}
    for outer in robot.links:
        for index, shape in enumerate(outer.collision or outer.visual):
            ball = ball_of(shape)
            if ball is None:
                continue
            middle = places[outer.name].apply(ball.middle)[0]
            first = bisect_left(order, (middle - ball.radius, ""))
            inside = [
                name
                for _, name in order[first : bisect_right(order, (middle + ball.radius, "\uffff"))]
                if group[name] != group[outer.name]
                and frozenset((group[name], group[outer.name])) not in near
                and frozenset((name, outer.name)) not in apart
                and holds(shape, places[outer.name].inverse(), ends[name])
            ]
            for name in inside if len(inside) < ENVELOPE else ():
                path = case.joint(robot.joint_to[name]) if name in robot.joint_to else case.link(name)
                place = case.value(path, "xyz")
                kind = "collision" if outer.collision else "visual"
                related = [("the shape around it", case.link(outer.name, kind, index))]
                message = f'link "{name}" is entirely inside link "{outer.name}"'
                help = "correct xyz or a size; a pair that is meant goes under disabled_contacts"
                yield case.problem("link-inside-link", message, place, help, related=related, key=place == path)


def _points(link: Link, place: Transform) -> list[Vector]:
    """Return points of the surface of all shapes of a link, seen from the root; none if one is a mesh."""
    points: list[Vector] = []
    for shape in link.collision or link.visual:
        geometry, to_root = shape.geometry, place.then(shape.pose.transform())
        if isinstance(geometry, Box):
            own: list[Vector] = list(product(*zip(geometry.lower, geometry.upper, strict=True)))
        elif isinstance(geometry, Sphere):
            sizes = [(x, y, z, geometry.radius / math.hypot(x, y, z)) for x, y, z in _SIDES]
            own = [(x * size, y * size, z * size) for x, y, z, size in sizes]
        elif isinstance(geometry, (Cylinder, Capsule)):
            radius, half = geometry.radius, geometry.length / 2
            half += radius if isinstance(geometry, Capsule) else 0.0
            own = [(radius * math.cos(a), radius * math.sin(a), z) for a in _TURNS for z in (-half, half)]
        else:
            return []
        points += map(to_root.apply, own)
    return points


def holds(shape: Shape, step: Transform, points: Sequence[Vector]) -> bool:
    """Return True if points of another frame, at ``step``, are all inside a box, a sphere or a cylinder."""
    geometry, back = shape.geometry, shape.pose.transform().inverse()
    own = [back.apply(step.apply(point)) for point in points]
    if isinstance(geometry, Box):
        sides = list(zip(geometry.lower, geometry.upper, strict=True))
        depths = [min(min(v - low, high - v) for v, (low, high) in zip(one, sides, strict=True)) for one in own]
    elif isinstance(geometry, Sphere):
        depths = [geometry.radius - math.hypot(*point) for point in own]
    elif isinstance(geometry, (Cylinder, Capsule)):
        depths = [min(geometry.radius - math.hypot(x, y), geometry.length / 2 - abs(z)) for x, y, z in own]
    else:
        return False
    return all(depth > _CLEARANCE for depth in depths)
