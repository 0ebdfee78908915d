"""Check meshes against the rest of the robot: their size, the masses of their links, and holes."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import Any

from rosorin_compile.model import Link, Mesh
from rosorin_compile.rules.case import Case
from rosorin_compile.source.diagnostics import Diagnostic
from rosorin_compile.source.rule_registry import DECLARED, PHYSICS, Rule

from ..mjcf.bodies import weld_groups
from .overlaps import Member, note
from .solids import Meshes, MeshShape, Solid, solids_of

RULES = (
    Rule(
        "mesh-size",
        "A warning: a mesh is hundreds of times longer than the rest of the robot, or shorter than a millimetre.",
        "Check the unit that it was drawn in; `scale: [0.001, 0.001, 0.001]` makes metres of millimetres.",
        PHYSICS,
    ),
    Rule(
        "mesh-mass",
        "A warning: the mass of a link is more than its shapes could weigh if they were of osmium, or less than air.",
        "Check the unit of the mass, and the scale of the mesh.",
        PHYSICS,
    ),
    Rule(
        "mesh-centre-of-mass",
        "A warning: the centre of mass of a link is outside the box around its shapes.",
        "Check `xyz` of the inertial: it is relative to the frame of the link, in metres.",
        PHYSICS,
    ),
    Rule(
        "mesh-inertia",
        "A warning: the inertia of a link is larger than that of its mass at the far end of its meshes.",
        "Inertia is about the centre of mass, in kg*m^2; `inertia: {of: collision}` computes it for primitives.",
        PHYSICS,
    ),
    Rule(
        "mesh-apart",
        "A warning: the collision shapes of a link are not where its visuals are.",
        "Check the `xyz`, `rpy` and `scale` of both.",
        PHYSICS,
    ),
    Rule(
        "mesh-not-closed",
        "A note: collision meshes are inside out or have holes. Simulators take their hulls.",
        "Close the holes, or turn the faces, in the program that made them.",
        PHYSICS,
    ),
)

DECLARED.update({rule.id: rule for rule in RULES})

LONGEST_PART, SHORTEST_PART = 20.0, 1e-3  # m: no part of a robot is longer, or shorter
TIMES = 200.0  # longer than all else in the robot: millimetres are 1,000 times, and parts are not all of a size
HEAVIEST, LIGHTEST = 25_000.0, 1.0  # kg/m^3: osmium has 22,600, air 1.2
FAR_INERTIA = 1.2  # of that of all mass at the farthest corner
OUTSIDE = 0.1  # of the longest side of the box, beyond which a centre of mass is outside
APART = 0.25  # of the longest side: so far the boxes of what collides and of what is seen may be apart


def check_meshes(case: Case, shapes: Sequence[MeshShape], meshes: Meshes) -> Iterator[Diagnostic]:
    """Yield a diagnostic for each link or mesh that cannot be right; ``meshes`` are those that could be read."""
    read = [shape for shape in shapes if shape.mesh in meshes]
    skipped = {shape.link for shape in shapes if shape.mesh not in meshes}
    wrong_size: dict[Mesh, Diagnostic] = {}
    for shape in read:
        if (found := _size(case, meshes, shape)) is not None:
            wrong_size.setdefault(shape.mesh, found)
            skipped.add(shape.link)
    yield from wrong_size.values()
    for name in dict.fromkeys(shape.link for shape in read):
        if name not in skipped:
            yield from _check_link(case, meshes, case.robot.link[name])
    kinds: dict[str, dict[str, Member]] = {"not closed": {}, "inside out": {}}
    for shape in read:
        surface, file = meshes[shape.mesh], shape.mesh.file.rpartition("/")[2]
        if shape.purpose == "collision" and not (surface.is_watertight and surface.volume >= 0):
            path = case.link(shape.link, shape.purpose, shape.number, "mesh", "file")
            kinds["inside out" if surface.is_watertight else "not closed"][file] = Member((shape.link,), file, path)
    for kind, members in kinds.items():
        message = f"collision meshes that are {kind} ({{count}}): {{names}}; simulators take the hull"
        yield from note(case, "mesh-not-closed", members.values(), message)


def _size(case: Case, meshes: Meshes, shape: MeshShape) -> Diagnostic | None:
    """Return a warning about a mesh whose size does not fit the rest of the robot."""
    sizes = [math.dist((0, 0, 0), joint.origin.xyz) for joint in case.robot.joints]
    primitives = [one for link in case.robot.links for one in link.collision if not isinstance(one.geometry, Mesh)]
    sizes += [
        2 * max(Solid("", 0, piece, piece.origin().transform()).size) for one in primitives for piece in one.solids()
    ]
    others = sorted(surface.extents.max() for mesh, surface in meshes.items() if mesh.file != shape.mesh.file)
    rest = max([*sizes, *others[len(others) // 2 : len(others) // 2 + 1]], default=0.0)
    longest = float(meshes[shape.mesh].extents.max())
    message = f'the mesh {shape.mesh.file.rpartition("/")[2]} of link "{shape.link}" is {longest:.3g} m long'
    if longest > LONGEST_PART or (rest > SHORTEST_PART and longest > TIMES * rest):
        message += ": that looks like millimetres"
    elif longest < SHORTEST_PART:
        message += ": that looks shrunk by 1,000"
    else:
        return None
    key = "scale" if shape.mesh.scale != (1, 1, 1) else "file"
    path = case.link(shape.link, shape.purpose, shape.number, "mesh", key)
    return case.problem("mesh-size", message, path)


def _check_link(case: Case, meshes: Meshes, link: Link) -> Iterator[Diagnostic]:
    """Yield warnings about the mass, the inertia and the places of the shapes of a link.

    The mass of a link may be that of all links that are fixed to it: a number is wrong if it fits neither. A mass is
    too large if it is so for the collision and for the visual shapes: a few spheres can stand for a foot.
    """
    import numpy as np

    group = next(group for group in weld_groups(case.robot).values() if link.name in group)
    fixed = [one for one in case.robot.links if one.name in group]

    poses = case.robot.poses_in_root({})

    def solids(links: Sequence[Link], *purposes: str) -> list[tuple[Link, Solid]]:
        every = ((one, purpose) for one in links for purpose in purposes)
        return [(one, solid) for one, what in every for solid in solids_of(getattr(one, what), one.name, meshes)]

    def corners(links: Sequence[Link], *purposes: str) -> Any:
        points = [np.empty((0, 3))]
        for one, solid in solids(links, *purposes):
            way = poses[link.name].inverse().then(poses[one.name])
            points.append(solid.in_link(solid.hull.vertices) @ np.array(way.rows).T + np.array(way.xyz))
        return np.concatenate(points)

    def problem(rule: str, message: str, *path: str | int, within: bool = False) -> Diagnostic:
        return case.problem(rule, message, case.link(link.name, *path), within=within)

    inertial, points = link.inertial, corners(fixed, "collision", "visual")
    if inertial is not None and inertial.mass > 0 and len(points):
        densities = []
        for purpose in ("collision", "visual"):
            for links in ([link], fixed) if solids([link], purpose) else ():
                mass = sum(one.inertial.mass for one in links if one.inertial)
                densities.append(mass / sum(solid.hull.volume for _, solid in solids(links, purpose)))
        centre, lower, upper = np.array(inertial.pose.xyz), points.min(axis=0), points.max(axis=0)
        beyond = float(np.maximum(lower - centre, centre - upper).max())
        reach = float(np.linalg.norm(points - centre, axis=1).max())
        gyration = math.sqrt(max(0.0, inertial.principal_moments[2]) / inertial.mass)
        if densities and (min(densities) > HEAVIEST or max(densities) < LIGHTEST):
            than = "no material is as heavy" if min(densities) > HEAVIEST else "less than air"
            message = (
                f'link "{link.name}" weighs {inertial.mass:.6g} kg, {densities[0]:,.3g} kg/m^3 in the hull of its'
                f" shapes: {than}"
            )
            yield problem("mesh-mass", message, "inertial", "mass")
        elif beyond > OUTSIDE * float((upper - lower).max()):
            message = f'the centre of mass of link "{link.name}" is {1000 * beyond:.1f} mm outside its shapes'
            yield problem("mesh-centre-of-mass", message, "inertial", "xyz")
        elif gyration > FAR_INERTIA * reach:
            message = (
                f'the inertia of link "{link.name}" is too large: {inertial.mass:.6g} kg would be {gyration:.3g} m away'
                f" from the centre of mass, and its shapes reach {reach:.3g} m"
            )
            yield problem("mesh-inertia", message, "inertial", "inertia", within=True)
    solid, seen = corners([link], "collision"), corners([link], "visual")
    if len(solid) and len(seen):
        gap = np.maximum(solid.min(axis=0) - seen.max(axis=0), seen.min(axis=0) - solid.max(axis=0)).max()
        if gap > APART * max(np.ptp(solid, axis=0).max(), np.ptp(seen, axis=0).max()):
            message = f'the collision shapes of link "{link.name}" are {1000 * gap:.1f} mm away from its visuals'
            yield problem("mesh-apart", message, "collision", 0)
