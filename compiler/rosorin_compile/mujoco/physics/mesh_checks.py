"""Check meshes against the masses, inertias and other shapes of their links.

The mass of a link may be that of all links that are fixed to it, so a number is only reported if it fits neither.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, Any

from rosorin_compile.model import Link, Mesh, Shape
from rosorin_compile.rules.case import Case
from rosorin_compile.source.diagnostics import WARNING, Diagnostic
from rosorin_compile.source.rule_registry import PHYSICS, Rule

from ..mjcf.bodies import weld_groups
from .overlaps import Member, note
from .solids import PURPOSES, Meshes, MeshShape, Solid

if TYPE_CHECKING:
    from .solids import Floats

RULES = (
    Rule(
        "mesh-size",
        "A warning: a mesh is hundreds of times longer than the rest of the robot, or shorter than a millimetre: it "
        "was drawn in another unit.",
        "`scale: [0.001, 0.001, 0.001]` makes metres of millimetres.",
        PHYSICS,
    ),
    Rule(
        "mesh-mass",
        "A warning: the mass of a link is more than its meshes could weigh if they were of osmium, or less than air.",
        "Check the unit of the mass, and the scale of the mesh.",
        PHYSICS,
    ),
    Rule(
        "mesh-inertia",
        "A warning: the inertia of a link is larger than that of its mass at the far end of its meshes.",
        "Compute it again: `inertia: {of: collision}`, or from the CAD program, about the centre of mass and in "
        "kg*m^2.",
        PHYSICS,
    ),
    Rule(
        "mesh-centre-of-mass",
        "A warning: the centre of mass of a link is outside the box around its shapes.",
        "Check `xyz` of the inertial: it is relative to the frame of the link, in metres.",
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
        "A note: collision meshes are inside out or have holes, so that they have no volume of their own. Simulators "
        "take their hulls.",
        "Close the holes in the program that made them.",
        PHYSICS,
    ),
)

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
    lengths = {mesh: _longest(loaded.outline) for mesh, loaded in meshes.items()}
    wrong_size: dict[Mesh, Diagnostic] = {}
    for shape in read:
        if (found := _size(case, meshes, lengths, shape)) is not None:
            wrong_size.setdefault(shape.mesh, found)
            skipped.add(shape.link)
    yield from wrong_size.values()
    for name in dict.fromkeys(shape.link for shape in read):
        if name not in skipped:
            yield from _check_link(case, meshes, case.robot.link[name])
    kinds: dict[str, dict[str, MeshShape]] = {"not closed": {}, "inside out": {}}
    for shape in read:
        surface = meshes[shape.mesh].surface
        if shape.purpose == "collision" and not (surface.is_watertight and surface.volume >= 0):
            kind = "inside out" if surface.is_watertight else "not closed"
            kinds[kind].setdefault(_file(shape), shape)
    for kind, help in (("not closed", "close it in the program that made it"), ("inside out", "turn its faces round")):
        message = f"collision meshes that are {kind} ({{count}}): {{names}}; simulators take the hull"
        members = [Member((one.link,), _file(one), _path(case, one, "file")) for one in kinds[kind].values()]
        yield from note(case, "mesh-not-closed", members, message, help)


def _longest(points: Floats) -> float:
    """Return the longest side (m) of the box around points (n, 3)."""
    return float((points.max(axis=0) - points.min(axis=0)).max())


def _path(case: Case, shape: MeshShape, key: str) -> Any:
    return case.link(shape.link, shape.purpose, shape.number, "mesh", key)


def _file(shape: MeshShape) -> str:
    return shape.mesh.file.rpartition("/")[2]


def _size(case: Case, meshes: Meshes, lengths: dict[Mesh, float], shape: MeshShape) -> Diagnostic | None:
    """Return a warning about a mesh whose size does not fit the rest of the robot."""
    sizes = [math.dist((0, 0, 0), joint.origin.xyz) for joint in case.robot.joints]
    for link in case.robot.links:
        primitives = [one for one in link.collision if not isinstance(one.geometry, Mesh)]
        sizes += [_longest(_corners([one], meshes)) for one in primitives]
    others = sorted(length for mesh, length in lengths.items() if mesh.file != shape.mesh.file)
    rest = max([*sizes, *others[len(others) // 2 : len(others) // 2 + 1]], default=0.0)
    longest = lengths[shape.mesh]
    message = f'the mesh {_file(shape)} of link "{shape.link}" is {float(f"{longest:.3g}"):.6g} m long'
    if longest > LONGEST_PART or (rest > SHORTEST_PART and longest > TIMES * rest):
        than = f", {longest / rest:,.4g} times as long as all else in the robot" if longest > TIMES * rest > 0 else ""
        message, help = f"{message}{than}: that looks like millimetres", "scale: [0.001, 0.001, 0.001]"
    elif longest < SHORTEST_PART:
        message, help = f"{message}: that looks shrunk by 1,000", "check the scale, and the unit of its export"
    else:
        return None
    key = "scale" if shape.mesh.scale != (1, 1, 1) else "file"
    return case.problem("mesh-size", message, _path(case, shape, key), help, severity=WARNING)


def _solids(shapes: Sequence[Shape], meshes: Meshes) -> Iterator[Solid]:
    """Yield the shapes of a link in its frame, without the meshes that were not read."""
    for piece in (piece for shape in shapes for piece in shape.solids()):
        mesh = meshes.get(piece.geometry) if isinstance(piece.geometry, Mesh) else None
        if mesh is not None or not isinstance(piece.geometry, Mesh):
            yield Solid("", 0, piece, piece.origin().transform(), mesh)


def _corners(shapes: Sequence[Shape], meshes: Meshes) -> Floats:
    """Return corners (n, 3) around shapes in the frame of their link."""
    import numpy as np

    return np.concatenate([np.empty((0, 3)), *(solid.corners() for solid in _solids(shapes, meshes))])


def _check_link(case: Case, meshes: Meshes, link: Link) -> Iterator[Diagnostic]:
    import numpy as np

    def problem(rule: str, message: str, *path: str | int, help: str, within: bool = False) -> Diagnostic:
        return case.problem(rule, message, case.link(link.name, *path), help, severity=WARNING, within=within)

    fixed = next(group for group in weld_groups(case.robot).values() if link.name in group)
    links = [one for one in case.robot.links if one.name in fixed]
    inertial = link.inertial
    if inertial is not None and inertial.mass > 0:
        volume = _wrong_volume(meshes, link, links)
        poses = case.robot.poses_in_root({})
        points = np.empty((0, 3))
        for one in links:
            way = poses[link.name].inverse().then(poses[one.name])
            corners = _corners((*one.collision, *one.visual), meshes)
            points = np.concatenate([points, corners @ np.array(way.rows).T + np.array(way.xyz)])
        centre, lower, upper = np.array(inertial.pose.xyz), points.min(axis=0), points.max(axis=0)
        beyond = float(np.maximum(lower - centre, centre - upper).max())
        reach = float(np.linalg.norm(points - centre, axis=1).max())
        gyration = math.sqrt(max(0.0, inertial.principal_moments[2]) / inertial.mass)
        if volume:
            density = inertial.mass / volume
            message = (
                f'link "{link.name}" weighs {inertial.mass:.6g} kg, and the hull of its shapes has {1000 * volume:.3g}'
                f" litres: that is {density:,.3g} kg/m^3, {'too much' if density > 1 else 'less than air'}"
            )
            help = "check the unit of the mass (grams?) and the scale of the mesh (millimetres?)"
            yield problem("mesh-mass", message, "inertial", "mass", help=help)
        elif beyond > OUTSIDE * float((upper - lower).max()):
            message = (
                f'the centre of mass of link "{link.name}" is {1000 * beyond:.1f} mm outside the box around its shapes'
            )
            help = "xyz of the inertial is relative to the frame of the link, in metres"
            yield problem("mesh-centre-of-mass", message, "inertial", "xyz", help=help)
        if not volume and gyration > FAR_INERTIA * reach:
            message = (
                f'the inertia of link "{link.name}" is too large: {inertial.mass:.6g} kg would be {gyration:.3g} m away'
                f" from the centre of mass, and its shapes reach {reach:.3g} m"
            )
            help = "inertia is about the centre of mass, in kg*m^2; inertia: {of: collision} computes it for primitives"
            yield problem("mesh-inertia", message, "inertial", "inertia", help=help, within=True)
    solid, seen = _corners(link.collision, meshes), _corners(link.visual, meshes)
    if len(solid) and len(seen):
        gaps = np.maximum(solid.min(axis=0) - seen.max(axis=0), seen.min(axis=0) - solid.max(axis=0))
        if gaps.max() > APART * max(_longest(solid), _longest(seen)):
            message = f'the collision shapes of link "{link.name}" are {1000 * gaps.max():.1f} mm away from its visuals'
            yield problem("mesh-apart", message, "collision", 0, help="check xyz, rpy and scale of both")


def _wrong_volume(meshes: Meshes, link: Link, fixed: Sequence[Link]) -> float:
    """Return the volume (m^3) that fits the mass neither of a link nor of all that is fixed to it, or 0.

    A mass is too large if it is so for the collision and for the visual shapes: a few spheres can stand for a foot.
    """

    def volume(links: Sequence[Link], purpose: str) -> float:
        solids = [solid for one in links for solid in _solids(getattr(one, purpose), meshes)]
        return sum(solid.volume for solid in solids if solid.hull or not solid.mesh)

    volumes = {purpose: own for purpose in PURPOSES if (own := volume([link], purpose)) > 0}
    densities = []
    for links in ([link], fixed):
        mass = sum(one.inertial.mass for one in links if one.inertial)
        densities += [mass / volume(links, purpose) for purpose in volumes]
    if densities and min(densities) > HEAVIEST:
        return max(volumes.values())
    return min(volumes.values()) if densities and max(densities) < LIGHTEST else 0.0
