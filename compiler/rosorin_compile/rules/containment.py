"""Containment: links that are entirely inside another link."""

from __future__ import annotations

import math
from bisect import bisect_left, bisect_right
from collections.abc import Iterator, Sequence
from itertools import product

from rosorin_compile.model import Box, Capsule, Cylinder, Link, Robot, Shape, Sphere, Transform, Vector
from rosorin_compile.source.diagnostics import WARNING, Diagnostic
from rosorin_compile.source.rule_registry import JOINTS, rule
from rosorin_compile.source.tree import exists

from .case import Case

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
    group = _groups(robot)
    near = {frozenset((group[joint.parent], group[joint.child])) for joint in robot.joints}
    apart = {frozenset(pair) for pair in robot.disabled_contacts}
    for outer in robot.links:
        for index, shape in enumerate(_shapes(outer)):
            middle, reach = places[outer.name].then(shape.pose.transform()).xyz[0], _reach(shape)
            first, last = bisect_left(order, (middle - reach, "")), bisect_right(order, (middle + reach, "\uffff"))
            inside = []
            for _, inner in order[first:last]:
                groups = frozenset((group[inner], group[outer.name]))
                if len(groups) < 2 or groups in near or frozenset((inner, outer.name)) in apart:
                    continue
                if holds(shape, places[outer.name].inverse(), ends[inner]):
                    inside.append(inner)
            if len(inside) < ENVELOPE:
                yield from (_contained(case, inner, outer, index) for inner in inside)


def _contained(case: Case, inner: str, outer: Link, index: int) -> Diagnostic:
    path = case.joint(case.robot.joint_to[inner]) if inner in case.robot.joint_to else case.link(inner)
    place = (*path, "xyz") if exists(case.tree, (*path, "xyz")) else path
    kind = "collision" if outer.collision else "visual"
    related = [case.related("the shape around it", case.link(outer.name, kind, index))]
    message = f'link "{inner}" is entirely inside link "{outer.name}"'
    help = "correct xyz or a size; a pair that is meant goes under disabled_contacts"
    return case.problem("link-inside-link", message, place, help, related=related, severity=WARNING, key=place == path)


def _groups(robot: Robot) -> dict[str, str]:
    """Return the top of the links that are fixed to each other, by link."""
    group: dict[str, str] = {}
    for link in robot.walk():
        joint = robot.joint_to.get(link.name)
        group[link.name] = group[joint.parent] if joint is not None and joint.is_fixed else link.name
    return group


def _shapes(link: Link) -> Sequence[Shape]:
    return link.collision or link.visual


def _reach(shape: Shape) -> float:
    geometry = shape.geometry
    if isinstance(geometry, Box):
        return math.hypot(*(max(abs(a), abs(b)) for a, b in zip(geometry.lower, geometry.upper, strict=True)))
    if isinstance(geometry, Sphere):
        return geometry.radius
    return geometry.radius + geometry.length if isinstance(geometry, (Cylinder, Capsule)) else 0.0


def _points(link: Link, place: Transform) -> list[Vector]:
    """Return points of the surface of all shapes of a link, seen from the root; none if one is a mesh."""
    points: list[Vector] = []
    for shape in _shapes(link):
        geometry, to_root = shape.geometry, place.then(shape.pose.transform())
        if isinstance(geometry, Box):
            (a, b, c), (d, e, f) = geometry.lower, geometry.upper
            own: list[Vector] = [(x, y, z) for x in (a, d) for y in (b, e) for z in (c, f)]
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
    for x, y, z in (back.apply(step.apply(point)) for point in points):
        if isinstance(geometry, Box):
            pairs = zip(geometry.lower, (x, y, z), geometry.upper, strict=True)
            inside = all(low + _CLEARANCE < value < high - _CLEARANCE for low, value, high in pairs)
        elif isinstance(geometry, Sphere):
            inside = math.hypot(x, y, z) < geometry.radius - _CLEARANCE
        elif isinstance(geometry, (Cylinder, Capsule)):
            inside = max(math.hypot(x, y) - geometry.radius, abs(z) - geometry.length / 2) < -_CLEARANCE
        else:
            inside = False
        if not inside:
            return False
    return True
