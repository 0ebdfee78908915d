"""Check meshes against the masses, inertias and other shapes of their links.

The mass of a link may be that of all links that are fixed to it, so a number is only reported if it fits neither.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

from rosorin_compile.model import Inertial, Link, Mesh, Shape
from rosorin_compile.rules.case import Case
from rosorin_compile.source.diagnostics import NOTE, WARNING, Diagnostic, first_of
from rosorin_compile.source.rule_registry import Heading, Rule

from ..mjcf.bodies import weld_groups
from .overlaps import split_accepted
from .solids import PURPOSES, Meshes, MeshShape, Solid

if TYPE_CHECKING:
    from .solids import Floats

RULES = (
    Rule(
        "mesh-size",
        "A warning: a mesh is hundreds of times longer than the rest of the robot, or shorter than a millimetre: it "
        "was drawn in another unit.",
        "`scale: [0.001, 0.001, 0.001]` makes metres of millimetres.",
        Heading.PHYSICS,
    ),
    Rule(
        "mesh-mass",
        "A warning: the mass of a link is more than its meshes could weigh if they were of osmium, or less than air.",
        "Check the unit of the mass, and the scale of the mesh.",
        Heading.PHYSICS,
    ),
    Rule(
        "mesh-inertia",
        "A warning: the inertia of a link is larger than that of its mass at the far end of its meshes, or less than a "
        "hundredth of what they have with even density.",
        "Compute it again: `inertia: {of: collision}`, or from the CAD program, about the centre of mass and in "
        "kg*m^2.",
        Heading.PHYSICS,
    ),
    Rule(
        "mesh-centre-of-mass",
        "A warning: the centre of mass of a link is outside the box around its shapes.",
        "Check `xyz` of the inertial: it is seen from the frame of the link, in metres.",
        Heading.PHYSICS,
    ),
    Rule(
        "mesh-apart",
        "A warning: the collision shapes of a link are not where its visuals are.",
        "Check the `xyz`, `rpy` and `scale` of both.",
        Heading.PHYSICS,
    ),
    Rule(
        "mesh-not-closed",
        "A note: collision meshes are inside out or have holes, so that they have no volume of their own. Simulators "
        "take their hulls.",
        "Close the holes in the program that made them.",
        Heading.PHYSICS,
    ),
)

LONGEST_PART, SHORTEST_PART = 20.0, 1e-3  # m: no part of a robot is longer, or shorter
TIMES = 200.0  # longer than all else in the robot: millimetres are 1,000 times, and parts are not all of a size
HEAVIEST, LIGHTEST = 25_000.0, 1.0  # kg/m^3: osmium has 22,600, air 1.2
SMALL_INERTIA = 0.01  # of that of the hull with even density
FAR_INERTIA = 1.2  # of that of all mass at the farthest corner
OUTSIDE = 0.1  # of the longest side of the box, beyond which a centre of mass is outside
APART = 0.25  # of the longest side: so far the boxes of what collides and of what is seen may be apart
_SHOWN = 5


def check_meshes(case: Case, shapes: Sequence[MeshShape], meshes: Meshes) -> Iterator[Diagnostic]:
    """Yield a diagnostic for each link or mesh that cannot be right; ``meshes`` are those that could be read."""
    read = [shape for shape in shapes if shape.mesh in meshes]
    wrong_size: dict[Mesh, Diagnostic] = {}
    of_wrong_size: set[str] = set()
    for shape in read:
        found = _size(case, meshes, shape, read)
        if found is not None:
            wrong_size.setdefault(shape.mesh, found)
            of_wrong_size.add(shape.link)
    yield from wrong_size.values()
    groups = weld_groups(case.robot).values()
    for name in dict.fromkeys(shape.link for shape in read if shape.link not in of_wrong_size):
        names = next(group for group in groups if name in group)
        link, fixed = case.robot.link[name], [one for one in case.robot.links if one.name in names]
        if link.inertial is not None and link.inertial.mass > 0:
            volume = _wrong_volume(meshes, link, fixed)
            if volume:
                yield _mass(case, link, link.inertial.mass, volume)
            else:
                yield from _inertia(case, meshes, link, link.inertial, fixed)
        yield from _apart(case, meshes, link)
    yield from _not_closed(case, meshes, [shape for shape in read if shape.purpose == "collision"])


def _size(case: Case, meshes: Meshes, shape: MeshShape, read: Sequence[MeshShape]) -> Diagnostic | None:
    """Return a warning about a mesh whose size does not fit the rest of the robot."""
    ways = [math.dist((0, 0, 0), joint.origin.xyz) for joint in case.robot.joints]
    solids = [solid for link in case.robot.links for one in link.collision for solid in one.solids()]
    sides = [_box_of([solid], meshes) for solid in solids if not isinstance(solid.geometry, Mesh)]
    others = sorted(meshes[other.mesh].longest for other in read if other.mesh.file != shape.mesh.file)
    median = others[len(others) // 2 : len(others) // 2 + 1]
    rest = max([*ways, *(float((box[1] - box[0]).max()) for box in sides if box), *median], default=0.0)
    longest = meshes[shape.mesh].longest
    message = f'the mesh {_file(shape)} of link "{shape.link}" is {float(f"{longest:.3g}"):.6g} m long'
    if longest > LONGEST_PART or (rest > SHORTEST_PART and longest > TIMES * rest):
        than = f", {longest / rest:,.4g} times as long as all else in the robot" if longest > TIMES * rest > 0 else ""
        message, help = f"{message}{than}: that looks like millimetres", "scale: [0.001, 0.001, 0.001]"
    elif longest < SHORTEST_PART:
        message += ": that looks shrunk by 1,000"
        help = "check the scale, and the unit that it was exported in"
    else:
        return None
    key = "scale" if shape.mesh.scale != (1, 1, 1) else "file"
    path = case.link(shape.link, shape.purpose, shape.number, "mesh", key)
    return case.problem("mesh-size", message, path, help, severity=WARNING)


def _file(shape: MeshShape) -> str:
    return shape.mesh.file.rpartition("/")[2]


def _corners(solid: Shape, meshes: Meshes) -> Floats | None:
    """Return corners (n, 3) around a shape in the frame of its link, or None for a mesh that was not read."""
    mesh = meshes.get(solid.geometry) if isinstance(solid.geometry, Mesh) else None
    if mesh is None and isinstance(solid.geometry, Mesh):
        return None
    return Solid("", 0, solid, solid.origin().transform(), mesh).corners()


def _box_of(solids: Sequence[Shape], meshes: Meshes) -> tuple[Floats, Floats] | None:
    """Return the lower and upper corner around shapes, or None without any or with a mesh that was not read."""
    import numpy as np

    corners = [found for found in (_corners(solid, meshes) for solid in solids) if found is not None]
    if not corners or len(corners) < len(solids):
        return None
    every = np.concatenate(corners)
    return every.min(axis=0), every.max(axis=0)


def _wrong_volume(meshes: Meshes, link: Link, fixed: Sequence[Link]) -> float:
    """Return the volume (m^3) that fits the mass neither of a link nor of all that is fixed to it, or 0.

    A mass is too large if it is so for the collision and for the visual shapes: a few spheres can stand for a foot.
    """
    groups = ([link], fixed)
    masses = [sum(one.inertial.mass for one in group if one.inertial) for group in groups]
    by_purpose = [[_volume(meshes, group, purpose) for group in groups] for purpose in PURPOSES]
    known = [volumes for volumes in by_purpose if volumes[0] > 0]
    pairs = [pair for volumes in known for pair in zip(masses, volumes, strict=True)]
    if pairs and all(mass > HEAVIEST * volume for mass, volume in pairs):
        return max(volumes[0] for volumes in known)
    if pairs and all(mass < LIGHTEST * volume for mass, volume in pairs):
        return min(volumes[0] for volumes in known)
    return 0.0


def _volume(meshes: Meshes, links: Sequence[Link], purpose: str) -> float:
    """Return the volume (m^3) of the shapes of links, of meshes that of their hulls."""
    total = 0.0
    for shape in (shape for link in links for shape in getattr(link, purpose)):
        if isinstance(shape.geometry, Mesh):
            mesh = meshes.get(shape.geometry)
            total += mesh.hull.volume if mesh and mesh.hull else 0.0
        else:
            total += shape.volume
    return total


def _mass(case: Case, link: Link, mass: float, volume: float) -> Diagnostic:
    density = mass / volume
    than = "no material is as heavy" if density > HEAVIEST else "less than air"
    message = (
        f'link "{link.name}" weighs {mass:.6g} kg, and the hull of its shapes has'
        f" {float(f'{1000 * volume:.3g}'):.6g} litres: that is {density:,.3g} kg/m^3, {than}"
    )
    help = "check the unit of the mass (grams?) and the scale of the mesh (millimetres?)"
    return case.problem("mesh-mass", message, case.link(link.name, "inertial", "mass"), help, severity=WARNING)


def _inertia(case: Case, meshes: Meshes, link: Link, inertial: Inertial, fixed: Sequence[Link]) -> Iterator[Diagnostic]:
    """Yield a warning if the centre of mass or the moments do not fit the shapes of all that is fixed to a link."""
    import numpy as np

    poses = case.robot.poses_in_root({})
    back, placed = poses[link.name].inverse(), []
    for one in fixed:
        way = back.then(poses[one.name])
        for solid in (solid for shape in (*one.collision, *one.visual) for solid in shape.solids()):
            corners = _corners(solid, meshes)
            if corners is not None:
                placed.append(corners @ np.array(way.rows).T + np.array(way.xyz))
    points, centre = np.concatenate(placed), np.array(inertial.pose.xyz)
    lower, upper = points.min(axis=0), points.max(axis=0)
    beyond = float(np.maximum(lower - centre, centre - upper).max())
    if beyond > OUTSIDE * float((upper - lower).max()):
        message = (
            f'the centre of mass of link "{link.name}" is {1000 * beyond:.1f} mm outside the box around its shapes'
        )
        help = "xyz of the inertial is seen from the frame of the link, in metres"
        path = case.link(link.name, "inertial", "xyz")
        yield case.problem("mesh-centre-of-mass", message, path, help, severity=WARNING)
    largest = inertial.principal_moments[2]
    if largest <= 0:
        return
    reach = float(np.linalg.norm(points - centre, axis=1).max())
    gyration = math.sqrt(largest / inertial.mass)
    own = [meshes.get(shape.geometry) for shape in (*link.collision, *link.visual) if isinstance(shape.geometry, Mesh)]
    even = max((_even_moment(mesh.hull.corners) for mesh in own if mesh and mesh.hull), default=0.0) * inertial.mass
    if gyration > FAR_INERTIA * reach:
        message = (
            f'the inertia of link "{link.name}" is too large: {inertial.mass:.6g} kg would be'
            f" {float(f'{gyration:.3g}'):.6g} m away from the centre of mass, and its shapes reach"
            f" {float(f'{reach:.3g}'):.6g} m"
        )
    elif largest < SMALL_INERTIA * even:
        message = (
            f'the inertia of link "{link.name}" is too small: its largest moment is {largest:.6g} kg*m^2, and'
            f" {inertial.mass:.6g} kg in the hull of its mesh have {float(f'{even:.3g}'):.6g} kg*m^2"
        )
    else:
        return
    help = "inertia is about the centre of mass, in kg*m^2; inertia: {of: collision} computes it for primitives"
    path = case.link(link.name, "inertial", "inertia")
    yield case.problem("mesh-inertia", message, path, help, severity=WARNING, within=True)


def _even_moment(corners: Floats) -> float:
    """Return the largest moment of a convex body of even density and mass 1 about its middle (m^2)."""
    import trimesh

    hull = trimesh.convex.convex_hull(corners)
    return float(max(hull.principal_inertia_components)) / float(hull.volume)


def _apart(case: Case, meshes: Meshes, link: Link) -> Iterator[Diagnostic]:
    """Yield a warning if the collision shapes of a link are not where its visuals are."""
    import numpy as np

    pieces = ([piece for shape in shapes for piece in shape.solids()] for shapes in (link.collision, link.visual))
    solid, seen = (_box_of(several, meshes) for several in pieces)
    if solid is None or seen is None:
        return
    (low, high), (lower, upper) = solid, seen
    longest = float(max((upper - lower).max(), (high - low).max()))
    if float(np.maximum(low - upper, lower - high).max()) <= APART * longest:
        return
    between = float(np.linalg.norm((low + high) / 2 - (lower + upper) / 2))
    message = (
        f'the collision shapes of link "{link.name}" have their middle {1000 * between:.1f} mm away from that of its'
        f" visuals, and do not touch them"
    )
    related = [case.related("the visual", case.link(link.name, "visual", 0))]
    help, path = "check xyz, rpy and scale of both", case.link(link.name, "collision", 0)
    yield case.problem("mesh-apart", message, path, help, related=related, severity=WARNING)


def _not_closed(case: Case, meshes: Meshes, shapes: Sequence[MeshShape]) -> Iterator[Diagnostic]:
    """Yield a note about collision meshes with holes, and one about those that are inside out."""
    kinds: dict[str, dict[str, MeshShape]] = {"not closed": {}, "inside out": {}}
    for shape in shapes:
        surface = meshes[shape.mesh].surface
        if not surface.is_watertight:
            kinds["not closed"].setdefault(_file(shape), shape)
        elif surface.volume < 0:
            kinds["inside out"].setdefault(_file(shape), shape)
    for kind, help in (("not closed", "close it in the program that made it"), ("inside out", "turn its faces round")):
        accepted, left = split_accepted(case, "mesh-not-closed", list(kinds[kind].values()), lambda one: (one.link,))
        yield from accepted
        if left:
            names = first_of([_file(shape) for shape in left], _SHOWN)
            verb = "mesh is" if len(left) == 1 else "meshes are"
            message = f"{len(left)} collision {verb} {kind}: {names}; simulators take the hull"
            path = case.link(left[0].link, left[0].purpose, left[0].number, "mesh", "file")
            yield replace(case.problem("mesh-not-closed", message, path, help, severity=NOTE), related=(), of=())
