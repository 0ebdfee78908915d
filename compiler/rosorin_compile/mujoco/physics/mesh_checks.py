"""Check meshes: their size against the rest of the robot, the masses of their links, and holes."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

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
            yield from _density(case, meshes, case.robot.link[name])
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


def _density(case: Case, meshes: Meshes, link: Link) -> Iterator[Diagnostic]:
    """Yield a warning if the mass of a link does not fit its shapes.

    It may be the mass of all links that are fixed to it: it is wrong if it fits neither. It is too large if it is so
    for the collision and for the visual shapes: a few spheres can stand for a foot.
    """
    group = next(group for group in weld_groups(case.robot).values() if link.name in group)
    fixed = [one for one in case.robot.links if one.name in group]

    def volume(links: Sequence[Link], purpose: str) -> float:
        solids = [solid for one in links for solid in solids_of(getattr(one, purpose), one.name, meshes)]
        return float(sum(solid.hull.volume for solid in solids))

    densities = []
    for purpose in ("collision", "visual"):
        for links in ([link], fixed) if volume([link], purpose) > 0 else ():
            mass = sum(one.inertial.mass for one in links if one.inertial)
            densities.append(mass / volume(links, purpose))
    if link.inertial and densities and (min(densities) > HEAVIEST or max(densities) < LIGHTEST):
        than = "no material is as heavy" if min(densities) > HEAVIEST else "less than air"
        weight = f'link "{link.name}" weighs {link.inertial.mass:.6g} kg'
        message = f"{weight}, {densities[0]:,.3g} kg/m^3 in the hull of its shapes: {than}"
        yield case.problem("mesh-mass", message, case.link(link.name, "inertial", "mass"))
